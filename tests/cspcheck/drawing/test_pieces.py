"""Architectures are laid out piece by piece, and rings as rings."""

from __future__ import annotations

from math import hypot

from hypothesis import given, settings, strategies as st

from cspcheck.drawing.layout import PictureLayout, Size
from cspcheck.drawing.pieces import GAP, in_pieces

BOX = Size(80.0, 40.0)
LABEL = Size(50.0, 15.0)


def overlap(layout: PictureLayout, sizes: list[Size]) -> bool:
    for i, (x, y) in enumerate(layout.centres):
        for j, (u, v) in enumerate(layout.centres[:i]):
            wide, high = (sizes[i].width + sizes[j].width) / 2, (sizes[i].height + sizes[j].height) / 2
            if abs(x - u) < wide - 0.01 and abs(y - v) < high - 0.01:
                return True
    return False


def test_a_ring_is_a_circle_in_order() -> None:
    layout = in_pieces([BOX] * 6, [(i, (i + 1) % 6) for i in range(6)], labels=[LABEL] * 6)
    centre = (sum(x for x, _ in layout.centres) / 6, sum(y for _, y in layout.centres) / 6)
    radii = [hypot(x - centre[0], y - centre[1]) for x, y in layout.centres]
    assert max(radii) - min(radii) < 0.01
    sides = [hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip(layout.centres, layout.centres[1:], strict=False)]
    assert max(sides) - min(sides) < 0.01


def test_a_second_line_in_a_ring_bows_outwards_clear_of_the_first_label() -> None:
    edges = [(i, (i + 1) % 4) for i in range(4)] + [(1, 0)]
    layout = in_pieces([BOX] * 4, edges, labels=[LABEL] * 5)
    straight, bow = layout.routes[0], layout.routes[4]
    assert bow.bow
    assert not straight.bow
    (x, y), (u, v) = straight.label, bow.label
    assert abs(x - u) >= LABEL.width or abs(y - v) >= LABEL.height


def test_what_is_alone_stands_beside_the_largest_piece() -> None:
    layout = in_pieces([BOX] * 6, [(0, 1), (1, 2), (2, 3)], labels=[LABEL] * 3)
    chain, alone = layout.centres[:4], layout.centres[4:]
    assert max(x for x, _ in chain) + BOX.width + GAP <= min(x for x, _ in alone) + 0.01
    assert max(y for _, y in alone) <= max(y for _, y in chain)


def test_nothing_is_nothing() -> None:
    assert in_pieces([], []) == PictureLayout((), (), 0.0, 0.0)


@settings(deadline=None)
@given(st.integers(1, 9), st.data())
def test_boxes_never_overlap_and_stay_inside(nodes: int, data: st.DataObject) -> None:
    end = st.integers(0, nodes - 1)
    edges = data.draw(st.lists(st.tuples(end, end).filter(lambda pair: pair[0] != pair[1]), max_size=12))
    sizes = [
        Size(data.draw(st.sampled_from([20.0, 80.0, 140.0])), data.draw(st.sampled_from([20.0, 60.0])))
        for _ in range(nodes)
    ]
    layout = in_pieces(sizes, edges, labels=[LABEL] * len(edges))
    assert not overlap(layout, sizes)
    for (x, y), box in zip(layout.centres, sizes, strict=True):
        assert x - box.width / 2 >= -0.01
        assert x + box.width / 2 <= layout.width + 0.01
        assert y - box.height / 2 >= -0.01
        assert y + box.height / 2 <= layout.height + 0.01
    assert [(route.source, route.target) for route in layout.routes] == edges
