"""Tidying a script: printed anew with its comments, blank lines and deliberate line breaks.

The tree is laid out without comments, which gives the same tokens as the source; then each comment goes back
between the two tokens that it stood between, at the end of a line, on lines of its own or inside a line as it was.
What the author broke over lines stays broken where that carries meaning (rows of process operators, conditionals,
declarations of a ``let``, constructors of a datatype); all other lines are filled anew. Formatting a formatted
script changes nothing.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from cspcheck.cspm.diagnostics import ScriptError, Severity
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing.lexer import Tokens, tokenise
from cspcheck.cspm.parsing.reading import is_markup, parse_alone
from cspcheck.cspm.printing.declarations import Printer
from cspcheck.cspm.printing.layout import WIDTH, lay_out
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s

STEP: Final = 4
"""Columns by which a line is indented that only a comment made necessary."""

_CLOSERS: Final = frozenset(["exports", "endmodule", "}", "|}", ")", "|)", "]", "]]", "|]", "SEQUENCE_CLOSE", "within"])
"""Before these a comment belongs to what is closed, and is indented like it."""

_OPENERS: Final = frozenset(["(", "{", "SEQUENCE_OPEN"])


def format_source(source: Source, *, width: int = WIDTH) -> str:
    """The script in tidy form, with all its comments; ends with a line break unless it is empty.

    The tree of the result is that of *source*. Included files are not read.

    Raises:
        ScriptError: the script does not parse, or is a LaTeX document.
    """
    if is_markup(source):
        from cspcheck.cspm.parsing.class_messages import document_to_format

        raise ScriptError(document_to_format(source.name))
    script = parse_alone(source)
    # A line that shows nothing for a mistake in it stops no check, but what it was to say is not known.
    if wrong := [remark for remark in script.remarks if remark.code == "CSP017"]:
        raise ScriptError(*[replace(remark, severity=Severity.ERROR) for remark in wrong])
    tokens = _tokens(source, script)[0]
    hints = _Hints(source, tokens)
    laid_out = lay_out(Printer(hints.broken).document(script), width)
    text = _weave(tokens, laid_out)
    # Whatever happens, a formatter must not change what a script says.
    again = parse_alone(Source(source.name, text))
    if print_script(again) != print_script(script) or len(again.comments) != len(script.comments):
        raise AssertionError("formatting would change the script")
    return text


def _tokens(source: Source, script: s.Script | None = None) -> tuple[Tokens, frozenset[int]]:
    """The tokens of a script, those inside Object-Z paragraphs included, and where the latter start."""
    tokens = tokenise(source)
    if "PARAGRAPH" not in tokens.kinds:
        return tokens, frozenset()
    return extension().expanded(tokens, parse_alone(source) if script is None else script)


class _Hints:
    """What the lines of the source say about the layout."""

    def __init__(self, source: Source, tokens: Tokens) -> None:
        self._text = source.text
        self._starts, self._ends = tokens.starts, tokens.ends
        self._comments = tokens.comments

    def broken(self, first: s.Node, second: s.Node, *, by_comment: bool = False) -> bool:
        """Whether a line ends between two nodes.

        With *by_comment*, whether a comment directly before the second needs lines of its own, or ends its line.
        """
        start, end = first.span.end, second.span.start
        if not by_comment:
            return "\n" in self._text[start:end]
        start = self._ends[bisect_left(self._starts, end) - 1]
        place = bisect_left(self._comments, (start, 0))
        while place < len(self._comments) and self._comments[place][0] < end:
            if self._ends_line(*self._comments[place]):
                return True
            place += 1
        return False

    def _ends_line(self, start: int, end: int) -> bool:
        text = self._text
        if text.startswith("--", start):
            return True
        before = text[text.rfind("\n", 0, start) + 1 : start]
        behind = text.find("\n", end)
        return not before.strip() and not text[end : behind if behind >= 0 else len(text)].strip()


@dataclass(frozen=True, slots=True)
class _Comment:
    """A comment with its surroundings.

    ``place`` is "behind" another thing on its line, "before" the next token on its line, "within" a line if both
    hold, or "alone". ``apart`` tells whether a blank line stands before it, ``column`` where it stands on its line.
    """

    text: str
    place: Literal["behind", "before", "within", "alone"]
    apart: bool
    column: int

    @property
    def to_line_end(self) -> bool:
        return self.text.startswith("--")


def _weave(tokens: Tokens, laid_out: str) -> str:
    """The text *laid_out* with the comments and the blank lines between declarations of the source."""
    made, spelt = _tokens(Source("<formatted>", laid_out))
    source_tokens, made_tokens = _Row(tokens), _Row(made)
    gaps = _aligned(source_tokens, made_tokens)
    out = _Text()
    end = 0
    for place in range(len(made_tokens.kinds)):
        start = made_tokens.starts[place]
        blank = laid_out[end:start]
        taken = gaps.get(place, [])
        comments = [c for gap in taken for c in source_tokens.comments(gap)]
        # `print` is the word before a blank, and a name elsewhere: a comment behind it goes in front of it.
        if laid_out[start : made_tokens.ends[place]] == "print":
            comments += [c for gap in gaps.get(place + 1, []) for c in source_tokens.comments(gap)]
        elif place and laid_out[made_tokens.starts[place - 1] : end] == "print":
            comments = []
        apart = any(source_tokens.ends_apart(gap) for gap in taken)
        for part, comment in _gap(blank, comments, apart, made_tokens, place):
            out.add(part, comment)
        end = made_tokens.ends[place]
        # Object-Z has several spellings for most of its signs; each stays as it is.
        out.add(source_tokens.words(taken[-1]) if start in spelt else laid_out[start:end])
    return out.finished()


class _Text:
    """A text that is written piece by piece, with comments at the ends of lines."""

    def __init__(self) -> None:
        self._lines: list[list[str]] = [[]]
        self._endings: dict[int, tuple[int, str]] = {}  # the comment that ends a line, with its column in the source

    def add(self, part: str, comment: _Comment | None = None) -> None:
        """Write a piece of text; *comment* is what it is if it goes to the end of its line, behind something."""
        if comment is not None:
            self._endings[len(self._lines) - 1] = (comment.column, part)
            return
        first, *others = part.split("\n")
        self._lines[-1].append(first)
        self._lines.extend([other] for other in others)

    def finished(self) -> str:
        """The text. Comments at the ends of neighbouring lines that the source has in one column get one column."""
        lines = ["".join(line).rstrip() for line in self._lines]
        number = 0
        while number < len(lines):
            run = number
            while run in self._endings and self._endings[run][0] == self._endings[number][0]:
                run += 1
            column = max((len(lines[n]) for n in range(number, run)), default=0)
            for n in range(number, run):
                lines[n] = f"{lines[n]:{column}}  {self._endings[n][1]}"
            number = max(run, number + 1)
        text = "\n".join(lines).rstrip()
        return text + "\n" if text else ""


def _gap(
    blank: str, comments: Sequence[_Comment], apart: bool, made: _Row, place: int
) -> Iterator[tuple[str, _Comment | None]]:
    """The pieces that stand between two tokens, where the layout has *blank*; comments that end lines are marked."""
    first = place == 0
    last = made.kinds[place] == "$END"
    separates = made.separated[place]
    if not comments:
        yield "\n" + blank if apart and separates and not first else blank, None
        return
    broken = "\n" in blank or last
    indent = blank.rsplit("\n", 1)[-1] if "\n" in blank else "" if first or last else " " * (made.indent(place) + STEP)
    inner = indent + "  " if made.kinds[place] in _CLOSERS and broken and not last else indent
    at_start = first  # nothing stands on the line yet, and nothing above it
    line_over = False  # a line break must come before anything else
    with_next = first  # the line is that of the next token, and holds nothing but comments
    for comment in comments:
        ending = None
        moves = comment.place in ("before", "within") and broken and not with_next
        if comment.place == "alone" or line_over or moves:
            with_next = comment.place in ("before", "within")
            if not at_start:
                yield "\n\n" if comment.apart and separates else "\n", None
            yield inner if comment.place == "alone" or not broken else indent, None
        elif not at_start:
            if comment.to_line_end:
                ending = comment
            elif blank or made.kinds[place - 1] not in _OPENERS:
                yield " ", None
        yield comment.text, ending
        at_start = False
        line_over = comment.to_line_end or comment.place == "alone" or (comment.place == "behind" and broken)
    if last:
        return
    if line_over:
        yield ("\n\n" if apart and separates else "\n") + indent, None
    elif blank or made.kinds[place] not in _CLOSERS:
        yield " ", None


class _Row:
    """The tokens of a text without its line breaks, and what stands between them."""

    def __init__(self, tokens: Tokens) -> None:
        self.text = tokens.source.text
        self.kinds: list[str] = []
        self.starts: list[int] = []
        self.ends: list[int] = []
        self.separated: list[bool] = []  # whether a line break that matters stands before the token
        separated = False
        for kind, start, end in zip(tokens.kinds, tokens.starts, tokens.ends, strict=True):
            if kind == "_NEWLINE":
                separated = True
                continue
            self.kinds.append(kind)
            self.starts.append(start if kind != "$END" else len(self.text))
            self.ends.append(end if kind != "$END" else len(self.text))
            self.separated.append(separated or kind == "$END" or len(self.kinds) == 1)
            separated = False
        self._comments: dict[int, list[tuple[int, int]]] = {}
        for start, end in tokens.comments:
            self._comments.setdefault(bisect_left(self.starts, start), []).append((start, end))

    def words(self, place: int) -> str:
        """The characters of a token."""
        return self.text[self.starts[place] : self.ends[place]]

    def indent(self, place: int) -> int:
        """The indentation of the line of the token before *place*."""
        start = self.starts[place - 1]
        line = self.text[self.text.rfind("\n", 0, start) + 1 : start]
        return len(line) - len(line.lstrip(" "))

    def comments(self, gap: int) -> list[_Comment]:
        """The comments before the token at *gap*."""
        found: list[_Comment] = []
        before = self.ends[gap - 1] if gap else 0
        spans = self._comments.get(gap, [])
        for number, (start, end) in enumerate(spans):
            text = self.text[start:end]
            after = spans[number + 1][0] if number + 1 < len(spans) else self.starts[gap]
            lines_before = self.text.count("\n", before, start)
            behind = lines_before == 0 and (before > 0 or bool(found))
            ahead = "\n" not in self.text[end:after] and after < len(self.text)
            place: Literal["behind", "before", "within", "alone"]
            place = ("within" if ahead else "behind") if behind else ("before" if ahead else "alone")
            column = start - self.text.rfind("\n", 0, start)
            found.append(_Comment(text.rstrip(), place, lines_before > 1, column))
            before = end
        return found

    def ends_apart(self, gap: int) -> bool:
        """Whether a blank line stands directly before the token at *gap*."""
        spans = self._comments.get(gap, [])
        before = spans[-1][1] if spans else self.ends[gap - 1] if gap else 0
        return self.text.count("\n", before, self.starts[gap]) > 1


def _aligned(source: _Row, made: _Row) -> dict[int, list[int]]:
    """For each token that was made, the tokens of the source before which what stands goes before it.

    The two rows of tokens are the same but for brackets in types, of which superfluous ones are not kept.
    """
    gaps: dict[int, list[int]] = {}
    pending: list[int] = []
    place = 0
    for gap, kind in enumerate(source.kinds):
        pending.append(gap)
        if kind == made.kinds[place]:
            gaps[place] = pending
            pending = []
            place += 1
    return gaps
