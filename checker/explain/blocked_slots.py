"""Who waits for whom: the components that an offered event lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import count

from cspcheck.checker.explain.joining import Missing, joined, linked, renamed, within
from cspcheck.checker.network.network import Network
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    Compressed,
    External,
    Hide,
    LinkedParallel,
    Parallel,
    Prioritised,
    Process,
    Project,
    Reference,
    Rename,
)
from cspcheck.cspm.recursion import deep_recursion

Move = tuple[int, int]
"""A slot and a label of its machine."""
Blocked = dict[int, set[int]]
"""For slots that offer events which cannot happen: the slots that would have to take part and cannot."""


def blocked(
    process: Process, network: Network, format: int, local: Mapping[int, int], *, sure: bool = False
) -> Blocked:
    """For each slot in use the slots that lack what one of its events needs.

    Events that can happen in some way are left out. Of a group of which nobody can ever perform an event, all are
    meant; with *sure* nobody is, since it need not be each of them that stands in the way.

    Args:
        process: the term that *network* was compiled from.
        network: the network.
        format: the format of the state.
        local: the local states of the slots in use.
    """
    offered = {slot: {label for label, _ in network.slots[slot].lts.successors(s)} for slot, s in local.items()}
    possible: set[Move] = set()
    missing: dict[Move, set[int]] = {}
    for rule in network.rules:
        if rule.format != format:
            continue
        lacking = {slot for slot, label in rule.moves if label not in offered.get(slot, ())}
        ready = [move for move in rule.moves if move[0] not in lacking]
        if not lacking:
            possible.update(ready)
        for move in ready:
            missing.setdefault(move, set()).update(lacking)
    for move, lacking in _without_rules(process, network).items():
        if move[1] in offered.get(move[0], ()) and not (sure and len(lacking) > 1):
            missing.setdefault(move, set()).update(lacking)
    found: Blocked = {}
    for move, lacking in missing.items():
        if move not in possible and lacking:
            found.setdefault(move[0], set()).update(lacking)
    return found


def shortest_cycle(waits_for: Blocked) -> tuple[int, ...] | None:
    """The shortest cycle of slots each of which waits for the next and the last for the first.

    Of several the one with the earliest slot, which comes first; None if there is none.
    """
    cycles = [cycle for start in sorted(waits_for) if (cycle := _shortest_cycle_through(start, waits_for))]
    return min(cycles, key=len, default=None)


def _shortest_cycle_through(start: int, waits_for: Blocked) -> tuple[int, ...] | None:
    # Breadth first, so the first that waits for the start closes the shortest cycle through it.
    ways: list[tuple[int, ...]] = [(start,)]
    seen = {start}
    for way in ways:  # grows
        others = waits_for.get(way[-1], set())
        if start in others:
            return way
        ways += [(*way, other) for other in sorted(others - seen)]
        seen |= others
    return None


def _without_rules(process: Process, network: Network) -> dict[Move, set[int]]:
    """The moves that no rule has because a partner cannot perform the event in any state, with those partners.

    Nothing is known of networks whose components are not the operands of *process*.
    """
    walk = _Walk(network)
    if network.formats == 1:
        with deep_recursion():
            walk.origins(process)
    return walk.stuck if walk.slots == len(network.slots) else {}


class _Walk:
    """A walk over the parallel operators of a term that finds which moves end up in which event of the whole."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._next = count()
        self.slots = 0
        self.stuck: dict[Move, set[int]] = {}

    def origins(self, process: Process) -> dict[int, set[Move]]:
        """For each event that *process* can ever perform, taus apart, the moves that it can be made of."""
        while isinstance(process, (Reference, Compressed)):
            if isinstance(process, Compressed) and process is self._compressed_next():
                break
            process = process.body() if isinstance(process, Reference) else process.process
        match process:
            case Parallel():
                parts, slots = self._parts(process.operands)
                return joined(parts, [process.events] * len(parts), self._note(slots))
            case AlphabetisedParallel():
                parts, slots = self._parts(process.operands)
                parts = [within(part, alphabet) for part, alphabet in zip(parts, process.alphabets, strict=True)]
                return joined(parts, process.alphabets, self._note(slots))
            case LinkedParallel():
                parts, slots = self._parts((process.left, process.right))
                return linked(parts[0], parts[1], process.links, self._note(slots), lambda moves: None)
            case Hide():
                found = self.origins(process.process)
                return {event: moves for event, moves in found.items() if event not in process.events}
            case Project():
                found = self.origins(process.process)
                return {event: moves for event, moves in found.items() if event == TICK or event in process.events}
            case Rename():
                return renamed(self.origins(process.process), process.pairs)
            case Prioritised() | External(function="prioritisepo") if self._network.is_prioritised:
                return self.origins(process.process)
        slot = next(self._next)
        self.slots = slot + 1
        if slot >= len(self._network.slots):
            return {}
        return {label: {(slot, label)} for label in self._network.slots[slot].lts.alphabet() if label != TAU}

    def _compressed_next(self) -> Process | None:
        """What the next component is a compression of, if it is one."""
        slots = self._network.slots
        return slots[self.slots].compressed if self.slots < len(slots) else None

    def _parts(self, operands: Iterable[Process]) -> tuple[list[dict[int, set[Move]]], list[range]]:
        """What each operand can ever perform, and its slots."""
        parts, slots = [], []
        for operand in operands:
            first = self.slots
            parts.append(self.origins(operand))
            slots.append(range(first, self.slots))
        return parts, slots

    def _note(self, slots: list[range]) -> Callable[[set[Move], Missing], None]:
        def note(moves: set[Move], missing: Missing) -> None:
            for move in moves:
                self.stuck.setdefault(move, set()).update(slot for operand, _ in missing for slot in slots[operand])

        return note
