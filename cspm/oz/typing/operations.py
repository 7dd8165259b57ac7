"""Operations: the schemas of a class, tied to its channels.

An event has one schema (``c`` or ``com_c``), or a guard and an effect (``enable_c``, ``effect_c``). Other schemas
serve in definitions such as ``op c = A ; B``, which :mod:`~cspcheck.cspm.oz.typing.operation_calculus` unfolds.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import replace

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import Apply, Term, Variable
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.objects import promoted
from cspcheck.cspm.oz.typing.operation_calculus import KINDS, SIGNS, Box, Calculus, Surroundings, closed, declared_in
from cspcheck.cspm.oz.typing.scopes import FailedEntry, ObjectEntry, ParameterEntry, StateEntry, TypingScope, mentioned
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.terms import free_variables, shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

PREFIXES = ("com_", "enable_", "effect_")


class Boxes:
    """The schemas of one class.

    Args:
        tree: the class.
        channels: its channels and methods.
        typing, scope: by which its predicates are read.
        around: its state.
        inherited: the schemas of its parents, by the names of their operations.
        report: told what is wrong.

    Attributes:
        channels: those of the class's channels that its schemas tell more about.
    """

    def __init__(
        self,
        tree: s.Class,
        channels: Mapping[str, core.Channel],
        typing: Typing,
        scope: TypingScope,
        around: Surroundings,
        inherited: Mapping[str, Box],
        report: DiagnosticSink,
    ) -> None:
        self.tree = tree
        self.channels: dict[str, core.Channel] = {}
        self._known = channels
        self._typing = typing
        self._scope = scope
        self._around = around
        self._inherited = inherited
        self._report = report
        self._definitions = {o.name: o for o in tree.operations if isinstance(o, s.OperationDefinition)}
        self._boxes: dict[str, Box] = {}
        self._open: list[str] = []
        self._offered: frozenset[str] = frozenset()
        self._calculus = Calculus(typing, around, self._named, self._in_brackets, self._promoted, report)

    def operations(self, offered: Mapping[str, core.Operation]) -> dict[str, core.Operation]:
        """The operations that the class's own schemas make, by event.

        *offered* are those that it inherits. Of plain Object-Z, operations that a parent keeps to itself and that the
        class makes visible are among the results.
        """
        self._offered = frozenset(offered)
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
            elif operation.name not in used and not self._is_plain:
                self._report(
                    messages.schema_without_channel(operation.name, operation.span, self._near(operation.name))
                )
        found = {}
        for event, schemas in events.items():
            made = self._operation(event, schemas)
            if made is not None:
                found[event] = made
        for name, box in self._inherited.items():
            if name in self._known and name not in offered and name not in found:
                found[name] = self._of_boxes(name, {"com": box})
        for operation in self.tree.operations:
            if operation.name not in self._boxes and (operation.name in used or self._is_plain):
                try:
                    self._made(operation, "effect")
                except Wrong as wrong:
                    self._report(wrong.diagnostic)
        return found

    @property
    def _is_plain(self) -> bool:
        """Whether this is a class of Object-Z without channels, some of whose operations may be its own business."""
        return all(channel.kind == "operation" for channel in self._known.values())

    def boxes(self) -> dict[str, Box]:
        """The schemas of the class, those that it inherits among them, by the names of their operations."""
        found = dict(self._inherited)
        for name, box in self._boxes.items():
            before = found.get(name)
            try:
                found[name] = box if before is None else self._calculus.joined("and", before, box, box.span)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
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
        if event in self._inherited and event not in self._offered and "com" in boxes:
            # What a parent says of an operation of this name that is none of its interface holds beside.
            try:
                boxes["com"] = self._calculus.joined("and", self._inherited[event], boxes["com"], boxes["com"].span)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                return None
        return self._of_boxes(event, boxes)

    def _of_boxes(self, event: str, boxes: dict[str, Box]) -> core.Operation:
        """The operation that the schemas of an event make."""
        if self._known[event].kind == "operation":
            # What is declared without decoration is a variable of the operation alone.
            for role, box in boxes.items():
                local = [(p.name, p.kind) for p in box.parameters if p.kind == "simple"]
                boxes[role] = self._calculus.hidden(box, local)
        boxes = {role: closed(box) for role, box in boxes.items()}
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
        parameters = {(p.name, p.kind): p for p in channel.parameters}
        # An operation of plain Object-Z may have more parameters than that of a parent.
        adopts = channel.kind == "operation" or (channel.kind != "chan" and not channel.parameters)
        for box in boxes.values():
            for parameter in box.parameters:
                key = (parameter.name, parameter.kind)
                # `k?` and `k!` are two variables; on a channel that declares one of them, the other is a mistake.
                named = next((k for k in parameters if k[0] == parameter.name), key)
                key = key if key in parameters or adopts else named
                declared = parameters.get(key)
                if declared is None and adopts:
                    parameters[key] = replace(parameter, carrier=self._calculus.closed_over_states(parameter))
                elif declared is None:
                    near = suggestions(parameter.name, [name for name, _ in parameters])
                    self._report(messages.parameter_not_of_channel(parameter.name, event, parameter.span, near))
                elif declared.type != parameter.type:
                    types = (str(parameter.type), str(declared.type))
                    self._report(messages.parameter_type(parameter.name, event, *types, parameter.span, declared.span))
                elif declared.kind == "simple":
                    parameters[key] = replace(declared, kind=parameter.kind)
                elif declared.kind != parameter.kind:
                    signs = (SIGNS[parameter.kind], SIGNS[declared.kind])
                    self._report(messages.parameter_kind(parameter.name, event, *signs, parameter.span, declared.span))
        channel = replace(channel, parameters=tuple(parameters.values()))
        self.channels[event] = channel
        return channel

    # --- boxes ------------------------------------------------------------------------------------------------

    def _made(self, schema: s.OperationSchema | s.OperationDefinition, place: str) -> Box:
        if isinstance(schema, s.OperationSchema):
            if schema.name not in self._boxes:
                self._boxes[schema.name] = self._box(schema, place, self._scope)
            return self._boxes[schema.name]
        if schema.name in self._boxes:
            return self._boxes[schema.name]
        if schema.name in self._open:
            raise Wrong(messages.operation_cycle([*self._open, schema.name], schema.span))
        self._open.append(schema.name)
        try:
            box = self._calculus.box(schema.body, self._scope)
        finally:
            self._open.pop()
        self._boxes[schema.name] = replace(box, name=schema.name, span=schema.span)
        return self._boxes[schema.name]

    def _named(self, reference: s.Reference) -> Box:
        inherited = self._inherited.get(reference.name)
        for operation in self.tree.operations:
            if operation.name == reference.name:
                own = self._made(operation, "effect")
                if inherited is None:
                    return own
                return self._calculus.joined("and", inherited, own, reference.span)
        if inherited is not None:
            return inherited
        names = [*[operation.name for operation in self.tree.operations], *self._inherited]
        raise Wrong(messages.unknown_operation(reference.name, reference.span, suggestions(reference.name, names)))

    def _in_brackets(self, text: s.OperationText, scope: TypingScope) -> Box:
        schema = s.OperationSchema(
            span=text.span, name="", delta=text.delta, declarations=text.declarations, predicates=text.predicates
        )
        return self._box(schema, "effect", scope)

    def _promoted(self, selection: s.Selection, scope: TypingScope) -> Box:
        found = self._typing.object(selection.record, scope, "effect")
        found = found or self._typing.object_value(selection.record, scope, "effect")
        if found is None:
            raise Wrong(messages.promotion(selection.span))
        return promoted(*found, selection.field, self._calculus, selection.span)

    def _box(self, schema: s.OperationSchema, place: str, scope: TypingScope) -> Box:
        delta = self._delta(schema)
        inner = TypingScope(scope)
        if self._is_plain and schema.name in self._inherited:
            for p in self._inherited[schema.name].parameters:
                if p.kind != "simple":
                    inner.add(p.name, ParameterEntry(p.name, p.kind, p.type, p.span))
        parameters = []
        seen: dict[str, Span] = {}
        included: list[s.Term] = []
        for declaration in schema.declarations:
            if not declaration.names:
                included.append(declaration.carrier)
                continue
            try:
                carrier = self._typing.carrier(declaration.carrier, scope)
            except Wrong as wrong:
                self._report(wrong.diagnostic)
                for name in declaration.names:
                    inner.add(name.name + name.decoration, FailedEntry(wrong.diagnostic))
                continue
            assert isinstance(carrier.type, core.SetType)
            for name in declaration.names:
                written = name.name + name.decoration
                if written in seen:
                    self._report(type_messages.declared_twice(written, seen[written], name.span))
                    continue
                seen[written] = name.span
                kind = KINDS.get(name.decoration, "simple")
                called = written if name.decoration == "'" else name.name  # no state variable: a name of its own
                parameter = core.Parameter(
                    name=called, type=carrier.type.element, carrier=carrier, span=name.span, kind=kind
                )
                parameters.append(parameter)
                inner.add(called, ParameterEntry(called, kind, parameter.type, name.span))
        predicates = []
        for node in included:
            try:
                predicates.append(self._included(node, scope, inner, parameters))
            except Wrong as wrong:
                self._report(wrong.diagnostic)
        for tree in schema.predicates:
            try:
                predicates.append(self._typing.predicate(tree, inner, place))  # type: ignore[arg-type]
            except Wrong as wrong:
                self._report(wrong.diagnostic)
        if place == "effect":
            self._discipline(schema, delta, inner)
        declared = tuple([declared_in(parameter) for parameter in parameters])
        return Box(schema.name, delta, tuple(parameters), declared, tuple(predicates), schema.span)

    def _included(self, node: s.Term, scope: TypingScope, inner: TypingScope, parameters: list[core.Parameter]) -> Term:
        """What an included schema says; components that are no state variables are parameters of the operation."""
        schema = self._typing.schemas.needed(node, scope)
        for field in schema.fields:
            base = field.name.rstrip("'?!")
            kind = KINDS.get(field.name[len(base) :])
            known = any((p.name, p.kind) == (base, kind) for p in parameters)
            if kind is not None and not known and (kind != "simple" or base not in self._around.states):
                parameters.append(
                    core.Parameter(name=base, type=field.type, carrier=field.carrier, span=field.span, kind=kind)
                )
                inner.add(base, ParameterEntry(base, kind, field.type, field.span))
        return self._typing.schemas.predicate(schema, inner, "effect", node.span)

    def _delta(self, schema: s.OperationSchema) -> tuple[str, ...]:
        found = []
        for name in schema.delta or ():
            entry = self._scope.find(name.name)
            if isinstance(entry, FailedEntry):
                continue
            if isinstance(entry, ObjectEntry) and not entry.pool:
                what = f"`{name.name}` in a Delta-list: an object that is exchanged"
                self._report(messages.objects_need_heap(what, name.span))
                continue
            if isinstance(entry, StateEntry) and not entry.secondary:
                found.append(name.name)
                continue
            states = [n for n in self._scope.names() if isinstance(self._scope.find(n), StateEntry)]
            near = suggestions(name.name, [n for n in states if n not in self._around.secondary])
            secondary = isinstance(entry, StateEntry)
            self._report(messages.wrong_in_delta(name.name, name.span, secondary=secondary, suggested=near))
        return tuple(dict.fromkeys(found))

    def _discipline(self, schema: s.OperationSchema, delta: tuple[str, ...], scope: TypingScope) -> None:
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
                    spoken = [n for n in map(self._states_in, self._around.invariant) if listed.name in n]
                    if all(len(names) == 1 for names in spoken):
                        self._report(messages.never_primed(listed.name, listed.span, bounded=bool(spoken)))

    def _states_in(self, term: Term) -> set[str]:
        return {name for name, role in free_variables(term) if role == "before"}


def _subject(declared: Apply) -> Variable:
    """The parameter that a declaration is about."""
    variable = declared.operands[0]
    assert isinstance(variable, Variable)
    return variable


def _beyond(box: Box, channel: core.Channel) -> list[Apply]:
    """The declarations of a schema that say something else than those of the channel do."""
    known: dict[tuple[str, core.Role], Hashable] = {(p.name, p.kind): shape(p.carrier) for p in channel.parameters}
    return [d for d in box.declared if known.get(_key(_subject(d))) not in (None, shape(d.operands[1]))]


def _key(variable: Variable) -> tuple[str, core.Role]:
    return variable.name, variable.role


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
        left = s.bare(left)
        if isinstance(left, s.Reference) and left.decoration == "":
            yield left.name, term.span


def inherited_operations(
    inherited: Mapping[str, core.Operation], own: Mapping[str, core.Operation], report: DiagnosticSink
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
