"""Names: every name of a script is tied to the one thing that it means, before types and values are looked at.

The result is a table from nodes to symbols (:class:`~cspcheck.cspm.naming.symbols.Names`); the tree stays as it is.
The few rules about patterns and fields that need no types are checked on the same walk.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Final

from cspcheck.cspm.diagnostics import Severity
from cspcheck.cspm.naming import messages as messages
from cspcheck.cspm.naming.declarations import Declarations, TooManyMistakes
from cspcheck.cspm.naming.modules import flatten, module_cycles
from cspcheck.cspm.naming.patterns import doubles, variables
from cspcheck.cspm.naming.scopes import MODULES, NotFound, Scope
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.dispatch import Dispatch

__all__ = ["Names", "Symbol", "SymbolKind", "resolve", "resolve_more"]


def resolve(script: syntax.Script) -> Names:
    """Tie the names of a whole script.

    Raises:
        ScriptError: with every mistake, up to twenty.
    """
    names = Names(script)
    resolver = _Resolver(names)
    names._resolver = resolver
    with deep_recursion(), suppress(TooManyMistakes):
        resolver.script(script)
    resolver.finish()
    return names


def resolve_more(names: Names, node: syntax.Expr | syntax.Assertion) -> None:
    """Tie the names of an expression or assertion that is written against a resolved script.

    Raises:
        ScriptError: with every mistake in it.
    """
    resolver: _Resolver = names._resolver
    names._kept.append(node)
    with deep_recursion(), suppress(TooManyMistakes):
        resolver.visit(node, resolver.top)
    resolver.finish()


TIES: Final = Dispatch[Callable[[Any, Any, Scope], None]]("tie the names of")
"""How the names in a node are tied, by its form."""


class _Resolver(Declarations):
    def __init__(self, names: Names) -> None:
        super().__init__(names)
        self.has_classes = False

    def script(self, script: syntax.Script) -> None:
        self.has_classes = any(
            isinstance(declaration, syntax.ModuleDeclaration) and type(declaration) is not syntax.ModuleDeclaration
            for declaration in flatten(script.declarations)
        )
        self._declare(script.declarations, self.top)
        self.names.top_level.update(self.top.names)
        self._visit_all(script.declarations, self.top)
        for diagnostic in module_cycles(self.top.names.values()):
            self.report(diagnostic)

    # --- visiting -------------------------------------------------------------------------------------------

    def visit(self, node: syntax.Node, scope: Scope) -> None:
        """Tie all names in *node*."""
        tie = TIES.get(type(node))
        if tie is not None:
            tie(self, node, scope)
        elif isinstance(node, syntax.Foreign):
            self._visit_all(node.names, scope)
        elif isinstance(node, syntax.ModuleDeclaration):  # of a class
            self._visit_moduledeclaration(node, scope)
        # Else a paragraph of Object-Z, or a claim about one: its names are tied elsewhere.

    def _visit_all(self, nodes: Iterable[syntax.Node], scope: Scope) -> None:
        for node in nodes:
            self.visit(node, scope)

    @TIES(syntax.Name)
    def _visit_name(self, node: syntax.Name, scope: Scope) -> None:
        try:
            symbol = self.lookup.find(scope, node.parts, node.span)
        except NotFound as missing:
            self.report(missing.diagnostic)
            return
        if symbol.kind in MODULES:
            instance = symbol.kind is SymbolKind.INSTANCE
            try:
                members = (self.lookup.module_of(symbol) if instance else symbol).base.exported
            except NotFound:
                members = frozenset()
            self.report(messages.module_is_no_value(node.text, node.span, sorted(members), instance=instance))
            return
        self.names._record(node, symbol)

    @TIES(syntax.LiteralExpr)
    def _visit_literalexpr(self, node: syntax.LiteralExpr, scope: Scope) -> None:
        pass

    @TIES(syntax.Paren)
    def _visit_paren(self, node: syntax.Paren, scope: Scope) -> None:
        self.visit(node.inner, scope)

    @TIES(syntax.TupleExpr)
    def _visit_tupleexpr(self, node: syntax.TupleExpr, scope: Scope) -> None:
        self._visit_all(node.items, scope)

    @TIES(syntax.SetExpr, syntax.SequenceExpr, syntax.Productions)
    def _visit_comprehension(
        self, node: syntax.SetExpr | syntax.SequenceExpr | syntax.Productions, scope: Scope
    ) -> None:
        self._visit_all(node.items, self._statements(node.statements or (), scope))

    @TIES(syntax.SetRange, syntax.SequenceRange)
    def _visit_range(self, node: syntax.SetRange | syntax.SequenceRange, scope: Scope) -> None:
        inner = self._statements(node.statements or (), scope)
        self.visit(node.low, inner)
        if node.high is not None:
            self.visit(node.high, inner)

    @TIES(syntax.MapExpr)
    def _visit_mapexpr(self, node: syntax.MapExpr, scope: Scope) -> None:
        for key, value in node.items:
            self.visit(key, scope)
            self.visit(value, scope)

    @TIES(syntax.Binary, syntax.Dot, syntax.ProcessBinary)
    def _visit_two(self, node: syntax.Binary | syntax.Dot | syntax.ProcessBinary, scope: Scope) -> None:
        self.visit(node.left, scope)
        self.visit(node.right, scope)

    @TIES(syntax.Unary)
    def _visit_unary(self, node: syntax.Unary, scope: Scope) -> None:
        self.visit(node.operand, scope)

    @TIES(syntax.Apply)
    def _visit_apply(self, node: syntax.Apply, scope: Scope) -> None:
        self.visit(node.function, scope)
        self._visit_all(node.arguments, scope)

    @TIES(syntax.Lambda)
    def _visit_lambda(self, node: syntax.Lambda, scope: Scope) -> None:
        inner = scope.within()
        self._bind(node.parameters, inner, "parameter list")
        self.visit(node.body, inner)

    @TIES(syntax.If)
    def _visit_if(self, node: syntax.If, scope: Scope) -> None:
        self.visit(node.condition, scope)
        self.visit(node.then, scope)
        self.visit(node.otherwise, scope)

    @TIES(syntax.Let)
    def _visit_let(self, node: syntax.Let, scope: Scope) -> None:
        inner = scope.within()
        self._declare(node.declarations, inner, local=True)
        self._visit_all(node.declarations, inner)
        self.visit(node.body, inner)

    # --- visiting processes ---------------------------------------------------------------------------------

    @TIES(syntax.Prefix)
    def _visit_prefix(self, node: syntax.Prefix, scope: Scope) -> None:
        self.visit(node.channel, scope)
        bound: dict[str, Span] = {}
        communicated: Span | None = None
        for field in node.fields:
            if field.kind == "$":
                if scope.timed:
                    self.report(messages.not_in_timed_section("a `$` field", field.span))
                if communicated is not None:
                    self.report(messages.dollar_after_input(field.span, communicated))
            elif communicated is None:
                communicated = field.span
            if field.expression is not None:
                self.visit(field.expression, scope)
            if field.restriction is not None:
                self.visit(field.restriction, scope)
            if field.pattern is not None:
                double = next(doubles(field.pattern), None)
                if double is not None:
                    self.report(messages.double_pattern_in_prefix(double.span))
                inner = scope.within()
                self._bind((field.pattern,), inner, "prefix")
                self._bound_once(inner, bound, "prefix")
                scope = inner
        self.visit(node.body, scope)

    @TIES(syntax.Guard)
    def _visit_guard(self, node: syntax.Guard, scope: Scope) -> None:
        self.visit(node.condition, scope)
        self.visit(node.body, scope)

    @TIES(syntax.Synchronised)
    def _visit_synchronised(self, node: syntax.Synchronised, scope: Scope) -> None:
        self._visit_all((node.left, node.events, node.right), scope)

    @TIES(syntax.AlphabetisedParallel)
    def _visit_alphabetisedparallel(self, node: syntax.AlphabetisedParallel, scope: Scope) -> None:
        self._visit_all((node.left, node.left_alphabet, node.right_alphabet, node.right), scope)

    @TIES(syntax.ClassParallel)
    def _visit_classparallel(self, node: syntax.ClassParallel, scope: Scope) -> None:
        if not self.has_classes:
            from cspcheck.cspm.parsing.class_messages import composition_without_classes

            between = node.span.source.text.find("||", node.left.span.end, node.right.span.start)
            self.report(composition_without_classes(node.span.source.span(between, between + 2)))
        self._visit_all((node.left, node.right), scope)

    @TIES(syntax.LinkedParallel)
    def _visit_linkedparallel(self, node: syntax.LinkedParallel, scope: Scope) -> None:
        if scope.timed:
            self.report(messages.not_in_timed_section("a linked parallel", node.span))
        self._visit_all((node.left, node.right), scope)
        self._pairs(node.links, self._statements(node.statements or (), scope))

    @TIES(syntax.Hide)
    def _visit_hide(self, node: syntax.Hide, scope: Scope) -> None:
        self._visit_all((node.process, node.events), scope)

    @TIES(syntax.Rename)
    def _visit_rename(self, node: syntax.Rename, scope: Scope) -> None:
        self.visit(node.process, scope)
        self._pairs(node.pairs, self._statements(node.statements or (), scope))

    @TIES(syntax.Replicated)
    def _visit_replicated(self, node: syntax.Replicated, scope: Scope) -> None:
        if node.operator == "<->" and scope.timed:
            self.report(messages.not_in_timed_section("a linked parallel", node.span))
        inner = self._statements(node.statements, scope)
        self._pairs(node.links, self._statements(node.link_statements or (), inner))
        if node.events is not None:
            self.visit(node.events, inner if node.operator == "||" else scope)
        self.visit(node.body, inner)

    def _pairs(self, pairs: Iterable[tuple[syntax.Expr, syntax.Expr]], scope: Scope) -> None:
        for pair in pairs:
            self._visit_all(pair, scope)

    def _statements(self, statements: Iterable[syntax.Statement], scope: Scope) -> Scope:
        """Tie the statements in order; the scope behind the last one."""
        bound: dict[str, Span] = {}
        for statement in statements:
            if isinstance(statement, syntax.Generator):
                self.visit(statement.source, scope)
                scope = scope.within()
                self._bind((statement.pattern,), scope, "pattern")
                self._bound_once(scope, bound, "list of generators")
            else:
                assert isinstance(statement, syntax.Qualifier)
                self.visit(statement.condition, scope)
        return scope

    # --- visiting declarations ------------------------------------------------------------------------------

    @TIES(syntax.FunctionDefinition)
    def _visit_functiondefinition(self, node: syntax.FunctionDefinition, scope: Scope) -> None:
        first = node.clauses[0]
        shape = [len(group) for group in first.groups]
        for clause in node.clauses:
            given = [len(group) for group in clause.groups]
            if given != shape:
                self.report(
                    messages.clauses_differ(node.name, clause.span, first.span, _arguments(shape), _arguments(given))
                )
            inner = scope.within()
            self._bind((p for group in clause.groups for p in group), inner, "parameter list")
            self.visit(clause.body, inner)

    @TIES(syntax.PatternDefinition)
    def _visit_patterndefinition(self, node: syntax.PatternDefinition, scope: Scope) -> None:
        for name in variables(node.pattern):
            if self.names.find(name) is None:
                self._constructor(name, scope)
        self.visit(node.body, scope)

    @TIES(syntax.ChannelDeclaration)
    def _visit_channeldeclaration(self, node: syntax.ChannelDeclaration, scope: Scope) -> None:
        if node.fields is not None:
            self.visit(node.fields, scope)

    @TIES(syntax.DatatypeDeclaration)
    def _visit_datatypedeclaration(self, node: syntax.DatatypeDeclaration, scope: Scope) -> None:
        for constructor in node.constructors:
            if node.subtype:
                symbol = scope.find(constructor.name)
                if symbol is None or symbol.kind is not SymbolKind.CONSTRUCTOR:
                    known = [s.name for s in scope.known() if s.kind is SymbolKind.CONSTRUCTOR]
                    close = suggestions(constructor.name, known)
                    self.report(messages.not_a_constructor(constructor.name, node.name, constructor.span, close))
                else:
                    self.names._record(constructor, symbol)
            if constructor.fields is not None:
                self.visit(constructor.fields, scope)

    @TIES(syntax.NametypeDeclaration)
    def _visit_nametypedeclaration(self, node: syntax.NametypeDeclaration, scope: Scope) -> None:
        self.visit(node.body, scope)

    @TIES(syntax.ImportDeclaration)
    def _visit_importdeclaration(self, node: syntax.ImportDeclaration, scope: Scope) -> None:
        pass

    @TIES(syntax.IncludeDeclaration)
    def _visit_includedeclaration(self, node: syntax.IncludeDeclaration, scope: Scope) -> None:
        self._visit_all(node.declarations, scope)

    @TIES(syntax.PrintDeclaration)
    def _visit_printdeclaration(self, node: syntax.PrintDeclaration, scope: Scope) -> None:
        before = len(self.diagnostics)
        with suppress(TooManyMistakes):
            self.visit(node.expression, scope)
        found = self.diagnostics[before:]
        if found:
            # What is only printed stops nothing.
            del self.diagnostics[before:]
            self.names.warnings += [replace(diagnostic, severity=Severity.WARNING) for diagnostic in found]
            self.names.unprintable.add(node.span)

    @TIES(syntax.ModuleDeclaration)
    def _visit_moduledeclaration(self, node: syntax.ModuleDeclaration, scope: Scope) -> None:
        inner = self._module_scopes[id(node)]
        self._visit_all(node.private, inner)
        self._visit_all(node.exported, inner)

    @TIES(syntax.InstanceDeclaration)
    def _visit_instancedeclaration(self, node: syntax.InstanceDeclaration, scope: Scope) -> None:
        self._visit_all(node.arguments, scope)
        try:
            module = self.lookup.module_of(self.names.symbol(node))
        except NotFound as missing:
            self.report(missing.diagnostic)
            return
        self.names._record(node.module, module)
        declaration = module.declaration
        assert isinstance(declaration, syntax.ModuleDeclaration)
        expected, given = len(declaration.parameters), len(node.arguments)
        if expected != given:
            self.report(messages.module_argument_count(node.module.text, expected, given, node.span, declaration.span))

    @TIES(syntax.TimedDeclaration)
    def _visit_timeddeclaration(self, node: syntax.TimedDeclaration, scope: Scope) -> None:
        if node.duration is not None:
            self.visit(node.duration, scope)
        tock = scope.find("tock")
        if tock is None:
            self.report(messages.no_tock(node.span, None))
        elif not (isinstance(tock.declaration, syntax.ChannelDeclaration) and tock.declaration.fields is None):
            self.report(messages.no_tock(node.span, tock.span))
        else:
            self.names._tocks[id(node)] = tock
        self._visit_all(node.declarations, scope.in_timed_section())

    @TIES(syntax.AnnotationDeclaration)
    def _visit_annotationdeclaration(self, node: syntax.AnnotationDeclaration, scope: Scope) -> None:
        self.visit(node.scheme.type, scope)

    # --- visiting types -------------------------------------------------------------------------------------

    @TIES(syntax.TypeName)
    def _visit_typename(self, node: syntax.TypeName, scope: Scope) -> None:
        if len(node.parts) > 1:
            try:
                self.names._record(node, self.lookup.find(scope, node.parts, node.span))
            except NotFound as missing:
                self.report(missing.diagnostic)
            return
        symbol = scope.find(node.parts[0])
        if symbol is not None and symbol.kind is SymbolKind.DATATYPE:
            self.names._record(node, symbol)

    @TIES(syntax.SetType)
    @TIES(syntax.SequenceType)
    def _visit_settype(self, node: syntax.SetType | syntax.SequenceType, scope: Scope) -> None:
        self.visit(node.element, scope)

    @TIES(syntax.TupleType)
    def _visit_tupletype(self, node: syntax.TupleType, scope: Scope) -> None:
        self._visit_all(node.items, scope)

    @TIES(syntax.MapType)
    def _visit_maptype(self, node: syntax.MapType, scope: Scope) -> None:
        self._visit_all((node.key, node.value), scope)

    @TIES(syntax.FunctionType)
    def _visit_functiontype(self, node: syntax.FunctionType, scope: Scope) -> None:
        self._visit_all((*node.parameters, node.result), scope)

    @TIES(syntax.DotType)
    def _visit_dottype(self, node: syntax.DotType, scope: Scope) -> None:
        self._visit_all((node.left, node.right), scope)

    @TIES(syntax.DotableType)
    def _visit_dotabletype(self, node: syntax.DotableType, scope: Scope) -> None:
        self._visit_all((node.argument, node.result), scope)

    # --- visiting assertions --------------------------------------------------------------------------------

    @TIES(syntax.AssertDeclaration)
    def _visit_assertdeclaration(self, node: syntax.AssertDeclaration, scope: Scope) -> None:
        self.visit(node.assertion, scope)

    @TIES(syntax.Refinement)
    def _visit_refinement(self, node: syntax.Refinement, scope: Scope) -> None:
        self._visit_all((node.specification, node.implementation), scope)
        self._options(node.options, scope)

    @TIES(syntax.Property)
    def _visit_property(self, node: syntax.Property, scope: Scope) -> None:
        self.visit(node.process, scope)
        if node.trace is not None:
            self.visit(node.trace, scope)
        self._options(node.options, scope)

    def _options(self, options: Iterable[syntax.AssertOption], scope: Scope) -> None:
        for option in options:
            if option.events is not None:
                self.visit(option.events, scope)
            self._visit_all(option.types, scope)
            if option.kind == "symmetry reduce":
                self.names.warnings.append(messages.symmetry_not_used(option.span))

    @TIES(syntax.BooleanAssertion)
    def _visit_booleanassertion(self, node: syntax.BooleanAssertion, scope: Scope) -> None:
        self.visit(node.condition, scope)

    @TIES(syntax.NotAssertion)
    def _visit_notassertion(self, node: syntax.NotAssertion, scope: Scope) -> None:
        self.visit(node.inner, scope)


def _arguments(shape: Sequence[int]) -> str:
    counts = [f"{n} argument{'' if n == 1 else 's'}" for n in shape]
    return " and then ".join(counts)
