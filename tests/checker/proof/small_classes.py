"""Random small classes as text, and what holds of them by going through all values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

from hypothesis import strategies as st

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.carriers import Undefined
from cspcheck.cspm.oz.values.evaluation import TermEvaluator

NUMBERS = range(3)
WIDE = range(-4, 9)
"""Values that after-states are tried with where carriers do not count: more than any predicate below tells apart."""


@dataclass(frozen=True)
class Operation:
    """An operation of a small class: its parameter, Delta-list, predicates, and guard (None: one schema)."""

    name: str
    parameter: str
    delta: tuple[str, ...]
    effect: tuple[str, ...]
    guard: tuple[str, ...] | None = None

    def text(self) -> str:
        """The schemas as text."""
        delta = f"    Delta({', '.join(self.delta)})\n"
        parameter = f"    {self.parameter} : 0..1\n" if self.parameter else ""
        lines = "".join(f"    {line}\n" for line in self.effect or ("true",))
        if self.guard is None:
            return f"  op {self.name}\n{delta}{parameter}  where\n{lines}"
        inputs = parameter if self.parameter.endswith("?") else ""
        guard = "".join(f"    {line}\n" for line in self.guard or ("true",))
        enable = f"  op enable_{self.name}\n{inputs}  where\n{guard}"
        return f"{enable}  op effect_{self.name}\n{delta}{parameter}  where\n{lines}"


@dataclass(frozen=True)
class Small:
    """A class with ``n : 0..2`` and ``b : bool``, an operation with an input and one with an output."""

    name: str
    invariant: tuple[str, ...]
    initial: tuple[str, ...]
    operations: tuple[Operation, ...]

    def text(self) -> str:
        """The class as text."""
        invariant = "  where\n" + "".join(f"    {line}\n" for line in self.invariant) if self.invariant else ""
        initial = "".join(f"    {line}\n" for line in self.initial or ("true",))
        return (
            f"class {self.name}\n  chan take : [i? : 0..1]\n  chan give : [o! : 0..1]\n"
            f"  main = take -> main [] give -> main\n  state\n    n : 0..2\n    b : bool\n{invariant}"
            f"  init\n{initial}{''.join(operation.text() for operation in self.operations)}end\n"
        )


@st.composite
def numbers(draw: st.DrawFn, variables: tuple[str, ...]) -> str:
    """An integer term."""
    base = draw(st.sampled_from([*variables, "0", "1", "2"]))
    return base + draw(st.sampled_from(["", "", "", " + 1", " - 1"]))


@st.composite
def predicates(draw: st.DrawFn, ints: tuple[str, ...], bools: tuple[str, ...], deep: bool = True) -> str:
    """A predicate over some variables."""
    kind = draw(st.integers(0, 5 if deep else 3))
    if kind <= 1 or not bools:
        relation = draw(st.sampled_from(["=", "<", "<=", "!="]))
        return f"{draw(numbers(ints))} {relation} {draw(numbers(ints))}"
    if kind == 2:
        return f"{draw(st.sampled_from(bools))} = {draw(st.sampled_from([*bools, 'true', 'false']))}"
    if kind == 3:
        return f"({draw(numbers(ints))}) in {{0, {draw(numbers(ints))}}}"
    left, right = draw(predicates(ints, bools, False)), draw(predicates(ints, bools, False))
    return f"({left}) {'=>' if kind == 4 else 'or'} ({right})"


@st.composite
def operations(draw: st.DrawFn, name: str, parameter: str) -> Operation:
    """An operation; most say what the changed variables become."""
    delta = draw(st.sampled_from([("n",), ("n", "b"), ("b",), ()]))
    before = ("n", parameter) if parameter.endswith("?") else ("n",)
    ints = ("n", parameter, *(["n'"] if "n" in delta else []))
    bools = ("b", *(["b'"] if "b" in delta else []))
    lines = []
    if "n" in delta and draw(st.integers(0, 3)):
        lines.append(f"n' = {draw(numbers(before))}")
    if "b" in delta and draw(st.booleans()):
        lines.append(f"b' = {draw(st.sampled_from(['b', 'true', 'false']))}")
    if parameter.endswith("!") and draw(st.integers(0, 3)):
        lines.append(f"{parameter} = {draw(st.sampled_from(['n', '0', '1', 'n - 1']))}")
    lines += draw(st.lists(predicates(ints, bools), max_size=2))
    guard = None
    if draw(st.integers(0, 2)) == 0:
        guard = tuple(draw(st.lists(predicates(before, ("b",)), max_size=1)))
    return Operation(name, parameter, delta, tuple(lines), guard)


@st.composite
def small_classes(draw: st.DrawFn, name: str = "A") -> Small:
    """A small class."""
    invariant = tuple(draw(st.lists(predicates(("n",), ("b",)), max_size=1)))
    initial = tuple(draw(st.lists(predicates(("n",), ("b",)), max_size=2)))
    take = draw(operations("take", "i?"))
    give = draw(operations("give", "o!"))
    return Small(name, invariant, initial, (take, give))


@st.composite
def variants(draw: st.DrawFn, original: Small, name: str) -> Small:
    """A class that differs from another here and there: a predicate more, or one less."""

    def changed(lines: tuple[str, ...], ints: tuple[str, ...], bools: tuple[str, ...]) -> tuple[str, ...]:
        what = draw(st.integers(0, 4))
        if what == 0 and lines:
            return lines[1:]
        if what == 1:
            return (*lines, draw(predicates(ints, bools)))
        return lines

    new = []
    for operation in original.operations:
        ints = ("n", operation.parameter, *(["n'"] if "n" in operation.delta else []))
        bools = ("b", *(["b'"] if "b" in operation.delta else []))
        effect = changed(operation.effect, ints, bools)
        new.append(Operation(operation.name, operation.parameter, operation.delta, effect, operation.guard))
    initial = changed(original.initial, ("n",), ("b",))
    return Small(name, original.invariant, initial, tuple(new))


# --- by going through all values -------------------------------------------------------------------------------------

State = tuple[int, bool]
Step = tuple[State, int, State]
"""Before, the parameter, after."""


class Enumerated:
    """What a small class does, by evaluating its predicates for all values."""

    def __init__(self, specification: core.Specification, model: core.ClassModel) -> None:
        self.model = model
        self._evaluator = TermEvaluator(specification, model)
        every = list(product(NUMBERS, (False, True)))
        self.states = [s for s in every if self._all(model.invariant, _before(s))]
        self.initial = [s for s in self.states if self._all(model.initial or (), _before(s))]

    def _all(self, predicates_: tuple[core.Term, ...], values: dict[Any, Any]) -> bool:
        """Whether all predicates are true: a false one decides, whatever an undefined one may be."""
        verdicts = []
        for predicate in predicates_:
            try:
                verdicts.append(self._evaluator.holds(predicate, values))
            except Undefined:
                verdicts.append(False)
        return all(verdicts)

    def invariant(self, state: State) -> bool:
        """Whether values, in or outside their carriers, satisfy the invariant."""
        return self._all(self.model.invariant, _before(state))

    def guard(self, operation: core.Operation, state: State, parameter: int) -> bool:
        """Whether the guard holds; true where there is none."""
        return self._all(operation.guard, {**_before(state), **_parameter(operation, parameter)})

    def raw(self, operation: core.Operation, values: range) -> Iterator[Step]:
        """Steps that guard, effect and Delta-list allow from states of the class, with after-values of n in a range.

        Outputs range over more than their carrier where after-values do.
        """
        output = operation.parameters[0].kind == "output"
        wide = output and values is WIDE
        for before in self.states:
            for parameter in WIDE if wide else (0, 1):
                if not output and not self.guard(operation, before, parameter):
                    continue
                if output and not self.guard(operation, before, 0):
                    continue
                for after in product(values if "n" in operation.delta else (before[0],), (False, True)):
                    if "b" not in operation.delta and after[1] != before[1]:
                        continue
                    env = {**_before(before), **_parameter(operation, parameter), **_after(after)}
                    if self._all(operation.effect, env):
                        yield before, parameter, after

    def steps(self, operation: core.Operation) -> list[Step]:
        """Steps of the operation in the class."""
        return [s for s in self.raw(operation, NUMBERS) if s[2] in self.states]


def _before(state: State) -> dict[Any, Any]:
    return {("n", "before"): state[0], ("b", "before"): state[1]}


def _after(state: State) -> dict[Any, Any]:
    return {("n", "after"): state[0], ("b", "after"): state[1]}


def _parameter(operation: core.Operation, value: int) -> dict[Any, Any]:
    (parameter,) = operation.parameters
    return {(parameter.name, parameter.kind): value}
