"""Runs to a state in which a claim fails: so many steps written out as one question, answered with values.

The values are put into the predicates of the classes by the evaluator (:mod:`cspcheck.checker.proof.replay`) before
anything is said of them. (Bounded model checking: Biere, Cimatti, Clarke, Zhu, TACAS 1999.)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Constraint, Found, Impossible
from cspcheck.checker.proof.terms import (
    Key,
    all_of,
    any_of,
    equal,
    integer,
    substitute,
    variables_of,
)
from cspcheck.checker.proof.unbounded.claims import Claim, Problem, Step
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term, Variable
from cspcheck.cspm.oz.writing.core_text import text


@dataclass(frozen=True)
class FailingRun:
    """A run to a state in which a claim fails.

    Attributes:
        states: the values of all state variables, before the first step and after each.
        steps: what happens, with the values of each event.
        claim: what fails at the end, with the values of its event.
        values: of the event of the claim.
        constants: values of the constants.
        vouched: whether the solver alone knows that some predicate holds.
        last: the values at the end, and those of the constants.
        place: the place at the end.
    """

    states: tuple[dict[str, str], ...]
    steps: tuple[tuple[Step, tuple[str, ...]], ...]
    claim: Claim
    values: tuple[str, ...]
    constants: dict[str, str]
    vouched: bool
    last: dict[Key, Term]
    place: int


class Runs:
    """Looks for runs of a problem."""

    def __init__(self, problem: Problem, prover: Prover) -> None:
        self.problem = problem
        self.prover = prover
        self.excluded = -1
        """There is no run with so many steps, or fewer."""

    def search(self, until: int) -> FailingRun | None:
        """A shortest run of at most so many steps, as far as the prover can tell."""
        sure = self.excluded
        # A claim that may fail although the assertion holds is none to look for.
        whole = all(claim.exact for claims in self.problem.claims for claim in claims)
        for length in range(self.excluded + 1, until + 1):
            found = self._of_length(length)
            if isinstance(found, FailingRun):
                return found
            if found and whole and sure == length - 1:
                sure = length
        self.excluded = sure
        return None

    def _of_length(self, length: int) -> FailingRun | bool:
        """A run of so many steps; otherwise whether it is known that there is none."""
        ends = self._ends()
        if not ends:
            return True
        parts = [replace(p, term=self._at(p.term, 0)) for p in self.problem.initial]
        parts.append(Constraint(equal(_place(0), integer(0)), "start"))
        reach = self._reachable(length)
        for number in range(length):
            ways = [
                self._way(step, index, number)
                for index, step in enumerate(self.problem.steps)
                if step.source in reach[number] and step.target in reach[number + 1]
            ]
            if not ways:
                return True
            parts.append(Constraint(any_of(ways), "step"))
        lasting = [(i, place, claim) for i, (place, claim) in enumerate(ends) if place in reach[length]]
        if not lasting:
            return True
        failing = []
        for index, place, claim in lasting:
            premises = [p.term for p in claim.premises]
            bad = self.prover.fails(claim.goal).term
            body = self._at(all_of([*premises, bad]), length)
            failing.append(all_of([equal(_place(length), integer(place)), equal(_END, integer(index)), body]))
        parts.append(Constraint(any_of(failing), "failing"))
        answer = self.prover.find(parts, self._shown(length))
        if isinstance(answer, Found):
            return self._run(answer, length, ends)
        return isinstance(answer, Impossible)

    def _ends(self) -> list[tuple[int, Claim]]:
        return [(place, c) for place, claims in enumerate(self.problem.claims) for c in claims if c.exact]

    def _reachable(self, length: int) -> list[set[int]]:
        """The places after so many steps, as far as control is concerned."""
        found = [{0}]
        for _ in range(length):
            found.append({step.target for step in self.problem.steps if step.source in found[-1]})
        return found

    def _way(self, step: Step, index: int, number: int) -> Term:
        terms = [
            equal(_place(number), integer(step.source)),
            equal(_place(number + 1), integer(step.target)),
            equal(_taken(number), integer(index)),
            *[part.term for part in step.parts],
        ]
        for variable in self.problem.variables():
            kept = step.unchanged.get((variable.name, "after"))
            if kept is not None:
                terms.append(equal(replace(variable, role="after"), kept))
        return self._at(all_of(terms), number)

    def _at(self, term: Term, number: int) -> Term:
        """A predicate said of a step of a run."""
        table: dict[Key, Term] = {}
        for variable in variables_of([term]).values():
            if variable.role == "before" and not _is_place(variable):
                table[variable.name, "before"] = _timed(variable, number)
            elif variable.role == "after":
                table[variable.name, "after"] = _timed(variable, number + 1)
            elif variable.role in ("input", "output", "simple"):
                table[variable.name, variable.role] = replace(_timed(variable, number), role="input")
        return substitute(term, table)

    def _shown(self, length: int) -> list[Variable]:
        shown = [_timed(v, number) for number in range(length + 1) for v in self.problem.variables()]
        return [*shown, *[_taken(number) for number in range(length)]]

    def _run(self, found: Found, length: int, ends: list[tuple[int, Claim]]) -> FailingRun | bool:
        values = {(v.name, v.role): value for v, value in found.values.items()}
        try:
            steps = [self.problem.steps[_number(values[_taken(n).name, "before"])] for n in range(length)]
            place, claim = ends[_number(values[_END.name, "before"])]
        except (KeyError, IndexError):
            return False

        def told(variables: Iterable[Variable], number: int) -> tuple[str, ...]:
            names = [_timed(v, number).name for v in variables]
            return tuple(text(values[name, "input"]) if (name, "input") in values else "_" for name in names)

        states = [
            {v.name: text(values[_timed(v, number).name, "before"]) for v in self.problem.variables()}
            for number in range(length + 1)
        ]
        constants = {v.name: text(value) for v, value in found.values.items() if v.role == "constant"}
        taken = tuple((step, told(step.values, number)) for number, step in enumerate(steps))
        last: dict[Key, Term] = {(v.name, v.role): x for v, x in found.values.items() if v.role == "constant"}
        last |= {(v.name, v.role): values[_timed(v, length).name, "before"] for v in self.problem.variables()}
        return FailingRun(
            tuple(states), taken, claim, told(claim.values, length), constants, bool(found.vouched), last, place
        )

    def offers(self, run: FailingRun, number: int) -> tuple[str, ...]:
        """The channels of which a component can perform an event at the end of a run, as far as is known."""
        component = self.problem.components[number]
        steps = [step for step in self.problem.steps if step.source == run.place]
        taken = {(channel, step.values) for step in steps for n, channel in step.move.parts if n == number}
        found = []
        for channel, values in sorted(taken, key=lambda pair: pair[0]):
            possible = Constraint(substitute(component.possible(channel, values), run.last), "possible", total=True)
            if isinstance(self.prover.find([possible]), Found):
                found.append(component.labels[channel] or channel)
        return tuple(dict.fromkeys(found))


def _place(number: int) -> Variable:
    return Variable(type=core.INT, name=f"place%{number}", role="before")


def _taken(number: int) -> Variable:
    return Variable(type=core.INT, name=f"taken%{number}", role="before")


_END = Variable(type=core.INT, name="end%", role="before")


def _is_place(variable: Variable) -> bool:
    return variable.name.startswith(("place%", "taken%", "end%"))


def _timed(variable: Variable, number: int) -> Variable:
    return replace(variable, name=f"{variable.name}@{number}", role="before")


def _number(value: Term) -> int:
    assert isinstance(value, core.Constant)
    return int(value.value)
