"""Which parameters a function is sure to need: their arguments can be evaluated at once, without thunks.

A first-order strictness analysis (Mycroft 1980) on the syntax: the variables that the evaluation of an expression
certainly evaluates, with the recursive calls of the function itself assumed to be as strict as can be and the
assumption weakened until it holds.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cspcheck.cspm.evaluator.patterns import is_irrefutable, is_variable
from cspcheck.cspm.evaluator.sorts import Sort
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator

_NOTHING: frozenset[Symbol] = frozenset()


class Strictness:
    """The strict parameters of the functions of one script."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.evaluator = evaluator
        self._known: dict[Symbol, tuple[bool, ...]] = {}

    def forget(self, symbols: Iterable[Symbol]) -> None:
        """Drop what is known of *symbols*, which nobody will ask for again."""
        for symbol in symbols:
            self._known.pop(symbol, None)

    def of(self, symbol: Symbol) -> tuple[bool, ...]:
        """For each parameter of a function with one parameter list, whether every call needs its value."""
        base = symbol.base
        known = self._known.get(base)
        if known is not None:
            return known
        definition = base.declaration
        assert isinstance(definition, syntax.FunctionDefinition)
        width = len(definition.clauses[0].groups[0])
        if len(definition.clauses[0].groups) > 1 or self.evaluator.sorts.of_result(base) is not Sort.DATA:
            self._known[base] = (False,) * width
            return self._known[base]
        self._known[base] = (False,) * width  # what others find while this is being worked out
        assumed = (True,) * width
        while True:
            found = self._parameters(definition, base, assumed)
            if found == assumed:
                break
            assumed = found
        self._known[base] = found
        return found

    def _parameters(
        self, definition: syntax.FunctionDefinition, itself: Symbol, assumed: tuple[bool, ...]
    ) -> tuple[bool, ...]:
        evaluator = self.evaluator
        width = len(assumed)
        needed: set[int] | None = None
        first: set[int] = set()
        for number, clause in enumerate(definition.clauses):
            patterns = clause.groups[0]
            refutable = {i for i, pattern in enumerate(patterns) if not is_irrefutable(evaluator, pattern)}
            if number == 0 and refutable:
                first = {min(refutable)}
            used = self._needs(clause.body, itself, assumed)
            mine = first | refutable
            for i, pattern in enumerate(patterns):
                if is_variable(evaluator, pattern) and self._symbol(pattern) in used:
                    mine.add(i)
            needed = mine if needed is None else needed & mine
            if not refutable:
                break
        return tuple([i in (needed or ()) for i in range(width)])

    def _symbol(self, pattern: syntax.Pattern) -> Symbol:
        while isinstance(pattern, syntax.ParenPattern):
            pattern = pattern.inner
        return self.evaluator.names.symbol(pattern)

    def _needs(self, node: syntax.Expr, itself: Symbol, assumed: tuple[bool, ...]) -> frozenset[Symbol]:
        """The local variables that the evaluation of *node* certainly evaluates."""

        def needs(inner: syntax.Expr) -> frozenset[Symbol]:
            return self._needs(inner, itself, assumed)

        match node:
            case syntax.Paren():
                return needs(node.inner)
            case syntax.Name():
                symbol = self.evaluator.names.find(node)
                return frozenset((symbol,)) if symbol is not None and symbol.is_local else _NOTHING
            case syntax.Binary():
                if node.operator in ("and", "or"):
                    return needs(node.left)
                if node.operator == "^":
                    return needs(node.left)
                return needs(node.left) | needs(node.right)
            case syntax.Unary():
                return needs(node.operand)
            case syntax.If():
                return needs(node.condition) | (needs(node.then) & needs(node.otherwise))
            case syntax.Dot():
                return needs(node.left) | needs(node.right)
            case syntax.SetRange(statements=None) | syntax.SequenceRange(statements=None):
                return needs(node.low) if node.high is None else needs(node.low) | needs(node.high)
            case syntax.SetExpr() | syntax.SequenceExpr():
                if node.statements:
                    generator = node.statements[0]
                    return needs(generator.source) if isinstance(generator, syntax.Generator) else _NOTHING
                if isinstance(node, syntax.SetExpr) and node.statements is None:
                    return frozenset().union(*map(needs, node.items))
                return _NOTHING
            case syntax.Let():
                return needs(node.body)
            case syntax.Apply():
                return self._application(node, itself, assumed)
        return _NOTHING

    def _application(self, node: syntax.Apply, itself: Symbol, assumed: tuple[bool, ...]) -> frozenset[Symbol]:
        function = node.function
        function = syntax.bare(function)
        if not isinstance(function, syntax.Name):
            return _NOTHING
        symbol = self.evaluator.names.find(function)
        if symbol is None:
            return _NOTHING
        strict: tuple[bool, ...]
        if symbol.base is itself:
            strict = assumed
        elif symbol.kind is SymbolKind.FUNCTION:
            strict = self.of(symbol)
        elif symbol.kind is SymbolKind.BUILTIN:
            builtin = self.evaluator.builtins.get(symbol.name)
            strict = tuple([kind == "v" for kind in getattr(builtin, "kinds", "")])
        else:
            return self._needs(function, itself, assumed)
        if len(strict) != len(node.arguments):
            return _NOTHING
        found = _NOTHING
        for argument, needed in zip(node.arguments, strict, strict=True):
            if needed:
                found |= self._needs(argument, itself, assumed)
        return found
