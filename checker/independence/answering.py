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
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from cspcheck.checker.independence.reading import ProcessReader, ScriptReader
from cspcheck.checker.independence.shapes import Determined, StateSize
from cspcheck.checker.independence.uses import Dependent, total
from cspcheck.checker.verdict import EverySize, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.evaluator.free import children
from cspcheck.cspm.naming.resolve import resolve
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.oz.processes.desugaring import given_name
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.typing.inference import infer

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
        for reading in _readings(script):
            found += _claim(assertion, reading, outcome.verdict)
    return tuple(found)


def _is_covered(assertion: s.Assertion) -> bool:
    match assertion:
        case s.Refinement(model=model, options=()):
            return model in _MODELS
        case s.Property(kind=kind, model=model, options=()):
            return kind != "has trace" and model in (None, *_MODELS)
    return False


@dataclass(frozen=True, slots=True)
class _TypeReading:
    """A script with the names and types in which one type is a datatype of constants."""

    names: Names
    types: Types
    symbol: Symbol
    size: int


_known: WeakKeyDictionary[Any, list[_TypeReading]] = WeakKeyDictionary()


def _readings(script: Script) -> list[_TypeReading]:
    """The types of a script whose size may make no difference, each with the script read so that it is a datatype."""
    found = _known.get(script)
    if found is None:
        found = _known[script] = [*_datatypes(script), *_ranges(script)]
    return found


def _datatypes(script: Script) -> Iterator[_TypeReading]:
    """The datatypes that consist of constants."""
    for symbol in script.names.top_level.values():
        declaration = symbol.declaration
        if symbol.kind is SymbolKind.DATATYPE and isinstance(declaration, s.DatatypeDeclaration):
            constructors = declaration.constructors
            if constructors and all(c.fields is None for c in constructors) and script.types is not None:
                yield _TypeReading(script.names, script.types, symbol, len(constructors))


def _ranges(script: Script) -> Iterator[_TypeReading]:
    """The sets of numbers, such as ``DATA = {0..2}``, that channels carry and that could as well be a datatype.

    They could where the script still has a type with a datatype in their place: then nobody calculates with their
    elements, names one, or takes one for a number.
    """
    if script.classes is not None:
        return
    carried = _carried(script)
    for name, symbol in script.names.top_level.items():
        declaration = symbol.declaration
        if symbol not in carried or not isinstance(declaration, s.NametypeDeclaration | s.PatternDefinition):
            continue
        body = declaration.body
        body = s.bare(body)
        if not isinstance(body, s.SetRange | s.SetExpr) or body.statements is not None:
            continue
        try:
            size = script.evaluate(f"card({name})")
            span = declaration.span
            values = [s.Constructor(span=span, name=f"{name}%{number}") for number in range(1, size + 1)]
            datatype = s.DatatypeDeclaration(span=span, name=name, constructors=tuple(values))
            tree = _replaced(script.tree, declaration, datatype)
            names = resolve(tree)
            if size:
                yield _TypeReading(names, infer(tree, names), names.top_level[name], size)
        except ScriptError:
            continue


def _carried(script: Script) -> set[Symbol]:
    """The names that the declarations of channels mention."""
    found: set[Symbol] = set()
    for symbol in script.names.top_level.values():
        if isinstance(symbol.declaration, s.ChannelDeclaration):
            stack: list[s.Node] = [symbol.declaration]
            while stack:
                node = stack.pop()
                mentioned = script.names.find(node) if isinstance(node, s.Name) else None
                found |= set() if mentioned is None else {mentioned}
                stack += children(node)
    return found


def _replaced(tree: s.Script, old: s.Declaration, new: s.Declaration) -> s.Script:
    def among(declarations: tuple[s.Declaration, ...]) -> tuple[s.Declaration, ...]:
        return tuple(map(one, declarations))

    def one(declaration: s.Declaration) -> s.Declaration:
        if declaration is old:
            return new
        if isinstance(declaration, s.IncludeDeclaration):
            return replace(declaration, declarations=among(declaration.declarations))
        return declaration

    return replace(tree, declarations=among(tree.declarations))


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


def _claim(assertion: s.Assertion, reading: _TypeReading, verdict: Verdict) -> Iterator[EverySize]:
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
