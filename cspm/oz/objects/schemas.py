"""Schema expressions by their components alone (Spivey, *The Z Notation*, 1992, chapter 5)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects.scopes import ClassName, Deferred, Scope, Value
from cspcheck.cspm.oz.objects.types import Bindings, ObjectZType, Power, bindings, known, shown
from cspcheck.cspm.oz.typing import type_messages
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

if TYPE_CHECKING:
    from cspcheck.cspm.oz.objects.terms import Terms

Components = dict[str, ObjectZType]
"""Types of components by their decorated names."""


class SchemaCalculus:
    """Components of schema expressions."""

    def __init__(self, terms: Terms) -> None:
        self._terms = terms

    def components(self, type_: ObjectZType) -> Components | None:
        """The components of a schema; None for the type of something else."""
        found = known(type_)
        element = known(found.element) if isinstance(found, Power) else None
        return dict(element.fields) if isinstance(element, Bindings) else None

    def of(self, node: s.Term, scope: Scope) -> Components:
        """The components of a schema expression.

        Raises:
            Wrong: it is none.
        """
        type_ = self._terms.term(node, scope)
        found = self.components(type_)
        if found is None:
            raise Wrong(type_messages.no_schema(shown(type_), node.span))
        return found

    def text(self, node: s.SchemaText, scope: Scope) -> Components:
        """The components of ``[x : T | p]``, whose predicates are typed."""
        declared = self._terms.declared(node.declarations, scope)
        inner = self._terms.narrowed(Scope(scope, declared), [])
        self._terms.predicates(node.predicates, inner)
        return {name: value.type for name, value in declared.items()}

    def merge(self, target: Components, more: Mapping[str, ObjectZType], span: Span) -> None:
        """Add components; one that is there already has the same type.

        Raises:
            Wrong: it has another.
        """
        for name, type_ in more.items():
            first = target.setdefault(name, type_)
            if not self._terms.unification.same(first, type_):
                raise Wrong(type_messages.types_differ(shown(type_), shown(first), span))

    def said(self, schema: ObjectZType, scope: Scope, span: Span) -> None:
        """A schema as a predicate: of the variables that are called as its components.

        Raises:
            Wrong: one is not there, or of another type.
        """
        for name, type_ in (self.components(schema) or {}).items():
            entry = scope.find(name)
            if isinstance(entry, Deferred):
                entry = entry.make()
            if not isinstance(entry, Value):
                raise Wrong(type_messages.unknown_name(name, span, suggestions(name, scope.known())))
            self._terms.must(entry.type, type_, span)

    def prefixed(self, word: str, argument: s.Term, scope: Scope) -> ObjectZType:
        """``Delta S``, ``Xi S``, ``pre S``, ``theta S``."""
        found = self.of(argument, scope)
        if word == "theta":
            for name, type_ in found.items():
                entry = scope.find(name)
                if not isinstance(entry, Value | Deferred) or isinstance(entry, ClassName):
                    raise Wrong(type_messages.unknown_name(name, argument.span, suggestions(name, scope.known())))
                if isinstance(entry, Value):
                    self._terms.must(entry.type, type_, argument.span)
            return bindings({name.rstrip("'") if name.endswith("'") else name: t for name, t in found.items()})
        if word == "pre":
            return Power(bindings({name: t for name, t in found.items() if not name.endswith(("'", "!"))}))
        return Power(bindings(found | {f"{name}'": type_ for name, type_ in found.items()}))

    def combined(self, operator: str, left: Components, right: s.Term, scope: Scope, span: Span) -> Components:
        """Hiding, projection, composition and piping."""
        if operator == "diff":
            hidden = [node.name + node.decoration for node in _names(right)]
            missing = [name for name in hidden if name not in left]
            if missing:
                raise Wrong(type_messages.no_component(missing[0], right.span, suggestions(missing[0], left)))
            return {name: type_ for name, type_ in left.items() if name not in hidden}
        other = self.of(right, scope)
        merged: Components = {}
        if operator == "filter":
            self.merge(merged, left, span)
            self.merge(merged, other, span)
            return {name: type_ for name, type_ in merged.items() if name in other}
        first, second = ("'", "") if operator == "compose" else ("!", "?")
        joined = [(name, name[:-1] + second) for name in left if name.endswith(first) and name[:-1] + second in other]
        for before, after in joined:
            self._terms.must(left[before], other[after], span)
        self.merge(merged, {n: t for n, t in left.items() if n not in [a for a, _ in joined]}, span)
        self.merge(merged, {n: t for n, t in other.items() if n not in [b for _, b in joined]}, span)
        return merged


def _names(node: s.Term) -> list[s.Reference]:
    """The names in brackets behind a hiding."""
    node = s.bare(node)
    items = node.items if isinstance(node, s.Display) else (node,)
    return [item for item in items if isinstance(item, s.Reference)]
