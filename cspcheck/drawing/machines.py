"""From machines and networks to pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from cspcheck.checker.explain.running import distinct_names
from cspcheck.checker.lts import Lts
from cspcheck.checker.network.network import Network
from cspcheck.cspm.process.events import TAU, TICK, EventTable
from cspcheck.cspm.process.terms import Compressed, Hide, Prioritised, Process, Project, Reference, Rename
from cspcheck.drawing.picture import Edge, EdgeKind, Picture, PictureNode, folded


def machine_picture(title: str, lts: Lts, events: EventTable, describe: Callable[[int], str] | None = None) -> Picture:
    """The states and transitions of an explicit machine, the initial state first.

    Args:
        title: what stands above.
        lts: the machine.
        events: names the labels.
        describe: the process expression of a state, shown as its hint.
    """
    order = [lts.root, *(state for state in range(lts.states) if state != lts.root)]
    number = {state: i for i, state in enumerate(order)}
    rows = [list(lts.successors(state)) for state in order]
    terminated = {number[target] for row in rows for label, target in row if label == TICK}
    nodes = []
    for i, state in enumerate(order):
        hint = describe(state) if describe else ""
        if i == 0:
            nodes.append(PictureNode(str(i), "initial", hint))
        elif i in terminated:
            nodes.append(PictureNode(str(i), "terminated", hint if hint and hint != "(terminated)" else "terminated"))
        else:
            nodes.append(PictureNode(str(i), "state" if rows[i] else "deadlock", hint))
    edges: dict[tuple[int, int, bool], list[str]] = {}
    for i, row in enumerate(rows):
        for label, target in row:
            edges.setdefault((i, number[target], label == TAU), []).append(events.name(label))
    return Picture(
        title,
        tuple(nodes),
        tuple(
            Edge(source, target, tuple(labels), "tau" if silent else "event")
            for (source, target, silent), labels in edges.items()
        ),
    )


def architecture_picture(title: str, network: Network, events: EventTable) -> Picture:
    """The components of a composition and the channels that join them.

    A channel that joins two components is a line between them; one that joins more is a line from each to a point.
    Where one side says what is sent (:func:`_says_which`) the line is an arrow. What a component does by
    itself stands in its box.
    """
    joined: dict[tuple[int, ...], dict[str, None]] = {}
    own: dict[int, dict[str, None]] = {}
    labels: dict[tuple[int, str], set[int]] = {}
    for rule in network.rules:
        if rule.cause in (TAU, TICK):
            continue
        channel = events.parts(rule.cause)[0].name
        participants = tuple(slot for slot, _ in rule.moves)
        for slot, label in rule.moves:
            labels.setdefault((slot, channel), set()).add(label)
        if len(participants) > 1:
            joined.setdefault(participants, {})[channel] = None
        else:
            own.setdefault(participants[0], {})[channel] = None
    names = distinct_names(slot.name for slot in network.slots)
    nodes = [
        PictureNode(
            name, "component", f"own: {', '.join(own[i])}" if i in own else "", tuple(folded(tuple(own.get(i, ()))))
        )
        for i, name in enumerate(names)
    ]
    senders = {(slot, channel) for (slot, channel), own in labels.items() if _says_which(network.slots[slot].lts, own)}
    edges = []
    for participants, channels in joined.items():
        if len(participants) == 2:
            edges += _lines(participants, channels, senders)
            continue
        nodes.append(PictureNode("", "junction", ", ".join(channels)))
        edges += [
            Edge(len(nodes) - 1, slot, tuple(channels) if i == 0 else (), "channel")
            for i, slot in enumerate(participants)
        ]
    return Picture(title, tuple(nodes), tuple(edges))


def _lines(pair: tuple[int, ...], channels: Iterable[str], senders: set[tuple[int, str]]) -> list[Edge]:
    """The lines between two components: one each way, and one for the channels of which the way is not known."""
    first, second = pair
    ways: dict[tuple[int, int, EdgeKind], list[str]] = {}
    for channel in channels:
        sending = [slot for slot in pair if (slot, channel) in senders]
        if len(sending) == 1:
            way: tuple[int, int, EdgeKind] = (first, second, "flow") if sending[0] == first else (second, first, "flow")
        else:
            way = (first, second, "channel")
        ways.setdefault(way, []).append(channel)
    return [Edge(source, target, tuple(labels), kind) for (source, target, kind), labels in ways.items()]


def _says_which(machine: Lts, labels: set[int]) -> bool:
    """Whether a component offers never more than one of the events of a channel: the choice is its own (``c!x``).

    Who offers several takes what comes (``c?x``).
    """
    states = np.repeat(np.arange(machine.states), np.diff(machine.offsets))
    chosen = np.isin(machine.labels, np.array(sorted(labels), dtype=np.int64))
    offered = np.unique(np.stack([states, machine.labels])[:, chosen], axis=1)
    return bool(offered.shape[1] == len(np.unique(offered[0])))


def without_priority(process: Process) -> Process:
    """A process without the priorities at its top, which do not change who talks to whom."""
    while isinstance(process, (Reference, Compressed, Prioritised)):
        process = process.body() if isinstance(process, Reference) else process.process
    if isinstance(process, (Hide, Project, Rename)):
        return process.with_active((without_priority(process.process),))
    return process
