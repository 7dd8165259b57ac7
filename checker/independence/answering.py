"""Whether a verdict is the same for every size of a type: the types that it may be asked of (:mod:`.claims`)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from cspcheck.checker.verdict import EverySize, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.resolve import resolve
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.syntax.children import children
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
            # What reads processes is imported for scripts that have such a type: few have.
            from cspcheck.checker.independence.claims import claim

            found += claim(assertion, reading, outcome.verdict)
    return tuple(found)


def _is_covered(assertion: s.Assertion) -> bool:
    match assertion:
        case s.Refinement(model=model, options=()):
            return model in _MODELS
        case s.Property(kind=kind, model=model, options=()):
            return kind != "has trace" and model in (None, *_MODELS)
    return False


@dataclass(frozen=True, slots=True)
class TypeReading:
    """A script with the names and types in which one type is a datatype of constants."""

    names: Names
    types: Types
    symbol: Symbol
    size: int


_known: WeakKeyDictionary[Any, list[TypeReading]] = WeakKeyDictionary()


def _readings(script: Script) -> list[TypeReading]:
    """The types of a script whose size may make no difference, each with the script read so that it is a datatype."""
    found = _known.get(script)
    if found is None:
        found = _known[script] = [*_datatypes(script), *_ranges(script)]
    return found


def _datatypes(script: Script) -> Iterator[TypeReading]:
    """The datatypes that consist of constants."""
    for symbol in script.names.top_level.values():
        declaration = symbol.declaration
        if symbol.kind is SymbolKind.DATATYPE and isinstance(declaration, s.DatatypeDeclaration):
            constructors = declaration.constructors
            if constructors and all(c.fields is None for c in constructors) and script.types is not None:
                yield TypeReading(script.names, script.types, symbol, len(constructors))


def _ranges(script: Script) -> Iterator[TypeReading]:
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
                yield TypeReading(names, infer(tree, names), names.top_level[name], size)
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
