"""The operational semantics: which events a process performs, and what it is afterwards.

One rule for each operator, in ``cspcheck.checker.semantics.sequential`` and ``cspcheck.checker.semantics.parallel``;
here they are put together and explored. Every other part of the checker is a faster way to compute what stands here.

States are terms in head normal form (``cspcheck.checker.semantics.head_normal``), so references unfold without a tau,
and equal states are one object.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from operator import itemgetter
from typing import NamedTuple, TypeVar

import numpy as np

from cspcheck.checker.budget import LimitReached
from cspcheck.checker.lts import Lts
from cspcheck.checker.messages import nested_functions
from cspcheck.checker.semantics.external import FOLLOWING, watch
from cspcheck.checker.semantics.growth import too_many
from cspcheck.checker.semantics.head_normal import HeadNormalForms
from cspcheck.checker.semantics.machine_states import Compile
from cspcheck.checker.semantics.parallel import CONCURRENT_RULES
from cspcheck.checker.semantics.sequential import SEQUENTIAL_RULES
from cspcheck.checker.semantics.steps import Row, Step
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import External, ExternalChoice, Prefix, Prioritised, Process, Watchdog

__all__ = [
    "Explored",
    "LimitReached",
    "MoreStates",
    "Poll",
    "Semantics",
    "breadth_first",
    "explore",
    "transitions",
]

Ahead = Callable[[External], Row | None]
"""Gives the transitions of an external function over a composition; None where its rule must give them."""

_RULES = SEQUENTIAL_RULES | CONCURRENT_RULES
_POLL_EVERY = 1024
MOST_NESTED = 50
"""So many functions around one another that each follow their operand are taken for a recursion that never ends."""


class Semantics:
    """The transitions of terms, with what has been computed of them so far.

    Those of operands are remembered, those of whole states are not, since they are asked for once each. Works
    through a list of what is left to do, so the depth of a term does not matter.

    Args:
        compile: asked for the state that a compressed or prioritised process is as a machine; by default they mean
            what the rules of their operators say.
        prioritised: what gives the transitions of prioritised processes, where compressions that do not go together
            with priority are not to be used.
        followed: what gives those of functions that look further than a step (``chase``), which must not depend on
            compressions.
        ahead: what gives the transitions of such a function over a composition in a faster way, where it can.
    """

    def __init__(
        self,
        compile: Compile | None = None,
        *,
        prioritised: Semantics | None = None,
        followed: Semantics | None = None,
        ahead: Ahead | None = None,
    ) -> None:
        self.heads = HeadNormalForms(compile)
        self._prioritised = prioritised
        self._followed_by = followed
        self._ahead = ahead
        self._has_delegates = prioritised is not None or followed is not None
        self._known: dict[Process, Row] = {}
        self._latest: tuple[Process, Row] | None = None
        """The state that was asked for last: explanations ask once for each of its steps."""
        self._nested = 0
        self.steps = 0
        """How many steps of terms and of their operands have been worked out: what that costs."""

    def state(self, process: Process) -> Process:
        """The state that *process* is: its head normal form.

        Raises:
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        return self.heads.of(process)

    def transitions(self, state: Process) -> Row:
        """The (event, state) pairs of a state, distinct, by event and then by first occurrence in the rule.

        Raises:
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        known = self._known
        found = known.get(state)
        if found is not None:
            return found
        latest = self._latest
        if latest is not None and latest[0] is state:
            return latest[1]
        if type(state) is ExternalChoice:
            row = self._of_prefixes(state)
            if row is not None:
                self._latest = state, row
                return row
        delegate = self._delegate(state) if self._has_delegates else None
        if delegate is not None:
            return delegate.transitions(state)
        todo = [operand for operand in state.active() if operand not in known]
        while todo:
            term = todo[-1]
            if term in known:
                todo.pop()
                continue
            delegate = self._delegate(term) if self._has_delegates else None
            if delegate is not None:
                known[term] = delegate.transitions(term)
                todo.pop()
                continue
            missing = [operand for operand in term.active() if operand not in known]
            if missing:
                todo.extend(missing)
            else:
                known[term] = self._apply(term)
                todo.pop()
        row = self._apply(state)
        self._latest = state, row
        return row

    def applied(self, term: Process, rows: list[Row]) -> list[Step]:
        """What the rule of the operator of *term* gives for operands with these transitions, in no special order."""
        if isinstance(term, (External, Watchdog)) and term.function in FOLLOWING:
            return self._followed(term)
        return _RULES[type(term)](self.heads.of, term, rows)

    def _delegate(self, term: Process) -> Semantics | None:
        """What gives the transitions of a term, if not this."""
        if isinstance(term, Prioritised):
            return self._prioritised
        if isinstance(term, (External, Watchdog)):
            return self._followed_by if term.function in FOLLOWING else self._prioritised
        return None

    def _of_prefixes(self, choice: ExternalChoice) -> Row | None:
        """The transitions of a choice between prefixes, what most states of processes with data are; else None.

        The same as its rule gives, without the transitions of the operands by themselves, which nobody asks for.
        """
        steps: list[Step] = []
        state = self.heads.of
        for operand in choice.operands:
            if type(operand) is not Prefix:
                return None
            steps += [(event, state(after)) for event, after in operand.branches]
        self.steps += 2 * len(steps)
        return _ordered(steps)

    def _apply(self, term: Process) -> Row:
        known = self._known
        steps = self.applied(term, [known[operand] for operand in term.active()])
        self.steps += len(steps)
        return _ordered(steps)

    def _followed(self, term: External | Watchdog) -> list[Step]:
        """What a function does that looks at more than the next step of its operand."""
        if self._ahead is not None and isinstance(term, External):
            row = self._ahead(term)
            if row is not None:
                return list(row)
        if self._nested == MOST_NESTED:
            raise ScriptError(nested_functions(term.function, MOST_NESTED))
        self._nested += 1
        try:
            if isinstance(term, Watchdog):
                return watch(self.heads.of, term, self._remembered)
            return FOLLOWING[term.function](self.heads.of, term, self._remembered)
        finally:
            self._nested -= 1

    def _remembered(self, state: Process) -> Row:
        row = self._known.get(state)
        if row is None:
            row = self._known[state] = self.transitions(state)
        return row


_event = itemgetter(0)


def _ordered(steps: list[Step]) -> Row:
    """Steps without repetitions, by event and then by first occurrence."""
    return tuple(sorted(dict.fromkeys(steps), key=_event)) if len(steps) > 1 else tuple(steps)


def transitions(process: Process) -> Row:
    """The (event, state) pairs of *process*, distinct, by event and then by first occurrence in the rule.

    Raises:
        ScriptError: a definition calls itself before any event, or cannot be evaluated.
    """
    semantics = Semantics()
    return semantics.transitions(semantics.state(process))


class Explored(NamedTuple):
    """A machine with the term that each of its states is."""

    lts: Lts
    terms: Sequence[Process]

    def alphabet(self) -> tuple[int, ...]:
        """The labels that occur, ascending."""
        # For the few labels of a component this is far quicker than the first call of numpy's unique.
        return tuple(sorted(set(self.lts.labels.tolist())))


Poll = Callable[[int], None]
"""Called now and then with the number of states found so far; what it raises ends the exploration."""


def explore(
    process: Process,
    limits: Limits = Limits(),  # noqa: B008  (immutable)
    *,
    poll: Poll | None = None,
    semantics: Semantics | None = None,
) -> Explored:
    """All states that *process* reaches, breadth first, numbered in the order in which they are met.

    The slow and obvious way, one object a state. Networks are explored by ``cspcheck.checker.search.exploration``.

    Args:
        process: any term.
        limits: only ``states`` matters here.
        poll: called about once in a thousand states.
        semantics: transitions computed before, to be used and added to.

    Raises:
        LimitReached: there are more states than the limit.
        ScriptError: a definition calls itself before any event, or cannot be evaluated.
    """
    semantics = semantics or Semantics()
    try:
        return breadth_first(semantics.state(process), semantics.transitions, limits.states, poll)
    except MoreStates as more:
        raise too_many(process, more.terms, semantics.heads) from None


class MoreStates(Exception):
    """An exploration found more states than it should; ``terms`` are those up to there."""

    def __init__(self, terms: Sequence[Process]) -> None:
        super().__init__(len(terms))
        self.terms = terms


def breadth_first(
    initial: Process,
    successors: Callable[[Process], Iterable[Step]],
    most: int | None,
    poll: Poll | None = None,
    terms: list[Process] | None = None,
) -> Explored:
    """The machine that a successor function spans; see :func:`spanned`.

    Raises:
        MoreStates: there are more states than *most*.
    """
    terms = [] if terms is None else terms
    try:
        lts = spanned(initial, successors, most, poll, terms)
    except TooMany:
        raise MoreStates(terms) from None
    return Explored(lts, tuple(terms))


class TooMany(Exception):
    """An exploration found more states than it should."""


State = TypeVar("State", bound=Hashable)


def spanned(
    initial: State,
    successors: Callable[[State], Iterable[tuple[int, State]]],
    most: int | None,
    poll: Poll | None,
    states: list[State],
) -> Lts:
    """The machine that a successor function spans, breadth first.

    Args:
        initial: state 0.
        successors: (label, state) pairs of a state, distinct.
        most: how many states there may be; None: any number.
        poll: called about once in a thousand states.
        states: an empty list, to which the states are added while they are found.

    Raises:
        TooMany: there are more than *most*.
    """
    number = {initial: 0}
    states.append(initial)
    offsets, labels, targets = [0], [], []
    for source in states:
        row = []
        for label, state in successors(source):
            target = number.get(state)
            if target is None:
                target = number[state] = len(states)
                if target == most:
                    raise TooMany
                states.append(state)
            row.append((label, target))
        row.sort()
        labels.extend([label for label, _ in row])
        targets.extend([target for _, target in row])
        offsets.append(len(labels))
        if poll is not None and len(offsets) % _POLL_EVERY == 0:
            poll(len(states))
    return Lts(np.array(offsets, np.int64), np.array(labels, np.int64), np.array(targets, np.int64))


def offer(row: Row) -> frozenset[int] | None:
    """What a state with these transitions can be relied on to perform: its acceptance.

    {tick} if it can tick, else everything if it is stable, else None.
    """
    events = frozenset(event for event, _ in row)
    if TICK in events:
        return frozenset({TICK})
    return None if TAU in events else events
