"""From the text of classes and other Object-Z paragraphs to tokens.

The kind of an operator is the first of its spellings in :mod:`cspcheck.cspm.oz.reading.operators` whatever was
written, so that ``∈`` and ``in`` are the same token; brackets and signs have their ASCII form as their kind. What
depends on where a character stands is settled here:

* ``<`` opens a sequence where an operand is expected and at the beginning of a line outside brackets; behind an
  operand it is *less than*. ``>`` closes the innermost open sequence.
* ``{-1, 0}`` is a set where CSPm's ``{-`` would open a comment: behind ``{-`` stand a number and then ``,``, ``..``
  or ``}``. ``-->`` with blanks on both sides, not at the beginning of a line, is an arrow and no comment.
* ``x!=y`` is ``x != y``; an output is compared with a blank: ``x! = y``.
* Words such as ``op`` and ``state`` are names like any other, except where they begin a line in the form of a
  section of a class; those tokens are marked ``section``. ``where`` and ``end`` are words of the notation anywhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from cspcheck.cspm.oz.reading.operators import NUMBER_SETS, SPELLINGS, Spelling
from cspcheck.cspm.source import Source, Span

BINDERS: Final = {"forall": "∀", "exists": "∃", "exists1": "∃₁", "lambda": "λ", "mu": "μ"}
WORDS: Final = frozenset(["where", "end", "true", "false", "if", "then", "else", "let", "inrel", *BINDERS])
"""Words of the notation that are no operators."""

_SIGNS: Final = {
    **{sign: sign for sign in ("(|", "|)", "(", ")", "{", "}", "[[", "]]", "[", "]", "<<", ">>")},
    **{sign: sign for sign in (",", ";", ":", ".", "|", "@", "==", "::=", "[]", "||", "||!")},
    "⦇": "(|",
    "⦈": "|)",
    "⟪": "<<",
    "⟫": ">>",
    "⟨": "SEQUENCE_OPEN",
    "⟩": "SEQUENCE_CLOSE",
    "∅": "EMPTY",
    "⟦": "[[",
    "⟧": "]]",
    "•": "@",
    "⦁": "@",
    "∣": "|",
    "□": "[]",
    "∥": "||",
}

INFIX: Final[dict[str, Spelling]] = {s.text[0]: s for s in SPELLINGS if s.kind in ("infix", "relation")}
PREFIX: Final[dict[str, Spelling]] = {s.text[0]: s for s in SPELLINGS if s.kind == "prefix"}
POSTFIX: Final[dict[str, Spelling]] = {s.text[0]: s for s in SPELLINGS if s.kind == "postfix"}

OPERAND_ENDS: Final = frozenset(
    ["NAME", "INT", "REAL", "true", "false", "EMPTY", ")", "}", "]", "]]", "|)", "SEQUENCE_CLOSE", *POSTFIX]
)
"""Kinds behind which an operand is complete."""

NAMING: Final = frozenset(kind for kind in PREFIX if kind.isalnum() and kind != "not")
"""Words that are operators or names; a longer sign that begins with ``<`` is an operator behind them."""

_CLOSERS: Final = {")": "(", "|)": "(|", "}": "{", "]": "[", "]]": "[[", ">>": "<<", "SEQUENCE_CLOSE": "SEQUENCE_OPEN"}
_OPENERS: Final = frozenset(_CLOSERS.values())

_SYMBOLS: dict[str, str] = dict(_SIGNS)
_WORDS: dict[str, str] = {word: word for word in WORDS}
for _spelling in SPELLINGS:
    for _text in (*_spelling.text, *_spelling.symbol):
        _table = _WORDS if _text.isascii() and _text[0].isalpha() else _SYMBOLS
        _table.setdefault(_text, _spelling.text[0])
for _word, _symbol in BINDERS.items():
    _SYMBOLS[_symbol] = _word
_NAME_SYMBOLS: Final = {"Δ": "Delta", **{symbol: name for name, (symbol, _) in NUMBER_SETS.items()}}
_WORDS["num"] = "int"

RESERVED: Final = frozenset(_WORDS) - {"num"}
"""Words that are no names in expressions."""

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"
_TOKEN = re.compile(
    r"[ \t\r\f\v]*(?:"
    r"(?P<lines>\n\s*)"
    r"|(?P<comment>--(?!>{1,2}[ \t]+\S)[^\n]*)"
    r"|(?P<block>\{-(?!\s*\d+(?:\.\d+)?\s*(?:,|\.\.|\})))"
    rf"|(?P<symbol>{'|'.join(re.escape(s) for s in sorted([*_SYMBOLS, *_NAME_SYMBOLS], key=len, reverse=True))})"
    rf"|(?P<name>{_NAME})(?P<decoration>(?:'|\?|!(?!=))+)?"
    r"|(?P<real>[0-9]+\.[0-9]+)"
    r"|(?P<int>[0-9]+)"
    r'|(?P<literal>"(?:[^"\\\n]|\\[^\n])*"|\'(?:[^\'\\\n]|\\[^\n])\')'
    r"|(?P<end>\Z)"
    r"|(?P<bad>.)"
    r")"
)
_BLOCK = re.compile(r"\{-|-\}")
_EOL = r"[ \t]*(?:$|--|\{-)"
SECTION: Final = re.compile(
    rf"(?:chan|method|local_chan|inherit|op|given|schema|lemma|visible)[ \t]+[A-Za-z_]|visible[ \t]*\("
    rf"|const[ \t]+[A-Za-z_]|const[ \t]*\[|const{_EOL}"
    rf"|main[ \t]*=(?!=)|{_NAME}[ \t]*::="
    rf"|state(?:{_EOL}|[ \t]+{_NAME}[ \t]*(?:,|:))"
    rf"|init(?:{_EOL}|[ \t]+(?!(?:in|notin|subset|subseteq|prefix|suffix|infix)\b)[A-Za-z0-9(#∀∃])"
    r"|INIT(?![A-Za-z0-9_])|(?:Delta(?![A-Za-z0-9_])|Δ)|↾",
    re.MULTILINE,
)
"""What a line begins with where a section of a class begins."""

HINT: Final = re.compile(
    rf"using[ \t]+{_NAME}(?=(?:[ \t]*[,(]|[ \t]+by[ \t]|[ \t]+end\b|{_EOL}))|by[ \t]+induction[ \t]+on[ \t]+{_NAME}",
    re.MULTILINE,
)
"""What helps a proof: behind a lemma or an operation."""

_INCLUSION: Final = re.compile(rf"(?:Delta|Δ)[ \t]+{_NAME}['?!]*(?![A-Za-z0-9_'?!]|[ \t]*[:,])")
"""``Delta S`` in the brackets of a schema, which may begin a line there."""

PARAGRAPH: Final = re.compile(
    rf"(?:class|given|schema|retrieve|lemma)[ \t]+{_NAME}"
    rf"|const[ \t]*\[|const\s+where\b"
    rf"|const(?:\s|--[^\n]*\n|\{{-(?:(?!-\}})[\s\S])*-\}})+{_NAME}['?!]?[ \t]*(?:,|:(?!:))"
    rf"|reading[ \t]+(?:{_NAME}|[^\W0-9_])"
    r"|view[ \t]+[A-Za-z]"
    rf"|{_NAME}[ \t]*::=",
    re.MULTILINE,
)
"""What a line begins with where a paragraph stands in a script: no line of CSPm begins so."""

ABBREVIATION: Final = re.compile(rf"{_NAME}[ \t]*(?:\[[ \t]*{_NAME}(?:[ \t]*,[ \t]*{_NAME})*[ \t]*\][ \t]*)?==(?!=)")
"""``DATA ==``: a paragraph where a declaration begins; elsewhere it may compare."""

_STOP: Final = re.compile(
    rf"(?:channel|datatype|subtype|nametype|assert|print|include|module|instance|transparent|external)\b"
    rf"|(?:class|retrieve|reading|view)[ \t]+{_NAME}"
)
"""What shows that a block was not closed: at the beginning of a line, no further to the right than the block."""


@dataclass(slots=True)
class Token:
    """A token of the Object-Z notation, from text or from LaTeX.

    Attributes:
        kind: see the module.
        start, end: its place in the text.
        first: whether it is the first on its line.
        tight: whether nothing stands between it and the token before.
        section: whether it begins a section of a class.
        value: of a name its text without decoration, of a number its value.
        decoration: of a name.
    """

    kind: str
    start: int
    end: int
    first: bool = False
    tight: bool = False
    section: bool = False
    value: str | int | Fraction = ""
    decoration: str = ""


@dataclass(slots=True)
class Scan:
    """The comments and the mistakes found while tokens are made."""

    comments: list[tuple[int, int]] = field(default_factory=list)
    unclosed_comment: Span | None = None


def tokens(source: Source, start: int, end: int, scan: Scan) -> Iterator[Token]:
    """The tokens of a part of *source*; the last has the kind ``$END``."""
    text = source.text
    open_brackets: list[str] = []
    previous = ""
    broken = True
    position = last = start
    while True:
        match = _TOKEN.match(text, position, end)
        assert match is not None  # the last alternative takes any character
        group = match.lastgroup
        if group == "decoration":
            group = "name"
        assert group is not None
        begin, position = match.start(group), match.end()
        if group == "lines":
            broken = True
            continue
        if group == "comment":
            scan.comments.append((begin, position))
            continue
        if group == "block":
            position = _block_comment(source, begin, end, scan)
            continue
        if broken and group == "symbol" and match[0].endswith(("-->", "-->>")):
            position = text.find("\n", begin, end)
            position = end if position < 0 else position
            scan.comments.append((begin, position))
            continue
        if group == "end":
            yield Token("$END", last, last, first=True, section=True)
            return
        token = Token("", begin, position, first=broken, tight=begin == last and last > start)
        includes = open_brackets[-1:] == ["["] and _INCLUSION.match(text, begin, end)
        if broken and (
            (SECTION.match(text, begin, end) and not includes)
            or (
                not open_brackets
                and (previous in OPERAND_ENDS or previous == ">>")
                and ABBREVIATION.match(text, begin, end)
            )
        ):
            # No bracket goes over a section: what is open was meant to be closed before.
            token.section = True
            open_brackets.clear()
        if (
            group == "name"
            and (broken or previous in OPERAND_ENDS or previous in NAMING)
            and HINT.match(text, begin, end)
        ):
            token.section = True
            open_brackets.clear()
        if group == "name":
            word = match["name"]
            token.decoration = match["decoration"] or ""
            if token.decoration or token.section or word not in _WORDS or (previous == "." and word not in ("where",)):
                token.kind, token.value = "NAME", "int" if word == "num" and not token.decoration else word
                if previous == "inrel":
                    token.kind = "RELATION"
            else:
                token.kind = _WORDS[word]
                token.value = word
                if word in ("where", "end"):
                    token.section = True
                    open_brackets.clear()
                elif word == "num":
                    token.kind, token.value = "NAME", "int"
        elif group == "symbol":
            _symbol_token(token, match["symbol"], previous, open_brackets)
            position = token.end
        elif group == "int":
            token.kind, token.value = "INT", match["int"]
        elif group == "real":
            token.kind, token.value = "REAL", match["real"]
        else:
            token.kind = "LITERAL" if group == "literal" else "BAD"
        if token.kind in _OPENERS:
            open_brackets.append(token.kind)
        elif token.kind in _CLOSERS and _CLOSERS[token.kind] in open_brackets:
            while open_brackets.pop() != _CLOSERS[token.kind]:
                pass
        broken = False
        previous = token.kind
        last = position
        yield token


def _symbol_token(token: Token, symbol: str, previous: str, open_brackets: list[str]) -> None:
    """Decide what a sign is where it stands; it may be only the first character of what was found."""
    begins_line = token.first and not open_brackets
    behind_operand = previous in OPERAND_ENDS and not begins_line
    innermost = open_brackets[-1] if open_brackets else ""
    if symbol in _NAME_SYMBOLS or token.section:
        token.kind, token.value = "NAME", _NAME_SYMBOLS.get(symbol, "visible")
        return
    if symbol[0] == "<" and (symbol in ("<", "<<") if begins_line or previous in NAMING else not behind_operand):
        token.kind, token.end = "SEQUENCE_OPEN", token.start + 1
    elif symbol[0] == ">" and innermost == "SEQUENCE_OPEN":
        token.kind, token.end = "SEQUENCE_CLOSE", token.start + 1
    elif symbol == ">>" and innermost != "<<":
        token.kind, token.end = ">", token.start + 1
    elif (symbol == "[]" and previous == ":") or (symbol == "[[" and behind_operand):  # `chan c : []`
        token.kind, token.end = "[", token.start + 1
    elif symbol == "]]" and innermost != "[[":
        token.kind, token.end = "]", token.start + 1
    else:
        token.kind = _SYMBOLS[symbol]


def _block_comment(source: Source, begin: int, end: int, scan: Scan) -> int:
    """The offset behind the block comment at *begin*; comments nest."""
    depth = 1
    position = begin + 2
    while depth:
        match = _BLOCK.search(source.text, position, end)
        if match is None:
            scan.unclosed_comment = source.span(begin, begin + 2)
            return end
        depth += 1 if match[0] == "{-" else -1
        position = match.end()
    scan.comments.append((begin, position))
    return position


@dataclass(frozen=True, slots=True)
class Extent:
    """How far a paragraph goes, with the comments in it."""

    end: int
    comments: tuple[tuple[int, int], ...]


_CONTINUES_BEFORE: Final = frozenset(
    [",", ";", ":", "|", "@", "==", "::=", "[]", "||", ".", "then", "else", "let", "if", "inrel", "RELATION"]
)
_NO_CONTINUATION: Final = frozenset(["-", "#"])
"""Operators that begin a line of their own."""


def continues(token: Token) -> bool:
    """Whether a token at the beginning of a line goes on with the line before."""
    return token.kind == "inrel" or (token.kind in INFIX and token.kind not in _NO_CONTINUATION)


def extent(source: Source, start: int) -> Extent:
    """How far the paragraph at *start* goes: to the ``end`` of a block, or over the lines of any other."""
    scan = Scan()
    stream = tokens(source, start, len(source.text), scan)
    first = next(stream)
    word = str(first.value) if first.kind == "NAME" else ""
    second = next(stream)
    if word in ("class", "schema", "retrieve") and second.kind == "NAME":
        end = _block_end(source, first, second, stream)
    else:
        end = _lines_end(
            source, first, second, stream, axiom=word == "const" and second.kind in ("NAME", ":", "[", "where")
        )
    return Extent(end, tuple(comment for comment in scan.comments if comment[0] < end))


def _block_end(source: Source, first: Token, second: Token, stream: Iterator[Token]) -> int:
    column = source.position(first.start)[1]
    line = source.position(first.start)[0]
    whole_class = first.value == "class"
    closable = False  # whether an `end` may close a section of the class
    schema = False  # whether a schema in the class is open
    end = second.end
    for token in stream:
        if token.kind == "$END":
            return end
        if token.first and source.position(token.start)[1] <= column and _STOP.match(source.text, token.start):
            return end
        end = token.end
        if token.kind == "end":
            if not whole_class:
                return end
            place = source.position(token.start)
            if schema:
                schema = closable = False
            elif closable and place[0] != line and (not token.first or place[1] > column):
                closable = False
            else:
                return end
        elif token.section and token.kind == "NAME":
            closable = token.value in ("op", "state", "init", "INIT", "const", "schema") or (
                closable and token.value in ("Delta", "using")
            )
            schema = schema or token.value == "schema"
        elif token.section and token.kind != "where":
            closable = False
    raise AssertionError("the last token is the end")


def _lines_end(source: Source, first: Token, second: Token, stream: Iterator[Token], *, axiom: bool) -> int:
    column = source.position(first.start)[1]
    depth = 0
    before = first
    token = second
    ahead: list[Token] = []
    block = False  # behind the `where` of constants, which only `end` ends
    while token.kind != "$END":
        if (
            token.first
            and source.position(token.start)[1] <= column
            and (_STOP.match(source.text, token.start) or PARAGRAPH.match(source.text, token.start))
        ):
            break
        if block and token.kind == "end":
            return token.end
        if token.kind == "where" and axiom:
            block = True
        elif token.first and not block and depth == 0 and before is not first:
            goes_on = (
                before.kind in _CONTINUES_BEFORE
                or before.kind in INFIX
                or token.kind in ("|", "@", "then", "else", ",", "::=", "==", "]", ")", "}")
                or continues(token)
                or (axiom and _is_declaration(token, stream, ahead))
                or (first.value == "lemma" and HINT.match(source.text, token.start))
            )
            if not goes_on:
                break
        if token.kind in _OPENERS:
            depth += 1
        elif token.kind in _CLOSERS:
            depth = max(depth - 1, 0)
        before = token
        token = ahead.pop(0) if ahead else next(stream)
    return before.end


def _is_declaration(token: Token, stream: Iterator[Token], ahead: list[Token]) -> bool:
    """Whether ``x, y :`` begins here; tokens that are looked at are kept in *ahead*."""
    place = -1

    def peek() -> Token:
        nonlocal place
        place += 1
        while len(ahead) <= place:
            if ahead and ahead[-1].kind == "$END":
                return ahead[-1]
            ahead.append(next(stream))
        return ahead[place]

    while token.kind == "NAME":
        following = peek()
        if following.kind == ":":
            return True
        if following.kind != ",":
            return False
        token = peek()
    return False
