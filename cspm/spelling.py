"""Did you mean: the names in scope that a misspelt one may stand for."""

from __future__ import annotations

from collections.abc import Iterable

SUGGESTIONS = 3
"""At most so many names are suggested."""


def distance(a: str, b: str, limit: int) -> int:
    """Edits (insert, delete, replace, swap neighbours) from *a* to *b*; anything above *limit* is ``limit + 1``.

    Optimal string alignment: Damerau's edits, no substring edited twice; only places that *limit* edits can reach are
    looked at (Ukkonen 1985).
    """
    if abs(len(a) - len(b)) > limit:
        return limit + 1
    before: list[int] = []
    previous = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        row = [limit + 1] * (len(b) + 1)
        row[0] = i
        for j in range(max(1, i - limit), min(len(b), i + limit) + 1):
            y = b[j - 1]
            best = min(previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                best = min(best, before[j - 2] + 1)
            row[j] = best
        if min(row) > limit:
            return limit + 1
        before, previous = previous, row
    return min(previous[-1], limit + 1)


def tolerance(name: str) -> int:
    """How many edits still look like a slip of the pen: none in one letter, one in four, two in eight, else three."""
    return 0 if len(name) < 2 else 1 if len(name) <= 4 else 2 if len(name) <= 8 else 3


def suggestions(name: str, known: Iterable[str]) -> tuple[str, ...]:
    """Up to three of the *known* names that *name* may be meant to be: those that are nearest, if near enough."""
    limit = tolerance(name)
    if not limit:
        return ()
    ranked: list[tuple[int, int, str]] = []
    for other in dict.fromkeys(known):
        if other == name or len(other) < 2:
            continue
        if other.casefold() == name.casefold():
            ranked.append((0, 0, other))
            continue
        edits = distance(name, other, limit)
        if edits <= limit and edits < max(len(name), len(other)) - 1:
            ranked.append((edits, abs(len(other) - len(name)), other))
    ranked.sort()
    return tuple([other for edits, _, other in ranked if edits == ranked[0][0]][:SUGGESTIONS])
