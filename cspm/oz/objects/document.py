"""The types of a whole document of plain Object-Z."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects.classes import Classes
from cspcheck.cspm.oz.objects.paragraphs import Paragraphs
from cspcheck.cspm.oz.objects.scopes import ClassName, Deferred, Scope, Value
from cspcheck.cspm.oz.objects.terms import Terms
from cspcheck.cspm.oz.objects.types import Open
from cspcheck.cspm.syntax.tree import Declaration, Node

_ANY = Deferred(lambda: Value(Open()), None)
"""What a script of CSPm declares may be of any type here."""


def _of_the_script(declarations: Sequence[Declaration]) -> Iterator[str]:
    """The names that declarations of CSPm may declare."""
    stack: list[Any] = [d for d in declarations if not isinstance(d, s.Paragraph)]
    while stack:
        part = stack.pop()
        if isinstance(part, tuple):
            stack.extend(part)
        elif isinstance(part, Node):
            name = getattr(part, "name", None)
            if isinstance(name, str):
                yield name
            stack.extend(getattr(part, f.name) for f in fields(part) if f.name != "span")


def mistakes(declarations: Sequence[Declaration]) -> list[Diagnostic]:
    """What is wrong with the types of a document, objects being references; each mistake once."""
    found: list[Diagnostic] = []
    _checked(declarations, found)
    return found


def signatures(declarations: Sequence[Declaration], name: str) -> dict[str, list[str]]:
    """The operations of a class of a document, inherited ones among them, each with its parameters."""
    classes = _checked(declarations, [])
    shape = classes.shape(name)
    return {o: list(classes.operations.signature(shape, o)) for o in classes.operation_names(name)}


def _checked(declarations: Sequence[Declaration], found: list[Diagnostic]) -> Classes:
    """The classes of a document; *found* is given what is wrong."""
    told: set[tuple[str, str, int]] = set()

    def report(diagnostic: Diagnostic) -> None:
        key = diagnostic.code, diagnostic.message, -1 if diagnostic.span is None else diagnostic.span.start
        if key not in told:
            told.add(key)
            found.append(diagnostic)

    terms = Terms(report)
    scope = Scope(names=dict.fromkeys(_of_the_script(declarations), _ANY))
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
    return terms.classes
