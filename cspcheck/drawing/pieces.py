"""Where the nodes of an architecture go: each connected piece by itself, rings as rings, the pieces in columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import cos, hypot, pi, sin

import networkx

from cspcheck.drawing.layout import PictureLayout, Route, Size, border, layered

GAP = 36.0
"""Between two pieces."""
LOWEST_COLUMN = 300.0
"""Pieces are put under each other up to this height, or that of the largest piece."""
RING = 4
"""Rings of fewer nodes look better as layers."""


def in_pieces(sizes: Sequence[Size], edges: Sequence[tuple[int, int]], *, labels: Sequence[Size] = ()) -> PictureLayout:
    """Lay out the connected pieces of a graph one by one and put them in columns, the largest first.

    Args:
        sizes: one a node.
        edges: (source, target).
        labels: the size of each edge's label, in the order of *edges*; missing ones are empty.
    """
    label_sizes = [*labels, *[Size(0.0, 0.0)] * (len(edges) - len(labels))]
    centres: list[tuple[float, float]] = [(0.0, 0.0)] * len(sizes)
    routes: list[Route | None] = [None] * len(edges)
    left = top = height = width = column = 0.0
    tallest = LOWEST_COLUMN
    for piece in sorted(_pieces(len(sizes), edges), key=lambda piece: -len(piece)):
        own = [i for i, (source, _) in enumerate(edges) if source in piece]
        number = {node: i for i, node in enumerate(piece)}
        laid = _piece(
            [sizes[node] for node in piece],
            [(number[edges[i][0]], number[edges[i][1]]) for i in own],
            [label_sizes[i] for i in own],
        )
        tallest = max(tallest, laid.height)
        if top and top + laid.height > tallest:
            left, top, column = left + column + GAP, 0.0, 0.0
        for node, (x, y) in zip(piece, laid.centres, strict=True):
            centres[node] = (x + left, y + top)
        for i, route in zip(own, laid.routes, strict=True):
            routes[i] = replace(route.moved(left, top), source=edges[i][0], target=edges[i][1])
        column, width, height = max(column, laid.width), max(width, left + laid.width), max(height, top + laid.height)
        top += laid.height + GAP
    return PictureLayout(tuple(centres), tuple(route for route in routes if route is not None), width, height)


def _pieces(nodes: int, edges: Sequence[tuple[int, int]]) -> list[list[int]]:
    """The nodes of each connected piece, ascending."""
    return [sorted(piece) for piece in networkx.connected_components(_neighbours(nodes, edges))]


def _neighbours(nodes: int, edges: Sequence[tuple[int, int]]) -> networkx.Graph[int]:
    """Who is joined with whom, loops apart."""
    graph: networkx.Graph[int] = networkx.Graph()
    graph.add_nodes_from(range(nodes))
    graph.add_edges_from((source, target) for source, target in edges if source != target)
    return graph


def _piece(sizes: Sequence[Size], edges: Sequence[tuple[int, int]], labels: Sequence[Size]) -> PictureLayout:
    around = _around(len(sizes), edges)
    return layered(sizes, edges, labels=labels) if around is None else _ring(around, sizes, edges, labels)


def _around(nodes: int, edges: Sequence[tuple[int, int]]) -> list[int] | None:
    """The nodes in the order in which they stand in a ring; None if they do not."""
    graph = _neighbours(nodes, edges)
    if nodes < RING or any(degree != 2 for _, degree in graph.degree) or not networkx.is_connected(graph):
        return None
    order = [0, min(graph[0])]
    while len(order) < nodes:
        order += [other for other in graph[order[-1]] if other != order[-2]]
    return order


def _ring(
    around: list[int], sizes: Sequence[Size], edges: Sequence[tuple[int, int]], labels: Sequence[Size]
) -> PictureLayout:
    """The nodes on a circle that is large enough for them and for the labels between, the first at the top."""
    widest = max(hypot(size.width, size.height) for size in sizes)
    longest = max((hypot(size.width, size.height) for size in labels), default=0.0)
    step = widest + 0.75 * longest + 14
    radius = step / (2 * sin(pi / len(around)))
    centres: list[tuple[float, float]] = [(0.0, 0.0)] * len(sizes)
    for place, node in enumerate(around):
        angle = 2 * pi * place / len(around) - pi / 2
        centres[node] = (radius * cos(angle), radius * sin(angle))
    # A further line between two nodes bends outwards, so far that its label is clear of the one before.
    last: dict[frozenset[int], tuple[float, Size]] = {}
    routes = []
    for (source, target), size in zip(edges, labels, strict=True):
        (x1, y1), (x2, y2) = centres[source], centres[target]
        middle = ((x1 + x2) / 2, (y1 + y2) / 2)
        away = hypot(*middle)
        outwards = (middle[0] / away, middle[1] / away)
        bend = 0.0
        before = last.get(frozenset((source, target)))
        if before is not None:
            across, down = (size.width + before[1].width) / 2 + 8, (size.height + before[1].height) / 2 + 6
            ways = [gap / abs(part) for gap, part in zip((across, down), outwards, strict=True) if abs(part) > 0.01]
            bend = before[0] + max(min(ways), 22.0)
        last[frozenset((source, target))] = (bend, size)
        middle = (middle[0] + bend * outwards[0], middle[1] + bend * outwards[1])
        start, end = border(centres[source], sizes[source], middle), border(centres[target], sizes[target], middle)
        inner = (middle,) if bend else ()
        routes.append(Route(source, target, (start, *inner, end), middle, bow=bend > 0))
    corners = [
        (x + side * size.width / 2, y + half * size.height / 2)
        for (x, y), size in [
            *zip(centres, sizes, strict=True),
            *[(r.label, s) for r, s in zip(routes, labels, strict=True)],
        ]
        for side, half in ((-1, -1), (1, 1))
    ]
    left, top = min(x for x, _ in corners), min(y for _, y in corners)
    right, bottom = max(x for x, _ in corners), max(y for _, y in corners)
    moved = tuple(route.moved(-left, -top) for route in routes)
    return PictureLayout(tuple((x - left, y - top) for x, y in centres), moved, right - left, bottom - top)
