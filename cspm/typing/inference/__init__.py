"""Type inference: every expression of a script gets a type, or the script a message that says why it has none.

Hindley-Milner (Damas and Milner 1982) with constrained variables and the dot types of
:mod:`cspcheck.cspm.typing.types`. Top-level definitions are generalised, in the order of their dependencies; a
``let`` is polymorphic only where annotated, and so are the types that FDR gives. What the rules say is in one file
for each subject: :mod:`.patterns`, :mod:`.expressions`, :mod:`.processes`, :mod:`.annotations`, :mod:`.declarations`,
:mod:`.modules`; a file for each of the order (:mod:`.dependencies`), of instances (:mod:`.views`) and of messages
(:mod:`.mistakes`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing.constraints import Unsatisfied
from cspcheck.cspm.typing.inference.context import Rejected
from cspcheck.cspm.typing.inference.dependencies import DependencyUnit, components, units_of
from cspcheck.cspm.typing.inference.mistakes import explain
from cspcheck.cspm.typing.inference.modules import ModuleRules
from cspcheck.cspm.typing.inference.processes import EVENTS
from cspcheck.cspm.typing.inference.views import Views
from cspcheck.cspm.typing.types import (
    BOOL,
    EQ,
    EVENT,
    PROC,
    Datatype,
    Scheme,
    SequenceOf,
    SetOf,
    Type,
    Variable,
    show_scheme,
)

__all__ = ["Types", "infer", "infer_assertion", "infer_expression"]

TOO_MANY = 20
"""After so many mistakes no more are looked for."""


class Types:
    """What inference found out about a script: a scheme for each definition, a type for each expression."""

    def __init__(self, names: Names, views: Views, declared: list[Symbol]) -> None:
        self.names = names
        self.declared = tuple(declared)
        """What the script declares at its top level, in order: values, functions, channels, types, constructors."""
        self.warnings: tuple[Diagnostic, ...] = ()
        self._views = views
        self._expressions: dict[int, Type] = {}
        self._kept: list[syntax.Node] = []

    def scheme(self, symbol: Symbol) -> Scheme:
        """The type of what *symbol* stands for, whatever instances of modules it is seen through.

        Raises:
            KeyError: it has none (a module, an instance, something from another script).
        """
        return self._views.scheme(symbol)

    def type_of(self, node: syntax.Expr | syntax.Pattern) -> Type:
        """The type of an expression or pattern of the script, as far as its definition determines it.

        Raises:
            KeyError: the node is not in the script, or is a dot inside a longer one.
        """
        return self._expressions[id(node)]

    def forget(self, root: syntax.Node, nodes: Iterable[syntax.Node], declared: Iterable[Symbol]) -> None:
        """Drop what is known of *nodes*, all those of a tree written against the script, and of what it declares."""
        self._kept = [kept for kept in self._kept if kept is not root]
        for node in nodes:
            self._expressions.pop(id(node), None)
        for symbol in declared:
            self._views.schemes.pop(symbol, None)

    def datatype(self, symbol: Symbol) -> Datatype:
        """The type of the values of a declared datatype."""
        return self._views.datatype(symbol)

    def listing(self) -> Iterator[tuple[str, str]]:
        """The top-level names with their types as annotations write them, in the order of the script."""
        for symbol in self.declared:
            yield symbol.name, show_scheme(self.scheme(symbol))


class _Inference(ModuleRules):
    """One run over a script, or over an expression or assertion behind it."""

    declared: list[Symbol]

    def script(self, script: syntax.Script) -> list[Diagnostic]:
        """Infer everything; the mistakes, in the order of the script."""
        units = units_of(script.declarations, self.names)
        self.declared = [
            symbol
            for unit in units
            if unit.module is None and not isinstance(unit.declaration, syntax.ModuleDeclaration)
            for symbol in unit.symbols
        ]
        found: list[Diagnostic] = []
        failed: set[DependencyUnit] = set()
        for unit in units:
            try:
                self.annotate(unit.symbols)
            except Rejected as rejected:
                failed.add(unit)
                found.append(rejected.diagnostic)
                for symbol in unit.symbols:
                    # Its users are not to blame: to them it is of any type.
                    anything = Variable(1)
                    self.views.schemes.setdefault(symbol, Scheme((anything,), anything))
        for group in components(units):
            if len(found) >= TOO_MANY:
                break
            if any(unit in failed or not failed.isdisjoint(unit.uses) for unit in group):
                failed.update(group)
                continue
            diagnostic = self._group(group)
            if diagnostic is not None:
                found.append(diagnostic)
                failed.update(group)
        found.extend(self._compared())
        return sorted(found, key=_position)

    def _group(self, group: list[DependencyUnit]) -> Diagnostic | None:
        """Infer one group; what is wrong with it."""
        cycle = self.cycle(group)
        if cycle is not None:
            return cycle
        self.rigid, self.defining = {}, {}
        self.dots.clear()
        mark = len(self.undecided)
        try:
            if len(group) == 1:
                node, depth = group[0].declaration, group[0].depth
                match node:
                    case syntax.ModuleDeclaration():
                        self.module_head(node, depth)
                        return None
                    case syntax.InstanceDeclaration():
                        self.instance(node, depth)
                        self.check_dots()
                        return None
                    case syntax.AssertDeclaration():
                        self.level = depth + 1
                        self.assertion(node.assertion)
                        self.check_dots()
                        return None
                    case syntax.PrintDeclaration():
                        if node.span not in self.names.unprintable:
                            self.level = depth + 1
                            self._printed(node)
                        return None
            self.group(group, group[0].depth)
        except Rejected as rejected:
            del self.undecided[mark:]
            return rejected.diagnostic
        return None

    def _printed(self, node: syntax.PrintDeclaration) -> None:
        """Infer what is only printed: a mistake in it stops nothing."""
        mark = len(self.undecided)
        try:
            self.settle(self.infer(node.expression), node.expression, "the expression")
        except Rejected as rejected:
            del self.undecided[mark:]
            self.warnings.append(replace(rejected.diagnostic, severity=Severity.WARNING))
            self.names.unprintable.add(node.span)

    def _compared(self) -> Iterator[Diagnostic]:
        """Comparisons of datatypes that turned out to have no equality."""
        told: set[int] = set()
        for datatype, node, role in self.undecided:
            assert isinstance(datatype, Datatype)
            if datatype.comparable is False and id(node) not in told:
                told.add(id(node))
                yield explain(Unsatisfied(EQ, datatype), datatype, datatype, node, role, None)
        self.undecided.clear()

    def assertion(self, node: syntax.Assertion) -> None:
        """Infer what an assertion speaks of. Raises Rejected."""
        match node:
            case syntax.Refinement():
                self.check(node.specification, PROC, "the specification")
                self.check(node.implementation, PROC, "the implementation")
                self._options(node.options)
            case syntax.Property():
                self.check(node.process, PROC, "the process of the assertion")
                if node.trace is not None:
                    self.check(node.trace, SequenceOf(EVENT), "the trace")
                self._options(node.options)
            case syntax.BooleanAssertion():
                self.check(node.condition, BOOL, "the assertion")
            case syntax.NotAssertion():
                self.assertion(node.inner)

    def _options(self, options: tuple[syntax.AssertOption, ...]) -> None:
        for option in options:
            if option.events is not None:
                self.check(option.events, EVENTS, "the set of the option")
            for types in option.types:
                self.check(types, SetOf(self.fresh()), "a type of the option")


def infer(script: syntax.Script, names: Names) -> Types:
    """Find the types of a whole script.

    Raises:
        ScriptError: with a mistake for each group of definitions that has no type; what depends on such a group is
            not looked at.
    """
    views = Views(names)
    inference = _Inference(names, views)
    with deep_recursion():
        mistakes = inference.script(script)
    if mistakes:
        raise ScriptError(*mistakes[:TOO_MANY])
    types = Types(names, views, [symbol for symbol in inference.declared if symbol in views.schemes])
    types.warnings = tuple(sorted(inference.warnings, key=_position))
    types._expressions = inference.expression_types
    types._kept.append(script)
    return types


def infer_expression(expression: syntax.Expr, types: Types) -> Scheme:
    """The type of an expression whose names are tied to the script of *types*.

    Raises:
        ScriptError: it has none.
    """
    with _later(types, expression) as inference:
        type_ = inference.settle(inference.infer(expression), expression, "the expression")
        inference.check_dots()
        inference.level = 0
        return inference.generalise(type_, expression)


def infer_assertion(assertion: syntax.Assertion, types: Types) -> None:
    """Check the types of an assertion whose names are tied to the script of *types*.

    Raises:
        ScriptError: something in it has not the type that it needs.
    """
    with _later(types, assertion) as inference:
        inference.assertion(assertion)
        inference.check_dots()


@contextmanager
def _later(types: Types, node: syntax.Node) -> Iterator[_Inference]:
    inference = _Inference(types.names, types._views)
    types._kept.append(node)
    with deep_recursion():
        try:
            yield inference
        except Rejected as rejected:
            raise ScriptError(rejected.diagnostic) from None
    mistakes = list(inference._compared())
    if mistakes:
        raise ScriptError(*mistakes)
    types._expressions.update(inference.expression_types)


def _position(diagnostic: Diagnostic) -> tuple[str, int]:
    return ("", -1) if diagnostic.span is None else (diagnostic.span.source.name, diagnostic.span.start)
