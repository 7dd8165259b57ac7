"""``chase`` over a composition, state by state: what its rule says, on tuples of local states.

The rule (``semantics.external.chase``) looks for the first tau of the operand again and again. Here the operand is a
network whose tau rules are in the order in which the operators give their steps; after a step only the rules can have
come to fire, or ceased to, in which a component takes part that has moved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import product

from cspcheck.checker.network.actions import TooManyActions
from cspcheck.checker.network.compiled_taus import CompiledTaus
from cspcheck.checker.network.lazy_terms import LazyTerms
from cspcheck.checker.network.skeleton import Component, compile_parts
from cspcheck.checker.network.trees import Key, tree_of
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Explored, MoreStates, Poll, Semantics, TooMany, spanned
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import External, Process

Locals = tuple[int, ...]
"""The local state of each component."""
LocalRow = dict[int, tuple[int, ...]]
"""By label: the local states that a component can be in afterwards, in the order of its rules."""
Change = tuple[int, tuple[int, ...]]
"""Tau rules that can fire no more, as bits, and tau rules that may have come to."""

CHASES = ("chase", "chase_nocache")

FOLLOWED = 200
"""So many times taus are followed before the kernel for it is worth its loading."""

COMPILED = True
"""In which form that kernel is used."""

MOST_LOCAL = 2_000
"""A component inside has at most so many states; else the rule is applied to terms."""


class NotChasable(Exception):
    """The operand is no composition of small components that go on for ever."""


class Chased:
    """The states of ``chase(P)`` as far as they have been met, for a composition ``P``.

    Args:
        term: ``chase(P)``, in head normal form; state 0.
        component: explores a component, up to ``MOST_LOCAL`` states.
        semantics: gives the order of the transitions of components.

    Attributes:
        alphabet: all labels that its states may have.

    Raises:
        Unsuited: P is no such composition.
        MoreStates: a component is too large.
    """

    def __init__(self, term: External, component: Callable[[Component], Explored], semantics: Semantics) -> None:
        self._function = term
        try:
            network, components = compile_parts(term.process, component)
        except TooManyActions:
            raise NotChasable from None
        if len(network.slots) < 2 or any((slot.lts.labels == TICK).any() for slot in network.slots):
            raise NotChasable
        self._slots = network.slots
        self._semantics = semantics
        self._able = [self._local_rows(slot.terms) for slot in network.slots]
        self._tree = tree_of(term.process, components)
        ordered: dict[int, list[tuple[tuple[int, int], ...]]] = {}
        for rule in network.rules:
            ordered.setdefault(rule.result, []).append(rule.moves)
        for event, several in ordered.items():
            if len(several) > 1:
                several.sort(key=partial(self._place, event))
        self._taus = ordered.pop(TAU, [])
        self._visible = dict(sorted(ordered.items()))
        self._touching: list[list[tuple[int, int]]] = [[] for _ in network.slots]
        for place, moves in enumerate(self._taus):
            for slot, label in moves:
                self._touching[slot].append((place, label))
        self._changes: dict[tuple[int, int | None, int], Change] = {}
        self._followed = 0
        self._compiled: CompiledTaus | None = None
        self.alphabet = (TAU, *self._visible)
        self._states: list[Locals] = []
        self._number: dict[Locals, int] = {}
        self._ends: list[Locals | None] = []
        self._reached: dict[Locals, int] = {}
        self._after: dict[tuple[int, int], tuple[int, ...]] = {}
        self._terms: dict[int, Process] = {0: term}
        start = (0,) * len(network.slots)
        self._add(start, self._chased(start, None))

    def __len__(self) -> int:
        return len(self._states)

    def after(self, state: int, event: int) -> tuple[int, ...]:
        """The states that an event leads to, in order; none if it is not possible."""
        found = self._after.get((state, event))
        if found is None:
            found = self._after[state, event] = tuple(dict.fromkeys(self._performed(state, event)))
        return found

    def row(self, state: int) -> list[tuple[int, int]]:
        """All (event, state) pairs of a state."""
        events = self._visible if self._ends[state] is not None else (TAU,)
        return [(event, after) for event in events for after in self.after(state, event)]

    def term(self, state: int) -> Process:
        """The term that a state is."""
        term = self._terms.get(state)
        if term is None:
            terms = [slot.terms[local] for slot, local in zip(self._slots, self._states[state], strict=True)]
            term = self._terms[state] = self._function.with_active((self._tree.put_together(terms),))
        return term

    def _place(self, event: int, moves: tuple[tuple[int, int], ...]) -> Key:
        key = self._tree.order(event, moves)
        assert key is not None, "a rule of a network follows from its operators"
        return key

    def _add(self, state: Locals, end: Locals | None) -> int:
        number = self._number.get(state)
        if number is None:
            number = self._number[state] = len(self._states)
            self._states.append(state)
            self._ends.append(end)
        return number

    def _performed(self, state: int, event: int) -> Iterable[int]:
        end = self._ends[state]
        if end is None:
            return [state] if event == TAU else []
        return [
            self._settled(after, end) for moves in self._visible.get(event, ()) for after in self._moved(end, moves)
        ]

    def _settled(self, start: Locals, before: Locals) -> int:
        """The state that ``chase`` goes on in from where an event led to from a state without taus."""
        number = self._reached.get(start)
        if number is None:
            end = self._chased(start, before)
            number = self._reached[start] = self._add(start if end is None else end, end)
        return number

    def _moved(self, state: Locals, moves: Iterable[tuple[int, int]]) -> Iterable[Locals]:
        """The states that a rule leads to, in order."""
        moves = tuple(moves)
        outcomes = []
        for slot, label in moves:
            targets = self._able[slot][state[slot]].get(label)
            if targets is None:
                return
            outcomes.append(targets)
        for outcome in product(*outcomes):
            after = list(state)
            for (slot, _), target in zip(moves, outcome, strict=True):
                after[slot] = target
            yield tuple(after)

    def _chased(self, start: Locals, before: Locals | None) -> Locals | None:
        """Where the first taus lead to; None if nowhere.

        *before* is the state from which an event led to the start, and in which no tau rule could fire; None if there
        is no such state.
        """
        self._followed += 1
        if self._followed > FOLLOWED:
            if self._compiled is None:
                self._compiled = CompiledTaus(self._able, self._taus, compiled=COMPILED)
            return self._compiled.chased(start)
        here = list(start)
        seen = {start}
        # The rules that can fire, by their places in the order.
        firing = 0
        if before is None:
            changed: Iterable[Change] = [self._change(slot, None, local) for slot, local in enumerate(start)]
        else:
            pairs = zip(before, start, strict=True)
            changed = [self._change(slot, old, new) for slot, (old, new) in enumerate(pairs) if old != new]
        able, taus = self._able, self._taus
        while True:
            for lost, gained in changed:
                firing &= ~lost
                for place in gained:
                    for other, label in taus[place]:
                        if label not in able[other][here[other]]:
                            break
                    else:
                        firing |= 1 << place
            if not firing:
                return tuple(here)
            following = []
            for slot, label in taus[(firing & -firing).bit_length() - 1]:
                old = here[slot]
                new = able[slot][old][label][0]
                if new != old:
                    here[slot] = new
                    following.append((slot, old, new))
            changed = [self._change(*step) for step in following]
            state = tuple(here)
            if state in seen:
                return None
            seen.add(state)

    def _change(self, slot: int, old: int | None, new: int) -> Change:
        """What it does to the tau rules that a component moves.

        Those that can fire no more, as bits, and those that may have come to.
        """
        found = self._changes.get((slot, old, new))
        if found is None:
            own = self._able[slot][new]
            before = {} if old is None else self._able[slot][old]
            lost = sum(1 << place for place, label in self._touching[slot] if label not in own)
            gained = tuple(place for place, label in self._touching[slot] if label in own and label not in before)
            found = self._changes[slot, old, new] = lost, gained
        return found

    def _local_rows(self, terms: Sequence[Process]) -> list[LocalRow]:
        """The rows of a component, in the order of its rules."""
        numbers = {term: number for number, term in enumerate(terms)}
        rows = []
        for term in terms:
            row: dict[int, list[int]] = {}
            for event, after in self._semantics.transitions(term):
                row.setdefault(event, []).append(numbers[after])
            rows.append({event: tuple(targets) for event, targets in row.items()})
        return rows


def machine_of_chase(chased: Chased, state: int, most: int, poll: Poll | None) -> Explored:
    """All states of a chased composition from one of them.

    Raises:
        MoreStates: there are more than *most*.
    """
    states: list[int] = []
    try:
        lts = spanned(state, chased.row, most, poll, states)
    except TooMany:
        # What grows is not in these terms; there must be as many of them as there are states.
        raise MoreStates([chased.term(state)] * most) from None
    return Explored(lts, LazyTerms(len(states), lambda i: chased.term(states[i])))


class Chases:
    """The compositions that are chased in a script; each is compiled once.

    Args:
        component: explores a component, up to ``MOST_LOCAL`` states.
        semantics: the transitions of terms, without machines.
    """

    def __init__(self, component: Callable[[Component], Explored], semantics: Callable[[], Semantics]) -> None:
        self._component = component
        self._semantics = semantics
        self._known: dict[Process, tuple[Chased, int] | None] = {}

    def of(self, term: Process) -> tuple[Chased, int] | None:
        """What a term is as a state of a chased composition; None if it is no such thing."""
        if not isinstance(term, External) or term.function not in CHASES:
            return None
        if term not in self._known:
            try:
                self._known[term] = Chased(term, self._component, self._semantics()), 0
            except (NotChasable, MoreStates):
                self._known[term] = None
        return self._known[term]

    def explorer(self, term: Process) -> Callable[[int, Poll | None], Explored] | None:
        """What explores a chased composition; None for other terms."""
        found = self.of(term)
        return None if found is None else partial(machine_of_chase, *found)

    def row(self, term: External) -> Row | None:
        """The transitions of a chased composition, in the order of its rule."""
        found = self.of(term)
        if found is None:
            return None
        chased, state = found
        row = []
        for event, number in chased.row(state):
            after = chased.term(number)
            self._known.setdefault(after, (chased, number))
            row.append((event, after))
        return tuple(row)
