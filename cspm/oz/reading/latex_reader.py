r"""Reading LaTeX documents with classes: their environments become the paragraphs of a script.

Text around the environments is ignored. An environment ``cspm`` (set like ``verbatim``) holds declarations of CSPm,
so that a document can compose its classes and make assertions.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.latex_commands import CSP_COMMANDS, NAMES
from cspcheck.cspm.oz.reading.latex_environments import BOXES, is_claim
from cspcheck.cspm.oz.reading.latex_lexer import Lexer, Markup
from cspcheck.cspm.oz.reading.lexer import NAMING, OPERAND_ENDS, Token
from cspcheck.cspm.oz.reading.reader import Reader
from cspcheck.cspm.parsing.lexer import Tokens, tokenise
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as s

if TYPE_CHECKING:
    from cspcheck.cspm.parsing.builder import Include

_TOP: Final = frozenset([*BOXES, "syntax", "zed", "type", "zpar", "cspm"]) - {
    "state",
    "anonschema",
    "init",
    "op",
    "opschema",
}
"""Environments that are read where they stand outside others."""

_BEGIN = re.compile(r"\\begin\{verbatim\}[\s\S]*?\\end\{verbatim\}|(?<!\\)%[^\n]*|\\begin[ \t]*\{([A-Za-z]+)\}")


class LatexDocument:
    """The declarations of a document, with its comments, and what is wrong or odd about it."""

    def __init__(self, source: Source, include: Include) -> None:
        self.source = source
        self.include = include
        self.declarations: list[s.Declaration] = []
        self.comments: list[tuple[int, int]] = []
        self.errors: list[Diagnostic] = []
        self.remarks: list[Diagnostic] = []
        self.found = False
        self._relations: set[str] = set()
        with deep_recursion():
            self._read()

    def script(self) -> s.Script:
        """The document as a script."""
        text = self.source.text
        return s.Script(
            span=self.source.span(0, len(text)),
            declarations=tuple(self.declarations),
            comments=tuple(
                s.Comment(span=self.source.span(start, end), text=text[start:end]) for start, end in self.comments
            ),
            remarks=tuple(self.remarks),
        )

    def _read(self) -> None:
        text = self.source.text
        position = max(text.find("\\begin{document}"), 0)
        while (match := _BEGIN.search(text, position)) is not None:
            name = match[1]
            position = match.end()
            if name not in _TOP or (name == "theorem" and not is_claim(text, position)):
                continue
            self.found = True
            end = _environment_end(text, name, match.start())
            if name == "cspm":
                self._csp(match.end(), text.rfind("\\end", match.end(), end))
            else:
                self._environment(match.start(), end)
            position = max(end, position)
        if not self.found:
            self.remarks.append(messages.nothing_to_read(self.source.span(0, 0)))
        self.remarks = _once_each(self.remarks)

    def _csp(self, start: int, end: int) -> None:
        """Declarations of CSPm, as in a script."""
        from cspcheck.cspm.parsing import mistakes as parser_mistakes
        from cspcheck.cspm.parsing.builder import TreeBuilder
        from cspcheck.cspm.parsing.driver import Unexpected, run
        from cspcheck.cspm.parsing.table import table

        tokens = tokenise(self.source, start=start, end=end if end >= 0 else len(self.source.text), classes=True)
        self.comments += tokens.comments
        if tokens.errors:
            self.errors += tokens.errors
            return
        tree = TreeBuilder(tokens, self.include)
        try:
            script: Any = run(table(), "script", tokens, tree)
        except Unexpected as error:
            self.errors += [*tree.errors, parser_mistakes.diagnose(table(), "script", tokens, error.index).diagnostic]
            return
        tree.finish()
        self.errors += tree.errors
        self.declarations += script.declarations

    def _environment(self, start: int, end: int) -> None:
        markup = Lexer(self.source, start, end, self._relations).run()
        self.comments += markup.comments
        self.errors += markup.errors
        self.remarks += markup.remarks
        for tokens in _paragraphs(markup):
            reader = MarkupReader(self.source, tokens)
            paragraph, errors = reader.read()
            if paragraph is not None:
                self.declarations.append(paragraph)
            self.errors += errors
            self.remarks = [r for r in self.remarks if not reader.is_equation(r)]


def _environment_end(text: str, name: str, start: int) -> int:
    """The offset behind the ``\\end`` of the environment that begins at *start*; the end of the text if it has none."""
    depth = 0
    for match in re.compile(rf"\\(begin|end)[ \t]*\{{{name}\}}").finditer(text, start):
        depth += 1 if match[1] == "begin" else -1
        if depth == 0:
            return match.end()
    return len(text)


def _once_each(remarks: Sequence[Diagnostic]) -> list[Diagnostic]:
    """The remarks without those that say the same again."""
    told: dict[tuple[str, str], Diagnostic] = {}
    for remark in remarks:
        told.setdefault((remark.code, remark.message), remark)
    return list(told.values())


# --- lines of classes and zed environments -----------------------------------------------------------------------

_INTERFACES: Final = frozenset(["chan", "method", "local_chan", "inherit", "visible"])
_KEYWORDS: Final = frozenset(["reading", "view", "retrieve"])
_OPERATION_NAME = re.compile(r"(?:com|enable|effect)_")


def _word(token: Token, word: str) -> Token:
    """A word of the notation before a token."""
    return Token("NAME", token.start, token.start, first=True, section=True, value=word)


def _paragraphs(markup: Markup) -> list[list[Token]]:
    """The tokens of each paragraph, with the words that the text notation has and the markup has not."""
    tokens, boxes = markup.tokens, markup.boxes
    classes = tokens[0].kind == "NAME" and tokens[0].value == "class" and tokens[0].section
    operations = _operations(tokens, boxes) if classes else frozenset()
    result: list[list[Token]] = [[]]
    place = 0
    while place < len(tokens):
        token = tokens[place]
        at_top = boxes[place] in ("class", "zed")
        new = [token]
        consumed = 1
        if classes and token.section and token.value in ("schema", "op") and _is_initial(tokens, place):
            token.value, consumed = "init", 2
        elif token.section and token.kind == "NAME" and token.value == "schema" and place in operations:
            token.value = "op"
        elif token.first and at_top and not token.section and not _goes_on(result[-1], token):
            new, consumed = _line(tokens, place, _line_end(tokens, boxes, place), in_class=classes)
        section = (token.section or new[0].section) and token.kind not in ("where", "end")
        begins = not classes and result[-1] and section and token.value not in ("using", "by")
        if begins and token.kind != "$END" and _is_complete(result[-1]):
            result.append([])
        result[-1] += new
        place += consumed
    last = tokens[-1]
    return [[*found, last] if found[-1].kind != "$END" else found for found in result if found[0].kind != "$END"]


def _is_initial(tokens: Sequence[Token], place: int) -> bool:
    """Whether a box that is named INIT begins here."""
    return tokens[place].kind == "NAME" and tokens[place + 1].value in ("INIT", "Init")


def _is_complete(tokens: Sequence[Token]) -> bool:
    """Whether a paragraph outside a class may end before a new section: a box only behind its ``end``."""
    words = [str(t.value) for t in tokens if t.section and t.kind == "NAME"]
    return not words or words[0] not in BOXES.values() or words[0] == "lemma" or tokens[-1].kind == "end"


def _line_end(tokens: Sequence[Token], boxes: Sequence[str], place: int) -> int:
    """The token at which the line of the one at *place* ends."""
    end = place + 1
    while end < len(tokens) and not tokens[end].first and boxes[end] == boxes[place] and not tokens[end].section:
        end += 1
    return end


def _goes_on(before: Sequence[Token], token: Token) -> bool:
    """Whether a line continues the one before it: an equation of CSP over several lines, a free type."""
    if not before:
        return False
    last = before[-1]
    if last.kind in ("end", "where") or last.section:
        return False
    complete = last.kind in OPERAND_ENDS or last.kind in NAMING or last.kind in (">>", "LITERAL")
    return not complete or token.kind in ("|", "BAD", ")", "]", "}", "->", "|->", "|>", "[]", "||", ";")


def _line(tokens: Sequence[Token], place: int, end: int, *, in_class: bool) -> tuple[list[Token], int]:
    """A line of a class or a ``zed`` environment in the form of the text notation, and how many tokens it was."""
    token = tokens[place]
    line = tokens[place:end]
    following = line[1] if len(line) > 1 else None
    if token.kind == "[":
        return _bracketed_line(tokens, place, end)
    if token.kind != "NAME":
        return [token], 1
    word = str(token.value)
    if word in (_INTERFACES if in_class else _KEYWORDS):
        token.section = True
        return [token], 1
    if following is None:
        return ([_word(token, "inherit"), _plain(token)], 1) if in_class else ([token], 1)
    if word == "main" and following.kind in ("=", "SDEF"):
        token.section = True
        return [token], 1
    kinds = [t.kind for t in line]
    definition = next((i for i, kind in enumerate(kinds) if kind in ("==", "::=", "SDEF", "=")), -1)
    if definition >= 0 and kinds[definition] in ("==", "::="):
        token.section = True
        return [token], 1
    if definition >= 0 and kinds[definition] == "SDEF":
        return _definition(tokens, place, end, place + definition, in_class=in_class)
    if in_class and definition < 0 and following.kind == "[":
        return [_word(token, "inherit"), _plain(token)], 1
    return [token], 1


def _plain(token: Token) -> Token:
    token.first = False
    return token


def _bracketed_line(tokens: Sequence[Token], place: int, end: int) -> tuple[list[Token], int]:
    """``[A, B]``: given types; ``[ x : T | p ]``: the state."""
    close = _matching(tokens, place)
    inner = list(tokens[place + 1 : close])
    consumed = close + 1 - place
    if any(t.kind == ":" for t in inner):
        return [_word(tokens[place], "state"), *_box(inner), _ended(tokens[place])], consumed
    for token in inner:
        token.first = False
    return [_word(tokens[place], "given"), *inner], consumed


def _matching(tokens: Sequence[Token], place: int) -> int:
    depth = 0
    for position in range(place, len(tokens)):
        depth += (tokens[position].kind == "[") - (tokens[position].kind == "]")
        if depth == 0:
            return position
    return len(tokens) - 1


def _box(inner: Sequence[Token]) -> list[Token]:
    """``x : T; y : U | p`` in brackets as the lines of a box."""
    depth = 0
    for token in inner:
        depth += (token.kind in ("{", "(", "[")) - (token.kind in ("}", ")", "]"))
        if token.kind == "|" and depth == 0:
            token.kind, token.section, token.first = "where", True, True
            break
    return list(inner)


def _ended(token: Token) -> Token:
    return Token("end", token.start, token.start, first=True, section=True, value="end")


def _definition(tokens: Sequence[Token], place: int, end: int, sign: int, *, in_class: bool) -> tuple[list[Token], int]:
    """``N \\sdef ...``: an operation, INIT, a schema, or an equation."""
    token, head = tokens[place], list(tokens[place:sign])
    boxed = sign + 1 < len(tokens) and tokens[sign + 1].kind == "["
    if not in_class and not (boxed and len(head) == 1 and _matching(tokens, sign + 1) + 1 >= end):
        tokens[sign].kind, token.section = "==", True
        return [token], 1
    if boxed and (token.value in ("INIT", "Init") or not in_class):
        close = _matching(tokens, sign + 1)
        inner = list(tokens[sign + 2 : close])
        if in_class:
            return [_word(token, "init"), *inner, _ended(token)], close + 1 - place
        return [_word(token, "schema"), _plain(token), *_box(inner), _ended(token)], close + 1 - place
    text_of_line = tokens[sign + 1 : _equation_end(tokens, sign + 1)]
    if len(head) > 1 or not in_class or (not boxed and any(_is_csp(t) for t in text_of_line)):
        return [token], 1
    tokens[sign].kind = "="
    return [_word(token, "op"), _plain(token)], 1


def _equation_end(tokens: Sequence[Token], place: int) -> int:
    while place < len(tokens) and not tokens[place].section:
        if tokens[place].first and tokens[place].kind == "NAME" and tokens[place - 1].kind in OPERAND_ENDS:
            break
        place += 1
    return place


def _is_csp(token: Token) -> bool:
    return token.kind in ("BAD", "->", "|->") or str(token.value) in ("SKIP", "STOP")


def _operations(tokens: Sequence[Token], boxes: Sequence[str]) -> frozenset[int]:
    """The ``schema`` boxes of a class that describe operations, by the place of their first token."""
    channels: set[str] = set()
    for place, token in enumerate(tokens):
        if boxes[place] == "class" and token.value in ("chan", "method", "local_chan") and token.first:
            following = place + 1
            while tokens[following].kind in ("NAME", ",") and not tokens[following].first:
                channels.add(str(tokens[following].value))
                following += 1
    found: set[int] = set()
    for place, token in enumerate(tokens):
        if not (token.section and token.kind == "NAME" and token.value == "schema"):
            continue
        name = str(tokens[place + 1].value)
        inside = place + 2
        decorated = False
        while inside < len(tokens) and tokens[inside].kind not in ("end", "$END"):
            # Without brackets `Delta S` includes the schema S, before and after.
            listed = tokens[inside].value == "Delta" and tokens[inside + 1].kind == "("
            decorated = decorated or bool(tokens[inside].decoration) or listed
            inside += 1
        if _OPERATION_NAME.match(name) or name in channels or decorated:
            found.add(place)
    return frozenset(found)


# --- the parser over markup --------------------------------------------------------------------------------------


class _EquationTokens(Tokens):
    """Tokens of CSPm with the text that they stand for, which is not the text of the document."""

    def __init__(self, source: Source, found: Tokens, places: Sequence[tuple[int, int, int]]) -> None:
        """*places* are the pieces of the text of *found*: where each begins, and where its markup does and ends."""
        super().__init__(source, kinds=found.kinds)
        self.texts = [found.text(index) for index in range(len(found.kinds))]
        self.starts, self.ends = [], []
        for start, end in zip(found.starts, found.ends, strict=True):
            self.starts.append(_place(places, start)[1])
            self.ends.append(_place(places, max(start, end - 1))[2])

    def text(self, index: int) -> str:
        """The characters that a token stands for."""
        return self.texts[index]


def _place(places: Sequence[tuple[int, int, int]], offset: int) -> tuple[int, int, int]:
    return places[max(0, bisect_right(places, offset, key=itemgetter(0)) - 1)]


class MarkupReader(Reader):
    """Reads paragraphs from the tokens of markup."""

    def is_equation(self, remark: Diagnostic) -> bool:
        """Whether a remark speaks of an equation, where the commands have another meaning."""
        place = remark.span
        return place is not None and any(start <= place.start and place.end <= end for start, end in self.equations)

    def column(self, token: Token) -> int:
        """Columns mean nothing to TeX."""
        return 0

    def equation_tokens(self, span: Span) -> Tokens:
        """The tokens of CSPm that the markup in a part of the source stands for."""
        pieces: list[str] = []
        places: list[tuple[int, int, int]] = []
        length = 0
        for token, text in self._pieces(span):
            if pieces:
                gap = "\n" if token.first else "" if token.tight else " "
                pieces.append(gap)
                length += len(gap)
            places.append((length, token.start, token.end))
            pieces.append(text)
            length += len(text)
        found = tokenise(Source(self.source.name, "".join(pieces)), form="equations")
        made = _EquationTokens(self.source, found, places)
        made.errors = [self._moved(error, places) for error in found.errors]
        return made

    def _pieces(self, span: Span) -> Iterator[tuple[Token, str]]:
        """The tokens in a part of the document with what they stand for in CSPm."""
        inside = [t for t in self.found if span.start <= t.start and t.end <= span.end and t.start < t.end]
        texts = [self._csp(token) for token in inside]
        for number, (token, text) in enumerate(zip(inside, texts, strict=True)):
            # The bars in `\lpar | A | \rpar` belong to the brackets.
            if text == "|" and (texts[number - 1] == "[|" or texts[number + 1 : number + 2] == ["|]"]):
                continue
            yield token, text

    def _moved(self, error: Diagnostic, places: Sequence[tuple[int, int, int]]) -> Diagnostic:
        """A mistake in the text of an equation, at its place in the document."""
        if error.span is None:
            return error
        start = _place(places, error.span.start)[1]
        end = _place(places, max(error.span.start, error.span.end - 1))[2]
        return replace(error, span=self.source.span(start, max(start, end)), labels=())

    def _csp(self, token: Token) -> str:
        """What a token stands for in CSPm."""
        raw = self.source.text[token.start : token.end]
        if token.kind == "NAME":
            return {"Skip": "SKIP", "Stop": "STOP"}.get(str(token.value), str(token.value)) + token.decoration
        command = re.match(r"\\[A-Za-z]+|\\.", raw)
        if command is not None and command[0] in CSP_COMMANDS:
            return CSP_COMMANDS[command[0]]
        if command is not None and command[0] in NAMES:
            return NAMES[command[0]][0]
        return token.kind if command is not None else raw


def text_of(span: Span) -> str:
    """The paragraph of one line that stands at a place of a document, in the text notation."""
    from cspcheck.cspm.oz.writing.printer import print_paragraph

    markup = f"\\begin{{zed}}{span.text}\\end{{zed}}"
    (paragraph,) = LatexDocument(Source("line.tex", markup), lambda path, place: ()).declarations
    assert isinstance(paragraph, s.Paragraph)
    return print_paragraph(paragraph)
