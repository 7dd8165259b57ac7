"""Pictures as SVG, placed by :mod:`cspcheck.drawing.layout`; readable on light and dark pages."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.drawing.layout import Route, Size, layered
from cspcheck.drawing.picture import Edge, Picture, PictureNode, folded
from cspcheck.drawing.pieces import in_pieces
from cspcheck.drawing.text import escape

CHARACTER_WIDTH = 7.0
LINE_HEIGHT = 15.0
MARGIN = 24.0
TITLE_HEIGHT = 30.0
RADIUS = 15.0
DETAIL_HEIGHT = 13.0
DETAIL_SCALE = 10 / 12
BASELINE = 4.0
"""How far below its middle a line of text stands."""

STYLE = """
svg { font: 12px ui-monospace, 'DejaVu Sans Mono', Consolas, monospace; background: #ffffff; }
.title { font-size: 14px; font-weight: bold; fill: #1f2933; }
.node { fill: #eef4fb; stroke: #33658a; stroke-width: 1.4; }
.initial { fill: #cfe3f5; stroke-width: 2.4; }
.deadlock { fill: #fbdcd9; stroke: #b3261e; }
.terminated { fill: #e4f3e3; stroke: #2e7d32; }
.junction { fill: #33658a; }
.component { fill: #f6f8fa; stroke: #33658a; }
.edge { fill: none; stroke: #52606d; stroke-width: 1.2; }
.tau { stroke-dasharray: 4 3; stroke: #9aa5b1; }
.channel, .flow { stroke: #33658a; stroke-width: 1.6; }
.label { fill: #1f2933; }
.label.tau { fill: #7b8794; stroke: none; }
.label.channel, .label.flow { stroke: none; }
.detail { fill: #7b8794; text-anchor: middle; font-size: 10px; }
.text { fill: #1f2933; text-anchor: middle; }
.ground { fill: #ffffff; }
.head { fill: #52606d; }
"""


def text_width(text: str) -> float:
    """Width of a text in pixels in the picture's monospaced font."""
    return len(text) * CHARACTER_WIDTH


def render(picture: Picture) -> str:
    """The picture as one SVG document."""
    sizes = [_size(node) for node in picture.nodes]
    labels = [folded(edge.labels) for edge in picture.edges]
    arrange = in_pieces if any(node.kind == "component" for node in picture.nodes) else layered
    layout = arrange(
        sizes, [(edge.source, edge.target) for edge in picture.edges], labels=[_label_size(lines) for lines in labels]
    )
    parts = [_edge(edge, route, lines) for edge, route, lines in zip(picture.edges, layout.routes, labels, strict=True)]
    parts += [
        _node(node, size, centre) for node, size, centre in zip(picture.nodes, sizes, layout.centres, strict=True)
    ]
    parts += [
        _label(edge, route, lines) for edge, route, lines in zip(picture.edges, layout.routes, labels, strict=True)
    ]
    width = max(layout.width, text_width(picture.title) * 1.2)
    return document(picture.title, width, layout.height, parts)


def document(title: str, width: float, height: float, parts: Sequence[str]) -> str:
    """An SVG document with a title above *parts*, which take *width* by *height* pixels."""
    full_width, full_height = width + 2 * MARGIN, height + 2 * MARGIN + TITLE_HEIGHT
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{full_width:.0f}" height="{full_height:.0f}"'
        f' viewBox="0 0 {full_width:.0f} {full_height:.0f}" role="img">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n"
        '<defs><marker id="head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8" markerHeight="8"'
        ' orient="auto-start-reverse"><path class="head" d="M0 1 L9 5 L0 9 z"/></marker></defs>\n'
        f'<rect width="100%" height="100%" fill="#ffffff"/>\n'
        f'<text class="title" x="{MARGIN}" y="{MARGIN}">{escape(title)}</text>\n'
        f'<g transform="translate({MARGIN} {MARGIN + TITLE_HEIGHT})">\n{body}\n</g>\n</svg>\n'
    )


def _size(node: PictureNode) -> Size:
    if node.kind == "component":
        widest = max([text_width(node.label), *(text_width(line) * DETAIL_SCALE for line in node.details)])
        return Size(widest + 28, 38.0 + len(node.details) * DETAIL_HEIGHT)
    if node.kind == "junction":
        return Size(8.0, 8.0)
    return Size(max(2 * RADIUS, text_width(node.label) + 14), 2 * RADIUS)


def _node(node: PictureNode, size: Size, centre: tuple[float, float]) -> str:
    x, y = centre
    hint = f"<title>{escape(node.hint)}</title>" if node.hint else ""
    radius = 4.0 if node.kind == "component" else size.height / 2
    top = y + BASELINE - len(node.details) * DETAIL_HEIGHT / 2
    details = "".join(
        f'<text class="detail" x="{x:.1f}" y="{top + (i + 1) * DETAIL_HEIGHT + 1:.1f}">{escape(line)}</text>'
        for i, line in enumerate(node.details)
    )
    return (
        f"<g>{hint}"
        f'<rect class="node {node.kind}" x="{x - size.width / 2:.1f}" y="{y - size.height / 2:.1f}"'
        f' width="{size.width:.1f}" height="{size.height:.1f}" rx="{radius:.1f}"/>'
        f'<text class="text" x="{x:.1f}" y="{top:.1f}">{escape(node.label)}</text>{details}</g>'
    )


def _edge(edge: Edge, route: Route, lines: Sequence[str]) -> str:
    head = "" if edge.kind == "channel" else ' marker-end="url(#head)"'
    hint = f"<title>{escape(', '.join(edge.labels))}</title>" if len(lines) < len(edge.labels) else ""
    return f'<path class="edge {edge.kind}" d="{_path(route)}"{head}>{hint}</path>'


def _path(route: Route) -> str:
    """A smooth curve through the points: cubic Béziers that meet without a corner."""
    points = route.points
    start = f"M{points[0][0]:.1f} {points[0][1]:.1f}"
    if route.source == route.target:
        (x1, y1), (x2, y2), (x3, y3) = points[1:]
        return f"{start} C{x1:.1f} {y1:.1f} {x2:.1f} {y2:.1f} {x3:.1f} {y3:.1f}"
    if route.bow:
        (x0, y0), (x1, y1), (x2, y2) = points
        return f"{start} Q{2 * x1 - (x0 + x2) / 2:.1f} {2 * y1 - (y0 + y2) / 2:.1f} {x2:.1f} {y2:.1f}"
    if len(points) == 2:
        return f"{start} L{points[1][0]:.1f} {points[1][1]:.1f}"
    path = [start]
    for i in range(len(points) - 1):
        here, there = points[i], points[i + 1]
        (dx, dy), (ex, ey) = _tangent(points, i), _tangent(points, i + 1)
        path.append(
            f"C{here[0] + dx:.1f} {here[1] + dy:.1f} {there[0] - ex:.1f} {there[1] - ey:.1f}"
            f" {there[0]:.1f} {there[1]:.1f}"
        )
    return " ".join(path)


def _tangent(points: Sequence[tuple[float, float]], i: int) -> tuple[float, float]:
    """How an edge passes a point: straight up or down between layers, level where it turns back, else straight on."""
    x, y = points[i]
    if i == 0 or i == len(points) - 1:
        x2, y2 = points[1] if i == 0 else points[-2]
        sign = 1 if i == 0 else -1
        return sign * (x2 - x) / 3, sign * (y2 - y) / 3
    (x1, y1), (x2, y2) = points[i - 1], points[i + 1]
    if (y - y1) * (y2 - y) > 0:
        return 0.0, min(abs(y - y1), abs(y2 - y)) / 2 * (1 if y2 > y else -1)
    if y2 == y1 and (x - x1) * (x2 - x) <= 0:
        return 0.0, 0.0
    return min(abs(x - x1), abs(x2 - x), abs(x2 - x1) / 2) / 2 * (1 if x2 > x1 else -1), 0.0


def _label_size(lines: Sequence[str]) -> Size:
    return Size(max((text_width(line) for line in lines), default=0.0), len(lines) * LINE_HEIGHT)


def _label(edge: Edge, route: Route, lines: Sequence[str]) -> str:
    if not lines:
        return ""
    x, y = route.label
    size = _label_size(lines)
    if route.source == route.target:
        left, anchor, ground = x, "start", ""
    else:
        # The edge passes under its label; a ground in the page's colour keeps the words readable.
        left, anchor = x - size.width / 2, "middle"
        ground = (
            f'<rect class="ground" x="{left - 2:.1f}" y="{y - size.height / 2:.1f}"'
            f' width="{size.width + 4:.1f}" height="{size.height:.1f}"/>'
        )
    top = y - (len(lines) - 1) * LINE_HEIGHT / 2 + BASELINE
    spans = "".join(
        f'<tspan x="{x:.1f}" y="{top + i * LINE_HEIGHT:.1f}">{escape(line)}</tspan>' for i, line in enumerate(lines)
    )
    return f'{ground}<text class="label {edge.kind}" text-anchor="{anchor}">{spans}</text>'
