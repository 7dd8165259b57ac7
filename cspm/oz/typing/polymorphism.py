r"""Polymorphic objects: ``poly Shape`` and unions of classes, as finite alternatives.

Which class an object of ``poly Shape`` is of never changes, and it is one of those of the script: ``Shape`` and the
classes that inherit from it. So ``poly Shape`` stands for a class of its own, which has a constant kind and an object
of each alternative, and each of whose operations is that of the alternative of its kind::

    class poly_Shape
      state
        kind : poly_Shape_kind          -- is_Shape | is_Square | is_Circle
        as_Shape : Shape; as_Square : Square; as_Circle : Circle
        Delta
        x : nat                         -- what a Shape has
      where
        kind = is_Square => x = as_Square.x
        ...
      op move = ([kind = is_Shape] and as_Shape.move) [] ([kind = is_Square] and as_Square.move) [] ...
    end

A union ``Square union Circle`` is the same with the operations that all of them have.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.reading.operators import NUMBER_SETS
from cspcheck.cspm.oz.typing import messages as messages
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax.tree import Declaration, NameDeclaration, Node

N = TypeVar("N", bound=Node)


def with_alternatives(
    declarations: Sequence[Declaration], report: Callable[[Diagnostic], None]
) -> tuple[list[Declaration], frozenset[str]]:
    """The declarations with classes in place of polymorphic sets of objects, and what these classes are called."""
    classes = {d.name: d for d in declarations if isinstance(d, s.Class)}
    found = _Alternatives(classes, report)
    for declaration in declarations:
        if isinstance(declaration, s.Abbreviation) and not declaration.generics and found.is_class(declaration.body):
            found.called[declaration.name] = declaration.body
    kept = [d for d in declarations if not (isinstance(d, s.Abbreviation) and d.name in found.called)]
    result = [found.rewritten(d) if isinstance(d, s.Paragraph) else d for d in kept]
    return [*found.kinds, *result, *found.made.values()], frozenset(found.made)


class _Alternatives:
    def __init__(self, classes: Mapping[str, s.Class], report: Callable[[Diagnostic], None]) -> None:
        self.classes = classes
        self.report = report
        self.made: dict[str, s.Class] = {}
        self.called: dict[str, s.Term] = {}
        """Abbreviations of sets of objects."""
        self.kinds: list[s.FreeType] = []
        self.everywhere: set[str] = {*NUMBER_SETS, *classes}
        """Names that mean the same in every class."""

    def rewritten(self, node: N) -> N:
        """A tree with the names of classes in place of ``poly C`` and unions of classes."""
        changed: dict[str, Any] = {}
        for field in fields(node):
            if field.name != "span":
                old = getattr(node, field.name)
                new = self._value(old)
                if new is not old:
                    changed[field.name] = new
        return replace(node, **changed) if changed else node

    def _value(self, value: Any) -> Any:
        if isinstance(value, tuple):
            items = tuple([self._value(item) for item in value])
            return items if any(new is not old for new, old in zip(items, value, strict=True)) else value
        if isinstance(value, s.Operator):
            union = self._union(value)
            if union is not None and len(union) > 1:
                return self._reference(value, "_or_".join(union), union, union[0], every=False)
            if value.name == "poly":
                return self._poly(value)
            if value.name == "contained":
                return self._value(value.operands[0])  # it belongs to the attribute that names it in any case
        if isinstance(value, s.Reference) and value.name in self.called and not (value.decoration or value.arguments):
            return self._value(self.called[value.name])
        if isinstance(value, s.Renamed) and self.is_class(value):
            return self._renamed(value)
        return self.rewritten(value) if isinstance(value, Node) else value

    def is_class(self, term: s.Term) -> bool:
        """Whether a term is a class, perhaps with actual parameters and under other names, or made of such."""
        match term:
            case s.Grouped(inner=inner) | s.Renamed(term=inner) | s.Operator(name="poly", operands=(inner,)):
                return self.is_class(inner)
            case s.Operator(name="union", operands=(left, right)):
                return self.is_class(left) and self.is_class(right)
        return isinstance(term, s.Reference) and (term.name in self.classes or term.name in self.called)

    def _renamed(self, node: s.Renamed) -> s.Term:
        """``C[T][new/old]``: a class that inherits from C under other names, and nothing more."""
        inner = self._value(node.term)
        inner = s.bare(inner)
        known = inner.name in self.classes or inner.name in self.made if isinstance(inner, s.Reference) else False
        if not isinstance(inner, s.Reference) or not known or any(map(self._is_local, inner.arguments)):
            return self.rewritten(node)
        pairs = tuple(
            [tuple([NameDeclaration(span=d.span, name=d.name + d.decoration) for d in pair]) for pair in node.renamings]
        )
        inherit = s.Inherit(span=node.span, name=inner.name, arguments=inner.arguments, renamings=pairs)  # type: ignore[arg-type]
        for name, made in self.made.items():
            if made.inherits == (inherit,):
                return s.Reference(span=node.span, name=name)
        name = f"{inner.name}_renamed_{len(self.made)}"
        self.made[name] = s.Class(span=node.span, name=name, inherits=(inherit,))
        return s.Reference(span=node.span, name=name)

    def _is_local(self, term: s.Term) -> bool:
        """Whether a term may speak of names that are not those of the script."""
        return bool(_names(term) - self.everywhere)

    def _poly(self, node: s.Operator) -> s.Term:
        operand = node.operands[0]
        operand = s.bare(operand)
        if not isinstance(operand, s.Reference) or operand.name not in self.classes or operand.arguments:
            self.report(messages.no_alternatives("`poly` is said of what is no class without parameters", node.span))
            return s.Reference(span=node.span, name="nat")
        kin = [name for name in self.classes if operand.name in self._ancestors(name)]
        return self._reference(node, f"poly_{operand.name}", kin, operand.name, every=True)

    def _union(self, term: s.Term) -> list[str] | None:
        """The classes of a union of them; None for a union of other sets."""
        term = s.bare(term)
        if isinstance(term, s.Reference) and term.name in self.classes and not term.arguments:
            return [term.name]
        if isinstance(term, s.Operator) and term.name == "union":
            left, right = map(self._union, term.operands)
            return None if left is None or right is None else list(dict.fromkeys([*left, *right]))
        return None

    def _ancestors(self, name: str) -> set[str]:
        """The class and what it inherits from."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            current = waiting.pop()
            if current not in found and current in self.classes:
                found.add(current)
                waiting += [inherit.name for inherit in self.classes[current].inherits]
        return found

    def _reference(self, node: s.Term, name: str, kin: Sequence[str], first: str, *, every: bool) -> s.Term:
        if name not in self.made:
            for alternative in kin:
                tree = self.classes[alternative]
                if tree.generics or any(self.classes[a].interface for a in self._ancestors(alternative)):
                    what = f"`{alternative}` has parameters or channels: its objects are no alternatives"
                    self.report(messages.no_alternatives(what, node.span))
                    return s.Reference(span=node.span, name="nat")
            self._make(name, kin, first, node.span, every=every)
        return s.Reference(span=node.span, name=name)

    def _make(self, name: str, kin: Sequence[str], first: str, span: Span, *, every: bool) -> None:
        """The class that stands for some alternatives; *every*: all have what the first one has."""
        kind = f"{name}_kind"
        branches = tuple([s.Branch(span=span, name=f"{name}_is_{k}") for k in kin])
        self.kinds.append(s.FreeType(span=span, name=kind, branches=branches))

        def reference(text: str) -> s.Reference:
            return s.Reference(span=span, name=text)

        def of_kind(k: str) -> s.Term:
            operands = (reference("kind"), reference(f"{name}_is_{k}"))
            return s.Chain(span=span, relations=("equal",), operands=operands)

        def declare(text: str, carrier: s.Term) -> s.Declare:
            return s.Declare(span=span, names=(s.Declared(span=span, name=text),), carrier=carrier)

        def part(k: str, field: str) -> s.Term:
            return s.Selection(span=span, record=reference(f"as_{k}"), field=field)

        attributes = self._common(kin, first, every=every)
        said = []
        for attribute in attributes:
            for k in kin:
                equal = s.Chain(span=span, relations=("equal",), operands=(reference(attribute), part(k, attribute)))
                said.append(s.Operator(span=span, name="implies", operands=(of_kind(k), equal)))
        common = [self._operations(k) for k in kin]
        operations = []
        for operation in [o for o in common[kin.index(first)] if all(o in others for others in common)]:
            body: s.Term | None = None
            for k in kin:
                guard = s.OperationText(span=span, delta=None, predicates=(of_kind(k),))
                branch: s.Term = s.Operator(span=span, name="and", operands=(guard, part(k, operation)))
                branch = s.Grouped(span=span, inner=branch)
                body = branch if body is None else s.Operator(span=span, name="choice", operands=(body, branch))
            assert body is not None
            operations.append(s.OperationDefinition(span=span, name=operation, body=body))
        visible = [*attributes, *[o.name for o in operations], "kind", "INIT"]
        self.made[name] = s.Class(
            span=span,
            name=name,
            visibility=tuple([NameDeclaration(span=span, name=v) for v in visible]),
            state=s.State(
                span=span,
                primary=(declare("kind", reference(kind)), *[declare(f"as_{k}", reference(k)) for k in kin]),
                secondary=tuple([declare(a, _placed(carrier, span)) for a, carrier in attributes.items()]),
                predicates=tuple(said),
            ),
            initial=s.Initial(span=span, predicates=tuple([part(k, "INIT") for k in kin])),
            operations=tuple(operations),
        )

    def _common(self, kin: Sequence[str], first: str, *, every: bool) -> dict[str, s.Term]:
        """The attributes that every alternative has, taken from any set that one of them takes them from."""
        found = dict(self._attributes(first))
        for other in () if every else kin[1:]:
            theirs = dict(self._attributes(other))
            both: dict[str, s.Term] = {}
            for name, carrier in found.items():
                if name not in theirs:
                    continue
                operands = (carrier, theirs[name])
                alike = carrier == theirs[name]
                both[name] = carrier if alike else s.Operator(span=carrier.span, name="union", operands=operands)
            found = both
        return found

    def _attributes(self, name: str, seen: frozenset[str] = frozenset()) -> Iterator[tuple[str, s.Term]]:
        """The visible variables of a class with what they are taken from, where the script's names tell that."""
        tree = self.classes[name]
        for inherit in tree.inherits:
            if inherit.name in seen or inherit.renamings or inherit.arguments:
                continue
            if inherit.name in self.classes:
                yield from self._attributes(inherit.name, seen | {name})
        local = {n for p in tree.paragraphs for n in _declared(p)}
        visible = None if tree.visibility is None else {v.name for v in tree.visibility}
        state = tree.state
        constants = [d for p in tree.paragraphs if isinstance(p, s.Axiom) and not p.generics for d in p.declarations]
        for paragraph in tree.paragraphs:
            if isinstance(paragraph, s.Abbreviation) and not paragraph.generics:
                # Its only value.
                one = s.Display(span=paragraph.body.span, kind="set", items=(paragraph.body,))
                name_ = s.Declared(span=paragraph.span, name=paragraph.name)
                constants.append(s.Declare(span=paragraph.span, names=(name_,), carrier=one))
        for declaration in (*constants, *(() if state is None else (*state.primary, *state.secondary))):
            if _names(declaration.carrier) & (local | set(self.classes)):
                continue
            for declared in declaration.names:
                if visible is None or declared.name in visible:
                    yield declared.name, declaration.carrier

    def _operations(self, name: str, seen: frozenset[str] = frozenset()) -> dict[str, None]:
        """The visible operations of a class, inherited ones among them."""
        tree = self.classes[name]
        found: dict[str, None] = {}
        for inherit in tree.inherits:
            if inherit.name in self.classes and inherit.name not in seen:
                new = {old.name: new.name for new, old in inherit.renamings}
                found |= {new.get(o, o): None for o in self._operations(inherit.name, seen | {name})}
        found |= {operation.name: None for operation in tree.operations}
        if tree.visibility is not None:
            visible = {v.name for v in tree.visibility}
            found = {o: None for o in found if o in visible}
        return found


def _placed(value: Any, span: Span) -> Any:
    """A tree as if it stood at a place, which is where its mistakes are told."""
    if isinstance(value, tuple):
        return tuple([_placed(item, span) for item in value])
    if not isinstance(value, Node):
        return value
    changed = {f.name: _placed(getattr(value, f.name), span) for f in fields(value) if f.name != "span"}
    return replace(value, span=span, **changed)


def _declared(paragraph: s.Paragraph) -> Iterator[str]:
    """The names that a paragraph of a class declares."""
    match paragraph:
        case s.Axiom():
            yield from (d.name for declaration in paragraph.declarations for d in declaration.names)
        case s.Abbreviation() | s.FreeType() | s.Schema():
            yield paragraph.name


def _names(term: s.Term) -> set[str]:
    from cspcheck.cspm.oz.typing.scopes import subterms

    found: set[str] = set()
    stack = [term]
    while stack:
        current = stack.pop()
        if isinstance(current, s.Reference):
            found.add(current.name)
        stack.extend(subterms(current))
    return found
