"""Reduction by itself: a network composed two by two and minimised in between, so that most of it is never explored.

Components that act together are composed, what happens between the two alone becomes internal if the question is not
about it, and the result is made as small as the question allows; and so on, in an order taken from the rules, as long
as components stay small. (Smart reduction: Crouzen and Lang, "Smart Reduction", FASE 2011.) What is left is a network
again, of fewer and smaller components.

The equivalences keep what is asked for in every context that rules can make: traces and stable failures (F), or
failures and divergences (FD). The labels of composed components are numbered by the structure alone, so that equal
parts of a system (a thousand philosophers) are composed and minimised once.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.lts import Lts, machine, reachable, sources
from cspcheck.checker.network.network import Network, Rule, Slot
from cspcheck.checker.reduction.bisimulation import delay_bisimulation, factor_tau_loops, strong_bisimulation
from cspcheck.checker.reduction.compression import eliminate_diamonds
from cspcheck.checker.sparse_rows import gather_rows
from cspcheck.checker.specification.normal_form import FailuresModel
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK

MOST_PRODUCT = 50_000
"""Pairs of states past which two components are not composed."""
MOST_MOVES = 1_000_000
"""Transitions past which they are not."""
MOST_WORK = 3_000_000
"""When so many transitions have been composed nothing more is."""
KEPT_STATES = 1_000
"""A composed component with more states than this is kept only if minimising has made it a good deal smaller."""
DIAMONDS = 300
"""Machines with more states than this are left as delay bisimulation has them."""
ALIKE = 5_000
"""Pairs of states past which two that do not act together are not composed."""
MANY = 6
"""Of a rule with more participants than this only neighbours are composed."""

Moves = dict[int, int]
"""What the parts that take part in a rule perform: label by number of the part."""


@dataclass(frozen=True, slots=True)
class Joint:
    """One way in which two parts, or one of them, take part in what the pair of them performs.

    Attributes:
        left, right: the labels of the two; None for one that takes no part.
        label: the label of the pair.
    """

    left: int | None
    right: int | None
    label: int


@dataclass(frozen=True, eq=False, slots=True)
class ComposedPart:
    """A component, or several that have been composed.

    Attributes:
        number: tells it from all others.
        lts: its machine, minimised. 0 is tau, 1 is tick; other labels mean what the rules say.
        slot: the component of the network, for a single one.
        labels: for a single one, the labels in the network's slot that each label stands for: (label, slot's label).
        pair: the two parts that a composed one is made of.
        joints: how these act together.
    """

    number: int
    lts: Lts
    slot: int | None = None
    labels: tuple[tuple[int, int], ...] = ()
    pair: tuple[ComposedPart, ComposedPart] | None = None
    joints: tuple[Joint, ...] = ()


class NotComposable(Exception):
    """The network is not one that can be composed two by two."""


@dataclass(eq=False, slots=True)
class ComposedNetwork:
    """What is left of a network.

    Attributes:
        network: the network that is left.
        parts: what its components are.
        states, transitions: what was composed on the way, before it was minimised.
    """

    network: Network
    parts: tuple[ComposedPart, ...]
    states: int
    transitions: int


def composed(
    network: Network,
    model: FailuresModel,
    visible: Callable[[int], int],
    poll: Callable[[], None] = lambda: None,
    *,
    by_ties: bool = False,
    most: int = MOST_PRODUCT,
) -> ComposedNetwork:
    """What is left of a network when its components have been composed as far as that makes it smaller.

    Args:
        network: a network of one format.
        model: F keeps traces and stable failures, FD failures and divergences.
        visible: the event that an event of the network counts as; tau for one that does not matter. Tick stays.
        poll: called now and then; what it raises ends the work.
        by_ties: whether of two pairs the one with more rules in common may come before one with fewer states: what
            many depend on (the facts that messages are made of) is put together before each of those has it.
        most: pairs of states past which two components are not composed.

    Raises:
        Unsuited: the network has formats, rules that give way to others (what a part may do then depends on all the
            others), or termination that is no part of every component.
    """
    if network.formats != 1 or any(rule.raises or rule.yields for rule in network.rules):
        raise NotComposable
    work = _Work(network, model, visible, by_ties, most)
    work.run(poll)
    return work.result()


@dataclass(eq=False, slots=True)
class _Live:
    """A rule over the parts that there are at the moment."""

    result: int
    moves: Moves


@dataclass(eq=False)
class _Work:
    network: Network
    model: FailuresModel
    visible: Callable[[int], int]
    by_ties: bool
    most: int
    parts: dict[int, ComposedPart] = field(default_factory=dict)
    rules: dict[int, _Live] = field(default_factory=dict)
    rules_of: dict[int, set[int]] = field(default_factory=dict)
    states: int = 0
    transitions: int = 0

    def __post_init__(self) -> None:
        self._minimised: dict[tuple[bytes, bytes, bytes], Lts] = {}
        self._products: dict[tuple[int, int, tuple[Joint, ...]], tuple[Lts, int]] = {}
        self._next = len(self.network.slots) + len(self.network.rules)
        # For each event that parts show without others: these parts, and by how many rules.
        self.alone: dict[int, dict[int, int]] = {}
        labels = self._labels()
        by_key: dict[tuple[int, tuple[tuple[int, int], ...]], int] = {}
        for rule in self.network.rules:
            result = rule.result if rule.result in (TAU, TICK) else self.visible(rule.result)
            if any(label not in labels[slot] for slot, label in rule.moves):
                continue
            moves = tuple((slot, labels[slot][label]) for slot, label in rule.moves)
            by_key.setdefault((result, moves), len(by_key))
        self.rules_of = {part: set() for part in range(len(self.network.slots))}
        for (result, moves), number in by_key.items():
            self._add(number, _Live(result, dict(moves)))
        for part, slot in enumerate(self.network.slots):
            joints, meanings = _joints(self._meanings(part))
            self._replace(self.rules_of[part], part, meanings)
            # Several labels of the slot may be one of the part: the same becomes of them.
            names = {joint.left: joint.label for joint in joints}
            made = {old: names[label] for old, label in labels[part].items() if label in names}
            lts = reachable(relabelled(replace(slot.lts, root=self._initial(part)), made))
            own = tuple((label, old) for old, label in made.items())
            self.parts[part] = ComposedPart(part, self._minimal(lts), slot=part, labels=own)

    def _initial(self, slot: int) -> int:
        return dict(self.network.initial).get(slot, 0)

    def _labels(self) -> list[dict[int, int]]:
        """For each slot the labels that take part in a rule which can ever fire, numbered anew in their order."""
        alphabets = [set(slot.lts.alphabet()) for slot in self.network.slots]
        used: list[set[int]] = [set() for _ in alphabets]
        for rule in self.network.rules:
            if all(label in alphabets[slot] for slot, label in rule.moves):
                for slot, label in rule.moves:
                    if (label == TICK) != (rule.result == TICK):
                        raise NotComposable
                    used[slot].add(label)
        return [
            {label: label if label < FIRST_EVENT else FIRST_EVENT + i for i, label in enumerate(sorted(labels))}
            for labels in used
        ]

    def run(self, poll: Callable[[], None]) -> None:
        """Compose pairs, those first that make the fewest states, until none is worth it.

        Those that act together come first. Then those that only look alike: of equal components side by side it
        matters how many are where, not which.
        """
        waiting: list[tuple[float, int, int]] = []
        later: list[tuple[float, int, int]] = []
        tried: set[tuple[int, int]] = set()

        def offer(pairs: Iterable[tuple[int, int]], where: list[tuple[float, int, int]]) -> None:
            for one, other in pairs:
                pair = (min(one, other), max(one, other))
                if pair not in tried:
                    tried.add(pair)
                    heapq.heappush(where, (self._cost(*pair), *pair))

        for rule in self.rules.values():
            offer(_neighbours(rule.moves), waiting)
        for parts in self.alone.values():
            offer(_neighbours(parts), later)
        while waiting or later:
            most, (_, one, other) = (self.most, heapq.heappop(waiting)) if waiting else (ALIKE, heapq.heappop(later))
            if one not in self.parts or other not in self.parts:
                continue
            if self._size(one, other) > min(most, self.most):
                continue
            if self.transitions > MOST_WORK:
                break
            poll()
            number = self._compose(self.parts[one], self.parts[other])
            if number is not None:
                rules = [self.rules[rule] for rule in self.rules_of[number]]
                offer((pair for rule in rules for pair in _neighbours(rule.moves) if number in pair), waiting)
                alike = [self.alone[event] for event in {rule.result for rule in rules} if event in self.alone]
                offer((pair for parts in alike for pair in _neighbours(parts) if number in pair), later)

    def _cost(self, one: int, other: int) -> float:
        """How late a pair is composed; without ties by its size."""
        return self._size(one, other) / (max(1, len(self._shared(one, other))) if self.by_ties else 1)

    def _shared(self, one: int, other: int) -> set[int]:
        """The rules that two parts take part in together."""
        return self.rules_of[one] & self.rules_of[other]

    def _size(self, one: int, other: int) -> int:
        return self.parts[one].lts.states * self.parts[other].lts.states

    def _compose(self, one: ComposedPart, other: ComposedPart) -> int | None:
        """Put a pair in the place of two parts; None if that is not worth while."""
        concerned = self.rules_of[one.number] | self.rules_of[other.number]
        joints, labels = _joints(self._meanings(one.number, other.number))
        made = self._product(one, other, joints)
        if made is None:
            return None
        lts, before = made
        if lts.states > KEPT_STATES and 2 * lts.states > before:
            return None
        if not self._shared(one.number, other.number) and 4 * lts.states > 3 * before:
            return None  # two equal states of two equal components, the least of this kind, make three states of four
        number = self._next
        self._next += 1
        self.parts[number] = ComposedPart(number, lts, pair=(one, other), joints=joints)
        self.rules_of[number] = set()
        del self.parts[one.number], self.parts[other.number]
        performed = set(lts.alphabet())
        kept = {meaning: label for meaning, label in labels.items() if label in performed}
        self._replace(concerned, number, kept)
        return number

    def _meanings(self, one: int, other: int | None = None) -> Meanings:
        """What becomes of what one or two parts perform."""
        meanings: Meanings = {}
        for number in self.rules_of[one] | (set() if other is None else self.rules_of[other]):
            rule = self.rules[number]
            rest = tuple(sorted((p, label) for p, label in rule.moves.items() if p not in (one, other)))
            key = (rule.moves.get(one), None if other is None else rule.moves.get(other))
            meanings.setdefault(key, set()).add((rule.result, rest))
        return meanings

    def _replace(self, concerned: Collection[int], part: int, labels: dict[Meaning, int]) -> None:
        """Have rules for the labels of a part in the place of others."""
        for number in list(concerned):
            self._remove(number)
        for meaning, label in labels.items():
            for result, rest in sorted(meaning):
                self._add(self._next, _Live(result, {part: label, **dict(rest)}))
                self._next += 1

    def _add(self, number: int, rule: _Live) -> None:
        self.rules[number] = rule
        for part in rule.moves:
            self.rules_of[part].add(number)
            if len(rule.moves) == 1 and rule.result not in (TAU, TICK):
                showing = self.alone.setdefault(rule.result, {})
                showing[part] = showing.get(part, 0) + 1

    def _remove(self, number: int) -> None:
        rule = self.rules.pop(number)
        for part in rule.moves:
            self.rules_of[part].discard(number)
            if len(rule.moves) == 1 and rule.result not in (TAU, TICK):
                showing = self.alone[rule.result]
                showing[part] -= 1
                if not showing[part]:
                    del showing[part]

    def _product(self, one: ComposedPart, other: ComposedPart, joints: tuple[Joint, ...]) -> tuple[Lts, int] | None:
        """The minimised machine of a pair, and how many states it had before."""
        key = (id(one.lts), id(other.lts), joints)
        found = self._products.get(key)
        if found is None:
            whole = product(one.lts, other.lts, joints)
            if whole is None:
                return None
            self.states += whole[0].states
            self.transitions += whole[0].transitions
            # The parts are kept in the result, so their identities stay theirs.
            found = self._products[key] = (self._minimal(whole[0]), whole[0].states)
        return found

    def _minimal(self, lts: Lts) -> Lts:
        """The machine made smaller; one object for equal machines."""
        key = (lts.offsets.tobytes(), lts.labels.tobytes(), lts.targets.tobytes() + lts.root.to_bytes(8, "little"))
        found = self._minimised.get(key)
        if found is None:
            small = minimal(lts, self.model)
            same = (small.offsets.tobytes(), small.labels.tobytes(), small.targets.tobytes() + bytes(8))
            found = self._minimised[key] = self._minimised.setdefault(same, small)
        return found

    def result(self) -> ComposedNetwork:
        """The network of the parts that are left."""
        order = sorted(self.parts)
        place = {number: slot for slot, number in enumerate(order)}
        slots = tuple(Slot(f"part {place[n] + 1}", None, self.parts[n].lts, ()) for n in order)
        rules = sorted(
            (rule.result, tuple(sorted((place[part], label) for part, label in rule.moves.items())))
            for rule in self.rules.values()
        )
        network = Network(
            slots,
            tuple(Rule(result, moves, result) for result, moves in rules),
            initial=tuple((slot, 0) for slot in range(len(slots))),
            terminated=any(result == TICK for result, _ in rules),
        )
        return ComposedNetwork(network, tuple(self.parts[n] for n in order), self.states, self.transitions)


def _neighbours(moves: Collection[int]) -> Iterable[tuple[int, int]]:
    parts = sorted(moves)
    if len(parts) > MANY:
        return list(pairwise(parts))
    return [(one, other) for i, one in enumerate(parts) for other in parts[i + 1 :]]


Meaning = frozenset[tuple[int, tuple[tuple[int, int], ...]]]
"""What becomes of a label: results of the whole, each with what other parts must perform for it."""


Meanings = dict[tuple[int | None, int | None], set[tuple[int, tuple[tuple[int, int], ...]]]]
"""What becomes of what two parts perform, either of them or both."""


def _joints(meanings: Meanings) -> tuple[tuple[Joint, ...], dict[Meaning, int]]:
    """Labels for the ways in which two parts act; ways with the same meaning have the same label."""
    labels: dict[Meaning, int] = {}
    joints = []
    fresh = FIRST_EVENT
    for left, right in sorted(meanings, key=lambda key: tuple(-1 if label is None else label for label in key)):
        meaning = frozenset(meanings[left, right])
        label = labels.get(meaning)
        if label is None:
            results = {result for result, _ in meaning}
            if meaning == {(TAU, ())}:
                label = TAU
            elif TICK in results:
                if len(results) > 1 or TICK in labels.values():
                    raise NotComposable
                label = TICK
            else:
                label, fresh = fresh, fresh + 1
            labels[meaning] = label
        joints.append(Joint(left, right, label))
    return tuple(joints), labels


def product(one: Lts, other: Lts, joints: Collection[Joint]) -> tuple[Lts, Int64Array] | None:
    """The machine of two that act together, and which pair each of its states is: ``left * other.states + right``.

    None if it has too many transitions.
    """
    width = other.states
    left, right = _by_label(one), _by_label(other)
    everyone_left, everyone_right = np.arange(one.states), np.arange(width)
    starts, labels, targets = [], [], []
    total = 0
    for joint in joints:
        sources_left, targets_left = (everyone_left, everyone_left) if joint.left is None else left(joint.left)
        sources_right, targets_right = (everyone_right, everyone_right) if joint.right is None else right(joint.right)
        total += len(sources_left) * len(sources_right)
        if total > MOST_MOVES:
            return None
        starts.append((sources_left[:, None] * width + sources_right).reshape(-1))
        targets.append((targets_left[:, None] * width + targets_right).reshape(-1))
        labels.append(np.full(len(starts[-1]), joint.label, dtype=np.int64))
    none = np.zeros(0, dtype=np.int64)
    lts, pairs = _reached(
        one.states * width,
        np.concatenate([none, *starts]),
        np.concatenate([none, *labels]),
        np.concatenate([none, *targets]),
        one.root * width + other.root,
    )
    return lts, pairs


def _by_label(lts: Lts) -> Callable[[int], tuple[Int64Array, Int64Array]]:
    order = np.argsort(lts.labels, kind="stable")
    labels, starts, targets = lts.labels[order], sources(lts)[order], lts.targets[order]

    def transitions(label: int) -> tuple[Int64Array, Int64Array]:
        span = slice(*np.searchsorted(labels, [label, label + 1]).tolist())
        return starts[span], targets[span]

    return transitions


def _reached(
    states: int, starts: Int64Array, labels: Int64Array, targets: Int64Array, root: int
) -> tuple[Lts, Int64Array]:
    """What is reached from the root, in the order of the numbers but the root first; and what each state was."""
    order = np.argsort(starts, kind="stable")
    starts, labels, targets = starts[order], labels[order], targets[order]
    offsets = np.concatenate([[0], np.cumsum(np.bincount(starts, minlength=states))]).astype(np.int64)
    seen = np.zeros(states, dtype=np.bool_)
    seen[root] = True
    frontier = np.array([root], dtype=np.int64)
    while len(frontier):
        found = targets[gather_rows(offsets, frontier)]
        frontier = distinct(found[~seen[found]])
        seen[frontier] = True
    members = np.flatnonzero(seen)
    members = np.concatenate([[root], members[members != root]]).astype(np.int64)
    number = np.full(states, -1, dtype=np.int64)
    number[members] = np.arange(len(members))
    kept = seen[starts]
    return machine(len(members), number[starts[kept]], labels[kept], number[targets[kept]]), members


def minimal(lts: Lts, model: FailuresModel) -> Lts:
    """A small machine with the same traces and failures, in FD also the same divergences, in every context."""
    small = strong_bisimulation(lts)
    if not (small.labels == TAU).any():
        return small
    if model == "F":
        small = strong_bisimulation(_without_harmless_loops(small))
    small = delay_bisimulation(small)
    if small.states <= DIAMONDS and (small.labels == TAU).any():
        other = strong_bisimulation(eliminate_diamonds(small))
        if (other.states, other.transitions) < (small.states, small.transitions):
            small = other
    return small


def _without_harmless_loops(lts: Lts) -> Lts:
    """The machine without cycles of taus, but for a tau to itself where there is no other tau to keep it unstable."""
    lts = factor_tau_loops(lts)
    starts = sources(lts)
    tau = lts.labels == TAU
    loop = tau & (starts == lts.targets)
    leaving = np.bincount(starts[tau & ~loop], minlength=lts.states) > 0
    kept = ~(loop & leaving[starts])
    return reachable(machine(lts.states, starts[kept], lts.labels[kept], lts.targets[kept], lts.root))


def relabelled(lts: Lts, labels: dict[int, int]) -> Lts:
    """The machine with other labels, and without the transitions that have none."""
    events, columns = np.unique(lts.labels, return_inverse=True)
    new = np.array([labels.get(event, -1) for event in events.tolist()], dtype=np.int64)[columns]
    kept = new >= 0
    return machine(lts.states, sources(lts)[kept], new[kept], lts.targets[kept], lts.root)
