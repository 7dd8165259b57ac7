r"""Documents of plain Object-Z that are typed, and of which a part cannot be run.

A class is run as a process by flattening its objects, and not every class can be flattened: ``self``, classes that
refer to each other, objects as values of generic constants and their like would need a heap. Such a document is correct
all the same if its types are, which :mod:`cspcheck.cspm.oz.objects` finds with objects as references. Then what
cannot be flattened are left out, each with a word of why, and the rest is run.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Final

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects import messages
from cspcheck.cspm.oz.objects.document import mistakes
from cspcheck.cspm.oz.typing.paragraphs import names_of
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax

_LIMITS: Final = frozenset(["CSP625", "CSP657", "CSP659", "CSP670"])
"""What the flattening of classes says where it does not go on, whatever the paragraph speaks of."""

_FOLLOWING: Final = frozenset(
    [*(f"CSP{number}" for number in (*range(630, 638), 639)), "CSP644", "CSP646", "CSP656", "CSP658", "CSP661"]
)
"""What it says of a paragraph that speaks of objects which it cannot flatten, beside that."""

_OF_OBJECTS: Final = frozenset(["CSP630", "CSP631", "CSP635", "CSP639", "CSP658"])
_BETTER_SAID: Final = frozenset(["CSP644", "CSP646", *_LIMITS])
"""What is said better with objects as references: the first where a paragraph speaks of them, the others anywhere."""

MOST_ROUNDS: Final = 20


@dataclass(frozen=True)
class Kept:
    """A document without the paragraphs that cannot be run, and what is said of these."""

    declarations: list[syntax.Declaration]
    warnings: tuple[Diagnostic, ...]


def kept(
    declarations: Sequence[syntax.Declaration],
    error: ScriptError,
    elaborated: Callable[[list[syntax.Declaration]], object],
) -> Kept:
    """A document whose flattening failed, without what cannot be flattened.

    Args:
        error: of the flattening.
        elaborated: flattens a document, or fails.

    Raises:
        ScriptError: a type is wrong, or something else is that has to do with no limit.
    """
    if not _is_plain(declarations) or not any(d.code in _LIMITS | _FOLLOWING for d in _errors(error)):
        raise error
    found = mistakes(declarations)
    if found:
        raise ScriptError(*_together(declarations, _errors(error), found), *_others(error))
    left = list(declarations)
    reasons: dict[str, str] = {}
    told: list[Diagnostic] = []
    for _ in range(MOST_ROUNDS):
        paragraphs = [d for d in left if isinstance(d, s.Paragraph)]
        failing: dict[int, Diagnostic] = {}
        first: set[str] = set()
        for diagnostic in sorted(_errors(error), key=lambda d: d.code not in _LIMITS):
            paragraph = _paragraph_at(paragraphs, diagnostic.span)
            if paragraph is None or not _is_limit(diagnostic, paragraph, paragraphs, reasons):
                raise error
            if diagnostic.code in _LIMITS:
                first.update(_declares(paragraph))
            if diagnostic.code in _LIMITS or not (_mentioned(paragraph) - set(_declares(paragraph))) & first:
                failing.setdefault(id(paragraph), diagnostic)
        out = _with_users(paragraphs, failing, reasons, told)
        left = [d for d in left if id(d) not in out]
        try:
            elaborated(left)
            break
        except ScriptError as again:
            error = again
    else:
        raise error
    _unasked(left, reasons)
    return Kept(left, tuple(told))


def check_alternatives(declarations: Sequence[syntax.Declaration]) -> None:
    """Look whether classes go together in the polymorphic sets and unions of a document that can be run.

    Raises:
        ScriptError: some do not.
    """
    if not _is_plain(declarations) or not any(_has_alternatives(d) for d in declarations if isinstance(d, s.Paragraph)):
        return
    wrong = [d for d in mistakes(declarations) if d.code in ("CSP670", "CSP671")]
    if wrong:
        raise ScriptError(*wrong)


def _has_alternatives(node: syntax.Node) -> bool:
    return any(isinstance(part, s.Operator) and part.name in ("poly", "union", "contained") for part in _nodes(node))


def _errors(error: ScriptError) -> list[Diagnostic]:
    return [d for d in error.diagnostics if d.severity is Severity.ERROR]


def _others(error: ScriptError) -> list[Diagnostic]:
    return [d for d in error.diagnostics if d.severity is not Severity.ERROR]


def _is_plain(declarations: Sequence[syntax.Declaration]) -> bool:
    """Whether the classes of a document are those of Object-Z, without channels and equations."""
    classes = [d for d in declarations if isinstance(d, s.Class)]
    return not any(c.interface or c.equations for c in classes)


def _together(
    declarations: Sequence[syntax.Declaration], errors: list[Diagnostic], found: list[Diagnostic]
) -> list[Diagnostic]:
    """What is wrong, each mistake told once: by the flattening where it speaks of values alone."""
    paragraphs = [d for d in declarations if isinstance(d, s.Paragraph)]
    own = []
    for diagnostic in errors:
        paragraph = _paragraph_at(paragraphs, diagnostic.span)
        if any(_overlap(d.span, diagnostic.span) for d in found):
            # A class or an object that is no value of the flattening is one here.
            value = diagnostic.code == "CSP637" and diagnostic.labels
            objects = paragraph is not None and _speaks_of_objects(paragraph, paragraphs, {})
            better = diagnostic.code in _BETTER_SAID or (objects and diagnostic.code in _OF_OBJECTS)
            if not value and not better:
                own.append(diagnostic)
        elif paragraph is None or not _is_limit(diagnostic, paragraph, paragraphs, {}):
            own.append(diagnostic)
    found = [d for d in found if not any(_overlap(d.span, other.span) for other in own)]
    return [*own, *found]


def _overlap(one: Span | None, other: Span | None) -> bool:
    if one is None or other is None or one.source is not other.source:
        return False
    return one.start < other.end and other.start < one.end


def _paragraph_at(paragraphs: Sequence[s.Paragraph], span: Span | None) -> s.Paragraph | None:
    for paragraph in paragraphs:
        place = paragraph.span
        if span is None or place.source is not span.source:
            continue
        if place.start <= span.start and span.end <= place.end:
            return paragraph
    return None


def _is_limit(
    diagnostic: Diagnostic, paragraph: s.Paragraph, paragraphs: Sequence[s.Paragraph], reasons: Mapping[str, str]
) -> bool:
    """Whether a mistake is one of flattening alone, if the types of the document are right."""
    if diagnostic.code == "CSP657":
        return isinstance(paragraph, s.Class) and bool(paragraph.inherits)  # which overrides what it inherits
    if diagnostic.code in _LIMITS:
        return True
    if diagnostic.code not in _FOLLOWING:
        return False
    return _speaks_of_objects(paragraph, paragraphs, reasons)


def _speaks_of_objects(paragraph: s.Paragraph, paragraphs: Sequence[s.Paragraph], reasons: Mapping[str, str]) -> bool:
    """Whether a paragraph uses objects, generic names without parameters, or what is left out."""
    names = {"self", "oid"} | {p.name for p in paragraphs if isinstance(p, s.Class)} | set(reasons)
    generic = {n for p in paragraphs if isinstance(p, s.Abbreviation | s.Axiom) and p.generics for n, _ in names_of(p)}
    used = {name for name, part in _uses(paragraph) if not isinstance(part, s.Inherit)}
    return bool(used & (names | generic) or _mentioned(paragraph) & set(reasons))


def _mentioned(node: syntax.Node) -> set[str]:
    """The names that a paragraph uses."""
    return {name for name, _ in _uses(node)}


def _uses(node: object) -> Iterator[tuple[str, syntax.Node]]:
    """The names that a tree uses, each with where."""
    for part in _nodes(node):
        match part:
            case s.Reference(name=name) | s.Inherit(name=name):
                yield name, part
            case syntax.Name(parts=parts):
                yield parts[0], part
            case s.Retrieve():
                yield part.abstract.name, part
                yield part.concrete.name, part
            case s.Obligations(subject=subject):
                yield subject.name, subject
            case s.DataRefinement(abstract=one, concrete=other) | s.Subtype(parent=one, child=other):
                yield one.name, one
                yield other.name, other


def _nodes(node: object) -> Iterator[syntax.Node]:
    """All nodes of a tree."""
    stack: list[Any] = [node]
    while stack:
        part = stack.pop()
        if isinstance(part, tuple):
            stack.extend(part)
        elif isinstance(part, syntax.Node) and is_dataclass(part):
            yield part
            stack.extend(getattr(part, f.name) for f in fields(part) if f.name != "span")


def _declares(paragraph: s.Paragraph) -> list[str]:
    match paragraph:
        case s.Class(name=name) | s.Lemma(name=name) | s.Retrieve(name=name):
            return [name]
    return [name for name, _ in names_of(paragraph)]


def _with_users(
    paragraphs: Sequence[s.Paragraph],
    failing: Mapping[int, Diagnostic],
    reasons: dict[str, str],
    told: list[Diagnostic],
) -> set[int]:
    """The paragraphs that cannot be run, and those that use them; *reasons* and *told* grow."""
    out: set[int] = set()

    def leave_out(paragraph: s.Paragraph, reason: str, place: Span | None) -> None:
        out.add(id(paragraph))
        names = _declares(paragraph)
        reasons.update(dict.fromkeys(names, reason))
        told.append(messages.not_run(names[0] if names else "a predicate", reason, place or paragraph.span))

    for paragraph in paragraphs:
        if id(paragraph) in failing:
            diagnostic = failing[id(paragraph)]
            leave_out(paragraph, _reason(diagnostic, paragraph, paragraphs), diagnostic.span)
    while True:
        more = [
            (paragraph, sorted(used))
            for paragraph in paragraphs
            if id(paragraph) not in out and (used := _mentioned(paragraph) & set(reasons))
        ]
        if not more:
            return out
        for paragraph, uses in more:
            place = next(part.span for name, part in _uses(paragraph) if name == uses[0])
            leave_out(paragraph, f"it uses `{uses[0]}`", place)


def _reason(diagnostic: Diagnostic, paragraph: s.Paragraph, paragraphs: Sequence[s.Paragraph]) -> str:
    """Why a paragraph cannot be flattened, in words of the document."""
    if diagnostic.code in _LIMITS:
        return _in_words(diagnostic.message, [p.name for p in paragraphs if isinstance(p, s.Class)])
    used = _mentioned(paragraph)
    for name in ("self", "oid"):
        if name in used:
            return f"`{name}` would need a heap"
    for other in paragraphs:
        if isinstance(other, s.Class) and other.generics and other.name in used:
            return f"objects of the generic class `{other.name}` as values would need a heap"
        if isinstance(other, s.Abbreviation) and other.generics and other.name in used:
            return f"objects of what `{other.name}` stands for would need a heap"
    if any(isinstance(part, s.Renamed) for part in _nodes(paragraph)):
        return "objects under other names of their features would need a heap"
    return "what it says of the classes of its objects would need a heap"


def _in_words(message: str, classes: Sequence[str]) -> str:
    """A message with the writing of the document for classes that the flattening has made."""
    one = "|".join(map(re.escape, sorted(classes, key=len, reverse=True)))
    if not one:
        return message
    message = re.sub(rf"`poly_({one})`", r"`poly \1`", message)
    message = re.sub(rf"`({one})_renamed_\d+`", r"`\1` under other names", message)
    return re.sub(rf"`(?:{one})(?:_or_(?:{one}))+`", lambda m: m[0].replace("_or_", " union "), message)


def _unasked(declarations: Sequence[syntax.Declaration], reasons: Mapping[str, str]) -> None:
    """Refuse claims and processes that need what is left out."""
    wrong = []
    for declaration in declarations:
        if isinstance(declaration, s.Paragraph):
            continue
        for name, place in _uses(declaration):
            if name in reasons:
                wrong.append(messages.asked_of_not_run(name, reasons[name], place.span))
    if wrong:
        raise ScriptError(*wrong)
