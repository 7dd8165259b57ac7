"""Predicates of Object-Z in Ada mean what they mean: random ones are compiled, and compared with the evaluator."""

from __future__ import annotations

import random
import shutil
import subprocess
from itertools import product
from pathlib import Path

import pytest

from cspcheck.codegen.emit.ada_methods import tidy
from cspcheck.codegen.emit.ada_terms import AdaTerms, bare
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.evaluation import TermEvaluator

COUNT, SIZE = 150, 4
VALUES = (-3, 0, 2)


class Random:
    """Terms over `x` and `y`, and what is bound around."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.names = 0

    def number(self, size: int, bound: tuple[str, ...]) -> core.Term:
        """An integer."""
        kind = self.random.randrange(10) if size else self.random.randrange(2)
        if kind == 0:
            return core.Constant(type=core.INT, value=self.random.randint(-3, 3))
        if kind == 1:
            name = self.random.choice(("x", "y", *bound))
            return core.Variable(type=core.INT, name=name, role="bound" if name in bound else "before")
        if kind == 2:
            parts = (self.truth(size - 1, bound), self.number(size - 1, bound), self.number(size - 1, bound))
            return core.If(type=core.INT, test=parts[0], then=parts[1], otherwise=parts[2])
        if kind < 5:
            divisor = core.Constant(type=core.INT, value=self.random.choice((-3, -2, 2, 3)))
            operator = self.random.choice(("div", "mod"))
            return core.Apply(type=core.INT, operator=operator, operands=(self.number(size - 1, bound), divisor))
        if kind == 5:
            operator = self.random.choice(("abs", "negate"))
            return core.Apply(type=core.INT, operator=operator, operands=(self.number(size - 1, bound),))
        operator = self.random.choice(("plus", "minus", "times"))
        operands = (self.number(size - 1, bound), self.number(size - 1, bound))
        return core.Apply(type=core.INT, operator=operator, operands=operands)

    def truth(self, size: int, bound: tuple[str, ...]) -> core.Term:
        """A predicate."""
        kind = self.random.randrange(9) if size else 8
        if kind == 0:
            return core.Apply(type=core.BOOL, operator="not", operands=(self.truth(size - 1, bound),))
        if kind < 4:
            operator = self.random.choice(("and", "or", "implies", "iff"))
            operands = tuple(self.truth(size - 1, bound) for _ in range(2))
            return core.Apply(type=core.BOOL, operator=operator, operands=operands)
        if kind == 4:
            return self.membership(size, bound)
        if kind == 5:
            self.names += 1
            name = f"b%{self.names}"
            binder = core.Binder(name, core.INT, self.range(), "b")
            return core.Quantifier(
                type=core.BOOL,
                kind=self.random.choice(("forall", "exists")),
                binders=(binder,),
                condition=self.truth(0, (*bound, name)),
                body=self.truth(size - 1, (*bound, name)),
            )
        operator = self.random.choice(("less", "at_most", "equal"))
        operands = (self.number(max(0, size - 1), bound), self.number(max(0, size - 1), bound))
        return core.Apply(type=core.BOOL, operator=operator, operands=operands)

    def range(self) -> core.Term:
        """A set of integers that follow each other."""
        low = self.random.randint(-2, 2)
        ends = (low, low + self.random.randint(-1, 2))
        operands = tuple(core.Constant(type=core.INT, value=end) for end in ends)
        return core.Apply(type=core.SetType(core.INT), operator="range", operands=operands)

    def membership(self, size: int, bound: tuple[str, ...]) -> core.Term:
        """That a number is in a set."""
        value = self.number(size - 1, bound)
        kind = self.random.randrange(4)
        if kind == 0:
            items = tuple(self.number(0, bound) for _ in range(self.random.randint(1, 3)))
            carrier: core.Term = core.Apply(type=core.SetType(core.INT), operator="set", operands=items)
        elif kind == 1:
            operator = self.random.choice(("Int", "Nat", "Nat1"))
            carrier = core.Apply(type=core.SetType(core.INT), operator=operator)
        else:
            carrier = self.range()
        return core.Apply(type=core.BOOL, operator="in", operands=(value, carrier))


@pytest.mark.skipif(shutil.which("gnatmake") is None, reason="gnat is not here: apt-get install gnat")
def test_random_predicates(tmp_path: Path) -> None:
    source = Random(20_260)
    terms = [source.truth(SIZE, ()) for _ in range(COUNT)]
    lines = ["with Ada.Text_IO; use Ada.Text_IO;", "procedure Terms is", "   pragma Warnings (Off);"]
    for i, term in enumerate(terms):
        text = bare(AdaTerms(lambda variable: variable.name, lambda _: None).text(term))
        lines += [f"   function P_{i} (x, y : Integer) return Boolean is", f"     ({text});"]
    lines += ["   type Row is array (1 .. 2) of Integer;", "   Rows : constant array (Positive range <>) of Row :="]
    rows = list(product(VALUES, repeat=2))
    lines += [f"     ({', '.join(f'({x}, {y})' for x, y in rows)});", "begin", "   for R of Rows loop"]
    lines += [f"      Put (if P_{i} (R (1), R (2)) then '1' else '0');" for i in range(COUNT)]
    lines += ["      New_Line;", "   end loop;", "end Terms;", ""]
    (tmp_path / "terms.adb").write_text(tidy("\n".join(lines)), encoding="utf-8")
    command = ["gnatmake", "-q", "-gnat2012", "-O0", "terms.adb"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    said = subprocess.run(["./terms"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    evaluator = TermEvaluator(core.Specification())
    for (x, y), row in zip(rows, said, strict=True):
        expected = [evaluator.holds(term, {("x", "before"): x, ("y", "before"): y}) for term in terms]
        wrong = [i for i, value in enumerate(expected) if row[i] != str(int(value))]
        assert not wrong, (x, y, terms[wrong[0]])
    assert 0.2 < sum(row.count("1") for row in said) / (len(rows) * COUNT) < 0.8
