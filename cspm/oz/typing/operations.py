"""Operations: the schemas of a class, tied to its channels.

An event has one schema (``c`` or ``com_c``), or a guard and an effect (``enable_c``, ``effect_c``). Other schemas
serve in definitions such as ``op c = A ; B``, which are unfolded here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Literal

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import BOOL, Apply, Constant, Term, Variable
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.scopes import FailedEntry, ParameterEntry, Scope, StateEntry, mentioned
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import renamed_variables
from cspcheck.cspm.oz.values.terms import free_variables, shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

Report = Callable[[Diagnostic], None]
PREFIXES = ("com_", "enable_", "effect_")


@dataclass(frozen=True)
class Box:
    """A schema by itself: what it may change, its parameters, its predicates.

    ``declared`` are the predicates that its declarations are: each parameter is in the set that it is declared with.
    They are kept apart from the others because most only repeat what the channel says.
    """

    name: str
    delta: tuple[str, ...]
    parameters: tuple[core.Parameter, ...]
    declared: tuple[Apply, ...]
    predicates: tuple[Term, ...]
    span: Span


class Boxes:
    """The schemas of one class.

    Attributes:
        channels: those of the class's channels that its schemas tell more about.
    """

    def __init__(
        self,
        tree: s.Class,
        channels: Mapping[str, core.Channel],
        typing: Typing,
        scope: Scope,
        states: Mapping[str, core.Declared],
        secondary: set[str],
        invariant: Sequence[Term],
        report: Report,
    ) -> None:
        self.tree = tree
        self.channels: dict[str, core.Channel] = {}
        self._known = channels
        self._typing = typing
        self._scope = scope
        self._states = states
        self._secondary = secondary
        self._invariant = invariant
        self._report = report
        self._definitions = {o.name: o for o in tree.operations if isinstance(o, s.OperationDefinition)}
        self._boxes: dict[str, Box] = {}
        self._open: list[str] = []
        self._fresh = count(1)

    def operations(self) -> dict[str, core.Operation]:
        """The operations that the class's own schemas make, by event."""
        used = {
            reference.name for definition in self._definitions.values() for reference in mentioned([definition.body])
        }
        events: dict[str, list[tuple[str, s.OperationSchema | s.OperationDefinition]]] = {}
        seen: dict[str, Span] = {}
        for operation in self.tree.operations:
            if operation.name in seen:
                self._report(type_messages.declared_twice(operation.name, seen[operation.name], operation.span))
                continue
            seen[operation.name] = operation.span
            event, role = self._event(operation.name)
            if event is not None:
                events.setdefault(event, []).append((role, operation))
            elif operation.name not in used:
                self._report(
                    messages.schema_without_channel(operation.name, operation.span, self._near(operation.name))
                )
        found = {}
        for event, schemas in events.items():
            made = self._operation(event, schemas)
            if made is not None:
                found[event] = made
        for operation in self.tree.operations:
            if (
                isinstance(operation, s.OperationSchema)
                and operation.name not in self._boxes
                and operation.name in used
            ):
                self._box(operation, "effect")
        return found

    def _event(self, name: str) -> tuple[str | None, str]:
        if name in self._known:
            return name, "com"
        for prefix in PREFIXES:
            if name.startswith(prefix) and name[len(prefix) :] in self._known:
                return name[len(prefix) :], prefix[:-1]
        return None, ""

    def _near(self, name: str) -> tuple[str, ...]:
        prefix = next((p for p in PREFIXES if name.startswith(p)), "")
        return tuple([prefix + near for near in suggestions(name[len(prefix) :], self._known)])

    # --- one event --------------------------------------------------------------------------------------------

    def _operation(
        self, event: str, schemas: list[tuple[str, s.OperationSchema | s.OperationDefinition]]
    ) -> core.Operation | None:
        roles: dict[str, s.OperationSchema | s.OperationDefinition] = {}
        for role, schema in schemas:
            other = next((o for r, o in roles.items() if "com" in (role, r) or r == role), None)
            if other is not None:
                self._report(messages.schemas_clash(event, other.name, schema.name, schema.span, other.span))
                return None
            roles[role] = schema
        boxes: dict[str, Box] = {}
        for role, schema in roles.items():
            try:
                boxes[role] = self._made(schema, "guard" if role == "enable" else "effect")
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                return None
        channel = self._channel(event, boxes)
        guard = boxes.get("enable")
        effect = boxes.get("com") or boxes.get("effect")
        if "com" in boxes:
            form = "com"
        elif effect is None:
            form = "enable"
        else:
            form = "guarded" if guard is not None else "effect"
        delta = dict.fromkeys(name for box in boxes.values() for name in box.delta)
        asked: list[Term] = []
        done: list[Term] = []
        if guard is not None:
            declared = _beyond(guard, channel)
            asked += [*[d for d in declared if _subject(d).role != "output"], *guard.predicates]
            done += [d for d in declared if _subject(d).role == "output"]
        if effect is not None:
            done += [*_beyond(effect, channel), *effect.predicates]
        return core.Operation(
            name=event,
            form=form,  # type: ignore[arg-type]
            parameters=channel.parameters,
            delta=tuple(delta),
            guard=tuple(asked),
            effect=tuple(done),
            spans=tuple([box.span for box in boxes.values()]),
        )

    def _channel(self, event: str, boxes: Mapping[str, Box]) -> core.Channel:
        """The channel of an event, with what the schemas say of its parameters."""
        channel = self._known[event]
        parameters = {p.name: p for p in channel.parameters}
        adopts = channel.kind != "chan" and not channel.parameters
        for box in boxes.values():
            for parameter in box.parameters:
                declared = parameters.get(parameter.name)
                if declared is None and adopts:
                    parameters[parameter.name] = replace(parameter, carrier=self._closed(parameter))
                elif declared is None:
                    near = suggestions(parameter.name, parameters)
                    self._report(messages.parameter_not_of_channel(parameter.name, event, parameter.span, near))
                elif declared.type != parameter.type:
                    types = (str(parameter.type), str(declared.type))
                    self._report(messages.parameter_type(parameter.name, event, *types, parameter.span, declared.span))
                elif declared.kind == "simple":
                    parameters[parameter.name] = replace(declared, kind=parameter.kind)
                elif declared.kind != parameter.kind:
                    signs = (_SIGNS[parameter.kind], _SIGNS[declared.kind])
                    self._report(messages.parameter_kind(parameter.name, event, *signs, parameter.span, declared.span))
        channel = replace(channel, parameters=tuple(parameters.values()))
        self.channels[event] = channel
        return channel

    def _closed(self, parameter: core.Parameter) -> Term:
        """The set that a parameter is declared with, for any state: what the fields of its channel carry."""
        used = {name for name, role in free_variables(parameter.carrier) if role == "before"}
        if not used:
            return parameter.carrier
        table: dict[str, Variable] = {}
        binders: list[core.Binder] = []
        for name in [name for name in self._states if name in used]:
            declared = self._states[name]
            binders.append(self._bound(name, declared.type, declared.carrier))
            table[name] = Variable(type=declared.type, name=binders[-1].name, role="bound", span=parameter.span)
        carrier = renamed_variables(parameter.carrier, "before", table)
        binders.append(self._bound(parameter.name, parameter.type, carrier))
        value = Variable(type=parameter.type, name=binders[-1].name, role="bound", span=parameter.span)
        return core.Comprehension(
            type=core.SetType(parameter.type),
            kind="set",
            binders=tuple(binders),
            condition=Constant(type=BOOL, value=True),
            body=value,
            span=parameter.carrier.span,
        )

    def _bound(self, name: str, type_: core.Type, carrier: Term) -> core.Binder:
        """A binder with a name of its own."""
        return core.Binder(f"{name}%{self.tree.name}%{next(self._fresh)}", type_, carrier, name)

    # --- boxes ------------------------------------------------------------------------------------------------

    def _made(self, schema: s.OperationSchema | s.OperationDefinition, place: str) -> Box:
        if isinstance(schema, s.OperationSchema):
            return self._box(schema, place)
        if schema.name in self._open:
            raise Wrong(messages.operation_cycle([*self._open, schema.name], schema.span))
        self._open.append(schema.name)
        try:
            box = self._defined(schema.body)
        finally:
            self._open.pop()
        return replace(box, name=schema.name, span=schema.span)

    def _box(self, schema: s.OperationSchema, place: str) -> Box:
        if schema.name in self._boxes:
            return self._boxes[schema.name]
        delta = self._delta(schema)
        inner = Scope(self._scope)
        parameters = []
        seen: dict[str, Span] = {}
        for declaration in schema.declarations:
            try:
                carrier = self._typing.carrier(declaration.carrier, self._scope)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                for name in declaration.names:
                    inner.add(name.name + name.decoration, FailedEntry(wrong.diagnostic))
                continue
            assert isinstance(carrier.type, core.SetType)
            for name in declaration.names:
                if name.name in seen:
                    self._report(type_messages.declared_twice(name.name, seen[name.name], name.span))
                    continue
                seen[name.name] = name.span
                kind = _KINDS.get(name.decoration, "simple")
                parameter = core.Parameter(
                    name=name.name, type=carrier.type.element, carrier=carrier, span=name.span, kind=kind
                )
                parameters.append(parameter)
                inner.add(name.name, ParameterEntry(name.name, kind, parameter.type, name.span))
        predicates = []
        for tree in schema.predicates:
            try:
                predicates.append(self._typing.predicate(tree, inner, place))  # type: ignore[arg-type]
            except Wrong as wrong:
                self._report(wrong.diagnostic)
        if place == "effect":
            self._discipline(schema, delta, inner)
        declared = tuple([_declared(parameter) for parameter in parameters])
        box = Box(schema.name, delta, tuple(parameters), declared, tuple(predicates), schema.span)
        self._boxes[schema.name] = box
        return box

    def _delta(self, schema: s.OperationSchema) -> tuple[str, ...]:
        found = []
        for name in schema.delta or ():
            entry = self._scope.find(name.name)
            if isinstance(entry, FailedEntry):
                continue
            if isinstance(entry, StateEntry) and not entry.secondary:
                found.append(name.name)
                continue
            states = [n for n in self._scope.names() if isinstance(self._scope.find(n), StateEntry)]
            near = suggestions(name.name, [n for n in states if n not in self._secondary])
            secondary = isinstance(entry, StateEntry)
            self._report(messages.wrong_in_delta(name.name, name.span, secondary=secondary, suggested=near))
        return tuple(dict.fromkeys(found))

    def _discipline(self, schema: s.OperationSchema, delta: tuple[str, ...], scope: Scope) -> None:
        """What primes and the Delta-list say of each other."""
        primed: dict[str, Span] = {}
        for reference in mentioned(schema.predicates):
            if reference.decoration == "'":
                primed.setdefault(reference.name, reference.span)
        for name, span in primed.items():
            entry = scope.find(name)
            if isinstance(entry, StateEntry) and not entry.secondary and name not in delta:
                self._report(messages.not_in_delta(name, span, schema.span if schema.delta is None else None))
        forgotten = set()
        for branch in branches(schema.predicates):
            changed = {r.name for r in mentioned(branch) if r.decoration == "'"}
            for term in branch:
                for name, span in _equations(term):
                    if name in delta and name not in changed:
                        forgotten.add(name)
                        self._report(messages.forgotten_prime(name, span))
        if schema.predicates:
            # An operation about which nothing is said is a black box; one about which something is said is not.
            for listed in schema.delta or ():
                if listed.name in delta and listed.name not in primed and listed.name not in forgotten:
                    spoken = [n for n in map(self._states_in, self._invariant) if listed.name in n]
                    if all(len(names) == 1 for names in spoken):
                        self._report(messages.never_primed(listed.name, listed.span, bounded=bool(spoken)))

    def _states_in(self, term: Term) -> set[str]:
        return {name for name, role in free_variables(term) if role == "before"}

    # --- expressions over operations --------------------------------------------------------------------------

    def _defined(self, body: s.Term) -> Box:
        match body:
            case s.Grouped():
                return self._defined(body.inner)
            case s.Reference():
                return self._named(body)
            case s.Operator(name="and" | "choice" | "compose" as name, operands=operands):
                boxes = [self._defined(operand) for operand in operands]
                result = boxes[0]
                for box in boxes[1:]:
                    result = self._joined(name, result, box, body.span)
                return result
            case s.Operator(name=name):
                raise Wrong(messages.operation_expression(_WRITTEN.get(name, name), body.span))
        raise Wrong(messages.operation_expression("this", body.span))

    def _named(self, reference: s.Reference) -> Box:
        for operation in self.tree.operations:
            if operation.name == reference.name:
                return self._made(operation, "effect")
        names = [operation.name for operation in self.tree.operations]
        raise Wrong(messages.unknown_operation(reference.name, reference.span, suggestions(reference.name, names)))

    def _joined(self, name: str, left: Box, right: Box, span: Span) -> Box:
        delta = tuple(dict.fromkeys((*left.delta, *right.delta)))
        parameters = {p.name: p for p in left.parameters}
        for parameter in right.parameters:
            first = parameters.get(parameter.name)
            if first is None:
                parameters[parameter.name] = parameter
            elif (first.type, first.kind) != (parameter.type, parameter.kind):
                types = (str(parameter.type), str(first.type))
                raise Wrong(messages.parameter_type(parameter.name, name, *types, parameter.span, first.span))
            elif shape(first.carrier) != shape(parameter.carrier):
                how: Literal["inter", "union"] = "union" if name == "choice" else "inter"
                parameters[parameter.name] = replace(first, carrier=joined_sets(how, first.carrier, parameter.carrier))
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
            predicates = (self._sequence(left, second, delta, span),)
        return Box(name, delta, tuple(parameters.values()), declared, predicates, span)

    def _kept(self, delta: tuple[str, ...], box: Box) -> Iterator[Term]:
        """That variables of a joint Delta-list which one operation does not change keep their values."""
        for name in delta:
            if name not in box.delta:
                after, before = self._state(name, "after", box.span), self._state(name, "before", box.span)
                yield Apply(type=BOOL, operator="equal", operands=(after, before), span=box.span)

    def _state(self, name: str, role: core.Role, span: Span) -> Variable:
        entry = self._scope.find(name)
        assert isinstance(entry, StateEntry)
        return Variable(type=entry.type, name=name, role=role, span=span)

    def _sequence(self, left: Box, right: Box, delta: tuple[str, ...], span: Span) -> Term:
        """One operation, then the other, by way of a state between them that satisfies the invariant."""
        middle = {}
        binders = []
        between = [*delta, *sorted(self._secondary)]
        for name in between:
            declared = self._states[name]
            binders.append(self._bound(name, declared.type, declared.carrier))
            middle[name] = Variable(type=declared.type, name=binders[-1].name, role="bound", span=span)
        first = [renamed_variables(p, "after", middle) for p in (*left.predicates, *self._kept(delta, left))]
        holds = [renamed_variables(p, "before", middle) for p in self._invariant]
        second = [renamed_variables(p, "before", middle) for p in (*right.predicates, *self._kept(delta, right))]
        return core.Quantifier(
            type=BOOL,
            kind="exists",
            binders=tuple(binders),
            condition=core.conjunction(tuple(holds), span),
            body=core.conjunction((*first, *second), span),
            span=span,
        )


def _declared(parameter: core.Parameter) -> Apply:
    """The predicate that the declaration of a parameter is."""
    variable = Variable(type=parameter.type, name=parameter.name, role=parameter.kind, span=parameter.span)
    return Apply(type=BOOL, operator="in", operands=(variable, parameter.carrier), span=parameter.span)


def _subject(declared: Apply) -> Variable:
    """The parameter that a declaration is about."""
    variable = declared.operands[0]
    assert isinstance(variable, Variable)
    return variable


def _beyond(box: Box, channel: core.Channel) -> list[Apply]:
    """The declarations of a schema that say something else than those of the channel do."""
    known = {p.name: shape(p.carrier) for p in channel.parameters}
    return [d for d in box.declared if known.get(_subject(d).name) not in (None, shape(d.operands[1]))]


def joined_sets(operator: Literal["inter", "union"], left: Term, right: Term) -> Term:
    """Two declared sets as one, in an order that does not depend on which of them was declared first."""
    first, second = sorted((left, right), key=lambda term: str(shape(term)))
    return Apply(type=left.type, operator=operator, operands=(first, second), span=left.span)


_SIGNS = {"input": "?", "output": "!", "simple": ""}
_KINDS: dict[str, core.ParameterKind] = {"?": "input", "!": "output", "": "simple"}
_WRITTEN = {"parallel": "||", "hide": "\\", "enrich": "@"}


def branches(predicates: tuple[s.Term, ...]) -> list[list[s.Term]]:
    """The ways through predicates: each alternative of an ``or`` and of a conditional, each consequence, by itself.

    The conjuncts of one predicate at the top stand together with those of the others.
    """
    common: list[s.Term] = []
    split: list[list[s.Term]] = []
    for predicate in predicates:
        ways = _ways(predicate)
        if len(ways) == 1:
            common.extend(ways[0])
        else:
            split.extend(ways)
    return [[*common, *way] for way in split] if split else [common]


def _ways(term: s.Term) -> list[list[s.Term]]:
    match term:
        case s.Grouped():
            return _ways(term.inner)
        case s.Operator(name="or", operands=operands):
            return [way for operand in operands for way in _ways(operand)]
        case s.Operator(name="and", operands=operands):
            joined: list[list[s.Term]] = [[]]
            for operand in operands:
                ways = _ways(operand)
                if len(joined) * len(ways) > 64:
                    joined = [[*way, operand] for way in joined]
                else:
                    joined = [[*way, *more] for way in joined for more in ways]
            return joined
        case s.Operator(name="implies", operands=(_, consequence)):
            return [*_ways(consequence), []]
        case s.Conditional():
            return [*_ways(term.then), *_ways(term.otherwise)]
    return [[term]]


def _equations(term: s.Term) -> Iterator[tuple[str, Span]]:
    """Equations ``x = e`` for an unprimed name x at the top of a conjunct."""
    if isinstance(term, s.Chain) and term.relations == ("equal",):
        left = term.operands[0]
        while isinstance(left, s.Grouped):
            left = left.inner
        if isinstance(left, s.Reference) and left.decoration == "":
            yield left.name, term.span


def inherited_operations(
    inherited: Mapping[str, core.Operation], own: Mapping[str, core.Operation], report: Report
) -> dict[str, core.Operation]:
    """The operations of a parent with those of a child; schemas of one event are conjoined."""
    joined = dict(inherited)
    for event, operation in own.items():
        before = joined.get(event)
        if before is None or before == operation:
            joined[event] = operation
            continue
        if {before.form, operation.form} not in ({"com"}, {"guarded"}, {"effect"}, {"enable"}) and (
            "com" in (before.form, operation.form)
        ):
            spans = (operation.spans[0], before.spans[0] if before.spans else None)
            report(messages.schemas_clash(event, before.form, operation.form, *spans))
            continue
        guarded = bool({before.form, operation.form} & {"guarded", "enable"})
        effective = bool({before.form, operation.form} & {"guarded", "effect", "com"})
        form = operation.form
        if form != "com":
            form = "guarded" if guarded and effective else "enable" if guarded else "effect"
        parameters = {p.name: p for p in (*before.parameters, *operation.parameters)}
        joined[event] = core.Operation(
            name=event,
            form=form,
            parameters=tuple(parameters.values()),
            delta=tuple(dict.fromkeys((*before.delta, *operation.delta))),
            guard=(*before.guard, *[g for g in operation.guard if g not in before.guard]),
            effect=(*before.effect, *[e for e in operation.effect if e not in before.effect]),
            spans=(*before.spans, *operation.spans),
        )
    return joined
