"""What every rule of inference uses: the types of symbols, fresh variables, and mistakes told where they are seen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.notation import extension
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.dispatch import Dispatch
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.builtins import DEPRECATED, builtin_scheme
from cspcheck.cspm.typing.inference.mistakes import explain
from cspcheck.cspm.typing.inference.views import Views
from cspcheck.cspm.typing.types import (
    Constraints,
    Rigid,
    Scheme,
    Type,
    Variable,
    free_variables,
    larger_than,
    resolve,
    substitute,
)
from cspcheck.cspm.typing.unification import TypeClash, Unifier

Origin = Callable[[], Label | None]
"""Gives, when a mistake is told, the place that makes the demand."""


LARGEST = 20_000
"""Parts that the type of a definition may have."""


def first_line(span: Span) -> Span:
    """The part of *span* in its first line: enough to show where a long declaration stands."""
    return Span(span.source, span.start, span.start + len(span.text.split("\n", 1)[0]))


class Rejected(Exception):
    """An expression or declaration without a type; ``diagnostic`` says why."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


INFERS: Final = Dispatch[Callable[[Any, Any], Type]]("infer the type of")
"""The rules for expressions and patterns, by the form."""


class InferenceContext:
    """The state of one inference.

    ``level`` is the depth of the definition at hand, see :class:`~cspcheck.cspm.typing.types.Variable`.
    ``expression_types`` has the type of every expression and pattern by the identity of its node.
    """

    def __init__(self, names: Names, views: Views) -> None:
        self.names = names
        self.views = views
        self.unifier = Unifier()
        self.level = 1
        self.expression_types: dict[int, Type] = {}
        self.warnings: list[Diagnostic] = []
        self.rigid: dict[str, Rigid] = {}
        """The variables of the annotations around the place at hand."""
        self.defining: dict[Symbol, Type] = {}
        """What the definitions at hand make of their symbols, inside themselves."""
        self.undecided: list[tuple[Type, syntax.Node, str]] = []
        """Datatypes that were compared before it was known whether they have equality, and where."""
        self.shared: set[Symbol] = set()
        """Local definitions that would be polymorphic if they were annotated."""
        self.dots: list[tuple[syntax.Expr, Type]] = []
        """The dotted expressions of the definitions at hand."""

    # --- inferring and checking ------------------------------------------------------------------------------

    def infer(self, node: syntax.Expr | syntax.Pattern) -> Type:
        """The type of an expression or a pattern.

        Raises:
            Rejected: it has none.
        """
        if isinstance(node, syntax.Foreign):
            type_ = extension().foreign_type(self, node)
        else:
            type_ = INFERS[type(node)](self, node)
        self.expression_types[id(node)] = type_
        return type_

    def check(
        self, node: syntax.Expr | syntax.Pattern, expected: Type, role: str, origin: Origin | None = None
    ) -> None:
        """Infer *node* and make its type *expected*; *role* names the place, *origin* where the demand comes from."""
        self.agree(expected, self.infer(node), node, role, origin)

    def agree(self, expected: Type, actual: Type, node: syntax.Node, role: str, origin: Origin | None = None) -> None:
        """Make two types the same. Raises Rejected."""
        try:
            self.unifier.unify(expected, actual)
        except TypeClash as clash:
            raise self.rejected(clash, expected, actual, node, role, origin) from None
        if self.unifier.undecided:
            self._note_undecided(node, role)

    def accept(self, expected: Type, actual: Type, node: syntax.Node, role: str, origin: Origin | None = None) -> None:
        """Let a parameter or pattern of type *expected* take a value of type *actual*. Raises Rejected."""
        try:
            self.unifier.argument(expected, actual)
        except TypeClash as clash:
            raise self.rejected(clash, expected, actual, node, role, origin) from None
        if self.unifier.undecided:
            self._note_undecided(node, role)

    def require(self, constraints: Constraints, type_: Type, node: syntax.Node, role: str) -> None:
        """Make a type satisfy constraints. Raises Rejected."""
        try:
            self.unifier.constrain(constraints, type_)
        except TypeClash as clash:
            raise self.rejected(clash, type_, type_, node, role, None) from None
        if self.unifier.undecided:
            self._note_undecided(node, role)

    def settle(self, type_: Type, node: syntax.Node, role: str) -> Type:
        """Read the dots of a type by the longest match. Raises Rejected."""
        try:
            return self.unifier.settle(type_)
        except TypeClash as clash:
            raise self.rejected(clash, type_, type_, node, role, None) from None

    def check_dots(self) -> None:
        """Hold the fields in each dotted expression against its channel or constructor, where nothing else has.

        A field that is still open stays so: how much it stands for may be different for each use. Raises Rejected.
        """
        for node, type_ in self.dots:
            clash = self.unifier.misfit(type_)
            if clash is not None:
                raise self.rejected(clash, type_, type_, node, "", None)
        self.dots.clear()

    def rejected(
        self, clash: Exception, expected: Type, actual: Type, node: syntax.Node, role: str, origin: Origin | None
    ) -> Rejected:
        """The rejection that tells of a clash at *node*."""
        self.unifier.undecided.clear()
        return Rejected(explain(clash, expected, actual, node, role, None if origin is None else origin()))

    def _note_undecided(self, node: syntax.Node, role: str) -> None:
        self.undecided.extend([(datatype, node, role) for datatype in self.unifier.undecided])
        self.unifier.undecided.clear()

    # --- variables and symbols -------------------------------------------------------------------------------

    def fresh(self, constraints: Constraints = 0) -> Variable:
        """A new variable of the definition at hand."""
        return Variable(self.level, constraints)

    def instantiate(self, scheme: Scheme) -> Type:
        """A copy of the scheme's type with fresh variables."""
        if not scheme.variables:
            return scheme.type
        mapping: dict[Type, Type] = {variable: self.fresh(variable.constraints) for variable in scheme.variables}
        return substitute(scheme.type, mapping.get)

    def generalise(self, type_: Type, node: syntax.Node, name: str | None = None) -> Scheme:
        """The scheme of *type_* over the variables that belong to definitions deeper than the one at hand.

        Raises Rejected if the type is too large for a scheme, which is copied with each use.
        """
        if larger_than(type_, LARGEST):
            raise Rejected(messages.type_too_large(first_line(node.span), name))
        return Scheme(tuple([v for v in free_variables(type_) if v.level > self.level]), resolve(type_))

    def symbol_type(self, symbol: Symbol, span: Span | None = None) -> Type:
        """The type of one use of *symbol*, at *span*."""
        if symbol.kind is SymbolKind.BUILTIN:
            if symbol.name in DEPRECATED and span is not None:
                self.warnings.append(messages.deprecated_name(symbol.name, DEPRECATED[symbol.name], span))
            return self.instantiate(builtin_scheme(symbol.name))
        return self.instantiate(self.views.scheme(symbol))
