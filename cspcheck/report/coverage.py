"""What never happened in a check that passed, as lines below its verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cspcheck.report.style import Style, harmless, wrapped

if TYPE_CHECKING:
    from cspcheck.coverage import Coverage, Never

_NAMES = {
    "prefix": "",
    "branch": "",
    "definition": "",
    "guard": "the guard ",
    "component": "the component ",
    "event": "",
}


def coverage_lines(coverage: Coverage, style: Style) -> list[str]:
    """``coverage: 4 of 6 prefixes happen``, and what does not."""
    lines = [f"coverage: {coverage.performed:,} of {coverage.prefixes:,} prefixes happen"]
    if coverage.prefixes and coverage.performed == coverage.prefixes and not coverage.never:
        lines = [f"coverage: all {coverage.prefixes:,} prefixes happen"]
    for never in coverage.never:
        lines += wrapped(harmless(_sentence(never)), style.width - 2, "  ", "    ")
    return [style.paint(line, "dim") if i == 0 else line for i, line in enumerate(lines)]


def _sentence(never: Never) -> str:
    place = f"line {never.line}: " if never.line else ""
    if never.kind == "event":
        return f"never {{{never.text}}}: {never.why}"
    return f"{place}{_NAMES[never.kind]}`{never.text}` {never.why}"
