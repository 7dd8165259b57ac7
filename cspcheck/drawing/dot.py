"""Pictures in the DOT language, for those who have Graphviz."""

from __future__ import annotations

from cspcheck.drawing.picture import Node, Picture, folded

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
    undirected = any(edge.kind == "channel" for edge in picture.edges)
    lines = [f"{'graph' if undirected else 'digraph'} {_quoted(picture.title)} {{", "  node [fontname=monospace];"]
    lines += [f"  n{i} [label={_quoted(node.label)}, {_style(node)}];" for i, node in enumerate(picture.nodes)]
    arrow = "--" if undirected else "->"
    for edge in picture.edges:
        style = ", style=dashed" if edge.kind == "tau" else ""
        label = _quoted("\n".join(folded(edge.labels)))
        lines.append(f"  n{edge.source} {arrow} n{edge.target} [label={label}{style}];")
    return "\n".join([*lines, "}", ""])


def _style(node: Node) -> str:
    return _NODE_STYLE[node.kind]


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
