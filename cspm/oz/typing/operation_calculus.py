"""The operation calculus of Object-Z: operations made of operations, unfolded to one schema each.

Conjunction, choice, sequence, parallel composition, hiding, renaming, enrichment and their distributed forms, as in
Smith, *The Object-Z Specification Language* (2000), chapter 3. ``k?`` and ``k!`` are different variables; parallel and
sequential composition identify the output of one operand with the input of the same name of another, and hide both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Final, Literal

from cspcheck.cspm.diagnostics import DiagnosticSink, Severity
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import BOOL, Apply, Constant, Term, Variable
from cspcheck.cspm.oz.objects.messages import duplicate_renaming, value_handed_on
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.scopes import ParameterEntry, TypingScope
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import renamed_variables, substituted
from cspcheck.cspm.oz.values.terms import free_variables, shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

SIGNS: Final[Mapping[core.ParameterKind, str]] = {"input": "?", "output": "!", "simple": ""}
KINDS: Final[Mapping[str, core.ParameterKind]] = {"?": "input", "!": "output", "": "simple"}

Key = tuple[str, core.ParameterKind]


@dataclass(frozen=True)
class Place:
    """That an operation changes one object of a family: *name* has *value* at *index* after it."""

    name: str
    type: core.FunctionType
    index: Term
    value: Term


@dataclass(frozen=True)
class Box:
    """A schema by itself: what it may change, its parameters, its predicates.

    ``declared`` are the predicates that its declarations are: each parameter is in the set that it is declared with.
    They are kept apart from the others because most only repeat what the channel says. Operations of objects of one
    family change it at ``places``, those of all operands together; what is elsewhere stays. ``values`` are the
    variables in them that the predicates leave open. Of the families in ``framed`` is said already which objects stay.
    """

    name: str
    delta: tuple[str, ...]
    parameters: tuple[core.Parameter, ...]
    declared: tuple[Apply, ...]
    predicates: tuple[Term, ...]
    span: Span
    places: tuple[Place, ...] = ()
    values: tuple[core.Binder, ...] = ()
    framed: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Surroundings:
    """The state of the class that operations work on.

    Attributes:
        owner: the class, which makes names of bound variables unique.
        states: all state variables.
        secondary: those that follow from the others.
        invariant: of the class; it holds in the state between the operands of a sequence.
    """

    owner: str
    states: Mapping[str, core.Declared]
    secondary: frozenset[str]
    invariant: Sequence[Term]


class Calculus:
    """Unfolds expressions over operations.

    Args:
        typing: of the specification.
        around: the state of the class.
        named: the schema of an operation of the class, by its name.
        boxed: the schema that stands in brackets in an expression, in the scope of what enriches it.
        promoted: the operation of an object, ``a.Op``.
        report: told what is odd.
    """

    def __init__(
        self,
        typing: Typing,
        around: Surroundings,
        named: Callable[[s.Reference], Box],
        boxed: Callable[[s.OperationText, TypingScope], Box],
        promoted: Callable[[s.Selection, TypingScope], Box],
        report: DiagnosticSink,
    ) -> None:
        self._typing = typing
        self._around = around
        self._named = named
        self._boxed = boxed
        self._promoted = promoted
        self._report = report
        self._fresh = count(1)

    def box(self, body: s.Term, scope: TypingScope) -> Box:
        """The schema that an expression stands for.

        Raises:
            Wrong: it has none.
        """
        match body:
            case s.Grouped():
                return self.box(body.inner, scope)
            case s.Reference():
                return self._named(body)
            case s.OperationText():
                return self._boxed(body, scope)
            case s.Selection():
                return self._promoted(body, scope)
            case s.Renamed():
                return self._renamed(self.box(body.term, scope), body)
            case s.Distributed():
                return self._distributed(body, scope)
            case s.Operator(name="hide", operands=(operand, s.Display() as hidden)):
                return self._hidden(self.box(operand, scope), hidden)
            case s.Operator(name="enrich", operands=(first, second)):
                left = self.box(first, scope)
                inner = TypingScope(scope)
                for p in left.parameters:
                    inner.add(p.name, ParameterEntry(p.name, p.kind, p.type, p.span))
                return self.joined("and", left, self.box(second, inner), body.span)
            case s.Operator(name="parallel" | "parallel_open" as name, operands=(first, second)):
                return self._parallel(
                    self.box(first, scope), self.box(second, scope), body.span, hides=name == "parallel"
                )
            case s.Operator(name="and" | "or" | "choice" | "compose" as name, operands=operands):
                boxes = [self.box(operand, scope) for operand in operands]
                result = boxes[0]
                for other in boxes[1:]:
                    result = self.joined("choice" if name == "or" else name, result, other, body.span)
                return result
        raise Wrong(messages.operation_expression(body.span))

    # --- two operations ---------------------------------------------------------------------------------------

    def joined(self, name: Literal["and", "choice", "compose"], left: Box, right: Box, span: Span) -> Box:
        """Two operations as one: both, one of them, one after the other.

        Raises:
            Wrong: they have a parameter of the same name with different types.
        """
        delta = tuple(dict.fromkeys((*left.delta, *right.delta)))
        hidden: list[core.Binder] = []
        if name == "and":
            right = self._apart(left, right)
            twice = (left.framed & set(right.delta)) | (right.framed & set(left.delta))
            if twice:
                raise Wrong(messages.changed_twice(sorted(twice)[0], span))
        else:
            left, right = closed(left), closed(right)
        if name == "compose":
            left, right, hidden = self._identified(left, right, span)
        parameters = _merged(left, right, name)
        declared = tuple({shape(d): d for d in (*left.declared, *right.declared)}.values())
        if name == "and":
            predicates: tuple[Term, ...] = (*left.predicates, *right.predicates)
        elif name == "choice":
            # What only one alternative declares holds in that alternative.
            shapes = [{shape(d) for d in box.declared} for box in (left, right)]
            declared = tuple([d for d in declared if all(shape(d) in known for known in shapes)])
            common = set(map(shape, declared))
            both = []
            for box in (left, right):
                own = [d for d in box.declared if shape(d) not in common]
                both.append(core.conjunction((*own, *box.predicates, *self._kept(delta, box)), box.span))
            predicates = (Apply(type=BOOL, operator="or", operands=tuple(both), span=span),)
        else:
            # What the second operation declares is about the state between.
            between = [d for d in right.declared if any(role == "before" for _, role in free_variables(d))]
            declared = tuple([d for d in declared if d in left.declared or d not in between])
            second = replace(right, predicates=(*between, *right.predicates))
            predicates = (self._sequence(left, second, delta, hidden, span),)
        places, values = ((*left.places, *right.places), (*left.values, *right.values)) if name == "and" else ((), ())
        return Box(left.name, delta, parameters, declared, predicates, span, places, values, left.framed | right.framed)

    def _apart(self, left: Box, right: Box) -> Box:
        """The second box with other names for the variables that both leave open."""
        names = {binder.name for binder in left.values}
        fresh = {b.name: self.bound(b.written, b.type, b.carrier) for b in right.values if b.name in names}
        if not fresh:
            return right

        def renamed(v: Variable) -> Term | None:
            return replace(v, name=fresh[v.name].name) if v.role == "bound" and v.name in fresh else None

        right = changed(right, renamed)
        return replace(right, values=tuple([replace(b, name=fresh.get(b.name, b).name) for b in right.values]))

    def _kept(self, delta: tuple[str, ...], box: Box) -> Iterator[Term]:
        """That variables of a joint Delta-list which one operation does not change keep their values."""
        for name in delta:
            if name not in box.delta:
                after, before = self._state(name, "after", box.span), self._state(name, "before", box.span)
                yield Apply(type=BOOL, operator="equal", operands=(after, before), span=box.span)

    def _state(self, name: str, role: core.Role, span: Span) -> Variable:
        return Variable(type=self._around.states[name].type, name=name, role=role, span=span)

    def _sequence(
        self, left: Box, right: Box, delta: tuple[str, ...], hidden: Sequence[core.Binder], span: Span
    ) -> Term:
        """One operation, then the other, by way of a state between them that satisfies the invariant."""
        middle = {}
        binders = list(hidden)
        for name in [*delta, *sorted(self._around.secondary)]:
            declared = self._around.states[name]
            binders.append(self.bound(name, declared.type, declared.carrier))
            middle[name] = Variable(type=declared.type, name=binders[-1].name, role="bound", span=span)
        first = [renamed_variables(p, "after", middle) for p in (*left.predicates, *self._kept(delta, left))]
        holds = [renamed_variables(p, "before", middle) for p in self._around.invariant]
        second = [renamed_variables(p, "before", middle) for p in (*right.predicates, *self._kept(delta, right))]
        return core.Quantifier(
            type=BOOL,
            kind="exists",
            binders=tuple(binders),
            condition=core.conjunction(tuple(holds), span),
            body=core.conjunction((*first, *second), span),
            span=span,
        )

    def _identified(self, left: Box, right: Box, span: Span) -> tuple[Box, Box, list[core.Binder]]:
        """What *left* hands on to *right*, as bound variables that both speak of."""
        return self._shared(left, right, [_pairs(left, right), _handed_on(left, right)], span)

    def _shared(
        self, left: Box, right: Box, pairs: Sequence[Iterable[tuple[core.Parameter, core.Parameter]]], span: Span
    ) -> tuple[Box, Box, list[core.Binder]]:
        binders: list[core.Binder] = []
        for first, second in [pair for found in pairs for pair in found]:
            carrier = _common("inter", first, second)
            binders.append(self.bound(first.name, first.type, carrier))
            value = Variable(type=first.type, name=binders[-1].name, role="bound", span=span)
            left = _without(left, (first.name, first.kind), value)
            right = _without(right, (second.name, second.kind), value)
        return left, right, binders

    def _parallel(self, left: Box, right: Box, span: Span, *, hides: bool) -> Box:
        """Both at once; inputs of the one are outputs of the other where they have the same name."""
        pairs = [list(_pairs(left, right)), [(i, o) for o, i in _pairs(right, left)]]
        both = {o.name for o, _ in pairs[0]} & {o.name for _, o in pairs[1]}
        # What each of them both tells and hears, neither hears from the other.
        pairs = [[pair for pair in found if pair[0].name not in both] for found in pairs]
        if hides:
            left, right, binders = self._shared(left, right, pairs, span)
            return self._exists(binders, self.joined("and", left, right, span), span)
        for output, input_ in pairs[0]:
            right = _renamed(right, input_, output)
        for input_, output in pairs[1]:
            left = _renamed(left, input_, output)
        return self.joined("and", left, right, span)

    # --- one operation ----------------------------------------------------------------------------------------

    def _exists(self, binders: Sequence[core.Binder], box: Box, span: Span, condition: Term | None = None) -> Box:
        """A box in which some values exist instead of being parameters."""
        if not binders:
            return box
        names = {binder.name for binder in binders}
        own = tuple([d for d in box.declared if not any(name in names for name, _ in free_variables(d))])
        within = [d for d in box.declared if d not in own]
        parameters = tuple([replace(p, carrier=self.closed(p, binders)) for p in box.parameters])
        if box.places:
            said = (*([] if condition is None else [condition]), *within)
            return replace(
                box,
                parameters=parameters,
                declared=own,
                predicates=(*said, *box.predicates),
                span=span,
                values=(*binders, *box.values),
            )
        predicate = core.Quantifier(
            type=BOOL,
            kind="exists",
            binders=tuple(binders),
            condition=condition or Constant(type=BOOL, value=True),
            body=core.conjunction((*within, *box.predicates), span),
            span=span,
        )
        return replace(box, parameters=parameters, declared=own, predicates=(predicate,), span=span)

    def hidden(self, box: Box, keys: Sequence[Key]) -> Box:
        """A box without some of its parameters, of which only is said that they have values."""
        binders = []
        for key in dict.fromkeys(keys):
            parameter = next(p for p in box.parameters if (p.name, p.kind) == key)
            binders.append(self.bound(parameter.name, parameter.type, parameter.carrier))
            value = Variable(type=parameter.type, name=binders[-1].name, role="bound", span=parameter.span)
            box = _without(box, key, value)
        return self._exists(binders, box, box.span)

    def _hidden(self, box: Box, hidden: s.Display) -> Box:
        return self.hidden(box, [self._key(box, item) for item in hidden.items])

    def _key(self, box: Box, item: s.Term | s.Declared) -> Key:
        """The parameter of an operation that a name with its decoration means."""
        item = item if isinstance(item, s.Declared) else s.bare(item)
        written = {p.name + SIGNS[p.kind]: (p.name, p.kind) for p in box.parameters}
        if not isinstance(item, s.Reference | s.Declared):
            raise Wrong(messages.operation_expression(item.span))
        name = item.name + item.decoration
        if name not in written:
            raise Wrong(type_messages.unknown_parameter(name, item.span, suggestions(name, written)))
        return written[name]

    def _renamed(self, box: Box, node: s.Renamed) -> Box:
        """All at once; a name that the operation does not have changes nothing, which is told."""
        written = {p.name + SIGNS[p.kind]: p for p in box.parameters}
        seen: dict[str, s.Declared] = {}
        later: list[tuple[core.Parameter, core.Parameter]] = []
        for new, old in node.renamings:
            name = old.name + old.decoration
            if name in seen:
                raise Wrong(duplicate_renaming(name, old.span))
            seen[name] = new
            if name not in written:
                found = type_messages.unknown_parameter(name, old.span, suggestions(name, written))
                self._report(replace(found, severity=Severity.WARNING))
                continue
            if new.decoration not in KINDS:
                raise Wrong(type_messages.prime_on_no_state(new.name + new.decoration, new.span))
            first = written[name]
            # By way of a name that nothing else has, so that names can be exchanged.
            between = replace(first, name=f"{first.name}%{len(later)}")
            box = _renamed(box, first, between)
            later.append((between, replace(first, name=new.name, kind=KINDS[new.decoration], span=new.span)))
        for between, target in later:
            box = _renamed(box, next(p for p in box.parameters if p.name == between.name), target)
        return box

    # --- distributed operations -------------------------------------------------------------------------------

    def _distributed(self, node: s.Distributed, scope: TypingScope) -> Box:
        if node.kind in ("compose", "parallel"):
            return self._unfolded(node, scope)
        binders, inner = self._typing.binders(node.declarations, scope, "effect")
        condition = None if node.condition is None else self._typing.predicate(node.condition, inner, "effect")
        box = self.box(node.body, inner)
        written = {binder.written for binder in binders}
        for parameter in box.parameters:
            if parameter.kind == "simple" and parameter.name in written:
                raise Wrong(type_messages.declared_twice(parameter.name, node.span, parameter.span))
        if node.kind == "choice":
            return self._exists(binders, box, node.span, condition)
        parameters = tuple([replace(p, carrier=self.closed(p, binders)) for p in box.parameters])
        said = self._of_each(box, binders, condition or Constant(type=BOOL, value=True), node.span)
        framed = box.framed | {place.name for place in box.places}
        return Box(box.name, box.delta, parameters, (), said, node.span, framed=framed)

    def _of_each(self, box: Box, binders: tuple[core.Binder, ...], condition: Term, span: Span) -> tuple[Term, ...]:
        """That an operation happens for each value of bound variables, at all of their places at once."""
        predicates = [*box.declared, *box.predicates]
        moved: list[Term] = []
        names = dict.fromkeys(place.name for place in box.places)
        for name in names:
            places = [place for place in box.places if place.name == name]
            first = places[0]
            before, after = [Variable(type=first.type, name=name, role=role, span=span) for role in ("before", "after")]
            index = first.index
            its_own = isinstance(index, Variable) and len(binders) == 1 and index.name == binders[0].name
            if its_own and len(places) == 1 and not box.values:
                each: Term = core.Comprehension(
                    type=first.type, kind="lambda", binders=binders, condition=condition, body=first.value, span=span
                )
                value = Apply(type=first.type, operator="override", operands=(before, each), span=span)
                moved.append(Apply(type=BOOL, operator="equal", operands=(after, value), span=span))
                continue
            for place in places:
                there = Apply(type=first.type.range, operator="apply", operands=(after, place.index), span=span)
                predicates.append(Apply(type=BOOL, operator="equal", operands=(there, place.value), span=span))
            moved.append(self._elsewhere(places, binders, condition, span))
        body = core.conjunction(tuple(predicates), span)
        if box.values:
            true = Constant(type=BOOL, value=True)
            body = core.Quantifier(type=BOOL, kind="exists", binders=box.values, condition=true, body=body, span=span)
        all_ = core.Quantifier(type=BOOL, kind="forall", binders=binders, condition=condition, body=body, span=span)
        return (*moved, all_)

    def _elsewhere(
        self, places: Sequence[Place], binders: tuple[core.Binder, ...], condition: Term, span: Span
    ) -> Term:
        """That a family is as it was where no operation of a distributed one changes it."""
        kind = places[0].type
        before, after = [Variable(type=kind, name=places[0].name, role=role, span=span) for role in ("before", "after")]
        identities = Apply(type=core.SetType(kind.domain), operator="dom", operands=(before,), span=span)
        binder = self.bound("i", kind.domain, identities)
        one = Variable(type=kind.domain, name=binder.name, role="bound", span=span)
        there = [Apply(type=BOOL, operator="equal", operands=(one, place.index), span=span) for place in places]
        some: Term = there[0] if len(there) == 1 else Apply(type=BOOL, operator="or", operands=tuple(there), span=span)
        changed_ = core.Quantifier(type=BOOL, kind="exists", binders=binders, condition=condition, body=some, span=span)
        values = [Apply(type=kind.range, operator="apply", operands=(f, one), span=span) for f in (after, before)]
        return core.Quantifier(
            type=BOOL,
            kind="forall",
            binders=(binder,),
            condition=Apply(type=BOOL, operator="not", operands=(changed_,), span=span),
            body=Apply(type=BOOL, operator="equal", operands=tuple(values), span=span),
            span=span,
        )

    def _unfolded(self, node: s.Distributed, scope: TypingScope) -> Box:
        """One operand after the other, for elements that are written out: how many there are must be known."""
        (declaration,) = node.declarations if len(node.declarations) == 1 else (None,)
        elements = _displayed(declaration.carrier) if declaration is not None and len(declaration.names) == 1 else None
        if declaration is None or not elements or node.condition is not None:
            raise Wrong(messages.distribution_not_known(node.span))
        boxes = []
        for element in elements:
            inner = self._typing.local(scope, declaration.names[0], element, "effect")
            boxes.append(self.box(node.body, inner))
        result = boxes[0]
        for box in boxes[1:]:
            if node.kind == "compose":
                result = self.joined("compose", result, box, node.span)
            else:
                result = self._parallel(result, box, node.span, hides=True)
        return result

    # --- bound variables --------------------------------------------------------------------------------------

    def bound(self, name: str, type_: core.Type, carrier: Term) -> core.Binder:
        """A binder with a name of its own."""
        return core.Binder(f"{name}%{self._around.owner}%{next(self._fresh)}", type_, carrier, name)

    def closed(self, parameter: core.Parameter, binders: Sequence[core.Binder]) -> Term:
        """The set that a parameter is declared with, for any values of bound variables that it depends on."""
        used = free_variables(parameter.carrier)
        around = [binder for binder in binders if (binder.name, "bound") in used]
        if not around:
            return parameter.carrier
        value = self.bound(parameter.name, parameter.type, parameter.carrier)
        return core.Comprehension(
            type=core.SetType(parameter.type),
            kind="set",
            binders=(*around, value),
            condition=Constant(type=BOOL, value=True),
            body=Variable(type=parameter.type, name=value.name, role="bound", span=parameter.span),
            span=parameter.carrier.span,
        )

    def closed_over_states(self, parameter: core.Parameter) -> Term:
        """The set that a parameter is declared with, for any state: what the fields of its channel carry."""
        used = {name for name, role in free_variables(parameter.carrier) if role == "before"}
        table: dict[str, Variable] = {}
        binders: list[core.Binder] = []
        for name, declared in self._around.states.items():
            if name in used:
                binders.append(self.bound(name, declared.type, declared.carrier))
                table[name] = Variable(type=declared.type, name=binders[-1].name, role="bound", span=parameter.span)
        carrier = renamed_variables(parameter.carrier, "before", table)
        return self.closed(replace(parameter, carrier=carrier), binders)


def _pairs(left: Box, right: Box) -> Iterator[tuple[core.Parameter, core.Parameter]]:
    """The outputs of one operation with the inputs of another that have their names."""
    for output in left.parameters:
        for input_ in right.parameters:
            if (output.name, output.kind, input_.kind) == (input_.name, "output", "input"):
                if output.type != input_.type:
                    types = (str(input_.type), str(output.type))
                    raise Wrong(messages.parameter_type(input_.name, right.name, *types, input_.span, output.span))
                yield output, input_


def _handed_on(left: Box, right: Box) -> Iterator[tuple[core.Parameter, core.Parameter]]:
    """Variables of the operations alone: what the first leaves behind primed, with what the second begins with."""
    for first in left.parameters:
        for second in right.parameters:
            if first.kind == second.kind == "simple" and first.name == f"{second.name}'":
                if first.type != second.type:
                    raise Wrong(value_handed_on(first.name, (str(first.type), str(second.type)), second.span))
                yield first, second


def _merged(left: Box, right: Box, name: str) -> tuple[core.Parameter, ...]:
    """The parameters of two operations; one that both have lies in both sets, or, of a choice, in one of them."""
    parameters: dict[Key, core.Parameter] = {(p.name, p.kind): p for p in left.parameters}
    for parameter in right.parameters:
        key = (parameter.name, parameter.kind)
        first = parameters.get(key)
        if first is None:
            parameters[key] = parameter
        elif first.type != parameter.type:
            types = (str(parameter.type), str(first.type))
            raise Wrong(messages.parameter_type(parameter.name, left.name, *types, parameter.span, first.span))
        else:
            how: Literal["inter", "union"] = "union" if name == "choice" else "inter"
            parameters[key] = replace(first, carrier=_common(how, first, parameter))
    return tuple(parameters.values())


def _common(how: Literal["inter", "union"], first: core.Parameter, second: core.Parameter) -> Term:
    same = shape(first.carrier) == shape(second.carrier)
    return first.carrier if same else joined_sets(how, first.carrier, second.carrier)


def joined_sets(operator: Literal["inter", "union"], left: Term, right: Term) -> Term:
    """Two declared sets as one, in an order that does not depend on which of them was declared first."""
    first, second = sorted((left, right), key=lambda term: str(shape(term)))
    return Apply(type=left.type, operator=operator, operands=(first, second), span=left.span)


def closed(box: Box) -> Box:
    """A box that says itself what the families are afterwards in which it changes objects.

    What is said of one object twice must be the same.
    """
    if not box.places:
        return box
    predicates = list(box.predicates)
    span = box.span
    for name in dict.fromkeys(place.name for place in box.places):
        places = [place for place in box.places if place.name == name]
        kind = places[0].type
        after, value = [Variable(type=kind, name=name, role=role, span=span) for role in ("after", "before")]
        moved: Term = value
        for place in places:
            pair = Apply(
                type=core.TupleType((kind.domain, kind.range)), operator="tuple", operands=(place.index, place.value)
            )
            one = Apply(type=kind, operator="function", operands=(pair,), span=span)
            moved = Apply(type=kind, operator="override", operands=(moved, one), span=span)
        for other in places[:-1]:
            there = Apply(type=kind.range, operator="apply", operands=(moved, other.index), span=span)
            predicates.append(Apply(type=BOOL, operator="equal", operands=(there, other.value), span=span))
        predicates.append(Apply(type=BOOL, operator="equal", operands=(after, moved), span=span))
    body: Term = core.conjunction(tuple(predicates), span)
    if box.values:
        true = Constant(type=BOOL, value=True)
        body = core.Quantifier(type=BOOL, kind="exists", binders=box.values, condition=true, body=body, span=span)
    framed = box.framed | {place.name for place in box.places}
    return replace(box, predicates=(body,), places=(), values=(), framed=framed)


def changed(box: Box, change: Callable[[Variable], Term | None]) -> Box:
    """A box with variables replaced in all of its predicates and sets."""
    declared = [substituted(d, change) for d in box.declared]
    return replace(
        box,
        parameters=tuple([replace(p, carrier=substituted(p.carrier, change)) for p in box.parameters]),
        declared=tuple([d for d in declared if isinstance(d, Apply)]),
        predicates=tuple([substituted(p, change) for p in box.predicates]),
        places=tuple(
            [replace(p, index=substituted(p.index, change), value=substituted(p.value, change)) for p in box.places]
        ),
        values=tuple([replace(b, carrier=substituted(b.carrier, change)) for b in box.values]),
    )


def _without(box: Box, key: Key, value: Term) -> Box:
    """A box without one of its parameters, which has a certain value."""
    left = replace(box, parameters=tuple([p for p in box.parameters if (p.name, p.kind) != key]))
    return changed(left, lambda v: value if (v.name, v.role) == key else None)


def _renamed(box: Box, old: core.Parameter, new: core.Parameter) -> Box:
    """A box with another name for a parameter; one that has that name already becomes the same."""
    variable = Variable(type=new.type, name=new.name, role=new.kind, span=new.span)
    carrier = old.carrier
    box = _without(box, (old.name, old.kind), variable)
    other = next((p for p in box.parameters if (p.name, p.kind) == (new.name, new.kind)), None)
    if other is None:
        return replace(box, parameters=(*box.parameters, replace(new, carrier=carrier)))
    if other.type != old.type:
        types = (str(old.type), str(other.type))
        raise Wrong(messages.parameter_type(new.name, box.name, *types, new.span, other.span))
    both = replace(other, carrier=_common("inter", other, old))
    return replace(box, parameters=tuple([both if p is other else p for p in box.parameters]))


def declared_in(parameter: core.Parameter) -> Apply:
    """The predicate that the declaration of a parameter is."""
    variable = Variable(type=parameter.type, name=parameter.name, role=parameter.kind, span=parameter.span)
    return Apply(type=BOOL, operator="in", operands=(variable, parameter.carrier), span=parameter.span)


def _displayed(carrier: s.Term) -> tuple[s.Term, ...] | None:
    """The elements of a set or sequence that is written out; ``ran <a, b>`` has those of the sequence."""
    carrier = s.bare(carrier)
    if isinstance(carrier, s.Operator) and carrier.name == "ran":
        return _displayed(carrier.operands[0])
    return carrier.items if isinstance(carrier, s.Display) and carrier.kind in ("set", "sequence") else None
