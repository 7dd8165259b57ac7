"""Scopes: where a name is looked up, through modules and instances too, and what is said when it is not found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.naming import messages as messages
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TIMED_BUILTINS, TRANSPARENT
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax

BUILTIN_SYMBOLS = {
    name: Symbol(name, SymbolKind.BUILTIN, None) for name in sorted(BUILTINS | TIMED_BUILTINS | TRANSPARENT | EXTERNAL)
}
"""One symbol for each name of the language, shared by all scripts."""

MODULES = frozenset({SymbolKind.MODULE, SymbolKind.INSTANCE})
MATCHED = frozenset({SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR})
"""What a name in a pattern matches instead of binding it."""


class Scope:
    """A set of declarations that see each other, inside another; ``module`` is the module that they belong to."""

    __slots__ = ("module", "names", "parent", "timed")

    def __init__(self, parent: Scope | None, module: Symbol | None, *, timed: bool = False) -> None:
        self.parent = parent
        self.module = module
        self.timed = timed
        self.names: dict[str, Symbol] = {}

    def within(self) -> Scope:
        """A new scope inside this one."""
        return Scope(self, self.module, timed=self.timed)

    def in_timed_section(self) -> Scope:
        """The same names, seen from inside a Timed section."""
        return Scope(self, self.module, timed=True)

    def find(self, name: str) -> Symbol | None:
        """The innermost thing of that name, built-ins last."""
        scope: Scope | None = self
        while scope is not None:
            symbol = scope.names.get(name)
            if symbol is not None:
                return symbol
            scope = scope.parent
        if name in BUILTINS or (self.timed and name in TIMED_BUILTINS):
            return BUILTIN_SYMBOLS[name]
        return None

    def find_module(self, name: str) -> Symbol | None:
        """The innermost module or instance of that name."""
        scope: Scope | None = self
        while scope is not None:
            symbol = scope.names.get(name)
            if symbol is not None and symbol.kind in MODULES:
                return symbol
            scope = scope.parent
        return None

    def known(self) -> Iterator[Symbol]:
        """Everything in scope that is not built in, innermost first."""
        scope: Scope | None = self
        while scope is not None:
            yield from scope.names.values()
            scope = scope.parent


class NotFound(Exception):
    """A name that cannot be used; ``diagnostic`` says why."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(diagnostic.message)


class Lookup:
    """Finds what plain and qualified names mean."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self._instance_scopes: dict[Symbol, Scope] = {}
        self._resolving: set[Symbol] = set()

    def instance_declared(self, symbol: Symbol, scope: Scope) -> None:
        """Remember where an instance stands: its module is found when first needed."""
        self._instance_scopes[symbol] = scope

    def module_of(self, instance: Symbol) -> Symbol:
        """The module that an instance instantiates.

        Raises:
            NotFound: there is none, or finding it needs the instance itself.
        """
        base = instance.base
        if base.module is None:
            declaration = base.declaration
            assert isinstance(declaration, syntax.InstanceDeclaration)
            node = declaration.module
            if base in self._resolving:
                raise NotFound(messages.not_a_module(node.text, node.span))
            self._resolving.add(base)
            try:
                found = self.find(self._instance_scopes[base], node.parts, node.span)
            finally:
                self._resolving.discard(base)
            if found.kind is not SymbolKind.MODULE:
                raise NotFound(messages.not_a_module(node.text, node.span))
            base.module = found
        instance.module = base.module
        return base.module

    def find(self, scope: Scope, parts: Sequence[str], span: Span) -> Symbol:
        """What the name *parts* means in *scope*.

        Raises:
            NotFound: nothing, or nothing that may be used here.
        """
        symbol: Symbol | None = None
        if len(parts) > 1:
            # The members of a class, or a module: a variable of that name does not hide what is behind `::`.
            symbol = scope.find(f"{parts[0]}%") or scope.find_module(parts[0])
        symbol = symbol or scope.find(parts[0])
        if symbol is None:
            raise NotFound(self._undefined(scope, parts, span))
        for i, part in enumerate(parts[1:], 1):
            if symbol.kind not in MODULES:
                raise NotFound(
                    messages.undefined_name(
                        "::".join(parts),
                        span,
                        help_line=f"`{'::'.join(parts[:i])}` is not a module; write spaces around `::` for a type",
                    )
                )
            symbol = self._member(symbol, "::".join(parts[:i]), part, span)
        return symbol

    def _member(self, container: Symbol, path: str, name: str, span: Span) -> Symbol:
        if container.kind is SymbolKind.INSTANCE:
            module = self.module_of(container).base
            seen_through: Symbol | None = container
        else:
            module, seen_through = container.base, container.instance
            if module.parameters_declared:
                raise NotFound(messages.needs_instance(name, path, span))
        member = module.members.get(name)
        if member is None:
            close = suggestions(name, module.exported)
            raise NotFound(messages.undefined_name(f"{path}::{name}", span, [f"{path}::{c}" for c in close]))
        if name not in module.exported:
            raise NotFound(messages.private_name(name, module.name, span, member.span))
        return member if seen_through is None else self.names.project(seen_through, member)

    def _undefined(self, scope: Scope, parts: Sequence[str], span: Span) -> Diagnostic:
        name = parts[0]
        if len(parts) > 1:
            modules = [s.name for s in scope.known() if s.kind in MODULES]
            return messages.undefined_name(name, span, suggestions(name, modules))
        if name in TIMED_BUILTINS:
            return messages.undefined_name(name, span, help_line=f"`{name}` can be used inside a Timed section only")
        for kind, importable in (("transparent", TRANSPARENT), ("external", EXTERNAL)):
            if name in importable:
                return messages.undefined_name(name, span, help_line=f"import it with `{kind} {name}`")
        for module in (s for s in scope.known() if s.kind is SymbolKind.MODULE):
            member = module.members.get(name)
            if member is None:
                continue
            if name not in module.exported:
                return messages.private_name(name, module.name, span, member.span)
            if module.parameters_declared:
                return messages.needs_instance(name, module.name, span)
            return messages.undefined_name(name, span, [f"{module.name}::{name}"])
        known = [s.name for s in scope.known()]
        return messages.undefined_name(name, span, suggestions(name, [*known, *sorted(BUILTINS)]))
