"""FDR4's Python names, for programs that were written for its API: ``from cspcheck import fdr``.

A session loads one file and has its assertions, which are executed and then say whether they passed and what
counterexamples there are; a counterexample has the behaviours of specification and implementation, whose events are
numbers that the session knows by name. Processes are evaluated to machines, with nodes and transitions. What a program
needs of the names that FDR4's own examples and published programs use is here; FDR4's graphical and compiling parts are
not.

A process that has terminated is a deadlock to ``deadlock free``, as it is in FDR4.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import cspcheck
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.report.refines import NO_EVENT, TAU, TICK, UNCHANGED, EventNumbers, counterexample_object
from cspcheck.result import Result

T = TypeVar("T")

INVALID_EVENT = NO_EVENT
"""Where a process takes no part in a step."""
SemanticModel_Traces = "T"
SemanticModel_Failures = "F"
SemanticModel_FailuresDivergences = "FD"


class Error(Exception):
    """A request that cannot be met; the message says why."""


class FileLoadError(Error):
    """A file cannot be read, or there is an error in it."""


class InputFileError(Error):
    """An expression, or an assertion, has an error in it, or its evaluation has met one."""


def library_init() -> None:
    """Nothing: there is no library to be prepared."""


def library_exit() -> None:
    """Nothing."""


def has_valid_license() -> bool:
    """True: none is needed."""
    return True


def version() -> str:
    """The version of cspcheck."""
    return cspcheck.__version__


@dataclass(frozen=True, slots=True)
class Evaluated(Generic[T]):
    """What was asked for, behind a call, as FDR4 hands it out."""

    value: T

    def result(self) -> T:
        """What was asked for."""
        return self.value

    def warnings(self) -> list[str]:
        """None: warnings are told when the file is loaded."""
        return []


@dataclass(frozen=True, slots=True)
class CompiledEvent:
    """An event by its number and its name."""

    number: int
    name: str

    def __str__(self) -> str:
        return self.name

    def to_string(self) -> str:
        """The name."""
        return self.name


@dataclass(frozen=True, slots=True)
class Node:
    """A state: its number in its machine, and how it is written, where that is known."""

    number: int
    name: str | None = None

    def hash_code(self) -> int:
        """The number."""
        return self.number


@dataclass(frozen=True, slots=True)
class Transition:
    """One step of a machine."""

    _event: int
    _destination: Node

    def event(self) -> int:
        """The number of its event."""
        return self._event

    def destination(self) -> Node:
        """Where it leads."""
        return self._destination


class Machine:
    """The labelled transition system of a process, which is built when its states are asked for."""

    def __init__(self, session: Session, name: str) -> None:
        self._session = session
        self._name = name
        self._lts: cspcheck.Machine | None = None

    def __str__(self) -> str:
        return self._name

    def root_node(self) -> Node:
        """The initial state.

        Raises:
            InputFileError: the process cannot be evaluated.
            Error: it has too many states.
        """
        return Node(self._built().initial)

    def alphabet(self, include_tau: bool = False) -> list[int]:
        """The numbers of the events that occur, with 1 for the internal action if that is asked for.

        Raises:
            InputFileError, Error: as in :meth:`root_node`.
        """
        numbers = [self._session.compile_event(name) for name in self._built().alphabet]
        return [number for number in numbers if include_tau or number != TAU]

    def transitions(self, node: Node) -> list[Transition]:
        """The steps that are possible in a state.

        Raises:
            InputFileError, Error: as in :meth:`root_node`.
        """
        number = self._session.compile_event
        return [Transition(number(event), Node(target)) for event, target in self._built().successors(node.number)]

    def _built(self) -> cspcheck.Machine:
        if self._lts is None:
            try:
                self._lts = self._session.script.process(self._name).lts()
            except ScriptError as error:
                raise InputFileError(str(error)) from None
            except cspcheck.Incomplete as error:
                raise Error(str(error)) from None
        return self._lts


class Behaviour:
    """What one process does in a counterexample."""

    def __init__(self, machine: Machine, trace: list[int], states: list[str | None], children: list[Behaviour]) -> None:
        self._machine = machine
        self._trace = trace
        self._states = states
        self._children = children

    def machine(self) -> Machine:
        """The process."""
        return self._machine

    def trace(self) -> list[int]:
        """Its events, with :data:`INVALID_EVENT` where it takes no part in a step."""
        return list(self._trace)

    def node_path(self) -> list[Node | None]:
        """The states before the first step and after each, where they are known."""
        return [None if text is None else Node(index, text) for index, text in enumerate(self._states)]


class IrrelevantBehaviour(Behaviour):
    """One that does not matter beyond its trace."""


class TraceBehaviour(Behaviour):
    """An event that must not be, or, of the specification, is not possible."""

    _event: int = INVALID_EVENT

    def error_event(self) -> int:
        """The number of the event."""
        return self._event


class MinAcceptanceBehaviour(Behaviour):
    """A state that can be relied on to offer too little."""

    _offered: list[int]

    def min_acceptance(self) -> list[int]:
        """The numbers of the events that it offers."""
        return list(self._offered)


class LoopBehaviour(Behaviour):
    """A loop of steps."""

    _loop: int

    def loop_index(self) -> int:
        """Where in the trace the loop begins, from 0."""
        return self._loop


class ExplicitDivergenceBehaviour(Behaviour):
    """A state that diverges by its definition. None is made: divergence comes as a loop."""


class SegmentedBehaviour(Behaviour):
    """A behaviour of several sections. None is made."""

    def prior_sections(self) -> list[Behaviour]:
        """No sections."""
        return []

    def last(self) -> Behaviour:
        """The behaviour itself."""
        return self


class Counterexample:
    """Why an assertion does not hold.

    Attributes:
        found: the same with its texts at hand.
    """

    def __init__(self, found: cspcheck.Counterexample, implementation: Behaviour) -> None:
        self.found = found
        self._implementation = implementation

    def implementation_behaviour(self) -> Behaviour:
        """What the process does that it must not."""
        return self._implementation


class PropertyCounterexample(Counterexample):
    """One of a property."""


class RefinementCounterexample(Counterexample):
    """One of a refinement, or of divergence freedom."""

    _specification: Behaviour

    def specification_behaviour(self) -> Behaviour:
        """What the specification does beside it."""
        return self._specification


class TraceCounterexample(RefinementCounterexample):
    """An event that is not allowed."""

    def error_event(self) -> int:
        """Its number."""
        assert isinstance(self._implementation, TraceBehaviour)
        return self._implementation.error_event()


class MinAcceptanceCounterexample(RefinementCounterexample):
    """Too little is offered."""

    def min_acceptance(self) -> list[int]:
        """The numbers of the events that can be relied on."""
        assert isinstance(self._implementation, MinAcceptanceBehaviour)
        return self._implementation.min_acceptance()


class DivergenceCounterexample(RefinementCounterexample):
    """The process does nothing but internal steps for ever."""


class DeadlockCounterexample(PropertyCounterexample):
    """Nothing can happen."""


class DeterminismCounterexample(PropertyCounterexample):
    """An event can happen and be refused after one trace."""


_COUNTEREXAMPLES: dict[str, type[Counterexample]] = {
    "trace": TraceCounterexample,
    "refusal": MinAcceptanceCounterexample,
    "divergence": DivergenceCounterexample,
    "deadlock": DeadlockCounterexample,
    "nondeterminism": DeterminismCounterexample,
}

_BEHAVIOURS: dict[str, type[Behaviour]] = {
    "trace": TraceBehaviour,
    "min_acceptance": MinAcceptanceBehaviour,
    "loop": LoopBehaviour,
}


class DebugContext:
    """The behaviours of a counterexample, and of the components in them."""

    def __init__(self, counterexample: Counterexample, division: bool = True) -> None:
        self._counterexample = counterexample

    def initialise(self, canceller: object = None) -> None:
        """Nothing: all is at hand."""

    def root_behaviours(self) -> list[Behaviour]:
        """Of the specification, if there is one, and of the implementation."""
        specification = self.specification()
        return [*([] if specification is None else [specification]), self.implementation()]

    def specification(self) -> Behaviour | None:
        """What the specification does; None for a property."""
        found = self._counterexample
        return found.specification_behaviour() if isinstance(found, RefinementCounterexample) else None

    def implementation(self) -> Behaviour:
        """What the implementation does."""
        return self._counterexample.implementation_behaviour()

    def behaviour_children(self, behaviour: Behaviour) -> list[Behaviour]:
        """What the components of a composition do."""
        return list(behaviour._children)


class Assertion:
    """One assertion of a session. FDR4 gives each kind a class of its own; here the text tells them apart."""

    def __init__(self, session: Session, text: str) -> None:
        self._session = session
        self._text = text
        self._result: Result | None = None

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<cspcheck.fdr.Assertion {self._text!r}>"

    def to_string(self) -> str:
        """The text of the assertion, without the word ``assert``."""
        return self._text

    def execute(self, canceller: object = None) -> None:
        """Check the assertion. *canceller* is not looked at: Ctrl-C ends a check.

        Raises:
            InputFileError: what it speaks of cannot be evaluated.
            Error: a limit was reached, so that it neither passes nor fails.
        """
        try:
            result = self._session.script.check(self._text, termination="deadlock")
        except ScriptError as error:
            raise InputFileError(str(error)) from None
        self._result = result
        if result.verdict == "error":
            raise InputFileError(result.reason or self._text)
        if result.verdict == "unknown":
            raise Error(result.reason or self._text)

    def passed(self) -> bool:
        """Whether it holds.

        Raises:
            Error: it has not been executed.
        """
        return self.result.verdict == "pass"

    def counterexamples(self) -> list[Counterexample]:
        """Why it does not hold: one counterexample, or none.

        Raises:
            Error: it has not been executed.
        """
        found = self.result.counterexample
        return [] if found is None else [self._session.counterexample(self.result, found)]

    @property
    def result(self) -> Result:
        """All that is known of it.

        Raises:
            Error: it has not been executed.
        """
        if self._result is None:
            raise Error(f"`{self._text}` has not been executed")
        return self._result


class Session:
    """A file that is loaded, and what can be asked of it."""

    def __init__(self) -> None:
        self._script: cspcheck.Script | None = None
        self._number = EventNumbers()

    @property
    def script(self) -> cspcheck.Script:
        """The file that is loaded.

        Raises:
            Error: no file is loaded.
        """
        if self._script is None:
            raise Error("no file is loaded")
        return self._script

    def load_file(self, path: str | os.PathLike[str]) -> None:
        """Load a script, in the place of one that was loaded before.

        Raises:
            FileLoadError: it cannot be read, or there is an error in it.
        """
        try:
            self._script = cspcheck.load(path)
        except ScriptError as error:
            raise FileLoadError(str(error)) from None

    def assertions(self) -> list[Assertion]:
        """The assertions of the file, in its order.

        Raises:
            Error: no file is loaded.
        """
        return [Assertion(self, text) for text in self.script.assertions]

    def parse_assertion(self, text: str) -> Evaluated[Assertion]:
        """An assertion about what the file defines; what is wrong with it is told when it is executed.

        Raises:
            Error: no file is loaded.
        """
        assert self.script
        return Evaluated(Assertion(self, text.removeprefix("assert ").strip()))

    def evaluate_expression(self, text: str, canceller: object = None) -> Evaluated[str]:
        """The value of an expression, as ``print`` writes it.

        Raises:
            Error: no file is loaded.
            InputFileError: it has no value.
        """
        try:
            return Evaluated(self.script.show(text))
        except ScriptError as error:
            raise InputFileError(str(error)) from None

    def evaluate_process(
        self, text: str, model: str = SemanticModel_FailuresDivergences, canceller: object = None
    ) -> Evaluated[Machine]:
        """The machine of a process, in every model the same.

        Raises:
            Error: no file is loaded, or there are too many states.
            InputFileError: the process cannot be evaluated.
        """
        machine = Machine(self, text)
        machine.root_node()
        return Evaluated(machine)

    def compile_event(self, name: str) -> int:
        """The number of an event."""
        events = self.script._script.events
        return {events.tau: TAU, events.tick: TICK, "τ": TAU, "✓": TICK}.get(name) or self._number(name)

    def uncompile_event(self, event: int) -> CompiledEvent:
        """The event of a number.

        Raises:
            Error: there is none.
        """
        name = self._number.names().get(str(event))
        if name is None:
            raise Error(f"there is no event {event}")
        return CompiledEvent(event, name)

    def machine_node_name(self, machine: Machine, node: Node) -> str | None:
        """How a state is written, where that is known."""
        return node.name

    def print_statements(self) -> list[str]:
        """What the ``print`` lines of the file say.

        Raises:
            Error: no file is loaded.
        """
        return list(self.script.printed)

    def counterexample(self, result: Result, found: cspcheck.Counterexample) -> Counterexample:
        """A counterexample with its behaviours; *result* has found it."""
        written = counterexample_object(result, found, self._number, reveal=False)
        make = _COUNTEREXAMPLES.get(found.kind, Counterexample)
        counterexample = make(found, self._behaviour(written["implementation_behaviour"]))
        if isinstance(counterexample, RefinementCounterexample):
            counterexample._specification = self._beside(written, found)
        return counterexample

    def _beside(self, written: dict[str, Any], found: cspcheck.Counterexample) -> Behaviour:
        """What the specification does beside the process; nothing, where there is none."""
        if (behaviour := written.get("specification_behaviour")) is not None:
            return self._behaviour(behaviour)
        steps = [INVALID_EVENT for _ in found.trace]
        return IrrelevantBehaviour(Machine(self, "CHAOS(Events)"), steps, [None, *(None for _ in steps)], [])

    def _behaviour(self, written: dict[str, Any]) -> Behaviour:
        """A behaviour of the form that ``cspcheck refines`` writes."""
        trace: list[int] = written["trace"]
        states: list[str | None] = list(written.get("states", [None] * (len(trace) + 1)))
        for index, state in enumerate(states):
            if state == UNCHANGED:
                states[index] = states[index - 1]
        children = [self._behaviour(child) for child in written.get("child_behaviours", ())]
        made = _BEHAVIOURS[written["type"]](Machine(self, written["machine_name"]), trace, states, children)
        if isinstance(made, TraceBehaviour):
            made._event = written.get("error_event", INVALID_EVENT)
        elif isinstance(made, MinAcceptanceBehaviour):
            made._offered = written.get("min_acceptance", [])
        elif isinstance(made, LoopBehaviour):
            made._loop = written["loop_index"]
        return made
