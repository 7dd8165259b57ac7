"""The types of a whole document of plain Object-Z."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects.classes import Classes
from cspcheck.cspm.oz.objects.paragraphs import Paragraphs
from cspcheck.cspm.oz.objects.scopes import ClassName, Scope
from cspcheck.cspm.oz.objects.terms import Terms
from cspcheck.cspm.syntax.tree import Declaration


def mistakes(declarations: Sequence[Declaration]) -> list[Diagnostic]:
    """What is wrong with the types of a document, objects being references; each mistake once."""
    found: list[Diagnostic] = []
    told: set[tuple[str, str, int]] = set()

    def report(diagnostic: Diagnostic) -> None:
        key = diagnostic.code, diagnostic.message, -1 if diagnostic.span is None else diagnostic.span.start
        if key not in told:
            told.add(key)
            found.append(diagnostic)

    terms = Terms(report)
    scope = Scope()
    trees = {d.name: d for d in declarations if isinstance(d, s.Class)}
    terms.classes = Classes(trees, scope, terms, report)
    paragraphs = Paragraphs(terms, scope)
    for declaration in declarations:
        if isinstance(declaration, s.Class):
            scope.names[declaration.name] = ClassName(declaration.name, declaration.span)
        elif isinstance(declaration, s.Paragraph):
            scope.names.update(paragraphs.declare(declaration))
    terms.classes.declare()
    terms.classes.declared()
    for declaration in declarations:
        if isinstance(declaration, s.Class):
            terms.classes.check(declaration.name)
        elif isinstance(declaration, s.Paragraph):
            paragraphs.check(declaration)
    terms.determined()
    return found
