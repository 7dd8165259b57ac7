"""Where the nodes and edges of a directed graph go: layered drawing.

The four steps of Sugiyama, Tagawa and Toda (1981): layers (here by distance from the roots, so that a machine reads
from its initial state downwards), dummy nodes on edges that pass layers, fewer crossings by barycentres, and
coordinates that keep long edges straight (each layer is pulled to the median of its neighbours as far as the order
allows). Between any two layers of nodes lies a layer for labels: every edge has a dummy node as wide as its label
there, so that labels take part in the layout and never lie on each other (Gansner, Koutsofios, North, Vo 1993).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import networkx

SWEEPS = 12
"""Rounds of the crossing reduction; more do not help on graphs of a size that a person can read."""
NODE_GAP = 28.0
DUMMY_WIDTH = 14.0
LAYER_GAP = 20.0
LOOP_REACH = 26.0


@dataclass(frozen=True, slots=True)
class Size:
    """Width and height of a node in pixels."""

    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Route:
    """An edge as drawn: through its points, from the border of one node to the border of another.

    ``label`` is the middle of its label; for a loop the middle of the label's left side. ``bow``: it goes in one bow
    through its three points.
    """

    source: int
    target: int
    points: tuple[tuple[float, float], ...]
    label: tuple[float, float]
    bow: bool = False

    def moved(self, right: float, down: float) -> Route:
        """The same route elsewhere."""
        points = tuple((x + right, y + down) for x, y in self.points)
        return replace(self, points=points, label=(self.label[0] + right, self.label[1] + down))


@dataclass(frozen=True, slots=True)
class PictureLayout:
    """Centres of the nodes, routes of the edges (in the order given), and the size of the whole in pixels."""

    centres: tuple[tuple[float, float], ...]
    routes: tuple[Route, ...]
    width: float
    height: float


@dataclass(slots=True)
class _Layered:
    """The graph with dummy nodes: ids past the real nodes are dummies. Even layers hold nodes, odd ones labels."""

    layer: list[int]
    left: list[float]
    right: list[float]
    heights: list[float]
    order: list[list[int]]
    up: dict[int, list[int]] = field(default_factory=dict)
    down: dict[int, list[int]] = field(default_factory=dict)
    chains: list[list[int]] = field(default_factory=list)
    labelled: list[int] = field(default_factory=list)

    def add(self, layer: int, width: float, height: float) -> int:
        """A new node at the right end of a layer."""
        node = len(self.layer)
        self.layer.append(layer)
        self.left.append(width / 2)
        self.right.append(width / 2)
        self.heights.append(height)
        self.order[layer].append(node)
        return node

    def connect(self, above: int, below: int) -> None:
        """An edge between neighbouring layers."""
        self.down.setdefault(above, []).append(below)
        self.up.setdefault(below, []).append(above)


def layered(
    sizes: Sequence[Size],
    edges: Sequence[tuple[int, int]],
    *,
    roots: Sequence[int] = (0,),
    labels: Sequence[Size] = (),
) -> PictureLayout:
    """Lay a graph out from top to bottom.

    Args:
        sizes: one a node; nodes are numbered from 0.
        edges: (source, target); loops, parallel edges and edges in both directions are fine.
        roots: nodes of the first layer; what they do not reach gets layers of its own beside them.
        labels: the size of each edge's label, in the order of *edges*; missing ones are empty.
    """
    if not sizes:
        return PictureLayout((), (), 0.0, 0.0)
    label_sizes = [*labels, *[Size(0.0, 0.0)] * (len(edges) - len(labels))]
    graph = _with_dummies(sizes, edges, _layers(len(sizes), edges, roots), label_sizes)
    _reduce_crossings(graph)
    x = _coordinates(graph)
    leftmost = min(position - graph.left[n] for n, position in enumerate(x))
    x = [position - leftmost for position in x]
    y: list[float] = []
    top = 0.0
    for row in graph.order:
        height = max((graph.heights[n] for n in row), default=0.0)
        y.append(top + height / 2)
        top += height + LAYER_GAP
    places = [(x[n], y[graph.layer[n]]) for n in range(len(x))]
    routes = tuple(_route(edge, i, graph, places, sizes) for i, edge in enumerate(edges))
    width = max(position + graph.right[n] for n, position in enumerate(x))
    return PictureLayout(tuple(places[: len(sizes)]), routes, width, top - LAYER_GAP)


def _layers(nodes: int, edges: Sequence[tuple[int, int]], roots: Sequence[int]) -> list[int]:
    """Distance from the roots; the unreached start anew at layer 0, smallest number first."""
    graph: networkx.DiGraph[int] = networkx.DiGraph()
    graph.add_nodes_from(range(nodes))
    graph.add_edges_from(edges)
    layer: dict[int, int] = {}
    for start in [*roots, *range(nodes)]:
        if start not in layer:
            ways = networkx.single_source_shortest_path_length(graph.subgraph(set(graph) - set(layer)), start)
            layer.update(ways)
    return [layer[node] for node in range(nodes)]


def _with_dummies(
    sizes: Sequence[Size], edges: Sequence[tuple[int, int]], layer: list[int], labels: Sequence[Size]
) -> _Layered:
    bows = any(layer[source] == layer[target] and source != target for source, target in edges)
    graph = _Layered([], [], [], [], [[] for _ in range(2 * max(layer) + 1 + bows)])
    for node, size in enumerate(sizes):
        graph.add(2 * layer[node], size.width, size.height)
    for i, (source, target) in enumerate(edges):
        if source == target:
            graph.right[source] = max(graph.right[source], sizes[source].width / 2 + LOOP_REACH + labels[i].width)
            graph.chains.append([])
            graph.labelled.append(-1)
            continue
        high, low = (source, target) if layer[source] <= layer[target] else (target, source)
        first, last = 2 * layer[high] + 1, max(2 * layer[low] - 1, 2 * layer[high] + 1)
        # The label sits near the source, where a reader looks for what can happen next.
        label_layer = first if high == source else last
        chain: list[int] = []
        for between in range(first, last + 1):
            size = labels[i] if between == label_layer else Size(DUMMY_WIDTH, 0.0)
            dummy = graph.add(between, max(size.width, DUMMY_WIDTH), size.height)
            if between == label_layer:
                graph.labelled.append(dummy)
            graph.connect(chain[-1] if chain else high, dummy)
            chain.append(dummy)
        if layer[high] == layer[low]:
            graph.connect(low, chain[-1])
        else:
            graph.connect(chain[-1], low)
        graph.chains.append(chain if high == source else chain[::-1])
    return graph


def _reduce_crossings(graph: _Layered) -> None:
    """Order each layer by the mean position of its neighbours, down and up in turns; keep the best order met."""
    position = {node: float(i) for row in graph.order for i, node in enumerate(row)}
    best = [list(row) for row in graph.order]
    fewest = _crossings(graph)
    for sweep in range(SWEEPS):
        downwards = sweep % 2 == 0
        neighbours = graph.up if downwards else graph.down
        rows = graph.order[1:] if downwards else graph.order[-2::-1]
        for row in rows:
            means = {n: _mean([position[m] for m in neighbours.get(n, ())], position[n]) for n in row}
            row.sort(key=lambda n: means[n])
            for i, node in enumerate(row):
                position[node] = float(i)
        crossings = _crossings(graph)
        if crossings < fewest:
            fewest, best = crossings, [list(row) for row in graph.order]
    graph.order[:] = best


def _mean(values: Sequence[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise


def _crossings(graph: _Layered) -> int:
    """How many pairs of edges between neighbouring layers cross."""
    count = 0
    for row, following in pairwise(graph.order):
        below = {node: i for i, node in enumerate(following)}
        ends = [end for node in row for end in sorted(below[target] for target in graph.down.get(node, ()))]
        count += sum(other < end for i, end in enumerate(ends) for other in ends[i + 1 :])
    return count


def _coordinates(graph: _Layered) -> list[float]:
    """Centres on the horizontal axis: the order of each layer is kept, neighbours are pulled together."""
    x = [0.0] * len(graph.layer)
    for row in graph.order:
        right = 0.0
        for node in row:
            x[node] = right + graph.left[node]
            right += graph.left[node] + graph.right[node] + NODE_GAP
    for sweep in range(SWEEPS):
        downwards = sweep % 2 == 0
        for row in graph.order if downwards else graph.order[::-1]:
            neighbours = graph.up if downwards else graph.down
            wanted = [_median([x[m] for m in neighbours.get(node, ())], x[node]) for node in row]
            _place(row, wanted, graph, x)
    return x


def _median(values: list[float], otherwise: float) -> float:
    if not values:
        return otherwise
    values.sort()
    middle = len(values) // 2
    return values[middle] if len(values) % 2 else (values[middle - 1] + values[middle]) / 2


def _place(row: list[int], wanted: list[float], graph: _Layered, x: list[float]) -> None:
    """The positions nearest to the wanted ones (least squares) that keep the order and the gaps.

    Pool adjacent violators: blocks of nodes that touch move together to the mean of what their members want.
    """
    offsets = [0.0]
    for left, right in pairwise(row):
        offsets.append(offsets[-1] + graph.right[left] + NODE_GAP + graph.left[right])
    blocks: list[tuple[float, int]] = []
    for i, target in enumerate(wanted):
        value, count = target - offsets[i], 1
        while blocks and blocks[-1][0] >= value:
            other, others = blocks.pop()
            value = (value * count + other * others) / (count + others)
            count += others
        blocks.append((value, count))
    i = 0
    for value, count in blocks:
        for _ in range(count):
            x[row[i]] = value + offsets[i]
            i += 1


def _route(
    edge: tuple[int, int], number: int, graph: _Layered, places: Sequence[tuple[float, float]], sizes: Sequence[Size]
) -> Route:
    source, target = edge
    if source == target:
        points = _loop(places[source], sizes[source])
        return Route(source, target, points, (points[1][0] - 4, places[source][1]))
    chain = graph.chains[number]
    inner = [places[dummy] for dummy in chain]
    start = _way_out(source, inner[0], graph, places, sizes)
    end = _way_out(target, inner[-1], graph, places, sizes)
    return Route(source, target, (*start, *inner, *reversed(end)), places[graph.labelled[number]])


def _way_out(
    node: int,
    towards: tuple[float, float],
    graph: _Layered,
    places: Sequence[tuple[float, float]],
    sizes: Sequence[Size],
) -> list[tuple[float, float]]:
    """From the border of a node to where it is clear of taller neighbours in its layer."""
    tallest = max(graph.heights[other] for other in graph.order[graph.layer[node]])
    if tallest - sizes[node].height < 6:
        return [border(places[node], sizes[node], towards)]
    x, y = places[node]
    reach = max(sizes[node].width / 2 - 6, 0.0)
    down = 1 if towards[1] > y else -1
    out = border(places[node], Size(sizes[node].width, tallest), towards)[0]
    across = min(max(out, x - reach), x + reach)
    return [(across, y + down * sizes[node].height / 2), (across, y + down * tallest / 2)]


def _loop(centre: tuple[float, float], size: Size) -> tuple[tuple[float, float], ...]:
    x, y = centre
    right = x + size.width / 2
    return (
        (right - 2, y - size.height * 0.22),
        (right + LOOP_REACH, y - size.height * 0.4),
        (right + LOOP_REACH, y + size.height * 0.4),
        (right - 2, y + size.height * 0.22),
    )


def border(centre: tuple[float, float], size: Size, towards: tuple[float, float]) -> tuple[float, float]:
    """Where the line from the centre of a box towards a point leaves the box."""
    dx, dy = towards[0] - centre[0], towards[1] - centre[1]
    if dx == 0 and dy == 0:
        return centre
    scale = min(
        size.width / 2 / abs(dx) if dx else float("inf"),
        size.height / 2 / abs(dy) if dy else float("inf"),
    )
    return centre[0] + dx * scale, centre[1] + dy * scale
