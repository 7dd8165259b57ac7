"""What a layout promises: nothing lies on anything else, and everything is inside the picture."""

from __future__ import annotations

from hypothesis import given, strategies as st

from cspcheck.drawing.layout import Size, layered


@st.composite
def graphs(draw: st.DrawFn) -> tuple[list[Size], list[tuple[int, int]], list[Size]]:
    count = draw(st.integers(1, 9))
    node = st.integers(0, count - 1)
    sizes = [Size(30.0 + draw(st.integers(0, 90)), 30.0) for _ in range(count)]
    edges = draw(st.lists(st.tuples(node, node), max_size=18))
    labels = [Size(float(draw(st.integers(0, 120))), 15.0) for _ in edges]
    return sizes, edges, labels


def boxes_overlap(a: tuple[float, float], b: tuple[float, float], first: Size, second: Size) -> bool:
    return (
        abs(a[0] - b[0]) < (first.width + second.width) / 2 - 0.01
        and abs(a[1] - b[1]) < (first.height + second.height) / 2 - 0.01
    )


@given(graphs())
def test_no_two_nodes_overlap(graph: tuple[list[Size], list[tuple[int, int]], list[Size]]) -> None:
    sizes, edges, labels = graph
    layout = layered(sizes, edges, labels=labels)

    for i, a in enumerate(layout.centres):
        for j in range(i):
            assert not boxes_overlap(a, layout.centres[j], sizes[i], sizes[j])


@given(graphs())
def test_no_label_lies_on_a_node_or_on_another_label(
    graph: tuple[list[Size], list[tuple[int, int]], list[Size]],
) -> None:
    sizes, edges, labels = graph
    layout = layered(sizes, edges, labels=labels)
    placed = [(r.label, labels[i]) for i, r in enumerate(layout.routes) if r.source != r.target]

    for i, (point, size) in enumerate(placed):
        for other, other_size in placed[:i]:
            assert not boxes_overlap(point, other, size, other_size)
        for centre, node in zip(layout.centres, sizes, strict=True):
            assert not boxes_overlap(point, centre, size, node)


@given(graphs())
def test_everything_lies_inside_the_picture(graph: tuple[list[Size], list[tuple[int, int]], list[Size]]) -> None:
    sizes, edges, labels = graph
    layout = layered(sizes, edges, labels=labels)

    for (x, y), size in zip(layout.centres, sizes, strict=True):
        assert size.width / 2 - 0.01 <= x <= layout.width - size.width / 2 + 0.01
        assert size.height / 2 - 0.01 <= y <= layout.height - size.height / 2 + 0.01
    for route in layout.routes:
        for x, y in route.points:
            assert -0.01 <= x <= layout.width + 0.01
            assert -0.01 <= y <= layout.height + 0.01


@given(graphs())
def test_every_edge_runs_from_its_source_to_its_target(
    graph: tuple[list[Size], list[tuple[int, int]], list[Size]],
) -> None:
    sizes, edges, labels = graph
    layout = layered(sizes, edges, labels=labels)

    assert [(r.source, r.target) for r in layout.routes] == edges
    for route in layout.routes:
        for point, node in ((route.points[0], route.source), (route.points[-1], route.target)):
            centre, size = layout.centres[node], sizes[node]
            assert abs(point[0] - centre[0]) <= size.width / 2 + 0.01
            assert abs(point[1] - centre[1]) <= size.height / 2 + 0.01


def test_a_chain_is_drawn_straight_down() -> None:
    layout = layered([Size(30, 30)] * 4, [(0, 1), (1, 2), (2, 3)])

    assert len({round(x, 3) for x, _ in layout.centres}) == 1
    assert [y for _, y in layout.centres] == sorted(y for _, y in layout.centres)


def test_two_edges_between_two_nodes_do_not_share_a_path() -> None:
    layout = layered([Size(30, 30)] * 2, [(0, 1), (1, 0)], labels=[Size(20, 15)] * 2)

    assert layout.routes[0].points[1] != layout.routes[1].points[1]
