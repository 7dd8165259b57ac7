"""What can be wrong with the files and the characters of a script."""

from __future__ import annotations

import re
from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Severity, mistake
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions


def listed(words: Sequence[str], conjunction: str = "or") -> str:
    """``a``, ``a or b``, ``a, b or c``."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {conjunction} {words[-1]}"


def quoted(words: Sequence[str], conjunction: str = "or") -> str:
    """The words in backticks, as :func:`listed`."""
    return listed([f"`{word}`" for word in words], conjunction)


# --- files ---------------------------------------------------------------------------------------------------


@mistake(
    "CSP001",
    "a file cannot be read",
    explanation="The file does not exist, is a folder, or may not be read by you.",
    example="cspcheck no_such_file.csp",
    repair="Give the name of a file that exists; a relative name is relative to the current folder.",
)
def file_cannot_be_read(name: str, reason: str) -> Diagnostic:
    """The file *name* could not be opened; *reason* is the system's word for why."""
    return Diagnostic("CSP001", f"cannot read `{name}`: {reason}")


@mistake(
    "CSP013",
    "nested too deeply",
    explanation="The script nests brackets, operators or definitions deeper than can be followed: some 100,000.",
    example="300,000 opening brackets around a number.",
    repair="Give names to the parts.",
)
def nested_too_deeply(name: str) -> Diagnostic:
    """The text in *name* is nested deeper than can be followed."""
    return Diagnostic("CSP013", f"`{name}` is nested too deeply")


@mistake(
    "CSP002",
    "the file is in Rich Text Format",
    explanation="A word processor saved the script with its own markup. Scripts are plain text.",
    example="{\\rtf1\\ansi P = STOP}",
    repair="Save the script as plain text (in TextEdit: Format, Make Plain Text).",
)
def rich_text(name: str) -> Diagnostic:
    """The file starts as Rich Text Format files start."""
    return Diagnostic(
        "CSP002", f"`{name}` is a Rich Text file, not plain text", help="save the script as plain text and try again"
    )


@mistake(
    "CSP003",
    "the file is not text",
    explanation="The file contains NUL bytes. It is a binary file, or text in UTF-16.",
    example="A script saved as UTF-16, with a NUL byte beside each letter.",
    repair="Save the script as UTF-8.",
)
def binary_file(name: str) -> Diagnostic:
    """The file holds NUL bytes."""
    return Diagnostic("CSP003", f"`{name}` is not a text file", help="scripts are plain text; save this one as UTF-8")


def utf_16(name: str) -> Diagnostic:
    """The file is text in UTF-16, as PowerShell's `>` writes it."""
    return Diagnostic(
        "CSP003",
        f"`{name}` is text in UTF-16, not UTF-8",
        help="save it as UTF-8; in PowerShell: `... | Out-File -Encoding utf8 FILE`",
    )


@mistake(
    "CSP010",
    "an included file cannot be read",
    explanation="`include` looks for the file in the folder of the script that is checked (the root of all includes), "
    "not in the folder of the file that includes. It takes files from below that folder only, so that a script cannot "
    "have other files of whoever checks it shown in messages; `--include-root FOLDER` allows those below another "
    "folder, too.",
    example='include "no_such_file.csp"',
    repair='include "definitions.csp"',
)
def include_cannot_be_read(span: Span, path: str, reason: str) -> Diagnostic:
    """The file named by an `include` could not be loaded."""
    relative = "paths are relative to the folder of the script that is checked"
    allow = "`--include-root FOLDER` allows includes from below another folder, too"
    return Diagnostic(
        "CSP010", f"cannot include `{path}`: {reason}", span, help=allow if reason == OUTSIDE else relative
    )


OUTSIDE = "it is not below the folder of the script"
"""Why a file is not included that could be read."""


@mistake(
    "CSP011",
    "a file includes itself",
    explanation="A file includes itself, directly or through other files, so that its text would never end.",
    example='-- in a.csp:\ninclude "a.csp"',
    repair="Remove one `include` of the circle; a file sees everything that the script it belongs to declares.",
)
def include_cycle(span: Span, path: str, chain: Sequence[str]) -> Diagnostic:
    """An `include` of a file that is being included already; *chain* is the circle of files."""
    return Diagnostic(
        "CSP011",
        f"`{path}` includes itself",
        span,
        notes=(" includes ".join(f"`{name}`" for name in chain),),
        help="remove this `include`",
    )


@mistake(
    "CSP012",
    "includes are nested too deeply",
    explanation="Files include files that include files, more than a hundred deep.",
    example="A chain of more than 100 files, each of which includes the next.",
    repair="Include the files side by side from the script itself.",
)
def includes_too_deep(span: Span, limit: int) -> Diagnostic:
    """An `include` at a depth beyond *limit*."""
    return Diagnostic("CSP012", f"includes are nested more than {limit} deep", span)


# --- characters ----------------------------------------------------------------------------------------------

_LOOKALIKES = {
    "\u00a0": "an ordinary blank (this one is a no-break space)",
    "\u2013": "`-` (this is an en dash)",
    "\u2014": "`--` (this is an em dash)",
    "\u2212": "`-` (this is the typographic minus sign)",
    "\u2018": "`'` (this is a typographic quote)",
    "\u2019": "`'` (this is a typographic quote)",
    "\u201c": '`"` (this is a typographic quote)',
    "\u201d": '`"` (this is a typographic quote)',
    "\u2192": "`->`",
    "\u2190": "`<-`",
    "\u25a1": "`[]`",
    "\u2293": "`|~|`",
    "\u2016": "`||`",
    "\u2225": "`||`",
    "\u2264": "`<=`",
    "\u2265": "`>=`",
    "\u2260": "`!=`",
    "\u27e8": "`<`",
    "\u27e9": "`>`",
    "\u2227": "`and`",
    "\u2228": "`or`",
    "\u00ac": "`not`",
    "\u2026": "`..`",
    "`": "`'`",
}


_ARROW = re.compile(r"[ \t]*>")


@mistake(
    "CSP004",
    "a character that CSPm does not know",
    explanation="Outside comments and strings CSPm is written with the letters, digits and signs of ASCII. Signs "
    "copied from a "
    "paper or a word processor often look right and are others.",
    example="P = a \u2192 STOP",
    repair="P = a -> STOP",
)
def unknown_character(span: Span) -> Diagnostic:
    """A character that begins no token."""
    character = span.text
    shown = character if character.isprintable() else f"U+{ord(character):04X}"
    meant = _LOOKALIKES.get(character)
    if character in "\u2013\u2014\u2212" and _ARROW.match(span.source.text, span.end):
        meant = "`->` (a word processor has made a dash of the `-`)"
    return Diagnostic(
        "CSP004", f"unknown character `{shown}`", span, help=None if meant is None else f"write {meant.strip()}"
    )


@mistake(
    "CSP005",
    "a block comment is not closed",
    explanation="`{-` opens a comment that goes to the matching `-}`; such comments nest. A set that begins with a "
    "negative number "
    "opens a comment, too: write `{ -1..1}` with a blank.",
    example="S = {-1..1}",
    repair="S = { -1..1}",
)
def unclosed_comment(span: Span, rest: str) -> Diagnostic:
    """A `{-` without its `-}`; *rest* is the text behind it."""
    line = rest.split("\n", 1)[0]
    looks_like_set = "}" in line and not line.lstrip().startswith("-")
    return Diagnostic(
        "CSP005",
        "this comment is never closed",
        span,
        help="`{-` opens a comment; for a set that begins with a minus write `{ -`"
        if looks_like_set
        else "close it with `-}`; each `{-` inside a comment needs its own `-}`",
    )


@mistake(
    "CSP006",
    "a string is not closed",
    explanation='A string begins and ends with `"` on one line. `\\n` stands for a line break and `\\"` for a quote '
    "inside it.",
    example='text = "no such message',
    repair='text = "no such message"',
)
def unclosed_string(span: Span) -> Diagnostic:
    """A `"` without a second one on its line."""
    return Diagnostic("CSP006", "this string is not closed", span, help='close it with `"` on the same line')


@mistake(
    "CSP007",
    "a character literal is malformed",
    explanation="A character stands between two `'`. Primes at the end of a name belong to the name.",
    example="c = 'ab'",
    repair="c = <'a', 'b'>",
)
def malformed_character(span: Span) -> Diagnostic:
    """A `'` that begins no character."""
    return Diagnostic(
        "CSP007",
        "`'` begins no character here",
        span,
        help="a character is written `'c'`, a string `\"text\"`; the prime of a name follows its letters directly",
    )


@mistake(
    "CSP008",
    "a name begins with an underscore",
    explanation="A name begins with a letter. `_` alone is the pattern that matches everything.",
    example="_x = 1",
    repair="x_ = 1",
)
def name_begins_with_underscore(span: Span) -> Diagnostic:
    """A name such as ``_x``."""
    return Diagnostic(
        "CSP008", f"the name `{span.text}` begins with an underscore", span, help="names begin with a letter"
    )


@mistake(
    "CSP017",
    "what a `print` line shows cannot be read",
    explanation="The rest of a `print` line is an expression. One with a mistake in it stops nothing else: the line is "
    "left out.",
    example="channel a\nprint 1 + + 2\nassert a -> STOP :[divergence free]",
    repair="channel a\nprint 1 + 2\nassert a -> STOP :[divergence free]",
)
def print_left_out(mistake: str, span: Span) -> Diagnostic:
    """A ``print`` line with a mistake in it."""
    return Diagnostic("CSP017", f"this line shows nothing: {mistake}", span, severity=Severity.WARNING)


# --- words that stand in square brackets of an assertion -----------------------------------------------------


@mistake(
    "CSP016",
    "a comment that announces no verdict",
    explanation="A comment `-- expect: fail` beside an assertion, or alone on the line above it, says which verdict "
    "the script expects: `pass`, `fail` or `unknown`. This one looks like it, and counts for nothing.",
    example="-- expect: fails\nassert STOP :[deadlock free]",
    repair="-- expect: fail\nassert STOP :[deadlock free]",
)
def no_expectation(span: Span, meant: str | None) -> Diagnostic:
    """A comment at *span* says what to expect in a form that is none; *meant* is the verdict, if it can be guessed."""
    hint = f"did you mean `expect: {meant}`?" if meant else "the verdicts are `pass`, `fail` and `unknown`"
    return Diagnostic("CSP016", f"`{span.text}` announces no verdict", span, severity=Severity.WARNING, help=hint)


@mistake(
    "CSP120",
    "an assertion claims an unknown property",
    explanation="The properties are `deadlock free`, `divergence free` (or `livelock free`), `deterministic` and `has "
    "trace`; the "
    "options `tau priority over` and `partial order reduce`.",
    example="assert STOP :[deadlok free]",
    repair="assert STOP :[deadlock free]",
)
def unknown_property(span: Span, words: str, known: Sequence[str]) -> Diagnostic:
    """The words between ``:[`` and ``]`` are none of the *known* ones."""
    close = suggestions(words, known)
    return Diagnostic(
        "CSP120",
        f"unknown property `{words}`",
        span,
        help=f"did you mean `{close[0]}`?" if close else f"the properties and options are {quoted(known, 'and')}",
    )


@mistake(
    "CSP121",
    "an assertion names an unknown model",
    explanation="Refinement is written `[T=`, `[F=` or `[FD=` (traces, stable failures, failures-divergences); `[V=`, "
    "`[VD=`, `[R=` "
    "and `[RD=` are read, too. A property may name its model, as in `:[deadlock free [F]]`.",
    example="assert STOP [FDR= STOP",
    repair="assert STOP [FD= STOP",
)
def unknown_model(span: Span, known: Sequence[str]) -> Diagnostic:
    """The letters of ``[X=`` name no model."""
    return Diagnostic("CSP121", f"unknown model `{span.text}`", span, help=f"the models are {quoted(known, 'and')}")


def unknown_mode(span: Span, words: str, known: Sequence[str]) -> Diagnostic:
    """The inner bracket of ``:[words [mode]]`` holds none of the *known* words (of which there may be none)."""
    return Diagnostic(
        "CSP121",
        f"`{words}` has no variant `{span.text}`",
        span,
        help=f"it can be {quoted(known)}" if known else f"write `:[{words}]`",
    )


@mistake(
    "CSP122",
    "a property in an assertion is malformed",
    explanation="A property stands in square brackets behind a colon and may name its model in a second pair of "
    "brackets.",
    example="assert STOP :[deadlock free",
    repair="assert STOP :[deadlock free]",
)
def malformed_property(span: Span) -> Diagnostic:
    """A ``:[`` whose bracket is not closed or holds something else than words."""
    return Diagnostic(
        "CSP122", "malformed property", span, help="properties look like `:[deadlock free]` or `:[deadlock free [F]]`"
    )


__all__ = [
    "binary_file",
    "file_cannot_be_read",
    "include_cannot_be_read",
    "include_cycle",
    "includes_too_deep",
    "listed",
    "malformed_character",
    "malformed_property",
    "name_begins_with_underscore",
    "quoted",
    "rich_text",
    "unclosed_comment",
    "unclosed_string",
    "unknown_character",
    "unknown_mode",
    "unknown_model",
    "unknown_property",
]


@mistake(
    "CSP136",
    "a sequence that begins with a minus sign",
    explanation="Here `<-1, 5>` is a sequence. FDR reads `<-` as the arrow of a generator, and refuses the script.",
    example="s = <-1, 5>",
    repair="s = < -1, 5>",
)
def sequence_begins_with_minus(span: Span) -> Diagnostic:
    """``<-`` where a sequence must begin."""
    return Diagnostic(
        "CSP136",
        "other tools read `<-` as the arrow of a generator",
        span,
        Severity.WARNING,
        help="put a blank between `<` and `-`",
    )
