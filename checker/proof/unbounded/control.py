"""The CSP part of a class as a finite machine over its channels, where the values of events make no difference to it.

Read are equations whose prefixes name a channel alone, or bind what they receive and never look at it: then an event of
the machine stands for all events of its channel. Everything else is said to be unreadable.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from cspcheck.checker.budget import LimitReached
from cspcheck.checker.semantics.transitions import explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.equations import defined_name, names_in
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.construction import external_choice, prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.syntax import tree as syntax

MOST_STATES = 200
"""A machine with more states is not looked at."""
_CONSTANT = {"STOP": process.STOP, "SKIP": process.SKIP, "DIV": process.DIV}


class UnreadableProcess(Exception):
    """What keeps a process from being read; the message is a sentence without a full stop."""


@dataclass(frozen=True, slots=True)
class Control:
    """A finite machine over channels. The first state is the initial one.

    Attributes:
        moves: of each state the channel (None: an internal step) and the state behind it.
        mentioned: the channels that the equations speak of.
        ends: the states in which it may terminate; nothing is said of what follows.
    """

    moves: tuple[tuple[tuple[str | None, int], ...], ...]
    mentioned: frozenset[str]
    ends: frozenset[int] = frozenset()

    def settled(self, state: int) -> bool:
        """Whether a state can neither go on by itself nor terminate."""
        return state not in self.ends and all(channel is not None for channel, _ in self.moves[state])


ANYTHING = Control(((),), frozenset())
"""The control of a class without a CSP part: it takes no part in anything."""


def control(model: core.ClassModel, taken: Container[str] = ()) -> Control:
    """The CSP parts of a class, side by side on the channels that they have in common.

    Args:
        model: the class.
        taken: names that stand for something outside the class: where an event binds a value, they are constants.

    Raises:
        Unreadable: it depends on values, is not finite, or has an operator whose meaning is not read off.
    """
    parts = [part for part in model.processes if any(_names(e) == "main" for e in part.equations)]
    if not parts:
        return ANYTHING
    numbers = {name: number for number, name in enumerate(model.channels, start=TICK + 1)}
    names = {number: name for name, number in numbers.items()}
    whole: Process | None = None
    known: set[str] = set()
    for number, part in enumerate(parts):
        equations = _Equations(part.equations, numbers, number, taken)
        one = equations.named("main")
        mentioned = {name for name in _followed(part.equations) if name in numbers}
        if whole is None:
            whole = one
        else:
            common = EventSet.of(sorted(numbers[name] for name in mentioned & known))
            whole = process.Parallel(common, (whole, one))
        known |= mentioned
    assert whole is not None
    try:
        lts = explore(whole, Limits(states=MOST_STATES)).lts
    except LimitReached:
        raise UnreadableProcess(f"its process equations have more than {MOST_STATES} states") from None
    except ScriptError:
        raise UnreadableProcess("its process equations call themselves before any event") from None
    moves: list[tuple[tuple[str | None, int], ...]] = []
    ends = set()
    for state in range(lts.states):
        row = list(lts.successors(state))
        if any(label == TICK for label, _ in row):
            ends.add(state)
        moves.append(tuple((None if label == TAU else names[label], to) for label, to in row if label != TICK))
    return Control(tuple(moves), frozenset(known), frozenset(ends))


def _names(equation: syntax.Declaration) -> str | None:
    found = defined_name(equation)
    return None if found is None else found[0]


def _followed(equations: Sequence[syntax.Declaration]) -> set[str]:
    """The names that ``main`` leads to."""
    bodies = {name: equation for equation in equations if (name := _names(equation)) is not None}
    found: set[str] = set()
    todo = ["main"]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            if name in bodies:
                todo += [part.parts[0] for part in names_in(bodies[name])]
    return found


class _Equations:
    """The equations of one part as terms of processes over the numbers of channels."""

    def __init__(
        self, equations: Iterable[syntax.Declaration], numbers: Mapping[str, int], part: int, taken: Container[str]
    ) -> None:
        self._numbers = numbers
        self._taken = taken
        self._key = (object(), part)
        self._bodies: dict[str, syntax.Expr] = {}
        for equation in equations:
            match equation:
                case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern):
                    self._bodies[pattern.text] = equation.body

    def named(self, name: str) -> Process:
        """The process of an equation."""
        body = self._bodies[name]
        return Reference((self._key, name), Definition(name, body.span, lambda: self._process(body)))

    def _process(self, node: syntax.Expr) -> Process:
        match node:
            case syntax.Paren():
                return self._process(node.inner)
            case syntax.Prefix():
                return prefix(self._event(node), self._process(node.body))
            case syntax.ProcessBinary(operator="[]"):
                return external_choice((self._process(node.left), self._process(node.right)))
            case syntax.ProcessBinary(operator="|~|"):
                return process.InternalChoice((self._process(node.left), self._process(node.right)))
            case syntax.ProcessBinary(operator=";"):
                return process.Sequential(self._process(node.left), self._process(node.right))
            case syntax.ProcessBinary(operator="|||"):
                return process.Parallel(EventSet(), (self._process(node.left), self._process(node.right)))
            case syntax.Synchronised(operator="[|"):
                events = self._channels(node.events)
                return process.Parallel(events, (self._process(node.left), self._process(node.right)))
            case syntax.Name(parts=(name,)) if name in self._bodies:
                return self.named(name)
            case syntax.Name(parts=(name,)) if name in _CONSTANT:
                return _CONSTANT[name]
        text = " ".join(node.span.text.split())
        raise UnreadableProcess(
            f"`{text if len(text) < 60 else text[:57] + '...'}` in its process equations is not read"
        )

    def _event(self, node: syntax.Prefix) -> int:
        channel = node.channel
        channel = syntax.bare(channel)
        if isinstance(channel, syntax.Name) and len(channel.parts) == 1 and channel.parts[0] in self._numbers:
            used = {name.parts[0] for name in names_in(node.body)}
            if all(self._ignored(field, used) for field in node.fields):
                return self._numbers[channel.parts[0]]
        text = " ".join(node.span.text.split("->")[0].split())
        raise UnreadableProcess(f"its process equations look at the values of `{text}`")

    def _ignored(self, field: syntax.Field, used: set[str]) -> bool:
        """Whether a field takes any value, and nothing is done with it."""
        if field.kind != "?" or field.restriction is not None:
            return False
        match field.pattern:
            case syntax.Wildcard():
                return True
            case syntax.NamePattern() as pattern:
                return (
                    pattern.text not in used and pattern.text not in self._taken and pattern.text not in self._numbers
                )
        return False

    def _channels(self, node: syntax.Expr) -> EventSet:
        node = syntax.bare(node)
        if isinstance(node, syntax.Productions) and node.statements is None:
            names = [item.parts for item in node.items if isinstance(item, syntax.Name)]
            if len(names) == len(node.items) and all(len(n) == 1 and n[0] in self._numbers for n in names):
                return EventSet.of(sorted({self._numbers[name] for (name,) in names}))
        raise UnreadableProcess("its process equations have a set of events that is not one of whole channels")


def after(machine: Control, states: frozenset[int], channel: str) -> frozenset[int]:
    """Where a machine may be behind an event of a channel, internal steps included."""
    return closed(machine, {to for s in states for label, to in machine.moves[s] if label == channel})


def closed(machine: Control, states: Iterable[int]) -> frozenset[int]:
    """The states with those that internal steps lead to."""
    found = set(states)
    todo = list(found)
    while todo:
        for label, to in machine.moves[todo.pop()]:
            if label is None and to not in found:
                found.add(to)
                todo.append(to)
    return frozenset(found)


def offered(machine: Control, state: int) -> Iterator[str]:
    """The channels whose events a state can perform."""
    yield from dict.fromkeys(label for label, _ in machine.moves[state] if label is not None)
