"""What to say about a token of a paragraph that does not fit, and where to go on reading.

The table knows which terminals could have come instead, and its stack what is unfinished. After a mistake in a line of
predicates or declarations the next line is read, after one elsewhere in a class the next section, and after any other
nothing more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.layout import CLOSERS, Laid
from cspcheck.cspm.oz.reading.lexer import NAMING, RESERVED, Token
from cspcheck.cspm.oz.reading.outline import BEHIND, MISPLACED, SECTIONS, TWO_WORDS, UNKNOWN_SECTION, ParagraphLayout
from cspcheck.cspm.parsing import class_messages
from cspcheck.cspm.parsing.driver import Open, accepts, stack_before
from cspcheck.cspm.parsing.lexer import DECLARATION_KEYWORDS
from cspcheck.cspm.parsing.table import Table
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

OPERATOR: Final = "an operator"
LINE: Final = "a new line"

_OPENED_BY: Final[dict[str, frozenset[str]]] = {
    ")": frozenset(["(", "_CALL"]),
    "]": frozenset(["[", "_GENERICS", "_RENAMING"]),
    "}": frozenset(["{", "_COMPREHENSION", "_SCHEMA_SET"]),
    "]]": frozenset(["[["]),
    "|)": frozenset(["(|", "_BINDING"]),
    ">>": frozenset(["<<"]),
    "SEQUENCE_CLOSE": frozenset(["SEQUENCE_OPEN"]),
}
_BRACKETS: Final = frozenset().union(*_OPENED_BY.values())
_COMPREHENSIONS: Final = frozenset(["_COMPREHENSION", "_SCHEMA_SET"])
_QUANTIFIERS: Final = frozenset(["forall", "exists", "exists1"])
_BINDERS: Final = frozenset([*_QUANTIFIERS, "lambda", "mu", "let", *_COMPREHENSIONS])

_IN_BRACKETS: Final[dict[str, tuple[str, ...]]] = {
    "_CALL": ("`)`", "`,`", OPERATOR),
    "_GENERICS": ("`]`", "`,`"),
    "_RENAMING": ("`]`", "`,`"),
    "_COMPREHENSION": ("`}`", "`|`", "`@`"),
    "_SCHEMA_SET": ("`}`", "`|`", "`@`"),
    "[[": ("`]]`", "`,`", OPERATOR),
    "(|": ("`|)`", OPERATOR),
    "_BINDING": ("`|)`", "`,`"),
    "<<": ("`>>`", OPERATOR),
    "SEQUENCE_OPEN": ("`>`", "`,`", OPERATOR),
}
"""What can stand behind what is complete in a bracket."""

_RETRIEVE: Final = "a retrieve relation is written `retrieve R between A and C where ... end`"
_RENAMING: Final = "a renaming is written `[new/old]`"
_READING: Final = "a reading is written `reading real = {-1, 0, 1}`"
_QUANTIFIER: Final = "a quantifier is written `forall x : T | condition @ predicate`"
_DISTRIBUTED: Final = "a distributed operation is written `[] x : S @ Op`"
_BRACKET_LINES: Final = "inside brackets lines are not separate; write `and` between conjuncts"


class ReadingMistake(NamedTuple):
    """A diagnostic, the token at which it shows, and what to pass over: from the token ``start`` to before ``resume``.

    ``resume`` None: nothing can be read, or, if ``start`` is not the first token, all that stands behind a complete
    paragraph is passed over. ``line``: what is passed over stands for a line of predicates or declarations, and not
    for a section.
    """

    diagnostic: Diagnostic
    shows: int
    start: int
    resume: int | None
    line: bool = False


def diagnose(table: Table, layout: ParagraphLayout, index: int) -> ReadingMistake:
    """What to say about the terminal at *index*, which the grammar does not admit, or not what it stands for."""
    return _Situation(table, layout, index).finding()


class _Situation:
    """A terminal that does not fit with all that is known about it."""

    def __init__(self, table: Table, layout: ParagraphLayout, index: int) -> None:
        laid = layout.laid
        if index and self._decorated(table, laid, index):
            index -= 1
        self.table = table
        self.layout = layout
        self.laid: Laid = laid
        self.tokens = laid.found
        self.index = index
        self.at = laid.origins[index]
        self.token = self.tokens[self.at]
        self.kinds = laid.kinds
        self.stack: Open = stack_before(table, "paragraph", laid.kinds, index)
        self.before = laid.kinds[index - 1] if index else ""
        self.unit = self._unit()
        self.line = laid.lines[self.unit]
        if self.line == self.at and self.before not in ("_NEWLINE", ";") and not self.accepts("UNREAD"):
            self.line = -1  # what stands before the first line is not complete
        self.section = laid.sections[self.unit]
        self.open = self._open()

    @staticmethod
    def _decorated(table: Table, laid: Laid, index: int) -> bool:
        """Whether the terminal before is a name that should have no decoration."""
        stack = stack_before(table, "paragraph", laid.kinds, index)
        if stack.symbols[-1] != index - 1 or laid.kinds[index - 1] not in ("NAME", "DEFINED"):
            return False
        if not laid.found[laid.origins[index - 1]].decoration:
            return False
        return not any(accepts(table, stack, kind) for kind in ("INFIX", ".", ":", "/"))

    # --- what is known ---------------------------------------------------------------------------------------

    def accepts(self, *kinds: str) -> bool:
        """Whether a terminal of one of *kinds* could come."""
        return any(accepts(self.table, self.stack, kind) for kind in kinds)

    @property
    def complete(self) -> bool:
        """Whether the section or the paragraph before the terminal is complete."""
        return self.accepts("EQUATIONS", "$END")

    def _unit(self) -> int:
        """A terminal of the line or section that is wrong: the one before, where that is cut short."""
        laid, index = self.laid, self.index
        if index == 0 or (self.kinds[index] == TWO_WORDS and self.before == "op"):
            return index
        begins = self.token.section or laid.sections[index] != laid.sections[index - 1]
        return index - 1 if begins and not self.complete else index

    def _open(self) -> list[int]:
        """The tokens of the brackets that are open in the line or section, innermost last."""
        laid, found = self.laid, []
        for place in range(self.index):
            if laid.lines[place] != self.line or laid.sections[place] != self.section:
                continue
            at = laid.origins[place]
            kind = self.tokens[at].kind
            if laid.starts[place] == laid.ends[place]:
                continue
            if kind in CLOSERS:
                found.append(at)
            elif found and CLOSERS[self.tokens[found[-1]].kind] == kind:
                found.pop()
        return found

    @property
    def word(self) -> str:
        """The word that begins the section, or else the paragraph."""
        if self.section < 0:
            return self.kinds[0]
        return next(self.kinds[i] for i, at in enumerate(self.laid.origins) if at == self.section)

    def _unfinished(self) -> int | None:
        """The innermost terminal that began what is not finished behind something complete; None: nothing is."""
        kinds = self.kinds
        skip: list[frozenset[str]] = []
        for symbol in reversed(self.stack.symbols):
            if not isinstance(symbol, int):
                continue
            kind = kinds[symbol]
            if skip:
                if kind in skip[-1]:
                    done = skip.pop()
                    if kind in _COMPREHENSIONS and done is _BINDERS and not skip:
                        return symbol
                    continue
                if kind in _OPENED_BY:
                    skip.append(_OPENED_BY[kind])
            elif kind in _OPENED_BY:
                skip.append(_OPENED_BY[kind])
            elif kind == "@":
                skip.append(_BINDERS)
            elif kind == "else":
                skip.append(frozenset(["if"]))
            elif kind in _BRACKETS or kind in ("if", "then", "lambda", "let") or kind in _QUANTIFIERS:
                return symbol
        return None

    # --- where to go on --------------------------------------------------------------------------------------

    def finding(self) -> ReadingMistake:
        """The diagnostic, and where to go on."""
        kind = self.kinds[self.index]
        if kind == MISPLACED and self.complete:
            return ReadingMistake(self._misplaced(), self.at, self.at, self._next_section(self.at + 1, every=True))
        if self.line >= 0:
            start = self.line
            if self._begins_anew():
                start = self.at
            declares = self.line in self.laid.declaring
            if declares and self._no_declaration_at(start):
                resume = self._skip_line(start, start, 0)
                return ReadingMistake(self._no_declaration(start), start, start, resume, line=True)
            diagnostic = self._wrong(start != self.line)
            resume = self._skip_line(start, self.at, len(self.open))
            return ReadingMistake(diagnostic, self.at, start, resume, line=True)
        diagnostic = self._wrong(False)
        if self.section < 0:
            return ReadingMistake(diagnostic, self.at, self.at if self.complete else 0, None)
        resume = self._skip_line(self.section, self.at, len(self.open))
        return ReadingMistake(diagnostic, self.at, self.section, self._next_section(resume))

    def _begins_anew(self) -> bool:
        """Whether the line before is complete, and what begins this one goes on with nothing."""
        if not self.token.first or self.token.section or self.open or self.at == self.line:
            return False
        return self.accepts("_NEWLINE") and self.kinds[self.index] != "_NEWLINE"

    def _skip_line(self, start: int, at: int, depth: int) -> int:
        """The next line that begins no deeper than the one of the token *start*, or section."""
        column = self.layout.column(self.tokens[start])
        while True:
            token = self.tokens[at]
            if token.section and (token.kind == "$END" or at > start):
                return at
            if token.first and at > start and depth <= 0 and self.layout.column(token) <= column:
                return at
            depth += (token.kind in CLOSERS) - (token.kind in CLOSERS.values())
            at += 1

    def _next_section(self, at: int, *, every: bool = False) -> int:
        """The next section from a token on; with *every* also a part of one, which ``where`` or ``Delta`` begins."""
        while True:
            token = self.tokens[at]
            part = token.kind == "where" or (token.kind == "NAME" and token.value == "Delta")
            if token.section and (every or not part):
                return at
            at += 1

    # --- what to say -----------------------------------------------------------------------------------------

    def _span(self, token: Token) -> Span:
        return self.laid.source.span(token.start, token.end)

    def _found(self, token: Token) -> str:
        """A token in words."""
        text = self.laid.source.text[token.start : token.end]
        text = text if len(text) <= 40 else text[:37] + "..."
        if token.kind == "$END":
            return "the end of the paragraph"
        if token.kind == "NAME" and not token.section:
            return f"name `{text}`"
        if token.kind in ("INT", "REAL"):
            return f"number `{text}`"
        return f"`{text}`"

    def _refuse(self, *wanted: str, help: str | None = None) -> Diagnostic:
        """The token stands where one of *wanted* was due."""
        token = self.token
        words = self._found(token)
        if token.kind == "LITERAL":
            return messages.literal(self._span(token))
        opener = self.tokens[self.open[-1]] if self.open else None
        closes = token.kind in CLOSERS.values() and (opener is None or token.kind != CLOSERS[opener.kind])
        if opener is not None and (token.section or closes):
            closer = {"SEQUENCE_CLOSE": ">"}.get(CLOSERS[opener.kind], CLOSERS[opener.kind])
            compares = opener.first and closer == ">" and len(self.open) == 1
            return messages.unclosed_bracket(self._span(opener), closer, self._span(token), words, compares=compares)
        labels: tuple[Label, ...] = ()
        if opener is not None:
            labels = (Label(self._span(opener), "inside this bracket"),)
            if token.first and help is None:
                help = _BRACKET_LINES
        return messages.unexpected(self._span(token), words, wanted, labels=labels, help=help)

    def _wrong(self, anew: bool) -> Diagnostic:
        kind = self.kinds[self.index]
        special = self._special(kind)
        if special is not None:
            return special
        if anew:
            return self._refuse("an expression")
        if self.before == ".":
            if self.word == "op" and not self.accepts("INT"):
                return self._no_name("the name of an operation")
            return self._refuse("the name of a component")
        if not self.accepts("INFIX"):
            if self.accepts("INT"):
                return self._refuse("an expression")
            if self.accepts("DECLARED", "NAME", "RELATION") or self.index == 0:
                return self._name_due()
        return self._behind_something()

    def _special(self, kind: str) -> Diagnostic | None:
        """What has a message of its own."""
        token = self.token
        if kind == BEHIND and token.kind != "end" and self.complete:
            return self._refuse(OPERATOR, LINE)
        if kind == TWO_WORDS and self.unit == self.index:
            return self._two_words(self.at)
        if kind == UNKNOWN_SECTION and self.complete:
            word = str(token.value)
            if word in DECLARATION_KEYWORDS:
                return messages.not_in_class(self._span(token), word)
            return messages.unknown_section(self._span(token), word, suggestions(word, SECTIONS))
        if self.before == "Delta" and self.accepts("("):
            return messages.delta_without_brackets(self.laid.span(self.index - 1))
        if self.before == ":" and self.accepts("[") and not self.accepts("INT"):
            names = [self.laid.text(i) for i in range(self.index) if self.laid.sections[i] == self.section]
            return messages.parameters_without_brackets(self._span(token), " ".join(names[1:-1]).replace(" ,", ","))
        if self.accepts("$END") and self.section < 0 and token.kind == "end" and self.line < 0:
            return class_messages.end_too_many(self._span(token))
        return None

    def _two_words(self, at: int) -> Diagnostic:
        first, second = self.tokens[at], self.tokens[at + 1]
        span = self.laid.source.span(first.start, second.end)
        return messages.schema_in_two_words(span, str(first.value), str(second.value))

    def _misplaced(self) -> Diagnostic:
        before = self.at - 2
        if before >= 0 and self.tokens[before].first and self.layout.two_words(before):
            return self._two_words(before)  # read as one more predicate of the section before
        words = self._found(self.token)
        return messages.unexpected(self._span(self.token), words, ["a section of the class"])

    def _no_declaration_at(self, start: int) -> bool:
        known = self.layout.declares(start) or self.laid.includes(start)
        return not known and self.tokens[start].kind != "UNREAD"

    def _no_declaration(self, start: int) -> Diagnostic:
        token, following = self.tokens[start], self.tokens[start + 1]
        if following.kind in (":", ",") and token.kind != "NAME" and token.kind not in NAMING:
            self.token, self.at, self.open = token, start, []
            return self._no_name("a name")
        place = start
        while not self.tokens[place].section:
            place += 1
        return messages.no_declaration(self._span(token), self.tokens[place].kind == "where")

    def _no_name(self, wanted: str) -> Diagnostic:
        """A name is due."""
        token = self.token
        if token.kind == "NAME" and token.decoration and not token.section:
            return self._refuse(f"{wanted} without decoration")
        text = self.laid.source.text[token.start : token.end]
        if text in RESERVED and not token.section:
            return messages.reserved_word(self._span(token), text)
        return self._refuse(wanted)

    def _name_due(self) -> Diagnostic:
        """What is due where only a name can stand, or an operation."""
        word, before = self.word, self.before
        if word == "retrieve":
            names = {"between": "the name of the abstract class", "and": "the name of the concrete class"}
            return self._no_name(names.get(before, "a name"))
        if word == "op" and before == "op":
            return self._no_name("the name of an operation")
        if word == "inherit":
            renames = bool(self.open) and self.tokens[self.open[-1]].kind == "["
            if not renames:
                return self._no_name("the name of a class")
            return self._no_name("the old name" if before == "/" else "the new name")
        if self.accepts("[") and word == "op" and self.line < 0:
            return self._refuse("the name of an operation")
        return self._no_name("a name")

    def _behind_something(self) -> Diagnostic:
        """What could stand behind something complete."""
        word = self.word
        if word == "retrieve" and self.line < 0:
            wanted = next((kind for kind in ("between", "and", "where") if self.accepts(kind)), None)
            if wanted is not None:
                return self._refuse(f"`{wanted}`", help=_RETRIEVE)
        if word == "view" and not self.complete:
            return self._refuse("`control`", "`data`")
        if self.accepts(":") and not self.accepts("EQUATIONS"):
            return self._refuse("`:`", "`,`")
        if self.accepts("/") and not self.accepts("INFIX"):
            return self._refuse("`/`", help=_RENAMING)
        if self.accepts("==") and not self.accepts("INFIX"):
            return self._refuse("`==`", *(["`::=`"] if self.accepts("::=") else []))
        if self.before == "\\" and self.accepts("{"):
            return self._refuse("`(`")
        opener = self._unfinished()
        if opener is None:
            if word == "reading" and "_READ_AS" not in self.kinds[: self.index]:
                return self._refuse("`=`", help=_READING)
            distributed = self.word == "op" and self.accepts("@") and not self.accepts("||")
            if distributed:
                return self._refuse("`@`", "`|`", help=_DISTRIBUTED)
            return self._refuse(OPERATOR, LINE)
        return self._inside(opener)

    def _inside(self, opener: int) -> Diagnostic:
        """What could stand behind something complete in what the terminal *opener* began."""
        kind = self.kinds[opener]
        before = self.kinds[opener - 1] if opener else ""
        if kind in _QUANTIFIERS:
            return self._refuse("`@`", "`|`", help=_QUANTIFIER)
        match kind:
            case "lambda":
                return self._refuse("`@`", "`|`")
            case "let":
                return self._refuse("`@`", "`;`")
            case "if":
                return self._refuse("`then`", OPERATOR)
            case "then":
                return self._refuse("`else`", OPERATOR, help="every `if` has its `else`")
            case "(":
                if before in ("visible", "Delta") or (before == "\\" and self.word == "op" and self.line < 0):
                    return self._refuse("`)`", "`,`")
                return self._refuse("`)`", *(["`,`"] if self.accepts(",") else []), OPERATOR)
            case "{":
                hides = before == "\\" and self.word == "op" and self.line < 0
                return self._refuse("`}`", "`,`", *([] if hides else [OPERATOR]))
            case "[":
                if self.word in ("chan", "method", "local_chan") and before == ":":
                    return self._refuse("`]`", "`;`")
                if self.accepts(";", "|", "_BREAK"):
                    return self._refuse("`]`", "`|`", "`;`")
                return self._refuse("`]`", "`,`")
        return self._refuse(*_IN_BRACKETS[kind])


def order(found: Sequence[tuple[float, Diagnostic]]) -> list[Diagnostic]:
    """Diagnostics by the place in the text at which they show, each once."""
    told: list[Diagnostic] = []
    for _, diagnostic in sorted(found, key=lambda item: item[0]):
        if diagnostic not in told:
            told.append(diagnostic)
    return told
