r"""What the data part of a class does: from its states and operations to process terms.

In a state, each operation offers the events for which it has an effect; the environment chooses inputs and simple
parameters, the class chooses outputs and after-states (Fischer 2000). As a term, with s for a state::

    OZ      = |~| s : initial states @ OZ(s)
    OZ(s)   = [] op, in @ |~| out @ op.in.out -> |~| s' @ OZ(s')

The after-state is chosen behind the event: that has the same failures and divergences as choosing it before, and a
sum of choices in place of their product. With angelic outputs the environment chooses those too. An operation with a
guard whose effect is impossible diverges once it is performed.

Where a value that an operation demands lies in its carrier but outside the finite reading of that, the search does
not go on: the term is :class:`~cspcheck.cspm.process.terms.Beyond`, and no verdict that depends on it is given.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from operator import itemgetter
from typing import Any, Protocol

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, ClassModel, Term, Variable
from cspcheck.cspm.oz.processes import messages as messages
from cspcheck.cspm.oz.values.carriers import Frame
from cspcheck.cspm.oz.values.enumeration import Member, enumeration, membership
from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator
from cspcheck.cspm.oz.values.readings import written
from cspcheck.cspm.oz.values.solving import SolutionPlan, SoughtVariable, solver
from cspcheck.cspm.oz.values.terms import conjuncts, free_variables, mapped, shape
from cspcheck.cspm.oz.values.values import show, show_assignment
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    Beyond,
    ExternalChoice,
    InternalChoice,
    Prefix,
    Process,
    Reference,
)
from cspcheck.cspm.values.failure import Failure

StateValues = tuple[Any, ...]
"""The values of the state variables, primary ones first, in the order of declaration."""


class Alphabet(Protocol):
    """The events of a class, by channel and the values of its parameters."""

    def event(self, channel: str, values: tuple[Any, ...]) -> int | None:
        """The number of an event; None if a value is outside what the channel carries."""

    def values(self, channel: str) -> Sequence[Sequence[Any]] | None:
        """What each field of the channel carries; None if a field has infinitely many values."""


class DataPart:
    """The data part of one class.

    Args:
        evaluator: of the class.
        model: the class.
        alphabet: the events of its channels.
        angelic: whether the environment chooses outputs.
        name: what states are called in explanations.
    """

    def __init__(
        self,
        evaluator: TermEvaluator,
        model: ClassModel,
        alphabet: Alphabet,
        *,
        angelic: bool = False,
        name: str | None = None,
    ) -> None:
        self.evaluator = evaluator
        self.model = model
        self.alphabet = alphabet
        self.name = name or model.name
        self.angelic = angelic
        self.variables = (*model.primary, *model.secondary)
        self._types = {variable.name: variable.type for variable in self.variables}
        self.done: int | None = None
        """The event by which the data part agrees to terminate, in every state; None if it never has to."""
        self.visited: dict[StateValues, None] = {}
        """The states that have been looked at, in that order."""
        self._alike: dict[Process, dict[StateValues, None]] = {}
        """The states that have been looked at by what they can do."""
        self._operations: list[OperationPlan] | None = None

    @property
    def operations(self) -> list[OperationPlan]:
        """The operations, planned when a state is first looked at."""
        if self._operations is None:
            self._operations = [OperationPlan(self, operation) for operation in self.model.operations.values()]
        return self._operations

    # --- states --------------------------------------------------------------------------------------------------

    def initial_states(self) -> tuple[list[StateValues], list[Process]]:
        """The states that INIT and the invariant allow, in order, and what is beyond the finite readings.

        Raises:
            Failure: there is none at all.
        """
        scope = FrameScope((variable.name, "before") for variable in self.variables)
        unknowns = [SoughtVariable(v.name, "before", v.carrier, v.span) for v in self.variables]
        predicates = (*(self.model.initial or ()), *self.model.invariant)
        found = solver(self.evaluator, scope, unknowns, predicates)
        found.use_readings(self.evaluator)
        leaving = self._leaving(scope, self.variables, "before")
        take_state = _picker([scope.slot(*unknown.key) for unknown in unknowns])
        states: dict[StateValues, None] = {}
        beyond: dict[Process, None] = {}

        def take(frame: Frame) -> bool:
            left = leaving(frame)
            if left is None:
                states[take_state(frame)] = None
            else:
                beyond[Beyond(f"class `{self.name}` begins with {left}")] = None
            return False

        found.run(scope.frame(), take)
        if not states and not beyond:
            raise Failure(messages.no_initial_state(self.name, None, self.model.span))
        return list(states), list(beyond)

    def initial(self) -> Process:
        """The data part at its start."""
        states, beyond = self.initial_states()
        return choice([*map(self.reference, states), *beyond])

    def reference(self, state: StateValues) -> Reference:
        """The data part in a state, as a name."""
        return Reference((self, state), _StateDefinition(self, state))

    def text(self, state: StateValues) -> str:
        """A state as a person would write it."""
        if not self.variables:
            return self.name
        return f"{self.name}({show_assignment(self._types, state)})"

    def term(self, state: StateValues) -> Process:
        """What the data part does in a state.

        Raises:
            Failure: an operation's predicate has no truth value, or an infinite set would have to be gone through.
        """
        term = self._term(state)
        self._alike.setdefault(term, {})[state] = None
        return term

    def variables_of(self, state: StateValues) -> dict[str, str]:
        """The variables of a state by name; of states that can do the same only those that are the same in all.

        A state that is reached is known by what it can do, so of such states nobody can tell which it is.
        """
        alike = self._alike.get(self.reference(state).body(), {state: None})
        common = [(v, state[i]) for i, v in enumerate(self.variables) if len({other[i] for other in alike}) == 1]
        return {v.name: show(value, v.type) for v, value in common}

    def _term(self, state: StateValues) -> Process:
        self.visited[state] = None
        branches: dict[int, Process] = {}
        operands: list[Process] = []
        for operation in self.operations:
            operation.offer(state, branches, operands)
        if self.done is not None:
            branches[self.done] = SKIP
        if branches:
            operands.insert(0, Prefix(tuple(sorted(branches.items(), key=itemgetter(0)))))
        if not operands:
            return STOP
        operands.sort(key=lambda operand: not isinstance(operand, Beyond))  # to be seen in the state's text
        return operands[0] if len(operands) == 1 else ExternalChoice(tuple(operands))

    def _leaving(
        self, scope: FrameScope, variables: Sequence[core.Declared], role: core.Role
    ) -> Callable[[Frame], str | None]:
        """Which of the variables is outside its finite reading, and its value; None if none is."""
        tests: list[tuple[core.Declared, int, Member, str]] = []
        for variable in variables:
            way = enumeration(self.evaluator, variable.carrier, scope)
            if way.readings:
                self.evaluator.readings.use(way.readings)
                test = membership(self.evaluator, variable.carrier, scope, reading=True)
                text = ", ".join(f"`{written(reading)}`" for reading in way.readings)
                tests.append((variable, scope.slot(variable.name, role), test, text))
        prime = "'" if role == "after" else ""

        def leaving(frame: Frame) -> str | None:
            for variable, slot, test, text in tests:
                if not test(frame, frame[slot]):
                    self.evaluator.has_left = True
                    value = show(frame[slot], variable.type)
                    return f"{variable.name}{prime} = {value}, outside the reading {text}"
            return None

        return leaving if tests else _staying


def _staying(frame: Frame) -> None:
    return None


def choice(operands: Sequence[Process]) -> Process:
    """An internal choice; of one it is that."""
    return operands[0] if len(operands) == 1 else InternalChoice(tuple(operands))


class _StateDefinition(Definition):
    """What the reference to a state needs."""

    __slots__ = ("part", "state")

    def __init__(self, part: DataPart, state: StateValues) -> None:
        self.part = part
        self.state = state
        self.span = part.model.span

    @property
    def text(self) -> str:
        """The class with its state."""
        return self.part.text(self.state)

    @property
    def name(self) -> str:
        """The class."""
        return self.part.name

    @property
    def variables(self) -> Mapping[str, str]:
        """The variables of the class in this state."""
        return self.part.variables_of(self.state)

    def evaluate(self) -> Process:
        """The term of the state."""
        try:
            return self.part.term(self.state)
        except Failure as failure:
            failure.at(self.span)
            failure.called(lambda: self.text, None)
            raise failure.finished() from None


def _picker(slots: Sequence[int]) -> Callable[[Frame], tuple[Any, ...]]:
    """The values of some slots as a tuple."""
    if not slots:
        return lambda frame: ()
    if len(slots) == 1:
        (only,) = slots
        return lambda frame: (frame[only],)
    return itemgetter(*slots)


# --- operations ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Parameter:
    """A parameter as the operation sees it: its place among the fields of the event, and how it is chosen."""

    name: str
    kind: core.ParameterKind
    type: core.Type
    carrier: Term
    channel_carrier: Term
    span: Any

    @property
    def unknown(self) -> SoughtVariable:
        return SoughtVariable(self.name, self.kind, self.carrier, self.span)


Outcomes = dict[tuple[Any, ...], dict[tuple[Any, ...], dict[Process, None]]]
"""By the values of inputs and simple parameters, by those of all parameters: what may follow."""


class OperationPlan:
    """One operation with the plans by which its effects are found.

    Attributes:
        inputs, outputs: parameters that the environment chooses, simple ones included, and that the class chooses.
        ends: the variables that may change, afterwards.
        total: whether it is possible wherever its guard holds.
        guards: the guard of a total operation.
        predicates: what the outcomes satisfy; of an operation that is not total, its guard as well.
    """

    def __init__(self, part: DataPart, operation: core.Operation) -> None:
        self.part = part
        self.operation = operation
        self.channel = part.model.channels[operation.name]
        self.parameters = [_parameter(p, operation) for p in self.channel.parameters]
        self.total = operation.form in ("guarded", "effect")
        evaluator = part.evaluator
        model = part.model
        changing = {*operation.delta, *[v.name for v in model.secondary]}
        self.scope = scope = FrameScope((variable.name, "before") for variable in part.variables)
        self.changed = [variable for variable in part.variables if variable.name in changing]

        def settled(term: Term) -> Term:
            """The term, in which what does not change is said of the state before."""
            return mapped(
                term,
                lambda v: replace(v, role="before") if v.role == "after" and v.name not in changing else v,
            )

        def afterwards(term: Term) -> Term:
            return mapped(
                term,
                lambda v: replace(v, role="after") if v.role == "before" and v.name in changing else v,
            )

        invariant = [afterwards(term) for term in conjuncts(model.invariant)]
        # What speaks of nothing that changes held before.
        invariant = [term for term in invariant if any(role == "after" for _, role in free_variables(term))]
        carried = [p.carried for p in map(_Carried, self.parameters) if p.carried is not None]
        effect = [*map(settled, operation.effect), *carried]
        ends = self.ends = [SoughtVariable(v.name, "after", afterwards(v.carrier), v.span) for v in self.changed]
        outputs = self.outputs = [p.unknown for p in self.parameters if p.kind == "output"]
        inputs = self.inputs = [p.unknown for p in self.parameters if p.kind != "output"]
        self.guard: SolutionPlan | None = None
        self.guards: list[Term] = []
        if self.total:
            self.guards = [*operation.guard, *[t for t in carried if _about(t, inputs)]]
            self.guard = solver(evaluator, scope, inputs, self.guards)
            unknowns, predicates = [*outputs, *ends], [*effect, *invariant]
        else:
            unknowns, predicates = [*inputs, *outputs, *ends], [*operation.guard, *effect, *invariant]
        self.predicates = predicates
        self.solver = solver(evaluator, scope, unknowns, predicates)
        for plan in (self.guard, self.solver):
            if plan is not None:
                plan.use_readings(evaluator)
        self.relaxed = self._relaxed(inputs, predicates)
        self._leaving = part._leaving(scope, self.changed, "after")
        self._inputs = _picker([scope.slot(*unknown.key) for unknown in inputs])
        self._input_slots = [scope.slot(*unknown.key) for unknown in inputs]
        self._fields = _picker([scope.slot(p.name, p.kind) for p in self.parameters])
        self._after = _picker([scope.slot(v.name, "after" if v in self.changed else "before") for v in part.variables])
        self._frame = scope.frame()
        self._variables = len(part.variables)
        self._events: dict[tuple[Any, ...], int | None] = {}
        self._free_outputs = bool(outputs)

    def _relaxed(self, inputs: Sequence[SoughtVariable], predicates: Sequence[Term]) -> SolutionPlan | None:
        """Finds the inputs that nothing speaks against but what is said of variables tried from a finite reading.

        None where no output or after-value is: then an operation without an outcome is certainly refused.
        """
        sampled = {unknown.key for unknown, _ in self.solver.sampled if unknown.role not in ("input", "simple")}
        if not sampled:
            return None
        known = [] if self.total else list(inputs)
        surely = [
            term
            for term in conjuncts(predicates)
            if not any(role in ("after", "output") for _, role in free_variables(term))
        ]
        return solver(self.part.evaluator, self.scope, known, surely)

    # --- what it offers in a state -------------------------------------------------------------------------------

    def offer(self, state: StateValues, branches: dict[int, Process], operands: list[Process]) -> None:
        """Add what the operation offers in a state to *branches* (events with what follows) and *operands*."""
        self.part.evaluator.begin()
        frame = self._frame
        missing = len(self.scope.slots) - len(frame)
        if missing > 0:
            frame.extend([None] * missing)
        frame[: self._variables] = state
        outcomes: Outcomes = {}
        if self.guard is None:
            self.solver.run(frame, lambda frame: self._take(frame, outcomes))
            if self.relaxed is not None:
                self._doubt(frame, outcomes, operands)
        else:
            self._guarded(frame, outcomes, branches, operands)
        for by_fields in outcomes.values():
            self._offered(by_fields, branches, operands)

    def _take(self, frame: Frame, outcomes: Outcomes) -> bool:
        """Note a solution."""
        left = self._leaving(frame)
        after: Process
        if left is None:
            after = self.part.reference(self._after(frame))
        else:
            after = Beyond(f"`{self.operation.name}` of class `{self.part.name}` leads to {left}")
        outcomes.setdefault(self._inputs(frame), {}).setdefault(self._fields(frame), {})[after] = None
        return False

    def _doubt(self, frame: Frame, outcomes: Outcomes, operands: list[Process]) -> None:
        """Where no outcome was found because a finite reading may have been too small, nothing is known."""
        assert self.relaxed is not None
        doubtful: list[Process] = []

        def take(frame: Frame) -> bool:
            if self._inputs(frame) in outcomes:
                return False
            doubtful.append(self._perhaps())
            return True

        self.relaxed.run(frame, take)
        operands.extend(doubtful)

    def _perhaps(self) -> Process:
        """Something that the operation might do with a value that was not tried."""
        self.part.evaluator.has_left = True
        unknown = next(u for u, _ in self.solver.sampled if u.role not in ("input", "simple"))
        return Beyond(
            f"`{self.operation.name}` of class `{self.part.name}` has no `{unknown.written}` within the reading that "
            "was tried, and may have one outside"
        )

    def _guarded(self, frame: Frame, outcomes: Outcomes, branches: dict[int, Process], operands: list[Process]) -> None:
        assert self.guard is not None
        enabled: dict[tuple[Any, ...], None] = {}

        def take(frame: Frame) -> bool:
            enabled[self._inputs(frame)] = None
            return False

        self.guard.run(frame, take)
        for values in enabled:
            for slot, value in zip(self._input_slots, values, strict=True):
                frame[slot] = value
            self.solver.run(frame, lambda frame: self._take(frame, outcomes))
            if values not in outcomes:
                if self.relaxed is not None and self.relaxed.run(frame, lambda frame: True):
                    operands.append(self._perhaps())
                else:
                    self._diverge(values, branches, operands)

    def _diverge(self, inputs: tuple[Any, ...], branches: dict[int, Process], operands: list[Process]) -> None:
        """The guard holds and there is no effect: performing the event with these inputs diverges.

        Which outputs it has is the class's choice as always, so that whatever has an effect refines it.
        """
        domains = self.part.alphabet.values(self.operation.name) if self._free_outputs else ()
        if domains is None:
            operands.append(DIV)
            return
        given = iter(inputs)
        fixed: list[Sequence[Any]] = []
        for position, parameter in enumerate(self.parameters):
            fixed.append(domains[position] if parameter.kind == "output" else (next(given),))
        found = (self._event(fields) for fields in product(*fixed))
        numbers = [number for number in found if number is not None]
        if self.part.angelic or len(numbers) == 1:
            branches |= dict.fromkeys(numbers, DIV)
        elif numbers:
            operands.append(choice([Prefix(((number, DIV),)) for number in numbers]))

    def _offered(
        self,
        by_fields: dict[tuple[Any, ...], dict[Process, None]],
        branches: dict[int, Process],
        operands: list[Process],
    ) -> None:
        """What is offered for one choice of inputs: one event, or several among which the class chooses."""
        choices: list[Process] = []
        alone = self.part.angelic or len(by_fields) == 1
        for fields, after in by_fields.items():
            number = self._event(fields)
            if number is None:
                if self._free_outputs and not self._input_outside(fields):
                    choices.append(self._outside(fields))
                continue
            follows = choice(list(after))
            if alone:
                branches[number] = follows
            else:
                choices.append(Prefix(((number, follows),)))
        if choices:
            operands.append(choice(list(dict.fromkeys(choices))))

    def _event(self, fields: tuple[Any, ...]) -> int | None:
        try:
            return self._events[fields]
        except KeyError:
            found = self._events[fields] = self.part.alphabet.event(self.operation.name, fields)
            return found

    def _input_outside(self, fields: tuple[Any, ...]) -> bool:
        """Whether a value that the environment chooses is none that it can offer."""
        domains = self.part.alphabet.values(self.operation.name)
        return domains is not None and any(
            parameter.kind != "output" and value not in domain
            for parameter, value, domain in zip(self.parameters, fields, domains, strict=True)
        )

    def _outside(self, fields: tuple[Any, ...]) -> Process:
        """An output that is no value of its channel's finite reading."""
        self.part.evaluator.has_left = True
        domains = self.part.alphabet.values(self.operation.name) or [()] * len(fields)
        for parameter, value, domain in zip(self.parameters, fields, domains, strict=True):
            if parameter.kind == "output" and value not in domain:
                return Beyond(
                    f"`{self.operation.name}` of class `{self.part.name}` has {parameter.name}! = "
                    f"{show(value, parameter.type)}, outside the reading of its channel"
                )
        return Beyond(f"`{self.operation.name}` of class `{self.part.name}` has a value that its channel lacks")


@dataclass(frozen=True, slots=True)
class _Carried:
    """That a parameter's value is one of its channel, where the schema declares it differently."""

    parameter: _Parameter

    @property
    def carried(self) -> Term | None:
        p = self.parameter
        if shape(p.carrier) == shape(p.channel_carrier):
            return None
        variable = Variable(type=p.type, name=p.name, role=p.kind, span=p.span)
        return Apply(type=core.BOOL, operator="in", operands=(variable, p.channel_carrier), span=p.span)


def _parameter(parameter: core.Parameter, operation: core.Operation) -> _Parameter:
    """A channel's parameter as the schema declares it; one that the schema leaves out may have any value."""
    named = [p for p in operation.parameters if p.name == parameter.name]
    own = next((p for p in named if p.kind == parameter.kind), next(iter(named), parameter))
    return _Parameter(own.name, own.kind, own.type, own.carrier, parameter.carrier, own.span)


def _about(term: Term, unknowns: Sequence[SoughtVariable]) -> bool:
    return any(unknown.key in free_variables(term) for unknown in unknowns)
