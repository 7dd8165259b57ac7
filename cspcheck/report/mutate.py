"""What ``cspcheck mutate`` tells: the changes that no assertion notices, line by line, and how many there are."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from cspcheck.mutating import Fate, Mutant
from cspcheck.quantities import count, show_seconds
from cspcheck.report.style import Style, harmless, wrapped

SCHEMA = "cspcheck/mutation/1"


def listing(mutants: Sequence[Mutant], style: Style, verbosity: int) -> list[str]:
    """The unnoticed changes of a script with the lines that they stand on; above 0 the others too."""
    shown = [mutant for mutant in mutants if mutant.fate in ("unnoticed", "undecided") or verbosity > 0]
    lines: list[str] = []
    place: tuple[str, int] | None = None
    for mutant in shown:
        span = mutant.change.span
        if (span.source.name, span.line) != place:
            place = (span.source.name, span.line)
            text = harmless(span.source.line_text(span.line).strip())
            lines.append(f"{style.paint(f'{harmless(place[0])}:{place[1]}', 'bold')}  {style.paint(text, 'dim')}")
        lines += wrapped(harmless(_told(mutant)), style.width, "  ", "    ")
    return lines


def _told(mutant: Mutant) -> str:
    after = {
        "noticed": f"noticed by `{mutant.by}`",
        "unnoticed": "not noticed",
        "equivalent": "equivalent",
        "undecided": "not decided within the limits",
        "invalid": "no script any more",
    }[mutant.fate]
    return f"{mutant.change.text}: {after}"


def summary(mutants: Iterable[Mutant], seconds: float, *, interrupted: bool = False) -> str:
    """``40 changes: 31 noticed, 7 not noticed, 2 invalid; 82 % noticed, in 4.2 s``."""
    fates = Counter(mutant.fate for mutant in mutants)
    total = sum(fates.values())
    names: dict[Fate, str] = {
        "noticed": "noticed",
        "unnoticed": "not noticed",
        "equivalent": "equivalent",
        "undecided": "not decided",
        "invalid": "invalid",
    }
    parts = ", ".join(f"{fates[fate]:,} {name}" for fate, name in names.items() if fates[fate])
    judged = fates["noticed"] + fates["unnoticed"]
    score = f"; {100 * fates['noticed'] // judged} % noticed" if judged else ""
    start = "interrupted; until then " if interrupted else ""
    parts = parts or ("nothing was tried" if interrupted else "nothing to change")
    return f"{start}{count(total, 'change')}: {parts}{score}, in {show_seconds(seconds)}"


def document(mutants: Iterable[Mutant], version: str, *, interrupted: bool = False) -> str:
    """The same for programs."""
    return json.dumps(
        {
            "schema": SCHEMA,
            "version": version,
            "interrupted": interrupted,
            "mutants": [_object(mutant) for mutant in mutants],
        },
        indent=2,
    )


def _object(mutant: Mutant) -> dict[str, Any]:
    span = mutant.change.span
    return {
        "file": span.source.name,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
        "kind": mutant.change.kind,
        "change": mutant.change.text,
        "fate": mutant.fate,
        "noticed_by": mutant.by,
    }
