"""The verdicts that a script's comments announce: ``-- expect: fail``, and what was meant to be one and is none."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any, Final, Literal, TypeAlias

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing.lexing_messages import no_expectation
from cspcheck.cspm.parsing.reading import parse_alone
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax

Expected: TypeAlias = Literal["pass", "fail", "unknown"]
VERDICTS: Final = ("pass", "fail", "unknown")
_EXPECT = re.compile(r"\bexpect:\s*(pass|fail|unknown)\b")
_ATTEMPT = re.compile(
    r"(?:^(?:--|\{-)\s*|\b)(?P<word>expect(?:s|ed|ing)?)\s*(?P<sign>[:=]?)\s*(?P<verdict>[A-Za-z]+)?", re.I
)
_MEANT: Final = {
    "fail": ("fails", "failed", "failure", "failing", "false", "error", "no"),
    "pass": ("passes", "passed", "passing", "succeeds", "success", "true", "ok", "yes", "holds"),
    "unknown": ("undecided",),
}
"""Other words for the verdicts."""


class Expectations:
    """What the files of a script announce, each read when it is asked for."""

    def __init__(self, tree: syntax.Script, source: Source) -> None:
        self._known: dict[Source, _File] = {source: _File(tree.comments)}

    def expected(self, span: Span) -> Expected | None:
        """The verdict that a comment announces for the assertion at *span*: on one of its lines, or alone above it."""
        file = self._file(span.source)
        lines = range(span.line, span.end_line + 1)
        expected = next((file.beside[line] for line in lines if line in file.beside), None)
        return expected or file.above.get(span.line - 1)

    def mistaken(self, spans: Iterable[Span]) -> Iterator[Diagnostic]:
        """Warnings for comments beside or above the assertions at *spans* that announce no verdict and were to."""
        for span in spans:
            if self.expected(span) is not None:
                continue
            for comment in self._file(span.source).others:
                alone = comment.span.end_line == span.line - 1 and _is_alone(comment)
                if alone or span.line <= comment.span.line <= span.end_line:
                    yield from _attempt(comment)

    def _file(self, source: Source) -> _File:
        if source not in self._known:
            # The tree of an included file keeps its declarations alone: its comments are read anew, if it matters.
            said = _ATTEMPT.search(source.text) is not None
            self._known[source] = _File(parse_alone(source).comments if said else ())
        return self._known[source]


class _File:
    """The comments of one file: expected verdicts by line, and all others.

    A comment that stands alone counts for its own line too: it may be inside an assertion of several lines.
    """

    def __init__(self, comments: Iterable[syntax.Comment]) -> None:
        self.beside: dict[int, Expected] = {}
        self.above: dict[int, Expected] = {}
        self.others: list[syntax.Comment] = []
        for comment in comments:
            match = _EXPECT.search(comment.text)
            if match is None:
                self.others.append(comment)
                continue
            expected: Any = match.group(1)
            self.beside[comment.span.line] = expected
            if _is_alone(comment):
                self.above[comment.span.end_line] = expected


def _is_alone(comment: syntax.Comment) -> bool:
    """Whether only blanks stand before a comment on its line."""
    return not comment.span.source.line_text(comment.span.line)[: comment.span.column - 1].strip()


def _attempt(comment: syntax.Comment) -> Iterator[Diagnostic]:
    """What to say of a comment that looks like an announcement; prose that only has the word is left alone."""
    match = _ATTEMPT.search(comment.text)
    if match is None or match["verdict"] is None:
        return
    written = match["verdict"].lower()
    meant = tuple(verdict for verdict, words in _MEANT.items() if written == verdict or written in words)
    meant = meant or suggestions(written, VERDICTS)
    begins = match.start() == 0
    if (match["sign"] and (begins or match["word"] == "expect")) or (begins and meant):
        start = comment.span.start + match.start("word")
        span = comment.span.source.span(start, comment.span.start + match.end("verdict"))
        yield no_expectation(span, meant[0] if meant else None)
