"""What must hold in every reachable state for an assertion to hold: deadlock freedom, refinement of traces or failures.

A claim is about one place. It fails in a state where its premises hold, for some values, and its goal does not; the
assertion holds if no claim fails in a reachable state. For refinements the specification runs beside the implementation
as an observer, which is right where its data after a trace are determined by the trace
(:func:`determined_by_traces`); its control may then be in one of several states.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.situation import second
from cspcheck.checker.proof.terms import (
    FALSE,
    TRUE,
    Key,
    all_of,
    any_of,
    equal,
    is_true,
    negation,
    renamed,
    substitute,
    variables,
)
from cspcheck.checker.proof.unbounded.control import Control, UnreadableProcess, after, closed, offered
from cspcheck.checker.proof.unbounded.system import (
    ClassComponent,
    ClassSystem,
    Configuration,
    SystemLeaf,
    SystemMove,
    every,
    some,
)
from cspcheck.cspm.oz.core import Term, Variable

MOST_PLACES = 60

Kind = Literal["deadlock", "trace", "refusal", "divergence"]
Place = TypeVar("Place")


@dataclass(frozen=True)
class Claim:
    """What must hold at a place.

    Attributes:
        kind: what it is if the claim fails.
        premises: over the state before, and the values of the event.
        goal: what follows from them.
        label: the channel that is looked at; None: none.
        values: of its event.
        exact: whether the assertion fails if the claim does.
    """

    kind: Kind
    premises: tuple[Constraint, ...]
    goal: Term
    label: str | None = None
    values: tuple[Variable, ...] = ()
    exact: bool = True


@dataclass(frozen=True)
class Step:
    """What can happen between two places.

    Attributes:
        source, target: the places.
        move: what it is.
        values: of its event.
        parts: over the states before and after, and these values.
        unchanged: what keeps its value, by what it is afterwards.
    """

    source: int
    target: int
    move: SystemMove
    values: tuple[Variable, ...]
    parts: tuple[Constraint, ...]
    unchanged: dict[Key, Term]


@dataclass(frozen=True)
class Problem:
    """A machine over predicates, and what must hold in it.

    Attributes:
        components: whose variables the predicates speak of.
        places: a text for each place of control; the first is the start.
        initial, state: what holds of the data at the beginning, and always.
        steps: what can happen.
        claims: by place.
    """

    components: tuple[ClassComponent, ...]
    places: tuple[str, ...]
    initial: tuple[Constraint, ...]
    state: tuple[Constraint, ...]
    steps: tuple[Step, ...]
    claims: tuple[tuple[Claim, ...], ...]

    def variables(self) -> list[Variable]:
        """The state variables."""
        return [v for component in self.components for v in component.situation.state_variables()]


def deadlock_freedom(system: ClassSystem, *, divergences: bool) -> Problem:
    """The claims of an assertion of deadlock freedom.

    Args:
        system: what it is about. Termination is no deadlock.
        divergences: whether divergence counts.

    Raises:
        Unreadable: what it would take is not said here.
    """
    if len(system.components) > 1:
        _terminates_never(system.components)
    if divergences:
        _nothing_hidden_for_ever(system)

    def steps(at: Configuration) -> list[tuple[SystemMove, Configuration]]:
        return [(move, move.target) for move in system.moves(at)]

    def claims(at: Configuration) -> Iterator[Claim]:
        moves = _distinct(system.moves(at))
        for move in moves:
            yield from _total(system, move)
        if system.settled(at):
            # What a class chooses of an event it chooses once, whoever else takes part.
            met = [m.label for m in moves if len(m.parts) > 1]
            goal = any_of(system.alive(move) for move in moves)
            yield Claim("deadlock", (), goal, exact=len(met) == len(set(met)))

    def text(at: Configuration) -> str:
        return _waiting(_offered(system.moves(at)))

    return _problem(system, system.start, steps, claims, text)


def trace_refinement(system: ClassSystem, observer: ClassComponent) -> Problem:
    """The claims of a refinement of traces.

    Raises:
        Unreadable: what it would take is not said here.
    """
    return _Joint(system, observer).problem(failures=False)


def failures_refinement(system: ClassSystem, observer: ClassComponent, *, divergences: bool) -> Problem:
    """The claims of a refinement of failures, or of failures and divergences.

    Raises:
        Unreadable: what it would take is not said here.
    """
    if divergences:
        _nothing_hidden_for_ever(system)
        _nothing_hidden_for_ever(ClassSystem((observer,), SystemLeaf(0)))
    return _Joint(system, observer).problem(failures=True)


def determined_by_traces(observer: ClassComponent) -> Iterator[tuple[tuple[Constraint, ...], Term]]:
    """Premises, and what must follow from them, for the data of a class to be determined by what it has done."""
    situation = observer.situation
    states = situation.state_variables()

    def other(terms: Iterable[Term]) -> tuple[Term, ...]:
        return renamed(terms, lambda v: replace(v, name=f"{v.name}%second") if v.role == "before" else None)

    initial = tuple(observer.initial())
    twins = tuple(replace(p, term=t) for p, t in zip(initial, other(p.term for p in initial), strict=True))
    yield (*initial, *twins), all_of(equal(v, t) for v, t in zip(states, other(states), strict=True))
    ends = situation.state_variables("after")
    for channel in observer.model.operations:
        values = tuple(replace(v, role="input") for v in observer.parameters(channel))
        step = observer.step(channel, values)
        again = second(part.term for part in step)
        repeated = [replace(p, term=t) for p, t in zip(step, again, strict=True) if t != p.term]
        same = all_of(equal(v, t) for v, t in zip(ends, second(ends), strict=True))
        yield (*situation.state(), *step, *repeated), same


_Joined = tuple[Configuration, frozenset[int]]


class _Joint:
    """An implementation with its specification beside it, whose control is in one of a set of states."""

    def __init__(self, system: ClassSystem, observer: ClassComponent) -> None:
        _terminates_never((*system.components, observer))
        if any(label is None for label in observer.labels.values()):
            raise UnreadableProcess(f"`{observer.name}` hides events")
        self.system = system
        self.observer = observer
        self.number = len(system.components)
        self.whole = ClassSystem((*system.components, observer), SystemLeaf(0))

    def problem(self, *, failures: bool) -> Problem:
        def claims(place: _Joined) -> Iterator[Claim]:
            at, states = place
            for move in _distinct(self.system.moves(at)):
                yield from _total(self.system, move)
                if move.label is not None:
                    yield self._allowed(move, states)
            for channel in self._channels(states):
                yield from _total(self.whole, self._own(channel, at))
            if failures and self.system.settled(at):
                yield from self._accepted(at, states)

        def text(place: _Joined) -> str:
            return _waiting(_offered(self.system.moves(place[0])))

        start = (self.system.start, closed(self.observer.machine, [0]))
        return _problem(self.whole, start, self._steps, claims, text)

    def _steps(self, place: _Joined) -> list[tuple[SystemMove, _Joined]]:
        at, states = place
        found: list[tuple[SystemMove, _Joined]] = []
        for move in self.system.moves(at):
            if move.label is None:
                found.append((move, (move.target, states)))
                continue
            behind = self._behind(states, move.label)
            if behind is not None:
                channel, then = behind
                found.append((replace(move, parts=(*move.parts, (self.number, channel))), (move.target, then)))
        return found

    def _behind(self, states: frozenset[int], label: str) -> tuple[str, frozenset[int]] | None:
        """The specification's channel, and where its control may be behind an event of it; None where it has none."""
        channel = self.observer.channel(label)
        if channel is None:
            return None
        if channel in self.observer.free:
            return channel, states
        then = after(self.observer.machine, states, channel)
        return (channel, then) if then else None

    def _channels(self, states: Iterable[int]) -> list[str]:
        machine = self.observer.machine
        return list(dict.fromkeys([*(c for s in states for c in offered(machine, s)), *self.observer.free]))

    def _own(self, channel: str, at: Configuration) -> SystemMove:
        return SystemMove(self.observer.labels[channel], ((self.number, channel),), at)

    def _allowed(self, move: SystemMove, states: frozenset[int]) -> Claim:
        """That the specification can do what the implementation does."""
        assert move.label is not None
        values = self.system.values(move)
        behind = self._behind(states, move.label)
        goal = FALSE if behind is None else self.observer.possible(behind[0], values)
        return Claim("trace", tuple(self.system.step(move)), goal, move.label, values)

    def _accepted(self, at: Configuration, states: frozenset[int]) -> Iterator[Claim]:
        """That the implementation refuses no more than some state that the specification may be in."""
        moves = _distinct(self.system.moves(at))
        if any(len(move.parts) > 1 for move in moves):
            raise UnreadableProcess("what a composition of classes refuses is not read off")
        stable = tuple(
            Constraint(negation(self.system.alive(move)), "nothing hidden is possible")
            for move in moves
            if move.label is None
        )
        options = []
        for state in sorted(states):
            if self.observer.machine.settled(state):
                channels = self._channels([state])
                options.append([self._both(at, moves, channel) for channel in channels])
        if not options:
            raise UnreadableProcess(f"`{self.observer.name}` has states that are never stable")
        if len(options) == 1:
            for label, inputs, offer, answer in options[0]:
                yield Claim(
                    "refusal", (*stable, Constraint(offer, "offered by the specification")), answer, label, inputs
                )
            return
        goals = [all_of(every(inputs, offer, answer) for _, inputs, offer, answer in option) for option in options]
        yield Claim("refusal", stable, any_of(goals))

    def _both(
        self, at: Configuration, moves: Sequence[SystemMove], channel: str
    ) -> tuple[str | None, tuple[Variable, ...], Term, Term]:
        """A channel's label, its inputs, and that the specification, and the implementation, takes them."""
        own = self._own(channel, at)
        values = self.whole.values(own)
        chosen = [v for v in values if v.role == "output"]
        answers = []
        for move in moves:
            if move.label != own.label:
                continue
            if [v.role == "output" for v in self.system.values(move)] != [v.role == "output" for v in values]:
                raise UnreadableProcess(f"the classes do not agree on who chooses the values of `{own.label}`")
            number, name = move.parts[0]
            answers.append(some(chosen, self.system.components[number].possible(name, values)))
        inputs = tuple(v for v in values if v.role != "output")
        return own.label, inputs, some(chosen, self.observer.possible(channel, values)), any_of(answers)


def _problem(
    system: ClassSystem,
    start: Place,
    steps: Callable[[Place], list[tuple[SystemMove, Place]]],
    claims: Callable[[Place], Iterable[Claim]],
    text: Callable[[Place], str],
) -> Problem:
    places = {start: 0}
    todo = [start]
    found: list[Step] = []
    for place in todo:
        for move, target in steps(place):
            if target not in places:
                places[target] = len(places)
                todo.append(target)
            step = Step(
                places[place],
                places[target],
                move,
                system.values(move),
                tuple(system.step(move)),
                system.unchanged(move),
            )
            found.append(step)
        if len(todo) > MOST_PLACES:
            raise UnreadableProcess(f"control has more than {MOST_PLACES} places")
    return Problem(
        system.components,
        tuple(text(place) for place in todo),
        tuple(part for component in system.components for part in component.initial()),
        tuple(system.state()),
        tuple(found),
        tuple(tuple(c for c in claims(place) if not is_true(c.goal)) for place in todo),
    )


def _total(system: ClassSystem, move: SystemMove) -> Iterator[Claim]:
    """That no guard holds where its effect is impossible: there a class would diverge."""
    for number, channel in move.parts:
        component = system.components[number]
        covered = _covered(component, channel)
        if covered is None:
            continue
        values = system.values(move)
        table = component.renaming(channel, values)
        premises = tuple(replace(p, term=substitute(p.term, table)) for p in covered[0])
        yield Claim("divergence", premises, substitute(covered[1], table), move.label, values, exact=False)


def guards_that_cover(component: ClassComponent) -> Iterator[tuple[tuple[Constraint, ...], Term]]:
    """Premises, and what must follow from them, for a class never to diverge, in whatever state it is.

    Where an effect is impossible although its guard holds, an event is not refused; claims that fail there say nothing.
    """
    for channel in component.model.operations:
        covered = _covered(component, channel)
        if covered is not None:
            yield (*component.situation.state(), *covered[0]), covered[1]


def _covered(component: ClassComponent, channel: str) -> tuple[tuple[Constraint, ...], Term] | None:
    """The guard of an operation, and that the effect is possible; None where they are one schema."""
    operation = component.model.operations.get(channel)
    if operation is None or operation.form not in ("guarded", "effect"):
        return None
    carried = component.carried(channel)
    given = [p for p in carried if all(role != "output" for _, role in variables(p.term))]
    outputs = [v for v in component.parameters(channel) if v.role == "output"]
    effect = component.situation.possible(operation, outputs=False)
    return (*given, *component.situation.guard(operation)), some(outputs, all_of([*(p.term for p in carried), effect]))


def _terminates_never(components: Iterable[ClassComponent]) -> None:
    for component in components:
        if component.machine.ends:
            raise UnreadableProcess(f"`{component.name}` may terminate")


def _nothing_hidden_for_ever(system: ClassSystem) -> None:
    """Raise where hidden events and internal steps may go round in a circle, as far as control is concerned."""
    silent = {
        at: {move.target for move in system.moves(at) if move.label is None}
        for at in system.configurations(MOST_PLACES)
    }
    while done := [at for at, targets in silent.items() if not targets & silent.keys()]:
        for at in done:
            del silent[at]
    if silent:
        raise UnreadableProcess("hidden events may go on for ever as far as control is concerned")


def _distinct(moves: Iterable[SystemMove]) -> list[SystemMove]:
    """Moves without their targets, each once; internal steps of control are left out."""
    return list({(move.label, move.parts): move for move in moves if move.parts}.values())


def _offered(moves: Iterable[SystemMove]) -> list[str]:
    return sorted({move.label for move in moves if move.label is not None})


def _waiting(labels: Sequence[str]) -> str:
    return "nothing" if not labels else ", ".join(f"`{label}`" for label in labels)


__all__ = [
    "TRUE",
    "Claim",
    "Control",
    "Problem",
    "Step",
    "deadlock_freedom",
    "determined_by_traces",
    "failures_refinement",
    "guards_that_cover",
    "trace_refinement",
]
