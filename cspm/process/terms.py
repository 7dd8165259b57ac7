r"""The process algebra as immutable, hash-consed terms: what an evaluated process is.

Two terms with the same operator and the same operands are one object, so terms compare by identity and a state
of a process is a term. Recursion goes through :class:`Reference`: a definition with its evaluated arguments,
whose body is evaluated once, on demand. The operands of operators and the continuations of prefixes are either
references or terms built in place; evaluating a process therefore ends as soon as it meets named processes.

What the operators do is said in one place only, ``cspcheck.checker.semantics.transitions``. Nothing here looks inside
a reference.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol, TypeAlias

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.hash_consing import HashConsed
from cspcheck.cspm.source import Span

if TYPE_CHECKING:
    from cspcheck.cspm.process.definitions import Definition

Operands: TypeAlias = "tuple[Process, ...]"
Menu: TypeAlias = tuple[Any, ...]
"""What a choice between prefixes offers: for each operand its (event, process) pairs, or a menu inside. Never empty."""


@dataclass(frozen=True, eq=False, slots=True, weakref_slot=True)
class Process(metaclass=HashConsed):
    """A process term. Construct subclasses with positional operands only.

    Each operator says here how it is written, which of its operands are running, and what it is with others in their
    place: both sides of ``|||`` run, of ``;`` the left, but not its right, which has not started, nor what follows a
    prefix. What it *does* is said in the semantics alone.
    """

    symbol: ClassVar[str] = ""
    """How the operator is written, without its operands; empty for what is no operator."""
    has_active: ClassVar[bool] = False
    """Whether there is something running inside terms of this class."""

    def active(self) -> Operands:
        """The running operands, in order; a reference's only one is its body.

        Raises:
            ScriptError: the body of a reference cannot be evaluated.
        """
        return ()

    def with_active(self, operands: Operands) -> Process:
        """The term with other running operands.

        A compression is its operand; what cannot change a tick (hiding, renaming, priority) leaves SKIP as it is.
        """
        return self


@dataclass(frozen=True, eq=False, slots=True)
class Stop(Process):
    """``STOP``."""


@dataclass(frozen=True, eq=False, slots=True)
class Skip(Process):
    """``SKIP``: its only transition is tick, to :class:`Terminated`."""


@dataclass(frozen=True, eq=False, slots=True)
class Terminated(Process):
    """What is left after tick: no transitions, and no deadlock."""


@dataclass(frozen=True, eq=False, slots=True)
class Diverge(Process):
    """``DIV``: a tau to itself."""


@dataclass(frozen=True, eq=False, slots=True)
class Beyond(Process):
    """Where a search under finite readings stops: what the process does from here on is not known to it.

    It has no transitions, and no verdict may depend on that. ``report`` says what lies outside the readings.
    """

    report: str


@dataclass(frozen=True, eq=False, slots=True)
class Run(Process):
    """``RUN(A)``: always offers all of A."""

    events: EventSet


@dataclass(frozen=True, eq=False, slots=True)
class Chaos(Process):
    """``CHAOS(A)`` is ``STOP |~| ([] x : A @ x -> CHAOS(A))``."""

    events: EventSet


@dataclass(frozen=True, eq=False, slots=True)
class Prefix(Process):
    """``?x:S -> P(x)``: the events offered, ascending and distinct, each with what follows it."""

    branches: tuple[tuple[int, Process], ...]


@dataclass(frozen=True, eq=False, slots=True)
class ExternalChoice(Process):
    """``P [] Q [] ...``: at least two operands."""

    symbol: ClassVar[str] = "[]"
    has_active: ClassVar[bool] = True

    operands: tuple[Process, ...]

    def active(self) -> Operands:  # noqa: D102
        return self.operands

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return ExternalChoice(operands)


@dataclass(frozen=True, eq=False, slots=True)
class InternalChoice(Process):
    """``P |~| Q |~| ...``: a tau to each operand; at least one."""

    operands: tuple[Process, ...]


@dataclass(frozen=True, eq=False, slots=True)
class SlidingChoice(Process):
    """``P [> Q``."""

    symbol: ClassVar[str] = "[>"
    has_active: ClassVar[bool] = True

    left: Process
    right: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.left,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SlidingChoice(operands[0], self.right)


@dataclass(frozen=True, eq=False, slots=True)
class SynchronisingChoice(Process):
    """``P [+ A +] Q``: events of A are synchronised and do not resolve the choice; two or more operands."""

    symbol: ClassVar[str] = "[+ +]"
    has_active: ClassVar[bool] = True

    events: EventSet
    operands: tuple[Process, ...]

    def active(self) -> Operands:  # noqa: D102
        return self.operands

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SynchronisingChoice(self.events, operands)


@dataclass(frozen=True, eq=False, slots=True)
class Interrupt(Process):
    r"""``P /\ Q``."""

    symbol: ClassVar[str] = "/\\"
    has_active: ClassVar[bool] = True

    left: Process
    right: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.left, self.right)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return Interrupt(*operands)


@dataclass(frozen=True, eq=False, slots=True)
class SynchronisingInterrupt(Process):
    r"""``P /+ A +\ Q``: events of A are synchronised, other events of Q interrupt."""

    symbol: ClassVar[str] = "/+ +\\"
    has_active: ClassVar[bool] = True

    left: Process
    events: EventSet
    right: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.left, self.right)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SynchronisingInterrupt(operands[0], self.events, operands[1])


@dataclass(frozen=True, eq=False, slots=True)
class Throw(Process):
    """``P [| A |> Q``: after an event of A that P performs, Q takes over."""

    symbol: ClassVar[str] = "[| |>"
    has_active: ClassVar[bool] = True

    left: Process
    events: EventSet
    right: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.left,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return Throw(operands[0], self.events, self.right)


@dataclass(frozen=True, eq=False, slots=True)
class Sequential(Process):
    """``P ; Q``: the tick of P becomes a tau to Q."""

    symbol: ClassVar[str] = ";"
    has_active: ClassVar[bool] = True

    left: Process
    right: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.left,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return Sequential(operands[0], self.right)


NO_EVENTS = EventSet()


@dataclass(frozen=True, eq=False, slots=True)
class Parallel(Process):
    """``P [| A |] Q [| A |] ...``: all operands take part in events of A; interleaving is the empty A. Two or more.

    ``clocks``, here and in the other parallel operators, are the events by which time passes (``tock``): an operand
    that can terminate and offers one of them waits for the others instead of terminating by itself.
    """

    symbol: ClassVar[str] = "[| |]"
    has_active: ClassVar[bool] = True

    events: EventSet
    operands: tuple[Process, ...]
    clocks: EventSet = NO_EVENTS

    def active(self) -> Operands:  # noqa: D102
        return self.operands

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return Parallel(self.events, operands, self.clocks)


@dataclass(frozen=True, eq=False, slots=True)
class AlphabetisedParallel(Process):
    """``P [A || B] Q``, ``|| x:S @ [A(x)] P(x)``: each operand takes part in, and performs only, its alphabet."""

    symbol: ClassVar[str] = "[ || ]"
    has_active: ClassVar[bool] = True

    alphabets: tuple[EventSet, ...]
    operands: tuple[Process, ...]
    clocks: EventSet = NO_EVENTS

    def active(self) -> Operands:  # noqa: D102
        return self.operands

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return AlphabetisedParallel(self.alphabets, operands, self.clocks)


@dataclass(frozen=True, eq=False, slots=True)
class LinkedParallel(Process):
    """``P [a <-> b] Q``: P's a and Q's b happen together as a tau; neither happens alone."""

    symbol: ClassVar[str] = "[ <-> ]"
    has_active: ClassVar[bool] = True

    left: Process
    links: tuple[tuple[int, int], ...]
    right: Process
    clocks: EventSet = NO_EVENTS

    def active(self) -> Operands:  # noqa: D102
        return (self.left, self.right)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return LinkedParallel(operands[0], self.links, operands[1], self.clocks)


@dataclass(frozen=True, eq=False, slots=True)
class Hide(Process):
    r"""``P \ A``."""

    symbol: ClassVar[str] = "\\"
    has_active: ClassVar[bool] = True

    process: Process
    events: EventSet

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SKIP if operands[0] is SKIP else Hide(operands[0], self.events)


@dataclass(frozen=True, eq=False, slots=True)
class Project(Process):
    r"""``P |\ A``: hides all but A."""

    symbol: ClassVar[str] = "|\\"
    has_active: ClassVar[bool] = True

    process: Process
    events: EventSet

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SKIP if operands[0] is SKIP else Project(operands[0], self.events)


@dataclass(frozen=True, eq=False, slots=True)
class Rename(Process):
    """``P [[a <- b]]``: ascending distinct pairs (old, new); events that are no pair's old one stay as they are."""

    symbol: ClassVar[str] = "[[ ]]"
    has_active: ClassVar[bool] = True

    process: Process
    pairs: tuple[tuple[int, int], ...]

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SKIP if operands[0] is SKIP else Rename(operands[0], self.pairs)


BufferKind = Literal["BUFFER", "WEAK_BUFFER", "SIGNAL_BUFFER"]


@dataclass(frozen=True, eq=False, slots=True)
class Buffer(Process):
    """A first-in first-out buffer with ``contents`` (positions in ``pairs``, oldest first).

    ``pairs`` are (input, output) events. ``signals`` is () for BUFFER, (explode,) for WEAK_BUFFER and
    (full, empty) for SIGNAL_BUFFER.
    """

    kind: BufferKind
    capacity: int
    signals: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]
    contents: tuple[int, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Compressed(Process):
    """``normal(P)``, ``sbisim(P)`` and their like: means what P means; ``function`` names the compression."""

    symbol: ClassVar[str] = "compression"
    has_active: ClassVar[bool] = True

    function: str
    process: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return operands[0]


@dataclass(frozen=True, eq=False, slots=True)
class Fused(Process):
    """Means what ``process`` means, and says that this composition is best explored as one machine.

    A class is one: its data part by itself may have far more states, or no end of them.
    """

    has_active: ClassVar[bool] = True

    process: Process

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return operands[0]


@dataclass(frozen=True, eq=False, slots=True)
class Prioritised(Process):
    """``prioritise(P, <A0, A1, ...>)``: ``levels`` highest first; tau and tick rank with the first."""

    symbol: ClassVar[str] = "prioritise"
    has_active: ClassVar[bool] = True

    process: Process
    levels: tuple[EventSet, ...]

    def active(self) -> Operands:  # noqa: D102
        return (self.process,)

    def with_active(self, operands: Operands) -> Process:  # noqa: D102
        return SKIP if operands[0] is SKIP else Prioritised(operands[0], self.levels)


IDEMPOTENT = ("chase", "chase_nocache", "deter")
"""Functions that change nothing where they have been applied already, nor SKIP."""


@dataclass(frozen=True, eq=False, slots=True)
class External(Process):
    """An external function of the script applied to a process (``chase``, ``deter``, ``prioritisepo``, ...)."""

    has_active: ClassVar[bool] = True

    function: str
    process: Process
    arguments: tuple[Hashable, ...]

    def active(self) -> Operands:
        """The operand of ``prioritisepo`` runs; the other functions follow theirs."""
        return (self.process,) if self.function == "prioritisepo" else ()

    def with_active(self, operands: Operands) -> Process:
        """The function applied to another operand, in head normal form if the operand is."""
        (operand,) = operands
        if self.function in IDEMPOTENT and isinstance(operand, External) and operand.function == self.function:
            return operand
        if operand is SKIP and self.function in (*IDEMPOTENT, "prioritisepo"):
            return SKIP
        return External(self.function, operand, self.arguments)


@dataclass(frozen=True, eq=False, slots=True)
class Watchdog(Process):
    """A watchdog of the external functions at work: an observer of *events* that performs *bark* after a wrong one.

    ``members`` are the states that the specification can be in after what has been observed. ``insists``: the events
    that a watchdog for failures offers alone, to see whether all are refused; None while it does not insist.
    """

    function: str
    members: frozenset[Process]
    events: EventSet
    bark: int
    insists: frozenset[int] | None = None


@dataclass(frozen=True, eq=False, slots=True)
class MachineState(Process):
    """A state of an explicit machine that a part of a process has been compiled to: a leaf like any other.

    ``machine`` knows the transitions of all its states, and the term that it was made of (``checker.semantics``).
    """

    machine: Machine
    state: int


class Machine(Protocol):
    """What a machine must tell of itself to be described."""

    @property
    def source(self) -> Process:
        """The term whose behaviour the machine has."""


class Reference(Process):
    """A named process with its evaluated arguments, evaluated once, on demand.

    ``key`` identifies the definition and the values it is applied to; two references with equal keys are one
    object. ``text`` is how a person would write it (``Buf(<1, 2>)``), ``span`` where it is defined.
    """

    __slots__ = ("_body", "_definition", "key")

    has_active: ClassVar[bool] = True
    key: Hashable
    _definition: Definition
    _body: Process | None

    def __init__(self, key: Hashable, definition: Definition) -> None:
        object.__setattr__(self, "key", key)
        object.__setattr__(self, "_definition", definition)
        object.__setattr__(self, "_body", None)

    @classmethod
    def fresh(cls, key: Hashable, definition: Definition) -> Reference:
        """A reference of which the caller knows that there is none with this key: who makes all of them sees to it."""
        reference = cls.__new__(cls)
        cls.__init__(reference, key, definition)
        return reference

    @property
    def text(self) -> str:
        """The name with its arguments, as a person would write it."""
        return self._definition.text

    @property
    def name(self) -> str:
        """The name of what the reference is a state of."""
        return self._definition.name

    @property
    def variables(self) -> Mapping[str, str]:
        """The variables of the state that the reference is."""
        return self._definition.variables

    @property
    def span(self) -> Span | None:
        """Where the name is defined."""
        return self._definition.span

    def body(self) -> Process:
        """The term that the name stands for; never a reference again if the evaluator made this one.

        Raises:
            ScriptError: the definition cannot be evaluated.
        """
        body = self._body
        if body is None:
            body = self._definition.evaluate()
            object.__setattr__(self, "_body", body)
        return body

    def menu(self) -> Menu | None:
        """The menu of what the name stands for, if it offers events and nothing else; None where that is not known.

        The same as that of its head normal form, without a term being made.
        """
        return self._definition.menu() if self._body is None else None

    def active(self) -> Operands:
        """The body."""
        return (self.body(),)

    def with_active(self, operands: Operands) -> Process:
        """The body, or what is in its place."""
        return operands[0]

    def __repr__(self) -> str:
        return f"Reference({self.text})"


STOP = Stop()
SKIP = Skip()
TERMINATED = Terminated()
DIV = Diverge()
