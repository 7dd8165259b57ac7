"""Checking scripts for several values of their constants: which values, and what came of each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import whole_number
from cspcheck.result import Result

MOST = 10_000
"""A range of more values than this is taken for a mistake."""

_RANGE = re.compile(r"(-?\d+)\s*\.\.\s*(-?\d+)")


@dataclass(frozen=True, slots=True)
class Sweep:
    """A constant with the values to be checked, as CSPm text."""

    name: str
    values: tuple[str, ...]


def parse_sweep(name: str, text: str) -> Sweep:
    """The values of ``2..8``, ``2,4,8``, ``1..3,10``; anything else is a value by itself.

    Commas and ranges inside brackets belong to a value: ``{0..3}`` is one, ``{0},{0,1}`` are two.

    Raises:
        ValueError: a range goes down or is too long, or a value is missing.
    """
    values: list[str] = []
    for part in split_at_commas(text):
        if not part:
            raise ValueError(f"`{name}={text}` has a comma without a value")
        bounds = _RANGE.fullmatch(part)
        if bounds is None:
            values.append(part)
            continue
        low, high = _bound(bounds[1]), _bound(bounds[2])
        if low > high:
            raise ValueError(f"`{part}` goes down; write it as `{high}..{low}`")
        if high - low >= MOST:
            raise ValueError(f"`{part}` are {high - low + 1:,} values")
        values.extend(map(str, range(low, high + 1)))
    return Sweep(name, tuple(dict.fromkeys(values)))


def _bound(text: str) -> int:
    number = whole_number(text.removeprefix("-"))
    if number is None:
        raise ValueError(f"`{text}` has too many digits for a bound of a range")
    return -number if text.startswith("-") else number


def split_at_commas(text: str) -> list[str]:
    """The parts of a text between the commas that stand in no bracket and no string."""
    parts, depth, quoted = [""], 0, False
    for character in text:
        if character == '"':
            quoted = not quoted
        elif not quoted:
            depth += (character in "({[<") - (character in ")}]>")
        if character == "," and depth <= 0 and not quoted:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def combinations(sweeps: Sequence[Sweep]) -> Iterator[dict[str, str]]:
    """Every combination of values; the last constant changes fastest."""
    names = [sweep.name for sweep in sweeps]
    for values in product(*[sweep.values for sweep in sweeps]):
        yield dict(zip(names, values, strict=True))


def varying(sweeps: Iterable[Sweep]) -> list[str]:
    """The constants that have several values; all if none has."""
    sweeps = list(sweeps)
    return [sweep.name for sweep in sweeps if len(sweep.values) > 1] or [sweep.name for sweep in sweeps]


@dataclass(slots=True)
class Swept:
    """What came of one combination of values.

    Attributes:
        definitions: the values.
        results: the answers, script by script.
        diagnostics: errors and warnings of the scripts with these values.
    """

    definitions: dict[str, str]
    results: list[Result] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)
