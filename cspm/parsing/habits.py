"""Habits of other languages: what an unexpected token was meant to be by someone who usually writes another one.

Programming languages, textbooks, other tools for CSP. Looked at before any other rule, because what the machine
expects at such a place (`&` wants a process) helps nobody.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing import habit_messages as messages
from cspcheck.cspm.parsing.lexer import OPERAND_ENDS
from cspcheck.cspm.source import Source, Span

if TYPE_CHECKING:
    from cspcheck.cspm.parsing.mistakes import ParsingSituation

_COMPARISONS: Final = frozenset(["==", "!=", "<=", ">=", "LESS", ">", "true", "false", "not", "and", "or"])
_WORDS: Final = {"mod": "`%`", "div": "`/`", "in": "`member(x, S)`", "xor": "`!=`"}
"""Operators that are words elsewhere."""
_BEGINNINGS: Final = {
    "case": "`if ... then ... else ...`, or one equation for each case",
    "lambda": "`\\ x @ expression`",
    "process": "the process alone: `P = ...`",
    "var": "what changes as parameters of the process: `P(x) = c!x -> P(x + 1)`",
    "const": "the constant alone: `N = 3`",
    "def": "the definition alone: `f(x) = ...`",
    "type": "`nametype T = ...` for a set, or `datatype T = A | B`",
}
"""Words that begin something elsewhere."""
_REFINEMENT: Final = "`SPEC [T= IMPL`, `SPEC [F= IMPL` or `SPEC [FD= IMPL`"
_PROPERTY: Final = r"(?P<words>(?:deadlock|livelock|divergence)[ \t-]*free(?:dom)?|determinis(?:tic|m))"
_FORMS: Final = (
    # what stands in an assertion, and what to write; `{}` is the property
    (re.compile(rf":\[\s*{_PROPERTY}\s*\]\s*\[\s*(?P<model>[A-Z]{{1,2}})\s*\]"), "`:[{words} [{model}]]`"),
    (re.compile(rf"(?<!:)\[\s*{_PROPERTY}\s*\[\s*(?P<model>[A-Z]{{1,2}})\s*\]\s*\]"), "`:[{words} [{model}]]`"),
    (re.compile(rf"(?<!:)\[\s*{_PROPERTY}\s*\]"), "`:[{words}]`"),
    (re.compile(rf"(?::[ \t]*)?(?<![\[A-Za-z]){_PROPERTY}(?![A-Za-z]|\s*[\[\]])"), "`P :[{words}]`"),
    (re.compile(r"\[\s*[TFDVR]{1,2}\s*=\s*\]|\|=|\[=|⊑|===|\brefines\b|\brefinedby\b"), _REFINEMENT),
)  # fmt: skip
_PAT = re.compile(r"^[ \t]*#[ \t]*(?:assert|define|import|alphabet)\b.*$", re.MULTILINE)


_END: Final = re.compile(r"\n|--|\Z")
"""Where the text of a line ends."""


def habit(situation: ParsingSituation) -> Diagnostic | None:
    """What to say if the unexpected token looks like a habit; None if it does not."""
    for rule in (_comment, _assertion, _semicolon, _set_of_numbers, _list_of_names, _sign, _word):
        found = rule(situation)
        if found is not None:
            return found
    return None


def pat_script(source: Source) -> Diagnostic | None:
    """What to say of a text that cannot be parsed if it is a script of PAT."""
    found = _PAT.search(source.text)
    return None if found is None else messages.pat_script(source.span(*found.span()))


def once(found: list[Diagnostic]) -> list[Diagnostic]:
    """The diagnostics without the second and later ones of the same habit."""
    told: set[tuple[str, str]] = set()
    kept = []
    for diagnostic in found:
        key = (diagnostic.code, diagnostic.help or "")
        if diagnostic.code not in messages.HABITS or key not in told:
            kept.append(diagnostic)
        told.add(key)
    return kept


def _pair(situation: ParsingSituation, first: str, second: str) -> Span | None:
    """The place of two signs written as one, of which the unexpected token is one."""
    tokens = situation.tokens
    for index in (situation.index - 1, situation.index):
        if index < 0 or index + 1 >= len(tokens.kinds):
            continue
        glued = tokens.ends[index] == tokens.starts[index + 1]
        if glued and tokens.text(index) == first and tokens.text(index + 1) == second:
            return situation.source.span(tokens.starts[index], tokens.ends[index + 1])
    return None


def _comment(situation: ParsingSituation) -> Diagnostic | None:
    for second in ("/", "*"):
        span = _pair(situation, "/", second)
        if span is not None:
            return messages.borrowed_comment(span)
    first = situation.declaration_start()
    tokens = situation.tokens
    if tokens.kinds[first] == "#" and tokens.span(first).column == 1 and situation.index > first:
        text = situation.source.line_text(tokens.span(first).line)
        if "=" not in text:
            return messages.borrowed_comment(tokens.span(first))
    return None


def _assertion(situation: ParsingSituation) -> Diagnostic | None:
    tokens, source = situation.tokens, situation.source
    first = situation.declaration_start()
    if tokens.kinds[first] != "assert":
        return None
    start = tokens.ends[first]
    ending = _END.search(source.text, max(start, tokens.starts[situation.index]))
    end = len(source.text) if ending is None else ending.start()
    for form, instead in _FORMS:
        found = form.search(source.text, start, end)
        if found is not None:
            parts = found.groupdict()
            if "words" in parts:
                parts["words"] = _property_words(parts["words"])
            return messages.assertion_form(source.span(*found.span()), instead.format(**parts))
    return None


def _property_words(text: str) -> str:
    if text.startswith("determ"):
        return "deterministic"
    return f"{re.split(r'free|[ -]', text)[0].strip()} free"


def _semicolon(situation: ParsingSituation) -> Diagnostic | None:
    tokens, index = situation.tokens, situation.index
    if situation.kind == ";":
        following = tokens.kinds[index + 1] if index + 1 < len(tokens.kinds) else "$END"
        last = following in ("_NEWLINE", "$END") or tokens.span(index + 1).line > tokens.span(index).line
        return messages.semicolon(tokens.span(index)) if last else None
    # `P = a -> P;` goes on in the next line, where a declaration begins instead.
    before = index - 1
    if situation.kind == "=":
        before = situation.last_head() - 1
    elif situation.kind not in ("$END", "_NEWLINE") and not situation.ends_here():
        return None
    if before > 0 and tokens.kinds[before] == ";":
        following_line = tokens.span(min(before + 1, len(tokens.kinds) - 1)).line
        if situation.kind == "$END" or following_line > tokens.span(before).line:
            return messages.semicolon(tokens.span(before))
    return None


def _set_of_numbers(situation: ParsingSituation) -> Diagnostic | None:
    tokens, index = situation.tokens, situation.index
    if situation.kind != ".." or situation.open_bracket is not None or not 0 < index < len(tokens.kinds) - 1:
        return None
    low, high = tokens.text(index - 1), tokens.text(index + 1)
    span = situation.source.span(tokens.starts[index - 1], tokens.ends[index + 1])
    return messages.borrowed(span, f"`{{{low}..{high}}}`: a set stands in curly brackets")


def _list_of_names(situation: ParsingSituation) -> Diagnostic | None:
    tokens, index = situation.tokens, situation.index
    first = situation.declaration_start()
    declaration, span = tokens.kinds[first], tokens.span(index)
    if declaration == "datatype" and situation.kind in (",", "{", "["):
        return messages.borrowed(span, "the constructors with `|` between them: `datatype T = A | B`")
    if declaration == "channel" and situation.kind == "," and ":" in tokens.kinds[first:index]:
        return messages.borrowed(span, "a `channel` line for each type: `channel a : {0..1}` and `channel b`")
    return None


def _sign(situation: ParsingSituation) -> Diagnostic | None:
    tokens, index, kind = situation.tokens, situation.index, situation.kind
    for first, second, instead in (
        ("&", "&", "`and`"),
        (":", "=", "`=` to define, `==` to compare"),
        ("|", "[", "`P [| A |] Q`"),
        ("+", "+", "`s ^ t` to join sequences"),
        ("<", ">", "`!=`"),
    ):
        span = _pair(situation, first, second)
        if span is not None and (second != ">" or situation.previous == "LESS"):
            return messages.borrowed(span, instead)
    span = tokens.span(index)
    if kind == "||" and _is_condition(situation):
        return messages.borrowed(span, "`or`")
    if kind == "=>" and _is_condition(situation):
        return messages.borrowed(span, "`not p or q` for `p => q`")
    if kind == "=>" and situation.previous in OPERAND_ENDS and situation.bracket() != "(|":
        return messages.borrowed(span, "`->`: `a -> P` is a prefix")
    if kind == "!" and situation.previous not in OPERAND_ENDS:
        return messages.borrowed(span, "`not`")
    if (
        kind == "]"
        and situation.bracket() == "["
        and situation.operand_before_bracket()
        and len(situation.unfinished) < 2
    ):
        return messages.borrowed(span, "`P [| A |] Q`, or `P [ A || B ] Q` with an alphabet for each side")
    return None


def _is_condition(situation: ParsingSituation) -> bool:
    """Whether what stands before the unexpected token compares something."""
    tokens = situation.tokens
    first = situation.unfinished[0] if situation.unfinished else situation.declaration_start()
    if tokens.kinds[first] == "if":
        return True
    if tokens.kinds[first] == "[":
        return False
    return bool(_COMPARISONS & set(tokens.kinds[first : situation.index]))


def _word(situation: ParsingSituation) -> Diagnostic | None:
    tokens, index = situation.tokens, situation.index
    if situation.kind == "then" and situation.previous in OPERAND_ENDS and not situation.unfinished:
        return messages.borrowed(tokens.span(index), "`a -> P` for a prefix, `P ; Q` for one process after the other")
    if situation.kind != "NAME":
        return None
    word = tokens.text(index)
    if word == "in" and any(tokens.kinds[opener] == "let" for opener in situation.unfinished):
        return messages.borrowed(tokens.span(index), "`within`: `let x = 3 within P`")
    if word in _WORDS and situation.previous in OPERAND_ENDS:
        return messages.borrowed(tokens.span(index), _WORDS[word])
    before = tokens.text(index - 1) if index else ""
    if situation.previous == "NAME" and before in _BEGINNINGS:
        return messages.borrowed(tokens.span(index - 1), _BEGINNINGS[before])
    return None
