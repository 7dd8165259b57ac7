"""What paragraphs declare, by types that are found when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects.scopes import Deferred, Entry, Scope, Value
from cspcheck.cspm.oz.objects.terms import Terms
from cspcheck.cspm.oz.objects.types import Given, ObjectZType, Open, Power, bindings, pairs
from cspcheck.cspm.oz.typing import messages as class_messages
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax.tree import NameDeclaration


class Paragraphs:
    """Declares paragraphs, at the top of a document or in a class, and types their predicates.

    Args:
        terms: of the document.
        owner: what the names of given types begin with, to tell those of classes apart.
    """

    def __init__(self, terms: Terms, scope: Scope, owner: str = "") -> None:
        self._terms = terms
        self._scope = scope
        self._owner = f"{owner}." if owner else ""

    def declare(self, paragraph: s.Paragraph) -> dict[str, Entry]:
        """What a paragraph declares; nothing is typed before it is asked for."""
        match paragraph:
            case s.GivenTypes(names=names):
                return {n.name: Value(Power(Given(self._owner + n.name)), n.span) for n in names}
            case s.FreeType():
                return self._free(paragraph)
            case s.Abbreviation():
                scope, generics = self._generic(paragraph.name, paragraph.generics)

                def body(node: s.Abbreviation = paragraph) -> ObjectZType:
                    return self._terms.term(node.body, scope)

                return {paragraph.name: self._deferred(paragraph.name, body, paragraph.span, generics)}
            case s.Schema():
                scope, generics = self._generic(paragraph.name, paragraph.generics)

                def schema(node: s.Schema = paragraph) -> ObjectZType:
                    fields = self._terms.declared(node.declarations, scope)
                    return Power(bindings({name: value.type for name, value in fields.items()}))

                return {paragraph.name: self._deferred(paragraph.name, schema, paragraph.span, generics)}
            case s.Axiom():
                return self._axiom(paragraph)
        return {}

    def check(self, paragraph: s.Paragraph) -> None:
        """Type the predicates of a paragraph; mistakes are reported."""
        for entry in self.declare(paragraph):
            found = self._scope.find(entry)
            if isinstance(found, Deferred):
                found.make()
        match paragraph:
            case s.Schema():
                scope, _ = self._generic(paragraph.name, paragraph.generics)
                inner = Scope(scope, self._terms.declared(paragraph.declarations, scope))
                self._terms.predicates(paragraph.predicates, inner)
                self._terms.predicates(paragraph.initial or (), inner)
            case s.Axiom():
                scope, _ = self._generic(_place(paragraph), paragraph.generics)
                # Here the constants are those for the sets that the paragraph speaks of.
                own = [(n, self._scope.find(n)) for n in self.declare(paragraph)]
                made = {n: e.make() for n, e in own if isinstance(e, Deferred)}
                inner = Scope(scope, {n: Value(v.type, v.span) for n, v in made.items() if v is not None})
                self._terms.predicates(paragraph.predicates, inner)
            case s.Lemma():
                scope, _ = self._generic(paragraph.name, paragraph.generics)
                self._terms.predicates([paragraph.predicate], scope)

    def _generic(self, name: str, generics: Sequence[NameDeclaration]) -> tuple[Scope, tuple[str, ...]]:
        """The scope in a generic paragraph, and what its parameters are called in types."""
        names = tuple([f"{self._owner}{name}.{generic.name}" for generic in generics])
        if not names:
            return self._scope, ()
        inside = {g.name: Value(Power(Given(n)), g.span) for g, n in zip(generics, names, strict=True)}
        return Scope(self._scope, inside), names

    def _free(self, paragraph: s.FreeType) -> dict[str, Entry]:
        type_ = Given(self._owner + paragraph.name)
        found: dict[str, Entry] = {paragraph.name: Value(Power(type_), paragraph.span)}
        for branch in paragraph.branches:
            if branch.argument is None:
                found[branch.name] = Value(type_, branch.span)
                continue

            def constructor(argument: s.Term = branch.argument) -> ObjectZType:
                return pairs(self._terms.element(argument, self._scope), type_)

            found[branch.name] = self._deferred(branch.name, constructor, branch.span, ())
        return found

    def _axiom(self, paragraph: s.Axiom) -> dict[str, Entry]:
        scope, generics = self._generic(_place(paragraph), paragraph.generics)
        found: dict[str, Entry] = {}
        for declaration in paragraph.declarations:

            def element(carrier: s.Term = declaration.carrier) -> ObjectZType:
                return self._terms.element(carrier, scope)

            for declared in declaration.names:
                name = declared.name + declared.decoration
                found[name] = self._deferred(name, element, declared.span, generics)
        return found

    def _deferred(self, name: str, make: Callable[[], ObjectZType], span: Span, generics: tuple[str, ...]) -> Deferred:
        """An entry that is made once; one that needs itself, or is wrong, may be of any type."""
        made: list[Value] = []
        waiting: list[str] = []

        def once() -> Value:
            if made:
                return made[0]
            if waiting:
                self._terms.report(class_messages.recursive_schema(name, span))
                return Value(Open(), span)
            waiting.append(name)
            try:
                found = Value(make(), span, generics)
            except Wrong as wrong:
                self._terms.report(wrong.diagnostic)
                found = Value(Open(), span)
            made[:] = made or [found]
            return made[0]

        return Deferred(once, span)


def _place(paragraph: s.Axiom) -> str:
    """What tells the generic parameters of constants from those of others."""
    return f"const{paragraph.span.start}"
