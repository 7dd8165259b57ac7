"""Distances between words are those of the whole table, where they count."""

from __future__ import annotations

from hypothesis import given, strategies as st

from cspcheck.cspm.spelling import distance


def whole_table(a: str, b: str) -> int:
    rows = [[i + j if not i or not j else 0 for j in range(len(b) + 1)] for i in range(len(a) + 1)]
    for i in range(1, len(a) + 1):
        for j in range(1, len(b) + 1):
            swapped = i > 1 and j > 1 and a[i - 1] == b[j - 2] and a[i - 2] == b[j - 1]
            rows[i][j] = min(
                rows[i - 1][j] + 1,
                rows[i][j - 1] + 1,
                rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]),
                rows[i - 2][j - 2] + 1 if swapped else len(a) + len(b),
            )
    return rows[-1][-1]


WORDS = st.text("abc", max_size=9)


@given(WORDS, WORDS, st.integers(0, 4))
def test_up_to_the_limit_it_is_exact(a: str, b: str, limit: int) -> None:
    assert distance(a, b, limit) == min(whole_table(a, b), limit + 1)
