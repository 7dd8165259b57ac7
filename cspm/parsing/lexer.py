"""From text to tokens: everything about CSPm that depends on where a character stands.

Four things in CSPm cannot be left to a grammar, and are settled here while the tokens are made:

* a **line break** ends a declaration, but only where declarations stand (the script, a module, a ``let``, a
  ``Timed`` section), only behind a token that can end one, and only before a token that can begin one;
* ``<`` opens a sequence where an operand is expected and is *less than* behind an operand; the first ``>`` in an
  open sequence closes it, brackets inside it start afresh;
* ``::`` with no blank on either side joins the parts of a name, otherwise it introduces a type;
* ``not`` behind ``assert`` negates the assertion if that is a refinement or a property, and is an ordinary
  operator if it is a Boolean expression.

Classes and other Object-Z paragraphs have words of their own (:mod:`cspcheck.cspm.oz.reading.lexer`); here each is
one token. They are recognised at the beginning of a line by a form that no line of CSPm has, such as ``class Name``,
so that all their words remain names. ``X == e`` defines, ``P || Q`` composes and ``:[words]`` may be a proof
obligation only in scripts in which such a paragraph (or an ``include``) stands.

The kind of a punctuation token or of a keyword is its text, so that the grammar can quote it; the other kinds
have names in capitals.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final, Literal

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing import lexing_messages as lexing
from cspcheck.cspm.parsing.habit_messages import markdown
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions

DECLARATION_KEYWORDS: Final = frozenset(
    [
        *("channel", "datatype", "subtype", "nametype", "assert", "print", "include"),
        *("module", "exports", "endmodule", "instance", "Timed"),
    ]
)
"""Words that stand only where a declaration begins or ends, never inside an expression."""

KEYWORDS: Final = DECLARATION_KEYWORDS | frozenset(
    ["and", "or", "not", "if", "then", "else", "let", "within", "external", "transparent", "true", "false"]
)
"""The reserved words, ``_`` apart."""

MODELS: Final = ("T", "F", "FD", "V", "VD", "R", "RD")

OPERAND_ENDS: Final = frozenset(
    ["NAME", "QUALIFIED", "INT", "CHAR", "STRING", "true", "false", "_", ")", "}", "|}", "|)", "]]", "SEQUENCE_CLOSE"]
)
"""Kinds behind which an operand is complete: an operator or the end of a declaration may follow."""

_DECLARATION_ENDS: Final = OPERAND_ENDS | {
    *("PROPERTY", "REDUCE_OPTION", "SYMMETRY_OPTION", "endmodule", "PARAGRAPH", "OBLIGATION")
}

_BEGINS_DECLARATION: Final = frozenset(
    [
        "NAME",
        "QUALIFIED",
        "INT",
        "CHAR",
        "STRING",
        "true",
        "false",
        "_",
        "(",
        "(|",
        "{",
        "{|",
        "<",
        "-",
        "#",
        "PARAGRAPH",
    ]
) | (KEYWORDS - {"and", "or", "then", "else", "within"})
"""Kinds before which a line break counts; before any other it is only layout."""

_CLOSED_BY: Final = {
    ")": ("(", "Timed("),
    "|)": ("(|",),
    "}": ("{", "Timed"),
    "|}": ("{|",),
    "]]": ("[[",),
    "|]": ("[|",),
    "|>": ("[|",),
    "+]": ("[+",),
    "+\\": ("/+",),
    "]": ("[",),
    "SEQUENCE_CLOSE": ("<",),
    "within": ("let",),
}
"""The contexts that each closing token closes."""

_OPENERS: Final = frozenset(["(", "(|", "{", "{|", "[[", "[|", "[+", "/+", "["])
_DECLARATION_CONTEXTS: Final = frozenset(["script", "let", "Timed"])

_BLANK = r"[ \t\r\f\v]"
_SYMBOLS = [
    # longest first within each first character
    "=>*", "==", "=>", "=",
    "<->", "<-", "<=", "<",
    ">=", ">",
    "->", "-",
    "[]", "[|", "[[", "[>", "[+", "[",
    "]]", "]",
    "|||", "|~|", "||", "|]", "|>", "|}", "|)", "|\\", "|",
    "{|", "{", "}",
    "(", ")",
    "/\\", "/+", "/",
    "+]", "+\\", "+",
    "..", ".",
    "::", ":",
    "@@", "@",
    "!=", "!",
    "\\", "?", "$", "&", ";", ",", "^", "#", "*", "%",
]  # fmt: skip
_NAME = r"[A-Za-z][A-Za-z0-9_]*'*"

_TOKEN = re.compile(
    rf"{_BLANK}*(?:"
    rf"({_NAME}(?:::{_NAME})*)"  # 1 word
    r"|(\n\s*)"  # 2 line break
    r"|([0-9]+)"  # 3 integer
    r"|(--[^\n]*)"  # 4 comment
    r"|(\{-)"  # 5 block comment
    r"|(\(\|(?=\s))"  # 6 map opener
    r"|(:\s*\[(?=\s*[A-Za-z]))"  # 7 property or option of an assertion
    r"|(\[[A-Za-z]+=(?!=))"  # 8 refinement
    rf"|({'|'.join(re.escape(s) for s in _SYMBOLS)})"  # 9 symbol
    r'|("(?:[^"\\\n]|\\[^\n])*")'  # 10 string
    r"|('(?:[^'\\\n]|\\[^\n])')"  # 11 character
    r"|(_[A-Za-z0-9_]*'*)"  # 12 wildcard
    r"|(\Z)"  # 13 end
    r"|(.)"  # 14 anything else
    r")"
)
_HINT = re.compile(r"(by\s+induction\s+on)\s+[A-Za-z_]|using\s+[A-Za-z_]")
"""What helps the proof of a claim about classes."""
_BLOCK = re.compile(r"\{-|-\}")
_PROPERTY = re.compile(
    r":\s*\[\s*(?P<words>[A-Za-z]+(?:[\s-]+[A-Za-z]+)*)\s*(?:\[\s*(?P<mode>[A-Za-z]+)\s*\]\s*)?\](?:\s*:(?!\s*\[\s*[A-Za-z]))?"
)
_PROPERTY_KINDS: Final = {
    "deadlock free": "PROPERTY",
    "divergence free": "PROPERTY",
    "livelock free": "PROPERTY",
    "deterministic": "PROPERTY",
    "has trace": "TRACE_PROPERTY",
    "tau priority": "PRIORITY_OPTION",
    "tau priority over": "PRIORITY_OPTION",
    "partial order reduce": "REDUCE_OPTION",
    "symmetry reduce": "SYMMETRY_OPTION",
}
_REDUCTIONS: Final = ("precise", "hybrid", "fast")

PARAGRAPH_WORDS: Final = ("class", "given", "schema", "retrieve", "const", "reading", "view", "lemma")
"""What an Object-Z paragraph may begin with, besides the name that it defines."""
_DEFINES = re.compile(rf"{_BLANK}*(?:::=|==|\[)")
_HAS_PARAGRAPHS = re.compile(
    r"^[ \t]*(?:(?:class|given|schema|retrieve|const|reading|view|lemma)[ \t]+[^\W\d]|include\b|[A-Za-z]\w*[ \t]*::=)",
    re.MULTILINE,
)
_SYMBOLS_OF_CSP: Final = {
    "→": "->",
    "□": "[]",
    "⊓": "|~|",
    "⦀": "|||",
    "⟨": "<",
    "⟩": ">",
    "≠": "!=",
    "≤": "<=",
    "≥": ">=",
}
"""Signs that the equations of a class may be written with."""


Form = Literal["script", "expression", "assertion", "equations"]


@dataclass(slots=True)
class Tokens:
    """The tokens of a text in parallel lists, its comments, and what was wrong or odd about its characters.

    ``starts`` and ``ends`` are offsets into the text of ``source``. The last token has the kind ``$END``.
    """

    source: Source
    kinds: list[str] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    ends: list[int] = field(default_factory=list)
    comments: list[tuple[int, int]] = field(default_factory=list)
    errors: list[Diagnostic] = field(default_factory=list)
    remarks: list[Diagnostic] = field(default_factory=list)

    def text(self, index: int) -> str:
        """The characters of a token."""
        return self.source.text[self.starts[index] : self.ends[index]]

    def span(self, index: int) -> Span:
        """The place of a token."""
        return Span(self.source, self.starts[index], self.ends[index])


class _Contexts:
    """What is open, innermost last: brackets by their text (``<`` for a sequence), ``let``, ``Timed``, the text."""

    def __init__(self, whole: str) -> None:
        self._open = [whole]
        self._counts: dict[str, int] = {}
        self.innermost = whole

    @property
    def outermost(self) -> bool:
        """Whether nothing is open."""
        return len(self._open) == 1

    def open(self, context: str) -> None:
        self._open.append(context)
        self._counts[context] = self._counts.get(context, 0) + 1
        self.innermost = context

    def close(self, wanted: tuple[str, ...]) -> str:
        """Close the innermost of the *wanted* contexts with all that is open inside it, and return it.

        If there is none nothing changes: the parser reports the closing token.
        """
        if not any(self._counts.get(context) for context in wanted):
            return ""
        while (context := self._pop()) not in wanted:
            pass
        return context

    def forget_brackets(self) -> None:
        """Close everything up to the innermost list of declarations."""
        while self.innermost not in _DECLARATION_CONTEXTS and not self.outermost:
            self._pop()

    def _pop(self) -> str:
        context = self._open.pop()
        self._counts[context] -= 1
        self.innermost = self._open[-1]
        return context


def property_words(text: str) -> tuple[str, str | None]:
    """The normalised words and the bracketed mode of a ``:[...]`` token: ``("deadlock free", "F")``."""
    match = _PROPERTY.match(text)
    assert match is not None, text
    return " ".join(re.split(r"[\s-]+", match["words"])), match["mode"]


def tokenise(
    source: Source, *, start: int = 0, end: int | None = None, form: Form = "script", classes: bool = False
) -> Tokens:
    """The tokens of *source* from the offset *start* on, up to *end*.

    The text is a script, the equations of a class, or one expression or assertion, in which line breaks mean
    nothing. *classes* tells that there are classes, even if the text has none. Mistakes are collected in
    ``Tokens.errors``; the tokens around them are still made.
    """
    text = source.text
    end = len(text) if end is None else end
    tokens = Tokens(source)
    classes = classes or form != "script" or _HAS_PARAGRAPHS.search(text) is not None
    kinds, starts, ends = tokens.kinds, tokens.starts, tokens.ends
    contexts = _Contexts("script" if form in ("script", "equations") else "expression")
    broken = False  # a line break stands before the next token
    previous = ""  # kind of the last token
    timed = ""  # "(" once behind `Timed`, ")" once its bracket is closed: the next `{` holds declarations
    negations: list[int] = []  # the `not`s directly behind an `assert`, while it is unknown what they negate
    asserting = form == "assertion"  # in an assertion, not yet behind anything but `not`
    claiming = False  # behind an assertion about classes, where hints for its proof may stand

    position = start
    scan = _TOKEN.match
    while True:
        match = scan(text, min(position, end), end)
        assert match is not None  # the last alternative takes any character
        group = match.lastindex
        assert group is not None
        begin, position = match.span(group)
        if group == 1:
            word = text[begin:position]
            if word in KEYWORDS and (word != "print" or text[position : position + 1] in (" ", "\t")):
                kind = word
            elif "::" in word:
                kind = "QUALIFIED"
            else:
                kind = "NAME"
                if (broken or not kinds) and form == "script":
                    free = contexts.outermost and classes and (not kinds or previous in _DECLARATION_ENDS)
                    if (paragraph := _paragraph(tokens, begin, position, free=free)) is not None:
                        kind, position = "PARAGRAPH", paragraph
                elif word == "via" and previous == "NAME" and kinds[-2:-1] == ["SIMULATES"]:
                    kind = "VIA"
                elif claiming and word in ("using", "by") and (hint := _HINT.match(text, begin)) is not None:
                    kind, position = ("USING", position) if word == "using" else ("INDUCTION", hint.end(1))
        elif group == 9:
            kind = text[begin:position]
        elif group == 2:
            broken = True
            continue
        elif group == 3:
            kind = "INT"
        elif group == 4:
            tokens.comments.append((begin, position))
            continue
        elif group == 5:
            position = _block_comment(tokens, begin)
            continue
        elif group == 6:
            kind = "(|"
        elif group == 7:
            kind, position = _property(tokens, begin, classes=classes)
        elif group == 8:
            kind = "REFINES"
            if classes and text[begin + 1 : position - 1] == "OZ":
                kind = "SIMULATES"
            elif text[begin + 1 : position - 1] not in MODELS:
                tokens.errors.append(lexing.unknown_model(source.span(begin + 1, position - 1), MODELS))
        elif group == 10:
            kind = "STRING"
        elif group == 11:
            kind = "CHAR"
        elif group == 12:
            kind = "_"
            if position - begin > 1:
                tokens.errors.append(lexing.name_begins_with_underscore(source.span(begin, position)))
                kind = "NAME"
        elif group == 13:
            break
        elif form == "equations" and text[begin] in _SYMBOLS_OF_CSP:
            kind = _SYMBOLS_OF_CSP[text[begin]]
        else:
            position = _bad_character(tokens, begin)
            if text[begin] in "\"'":
                # What was meant is clear enough to go on: a literal that ends with its line.
                kind = "STRING" if text[begin] == '"' else "CHAR"
            else:
                continue

        context = contexts.innermost
        if kind == "||" and classes and previous in OPERAND_ENDS and context != "[":
            kind = "COMPOSES"

        # `<` and `>`.
        if kind[0] in "<>":
            if kind == "<" and broken and context in _DECLARATION_CONTEXTS and previous in _DECLARATION_ENDS:
                pass  # begins a declaration: a sequence pattern
            elif kind[0] == "<" and previous not in OPERAND_ENDS:
                if kind == "<-":
                    tokens.remarks.append(lexing.sequence_begins_with_minus(source.span(begin, position)))
                position = begin + 1  # `<-1>`, `<=`: where an operand is due only a sequence can open
                kind = "<"
            elif kind == "<":
                kind = "LESS"
            elif kind[0] == ">" and context == "<" and (kind == ">" or text[position : position + 1] in ("=", ">")):
                position = begin + 1
                kind = "SEQUENCE_CLOSE"

        # Line breaks.
        if broken:
            broken = False
            if context in _DECLARATION_CONTEXTS and previous in _DECLARATION_ENDS and kind in _BEGINS_DECLARATION:
                kinds.append("_NEWLINE")
                starts.append(ends[-1])
                ends.append(ends[-1])
                if contexts.outermost:
                    negations.clear()
        if (
            (kind in DECLARATION_KEYWORDS or kind == "PARAGRAPH")
            and context not in _DECLARATION_CONTEXTS
            and context != "expression"
        ):
            # No bracket goes over a declaration: whatever is open was meant to be closed before. The parser says so.
            contexts.forget_brackets()

        # Brackets.
        if kind in _OPENERS:
            if kind == "(" and previous == "Timed":
                timed = "("
                contexts.open("Timed(")
            elif kind == "{" and (previous == "Timed" or (timed == ")" and previous == ")")):
                timed = ""
                contexts.open("Timed")
            else:
                contexts.open(kind)
        elif kind == "<":
            kind = "SEQUENCE_OPEN"
            contexts.open("<")
        elif kind in _CLOSED_BY:
            if contexts.close(_CLOSED_BY[kind]) == "Timed(":
                timed = ")"
        elif kind == "let":
            contexts.open("let")

        # Negated assertions.
        if asserting:
            if kind == "not":
                negations.append(len(kinds))
            else:
                asserting = False
        if kind in ("OBLIGATION", "SIMULATES"):
            claiming = True
        if kind == "assert":
            claiming = False
            asserting = True
            negations.clear()
        elif negations and kind in ("REFINES", "PROPERTY", "TRACE_PROPERTY", "SIMULATES", "OBLIGATION"):
            for index in negations:
                kinds[index] = "ASSERT_NOT"
            negations.clear()

        kinds.append(kind)
        starts.append(begin)
        ends.append(position)
        previous = kind

    last = ends[-1] if ends else start
    kinds.append("$END")
    starts.append(last)
    ends.append(last)
    return tokens


def _paragraph(tokens: Tokens, begin: int, end: int, *, free: bool) -> int | None:
    """The offset behind the Object-Z paragraph whose first word stands from *begin* to *end*, if it begins one.

    *free* tells whether a declaration begins here in any case.
    """
    text = tokens.source.text
    if text[begin:end] not in PARAGRAPH_WORDS and not _DEFINES.match(text, end):
        return None
    return extension().paragraph_end(tokens, begin, free=free)


def _block_comment(tokens: Tokens, begin: int) -> int:
    """The offset behind the block comment at *begin*; comments nest."""
    text = tokens.source.text
    depth = 1
    position = begin + 2
    while depth:
        match = _BLOCK.search(text, position)
        if match is None:
            tokens.errors.append(lexing.unclosed_comment(tokens.source.span(begin, begin + 2), text[begin + 2 :]))
            return len(text)
        depth += 1 if match[0] == "{-" else -1
        position = match.end()
    tokens.comments.append((begin, position))
    return position


def _property(tokens: Tokens, begin: int, *, classes: bool) -> tuple[str, int]:
    """Kind and end of the ``:[...]`` token at *begin*; with *classes* it may be an obligation."""
    source = tokens.source
    match = _PROPERTY.match(source.text, begin)
    if match is None:
        line_end = source.text.find("\n", begin)
        end = line_end if line_end >= 0 else len(source.text)
        shown = source.text[begin:end].rstrip()
        tokens.errors.append(lexing.malformed_property(source.span(begin, begin + len(shown))))
        return "PROPERTY", end
    words = " ".join(re.split(r"[\s-]+", match["words"]))
    kind = _PROPERTY_KINDS.get(words)
    if kind is None and classes and not suggestions(words, _PROPERTY_KINDS):
        return "OBLIGATION", match.end()
    if kind is None:
        tokens.errors.append(lexing.unknown_property(source.span(*match.span("words")), words, tuple(_PROPERTY_KINDS)))
        return "PROPERTY", match.end()
    mode = match["mode"]
    if mode is not None:
        allowed = (
            _REDUCTIONS if kind == "REDUCE_OPTION" else () if kind in ("PRIORITY_OPTION", "SYMMETRY_OPTION") else MODELS
        )
        if mode not in allowed:
            tokens.errors.append(lexing.unknown_mode(source.span(*match.span("mode")), words, allowed))
    return kind, match.end()


def _bad_character(tokens: Tokens, begin: int) -> int:
    """Report what cannot begin a token at *begin*; the offset at which to go on."""
    source = tokens.source
    character = source.text[begin]
    if character in "\"'":
        line_end = source.text.find("\n", begin)
        end = line_end if line_end >= 0 else len(source.text)
        if character == '"':
            tokens.errors.append(lexing.unclosed_string(source.span(begin, end)))
            return end
        tokens.errors.append(lexing.malformed_character(source.span(begin, begin + 1)))
        return begin + 1
    if source.text.startswith("```", begin):
        fence = markdown(source.span(begin, begin + 3))
        if fence.code not in [error.code for error in tokens.errors]:
            tokens.errors.append(fence)
        return begin + 3
    tokens.errors.append(lexing.unknown_character(source.span(begin, begin + 1)))
    return begin + 1
