"""How long the state spaces of classes take: from their predicates to a verdict.

``python tests/benchmarks/bench_classes.py`` prints a table; the counts are asserted, so that nothing is left out. No
solver is asked: after-states come from equations, and what is left is tried.
"""

from __future__ import annotations

import time

import cspcheck

GRID = """
class Grid
  chan right, left, up, down
  chan jump : [k? : 0..3]
  chan place : [v! : 0..399]
  state x, y : 0..349
  init x = 0 and y = 0
  op com_right Delta(x) where x' = x + 1
  op com_left Delta(x) where x' = x - 1
  op com_up Delta(y) where y' = y + 1
  op com_down Delta(y) where if y = 0 then y' = 0 else y' = y - 1
  op com_jump Delta(x, y) k? : 0..3 where x' = y and y' = x and k? = (x + y) mod 4
  op com_place v! : 0..399 where v! = x
end
"""

QUEUE = """
reading ITEM = 3
given ITEM
class Queue
  chan put : [i? : ITEM]
  chan get : [i! : ITEM]
  state items : seq ITEM
    Delta size : 0..10
  where size = #items
  init items = <>
  op com_put Delta(items) i? : ITEM where items' = items ^ <i?>
  op com_get Delta(items) i! : ITEM where items = <i!> ^ items'
end
"""

TABLE = """
class Table
  chan bump : [k? : 0..5]
  chan find : [v? : 0..6; n! : 0..6]
  state f : 0..5 --> 0..6
  init f = {0 |-> 0, 1 |-> 0, 2 |-> 0, 3 |-> 0, 4 |-> 0, 5 |-> 0}
  op com_bump Delta(f) k? : 0..5 where f' = f (+) {k? |-> (f(k?) + 1) mod 7}
  op com_find v? : 0..6; n! : 0..6 where n! = #(f |> {v?})
end
"""

CLASSES = [("Grid", GRID, 122_500), ("Queue", QUEUE, 88_573), ("Table", TABLE, 117_649)]


def main() -> None:
    """Print the table."""
    print(f"{'class':8} {'states':>9} {'transitions':>12} {'seconds':>8}")
    for name, text, states in CLASSES:
        script = cspcheck.loads(text, name=f"{name}.csp")
        start = time.perf_counter()
        result = script.check(f"{name} :[divergence free]", full=True)
        seconds = time.perf_counter() - start
        print(f"{name:8} {result.states:>9,} {result.transitions:>12,} {seconds:>8.1f}")
        assert result, result.explain()
        assert result.states == states, f"{name} should have {states:,} states"


if __name__ == "__main__":
    main()
