"""What machine code computes is what Python computes, on random kernels; the rest of Python is refused."""

from __future__ import annotations

import importlib.util
import os
import random
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from cspcheck.checker.kernels import machine_code, translated_types, translation

EXAMPLES = int(os.environ.get("CSPCHECK_EXAMPLES", "8"))
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))

PREAMBLE = """
from __future__ import annotations
from typing import NamedTuple
from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array

LIMIT = 37

class Inner(NamedTuple):
    bytes: UInt8Array
    shift: int

class Outer(NamedTuple):
    inner: Inner
    small: Int32Array
"""
FORMS = ("words", "outer.small", "outer.inner.bytes", "small")
"""Arrays, of at least eight elements each."""


class Writer:
    """Writes random kernels that end, whose numbers stay small and whose indices lie within their arrays."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.lines: list[str] = []
        self.callees: list[str] = []

    def number(self, names: list[str], depth: int) -> str:
        pick = self.random.randrange(12 if depth else 3)
        if pick == 0:
            return str(self.random.randrange(-5, 40))
        if pick == 1:
            return self.random.choice([*names, "LIMIT", "outer.inner.shift"])
        if pick == 2:
            form = self.random.choice(FORMS)
            return f"{form}[{self.random.choice(names)} & 7]"
        left, right = self.number(names, depth - 1), self.number(names, depth - 1)
        if pick == 3:
            return f"({left} {self.random.choice('+-')} {right})"
        if pick == 4:
            return f"(({left} & 255) * ({right} & 63))"
        if pick == 5:
            return f"({left} // {self.random.choice([3, 7, -2, 16])})"
        if pick == 6:
            return f"({left} >> ({right} & 15))" if self.random.random() < 0.5 else f"(({left} & 255) << ({right} & 7))"
        if pick == 7:
            return f"({left} {self.random.choice('&|^')} {right})"
        if pick == 8:
            return f"{self.random.choice(['-', '~'])}{left}" if left[0] not in "-~" else f"({left})"
        if pick == 9:
            return f"{self.random.choice(['max', 'min'])}({left}, {right})"
        if pick == 10:
            return f"({left} if {self.truth(names, depth - 1)} else {right})"
        if self.callees:
            return f"{self.random.choice(self.callees)}({left}, words, {right}, outer, small)"
        return f"len({self.random.choice(FORMS)})"

    def truth(self, names: list[str], depth: int) -> str:
        pick = self.random.randrange(5 if depth else 1)
        left, right = self.number(names, max(0, depth - 1)), self.number(names, max(0, depth - 1))
        if pick in (0, 1):
            return f"({left} {self.random.choice(['<', '<=', '>', '>=', '==', '!='])} {right})"
        if pick == 2:
            return f"({left} < {right} <= {self.number(names, 0)})"
        if pick == 3:
            both = f"{self.truth(names, depth - 1)} {self.random.choice(['and', 'or'])} {self.truth(names, depth - 1)}"
            return f"(not ({both}))" if self.random.random() < 0.3 else f"({both})"
        return left  # a number as a truth

    def statements(self, names: list[str], indent: str, depth: int, looping: bool) -> None:
        for _ in range(self.random.randrange(1, 5)):
            pick = self.random.randrange(10 if depth else 5)
            name = self.random.choice(["a", "b", "c"])
            if pick <= 1:
                self.lines.append(f"{indent}{name} = {self.bounded(self.number(names, 3))}")
            elif pick == 2:
                self.lines.append(
                    f"{indent}{name} {self.random.choice(['+', '-', '^', '|'])}= {self.number(names, 1)} & 63"
                )
            elif pick == 3:
                form = self.random.choice(FORMS)
                value = f"({self.number(names, 2)}) & 127"
                operator = self.random.choice(["=", "=", "^=", "|="])
                self.lines.append(f"{indent}{form}[({self.number(names, 1)}) & 7] {operator} {value}")
            elif pick == 4:
                self.lines.append(f"{indent}{name}, c = {self.bounded(self.number(names, 1))}, {name} & 1023")
            elif pick <= 6:
                self.lines.append(f"{indent}if {self.truth(names, 2)}:")
                self.statements(names, indent + "    ", depth - 1, looping)
                if looping and self.random.random() < 0.4:
                    self.lines.append(f"{indent}    {self.random.choice(['break', 'continue'])}")
                elif self.random.random() < 0.1:
                    self.lines.append(f"{indent}    return a, b")
                elif self.random.random() < 0.5:
                    self.lines.append(f"{indent}else:")
                    self.statements(names, indent + "    ", depth - 1, looping)
            elif pick <= 8:
                variable = f"i{len(indent)}"
                bounds = self.random.choice(["6", f"{name} & 3, 5", f"0, {name} & 15, 3", f"0, 9, ({name} & 3) + 1"])
                self.lines.append(f"{indent}for {variable} in range({bounds}):")
                self.statements([*names, variable], indent + "    ", depth - 1, True)
            else:
                variable = f"w{len(indent)}"
                self.lines.append(f"{indent}{variable} = ({name} & 7) + 1")
                self.lines.append(f"{indent}while {self.random.choice(['True', f'{variable} < 12'])}:")
                self.lines.append(f"{indent}    {variable} += 1")
                self.lines.append(f"{indent}    if {variable} > 14:")
                self.lines.append(f"{indent}        break")
                self.statements([*names, variable], indent + "    ", depth - 1, True)

    @staticmethod
    def bounded(text: str) -> str:
        return f"({text}) & 1023"

    def kernel(self, name: str) -> None:
        self.lines.append(
            f"def {name}(a: int, words: Int64Array, b: bool, outer: Outer, small: Int32Array) -> tuple[int, int]:"
        )
        self.lines += ["    c = a ^ LIMIT", "    a &= 4095", "    b &= 4095"]
        self.statements(["a", "b", "c"], "    ", 3, False)
        self.lines.append("    return a, b")

    def helper(self, name: str) -> None:
        self.lines.append(f"def {name}(a: int, words: Int64Array, b: int, outer: Outer, small: Int32Array) -> int:")
        self.lines += ["    c = b ^ LIMIT", f"    if {self.truth(['a', 'b', 'c'], 2)}:", "        return a & 63"]
        self.lines.append(f"    return ({self.number(['a', 'b', 'c'], 3)}) & 1023")
        self.callees.append(name)


def module_of(text: str, folder: Path, name: str) -> ModuleType:
    """A module with a text."""
    file = folder / f"{name}.py"
    file.write_text(text)
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where the types in annotations are looked up
    spec.loader.exec_module(module)
    return module


def arguments(module: ModuleType, seed: int) -> tuple[Any, ...]:
    """Random arguments, the same for the same seed."""
    chance = np.random.default_rng(seed)
    words = chance.integers(0, 1000, 8, dtype=np.int64)
    inner = remembering(module.Inner, chance.integers(0, 256, 9, dtype=np.uint8), int(chance.integers(0, 9)))
    outer = remembering(module.Outer, inner, chance.integers(-50, 1000, 8, dtype=np.int32))
    small = chance.integers(-50, 1000, 10, dtype=np.int32)
    return int(chance.integers(-300, 300)), words, int(chance.integers(0, 300)), outer, small


def remembering(kind: Any, *members: Any) -> Any:
    class Remembering(kind):  # type: ignore[misc]
        words = None

    return Remembering(*members)


def as_lists(argument: Any) -> Any:
    """Arrays as the lists that Python computes with."""
    if isinstance(argument, np.ndarray):
        return argument.tolist()
    return type(argument)(*map(as_lists, argument)) if isinstance(argument, tuple) else argument


def test_random_kernels(tmp_path: Path) -> None:
    """Results, and what is in the arrays afterwards; also where some arguments are constants in a copy."""
    writer = Writer(SEED)
    names = [f"kernel{number}" for number in range(EXAMPLES)]
    helpers = []
    for number, name in enumerate(names):
        if number % 4 == 0:
            helpers.append(f"helper{number}")
            writer.helper(helpers[-1])
        writer.kernel(name)
    ending = f"\nKERNELS = ({', '.join([*helpers, *names])},)\n"
    module = module_of(PREAMBLE + "\n".join(writer.lines) + ending, tmp_path, "random_kernels")
    entries = {name: [{"a": 7}] if number % 2 else [] for number, name in enumerate(names)}
    made = machine_code.linked(None, [module], entries, lambda: None)
    ends = set()
    for name in names:
        function = getattr(module, name)
        compiled = machine_code.Caller(function, made)
        for round in range(12):
            given = arguments(module, SEED * 1000 + round)
            if round % 3 == 0:
                given = (7, *given[1:])
            lists = tuple(map(as_lists, given))
            assert compiled(*given) == function(*lists), (name, round)
            assert tuple(map(as_lists, given)) == lists, (name, round)
            ends.add(str(lists))
    assert len(ends) > 3 * EXAMPLES  # the kernels differ in what they do


def refused(text: str, folder: Path) -> str:
    """Why a kernel with a body is not translated."""
    kernel = "def kernel(a: int, words: Int64Array) -> int:\n    " + text.replace("\n", "\n    ")
    module = module_of(PREAMBLE + kernel + "\nKERNELS = (kernel,)\n", folder, "refused")
    with pytest.raises(translated_types.Untranslatable) as caught:
        translation.translated([module], {"kernel": ()})
    return str(caught.value).split(": ", 1)[1]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("return a % 2", "Mod has no translation"),
        ("return a / 2", "Div has no translation"),
        ("return 0.5", "the constant 0.5 has no translation"),
        ("return [a]", "List has no translation"),
        ("return sum(words)", "a call of sum has no translation"),
        ("for w in words:\n    a += w\nreturn a", "this loop has no translation"),
        ("b = words\nb = words\nreturn 1", "a second value of an array's name has no translation"),
        ("return words", "this as a number has no translation"),
        ("while a:\n    a -= 1\nelse:\n    a = 1\nreturn a", "the else of a loop has no translation"),
        ("return a is a", "this comparison has no translation"),
        ("return min(a, key=a)", "an argument by name has no translation"),
        ("try:\n    return a\nfinally:\n    a = 1", "Try has no translation"),
    ],
)
def test_what_is_not_understood_is_refused(text: str, why: str, tmp_path: Path) -> None:
    assert refused(text, tmp_path) == why


@pytest.mark.parametrize("which", ["", "TAU_"])
def test_entries_are_kernels(which: str) -> None:
    """The entries are kernels, and the constants of their copies are arguments."""
    from cspcheck.checker.kernels import jit

    modules, entries = getattr(jit, f"{which}MODULES"), getattr(jit, f"{which}ENTRIES")
    kernels: dict[str, Callable[..., Any]] = {f.__name__: f for module in modules for f in module.KERNELS}
    for name, copies in entries.items():
        known = {parameter for parameter, _ in translated_types.parameters(kernels[name])}  # type: ignore[arg-type]
        assert all(set(copy) <= known for copy in copies)
