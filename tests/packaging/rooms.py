"""The picture of the house, drawn from the import contracts.

``python -m tests.packaging.rooms > docs/architecture.svg`` writes it.

Each contract is a column of layers, the upper ones know the lower ones; what stands beside each other in a layer does
not know each other, or (front door) is one storey.
"""

from __future__ import annotations

import re
import sys
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COLUMN, GAP, LINE, PAD = 300, 24, 16, 10
WIDTH = 40
"""Characters in a line of a box."""


def contracts() -> list[tuple[str, list[list[str]]]]:
    """The contracts by the package that they are about: its layers from the top, each with its modules."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    found = tomllib.loads(text)["tool"]["importlinter"]["contracts"]
    return [
        (contract["containers"][0], [re.split(r"[\s:|]+", layer.strip()) for layer in contract["layers"]])
        for contract in found
        if contract["type"] == "layers"
    ]


def wrapped(names: list[str]) -> list[str]:
    """Names in lines of a box."""
    lines = [""]
    for name in names:
        if lines[-1] and len(lines[-1]) + 3 + len(name) > WIDTH:
            lines.append("")
        lines[-1] += (" · " if lines[-1] else "") + name
    return lines


def picture() -> str:
    """The picture as SVG."""
    parts: list[str] = []
    deepest = 0
    columns = contracts()
    for i, (package, layers) in enumerate(columns):
        x, y = GAP + i * (COLUMN + GAP), 34
        parts.append(f'<text class="title" x="{x}" y="22">{escape(package)}</text>')
        for layer in layers:
            lines = wrapped(layer)
            height = 2 * PAD + LINE * len(lines) - 4
            parts.append(f'<rect x="{x}" y="{y}" width="{COLUMN}" height="{height}" rx="4"/>')
            parts += [
                f'<text x="{x + PAD}" y="{y + PAD + 10 + LINE * k}">{escape(line)}</text>'
                for k, line in enumerate(lines)
            ]
            y += height
            if layer is not layers[-1]:
                middle = x + COLUMN / 2
                parts.append(f'<path d="M{middle} {y}v12m-4 -5l4 5l4 -5"/>')
                y += 14
        deepest = max(deepest, y)
    width, height = GAP + len(columns) * (COLUMN + GAP), deepest + GAP
    style = (
        "svg { font: 11px ui-monospace, 'DejaVu Sans Mono', Consolas, monospace; background: #ffffff; }\n"
        ".title { font-size: 13px; font-weight: bold; }\n"
        "text { fill: #1f2933; white-space: pre; }\n"
        "rect { fill: #f5f7fa; stroke: #7b8794; }\n"
        "path { fill: none; stroke: #3e4c59; }"
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
    title = "<title>Who knows whom: each layer knows those below it</title>"
    return "\n".join([head, title, f"<style>\n{style}\n</style>", *parts, "</svg>", ""])


if __name__ == "__main__":
    sys.stdout.write(picture())
