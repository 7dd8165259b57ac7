"""Objects by flattening: an attribute of a class type becomes the variables of the class, under its name.

``a : Account`` declares ``a.balance`` and what else an account has, with the account's invariant; ``f : X -> Account``,
a family of objects over given identities, declares functions from X. Each name is an object of its own, which it names
for ever.

Where a class uses objects as values (``s : power Account``, ``a? : Account``, ``a' = b``), they are identities, of
a given set with the name of the class, and the state has a *pool*: the family ``Account.balance : Account -> int`` of
all there are. It is one for all that the class is made of, so that objects can be shared and exchanged. Objects within
themselves are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import BOOL, Apply, Declared, FunctionType, SetType, Term, Variable
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.operation_calculus import Box, Calculus, Place, changed, closed
from cspcheck.cspm.oz.typing.schemas import maximal
from cspcheck.cspm.oz.typing.scopes import ClassEntry, Definition, FailedEntry, ObjectEntry, SetEntry, TypingScope
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong, element_of
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.oz.values.terms import conjuncts, free_variables
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

Change = Callable[[Variable], Term | None]


@dataclass(frozen=True)
class ObjectClass:
    """What is needed of a class to make objects of it: the class, its schemas, the objects that it has itself, and
    what its abbreviations stand for.
    """

    model: core.ClassModel
    boxes: Mapping[str, Box]
    objects: Mapping[str, ObjectEntry]
    types: Mapping[str, tuple[Definition, str]] = field(default_factory=dict)

    @property
    def pools(self) -> tuple[str, ...]:
        """The classes whose objects are values in it."""
        return tuple([name for name, entry in self.objects.items() if entry.pool])

    def owns(self, name: str) -> bool:
        """Whether a variable or constant is its own, not one of a pool, which all that a class is made of share."""
        return not any(name.startswith(f"{pool}.") for pool in self.pools)


@dataclass
class Flattened:
    """What the objects of a class declare in it, under qualified names."""

    primary: list[Declared] = field(default_factory=list)
    secondary: list[Declared] = field(default_factory=list)
    constants: list[Declared] = field(default_factory=list)
    axioms: list[Term] = field(default_factory=list)
    invariant: list[Term] = field(default_factory=list)
    objects: dict[str, ObjectEntry] = field(default_factory=dict)


class Objects:
    """Flattens the declarations of objects in one class.

    Args:
        typing, scope: by which the identities of families are read.
        owner: the class.
        made: the class that a declaration names, with actual parameters.
        values: the classes whose objects are values in the owner.
        report: told what is wrong or odd.
    """

    def __init__(
        self,
        typing: Typing,
        scope: TypingScope,
        owner: str,
        made: Callable[[s.Reference], ObjectClass],
        values: frozenset[str],
        report: Callable[[Diagnostic], None],
    ) -> None:
        self._typing = typing
        self._scope = scope
        self._owner = owner
        self._made = made
        self._values = values
        self._report = report
        self._fresh = 0

    def split(self, declarations: tuple[s.Declare, ...]) -> tuple[tuple[s.Declare, ...], list[s.Declare]]:
        """The declarations of values, and those of objects."""
        values = tuple([d for d in declarations if not d.names or self._class(d.carrier) is None])
        return values, [d for d in declarations if d not in values]

    def _class(self, carrier: s.Term) -> tuple[s.Reference, s.Term | None] | None:
        """The class, and the identities of a family; None for a set of values."""
        carrier = s.bare(carrier)
        if isinstance(carrier, s.Operator) and carrier.name == "fun":
            found = self._class(carrier.operands[1])
            return None if found is None or found[1] is not None else (found[0], carrier.operands[0])
        if isinstance(carrier, s.Reference) and isinstance(self._scope.find(carrier.name), ClassEntry):
            return None if carrier.name in self._values else (carrier, None)
        return None

    def pools(self, span: Span, known: Mapping[str, ObjectEntry], result: Flattened) -> None:
        """The objects of all classes that are values here or in an object, beside those *known* already."""
        owners = [made for entry in result.objects.values() if isinstance(made := entry.made, ObjectClass)]
        waiting = sorted(self._values) + [name for made in owners for name in made.pools]
        while waiting:
            name = waiting.pop()
            if name in known or name in result.objects:
                continue
            entry = self._scope.find(name)
            if not isinstance(entry, ClassEntry) or entry.identities is None:
                continue  # told where it is used
            try:
                made = self._made(s.Reference(span=span, name=name))
                self._flatten(name, made, entry.identities, span, result, pool=True)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                continue
            waiting += made.pools

    def flattened(self, declarations: list[s.Declare]) -> Flattened:
        """What declarations of objects declare."""
        result = Flattened()
        for declaration in declarations:
            found = self._class(declaration.carrier)
            assert found is not None
            try:
                made = self._made(found[0])
                identities = None if found[1] is None else self._typing.carrier(found[1], self._scope)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                for name in declaration.names:
                    self._scope.add(name.name, FailedEntry(wrong.diagnostic))
                continue
            for name in declaration.names:
                if name.name in result.objects:
                    first = result.objects[name.name].span
                    self._report(type_messages.declared_twice(name.name, first, name.span))
                    continue
                self._flatten(name.name, made, identities, name.span, result)
        return result

    def _flatten(
        self,
        path: str,
        made: ObjectClass,
        identities: Term | None,
        span: Span,
        result: Flattened,
        *,
        pool: bool = False,
    ) -> None:
        model = made.model
        shared = shared_constants(model)
        binder = None
        if identities is not None:
            self._fresh += 1
            binder = core.Binder(f"i%{self._owner}%{path}%{self._fresh}", element_of(identities), identities, "i")
        index = None if binder is None else Variable(type=binder.type, name=binder.name, role="bound", span=span)
        change = qualified(path, made, index)
        common = {id(p) for entry in made.objects.values() if entry.pool for p in entry.said}
        start = len(result.axioms), len(result.invariant)
        tables = (
            (model.primary, result.primary),
            (model.secondary, result.secondary),
            (model.constants, result.constants),
        )
        for declared_, target in tables:
            for one in [d for d in declared_ if made.owns(d.name)]:
                carrier = substituted(one.carrier, change)
                alike = target is result.constants and one.name in shared
                target.append(self._declared(path, one, carrier, None if alike else binder, span))
                if binder is not None and not alike and free_variables(one.carrier):
                    role: core.Role = "constant" if target is result.constants else "before"
                    value = change(Variable(type=one.type, name=one.name, role=role))
                    assert value is not None
                    said = Apply(type=BOOL, operator="in", operands=(value, carrier), span=span)
                    (result.axioms if role == "constant" else result.invariant).append(_for_all(said, binder))
        said_of_each = [substituted(p, change) for p in model.axioms if id(p) not in common]
        result.axioms += [p if binder is None or _free_of(p, binder) else _for_all(p, binder) for p in said_of_each]
        result.invariant += [_for_all(substituted(p, change), binder) for p in model.invariant if id(p) not in common]
        for name, (entry, _) in made.types.items():
            shown = model.visibility is None or name in model.visibility
            whole = isinstance(entry, SetEntry) and isinstance(entry.term, Apply) and entry.term.operator == "All"
            if shown and isinstance(entry, SetEntry) and not whole:
                term = substituted(entry.term, change)
                if binder is None or _free_of(term, binder):
                    self._scope.add(f"{path}.{name}", SetEntry(term, span))
        initial = tuple([substituted(p, change) for p in model.initial or ()])
        all_said = (*result.axioms[start[0] :], *result.invariant[start[1] :]) if pool else ()
        result.objects[path] = ObjectEntry(path, model.name, binder, initial, made, span, shared, pool, all_said)
        for name, inner in made.objects.items():
            if inner.pool:
                continue
            if binder is not None and inner.binder is not None:
                raise Wrong(messages.objects_need_heap("a family in each object of a family", span))
            own = tuple([substituted(p, change) for p in inner.initial])
            result.objects[f"{path}.{name}"] = replace(
                inner, name=f"{path}.{name}", initial=own, binder=binder or inner.binder, span=span
            )

    def _declared(self, path: str, one: Declared, carrier: Term, binder: core.Binder | None, span: Span) -> Declared:
        name = f"{path}.{one.name}"
        if binder is None:
            return Declared(name=name, type=one.type, carrier=carrier, span=span)
        if free_variables(one.carrier):
            carrier = maximal(one.type)  # it is said of each object what set the value is in
        kind = FunctionType(binder.type, one.type)
        family = Apply(type=SetType(kind), operator="fun", operands=(binder.carrier, carrier), span=span)
        return Declared(name=name, type=kind, carrier=family, span=span)


def _free_of(predicate: Term, binder: core.Binder) -> bool:
    return (binder.name, "bound") not in free_variables(predicate)


def shared_constants(model: core.ClassModel) -> frozenset[str]:
    """The constants that an axiom of the class gives a value, the same for all of its objects."""
    own = {c.name for c in model.constants}
    found: set[str] = set()
    for left, right in [pair for axiom in conjuncts(model.axioms) for pair in _equation(axiom)]:
        known = not any(name in own for name, role in free_variables(right) if role == "constant")
        if isinstance(left, Variable) and left.name in own and left.role == "constant" and known:
            found.add(left.name)
    return frozenset(found)


def _for_all(predicate: Term, binder: core.Binder | None) -> Term:
    if binder is None:
        return predicate
    true = core.Constant(type=BOOL, value=True)
    return core.Quantifier(
        type=BOOL, kind="forall", binders=(binder,), condition=true, body=predicate, span=predicate.span
    )


def qualified(path: str, made: ObjectClass, index: Term | None) -> Change:
    """The replacement of the variables and constants of a class by those of one of its objects."""
    model = made.model
    names = {d.name for d in (*model.primary, *model.secondary) if made.owns(d.name)}
    constants = {d.name for d in model.constants if made.owns(d.name)}
    shared = shared_constants(model)

    def change(v: Variable) -> Term | None:
        inside = (v.role in ("before", "after") and v.name in names) or (v.role == "constant" and v.name in constants)
        if not inside:
            return None
        if index is None or (v.role == "constant" and v.name in shared):
            return replace(v, name=f"{path}.{v.name}")
        family = replace(v, name=f"{path}.{v.name}", type=FunctionType(index.type, v.type))
        return Apply(type=v.type, operator="apply", operands=(family, index), span=v.span)

    return change


def promoted(entry: ObjectEntry, index: Term | None, name: str, calculus: Calculus, span: Span) -> Box:
    """The operation of an object: the schema of its class, said of the variables of the object.

    Raises:
        Wrong: the class has no such visible operation.
    """
    made = entry.made
    assert isinstance(made, ObjectClass)
    visible = [n for n in made.boxes if made.model.visibility is None or n in made.model.visibility]
    if name not in visible:
        raise Wrong(messages.no_operation_of_object(name, made.model.name, span, suggestions(name, visible)))
    box = replace(made.boxes[name], name=name, span=span)
    change = qualified(entry.name, made, index)

    def called(name: str) -> str:
        return f"{entry.name}.{name}" if made.owns(name) else name

    delta = tuple([called(name) for name in box.delta])
    framed = frozenset(map(called, box.framed))
    if index is None:
        places = tuple([replace(p, name=called(p.name)) for p in changed(box, change).places])
        return replace(changed(box, change), delta=delta, places=places, framed=framed)
    if any(made.owns(place.name) for place in box.places):
        box = closed(box)
    # Of a family, the functions change at one place.
    members = {d.name: d for d in (*made.model.primary, *made.model.secondary) if made.owns(d.name)}
    changing = [members[n] for n in dict.fromkeys((*box.delta, *members)) if n in box.delta or _secondary(made, n)]
    changing = [d for d in changing if made.owns(d.name)]
    binders = {d.name: calculus.bound(d.name, d.type, substituted(d.carrier, change)) for d in changing}

    def at_one_place(v: Variable) -> Term | None:
        if v.role == "after" and v.name in binders:
            return Variable(type=v.type, name=binders[v.name].name, role="bound", span=v.span)
        return change(replace(v, role="before") if v.role == "after" and v.name in members else v)

    box = replace(changed(box, at_one_place), delta=delta, framed=framed)
    predicates = list(box.predicates)
    places = box.places
    bound = {b.name: b for b in binders.values()}
    for d in changing:
        name_ = binders[d.name].name
        value, predicates = _determined(name_, predicates, frozenset(bound))
        if value is None:
            value = Variable(type=d.type, name=name_, role="bound", span=span)
        else:
            del bound[name_]
            known = value
            places = tuple(
                [replace(p, index=_put(p.index, name_, known), value=_put(p.value, name_, known)) for p in places]
            )
        places = (*places, Place(f"{entry.name}.{d.name}", FunctionType(index.type, d.type), index, value))
    values = (*bound.values(), *box.values)
    return replace(box, predicates=tuple(predicates), places=places, values=values)


def _secondary(made: ObjectClass, name: str) -> bool:
    return any(d.name == name for d in made.model.secondary)


def _determined(name: str, predicates: list[Term], bound: frozenset[str]) -> tuple[Term | None, list[Term]]:
    """The value that an equation gives a bound variable, put in for it everywhere; None where there is none."""
    for place, predicate in enumerate(predicates):
        for left, right in _equation(predicate):
            known = not any(n in bound for n, _ in free_variables(right))
            if isinstance(left, Variable) and left.name == name and known:
                rest = [*predicates[:place], *predicates[place + 1 :]]
                return right, [_put(p, name, right) for p in rest]
    return None, predicates


def _put(predicate: Term, name: str, value: Term) -> Term:
    return substituted(predicate, lambda v: value if v.name == name else None)


def _equation(predicate: Term) -> Iterator[tuple[Term, Term]]:
    if isinstance(predicate, Apply) and predicate.operator == "equal":
        left, right = predicate.operands
        yield left, right
        yield right, left
