"""From machines and networks to pictures."""

from __future__ import annotations

from collections.abc import Callable

from checker.lts import Lts
from checker.network import Network
from cspcheck.drawing.picture import Edge, Node, Picture
from cspm.events import TAU, TICK, EventTable


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
            nodes.append(Node(str(i), "initial", hint))
        elif i in terminated:
            nodes.append(Node(str(i), "terminated", hint or "terminated"))
        else:
            nodes.append(Node(str(i), "state" if rows[i] else "deadlock", hint))
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
    A component's own events are listed as its hint.
    """
    joined: dict[tuple[int, ...], dict[str, None]] = {}
    own: dict[int, dict[str, None]] = {}
    for rule in network.rules:
        if rule.cause in (TAU, TICK):
            continue
        channel = events.parts(rule.cause)[0].name
        participants = tuple(slot for slot, _ in rule.moves)
        if len(participants) > 1:
            joined.setdefault(participants, {})[channel] = None
        else:
            own.setdefault(participants[0], {})[channel] = None
    nodes = [
        Node(slot.name, "component", f"own: {', '.join(own[i])}" if i in own else "")
        for i, slot in enumerate(network.slots)
    ]
    edges = []
    for participants, channels in joined.items():
        labels = tuple(channels)
        if len(participants) == 2:
            edges.append(Edge(*participants, labels, "channel"))
            continue
        nodes.append(Node("", "junction", ", ".join(labels)))
        edges += [
            Edge(len(nodes) - 1, slot, labels if i == 0 else (), "channel") for i, slot in enumerate(participants)
        ]
    return Picture(title, tuple(nodes), tuple(edges))
