"""The lines of a source that a diagnostic is about, with the places underlined.

The layout is the one that compilers have settled on: a gutter with line numbers, carets under the place of the
mistake, dashes under the places that have a part in it, and a bracket beside a place that spans lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from cspcheck.cspm.source import Source, Span
from cspcheck.report.style import Style, columns, harmless

TAB = "    "
_MINIMUM = 20
"""Columns of source that are shown however narrow the terminal is."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A place to underline: ``^`` for the mistake itself, ``-`` for a secondary place."""

    span: Span
    text: str
    primary: bool

    @property
    def pointer(self) -> str:
        """The character that underlines it."""
        return "^" if self.primary else "-"

    @property
    def attributes(self) -> tuple[str, ...]:
        """How it is painted."""
        return ("bold", "red") if self.primary else ("bold", "blue")


@dataclass(slots=True)
class _Line:
    """A source line as shown, and where its characters stand in what is shown."""

    number: int
    text: str
    starts: list[int]
    here: list[tuple[int, int, Mark]] = field(default_factory=list)

    @classmethod
    def of(cls, source: Source, number: int) -> _Line:
        raw = harmless(source.line_text(number))
        pieces: list[str] = []
        starts: list[int] = []
        column = 0
        for character in raw:
            starts.append(column)
            pieces.append(TAB if character == "\t" else character)
            column += columns(pieces[-1])
        starts.append(column)
        return cls(number, "".join(pieces), starts)

    def column(self, character: int) -> int:
        """Where the character with this number (from 1) is shown; a place behind the line counts as its end."""
        return self.starts[min(character - 1, len(self.starts) - 1)]


def excerpt(marks: Iterable[Mark], style: Style) -> list[str]:
    """The excerpts of all sources that *marks* point into; the first mark's source comes first."""
    sources: dict[Source, list[Mark]] = {}
    for mark in marks:
        sources.setdefault(mark.span.source, []).append(mark)
    last = max((mark.span.end_line for group in sources.values() for mark in group), default=1)
    gutter = len(str(last))
    rows: list[str] = []
    for i, (source, group) in enumerate(sources.items()):
        span = group[0].span
        arrow = "-->" if i == 0 else ":::"
        place = f"{harmless(source.name)}:{span.line}:{span.column}"
        rows.append(" " * gutter + style.paint(arrow, "bold", "blue") + " " + place)
        rows.extend(_Excerpt(source, group, gutter, style).rows())
    return rows


class _Excerpt:
    """The excerpt of one source."""

    def __init__(self, source: Source, marks: list[Mark], gutter: int, style: Style) -> None:
        self.style = style
        self.gutter = gutter
        self.blocks = sorted((m for m in marks if last_line(m.span) > m.span.line), key=lambda m: m.span.start)
        numbers: set[int] = set()
        for mark in marks:
            numbers |= {mark.span.line, last_line(mark.span)}
        numbers |= {n + 1 for n in numbers if n + 2 in numbers}
        self.lines = {n: _Line.of(source, n) for n in sorted(numbers)}
        for mark in marks:
            if mark not in self.blocks:
                line = self.lines[mark.span.line]
                start = line.column(mark.span.column)
                end = max(line.column(mark.span.column + mark.span.end - mark.span.start), start + 1)
                line.here.append((start, end, mark))
        self.room = max(style.width - gutter - 3 - (2 * len(self.blocks)), _MINIMUM)

    def rows(self) -> Iterator[str]:
        yield self._row("", "")
        previous = 0
        for number, line in self.lines.items():
            if previous and number > previous + 1:
                yield self._dots(number)
            previous = number
            left = self._left_edge(line)
            flush = [block for block in self.blocks if block.span.line == number and self._is_flush(block)]
            rails = (self._rail(block, number, "/" if block in flush else " ") for block in self.blocks)
            yield self._row(str(number), "".join(rails) + self._window(line.text, left))
            for block in self.blocks:
                if block.span.line == number and block not in flush:
                    yield self._row("", self._corner(block, number, line.column(block.span.column) - left, opens=True))
            for text in self._underlines(line, left):
                yield self._row("", "".join(self._rail(block, number, "|") for block in self.blocks) + text)
            for block in self.blocks:
                if last_line(block.span) == number:
                    ends_here = block.span.end_line == number
                    end = line.column(max(block.span.end_column - 1, 1)) if ends_here else columns(line.text)
                    yield self._row("", self._corner(block, number, end - left, opens=False))

    def _row(self, number: str, text: str) -> str:
        edge = self.style.paint(f"{number:>{self.gutter}} |", "bold", "blue")
        return f"{edge} {text}".rstrip() if text else edge

    def _dots(self, following: int) -> str:
        """The row for the lines left out before line *following*."""
        rails = "".join(self._rail(block, following, " ") for block in self.blocks)
        return (self.style.paint(f"{'...':<{self.gutter + 3}}", "bold", "blue") + rails).rstrip()

    def _is_flush(self, block: Mark) -> bool:
        """Whether a block begins with the first character of its line, so that no arrow need lead there."""
        line = self.lines[block.span.line]
        return not line.text[: line.column(block.span.column)].strip()

    def _rail(self, block: Mark, number: int, first: str) -> str:
        """The two columns beside a row of line *number* that belong to a block; *first* on the block's first line."""
        inside = " "
        if number == block.span.line:
            inside = first if first != "|" or self._is_flush(block) else " "
        elif block.span.line < number <= last_line(block.span):
            inside = "|"
        return self.style.paint(inside, *block.attributes) + " " if inside.strip() else "  "

    def _corner(self, block: Mark, number: int, column: int, *, opens: bool) -> str:
        """The row that leads from a block's rail to the column of its first or last character."""
        position = self.blocks.index(block)
        outer = "".join(self._rail(other, number, "|") for other in self.blocks[:position])
        line = "_" * (2 * (len(self.blocks) - position) - 1 + max(column, 0)) + block.pointer
        if opens:
            return outer + self.style.paint(" " + line, *block.attributes)
        text = f" {harmless(block.text)}" if block.text else ""
        return outer + self.style.paint("|" + line + text, *block.attributes)

    def _left_edge(self, line: _Line) -> int:
        """The first column that is shown of a line that is too long for the terminal."""
        if columns(line.text) <= self.room or not line.here:
            return 0
        start = min(start for start, _, _ in line.here)
        return max(start - self.room // 3, 0)

    def _window(self, text: str, left: int) -> str:
        if left:
            text = "..." + _from_column(text, left + 3)
        return self.style.fit(text, self.room)

    def _underlines(self, line: _Line, left: int) -> Iterator[str]:
        """The rows below a line: one with the pointers and the last mark's text, then one for each other text."""
        if not line.here:
            return
        shown = ((self._clip(start - left), self._clip(end - left - 1) + 1, mark) for start, end, mark in line.here)
        places = sorted(shown, key=lambda place: (place[0], place[2].primary))
        cells: list[tuple[str, Mark | None]] = []
        for start, end, mark in sorted(places, key=lambda place: place[2].primary):
            cells.extend([(" ", None)] * (end - len(cells)))
            cells[start:end] = [(mark.pointer, mark)] * (end - start)
        row = self._paint_cells(cells)
        waiting = [place for place in places if place[2].text]
        if waiting and waiting[-1][1] == len(cells) and all(p[1] <= waiting[-1][0] for p in waiting[:-1]):
            _, _, mark = waiting.pop()
            row += " " + self.style.paint(harmless(mark.text), *mark.attributes)
        yield row
        while waiting:
            yield self._stems(waiting)
            start, _, mark = waiting.pop()
            above = [place for place in waiting if place[0] < start]
            stems = self._stems(above)
            width = above[-1][0] + 1 if above else 0
            yield stems + " " * (start - width) + self.style.paint(harmless(mark.text), *mark.attributes)

    def _clip(self, column: int) -> int:
        """A column of the window; what stands beside the window is pointed to at its edge."""
        return min(max(column, 0), self.room - 1)

    def _stems(self, places: list[tuple[int, int, Mark]]) -> str:
        cells: list[tuple[str, Mark | None]] = []
        for start, _, mark in places:
            cells.extend([(" ", None)] * (start + 1 - len(cells)))
            cells[start] = ("|", mark)
        return self._paint_cells(cells)

    def _paint_cells(self, cells: list[tuple[str, Mark | None]]) -> str:
        painted, run, owner = "", "", None
        for character, mark in [*cells, ("", None)]:
            if mark is not owner or not character:
                painted += self.style.paint(run, *owner.attributes) if owner else run
                run, owner = "", mark
            run += character
        return painted


def last_line(span: Span) -> int:
    """The line of the last character: a span that ends behind a line break ends on the line before."""
    if span.end > span.start and span.end_column == 1:
        return span.end_line - 1
    return span.end_line


def _from_column(text: str, column: int) -> str:
    """What of *text* stands at *column* and behind it."""
    passed = 0
    for i, character in enumerate(text):
        if passed >= column:
            return " " * (passed - column) + text[i:]
        passed += columns(character)
    return ""
