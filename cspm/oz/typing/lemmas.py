"""Lemmas: predicates that are to be proved and then help to prove, with what helps to prove them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core, laws, syntax as s
from cspcheck.cspm.oz.typing import lemma_messages as messages, type_messages
from cspcheck.cspm.oz.typing.fitting import unknown_in
from cspcheck.cspm.oz.typing.scopes import (
    ParameterEntry,
    PredicatePlace,
    SetEntry,
    TypingScope,
    VariableEntry,
    whole,
)
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.typing.uses import WrongArgument, fitted, outermost
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
        self._fitted: set[Span] = set()
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
            using=self.uses(hints.using, self._inside(inner, term), place),
            induction=None if on is None else on.name,
            span=tree.span,
        )

    def _inside(self, scope: TypingScope, term: core.Term) -> TypingScope:
        """The scope with the variables that a lemma is about."""
        inner = TypingScope(scope)
        for binder in outermost(term):
            variable = core.Variable(type=binder.type, name=binder.name, role="bound")
            if inner.own(binder.written) is None and term.span is not None:
                inner.add(binder.written, VariableEntry(variable, term.span))
        return inner

    def uses(self, uses: Iterable[s.LemmaUse], scope: TypingScope, place: PredicatePlace) -> tuple[core.LemmaUse, ...]:
        """Lemmas with the values that they are used for, whose types are looked at when all lemmas are known.

        Raises:
            Wrong: something in a value is wrong.
        """
        found = []
        for use in uses:
            arguments = tuple([self._typing.open_expression(term, scope, place) for term in use.arguments])
            found.append(core.LemmaUse(name=use.name, arguments=arguments, span=use.span))
        return tuple(found)

    def uses_of_operation(
        self, uses: Iterable[s.LemmaUse], scope: TypingScope, parameters: Iterable[core.Parameter]
    ) -> tuple[core.LemmaUse, ...]:
        """What an operation says that proofs about it need; mistakes are reported."""
        inner = TypingScope(scope)
        for parameter in parameters:
            entry = ParameterEntry(parameter.name, parameter.kind, parameter.type, parameter.span)
            inner.add(parameter.name, entry)
        try:
            return self.uses(uses, inner, "effect")
        except Wrong as wrong:
            self._report(wrong.diagnostic)
            return ()

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
                self._fit(lemmas.get(tree.name), lemmas)
            elif isinstance(tree, s.Class) and tree.name in models:
                known = {**lemmas, **models[tree.name].lemmas}
                for paragraph in tree.paragraphs:
                    if isinstance(paragraph, s.Lemma):
                        self._known(paragraph.hints, known)
                        self._fit(known.get(paragraph.name), known)
                for operation in tree.operations:
                    self._known(s.Hints(span=operation.span, using=operation.using), known)
                for made in models[tree.name].operations.values():
                    self._fit(made, known)
        for table in (lemmas, *[{**lemmas, **model.lemmas} for model in models.values()]):
            self._acyclic(table)

    def _known(self, hints: s.Hints | None, lemmas: Mapping[str, core.Lemma]) -> None:
        for name in hints.using if hints is not None else ():
            if not (name.name in lemmas or name.name in self._wrong or name.name in laws.names()):
                near = suggestions(name.name, [*lemmas, *laws.names()])
                self._report(messages.unknown_lemma(name.name, name.span, near))

    def _fit(self, user: core.Lemma | core.Operation | None, lemmas: Mapping[str, core.Lemma]) -> None:
        """Report values of another number or type than the variables of the lemma that is used for them."""
        for use in user.using if user is not None else ():
            lemma = lemmas.get(use.name) or (laws.laws()[use.name] if use.name in laws.names() else None)
            if lemma is None or not use.arguments or use.span is None or use.span in self._fitted:
                continue
            self._fitted.add(use.span)  # a child has the operations of its parents
            binders = outermost(lemma.term)
            if len(binders) != len(use.arguments):
                names = [binder.written for binder in binders]
                self._report(messages.lemma_arguments(use.name, names, len(use.arguments), use.span))
                continue
            try:
                fitted(lemma, use.arguments)
            except WrongArgument as wrong:
                argument = use.arguments[wrong.position]
                if unknown_in(argument.type):
                    self._report(type_messages.open_type(argument.span or use.span))
                    continue
                name, types = binders[wrong.position].written, (str(wrong.wanted), str(argument.type))
                self._report(messages.lemma_argument(use.name, name, *types, argument.span or use.span))

    def _acyclic(self, lemmas: Mapping[str, core.Lemma]) -> None:
        sorter = TopologicalSorter({name: [use.name for use in lemma.using] for name, lemma in lemmas.items()})
        try:
            sorter.prepare()
        except CycleError as cycle:
            names = cycle.args[1]
            span = lemmas[names[0]].span
            if span is not None:
                self._report(messages.circular_lemmas(names, span))


def helpful(
    tree: s.Class, event: str, inherited: core.Operation | None
) -> tuple[tuple[core.LemmaUse, ...], tuple[s.LemmaUse, ...]]:
    """The lemmas for proofs about an operation: those that the class's parents name, and those that it names itself."""
    own: list[s.LemmaUse] = []
    for operation in tree.operations:
        if operation.name in (event, *[f"{prefix}_{event}" for prefix in ("com", "enable", "effect")]):
            own += operation.using
    return inherited.using if inherited is not None else (), tuple(own)
