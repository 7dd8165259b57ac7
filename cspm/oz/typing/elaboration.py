"""From the tree of a script to its specification: paragraphs in order of need, then classes, then what joins them.

Mistakes are collected as long as it makes sense to go on, so that a user sees several at once; if there is one, the
script is refused. Warnings travel with the result.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.typing import messages as messages, type_messages
from cspcheck.cspm.oz.typing.classes import ClassTable
from cspcheck.cspm.oz.typing.constant_objects import with_constant_objects
from cspcheck.cspm.oz.typing.fitting import Misfit, fit
from cspcheck.cspm.oz.typing.forms import sets_of_one_range
from cspcheck.cspm.oz.typing.identities import identities
from cspcheck.cspm.oz.typing.interfaces import compare_interfaces, settled
from cspcheck.cspm.oz.typing.leaving_out import check_alternatives, kept
from cspcheck.cspm.oz.typing.lemmas import Lemmas
from cspcheck.cspm.oz.typing.paragraphs import DeclaredParagraphs
from cspcheck.cspm.oz.typing.polymorphism import with_alternatives
from cspcheck.cspm.oz.typing.scopes import AmbiguousEntry, ClassEntry, SetEntry, TypingScope, VariableEntry, toolkit
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.writing.printer import print_term
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax

MOST_MISTAKES = 20
"""After so many, no more are told."""


@dataclass(frozen=True)
class Elaborated:
    """The Object-Z part of a script, and what is odd about it."""

    specification: core.Specification
    warnings: tuple[Diagnostic, ...]
    classes: ClassTable

    def instance(self, name: str, arguments: tuple[s.Term, ...]) -> core.ClassModel:
        """A generic class with actual parameters, as the script writes them: ``Stack[DATA]``.

        Raises:
            ScriptError: there is no such class, or the arguments do not match.
        """
        with deep_recursion():
            try:
                return self.classes.instance(name, arguments)
            except Wrong as wrong:
                raise ScriptError(wrong.diagnostic) from None


def elaborate(script: syntax.Script) -> Elaborated:
    """The specification that the Object-Z part of a script is.

    Of a document of plain Object-Z that is typed, paragraphs that cannot be run are left out, with a warning each.

    Raises:
        ScriptError: with every mistake that could be told apart, up to twenty.
    """
    declarations = list(flat(script.declarations))
    with deep_recursion():
        try:
            found = _Elaboration(declarations).run()
        except ScriptError as error:
            left = kept(declarations, error, lambda rest: _Elaboration(rest).run())
            found = _Elaboration(left.declarations).run()
            return replace(found, warnings=(*left.warnings, *found.warnings))
        check_alternatives(declarations)
        return found


def flat(declarations: tuple[syntax.Declaration, ...]) -> Iterator[syntax.Declaration]:
    """The declarations of a script with those of the files that it includes, in order."""
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration):
            yield from flat(declaration.declarations)
        else:
            yield declaration


class _Elaboration:
    def __init__(self, declarations: list[syntax.Declaration]) -> None:
        self.declarations = declarations
        self.diagnostics: list[Diagnostic] = []
        self.records: dict[str, core.RecordDefinition] = {}
        self.typing = Typing(self.records)
        self.scope = TypingScope(toolkit())

    def report(self, diagnostic: Diagnostic) -> None:
        if diagnostic not in self.diagnostics:
            self.diagnostics.append(diagnostic)

    def run(self) -> Elaborated:
        self.declarations = with_constant_objects(self.declarations)
        self.declarations, alternatives = with_alternatives(self.declarations, self.report)
        paragraphs = DeclaredParagraphs(self.typing, self.scope, self.records, self.report)
        trees = [d for d in self.declarations if isinstance(d, s.Class)]
        for tree in trees:
            paragraphs.claim(tree.name, tree.span)
            self.scope.add(tree.name, ClassEntry(tree.name, tree.span, identities(tree, {t.name: t for t in trees})))
        paragraphs.script_values(self.declarations)
        paragraphs.elaborate([d for d in self.declarations if isinstance(d, s.Paragraph)])
        classes = ClassTable(trees, self.typing, self.scope, paragraphs, self.report)
        models = {name: model for name, model in classes.all().items() if name not in alternatives}
        paragraphs.givens.update(self.typing.identified)
        outside = [d for d in self.declarations if not isinstance(d, s.Paragraph)]
        compare_interfaces(models, outside, classes.unclear, self.report)
        models = settled(models)
        lemmas = Lemmas(self.typing, self.report)
        found_lemmas = lemmas.declared([d for d in self.declarations if isinstance(d, s.Lemma)], self.scope, "axiom")
        lemmas.check(self.declarations, found_lemmas, models)
        paragraphs.givens.update(lemmas.givens | classes.lemmas.givens)
        retrieves = {}
        for declaration in self.declarations:
            if isinstance(declaration, s.Retrieve):
                found = self._retrieve(declaration, models)
                if found is not None:
                    retrieves[found.name] = found
        self.scope = classes.parameters
        readings = [self._reading(d) for d in self.declarations if isinstance(d, s.Reading)]
        for paragraph in self.declarations:
            if isinstance(paragraph, s.Paragraph):
                for display, inner in sets_of_one_range(paragraph):
                    self.report(type_messages.set_of_one_range(print_term(display), print_term(inner), display.span))
        errors = self._errors()
        warnings = [d for d in self.diagnostics if d.severity is Severity.WARNING]
        if errors:
            raise ScriptError(*errors[:MOST_MISTAKES], *warnings[:MOST_MISTAKES])
        specification = core.Specification(
            givens=dict(paragraphs.givens),
            frees=dict(paragraphs.frees),
            records=dict(self.records),
            constants=tuple(paragraphs.constants),
            axioms=tuple(paragraphs.axioms),
            classes=models,
            retrieves=retrieves,
            lemmas=found_lemmas,
            readings=tuple([reading for reading in readings if reading is not None]),
            control=any(isinstance(d, s.View) and d.kind == "control" for d in self.declarations),
        )
        return Elaborated(specification, tuple(warnings), classes)

    def _errors(self) -> list[Diagnostic]:
        return [d for d in self.diagnostics if d.severity is Severity.ERROR]

    def _retrieve(self, tree: s.Retrieve, models: Mapping[str, core.ClassModel]) -> core.RetrieveRelation | None:
        sides = []
        for name in (tree.abstract, tree.concrete):
            if name.name not in models:
                self.report(messages.unknown_class(name.name, name.span, suggestions(name.name, models)))
                return None
            sides.append(models[name.name])
        scope = TypingScope(self.scope)
        choices: dict[str, list[VariableEntry]] = {}
        for model in sides:
            variables = [(v, "before") for v in (*model.primary, *model.secondary)]
            for declared, role in [*variables, *[(c, "constant") for c in model.constants]]:
                qualified = f"{model.name}.{declared.name}"
                variable: core.Term = core.Variable(
                    type=declared.type,
                    name=qualified,
                    role="before" if role == "before" else "constant",
                    span=declared.span,
                )
                entry = VariableEntry(variable, declared.span)
                scope.add(qualified, entry)
                choices.setdefault(declared.name, []).append(entry)
        for name_, entries in choices.items():
            if len(entries) == 1 or sides[0].name == sides[1].name:
                scope.add(name_, entries[0])
            else:
                scope.add(name_, AmbiguousEntry(tuple([f"{model.name}.{name_}" for model in sides])))
        predicates = []
        for predicate in tree.predicates:
            try:
                predicates.append(self.typing.predicate(predicate, scope, "retrieve"))
            except Wrong as wrong:
                self.report(wrong.diagnostic)
        return core.RetrieveRelation(
            name=tree.name,
            abstract=sides[0].name,
            concrete=sides[1].name,
            predicates=tuple(predicates),
            span=tree.span,
        )

    def _reading(self, tree: s.Reading) -> core.FiniteReading | None:
        text = print_term(tree.subject)
        try:
            subject = self._subject(tree.subject)
            assert isinstance(subject.type, core.SetType)
            element = subject.type.element
            carrier = tree.carrier
            carrier = s.bare(carrier)
            if isinstance(carrier, s.Number):
                counted = isinstance(
                    element,
                    core.GivenType
                    | core.SequenceType
                    | core.SetType
                    | core.FunctionType
                    | core.BagType
                    | core.FreeType,
                )
                if not counted or not isinstance(carrier.value, int) or carrier.value < 1:
                    raise Wrong(messages.wrong_reading(text, f"a set of values of type `{element}`", tree.carrier.span))
                return core.FiniteReading(subject=subject, text=text, values=None, bound=carrier.value, span=tree.span)
            values = self.typing.expression(tree.carrier, self.scope, "axiom")
            try:
                values = fit(values, core.SetType(element))
            except Misfit:
                raise Wrong(
                    messages.wrong_reading(text, f"a set of values of type `{element}`", tree.carrier.span)
                ) from None
            return core.FiniteReading(subject=subject, text=text, values=values, bound=None, span=tree.span)
        except Wrong as wrong:
            self.report(wrong.diagnostic)
            return None

    def _subject(self, node: s.Term) -> core.Term:
        """What is read: a set; ``T`` for the generic parameters of that name, ``Stack.T`` where T is a name too."""
        if isinstance(node, s.Selection) and isinstance(node.record, s.Reference):
            entry = self.scope.find(f"{node.record.name}.{node.field}") or self.scope.find(node.field)
            if isinstance(entry, SetEntry):
                return entry.term
        return replace(self.typing.carrier(node, self.scope), span=None)


_COUNTED = (
    core.GivenType,
    core.SequenceType,
    core.SetType,
    core.FunctionType,
    core.BagType,
    core.FreeType,
)
"""Types whose reading may be a number: of elements, or the greatest size of a collection."""
