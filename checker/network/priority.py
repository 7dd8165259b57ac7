"""Priority over a composition: rules that give way to others.

``prioritise(P, levels)`` and ``prioritisepo`` take transitions away from P's states and change nothing else. So the
network is that of P, and each of its rules says which bits it *raises* where it can fire, and which bits it *yields*
to. That is said of the events as the priority sees them; hiding and renaming around it then change the results of
rules, as they do for any network. What priority stands under a parallel operator, or over another priority, is not
treated here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from cspcheck.checker.network.actions import Action, hidden, projected, renamed
from cspcheck.checker.network.network import Network, Rule
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import External, Hide, Prioritised, Process, Project, Reference, Rename

MOST_BITS = 62
"""So many kinds of events that others give way to fit into a word."""

Bits = tuple[int, int]
"""What an event raises and what it yields to."""
Ranking = Callable[[Iterable[int]], dict[int, Bits] | None]
"""The bits of events; None if there are too many of them."""


@dataclass(frozen=True, slots=True)
class Priority:
    """A priority at the top of a process.

    Attributes:
        operators: hiding and renaming around it, from the outside in.
        term: the priority itself.
        operand: what it is applied to.
    """

    operators: tuple[Hide | Project | Rename, ...]
    term: Prioritised | External
    operand: Process

    def over(self, network: Network) -> Network | None:
        """The network of the process, given that of the operand; None if a word has too few bits for it."""
        bits = _bits(self.term, {rule.result for rule in network.rules})
        if bits is None:
            return None
        rules: Iterable[Rule] = [
            replace(rule, raises=bits[rule.result][0], yields=bits[rule.result][1]) for rule in network.rules
        ]
        for operator in reversed(self.operators):
            rules = list(_under(operator, rules))
        return replace(network, rules=_ordered(rules))


def at_the_top(process: Process) -> Priority | None:
    """The priority that a process is, behind names, hiding and renaming, if it is one."""
    operators: list[Hide | Project | Rename] = []
    while True:
        match process:
            case Reference():
                process = process.body()
            case Hide() | Project() | Rename():
                operators.append(process)
                process = process.process
            case Prioritised() | External(function="prioritisepo"):
                return Priority(tuple(operators), process, process.process)
            case _:
                return None


def _bits(term: Prioritised | External, events: Iterable[int]) -> dict[int, Bits] | None:
    if isinstance(term, Prioritised):
        return _bits_of_levels(term, events)
    return _bits_of_order(term, events)


def _bits_of_levels(term: Prioritised, events: Iterable[int]) -> dict[int, Bits] | None:
    """Each level has a bit and yields to those before; events of no level neither raise nor yield."""
    if len(term.levels) > MOST_BITS:
        return None

    def level(event: int) -> int | None:
        if event in (TAU, TICK):
            return 0
        return next((i for i, events in enumerate(term.levels) if event in events), None)

    found: dict[int, Bits] = {}
    for event in events:
        own = level(event)
        found[event] = (0, 0) if own is None else (1 << own, (1 << own) - 1)
    return found


def _bits_of_order(term: External, events: Iterable[int]) -> dict[int, Bits] | None:
    """Tau and tick share a bit, and each event has one that is above another."""
    prioritised, order, maximal = term.arguments
    known = set(events)
    lower: dict[int, set[int]] = {}
    for high, low in order:  # type: ignore[attr-defined]
        if high in known:
            lower.setdefault(high, set()).add(low)
    if len(lower) >= MOST_BITS:
        return None
    bit = {high: 1 << i for i, high in enumerate(sorted(lower), 1)}
    found: dict[int, Bits] = {TAU: (1, 0), TICK: (1, 0)}
    for event in known - {TAU, TICK}:
        yields = 0
        if event in prioritised:  # type: ignore[operator]
            yields = sum(bit[high] for high, lows in lower.items() if event in lows)
            yields |= event not in maximal  # type: ignore[operator]
        found[event] = (bit.get(event, 0), yields)
    return found


def _under(operator: Hide | Project | Rename, rules: Iterable[Rule]) -> Iterator[Rule]:
    """The rules under an operator, by what it does to actions."""
    for rule in rules:
        actions = [Action(rule.result, rule.cause, rule.moves)]
        match operator:
            case Hide():
                actions = hidden(actions, operator.events)
            case Project():
                actions = projected(actions, operator.events)
            case Rename():
                actions = renamed(actions, operator.pairs)
        for action in actions:
            yield replace(rule, result=action.result, cause=action.cause)


def _ordered(rules: Iterable[Rule]) -> tuple[Rule, ...]:
    """The rules of each format in order, and one of each kind: the one with the least cause."""
    least: dict[tuple[object, ...], Rule] = {}
    for rule in rules:
        key = (rule.format, rule.result, rule.moves, rule.switch, rule.raises, rule.yields)
        known = least.get(key)
        if known is None or rule.cause < known.cause:
            least[key] = rule
    return tuple(sorted(least.values(), key=lambda r: (r.format, r.result, r.moves, r.raises, r.yields)))
