"""Lists of declarations: clauses that belong together, and what may stand where."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing import messages as messages
from cspcheck.cspm.parsing.patterns import names_in
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as s

Enclosure = Literal["script", "module", "let", "Timed"]
Refuse = Callable[[Diagnostic], None]


@dataclass(slots=True)
class Clauses:
    """Clauses of one function while more may follow."""

    name: str
    clauses: list[s.Clause]


_KEYWORDS: Final[dict[type[s.Declaration], str]] = {
    s.ChannelDeclaration: "channel",
    s.DatatypeDeclaration: "datatype",
    s.NametypeDeclaration: "nametype",
    s.PrintDeclaration: "print",
    s.ModuleDeclaration: "module",
    s.InstanceDeclaration: "instance",
    s.AssertDeclaration: "assert",
}
_FORBIDDEN: Final[dict[Enclosure, tuple[type[s.Declaration], ...]]] = {
    "script": (),
    "module": (s.AssertDeclaration, s.PrintDeclaration, s.Paragraph),
    "let": (*_KEYWORDS, s.Paragraph),
    "Timed": (s.PrintDeclaration, s.Paragraph),
}
"""What may not be declared in each place, nor in a ``Timed`` section or an included file inside it."""


def group(
    declarations: Sequence[s.Declaration | Clauses], place: Enclosure, refuse: Refuse
) -> tuple[s.Declaration, ...]:
    """The declarations of one *place*, adjacent clauses of one function made one definition.

    What may not stand in such a place, a function whose clauses go over the border of a file, and annotations
    without a definition go to *refuse*.
    """
    grouped: list[s.Declaration] = []
    run: Clauses | None = None

    def finish() -> None:
        nonlocal run
        if run is not None:
            first, last = run.clauses[0], run.clauses[-1]
            grouped.append(
                s.FunctionDefinition(span=first.span.to(last.span), name=run.name, clauses=tuple(run.clauses))
            )
            run = None

    for declaration in declarations:
        if not isinstance(declaration, Clauses):
            finish()
            grouped.append(declaration)
        elif run is not None and run.name == declaration.name:
            run.clauses.extend(declaration.clauses)
        else:
            finish()
            run = declaration
    finish()
    _check_place(grouped, place, refuse)
    _check_borders(grouped, refuse)
    _check_annotations(grouped, refuse)
    return tuple(grouped)


def _check_place(declarations: Iterable[s.Declaration], place: Enclosure, refuse: Refuse) -> None:
    forbidden = _FORBIDDEN[place]
    if not forbidden:
        return
    work = [(declaration, declaration.span) for declaration in reversed(tuple(declarations))]
    while work:
        declaration, span = work.pop()
        if isinstance(declaration, forbidden):
            if isinstance(declaration, s.DatatypeDeclaration) and declaration.subtype:
                keyword = "subtype"
            elif isinstance(declaration, s.Paragraph):
                keyword = declaration.span.text.split(maxsplit=1)[0]
            else:
                keyword = _KEYWORDS[type(declaration)]
            # The keyword; for what an include brings, the include.
            if span is declaration.span:
                span = Span(span.source, span.start, span.start + len(keyword))
            refuse(messages.misplaced_declaration(span, keyword, place))
        elif isinstance(declaration, s.IncludeDeclaration):
            work.extend((inner, span) for inner in reversed(declaration.declarations))
        elif isinstance(declaration, s.TimedDeclaration):
            outer = None if span is declaration.span else span
            work.extend((inner, outer or inner.span) for inner in reversed(declaration.declarations))


def _check_borders(declarations: Sequence[s.Declaration], refuse: Refuse) -> None:
    """No function begins in one file and goes on in another."""
    for before, after in pairwise(declarations):
        if not isinstance(before, s.IncludeDeclaration) and not isinstance(after, s.IncludeDeclaration):
            continue
        first, second = _edge(before, -1), _edge(after, 0)
        if (
            isinstance(first, s.FunctionDefinition)
            and isinstance(second, s.FunctionDefinition)
            and first.name == second.name
        ):
            refuse(messages.definition_over_files(second.clauses[0].span, first.name, first.clauses[-1].span))


def _edge(declaration: s.Declaration, index: int) -> s.Declaration | None:
    while isinstance(declaration, s.IncludeDeclaration):
        if not declaration.declarations:
            return None
        declaration = declaration.declarations[index]
    return declaration


def _flat(declarations: Iterable[s.Declaration]) -> Iterator[s.Declaration]:
    """The declarations with those of includes and ``Timed`` sections, which share their scope."""
    work = list(reversed(tuple(declarations)))
    while work:
        declaration = work.pop()
        yield declaration
        if isinstance(declaration, s.IncludeDeclaration | s.TimedDeclaration):
            work.extend(reversed(declaration.declarations))


def _check_annotations(declarations: Sequence[s.Declaration], refuse: Refuse) -> None:
    annotated: dict[str, s.NameDeclaration] = {}
    scopes: dict[str, int] = {}
    for declaration in declarations:
        if not isinstance(declaration, s.AnnotationDeclaration):
            continue
        for name in declaration.names:
            if name.name in annotated:
                refuse(messages.annotated_twice(name.span, name.name, annotated[name.name].span))
            else:
                annotated[name.name] = name
                scopes[name.name] = id(declaration)
    if not annotated:
        return
    defined: set[str] = set()
    for declaration in _flat(declarations):
        match declaration:
            case s.FunctionDefinition() | s.NametypeDeclaration():
                defined.add(declaration.name)
            case s.PatternDefinition(pattern=pattern):
                defined.update(found.parts[0] for found in names_in(pattern) if len(found.parts) == 1)
            case s.DatatypeDeclaration(constructors=constructors):
                defined.update(constructor.name for constructor in constructors)
            case s.ChannelDeclaration(names=names):
                defined.update(name.name for name in names)
                both = [name for name in names if name.name in annotated]
                if len({scopes[name.name] for name in both}) > 1:
                    first, second = annotated[both[0].name], annotated[both[1].name]
                    refuse(messages.channels_annotated_apart(second.span, first.span, names[0].span))
    for text, name in annotated.items():
        if text not in defined:
            refuse(messages.annotation_without_definition(name.span, text))
