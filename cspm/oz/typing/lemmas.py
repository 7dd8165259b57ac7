"""Lemmas: predicates that are to be proved and then help to prove, with what helps to prove them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core, laws, syntax as s
from cspcheck.cspm.oz.typing import messages, type_messages
from cspcheck.cspm.oz.typing.scopes import PredicatePlace, SetEntry, TypingScope, whole
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax


class Lemmas:
    """Types lemmas and looks at what they use.

    Attributes:
        givens: the given sets that stand for their generic parameters.
    """

    def __init__(self, typing: Typing, report: DiagnosticSink) -> None:
        self._typing = typing
        self._report = report
        self._wrong: set[str] = set()
        self.givens: dict[str, Span] = {}

    def declared(
        self, paragraphs: Iterable[s.Paragraph], scope: TypingScope, place: PredicatePlace
    ) -> dict[str, core.Lemma]:
        """The lemmas among paragraphs, by name; mistakes are reported."""
        found: dict[str, core.Lemma] = {}
        for tree in paragraphs:
            if not isinstance(tree, s.Lemma):
                continue
            first = found.get(tree.name)
            if first is not None and first.span is not None:
                self._report(type_messages.declared_twice(tree.name, first.span, tree.span))
            try:
                found[tree.name] = self._lemma(tree, scope, place)
            except Wrong as wrong:
                self._wrong.add(tree.name)
                self._report(wrong.diagnostic)
        return found

    def _lemma(self, tree: s.Lemma, scope: TypingScope, place: PredicatePlace) -> core.Lemma:
        inner = TypingScope(scope)
        givens = []
        for generic in tree.generics:
            given = core.GivenType(f"{tree.name}.{generic.name}")
            self.givens[given.name] = generic.span
            givens.append(given.name)
            inner.add(generic.name, SetEntry(whole(given), generic.span))
        term = self._typing.predicate(tree.predicate, inner, place)
        hints = tree.hints or s.Hints(span=tree.span)
        on = hints.induction
        if on is not None and on.name not in [binder.written for binder in outermost(term)]:
            raise Wrong(messages.induction_on_nothing(on.name, on.span))
        return core.Lemma(
            name=tree.name,
            term=term,
            givens=tuple(givens),
            using=tuple([name.name for name in hints.using]),
            induction=None if on is None else on.name,
            span=tree.span,
        )

    def check(
        self,
        declarations: Iterable[syntax.Declaration],
        lemmas: Mapping[str, core.Lemma],
        models: Mapping[str, core.ClassModel],
    ) -> None:
        """Report what is used and is not there, and lemmas that use each other."""
        for tree in declarations:
            if isinstance(tree, s.Lemma):
                self._known(tree.hints, lemmas)
            elif isinstance(tree, s.Class) and tree.name in models:
                known = {**lemmas, **models[tree.name].lemmas}
                for paragraph in tree.paragraphs:
                    self._known(paragraph.hints if isinstance(paragraph, s.Lemma) else None, known)
                for operation in tree.operations:
                    self._known(s.Hints(span=operation.span, using=operation.using), known)
        for table in (lemmas, *[{**lemmas, **model.lemmas} for model in models.values()]):
            self._acyclic(table)

    def _known(self, hints: s.Hints | None, lemmas: Mapping[str, core.Lemma]) -> None:
        for name in hints.using if hints is not None else ():
            if not (name.name in lemmas or name.name in self._wrong or name.name in laws.names()):
                near = suggestions(name.name, [*lemmas, *laws.names()])
                self._report(messages.unknown_lemma(name.name, name.span, near))

    def _acyclic(self, lemmas: Mapping[str, core.Lemma]) -> None:
        sorter = TopologicalSorter({name: lemma.using for name, lemma in lemmas.items()})
        try:
            sorter.prepare()
        except CycleError as cycle:
            names = cycle.args[1]
            span = lemmas[names[0]].span
            if span is not None:
                self._report(messages.circular_lemmas(names, span))


def outermost(term: core.Term) -> tuple[core.Binder, ...]:
    """The variables that a predicate says something of for all values, whatever else it says."""
    if isinstance(term, core.Quantifier) and term.kind == "forall":
        return (*term.binders, *outermost(term.body))
    return ()


def helpful(tree: s.Class, event: str, inherited: core.Operation | None) -> tuple[str, ...]:
    """The lemmas for proofs about an operation of a class, those that its parents name among them."""
    names = list(inherited.using if inherited is not None else ())
    for operation in tree.operations:
        if operation.name in (event, *[f"{prefix}_{event}" for prefix in ("com", "enable", "effect")]):
            names += [name.name for name in operation.using]
    return tuple(dict.fromkeys(names))
