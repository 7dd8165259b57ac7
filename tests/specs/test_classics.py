"""The classics scale: verdicts stay what the scripts say, and sizes are exact, by formula where there is one."""

from __future__ import annotations

import pytest

import cspcheck
from cspcheck.checker.semantics.transitions import explore
from tests.specs.table import SPECS

CLASSICS = {
    "abp": (3,),
    "buffer_chain": (2, 5),
    "crossing": (3, 5),
    "election": (2, 4),
    "milner": (2, 5),
    "peterson": (3,),
    "philosophers": (2, 4),
    "token_ring": (3, 6),
}
"""The scripts, each with other sizes than its own."""

SIZES = {
    ("abp", "Protocol"): {3: (2166, 6522)},
    ("crossing", "System(DOWN, DOWN)"): {3: (26, 33), 5: (32, 39)},
    ("election", "Election"): {2: (6, 6), 4: (43, 85), 5: (133, 331)},
    ("peterson", "System"): {3: (1869, 5607)},
    ("philosophers", "Symmetric"): {2: (51, 94), 3: (359, 981), 4: (2575, 9404)},
    ("philosophers", "Asymmetric"): {2: (48, 88), 3: (336, 916), 4: (2400, 8744)},
    # N turns, N - 1 tasks that run or not, and the one whose turn it is in one of three places.
    ("milner", "Scheduler"): {n: (3 * n * 2 ** (n - 1), 3 * n * (n + 1) * 2**n // 4) for n in range(2, 8)},
    ("token_ring", "Ring"): {n: (3 * n * 2 ** (n - 1), 3 * n * (n + 1) * 2**n // 4) for n in range(3, 8)},
    # Each place is empty or holds one of two values; the buffer holds any sequence of up to N.
    ("buffer_chain", "Chain"): {1: (3, 4), 2: (9, 14), 5: (243, 540)},
    ("buffer_chain", "Buffer(<>)"): {n: (2 ** (n + 1) - 1, 2 ** (n + 2) - 4) for n in range(1, 7)},
}


def test_all_eight_are_there() -> None:
    assert sorted(CLASSICS) == sorted(path.stem for path in (SPECS / "classics").glob("*.csp"))


@pytest.mark.parametrize(("script", "size"), [(name, n) for name, sizes in CLASSICS.items() for n in sizes])
def test_the_verdicts_stay_what_the_script_says(script: str, size: int) -> None:
    results = cspcheck.load(SPECS / "classics" / f"{script}.csp", definitions={"N": size}).check()

    assert all(result.as_expected for result in results), [result.explain() for result in results]
    assert {str(result.verdict) for result in results} == {"pass", "fail"}


@pytest.mark.parametrize(("script", "process"), SIZES, ids=lambda part: str(part))
def test_sizes_are_exact(script: str, process: str) -> None:
    for size, expected in SIZES[script, process].items():
        loaded = cspcheck.load(SPECS / "classics" / f"{script}.csp", definitions={"N": size})
        machine = loaded.process(process).lts()
        terms, _ = explore(loaded.process(process)._term)

        assert (machine.states, machine.transitions) == (terms.states, terms.transitions) == expected
