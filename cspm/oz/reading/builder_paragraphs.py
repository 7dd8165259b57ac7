# ruff: noqa: D102 - an action is documented by the alternative of the grammar that it is named in
"""The actions of ``grammar/oz.lark`` for paragraphs and the sections of classes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal, NamedTuple, cast

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.builder import Names, TermBuilder
from cspcheck.cspm.oz.reading.layout import Laid
from cspcheck.cspm.parsing import class_messages
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as s

ReadEquations = Callable[[Span], tuple[tuple[s.Declaration, ...], list[Diagnostic]]]
"""Reads process equations: those in a part of a source, and what is wrong in them."""


class _Section(NamedTuple):
    """A part of a class: the attribute of ``syntax.Class`` that it goes to, and what it adds or is."""

    attribute: str
    value: Any
    span: Span


_ONCE = {"visibility": "visible", "state": "state", "initial": "init"}
"""What a class has at most once, by the word that begins it."""


class ParagraphBuilder(TermBuilder):
    """Builds paragraphs."""

    def __init__(self, laid: Laid, read_equations: ReadEquations) -> None:
        super().__init__(laid)
        self._read_equations = read_equations

    # --- paragraphs ------------------------------------------------------------------------------------------

    def given_types(self, span: Span, names: list[s.NameDeclaration]) -> z.Paragraph:
        return z.GivenTypes(span=span, names=tuple(names))

    def axiom(
        self,
        span: Span,
        generics: Sequence[s.NameDeclaration],
        declarations: Sequence[z.Declare],
        predicates: Sequence[z.Term] = (),
    ) -> z.Axiom:
        return z.Axiom(
            span=span, declarations=_read(declarations), predicates=_read(predicates), generics=tuple(generics)
        )

    def axiom_block(
        self,
        span: Span,
        generics: Sequence[s.NameDeclaration],
        declarations: list[z.Declare],
        predicates: list[z.Term],
        end: int,
    ) -> z.Axiom:
        self._closing(span, end)
        return self.axiom(span, generics, declarations, predicates)

    def _closing(self, span: Span, end: int) -> None:
        """Check the ``end`` of a block."""
        if self.laid.kinds[end] != "UNCLOSED":
            return
        first = self.index_at(span)
        ends = [token for token in self.laid.found[: self.laid.origins[end]] if token.kind == "end"]
        last = self.laid.source.span(ends[-1].start, ends[-1].end) if ends else None
        word = str(self.token(first).value)
        self.errors.append((end, messages.unclosed_block(self.laid.span(first), word, last)))

    def schema(
        self,
        span: Span,
        name: s.NameDeclaration,
        generics: list[s.NameDeclaration],
        declarations: list[z.Declare],
        predicates: list[z.Term],
        initial: Sequence[tuple[z.Term, ...]],
        end: int,
    ) -> z.Schema:
        self._closing(span, end)
        return z.Schema(
            span=span,
            name=name.name,
            declarations=_read(declarations),
            predicates=_read(predicates),
            initial=initial[0] if initial else None,
            generics=tuple(generics),
        )

    def initial_of_schema(self, span: Span, predicates: list[z.Term]) -> tuple[tuple[z.Term, ...]]:
        return (_read(predicates),)

    def abbreviation(
        self, span: Span, name: s.NameDeclaration, generics: list[s.NameDeclaration], body: z.Term
    ) -> z.Paragraph:
        return z.Abbreviation(span=span, name=name.name, body=body, generics=tuple(generics))

    def composed(self, span: Span, left: z.Term, right: z.Term) -> z.Term:
        return z.Operator(span=span, name="compose", operands=(left, right))

    def piped(self, span: Span, left: z.Term, right: z.Term) -> z.Term:
        return z.Operator(span=span, name="pipe", operands=(left, right))

    def free_type(
        self, span: Span, name: s.NameDeclaration, generics: list[s.NameDeclaration], branches: list[z.Branch]
    ) -> z.Paragraph:
        return z.FreeType(span=span, name=name.name, branches=tuple(branches))

    def branch(self, span: Span, name: s.NameDeclaration, argument: z.Term | None = None) -> z.Branch:
        return z.Branch(span=span, name=name.name, argument=argument)

    def reading(self, span: Span, subject: z.Term, carrier: z.Term) -> z.Paragraph:
        return z.Reading(span=span, subject=subject, carrier=carrier)

    def view(self, span: Span, kind: int) -> z.Paragraph:
        return z.View(span=span, kind=cast(Literal["control", "data"], self.token(kind).value))

    def retrieve(
        self,
        span: Span,
        name: s.NameDeclaration,
        abstract: s.NameDeclaration,
        concrete: s.NameDeclaration,
        predicates: list[z.Term],
        end: int,
    ) -> z.Paragraph:
        self._closing(span, end)
        return z.Retrieve(span=span, name=name.name, abstract=abstract, concrete=concrete, predicates=_read(predicates))

    def lemma(
        self,
        span: Span,
        name: s.NameDeclaration,
        generics: list[s.NameDeclaration],
        predicate: z.Term,
        hints: z.Hints | Sequence[Any],
    ) -> z.Lemma:
        return z.Lemma(
            span=span,
            name=name.name,
            predicate=predicate,
            generics=tuple(generics),
            hints=hints if isinstance(hints, z.Hints) else None,
        )

    def using(self, span: Span, uses: list[z.LemmaUse], on: s.NameDeclaration | None = None) -> z.Hints:
        return z.Hints(span=span, using=tuple(uses), induction=on)

    def use(self, span: Span, name: s.NameDeclaration, arguments: Sequence[z.Term] = ()) -> z.LemmaUse:
        return z.LemmaUse(span=name.span, name=name.name, arguments=_read(arguments))

    def induction(self, span: Span, on: s.NameDeclaration) -> z.Hints:
        return z.Hints(span=span, induction=on)

    # --- classes ---------------------------------------------------------------------------------------------

    def class_(
        self,
        span: Span,
        name: s.NameDeclaration,
        generics: list[s.NameDeclaration],
        sections: Sequence[_Section | None],
        end: int,
    ) -> z.Class:
        parts: dict[str, Any] = {}
        places: dict[str, Span] = {}
        for section in sections:
            if section is None:
                continue
            attribute, value, place = section
            word = _ONCE.get(attribute)
            if word is None:
                parts.setdefault(attribute, []).extend(value)
                continue
            index = self.index_at(place)
            keyword = self.laid.span(index)
            if attribute in places:
                self.errors.append((index, messages.section_twice(keyword, word, places[attribute])))
            else:
                places[attribute] = keyword
                parts[attribute] = value
        self._closing(span, end)
        once: dict[str, Any] = {attribute: parts.pop(attribute, None) for attribute in _ONCE}
        many: dict[str, Any] = {attribute: tuple(found) for attribute, found in parts.items()}
        return z.Class(span=span, name=name.name, generics=tuple(generics), **once, **many)

    def stray_end(self, span: Span, end: int) -> None:
        self.errors.append((end, class_messages.end_too_many(span)))

    def visible(self, span: Span, names: Sequence[s.NameDeclaration] = ()) -> _Section:
        return _Section("visibility", tuple(names), span)

    def inherit(self, span: Span, parents: list[z.Inherit]) -> _Section:
        return _Section("inherits", parents, span)

    def parent(
        self,
        span: Span,
        name: s.NameDeclaration,
        arguments: Sequence[z.Term] = (),
        renamings: Sequence[tuple[s.NameDeclaration, s.NameDeclaration]] = (),
    ) -> z.Inherit:
        return z.Inherit(span=span, name=name.name, arguments=tuple(arguments), renamings=tuple(renamings))

    def renamed_parent(
        self, span: Span, parent: z.Inherit, renamings: list[tuple[s.NameDeclaration, s.NameDeclaration]]
    ) -> z.Inherit:
        later = {old.name: new for new, old in renamings}
        done = {new.name for new, _ in parent.renamings}
        both = [(later.get(new.name, new), old) for new, old in parent.renamings]
        both = [(new, old) for new, old in both if new.name != old.name]  # the later undoes the earlier
        both += [(new, old) for new, old in renamings if old.name not in done]
        return z.Inherit(span=span, name=parent.name, arguments=parent.arguments, renamings=tuple(both))

    def interface(
        self, span: Span, word: int, names: list[s.NameDeclaration], parameters: Sequence[z.Declare] = ()
    ) -> _Section:
        kind = cast(Literal["chan", "method", "local_chan"], self.laid.kinds[word])
        made = z.Interface(span=span, kind=kind, names=tuple(names), parameters=tuple(parameters))
        return _Section("interface", (made,), span)

    def equations(self, span: Span, index: int) -> _Section:
        found, errors = self._read_equations(span)
        self.errors += [(index, error) for error in errors]
        return _Section("equations", found, span)

    def paragraph_of_class(self, span: Span, paragraph: z.Paragraph) -> _Section:
        return _Section("paragraphs", (paragraph,), span)

    def given_types_of_class(self, span: Span, names: list[s.NameDeclaration]) -> _Section:
        return self.paragraph_of_class(span, self.given_types(span, names))

    def state(
        self, span: Span, primary: list[z.Declare], secondary: list[z.Declare], predicates: list[z.Term]
    ) -> _Section:
        made = z.State(span=span, primary=_read(primary), secondary=_read(secondary), predicates=_read(predicates))
        return _Section("state", made, span)

    def init(self, span: Span, predicates: list[z.Term]) -> _Section:
        return _Section("initial", z.Initial(span=span, predicates=_read(predicates)), span)

    def operation_schema(
        self,
        span: Span,
        name: s.NameDeclaration,
        declarations: list[z.Declare],
        predicates: list[z.Term],
        lemmas: list[z.LemmaUse],
    ) -> _Section:
        return self._operation_schema(span, name, None, declarations, predicates, lemmas)

    def operation_schema_with_delta(
        self,
        span: Span,
        name: s.NameDeclaration,
        delta: Names,
        declarations: list[z.Declare],
        predicates: list[z.Term],
        lemmas: list[z.LemmaUse],
    ) -> _Section:
        return self._operation_schema(span, name, delta, declarations, predicates, lemmas)

    def _operation_schema(
        self,
        span: Span,
        name: s.NameDeclaration,
        delta: Names | None,
        declarations: Sequence[z.Declare],
        predicates: Sequence[z.Term],
        lemmas: Sequence[z.LemmaUse],
    ) -> _Section:
        made = z.OperationSchema(
            span=span,
            name=name.name,
            delta=delta,
            declarations=_read(declarations),
            predicates=_read(predicates),
            using=tuple(lemmas),
        )
        return _Section("operations", (made,), span)

    def operation_definition(
        self, span: Span, name: s.NameDeclaration, body: z.Term, lemmas: list[z.LemmaUse]
    ) -> _Section:
        if isinstance(body, z.OperationText):
            return self._operation_schema(span, name, body.delta, body.declarations, body.predicates, lemmas)
        made = z.OperationDefinition(span=span, name=name.name, body=body, using=tuple(lemmas))
        return _Section("operations", (made,), span)


def _read(items: Sequence[Any]) -> tuple[Any, ...]:
    """Items without those that stand for what was passed over."""
    return tuple(item for item in items if item is not None)
