"""Pictures in the DOT language, for those who have Graphviz."""

from __future__ import annotations

from cspcheck.drawing.picture import Picture, PictureNode, folded
from cspcheck.report.style import harmless_lines

_NODE_STYLE = {
    "state": "shape=circle",
    "initial": "shape=circle, penwidth=2.4",
    "deadlock": "shape=circle, color=red",
    "terminated": "shape=doublecircle",
    "component": "shape=box",
    "junction": "shape=point",
}


def render(picture: Picture) -> str:
    """The picture as a DOT document."""
    lines = [f"digraph {_quoted(picture.title)} {{", "  node [fontname=monospace];"]
    for i, node in enumerate(picture.nodes):
        lines.append(f"  n{i} [label={_quoted(chr(10).join([node.label, *node.details]))}, {_style(node)}];")
    for edge in picture.edges:
        style = {"tau": ", style=dashed", "channel": ", dir=none"}.get(edge.kind, "")
        label = _quoted("\n".join(folded(edge.labels)))
        lines.append(f"  n{edge.source} -> n{edge.target} [label={label}{style}];")
    return "\n".join([*lines, "}", ""])


def _style(node: PictureNode) -> str:
    return _NODE_STYLE[node.kind]


def _quoted(text: str) -> str:
    text = "\n".join(harmless_lines(text))
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
