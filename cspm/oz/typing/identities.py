"""Which objects are values: where a class uses its objects for more than their attributes and operations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import GivenType
from cspcheck.cspm.oz.typing import messages
from cspcheck.cspm.oz.typing.scopes import subterms, whole
from cspcheck.cspm.syntax.tree import NameDeclaration

POOL = "%"
"""What the name begins with under which the pool of a class is in scope."""


def identities(tree: s.Class, trees: Mapping[str, s.Class]) -> core.Term | None:
    """The set of the objects of a class, a given set of its name; None for a process, or a class with parameters."""
    seen: set[str] = set()
    waiting = [tree.name]
    while waiting:
        name = waiting.pop()
        if name in seen or name not in trees:
            continue
        seen.add(name)
        if trees[name].interface or trees[name].equations:
            return None
        waiting += [inherit.name for inherit in trees[name].inherits]
    return None if tree.generics else whole(GivenType(tree.name))


def circle(names: Sequence[str], trees: Mapping[str, s.Class]) -> Diagnostic:
    """What is wrong with classes each of which needs the next: they inherit, or have objects of each other."""
    span = trees[names[0]].span
    if all(any(i.name == above for i in trees[name].inherits) for name, above in pairwise(names)):
        return messages.cyclic_inheritance(names, span)
    return messages.objects_need_heap(f"an object of `{names[0]}` within itself", span)


def valued(tree: s.Class, names: frozenset[str]) -> frozenset[str]:
    """The classes among *names* whose objects a class uses as values.

    An attribute ``a : C`` or ``f : X -> C`` alone makes no value of an object, nor do ``a.x``, ``f(i).Op``, and
    ``a != b`` for two attributes.
    """
    attributes: dict[str, str] = {}
    found: set[str] = set()
    if tree.state is not None:
        for declaration in tree.state.primary:
            name = _class_of(declaration.carrier, names)
            if name is None or not declaration.names:
                found |= _mentioned(declaration.carrier, names, {})
            else:
                attributes |= {declared.name: name for declared in declaration.names}
                if isinstance(declaration.carrier, s.Operator):
                    found |= _mentioned(declaration.carrier.operands[0], names, {})
        for declaration in tree.state.secondary:
            found |= _mentioned(declaration.carrier, names, {})
    for term in _terms(tree):
        found |= _mentioned(term, names, attributes)
    for operation in tree.operations:
        deltas = [operation.delta] if isinstance(operation, s.OperationSchema) else list(_deltas(operation.body))
        found |= {attributes[n.name] for delta in deltas for n in delta or () if n.name in attributes}
    return frozenset(found)


def _class_of(carrier: s.Term, names: frozenset[str]) -> str | None:
    """The class of an attribute, or of a family of them."""
    carrier = s.bare(carrier)
    if isinstance(carrier, s.Operator) and carrier.name == "fun":
        range_ = carrier.operands[1]
        return range_.name if isinstance(range_, s.Reference) and range_.name in names else None
    return carrier.name if isinstance(carrier, s.Reference) and carrier.name in names else None


def _terms(tree: s.Class) -> Iterator[s.Term]:
    """All terms of a class but the carriers of its state."""
    if tree.state is not None:
        yield from tree.state.predicates
    if tree.initial is not None:
        yield from tree.initial.predicates
    for paragraph in tree.paragraphs:
        match paragraph:
            case s.Axiom() | s.Schema():
                yield from (declaration.carrier for declaration in paragraph.declarations)
                yield from paragraph.predicates
            case s.Abbreviation():
                yield paragraph.body
            case s.FreeType():
                yield from (branch.argument for branch in paragraph.branches if branch.argument is not None)
    for operation in tree.operations:
        if isinstance(operation, s.OperationSchema):
            yield from (declaration.carrier for declaration in operation.declarations)
            yield from operation.predicates
        else:
            yield operation.body


def _deltas(body: s.Term) -> Iterator[tuple[NameDeclaration, ...] | None]:
    stack = [body]
    while stack:
        term = stack.pop()
        if isinstance(term, s.OperationText):
            yield term.delta
        stack.extend(subterms(term))


def _mentioned(term: s.Term, names: frozenset[str], attributes: Mapping[str, str]) -> set[str]:
    found: set[str] = set()
    stack = [term]
    while stack:
        part = stack.pop()
        match part:
            case s.Reference(name=name) if name in names:
                found.add(name)
            case s.Reference(name=name, decoration="" | "'") if name in attributes:
                found.add(attributes[name])
            case s.Selection(record=record):
                stack += _beneath(record, attributes)
                continue
            case s.Chain(operands=operands) if all(map(_is_equality, part.relations)) and all(
                isinstance(o, s.Reference) and o.name in attributes for o in operands
            ):
                continue
        stack.extend(subterms(part))
    return found


def _is_equality(relation: str) -> bool:
    return relation in ("equal", "not_equal")


def _beneath(record: s.Term, attributes: Mapping[str, str]) -> list[s.Term]:
    """What is mentioned in front of a dot, but for the object itself."""
    record = s.bare(record)
    match record:
        case s.Reference(name=name) if name in attributes:
            return []
        case s.Application(function=s.Reference(name=name), argument=argument) if name in attributes:
            return [argument]
    return [record]


def pool_of(type_: core.Type) -> str | None:
    """The name under which the pool of the objects is in scope whose identities are of a type."""
    return POOL + type_.name if isinstance(type_, GivenType) else None
