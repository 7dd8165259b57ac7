"""What can be said without types or evaluation about whether an expression is a process.

A definition that is surely a process can be referred to anywhere without looking into it, even while it is being
evaluated itself (``P = f(P)``); one that surely is not needs no look at its value.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum, auto
from typing import TYPE_CHECKING

from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.prelude import TRANSPARENT
from cspcheck.cspm.syntax import tree as syntax

if TYPE_CHECKING:
    from cspcheck.cspm.typing.inference import Types


class Sort(Enum):
    """What an expression's value is."""

    PROCESS = auto()
    FUNCTION = auto()
    DATA = auto()
    """Neither of the two."""
    UNKNOWN = auto()


_PROCESS_FORMS = (
    syntax.Prefix,
    syntax.Guard,
    syntax.ProcessBinary,
    syntax.Synchronised,
    syntax.AlphabetisedParallel,
    syntax.LinkedParallel,
    syntax.Hide,
    syntax.Rename,
    syntax.Replicated,
)
_DATA_FORMS = (
    syntax.LiteralExpr,
    syntax.TupleExpr,
    syntax.SetExpr,
    syntax.SetRange,
    syntax.Productions,
    syntax.SequenceExpr,
    syntax.SequenceRange,
    syntax.MapExpr,
    syntax.Binary,
    syntax.Unary,
    syntax.Dot,
)
_PROCESS_BUILTINS = frozenset(
    {
        *("STOP", "SKIP", "DIV", "CHAOS", "RUN", "WAIT", "BUFFER", "WEAK_BUFFER", "SIGNAL_BUFFER", "timed_priority"),
        *("prioritise", "prioritise_nocache", "prioritisepo", "deter", "loop", "failure_watchdog", "trace_watchdog"),
        *TRANSPARENT,
    }
)
_UNKNOWN_BUILTINS = frozenset({"head", "error", "mapLookup", "relational_image", "relational_inverse_image"})


class Sorts:
    """The sorts of expressions and of definitions of one script, from their types where these are known."""

    def __init__(self, names: Names, types: Types | None) -> None:
        self.names = names
        self.types = types
        self._definitions: dict[Symbol, Sort] = {}
        self._asking: set[Symbol] = set()

    def forget(self, symbols: Iterable[Symbol]) -> None:
        """Drop what is known of *symbols*, which nobody will ask for again."""
        for symbol in symbols:
            self._definitions.pop(symbol, None)

    def of(self, node: syntax.Expr) -> Sort:
        """The sort of an expression's value."""
        while True:
            typed = self._by_type(node)
            if typed is not None:
                return typed
            match node:
                case syntax.Paren():
                    node = node.inner
                case syntax.Let():
                    node = node.body
                case syntax.If():
                    then = self.of(node.then)
                    if then is not Sort.UNKNOWN:
                        return then
                    node = node.otherwise
                case syntax.Lambda():
                    return Sort.FUNCTION
                case syntax.Name():
                    symbol = self.names.find(node)
                    return Sort.UNKNOWN if symbol is None else self.of_name(symbol)
                case syntax.Apply():
                    return self._of_application(node)
                case _:
                    if isinstance(node, _PROCESS_FORMS):
                        return Sort.PROCESS
                    return Sort.DATA if isinstance(node, _DATA_FORMS) else Sort.UNKNOWN

    def _by_type(self, node: syntax.Expr) -> Sort | None:
        """What the type of an expression says; None if it has none or could be any."""
        if self.types is None:
            return None
        from cspcheck.cspm.typing import types  # only there if types were inferred

        try:
            found = types.resolve(self.types.type_of(node))
        except KeyError:
            return None
        if isinstance(found, types.Variable | types.Rigid):
            return None
        if found is types.PROC:
            return Sort.PROCESS
        return Sort.FUNCTION if isinstance(found, types.Function) else Sort.DATA

    def of_name(self, symbol: Symbol) -> Sort:
        """The sort of what a name stands for."""
        match symbol.kind:
            case SymbolKind.BUILTIN:
                if symbol.name in ("STOP", "SKIP", "DIV"):
                    return Sort.PROCESS
                data = symbol.name in ("Int", "Bool", "Char", "Events", "Proc", "True", "False", "emptyMap")
                return Sort.DATA if data else Sort.FUNCTION
            case SymbolKind.FUNCTION:
                return Sort.FUNCTION
            case SymbolKind.VARIABLE:
                return Sort.UNKNOWN
            case SymbolKind.VALUE:
                declaration = symbol.declaration
                assert isinstance(declaration, syntax.PatternDefinition)
                pattern = declaration.pattern
                while isinstance(pattern, syntax.ParenPattern):
                    pattern = pattern.inner
                if not isinstance(pattern, syntax.NamePattern):
                    return Sort.UNKNOWN
                return self._of_bodies(symbol.base, [declaration.body])
        return Sort.DATA

    def of_result(self, symbol: Symbol, groups: int = 1) -> Sort:
        """The sort of what a function gives when applied to *groups* argument lists."""
        if symbol.kind is SymbolKind.BUILTIN:
            if symbol.name in _PROCESS_BUILTINS:
                return Sort.PROCESS
            return Sort.UNKNOWN if symbol.name in _UNKNOWN_BUILTINS else Sort.DATA
        declaration = symbol.declaration
        if symbol.kind is not SymbolKind.FUNCTION or not isinstance(declaration, syntax.FunctionDefinition):
            return Sort.UNKNOWN
        wanted = len(declaration.clauses[0].groups)
        if groups < wanted:
            return Sort.FUNCTION
        if groups > wanted:
            return Sort.UNKNOWN
        return self._of_bodies(symbol.base, [clause.body for clause in declaration.clauses])

    def _of_application(self, node: syntax.Apply) -> Sort:
        function: syntax.Expr = node
        groups = 0
        while True:
            function = syntax.bare(function)
            if not isinstance(function, syntax.Apply):
                break
            function = function.function
            groups += 1
        if isinstance(function, syntax.Name):
            symbol = self.names.find(function)
            return Sort.UNKNOWN if symbol is None else self.of_result(symbol, groups)
        if isinstance(function, syntax.Lambda) and groups == 1:
            return self.of(function.body)
        return Sort.UNKNOWN

    def _of_bodies(self, symbol: Symbol, bodies: list[syntax.Expr]) -> Sort:
        known = self._definitions.get(symbol)
        if known is not None:
            return known
        if symbol in self._asking:
            return Sort.UNKNOWN
        self._asking.add(symbol)
        try:
            found = Sort.UNKNOWN
            for body in bodies:
                found = self.of(body)
                if found is not Sort.UNKNOWN:
                    break
        finally:
            self._asking.discard(symbol)
        if found is not Sort.UNKNOWN or not self._asking:
            self._definitions[symbol] = found
        return found
