"""What declarations and patterns declare: each name of a scope has its symbol before any name is looked up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.naming import messages as messages
from cspcheck.cspm.naming.modules import declared_names, flatten
from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.scopes import BUILTIN_SYMBOLS, MATCHED, Lookup, NotFound, Scope
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.prelude import DEPRECATED_IMPORTS, EXTERNAL, TRANSPARENT
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax

TOO_MANY = 20
"""After so many mistakes the walk ends."""

Places: TypeAlias = dict[str, list[tuple[int, Span, bool]]]
"""Where each name of a scope is declared: the number of the declaration, its place, and whether it is a function."""


class TooManyMistakes(Exception):
    """There are so many mistakes that the rest is not looked at."""


class Declarations:
    """Gives symbols to what declarations and patterns declare, scope by scope."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.lookup = Lookup(names)
        self.top = Scope(None, None)
        self.diagnostics: list[Diagnostic] = []
        self._module_scopes: dict[int, Scope] = {}

    def report(self, diagnostic: Diagnostic) -> None:
        """Note a mistake, once.

        Raises:
            TooMany: there are enough of them.
        """
        if diagnostic not in self.diagnostics:
            self.diagnostics.append(diagnostic)
        if len(self.diagnostics) >= TOO_MANY:
            raise TooManyMistakes

    def finish(self) -> None:
        """End the walk.

        Raises:
            ScriptError: with the mistakes that were found, if there are any.
        """
        if self.diagnostics:
            found, self.diagnostics = self.diagnostics, []
            raise ScriptError(*found)

    # --- declaring ------------------------------------------------------------------------------------------

    def _declare(self, declarations: Sequence[syntax.Declaration], scope: Scope, *, local: bool = False) -> None:
        """Give symbols to all that *declarations* declare; patterns last, for they may mention constructors."""
        flat = list(flatten(declarations))
        spans: Places = {}

        def add(order: int, name: str, kind: SymbolKind, span: Span, node: syntax.Node, **more: Any) -> Symbol:
            symbol = Symbol(name, kind, span, node, owner=scope.module, is_local=local, **more)
            seen = spans.setdefault(name, [])
            seen.append((order, span, kind is SymbolKind.FUNCTION))
            if len(seen) == 1:
                scope.names[name] = symbol
            return symbol

        modules: list[tuple[Symbol, syntax.ModuleDeclaration]] = []
        for order, declaration in enumerate(flat):
            match declaration:
                case syntax.FunctionDefinition():
                    symbol = add(order, declaration.name, SymbolKind.FUNCTION, declaration.span, declaration)
                    self.names._record(declaration, symbol)
                case syntax.ChannelDeclaration():
                    for name in declaration.names:
                        symbol = add(order, name.name, SymbolKind.CHANNEL, name.span, declaration)
                        self.names._record(name, symbol)
                case syntax.DatatypeDeclaration():
                    kind = SymbolKind.SUBTYPE if declaration.subtype else SymbolKind.DATATYPE
                    self.names._record(declaration, add(order, declaration.name, kind, declaration.span, declaration))
                    if not declaration.subtype:
                        for c in declaration.constructors:
                            symbol = add(order, c.name, SymbolKind.CONSTRUCTOR, c.span, declaration, constructor=c)
                            self.names._record(c, symbol)
                case syntax.NametypeDeclaration():
                    symbol = add(order, declaration.name, SymbolKind.NAMETYPE, declaration.span, declaration)
                    self.names._record(declaration, symbol)
                case syntax.ModuleDeclaration():
                    symbol = add(order, declaration.key, SymbolKind.MODULE, declaration.span, declaration)
                    self.names._record(declaration, symbol)
                    modules.append((symbol, declaration))
                case syntax.InstanceDeclaration():
                    symbol = add(order, declaration.name, SymbolKind.INSTANCE, declaration.span, declaration)
                    self.names._record(declaration, symbol)
                    self.lookup.instance_declared(symbol, scope)
                case syntax.ImportDeclaration():
                    self._import(declaration, order, scope, spans)
        for order, declaration in enumerate(flat):
            if isinstance(declaration, syntax.PatternDefinition):
                pattern = _unwrap(declaration.pattern)
                for node in variables(pattern):
                    # What is declared beside it cannot be defined again; what is declared around it is a constant.
                    again = node is pattern and node.parts[0] in scope.names
                    if len(node.parts) == 1 and (again or not self._matches_itself(node, scope)):
                        symbol = add(order, node.text, SymbolKind.VALUE, node.span, declaration)
                        self.names._record(node, symbol)
        for twice, places in spans.items():
            if len(places) > 1:
                clauses = all(is_function for _, _, is_function in places)
                ordered = [span for _, span, _ in sorted(places, key=lambda place: place[0])]
                self.report(messages.defined_twice(twice, ordered, clauses=clauses))
        for symbol, module in modules:
            self._declare_module(symbol, module, scope)
        self._annotate(flat, scope)

    def _import(self, declaration: syntax.ImportDeclaration, order: int, scope: Scope, spans: Places) -> None:
        known, other = (TRANSPARENT, EXTERNAL) if declaration.kind == "transparent" else (EXTERNAL, TRANSPARENT)
        for name in declaration.names:
            if name.name not in known:
                other_kind = "external" if declaration.kind == "transparent" else "transparent"
                self.report(
                    messages.unknown_import(
                        name.name,
                        declaration.kind,
                        name.span,
                        suggestions(name.name, sorted(known)),
                        other_kind if name.name in other else None,
                    )
                )
                continue
            symbol = BUILTIN_SYMBOLS[name.name]
            self.names._record(name, symbol)
            if scope.names.get(name.name) is symbol:
                self.report(messages.imported_twice(name.name, spans[name.name][0][1], name.span))
                continue
            if name.name in DEPRECATED_IMPORTS:
                self.names.warnings.append(
                    messages.deprecated_import(name.name, DEPRECATED_IMPORTS[name.name], name.span)
                )
            spans.setdefault(name.name, []).append((order, name.span, False))
            scope.names.setdefault(name.name, symbol)

    def _matches_itself(self, node: syntax.NamePattern, scope: Scope) -> bool:
        symbol = scope.find(node.parts[0])
        return symbol is not None and symbol.kind in MATCHED

    def _declare_module(self, symbol: Symbol, module: syntax.ModuleDeclaration, scope: Scope) -> None:
        outer = Scope(scope, symbol, timed=scope.timed)
        self._bind(module.parameters, outer, "parameter list", local=False)
        symbol.parameters = tuple(outer.names.values())
        inner = Scope(outer, symbol, timed=scope.timed)
        self._declare((*module.private, *module.exported), inner)
        for parameter in symbol.parameters:
            again = inner.names.get(parameter.name)
            if again is not None and again.span is not None and parameter.span is not None:
                self.report(messages.parameter_redefined(parameter.name, symbol.name, parameter.span, again.span))
        symbol.members.update(inner.names)
        exported = Scope(None, symbol)
        for declaration in flatten(module.exported):
            exported.names.update(dict.fromkeys(declared_names(declaration, self.names), symbol))
        symbol.exported = frozenset(exported.names)
        self._module_scopes[id(module)] = inner

    def _annotate(self, flat: Sequence[syntax.Declaration], scope: Scope) -> None:
        for declaration in flat:
            if not isinstance(declaration, syntax.AnnotationDeclaration):
                continue
            for name in declaration.names:
                symbol = scope.names.get(name.name)
                if symbol is not None:  # the parser has seen to it that there is one, and one annotation for it
                    self.names._record(name, symbol)
                    self.names._annotations[symbol] = declaration

    # --- patterns -------------------------------------------------------------------------------------------

    def _bind(self, patterns: Iterable[syntax.Pattern], scope: Scope, where: str, *, local: bool = True) -> None:
        """Give symbols to the variables of *patterns*, which *scope* then holds, and tie their constructors."""
        outside = scope.parent if scope.parent is not None else scope
        for pattern in patterns:
            for node in variables(pattern):
                if self._constructor(node, outside):
                    continue
                name = node.text
                first = scope.names.get(name)
                if first is not None:
                    assert first.span is not None
                    self.report(messages.bound_twice(name, first.span, node.span, where))
                    continue
                symbol = Symbol(name, SymbolKind.VARIABLE, node.span, node, owner=scope.module, is_local=local)
                scope.names[name] = symbol
                self.names._record(node, symbol)

    def _bound_once(self, scope: Scope, bound: dict[str, Span], where: str) -> None:
        """Note where *scope* binds its variables, none of which may be in *bound* already."""
        for name, symbol in scope.names.items():
            assert symbol.span is not None
            if name in bound:
                self.report(messages.bound_twice(name, bound[name], symbol.span, where))
            bound[name] = symbol.span

    def _constructor(self, node: syntax.NamePattern, scope: Scope) -> bool:
        """Tie a name in a pattern that is no variable; False for a variable."""
        if len(node.parts) == 1:
            symbol = scope.find(node.parts[0])
            if symbol is None or symbol.kind not in MATCHED:
                return False
        else:
            try:
                symbol = self.lookup.find(scope, node.parts, node.span)
            except NotFound as missing:
                self.report(missing.diagnostic)
                return True
            if symbol.kind not in MATCHED:
                self.report(messages.qualified_variable(node.text, node.span))
                return True
        self.names._record(node, symbol)
        return True


def _unwrap(pattern: syntax.Pattern) -> syntax.Pattern:
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return pattern
