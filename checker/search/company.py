"""The machines of components that are worked out while a composition gets to their states, in kernels.

Such a component (``cspcheck.checker.network.chased``) may have no end by itself. The whole is explored from its initial
state; where a rule lacks nothing but a transition of such a component that is not known yet, this is worked out, and
the state is looked at again. What comes of it is the network with as much of each component as the whole gets to see:
it has the states and transitions of the whole, and is searched as any other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.kernels.company import Company, Outcome
from cspcheck.checker.kernels.jit import Kernels, kernels, tau_kernels
from cspcheck.checker.lts import Lts, machine
from cspcheck.checker.network.lazily import LazyComposition
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.layout import Layout, layout_of, packed_state
from cspcheck.checker.search.visited import Visited

CHUNK = 1 << 15
"""So many states of the whole are looked at before what they lack is worked out."""
WIDTH = 22
"""Bits for the state of a component that grows."""
FIRST_ROOM = 1 << 18
"""Words for successors, at first."""


class TooLarge(Exception):
    """The whole, or a component in its company, has too many states.

    Attributes:
        states: how many states of the whole were found.
    """

    def __init__(self, states: int) -> None:
        super().__init__(states)
        self.states = states


def together(
    composition: LazyComposition,
    room: Callable[[int, int], bool],
    poll: Callable[[int], None] | None,
    compiled: bool = True,
) -> Network:
    """The network of a composition, with what the whole gets to see of its components that are chased.

    Args:
        composition: the composition.
        room: tells whether so many states of the whole are allowed, which take so many bytes.
        poll: called now and then with the number of states found so far; what it raises ends the work.
        compiled: which form of the kernels is used.

    Raises:
        TooLarge: there are more states than are allowed.
    """
    growth = _Growth(composition, room, poll, tau_kernels(compiled), kernels(compiled))
    growth.run()
    return growth.network()


class _Part:
    """What is known of a component: its moves, ascending, and their targets.

    A move is a local state with the number of a label, ``state * len(labels) + number``.

    Attributes:
        labels: the labels that rules ask it for, ascending.
    """

    def __init__(self, labels: list[int]) -> None:
        self.labels = labels
        self.moves: Int64Array = np.zeros(0, dtype=np.int64)
        self.lengths: Int64Array = np.zeros(0, dtype=np.int64)
        self.targets: Int64Array = np.zeros(0, dtype=np.int64)

    def column(self, label: int) -> int:
        """The number of a label."""
        return int(np.searchsorted(self.labels, label))

    def add(self, moves: Int64Array, lengths: Int64Array, targets: Int64Array) -> None:
        """Add moves that were not known."""
        moves = np.concatenate([self.moves, moves])
        lengths = np.concatenate([self.lengths, lengths])
        targets = np.concatenate([self.targets, targets])
        order = np.argsort(moves, kind="stable")
        begins = np.cumsum(lengths) - lengths
        self.moves, self.lengths = moves[order], lengths[order]
        ends = np.cumsum(self.lengths)
        places = np.arange(len(targets)) - np.repeat(ends - self.lengths, self.lengths)
        self.targets = targets[places + np.repeat(begins[order], self.lengths)]

    def moves_of_states(self, states: int) -> Int64Array:
        """How many moves of each state are known."""
        return np.bincount(self.moves // max(1, len(self.labels)), minlength=states)

    @classmethod
    def whole(cls, lts: Lts, labels: list[int]) -> _Part:
        """All of a component."""
        part = cls(labels)
        columns = np.searchsorted(labels, lts.labels)
        columns[columns == len(labels)] = 0
        states = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
        wanted = np.array(labels, dtype=np.int64)[columns] == lts.labels if labels else np.zeros(0, dtype=np.bool_)
        moves = (states * len(labels) + columns)[wanted] if labels else np.zeros(0, dtype=np.int64)
        found, lengths = np.unique(moves, return_counts=True)
        # The transitions of a state are ordered by their labels, so the moves are ascending already.
        part.add(found, lengths, lts.targets[wanted] if labels else part.targets)
        return part


class _Growth:
    """The exploration; see :func:`together`."""

    def __init__(
        self,
        composition: LazyComposition,
        room: Callable[[int, int], bool],
        poll: Callable[[int], None] | None,
        growing: Kernels,
        searching: Kernels,
    ) -> None:
        self._composition = composition
        self._has_room = room
        self._poll = poll
        self._kernels = growing
        self._searching = searching
        slots = composition.network.slots
        self._states: dict[int, list[int]] = {slot: [composition.initial[slot]] for slot in composition.chased}
        self._numbers = {slot: {states[0]: 0} for slot, states in self._states.items()}
        labels: list[set[int]] = [set() for _ in slots]
        for rule in composition.network.rules:
            for slot, label in rule.moves:
                labels[slot].add(label)
        self._parts = [
            _Part(sorted(own)) if slot in composition.chased else _Part.whole(slots[slot].lts, sorted(own))
            for slot, own in enumerate(labels)
        ]
        widths = [
            WIDTH if i in composition.chased else (slot.lts.states - 1).bit_length() for i, slot in enumerate(slots)
        ]
        self._layout: Layout = layout_of([0, *widths])
        self._visited = Visited(self._layout.words)
        self._rules = self._company_rules()
        self._company = self._as_known()
        participants = max((len(rule.moves) for rule in composition.network.rules), default=1)
        self._scratch = [np.zeros(participants, dtype=np.int64) for _ in range(4)]
        self._take_room(FIRST_ROOM)

    def _take_room(self, words: int) -> None:
        room = np.empty(words, dtype=np.int64), np.empty(words, dtype=np.int64), np.empty(CHUNK, dtype=np.int64)
        self._outcome = Outcome(*room, *self._scratch)

    def _company_rules(self) -> dict[str, Int64Array]:
        """The arrays of :class:`Company` that stay: fields and rules."""
        fields = self._layout.slots
        asked, asked_labels = [0], []
        first_label, driven, others, other, other_label = [], [0], [0], [], []
        for slot, part in enumerate(self._parts):
            first_label.append(len(driven) - 1)
            for column, label in enumerate(part.labels):
                rules = self._composition.driven[slot].get(label, [])
                if rules:
                    asked_labels.append(column)
                for _, moves in rules:
                    # Those that grow come last: nothing is worked out that another does not join in.
                    for place, its_label in sorted(moves, key=lambda move: move[0] in self._composition.chased):
                        other.append(place)
                        other_label.append(self._parts[place].column(its_label))
                    others.append(len(other))
                driven.append(len(others) - 1)
            asked.append(len(asked_labels))
        arrays = {
            "word": [field.word for field in fields],
            "shift": [field.shift for field in fields],
            "mask": [(1 << field.width) - 1 for field in fields],
            "asked": asked,
            "asked_labels": asked_labels,
            "first_label": first_label,
            "driven": driven,
            "others": others,
            "other": other,
            "other_label": other_label,
        }
        return {name: np.array(values, dtype=np.int64) for name, values in arrays.items()}

    def _as_known(self) -> Company:
        """The components as far as they are known now."""
        parts, slots = self._parts, self._composition.network.slots
        sizes = [
            len(self._states[slot]) if slot in self._states else slots[slot].lts.states for slot in range(len(parts))
        ]
        lengths = np.concatenate([part.lengths for part in parts])
        known = np.concatenate([part.moves_of_states(size) for part, size in zip(parts, sizes, strict=True)])
        return Company(
            grows=np.array([slot in self._states for slot in range(len(parts))], dtype=np.uint8),
            first_row=np.cumsum([0, *sizes[:-1]], dtype=np.int64),
            known=np.concatenate([[0], np.cumsum(known)]).astype(np.int64),
            labels=np.concatenate([part.moves % max(1, len(part.labels)) for part in parts]),
            offsets=np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
            targets=np.concatenate([part.targets for part in parts]).astype(np.int32),
            **self._rules,
        )

    def run(self) -> None:
        """Explore the whole."""
        initial = [0 if i in self._states else local for i, local in enumerate(self._composition.initial)]
        self._add(packed_state(self._layout, 0, initial))
        first = 0
        while first < self._visited.known:
            if self._poll is not None:
                self._poll(self._visited.known)
            if not self._has_room(self._visited.known, self._visited.bytes_after_growth()):
                raise TooLarge(self._visited.known)
            until = min(self._visited.known, first + CHUNK)
            pending = self._expanded(None, first, until)
            while pending is not None:
                pending = self._expanded(pending, 0, len(pending) // self._visited.stride)
            first = until

    def _expanded(self, rows: Int64Array | None, first: int, end: int) -> Int64Array | None:
        """Add the successors of some rows, by default of the visited.

        Returns:
            The rows that lacked something, which is known now; None if none did.
        """
        stride = self._visited.stride
        questions: list[Int64Array] = []
        lacking: list[Int64Array] = []
        while first < end:
            given = self._visited.rows if rows is None else rows
            following, found, asked, pending = self._kernels.expand_together(
                self._company, given, first, end, stride, self._outcome
            )
            outcome = self._outcome
            if asked:
                questions.append(np.unique(outcome.questions[: 3 * asked].reshape(-1, 3), axis=0))
                lacking.append(given.reshape(-1, stride)[outcome.pending[:pending]].reshape(-1))
            self._add(outcome.rows[: found * stride])
            if following == first:
                self._take_room(2 * len(outcome.rows))
            first = following
        if not questions:
            return None
        self._answer(np.unique(np.concatenate(questions), axis=0))
        return np.concatenate(lacking)

    def _add(self, rows: Int64Array) -> None:
        count, place = len(rows) // self._visited.stride, 0
        while True:
            place = self._visited.insert(self._searching, rows, place, count)
            if place == count:
                return
            self._visited.grow(self._searching)

    def _answer(self, questions: Int64Array) -> None:
        """Work out transitions of the components that grow, given by component, local state and label."""
        for slot in distinct(questions[:, 0]).tolist():
            part, chased = self._parts[slot], self._composition.chased[slot]
            states, numbers = self._states[slot], self._numbers[slot]
            asked = questions[questions[:, 0] == slot]
            lengths, targets = [], []
            for _, state, column in asked.tolist():
                after = chased.after(states[state], part.labels[column])
                for target in after:
                    number = numbers.get(target)
                    if number is None:
                        number = numbers[target] = len(states)
                        states.append(target)
                    targets.append(number)
                lengths.append(len(after))
            if len(states) > 1 << WIDTH:
                raise TooLarge(self._visited.known)
            moves = asked[:, 1] * len(part.labels) + asked[:, 2]
            part.add(moves, np.array(lengths, dtype=np.int64), np.array(targets, dtype=np.int64))
        self._company = self._as_known()

    def network(self) -> Network:
        """The network with what is known of the components."""
        machines = {}
        for slot, states in self._states.items():
            part = self._parts[slot]
            sources = np.repeat(part.moves // max(1, len(part.labels)), part.lengths)
            columns = np.repeat(part.moves % max(1, len(part.labels)), part.lengths)
            labels = np.array(part.labels, dtype=np.int64)[columns]
            machines[slot] = machine(len(states), sources, labels, part.targets), states
        return self._composition.network_of(machines)
