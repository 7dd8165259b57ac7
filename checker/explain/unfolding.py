"""A run found in a composed and minimised network, unfolded into one of the network that the script has.

Each composed part is taken apart again: a run of the pair that it was made of is looked for that performs the same
labels and can end in a state that offers no more. Since minimising has kept traces and failures there is one. What
happens inside a part, which its minimised machine does not show, comes in before the next label that it shares with
others; so the runs of all parts fit together. The outcome is a run of the whole, though not a shortest one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from cspcheck.checker.lts import Lts
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.reduction.composing import ComposedNetwork, ComposedPart, Joint, product, relabelled
from cspcheck.checker.search.paths import PathStep
from cspcheck.cspm.process.events import TAU

Edge = tuple[int, int, int]
"""A source, a label and a target."""
_Ends = frozenset[int] | None
"""A run ends in a state without taus that offers no more than this; None: in any state."""


class NotUnfolded(Exception):
    """There is no such run, or it is not found: the failure has to be looked for in another way."""


@dataclass(eq=False, slots=True)
class _Happening:
    """One step of the whole: what each part performs, and for components of the network what they are afterwards."""

    labels: dict[int, int] = field(default_factory=dict)
    targets: dict[int, int] = field(default_factory=dict)


def unfolded(
    packed: PackedNetwork,
    composition: ComposedNetwork,
    small: PackedNetwork,
    path: Sequence[PathStep],
    event: int | None = None,
) -> tuple[PathStep, ...]:
    """The run of a network that a run of what was composed of it stands for.

    Args:
        packed: the network.
        composition: what was composed of it.
        small: the network of that, packed.
        path: a run of it that ends in a state without taus; or in one that can perform an event.
        event: this event. The run that is given can be followed by it, too.

    Raises:
        NotUnfolded: the run cannot be unfolded.
    """
    run, ends = _composed_run(composition, small, path, event)
    pending = list(zip(composition.parts, ends, strict=True))
    while pending:
        part, offers = pending.pop()
        if part.pair is None:
            run = _component(packed, part, offers, run)
        else:
            run, rest = _pair(part, part.pair, offers, run)
            pending.extend(rest)
    steps = _steps(packed, run)
    if event is None:
        return steps
    if steps[-1].event != event:
        raise NotUnfolded
    return steps[:-1]


def _composed_run(
    composition: ComposedNetwork, small: PackedNetwork, path: Sequence[PathStep], event: int | None
) -> tuple[list[_Happening], list[_Ends]]:
    """The run as the parts see it, with the event that follows if there is one, and how it must end for each part."""
    run = []
    for step in path:
        moves = composition.network.rules[step.rule].moves
        run.append(_Happening({composition.parts[slot].number: label for slot, label in moves}))
    last = small.initial if not path else np.array(path[-1].state, dtype=np.int64)
    offers = [_offers(part.lts, s) for part, s in zip(composition.parts, small.local_states(last), strict=True)]
    if event is None:
        return run, list(offers)
    for rule in composition.network.rules:
        if rule.result == event and all(label in offers[slot] for slot, label in rule.moves):
            run.append(_Happening({composition.parts[slot].number: label for slot, label in rule.moves}))
            return run, [None] * len(offers)
    raise NotUnfolded


def _offers(lts: Lts, state: int) -> frozenset[int]:
    return frozenset(label for label, _ in lts.successors(state))


def _pair(
    part: ComposedPart, pair: tuple[ComposedPart, ComposedPart], offers: _Ends, run: list[_Happening]
) -> tuple[list[_Happening], list[tuple[ComposedPart, _Ends]]]:
    """The run with two parts in the place of one, and what each of them offers at its end."""
    one, other = pair
    made = product(one.lts, other.lts, part.joints)
    if made is None:
        raise NotUnfolded
    whole, states = made
    edges = _run_of(whole, _visible(part, run), offers)
    width = other.lts.states

    def performed(edge: Edge) -> _Happening:
        source, label, target = edge
        joint = _joint(
            one.lts,
            other.lts,
            part.joints,
            label,
            divmod(int(states[source]), width),
            divmod(int(states[target]), width),
        )
        labels = {}
        if joint.left is not None:
            labels[one.number] = joint.left
        if joint.right is not None:
            labels[other.number] = joint.right
        return _Happening(labels)

    left, right = divmod(int(states[edges[-1][2] if edges else whole.root]), width)
    rest: list[tuple[ComposedPart, _Ends]] = [(one, None), (other, None)]
    if offers is not None:
        rest = [(one, _offers(one.lts, left)), (other, _offers(other.lts, right))]
    return _merged(part, run, [(edge[1], performed(edge)) for edge in edges]), rest


def _joint(
    one: Lts, other: Lts, joints: Collection[Joint], label: int, before: tuple[int, int], after: tuple[int, int]
) -> Joint:
    """How two parts perform a label together between two pairs of states."""

    def moves(lts: Lts, own: int | None, source: int, target: int) -> bool:
        return source == target if own is None else (own, target) in lts.successors(source)

    for joint in joints:
        if (
            joint.label == label
            and moves(one, joint.left, before[0], after[0])
            and moves(other, joint.right, before[1], after[1])
        ):
            return joint
    raise NotUnfolded


def _component(packed: PackedNetwork, part: ComposedPart, offers: _Ends, run: list[_Happening]) -> list[_Happening]:
    """The run with the states and labels of a component of the network."""
    assert part.slot is not None
    slot = packed.network.slots[part.slot]
    root = dict(packed.network.initial).get(part.slot, 0)
    lts = relabelled(
        Lts(slot.lts.offsets, slot.lts.labels, slot.lts.targets, root), {old: new for new, old in part.labels}
    )
    edges = _run_of(lts, _visible(part, run), offers)
    names = set(part.labels)
    performed = []
    for source, label, target in edges:
        # Of several labels that stand for one, any that leads there: the same becomes of them.
        own = next(old for old, there in slot.lts.successors(source) if there == target and (label, old) in names)
        performed.append((label, _Happening({-1 - part.slot: own}, {part.slot: target})))
    return _merged(part, run, performed)


def _visible(part: ComposedPart, run: list[_Happening]) -> list[int]:
    """What a part performs in a run, its taus apart."""
    labels = (happening.labels.get(part.number, TAU) for happening in run)
    return [label for label in labels if label != TAU]


def _merged(part: ComposedPart, run: list[_Happening], performed: list[tuple[int, _Happening]]) -> list[_Happening]:
    """The run with what stands for a part instead of the part: its taus come before what it performs next."""
    following = iter(performed)

    def until_visible() -> Iterator[tuple[int, _Happening]]:
        for label, inside in following:
            yield label, inside
            if label != TAU:
                return

    merged = []
    for happening in run:
        label = happening.labels.pop(part.number, None)
        if label == TAU:
            continue  # a tau of the part's minimised machine alone: its own run has others
        if label is not None:
            for own, inside in until_visible():
                if own == TAU:
                    merged.append(inside)
                else:
                    happening.labels.update(inside.labels)
                    happening.targets.update(inside.targets)
        merged.append(happening)
    merged.extend(inside for _, inside in following)
    return merged


def _run_of(lts: Lts, labels: Sequence[int], offers: _Ends) -> list[Edge]:
    """A run of a machine with the given labels, taus apart, that ends as it must.

    Raises:
        NotUnfolded: there is none.
    """
    start = (0, lts.root)
    came_by: dict[tuple[int, int], tuple[tuple[int, int], Edge] | None] = {start: None}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        position, state = here
        if position == len(labels):
            if offers is None:
                return _back(came_by, here)
            own = _offers(lts, state)
            if TAU not in own and own <= offers:
                return _back(came_by, here)
        for label, target in lts.successors(state):
            follows = position < len(labels) and label == labels[position] and label != TAU
            if label == TAU or follows:
                there = (position + follows, target)
                if there not in came_by:
                    came_by[there] = here, (state, label, target)
                    queue.append(there)
    raise NotUnfolded


def _back(came_by: dict[tuple[int, int], tuple[tuple[int, int], Edge] | None], end: tuple[int, int]) -> list[Edge]:
    edges = []
    while (came := came_by[end]) is not None:
        end, edge = came
        edges.append(edge)
    return edges[::-1]


def _steps(packed: PackedNetwork, run: list[_Happening]) -> tuple[PathStep, ...]:
    """The run as steps of the network."""
    rules: dict[tuple[tuple[int, int], ...], int] = {}
    for number, rule in enumerate(packed.network.rules):
        rules.setdefault(tuple(sorted(rule.moves)), number)
    local = list(packed.local_states(packed.initial))
    steps = []
    for happening in run:
        fired = rules.get(tuple(sorted((-1 - slot, label) for slot, label in happening.labels.items())))
        if fired is None:
            raise NotUnfolded
        for slot, target in happening.targets.items():
            local[slot] = target
        state = tuple(packed.pack(0, local).tolist())
        steps.append(PathStep(packed.network.rules[fired].result, fired, state))
    return tuple(steps)
