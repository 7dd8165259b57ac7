"""Reading paragraphs: from the tokens of text or markup to a tree, by the grammar ``grammar/oz.lark``.

The steps are :mod:`cspcheck.cspm.oz.reading.layout` (terminals), the parse table that Lark makes of the grammar with
the machine that runs it (:mod:`cspcheck.cspm.parsing.driver`), and the builder of nodes. After a mistake its line or
section is passed over and the rest is read again, so that several can be reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages, mistakes
from cspcheck.cspm.oz.reading.builder import RefusedToken
from cspcheck.cspm.oz.reading.builder_paragraphs import ParagraphBuilder
from cspcheck.cspm.oz.reading.lexer import Scan, Token, tokens
from cspcheck.cspm.oz.reading.outline import ParagraphLayout
from cspcheck.cspm.parsing import lexing_messages as lexing
from cspcheck.cspm.parsing.driver import Unexpected, run
from cspcheck.cspm.parsing.lexer import Tokens, tokenise
from cspcheck.cspm.parsing.table import Grammar, Table, table as stored
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as s

OZ: Final = Grammar(Path(__file__).with_name("grammar") / "oz.lark", ("paragraph",), frozenset(["condition", "result"]))
"""Where a ``|``, ``@`` or ``;`` could go on with a ``mu`` or with what is around it, it goes on with the ``mu``."""

MOST_MISTAKES: Final = 20
"""Mistakes of one paragraph that are reported, at most."""

_STANDS_FOR: Final = (
    ("DECLARED", "NAME"),
    ("NAME", "DECLARED"),
    ("WORD", "DECLARED"),
    ("PREFIX", "DECLARED"),
    ("(|", "_BINDING"),
)
"""Terminals that count as another where they cannot stand as what they look like."""


@cache
def table() -> Table:
    """The table of the grammar; what looks like a declaration is an ordinary name where none can stand, and so on."""
    made = stored(OZ)
    actions = []
    for row in made.actions:
        added = {kind: row[other] for kind, other in _STANDS_FOR if kind not in row and other in row}
        actions.append({**row, **added} if added else row)
    return replace(made, actions=actions)


def parse_paragraph(source: Source, start: int, end: int) -> tuple[z.Paragraph, list[Diagnostic]]:
    """The paragraph that fills the range of *source*, with what is wrong in it.

    If there are mistakes, the tree holds what could be read.
    """
    scan = Scan()
    found = list(tokens(source, start, end, scan))
    if scan.unclosed_comment is not None:
        rest = source.text[scan.unclosed_comment.end :]
        return nothing(source, start, end), [lexing.unclosed_comment(scan.unclosed_comment, rest)]
    paragraph, errors = Reader(source, found).read()
    return paragraph or nothing(source, start, end), errors


def nothing(source: Source, start: int, end: int) -> z.Paragraph:
    """What stands for a paragraph that could not be read."""
    return z.GivenTypes(span=source.span(start, end), names=())


class Reader:
    """Reads one paragraph."""

    def __init__(self, source: Source, found: Sequence[Token]) -> None:
        self.source = source
        self.found = list(found)
        self.equations: dict[tuple[int, int], tuple[tuple[s.Declaration, ...], list[Diagnostic]]] = {}
        """What has been read of CSPm, by its place."""

    def read(self) -> tuple[z.Paragraph | None, list[Diagnostic]]:
        """The paragraph, None if nothing could be read, and what is wrong in it."""
        wrong: list[tuple[float, Diagnostic]] = []
        found = self.found
        while True:
            layout = ParagraphLayout(self.source, found, self.column)
            laid = layout.run()
            builder = ParagraphBuilder(laid, self.read_equations)
            paragraph: Any = None
            try:
                paragraph = run(table(), "paragraph", laid, builder)
            except (Unexpected, RefusedToken) as error:
                finding = mistakes.diagnose(table(), layout, error.index)
                if found[finding.shows].kind in ("UNREAD", "UNREAD_SECTION"):
                    return paragraph, mistakes.order(wrong)  # it is said already what is wrong there
                behind = finding.resume is None and finding.start > 0
                wrong.append((found[finding.shows].start + behind / 2, finding.diagnostic))
                if (behind or finding.resume is not None) and len(wrong) < MOST_MISTAKES:
                    passed = range(finding.start, finding.resume or finding.start)
                    wrong += [(laid.starts[i], e) for i, e in builder.errors if laid.origins[i] in passed]
                    found = _passed_over(found, finding)
                    continue
            wrong += [(laid.starts[index], error) for index, error in builder.errors]
            return paragraph, mistakes.order(wrong)[:MOST_MISTAKES]

    def column(self, token: Token) -> int:
        """How far a token is indented, or the line that it stands in."""
        line_start = self.source.text.rfind("\n", 0, token.start) + 1
        before = self.source.text[line_start : token.start]
        return len(before) - len(before.lstrip()) if before.strip() else len(before)

    # --- equations -------------------------------------------------------------------------------------------

    def read_equations(self, span: Span) -> tuple[tuple[s.Declaration, ...], list[Diagnostic]]:
        """The equations of CSPm in a part of the source, and what is wrong in them."""
        key = span.start, span.end
        if key not in self.equations:
            self.equations[key] = self._read_equations(span)
        return self.equations[key]

    def _read_equations(self, span: Span) -> tuple[tuple[s.Declaration, ...], list[Diagnostic]]:
        from cspcheck.cspm.parsing import mistakes as parser_mistakes
        from cspcheck.cspm.parsing.builder import TreeBuilder
        from cspcheck.cspm.parsing.lexer import DECLARATION_KEYWORDS

        found = self.equation_tokens(span)
        if found.errors:
            return (), list(found.errors)
        tree = TreeBuilder(found, lambda path, place: ())
        try:
            script: Any = run(stored(), "script", found, tree)
        except Unexpected as error:
            finding = parser_mistakes.diagnose(stored(), "script", found, error.index)
            return (), [*tree.errors, finding.diagnostic]
        tree.finish()
        errors = list(tree.errors)
        equations: list[s.Declaration] = []
        for declaration in script.declarations:
            if isinstance(declaration, s.PatternDefinition | s.FunctionDefinition | s.AnnotationDeclaration):
                equations.append(declaration)
            else:
                start = declaration.span.start
                word = next((w for w in DECLARATION_KEYWORDS if self.source.text.startswith(w, start)), "this")
                errors.append(messages.not_in_class(self.source.span(start, start + len(word)), word))
        return tuple(equations), errors

    def equation_tokens(self, span: Span) -> Tokens:
        """The tokens of CSPm in a part of the source."""
        return tokenise(self.source, start=span.start, end=span.end, form="equations")


def _passed_over(found: Sequence[Token], finding: mistakes.ReadingMistake) -> list[Token]:
    """The tokens with one in place of what is passed over."""
    start, resume = finding.start, finding.resume
    if resume is None:
        return [*found[:start], found[-1]]
    first, last = found[start], found[max(resume - 1, start)]
    kind = "UNREAD" if finding.line else "UNREAD_SECTION"
    begins = finding.line or first.first
    unread = Token(kind, first.start, max(first.start, last.end), first=begins, section=not finding.line)
    return [*found[:start], unread, *found[max(resume, start) :]]
