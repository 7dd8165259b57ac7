"""What a state becomes by one event, where its other events do not matter: following a run, one event at a time.

The transitions of a composition are all that its operands can do, each with the state of the whole behind it. To
follow a run only those with one event are wanted, so the operands are asked for that event alone, and the states behind
the others are never made. ``transitions`` says what an operator does; this is a faster way to compute a part of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product

from cspcheck.checker.semantics.parallel import sharing
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.events import TAU, TICK, EventSet, new_names
from cspcheck.cspm.process.terms import SKIP, TERMINATED, AlphabetisedParallel, Hide, Parallel, Process, Rename

Targets = Sequence[Process]


class Directed:
    """The transitions of states by events.

    Args:
        semantics: gives the transitions of what is no composition; they are kept for good.
    """

    def __init__(self, semantics: Semantics) -> None:
        self._semantics = semantics
        self._rows: dict[Process, dict[int, list[Process]]] = {}
        self._events: dict[Process, frozenset[int]] = {}
        self._quiet: set[Process] = set()
        """Those without taus and ticks."""
        self._renamings: dict[int, tuple[object, dict[int, list[int]], dict[int, list[int]]]] = {}
        self._shared: dict[int, tuple[object, dict[int, bool]]] = {}

    def after(self, state: Process, event: int) -> Targets:
        """The states that *event* leads to, distinct."""
        found = self._after(state, event)
        return found if len(found) < 2 else list(dict.fromkeys(found))

    def initials(self, state: Process) -> frozenset[int]:
        """The events of a state, taus and ticks included."""
        kind = type(state)
        if kind is Parallel or kind is AlphabetisedParallel:
            return self._of_parallel(state)  # type: ignore[arg-type]
        if isinstance(state, Hide):
            inner = self.initials(state.process)
            hidden = self._members(state.events, inner)
            return (inner - hidden) | {TAU} if hidden else inner
        if isinstance(state, Rename):
            _, new = self._renaming(state)
            return frozenset([name for event in self.initials(state.process) for name in new.get(event, (event,))])
        found = self._events.get(state)
        if found is None:
            found = self._events[state] = frozenset(self._row(state))
        return found

    # --- one operator each -----------------------------------------------------------------------------------

    def _after(self, state: Process, event: int) -> Targets:
        row = self._rows.get(state)
        if row is not None:
            return row.get(event, ())
        kind = type(state)
        if kind is Parallel or kind is AlphabetisedParallel:
            return self._in_parallel(state, event)  # type: ignore[arg-type]
        if isinstance(state, Hide):
            if event == TAU:
                targets = list(self._after(state.process, TAU))
                for hidden in self._members(state.events, self.initials(state.process)):
                    targets += self._after(state.process, hidden)
            else:
                targets = [] if event in state.events else list(self._after(state.process, event))
            return [Hide(target, state.events) if _goes_on(target) else target for target in targets]
        if isinstance(state, Rename):
            old, new = self._renaming(state)
            names = [*old.get(event, ()), *([] if event in new else [event])]
            targets = [target for name in names for target in self._after(state.process, name)]
            return [Rename(target, state.pairs) if _goes_on(target) else target for target in targets]
        return self._row(state).get(event, ())

    def _in_parallel(self, state: Parallel | AlphabetisedParallel, event: int) -> Targets:
        operands = state.operands
        if event == TICK:
            ready = all(self._is_ready(operand, state.clocks) for operand in operands)
            return [TERMINATED] if ready else []
        if event == TAU:
            found = []
            for i, operand in enumerate(operands):
                if operand in self._quiet:
                    continue
                found += [_with(state, i, target) for target in self._after(operand, TAU)]
                if self._can_tick(operand) and not self._is_ready(operand, state.clocks):
                    found.append(_with(state, i, SKIP))
            return found
        if isinstance(state, AlphabetisedParallel):
            participants = sharing(state.alphabets, event)
        elif self._is_shared(state.events, event):
            participants = list(range(len(operands)))
        else:
            return [
                _with(state, i, target) for i, operand in enumerate(operands) for target in self._after(operand, event)
            ]
        targets = []
        for i in participants:
            some = self._after(operands[i], event)
            if not some:
                return []
            targets.append(some)
        found = []
        for outcome in product(*targets) if participants else ():
            after = list(operands)
            for i, target in zip(participants, outcome, strict=True):
                after[i] = target
            found.append(_rebuilt(state, tuple(after)))
        return found

    def _of_parallel(self, state: Parallel | AlphabetisedParallel) -> frozenset[int]:
        rows = [self.initials(operand) for operand in state.operands]
        found: set[int] = set()
        for row in rows:
            found |= row
        found -= {TAU, TICK}
        if isinstance(state, AlphabetisedParallel):
            found = {
                event
                for event in found
                if (sharers := sharing(state.alphabets, event)) and all(event in rows[i] for i in sharers)
            }
        else:
            found -= {event for event in self._members(state.events, found) if not all(event in row for row in rows)}
        ready = [self._is_ready(operand, state.clocks) for operand in state.operands]
        if all(ready):
            found.add(TICK)
        if any(TAU in row or (TICK in row and not is_ready) for row, is_ready in zip(rows, ready, strict=True)):
            found.add(TAU)
        return frozenset(found)

    def _is_ready(self, operand: Process, clocks: EventSet) -> bool:
        """Whether an operand does not keep the whole from ticking: it has terminated, or waits with time."""
        if not self._can_tick(operand):
            return False
        events = self.initials(operand)
        return len(events) == 1 or (bool(clocks) and any(event in clocks for event in events))

    def _can_tick(self, state: Process) -> bool:
        """Whether a state can tick, without a look at what else it can do where that matters little."""
        while isinstance(state, (Hide, Rename)):
            state = state.process
        if isinstance(state, (Parallel, AlphabetisedParallel)):
            return all(self._is_ready(operand, state.clocks) for operand in state.operands)
        return TICK in self._row(state)

    # --- what is known ---------------------------------------------------------------------------------------

    def _row(self, state: Process) -> dict[int, list[Process]]:
        row = self._rows.get(state)
        if row is None:
            row = self._rows[state] = {}
            for event, target in self._semantics.transitions(state):
                row.setdefault(event, []).append(target)
            if TAU not in row and TICK not in row:
                self._quiet.add(state)
        return row

    def _is_shared(self, events: EventSet, event: int) -> bool:
        # All states of a composition ask the same set, which is kept with what is known of it.
        found = self._shared.get(id(events))
        if found is None:
            found = self._shared[id(events)] = events, {}
        known = found[1]
        if event not in known:
            known[event] = event in events
        return known[event]

    def _members(self, events: EventSet, some: Iterable[int]) -> set[int]:
        """Which of *some* events are in a set."""
        return {event for event in some if event not in (TAU, TICK) and self._is_shared(events, event)}

    def _renaming(self, state: Rename) -> tuple[dict[int, list[int]], dict[int, list[int]]]:
        """The old names of each new one, and the new names of each old one."""
        found = self._renamings.get(id(state.pairs))
        if found is None:
            old: dict[int, list[int]] = {}
            for before, name in state.pairs:
                old.setdefault(name, []).append(before)
            found = self._renamings[id(state.pairs)] = state.pairs, old, new_names(state.pairs)
        return found[1], found[2]


def _goes_on(target: Process) -> bool:
    return target is not SKIP and target is not TERMINATED


def _with(state: Parallel | AlphabetisedParallel, i: int, operand: Process) -> Process:
    operands = state.operands
    return _rebuilt(state, (*operands[:i], operand, *operands[i + 1 :]))


def _rebuilt(state: Parallel | AlphabetisedParallel, operands: tuple[Process, ...]) -> Process:
    if isinstance(state, Parallel):
        return Parallel(state.events, operands, state.clocks)
    return AlphabetisedParallel(state.alphabets, operands, state.clocks)
