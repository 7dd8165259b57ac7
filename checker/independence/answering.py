"""Whether a verdict is the same for every size of a type, after Lazić and Roscoe.

Two theorems are used, for types in which the processes are data independent (:mod:`.reading`, :mod:`.classes`):

*Nothing is tested.* A map from the values of one size onto those of another then takes the machine of a process onto its
machine at the other size, step by step in both directions (Lazić 1999, chapters 4 and 6; Roscoe 1997, theorem 15.3.1;
*Understanding Concurrent Systems*, 2010, chapter 17). So deadlock and divergence are the same for all sizes. A refinement
whose specification is determined by its trace (Norm) can be broken by a value that differs from *one* other, or by
the offer of some values where all are demanded: two values show either. Nondeterminism is a run that offers an event and
another that refuses it: the values of this event and one for all others show that.

*Values are tested for equality.* A permutation of the values is one of the states and takes steps to steps, and the
states with certain values have the same steps between them whatever other values there are. With W values in a state
at most, and k new ones in a step, what can be reached with W + k values is, up to permutations, what can be reached with any
larger number (Lazić 1999, chapter 7; Roscoe 1997, theorem 15.3.2). The states of a refinement are those of both sides, the
specification determined by its trace; of determinism, two of the process.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cspcheck.checker.independence.reading import ProcessReader, ScriptReader
from cspcheck.checker.independence.shapes import Determined, StateSize
from cspcheck.checker.independence.uses import Dependent, total
from cspcheck.checker.verdict import EverySize, Outcome, Verdict
from cspcheck.cspm.oz.processes.desugaring import given_name
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind

if TYPE_CHECKING:
    from cspcheck.cspm.script import Script
    from cspcheck.cspm.typing.inference import Types

_MODELS = ("T", "F", "FD")


def for_every_size(assertion: s.Assertion, script: Script, outcome: Outcome) -> tuple[EverySize, ...]:
    """What the verdict about processes of a script says of types of other sizes.

    Args:
        assertion: a refinement or a property; of others nothing is said.
        script: the script that it belongs to.
        outcome: the answer to it.
    """
    if outcome.verdict not in (Verdict.PASS, Verdict.FAIL) or script.types is None or not _is_covered(assertion):
        return ()
    found: list[EverySize] = []
    with deep_recursion():
        for symbol in _candidates(script.names):
            found += _claim(assertion, script.names, script.types, symbol, outcome.verdict)
    return tuple(found)


def _is_covered(assertion: s.Assertion) -> bool:
    match assertion:
        case s.Refinement(model=model, options=()):
            return model in _MODELS
        case s.Property(kind=kind, model=model, options=()):
            return kind != "has trace" and model in (None, *_MODELS)
    return False


def _candidates(names: Names) -> Iterator[Symbol]:
    """The datatypes that consist of constants."""
    for symbol in names.top_level.values():
        declaration = symbol.declaration
        if symbol.kind is SymbolKind.DATATYPE and isinstance(declaration, s.DatatypeDeclaration):
            if declaration.constructors and all(c.fields is None for c in declaration.constructors):
                yield symbol


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


def _claim(
    assertion: s.Assertion, names: Names, types: Types, symbol: Symbol, verdict: Verdict
) -> Iterator[EverySize]:
    """What can be said of one type, if anything."""
    declaration = symbol.declaration
    assert isinstance(declaration, s.DatatypeDeclaration)
    size = len(declaration.constructors)
    try:
        script = ScriptReader(names, types, symbol, given_name(symbol.name))
        if script.touched.event_slots == 0:
            return
        match assertion:
            case s.Refinement():
                sides = [_Side(ProcessReader(script, n), n) for n in (assertion.specification, assertion.implementation)]
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
        yield EverySize(given_name(symbol.name), size, enough, least, False, size >= enough or verdict is Verdict.FAIL)
        return
    held = total([side.held for side in sides])
    new: list[int | None] = [fields, *[side.reader.use.chosen for side in sides]]
    if held is None or None in new:
        return
    most = max(count for count in new if count is not None)
    enough = held * (2 if twice else 1) + most
    yield EverySize(given_name(symbol.name), size, enough, enough, True, size >= enough, held * (2 if twice else 1), most)
