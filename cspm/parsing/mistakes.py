"""What to say about a token that does not fit, and where to go on looking for mistakes.

The machine knows which tokens could have come instead, and its stack knows what is still open. Most mistakes show
only some tokens later, so the search goes from the innermost unfinished construct outwards.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.parsing import class_messages, habits, messages as messages
from cspcheck.cspm.parsing.builder import MOST_MISTAKES, TreeBuilder
from cspcheck.cspm.parsing.driver import Open, Unexpected, accepts, expected, run, stack_before
from cspcheck.cspm.parsing.lexer import (
    DECLARATION_KEYWORDS,
    KEYWORDS,
    OPERAND_ENDS,
    PARAGRAPH_WORDS,
    Tokens,
    tokenise,
)
from cspcheck.cspm.parsing.lexing_messages import quoted
from cspcheck.cspm.parsing.table import Table
from cspcheck.cspm.source import Source
from cspcheck.cspm.spelling import suggestions

_CLOSERS: Final = {
    "(": ")",
    "{": "}",
    "{|": "|}",
    "SEQUENCE_OPEN": "SEQUENCE_CLOSE",
    "(|": "|)",
    "[[": "]]",
    "[|": "|]",
    "[+": "+]",
    "/+": "+\\",
    "[": "]",
}
_OPENERS: Final = {closer: opener for opener, closer in _CLOSERS.items()} | {"|>": "[|"}
_REPLICATED: Final = frozenset(["[]", "|~|", "|||", ";", "||", "|]", "+]", "]", "\\"])
"""What stands before the generators of a replicated operator, or the parameters of a lambda."""

_LONGEST_HEAD: Final = 200
"""Tokens of a definition's left side that are looked through for its ``=``, at most."""

_OPERAND_STARTS: Final = frozenset(
    ["NAME", "QUALIFIED", "INT", "CHAR", "STRING", "true", "false", "_", "(", "(|", "{", "{|", "SEQUENCE_OPEN"]
)
_TELLING: Final = ("then", "else", "within", "@", "=", "::", "<-", "<->", "=>", "exports", "endmodule", ",")
"""Words and signs that are worth mentioning where they could come."""

_DECLARATION: Final = "a declaration"
_BEGINS_DECLARATION: Final = (DECLARATION_KEYWORDS - {"exports", "endmodule"}) | {
    "transparent",
    "external",
    "PARAGRAPH",
}

# A set that begins with a negative number, taken for a comment.
_COMMENTED_SET = re.compile(r"\{-\s*\d+\s*(\.\.|,|\})")


class ParsingMistake(NamedTuple):
    """A diagnostic and the token from which on to look for further declarations."""

    diagnostic: Diagnostic
    resume: int


def diagnose(table: Table, start: str, tokens: Tokens, index: int) -> ParsingMistake:
    """What to say about the unexpected token at *index*."""
    stack = stack_before(table, start, tokens.kinds, index)
    finding = ParsingSituation(table, tokens, index, stack).finding()
    for begin, end in tokens.comments:
        if tokens.starts[max(index - 20, 0)] <= begin <= tokens.starts[index] and _COMMENTED_SET.match(
            tokens.source.text, begin, end
        ):
            note = "the text between `{-` and `-}` is a comment; for a set that begins with a minus write `{ -`"
            return finding._replace(diagnostic=finding.diagnostic.with_notes(note))
    return finding


def all_of(table: Table, tokens: Tokens, index: int) -> list[Diagnostic]:
    """The diagnostic for the token at *index* of a script, and those for what comes behind it.

    After a mistake the next thing at the beginning of a line that looks like a declaration is taken for one, with
    nothing open before it. Inside modules and ``Timed`` sections that would guess too much, so there the first
    mistake is the last.
    """
    found: list[Diagnostic] = []
    while True:
        finding = diagnose(table, "script", tokens, index)
        found.append(finding.diagnostic)
        inside = stack_before(table, "script", tokens.kinds, index).symbols
        if len(found) == MOST_MISTAKES or any(
            isinstance(symbol, int) and tokens.kinds[symbol] in ("module", "Timed") for symbol in inside
        ):
            return found
        resume = _next_declaration(tokens, finding.resume, len(tokens.kinds))
        if resume is None:
            return found
        tokens = tokenise(tokens.source, start=tokens.starts[resume])
        if tokens.errors:
            return found
        tree = TreeBuilder(tokens, lambda path, span: ())
        try:
            run(table, "script", tokens, tree)
        except Unexpected as error:
            found.extend(tree.errors[: MOST_MISTAKES - len(found) - 1])
            index = error.index
            continue
        # Whether each annotation has its definition cannot be said of a part of a script.
        found.extend(error for error in tree.errors if not messages.concerns_whole_script(error))
        return found[:MOST_MISTAKES]


def _next_declaration(tokens: Tokens, first: int, end: int) -> int | None:
    """The first token from *first* up to *end* that stands at the beginning of a line and begins a declaration."""
    text = tokens.source.text
    for index in range(first, end):
        start = tokens.starts[index]
        if start and text[start - 1] != "\n":
            continue
        if tokens.kinds[index] in _BEGINS_DECLARATION or _is_head(tokens.kinds, index):
            return index
    return None


def _is_head(kinds: Sequence[str], index: int) -> bool:
    """Whether a definition or an annotation begins here: ``f(x)(y) =``, ``a, b ::``."""
    if kinds[index] != "NAME":
        return False
    index += 1
    if kinds[index] == ",":
        while kinds[index] == "," and kinds[index + 1] == "NAME":
            index += 2
        return kinds[index] == "::"
    end = index + _LONGEST_HEAD
    while kinds[index] == "(":
        depth = 0
        while True:
            depth += (kinds[index] == "(") - (kinds[index] == ")")
            index += 1
            if depth == 0:
                break
            if kinds[index] in ("$END", "_NEWLINE") or index > end:
                return False
    return kinds[index] in ("=", "::")


class ParsingSituation:
    """An unexpected token with all that is known about it."""

    def __init__(self, table: Table, tokens: Tokens, index: int, stack: Open) -> None:
        self.table = table
        self.tokens = tokens
        self.source: Source = tokens.source
        self.stack = stack
        self.index = index
        self.kind = tokens.kinds[index]
        self.previous = tokens.kinds[index - 1] if index else ""
        self.unfinished = list(self._unfinished())
        self.open_bracket = next((i for i in self.unfinished if tokens.kinds[i] in _CLOSERS), None)

    # --- what is known ---------------------------------------------------------------------------------------

    def _unfinished(self) -> list[int]:
        """The tokens that began what is not finished, innermost first.

        These are open brackets, ``let`` without ``within``, ``if`` without ``then``, ``then`` without ``else``, and
        replicated operators and lambdas without ``@``.
        """
        kinds = self.tokens.kinds
        found = []
        skip: list[frozenset[str]] = []  # what is finished, so that its beginning is to be passed over
        symbols = self.stack.symbols
        for place in range(len(symbols) - 1, -1, -1):
            symbol = symbols[place]
            if not isinstance(symbol, int):
                continue
            kind = kinds[symbol]
            if skip and kind in skip[-1]:
                skip.pop()
                if kind in _OPENERS:  # the `|]` before replicated generators closes a bracket itself
                    skip.append(frozenset([_OPENERS[kind]]))
            elif kind in _OPENERS:
                # Behind what is infix stands nothing yet (the machine has made an operator of it otherwise).
                if kind in ("|]", "+]", "]") and place + 1 < len(symbols) and not self._is_alphabet(place):
                    found.append(symbol)
                skip.append(frozenset([_OPENERS[kind]]))
            elif kind == "within":
                skip.append(frozenset(["let"]))
            elif kind == "else":
                skip.append(frozenset(["then"]))
            elif kind == "then":
                skip.append(frozenset(["if"]))
                found.append(symbol)
            elif kind == "@":
                skip.append(_REPLICATED)
            elif kind in _CLOSERS or kind in ("let", "if") or (kind in _REPLICATED and place + 1 < len(symbols)):
                found.append(symbol)
        return found

    def _is_alphabet(self, place: int) -> bool:
        """Whether the `]` at a place of the stack closes the alphabet of a replicated `||`."""
        return "@" in self._kinds_below(place, 3)

    def declaration_start(self) -> int:
        """The first token of the declaration that the unexpected token belongs to."""
        kinds, symbols = self.tokens.kinds, self.stack.symbols
        for place in range(len(symbols) - 1, -1, -1):
            symbol = symbols[place]
            if not isinstance(symbol, int):
                continue
            if kinds[symbol] in ("_NEWLINE", "let", "exports"):
                return symbol + 1
            if kinds[symbol] == "{" and "Timed" in (kinds[symbol - 1], *self._kinds_below(place, 4)):
                return symbol + 1
        return 0

    def _opens_timed_section(self, opener: int) -> bool:
        """Whether a token is the bracket of ``Timed {`` or ``Timed(f) {``."""
        kinds = self.tokens.kinds
        if kinds[opener] != "{":
            return False
        before, depth = opener - 1, 0
        while before > 0 and (kinds[before] == ")" or depth):
            depth += (kinds[before] == ")") - (kinds[before] == "(")
            before -= 1
        return kinds[before] == "Timed"

    def _kinds_below(self, place: int, distance: int) -> list[str]:
        """The kind of the token that lies *distance* symbols below a place of the stack, if there is one."""
        symbol = self.stack.symbols[place - distance] if place >= distance else ""
        return [self.tokens.kinds[symbol]] if isinstance(symbol, int) else []

    def _found(self, index: int | None = None) -> str:
        index = self.index if index is None else index
        kind, text = self.tokens.kinds[index], self.tokens.text(index)
        if kind == "PARAGRAPH":
            text = text.split()[0]
        text = text if len(text) <= 40 else text[:37] + "..."
        return {
            "NAME": f"name `{text}`",
            "QUALIFIED": f"name `{text}`",
            "INT": f"number `{text}`",
            "CHAR": f"character `{text}`",
            "STRING": f"string `{text}`",
            "_NEWLINE": "the end of the line",
            "$END": "the end of the text",
        }.get(kind, f"`{text}`")

    def ends_here(self) -> bool:
        """Whether the unexpected token shows that the declaration before it is over."""
        if self.kind in ("$END", "_NEWLINE"):
            return True
        return self.kind in DECLARATION_KEYWORDS or self.kind == "PARAGRAPH"

    def bracket(self) -> str:
        """The innermost open bracket; empty if there is none."""
        return "" if self.open_bracket is None else self.tokens.kinds[self.open_bracket]

    def operand_before_bracket(self) -> bool:
        """Whether the innermost open bracket stands behind an operand, as an operator does."""
        opener = self.open_bracket
        return opener is not None and opener > 0 and self.tokens.kinds[opener - 1] in OPERAND_ENDS

    def last_head(self) -> int:
        """Where the last definition before the unexpected token begins, read as a part of the one before; 0 if none."""
        first, head = self.declaration_start(), 0
        while (found := _next_declaration(self.tokens, first + 1, self.index)) is not None:
            head = first = found
        return head

    # --- what to say -----------------------------------------------------------------------------------------

    def finding(self) -> ParsingMistake:
        """The diagnostic, and where to go on."""
        habit = habits.habit(self)
        if habit is not None:
            return ParsingMistake(habit, self.index)
        for rule in (
            self._unfinished_before_next_declaration,
            self._map_opener,
            self._keyword_before,
            self._closing_bracket,
            self._missing_process,
            self._end_of_declaration,
            self._definition_sign,
            self._behind_sequence,
            self._reserved_word,
            self._module_header,
            self._missing_word,
        ):
            finding = rule()
            if isinstance(finding, Diagnostic):
                return ParsingMistake(finding, self.index)
            if finding is not None:
                return finding
        labels: tuple[Label, ...] = ()
        if self.open_bracket is not None and self.kind in _OPERAND_STARTS:
            labels = (Label(self.tokens.span(self.open_bracket), "inside this bracket"),)
        return ParsingMistake(
            messages.unexpected(
                self.tokens.span(self.index), self._found(), self._wanted(), labels=labels, help=self._hint()
            ),
            self.index,
        )

    def _unfinished_construct(self, opener: int, found: int) -> Diagnostic | None:
        """The diagnostic for what begins at *opener* and should be finished before *found*."""
        tokens = self.tokens
        span, words = tokens.span(found), self._found(found)
        kind = tokens.kinds[opener]
        if kind in _CLOSERS:
            closer = self._closer(opener)
            return messages.unclosed_bracket(tokens.span(opener), tokens.text(opener), closer, span, words)
        if kind == "let":
            return messages.missing_within(tokens.span(opener), span, words)
        if kind in ("if", "then"):
            word = "then" if kind == "if" else "else"
            return messages.missing_branch(span, word, tokens.span(opener), words)
        if kind in ("[]", "|~|", "|||", ";") and not {":", "<-"} & set(tokens.kinds[opener + 1 : found]):
            return messages.operator_without_operand(tokens.span(opener))
        return messages.missing_at(span, tokens.span(opener), words, self._replicated(opener))

    def _closer(self, opener: int) -> str:
        closer = _CLOSERS[self.tokens.kinds[opener]]
        return ">" if closer == "SEQUENCE_CLOSE" else closer

    def _replicated(self, opener: int) -> str:
        kind = self.tokens.kinds[opener]
        return "the lambda" if kind == "\\" else f"the replicated `{_OPENERS.get(kind, kind)}`"

    def _unfinished_before_next_declaration(self) -> ParsingMistake | None:
        """Something is open, and a new declaration has begun: it was meant to end before."""
        if not self.unfinished:
            return None
        opener = self.unfinished[0]
        # Declarations are what the bracket of a Timed section is for.
        timed = self._opens_timed_section(opener)
        following = None if timed else _next_declaration(self.tokens, opener + 1, self.index + 1)
        if following is None and self.ends_here() and self.kind != "_NEWLINE":
            following = self.index
        if following is None:
            return None
        if self.tokens.kinds[opener] in ("if", "then") or self.tokens.kinds[opener] in _REPLICATED:
            # Not what begins too early but what is missing before it, if the expression itself is cut short.
            before = self.tokens.kinds[following - 1]
            if before not in OPERAND_ENDS:
                return None
        diagnostic = self._unfinished_construct(opener, following)
        return None if diagnostic is None else ParsingMistake(diagnostic, following)

    def _map_opener(self) -> Diagnostic | None:
        tokens, index = self.tokens, self.index
        if self.kind in ("|", "|)") and self.previous == "(" and tokens.ends[index - 1] == tokens.starts[index]:
            return messages.map_without_blank(self.source.span(tokens.starts[index - 1], tokens.ends[index]))
        return None

    def _closing_bracket(self) -> Diagnostic | None:
        if self.kind not in _OPENERS:
            return None
        span = self.tokens.span(self.index)
        if self.open_bracket is None:
            return messages.unopened_bracket(span)
        opener = self.tokens.kinds[self.open_bracket]
        if _CLOSERS[opener] != self.kind and not (opener == "[|" and self.kind == "|>"):
            return messages.wrong_closing_bracket(
                span, self.tokens.span(self.open_bracket), self._closer(self.open_bracket)
            )
        if self.kind == "]" and self._replicated_around() and self.previous in OPERAND_ENDS:
            return self._unfinished_construct(self.unfinished[1], self.open_bracket)
        if self.unfinished[0] != self.open_bracket and self.previous in OPERAND_ENDS:
            return self._unfinished_construct(self.unfinished[0], self.index)
        if self.previous == "(" and self.kind == ")":
            both = self.source.span(self.tokens.starts[self.index - 1], span.end)
            called = self.index > 1 and self.tokens.kinds[self.index - 2] in ("NAME", "QUALIFIED")
            return messages.empty_module_brackets(both) if called else messages.empty_brackets(both)
        return None

    def _replicated_around(self) -> bool:
        """Whether the innermost open thing is a `[` among the generators of a replicated `||`."""
        kinds = [self.tokens.kinds[i] for i in self.unfinished[:2]]
        return kinds == ["[", "||"]

    def _missing_process(self) -> Diagnostic | None:
        if self.previous != "->" or not accepts(self.table, self.stack, "INT"):
            return None
        if self.kind in KEYWORDS and not self.ends_here():
            return None
        return messages.missing_process(self.tokens.span(self.index), self.tokens.span(self.index - 1))

    def _end_of_declaration(self) -> Diagnostic | None:
        if not self.ends_here():
            return None
        if self.unfinished and self.previous in OPERAND_ENDS:
            return self._unfinished_construct(self.unfinished[0], self.index)
        if self._lacks_definition_sign():
            return self._expression_alone()
        if self.kind == "$END":
            before = self.tokens.span(self.index - 1) if self.index else None
            return messages.unexpected_end(self.tokens.span(self.index), self._wanted(), before)
        wanted = self._wanted()
        if self.kind in DECLARATION_KEYWORDS and self.first_on_line(self.index) and wanted != [_DECLARATION]:
            return self._cut_short(self.index, wanted)
        return None

    def _cut_short(self, following: int, wanted: Sequence[str]) -> Diagnostic:
        """A declaration is not complete before the one that begins at *following*."""
        tokens = self.tokens
        if tokens.kinds[following - 1] == "->":
            return messages.missing_process(tokens.span(following), tokens.span(following - 1))
        return messages.declaration_cut_short(
            tokens.span(following), self._found(following), wanted, tokens.span(following - 1)
        )

    def _lacks_definition_sign(self) -> bool:
        if not self.stack.symbols or not accepts(self.table, self.stack, "="):
            return False
        return self.tokens.kinds[self.declaration_start()] not in KEYWORDS - {"true", "false", "not", "if", "let"}

    def _expression_alone(self) -> Diagnostic:
        tokens = self.tokens
        first = self.declaration_start()
        if tokens.text(first) == "end" and self.index == first + 1 and "PARAGRAPH" in tokens.kinds:
            return class_messages.end_too_many(tokens.span(first))
        if tokens.kinds[first] == "QUALIFIED" and self.index == first + 1:
            return messages.annotation_without_blank(tokens.span(first))
        depth = 0
        for index in range(first, self.index):
            kind = tokens.kinds[index]
            depth += (kind in _CLOSERS) - (kind in _OPENERS)
            if kind == "==" and depth == 0:
                return messages.comparison_for_definition(tokens.span(index))
        if first > 1 and tokens.kinds[first - 1] == "_NEWLINE":
            if tokens.kinds[first] in ("-", "(", "{", "{|", "#", "SEQUENCE_OPEN"):
                return messages.line_begins_declaration(tokens.span(first), tokens.span(first - 2))
            if tokens.span(first).column > 1 and len(tokens.kinds) > first:
                return messages.line_continues_nothing(tokens.span(first), tokens.span(first - 2))
        return messages.expression_alone(
            self.source.span(tokens.starts[first], tokens.ends[self.index - 1]), self._found()
        )

    def _definition_sign(self) -> ParsingMistake | Diagnostic | None:
        if self.kind != "=":
            return None
        if self.previous in KEYWORDS:
            return messages.reserved_word(self.tokens.span(self.index - 1))
        # Is this the sign of a new definition, read as part of the one before because that is not complete?
        head = self.last_head()
        if head and self.tokens.kinds[head - 1] not in OPERAND_ENDS:
            before = stack_before(self.table, "script", self.tokens.kinds, head)
            wanted = ParsingSituation(self.table, self.tokens, head, before)._wanted()
            return ParsingMistake(self._cut_short(head, wanted), head)
        if self.previous not in OPERAND_ENDS:
            return None
        return messages.definition_sign_in_expression(self.tokens.span(self.index))

    def _behind_sequence(self) -> Diagnostic | None:
        """``<x | x <- s, x>2>``: the sequence ended too early."""
        tokens, index = self.tokens, self.index
        if self.previous != "SEQUENCE_CLOSE" or self.kind not in _OPERAND_STARTS:
            return None
        line = tokens.span(index).line
        later = index + 1
        while tokens.kinds[later] not in ("$END", ">", "SEQUENCE_CLOSE") and tokens.span(later).line == line:
            later += 1
        if tokens.kinds[later] not in (">", "SEQUENCE_CLOSE"):
            return None
        opening, depth = index - 1, 0
        while True:
            depth += (tokens.kinds[opening] == "SEQUENCE_CLOSE") - (tokens.kinds[opening] == "SEQUENCE_OPEN")
            if depth == 0:
                break
            opening -= 1
        return messages.greater_closes_sequence(
            tokens.span(index), self._found(), tokens.span(index - 1), tokens.span(opening)
        )

    def _reserved_word(self) -> Diagnostic | None:
        if self.kind not in KEYWORDS or not accepts(self.table, self.stack, "NAME"):
            return None
        follower = self.tokens.kinds[self.index + 1] if self.kind != "$END" else ""
        named = expected(self.table, self.stack) <= {"NAME", "QUALIFIED"}
        # `x = channel + 1`, `f(assert)`, but not `if then`: there something else is missing before the word.
        if named or (self.kind in DECLARATION_KEYWORDS and not self.first_on_line(self.index)) or follower == "=":
            return messages.reserved_word(self.tokens.span(self.index))
        return None

    def _keyword_before(self) -> Diagnostic | None:
        """``f(let)``: the word before was meant as a name."""
        if self.previous in KEYWORDS - {"true", "false"} and self.kind in (")", ",", "]", "}"):
            return messages.reserved_word(self.tokens.span(self.index - 1))
        return None

    def _module_header(self) -> Diagnostic | None:
        wanted = expected(self.table, self.stack)
        if "_NEWLINE" in wanted and wanted <= {"_NEWLINE", "("}:
            return messages.module_header(self.tokens.span(self.index), self._found())
        return None

    def _missing_word(self) -> Diagnostic | None:
        if not self.unfinished or self.previous not in OPERAND_ENDS:
            return None
        opener = self.unfinished[0]
        if self.tokens.kinds[opener] in _CLOSERS or self.tokens.kinds[opener] == "let":
            return None
        return self._unfinished_construct(opener, self.index)

    def first_on_line(self, index: int) -> bool:
        """Whether only blanks stand before a token on its line."""
        start = self.tokens.starts[index]
        return not self.source.text[self.source.text.rfind("\n", 0, start) + 1 : start].strip()

    # --- words -----------------------------------------------------------------------------------------------

    def _wanted(self) -> list[str]:
        """What could have come, in words, the most telling first and few of them."""
        kinds = expected(self.table, self.stack)
        if "channel" in kinds:
            return [_DECLARATION]
        if "INT" in kinds:
            return ["a process" if self.previous in ("->", "&", "[]", "|~|", "|||") else "an expression"]
        words = []
        if kinds & {"{", "SEQUENCE_OPEN"}:
            words.append("a type")
        elif "NAME" in kinds:
            words.append("a name")
        elif "STRING" in kinds:
            words.append("a file name in quotes")
        if self.open_bracket is not None:
            closer = _CLOSERS[self.tokens.kinds[self.open_bracket]]
            if closer in kinds:
                words.append(f"`{self._closer(self.open_bracket)}`")
            if "|>" in kinds and self.tokens.kinds[self.open_bracket] == "[|":
                words.append("`|>`")
            if "||" in kinds:
                words.append("`||`")
        operator = "+" in kinds or "[]" in kinds
        words += [f"`{kind}`" for kind in _TELLING if kind in kinds]
        if "->" in kinds and "&" not in kinds:
            words.append("`->`")
        if "[" in kinds and not operator:
            words.append("`[`")
        if operator:
            words.append("an operator")
        if "_NEWLINE" in kinds:
            words.append("a new line")
        return words[:4]

    def _hint(self) -> str | None:
        """What to try, for some frequent mistakes."""
        bracket = "" if self.open_bracket is None else self.tokens.kinds[self.open_bracket]
        match self.kind:
            case "::":
                return "a type annotation stands alone: `name :: type`"
            case ":" if bracket == "":
                return "a type is given by a declaration of its own: `name :: type`"
            case "|" if bracket == "[|":
                return "`[|` is closed by `|]`"
            case "|" if self.previous in OPERAND_ENDS:
                return "`[]` is external choice, `|~|` internal choice, `|||` interleaving"
            case "||" if bracket == "[":
                return "`[ A || B ]` stands between two processes"
            case "||":
                return "write `P [| A |] Q` or `P [ A || B ] Q`, or `P ||| Q` if they share no events"
            case "," | "]" if bracket == "[":
                return "a sequence is written `<1, 2>`, a set `{1, 2}`"
            case "exports" | "endmodule":
                return f"`{self.kind}` belongs to a `module`"
            case "if" | "let" | "\\" if self.previous in ("!", "?", "$", ":"):
                return "put it in brackets"
            case "NAME" if self.previous == "NAME" and self.declaration_start() == self.index - 1:
                close = suggestions(self.tokens.text(self.index - 1), PARAGRAPH_WORDS)
                return (
                    f"did you mean {quoted([f'{word} {self.tokens.text(self.index)}' for word in close])}?"
                    if close
                    else None
                )
            case "NAME" if self.tokens.text(self.index) == "where":
                return "local definitions are written `let definitions within expression`"
        return None
