"""Whether a verdict is the same for every size of a type, after Lazić and Roscoe.

Two theorems are used, for types in which the processes are data independent (:mod:`.reading`, :mod:`.classes`):

*Nothing is tested.* A map from the values of one size onto those of another then takes the machine of a process onto
its machine at the other size, step by step in both directions (Lazić 1999; Roscoe 1997, 15.3.2; *Understanding
Concurrent Systems*, 2010, chapter 17). So deadlock and divergence are the same for all sizes. A refinement whose
specification is determined by its trace (Norm) can be broken by a value that differs from *one* other, or by the offer
of some values where all are demanded: two values show either. Nondeterminism is a run that offers an event and another
that refuses it: the values of this event and one for all others show that.

*Values are tested for equality.* A permutation of the values is one of the states and takes steps to steps, and the
states with certain values have the same steps between them whatever other values there are. With W values in a state
at most, and k new ones in a step, what can be reached with W + k values is, up to permutations, what can be reached
with any larger number (the same places, the general theorem). The states of a refinement are those of both sides, the
specification determined by its trace; those of determinism are two of the process.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cspcheck.checker.independence.reading import ProcessReader, ScriptReader
from cspcheck.checker.independence.shapes import Determined, StateSize
from cspcheck.checker.independence.uses import Dependent, total
from cspcheck.checker.verdict import EverySize, Verdict
from cspcheck.cspm.oz.processes.nodes import given_name
from cspcheck.cspm.syntax import tree as s

if TYPE_CHECKING:
    from cspcheck.checker.independence.answering import TypeReading


@dataclass(frozen=True, slots=True)
class _Side:
    """How one process of an assertion treats the values."""

    reader: ProcessReader
    node: s.Expr

    @property
    def tests(self) -> bool:
        return self.reader.use.tests

    @property
    def held(self) -> int | None:
        return StateSize(self.reader).of(self.node)

    @property
    def is_determined(self) -> bool:
        """Whether its trace tells where it is, or it has no values that it could remember."""
        if Determined(self.reader).of(self.node):
            return True
        return not self.tests and self.reader.use.chosen == 0 and self.held == 0


def claim(assertion: s.Assertion, reading: TypeReading, verdict: Verdict) -> Iterator[EverySize]:
    """What can be said of one type, if anything."""
    size, name = reading.size, given_name(reading.symbol.name)
    try:
        script = ScriptReader(reading.names, reading.types, reading.symbol, name)
        if script.touched.event_slots == 0:
            return
        match assertion:
            case s.Refinement():
                sides = [
                    _Side(ProcessReader(script, n), n) for n in (assertion.specification, assertion.implementation)
                ]
                if not sides[0].is_determined:
                    return
                twice, kind = False, "refinement"
            case s.Property():
                sides = [_Side(ProcessReader(script, assertion.process), assertion.process)]
                twice, kind = assertion.kind == "deterministic", assertion.kind
            case _:
                return
    except (Dependent, KeyError):
        return
    if not any(side.reader.meets_values for side in sides):
        return
    fields = script.touched.event_slots
    if not any(side.tests for side in sides):
        enough = 2 if kind == "refinement" else 1
        if twice:
            if fields is None:
                return
            enough = fields + 1
        # Fewer values show less: what holds of a size holds of the smaller ones, what fails, fails for the larger ones.
        least = 1 if verdict is Verdict.PASS else min(size, enough)
        yield EverySize(name, size, enough, least, False, size >= enough or verdict is Verdict.FAIL)
        return
    held = total([side.held for side in sides])
    new: list[int | None] = [fields, *[side.reader.use.chosen for side in sides]]
    if held is None or None in new:
        return
    most = max(count for count in new if count is not None)
    enough = held * (2 if twice else 1) + most
    yield EverySize(name, size, enough, enough, True, size >= enough, held * (2 if twice else 1), most)
