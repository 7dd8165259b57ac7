"""How much slower functions of a script run than the same functions written in plain Python.

``python tests/benchmarks/bench_evaluator.py`` prints a table. Both sides are written naively and alike; the script is
loaded and its functions are compiled before the clock starts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

SCRIPT = r"""
sieve(<>) = <>
sieve(<p>^xs) = <p>^sieve(<x | x <- xs, x % p != 0>)
last(<x>) = x
last(<x>^xs) = last(xs)
primes(n) = last(sieve(<2..n>))

compose(r, s) = {(x, z) | (x, y) <- r, (w, z) <- s, y == w}
close(r) = let t = union(r, compose(r, r)) within if t == r then r else close(t)
closure(n) = card(close({(i, i + 1) | i <- {1..n}}))

sort(<>) = <>
sort(<p>^xs) = sort(<x | x <- xs, x < p>)^<p>^sort(<x | x <- xs, x >= p>)
scatter(n) = <(i * 7919) % n | i <- <1..n>>
sorted(n) = last(sort(scatter(n)))

fib(n) = if n < 2 then n else fib(n - 1) + fib(n - 2)

total(<>) = 0
total(<x>^xs) = x + total(xs)
sums(n) = total(<1..n>)

queens(n) =
  let safe(q, <>, d) = true
      safe(q, <p>^ps, d) = q != p and q != p + d and q != p - d and safe(q, ps, d + 1)
      place(0) = <<>>
      place(k) = <<q>^b | b <- place(k - 1), q <- <1..n>, safe(q, b, 1)>
  within #place(n)

subsets(n) = card({s | s <- Set({1..n}), card(s) > 2, member(1, s)})
"""


def primes(n: int) -> int:
    def sieve(xs: list[int]) -> list[int]:
        return [] if not xs else [xs[0], *sieve([x for x in xs[1:] if x % xs[0] != 0])]

    return sieve(list(range(2, n + 1)))[-1]


def closure(n: int) -> int:
    def close(r: frozenset[tuple[int, int]]) -> frozenset[tuple[int, int]]:
        t = r | {(x, z) for (x, y) in r for (w, z) in r if y == w}
        return r if t == r else close(t)

    return len(close(frozenset((i, i + 1) for i in range(1, n + 1))))


def sort(n: int) -> int:
    def quick(xs: list[int]) -> list[int]:
        if not xs:
            return []
        p, *rest = xs
        return [*quick([x for x in rest if x < p]), p, *quick([x for x in rest if x >= p])]

    return quick([(i * 7919) % n for i in range(1, n + 1)])[-1]


def fib(n: int) -> int:
    return n if n < 2 else fib(n - 1) + fib(n - 2)


def sums(n: int) -> int:
    def total(xs: tuple[int, Any] | None) -> int:
        return 0 if xs is None else xs[0] + total(xs[1])

    linked: tuple[int, Any] | None = None
    for i in range(n, 0, -1):
        linked = (i, linked)
    return total(linked)


def queens(n: int) -> int:
    def safe(q: int, b: list[int], d: int) -> bool:
        return not b or (q != b[0] and q != b[0] + d and q != b[0] - d and safe(q, b[1:], d + 1))

    def place(k: int) -> list[list[int]]:
        return [[]] if k == 0 else [[q, *b] for b in place(k - 1) for q in range(1, n + 1) if safe(q, b, 1)]

    return len(place(n))


def subsets(n: int) -> int:
    def powerset(xs: list[int]) -> list[frozenset[int]]:
        return [frozenset(x for i, x in enumerate(xs) if c >> i & 1) for c in range(1 << len(xs))]

    return len({s for s in powerset(list(range(1, n + 1))) if len(s) > 2 and 1 in s})


CASES: list[tuple[str, str, Callable[[int], int], int]] = [
    ("sieve of primes, sequences", "primes", primes, 4000),
    ("transitive closure, sets of pairs", "closure", closure, 26),
    ("quicksort, sequences", "sorted", sort, 5000),
    ("queens, nested generators", "queens", queens, 7),
    ("sum over a sequence, recursion", "sums", sums, 20000),
    ("Fibonacci, calls only", "fib", fib, 21),
    ("subsets of a set", "subsets", subsets, 13),
]


def seconds(work: Callable[[], Any]) -> tuple[float, Any]:
    """The best of three runs, and the result."""
    best = float("inf")
    result = None
    for _ in range(3):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
    return best, result


def main() -> None:
    """Run all cases and print their ratios."""
    sys.setrecursionlimit(100_000)
    script = load(Source("bench.csp", SCRIPT))
    print(f"{'':36}{'script':>10}{'Python':>10}{'ratio':>8}")
    for title, name, function, size in CASES:
        script.evaluate(f"{name}(3)")
        ours, found = seconds(lambda name=name, size=size: script.evaluate(f"{name}({size})"))  # type: ignore[misc]
        theirs, wanted = seconds(lambda function=function, size=size: function(size))  # type: ignore[misc]
        assert found == wanted, (title, found, wanted)
        print(f"{title:36}{ours:9.3f}s{theirs:9.3f}s{ours / theirs:8.1f}")


if __name__ == "__main__":
    main()
