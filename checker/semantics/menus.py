"""Sequential processes with data, explored without a term for each state.

Most states of such a process offer events and nothing else: choices between prefixes, whose terms would be made to be
taken apart at once. Their *menus* say the same: for each operand of the choice the (event, process) pairs that it
offers, for a choice inside another what it says itself. Two states are one exactly if their menus are equal, since
terms are equal exactly if their operands are.

Everything else is explored by its term; and the term of any state is made when somebody asks for it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import itemgetter
from typing import overload

import numpy as np

from cspcheck.checker.lts import Lts
from cspcheck.checker.semantics.head_normal import HeadNormalForms, menu_of
from cspcheck.checker.semantics.steps import Step
from cspcheck.checker.semantics.transitions import TooMany
from cspcheck.cspm.process.terms import Menu, Process, Reference

POLL_EVERY = 1024


class States(Sequence[Process]):
    """The states of a machine: for each what it was met as, a name or a term; its term is made when asked for."""

    def __init__(self, heads: HeadNormalForms, met: list[Process] | None = None, others: list[int] | None = None):
        self._heads = heads
        self.met = [] if met is None else met
        self.others: list[int] = [] if others is None else others
        """The states that have no menu, ascending."""

    def __len__(self) -> int:
        return len(self.met)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and len(self) == len(other) and all(map(operator.is_, self, other))

    def __hash__(self) -> int:
        return hash(tuple(self))

    @overload
    def __getitem__(self, index: int) -> Process: ...

    @overload
    def __getitem__(self, index: slice) -> States: ...

    def __getitem__(self, index: int | slice) -> Process | States:
        if isinstance(index, slice):
            chosen = range(len(self.met))[index]
            place = {state: i for i, state in enumerate(chosen)}
            others = [place[state] for state in self.others if state in place]
            return States(self._heads, self.met[index], others)
        return self._heads.of(self.met[index])


def unlike_menus(terms: Sequence[Process]) -> Iterator[tuple[int, Process]]:
    """The states with their terms, without those that offer events and do nothing else."""
    if isinstance(terms, States):
        for state in terms.others:
            yield state, terms[state]
    else:
        yield from enumerate(terms)


def steps_of(menu: Menu) -> list[tuple[int, Process]]:
    """The (event, process) pairs of a menu, in order; processes may be names."""
    steps: list[tuple[int, Process]] = []
    for group in menu:
        if not group:
            continue  # a choice between nothing
        first = group[0]
        if first and type(first[0]) is int:
            steps += group
        else:
            steps += steps_of(group)
    return steps


def explored(
    initial: Process,
    successors: Callable[[Process], Iterable[Step]],
    most: int | None,
    poll: Callable[[int], None] | None,
    states: States,
    heads: HeadNormalForms,
) -> Lts:
    """The machine of a term, breadth first: the same as ``transitions.spanned`` gives, state by state.

    Args:
        initial: state 0, in head normal form.
        successors: (event, state) pairs of a state that has no menu, distinct; of one that has, what its menu says.
        most: how many states there may be; None: any number.
        poll: called about once in a thousand states.
        states: empty; the states are added while they are found.
        heads: what brings terms to head normal form.

    Raises:
        TooMany: there are more than *most*.
    """
    known: dict[Process, int] = {}
    numbers: dict[Process, int] = {}
    first: dict[Process, Process] = {}
    by_menu = heads.by_menu
    kept: list[Menu | Process] = []
    """Of each state the menu; its term if it has none."""

    def state_of(process: Process) -> tuple[Process, Menu | Process]:
        """The state that a process is: whoever was the first with its menu, and that; or its term, twice."""
        menu = process.menu() if type(process) is Reference else None
        if menu is None:
            state = heads.of(process)
            menu = menu_of(state)
            if menu is None:
                first.setdefault(state, process)
                return state, state
        met = by_menu.setdefault(menu, process)
        if met is not process:
            # One state under several names: what it is called depends on which comes first.
            heads.of(met)
            heads.of(process)
        return met, menu

    def number(process: Process, state: tuple[Process, Menu | Process]) -> int:
        who, what = state
        found = numbers.get(who)
        if found is None:
            found = len(kept)
            if found == most:
                raise TooMany
            numbers[who] = found
            kept.append(what)
            if type(what) is tuple:
                states.met.append(who)
            else:
                states.met.append(first[who])
                states.others.append(found)
        known[process] = found
        return found

    number(initial, state_of(initial))
    offsets: list[int] = [0]
    labels: list[int] = []
    targets: list[int] = []
    for what in kept:  # grows
        offers = isinstance(what, tuple)
        steps = steps_of(what) if isinstance(what, tuple) else list(successors(what))
        # What is met for the first time is found once: many events may lead to one process. Names are given in the
        # order of the menu, numbers in that of the events.
        fresh: dict[Process, tuple[Process, Menu | Process]] = {}
        for _, after in steps:
            if after not in known and after not in fresh:
                fresh[after] = state_of(after)
        if offers:
            steps = sorted(steps, key=_event)
        events: list[int] = []
        row: list[int] = []
        for event, after in steps:
            target = known.get(after)
            events.append(event)
            row.append(number(after, fresh[after]) if target is None else target)
        if not offers or len(set(events)) < len(events):
            distinct = sorted(set(zip(events, row, strict=True)))
            events = [event for event, _ in distinct]
            row = [target for _, target in distinct]
        labels += events
        targets += row
        offsets.append(len(labels))
        if poll is not None and len(offsets) % POLL_EVERY == 0:
            poll(len(kept))
    return Lts(np.array(offsets, np.int64), np.array(labels, np.int64), np.array(targets, np.int64))


_event = itemgetter(0)
