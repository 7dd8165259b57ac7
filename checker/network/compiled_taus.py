"""The tau rules of what is chased, as the arrays of a kernel."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

import numpy as np

from cspcheck.checker.kernels.company import FLAGS, TauRules, TauScratch
from cspcheck.checker.kernels.jit import tau_kernels


class CompiledTaus:
    """The rules with the result tau of a composition of small components, in the order in which they come.

    Args:
        rows: per component and local state, the targets of each label in the order of the component's rules.
        rules: what the participants of each rule do.
        compiled: which form of the kernel is used.
    """

    def __init__(
        self,
        rows: Sequence[Sequence[Mapping[int, Sequence[int]]]],
        rules: Sequence[Sequence[tuple[int, int]]],
        *,
        compiled: bool = True,
    ) -> None:
        parts: list[list[tuple[int, int]]] = [[] for _ in rows]
        numbers = []
        for place, moves in enumerate(rules):
            numbers.append([(slot, len(parts[slot])) for slot, _ in moves])
            for slot, label in moves:
                parts[slot].append((place, label))
        touched = np.cumsum([0, *map(len, parts)]).astype(np.int64)
        table: list[int] = []
        after: list[int] = []
        for own, local_rows in zip(parts, rows, strict=True):
            table.append(len(after))
            for row in local_rows:
                after += [row[label][0] if label in row else -1 for _, label in own]
        source = random.Random(0)
        sizes = [len(local_rows) for local_rows in rows]
        arrays = {
            "touched": touched,
            "place": [place for own in parts for place, _ in own],
            "table": table,
            "needs": [len(moves) for moves in rules],
            "parts": np.cumsum([0, *map(len, rules)]),
            "part": [touched[slot] + number for moves in numbers for slot, number in moves],
            "part_slot": [slot for moves in rules for slot, _ in moves],
            "mix": np.cumsum([0, *sizes])[:-1],
            "mixes": [source.getrandbits(62) for _ in range(sum(sizes))],
        }
        self._rules = TauRules(
            after=np.array(after, dtype=np.int32),
            **{name: np.array(values, dtype=np.int64) for name, values in arrays.items()},
        )
        self._scratch = TauScratch(
            np.zeros(len(rules), dtype=np.int64),
            np.zeros(len(rules), dtype=np.uint8),
            np.zeros(-(-len(rules) // FLAGS), dtype=np.int64),
            np.zeros(len(rows), dtype=np.int64),
        )
        self._chase = tau_kernels(compiled).chase_taus

    def chased(self, state: Sequence[int]) -> tuple[int, ...] | None:
        """Where the first taus lead to from a state; None if nowhere."""
        here = np.array(state, dtype=np.int64)
        return tuple(here.tolist()) if self._chase(self._rules, here, self._scratch) else None
