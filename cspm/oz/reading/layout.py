"""Laying out the tokens of a paragraph for the grammar: where lines and sections begin, and what only neighbours tell.

The lexers of text and of markup give the same tokens; here they become the terminals of ``grammar/oz.lark``:

* Outside brackets a line is a conjunct or a declaration of its own, so ``_NEWLINE`` stands between it and the one
  before, unless that ends with what needs more, or it begins with what goes on (an infix operator other than ``-``).
  In brackets lines are layout, and ``_BREAK`` tells where one begins that does not go on with the one before: only
  schema texts have a meaning for that.
* The lines of a class from one that begins an equation to the next section are one token, which CSPm's grammar reads.
* Operators are named after where they stand, brackets after what stands before or behind them, and names that are
  declared are told from names that are used, all by looking at the next few tokens.

A section begins where the lexer says so, whatever is open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from cspcheck.cspm.oz.reading.lexer import BINDERS, INFIX, NAMING, POSTFIX, PREFIX, Token, continues
from cspcheck.cspm.oz.reading.precedence import DISTRIBUTED
from cspcheck.cspm.parsing.lexer import Tokens
from cspcheck.cspm.source import Source

CLOSERS: Final = {"(": ")", "{": "}", "[": "]", "[[": "]]", "(|": "|)", "<<": ">>", "SEQUENCE_OPEN": "SEQUENCE_CLOSE"}
_QUOTED: Final = frozenset(["=", "in", "and", "or", "-", "\\", "/", "comp"])
"""Infix operators that have another meaning as well."""

_GOES_ON: Final = frozenset([",", ";", ":", ".", "==", "::="])
"""Signs that begin a line and go on with the one before, beside infix operators."""

_OPERATION_GOES_ON: Final = frozenset(["[]", "||", "||!", "@"])
COMPLETE: Final = frozenset(
    [
        *("NAME", "DECLARED", "WORD", "INT", "REAL", "true", "false", "EMPTY", "POSTFIX", "LITERAL", "BAD", "VIEW_OF"),
        *(CLOSERS.values()),
        *("UNREAD", "UNREAD_SECTION"),
    ]
)
"""Terminals behind which nothing more is needed."""

_ARGUMENT_STARTS: Final = frozenset(
    ["NAME", "INT", "REAL", "true", "false", "EMPTY", "(", "{", "[[", "SEQUENCE_OPEN", "(|", "LITERAL"]
)
_APPLIED_TO: Final = _ARGUMENT_STARTS | set(PREFIX) | set(BINDERS) | {"if", "let"}


class Laid(Tokens):
    """The terminals of a paragraph.

    Attributes:
        found: the tokens that it was laid out from.
        origins: for each terminal the place of its token in *found*; for one that stands for none, of the next.
        lines: for each terminal where the line begins that it stands in; -1 outside lines of predicates and
            declarations.
        sections: for each terminal where the section of a class begins that it stands in; -1 outside.
        declaring: where the lines begin that are declarations.
    """

    __slots__ = ("declaring", "found", "lines", "origins", "sections")

    def __init__(self, source: Source, found: Sequence[Token]) -> None:
        super().__init__(source)
        self.found = found
        self.origins: list[int] = []
        self.lines: list[int] = []
        self.sections: list[int] = []
        self.declaring: set[int] = set()

    def includes(self, at: int) -> bool:
        """Whether a line of declarations includes a schema: ``S``, ``S'``, ``S[T]``, ``Xi S``, ``[x : T | p]``."""
        token, following = self.found[at], self.found[min(at + 1, len(self.found) - 1)]
        if token.kind == "[":
            return True
        if token.kind != "NAME":
            return False
        if token.value in ("Delta", "Xi") and following.kind == "NAME" and not following.first:
            return self.found[min(at + 2, len(self.found) - 1)].kind not in (":", ",")
        return following.first or following.section or following.kind in (";", "[")


class OpenFrame:
    """What is open: a bracket or the paragraph.

    Attributes:
        opener: the kind of the bracket.
        start: whether such a declaration begins with the next token.
        listing: whether the next name goes on with its names.
        binders: the binders that wait for their ``@``, innermost last: whether each declares its names still.
        conditionals: how many ``if`` wait for their ``else``.
    """

    __slots__ = ("binders", "conditionals", "listing", "opener", "start")

    def __init__(self, opener: str) -> None:
        self.opener = opener
        self.start = self.listing = False
        self.binders: list[bool] = []
        self.conditionals = 0

    @property
    def declaring(self) -> bool:
        """Whether a binder declares its names."""
        return bool(self.binders) and self.binders[-1]

    def binds(self) -> None:
        """A binder begins."""
        self.start = True
        self.binders.append(True)

    def goes_on(self, kind: str) -> bool:
        """Whether a token that begins a line goes on with what a binder or a conditional began."""
        if kind in ("|", "@"):
            return bool(self.binders)
        return kind in ("then", "else") and self.conditionals > 0


class LineLayout:
    """Lays out the lines of a paragraph; *column* tells how far a token is indented."""

    def __init__(self, source: Source, found: Sequence[Token], column: Callable[[Token], int]) -> None:
        self.tokens = found
        self.column = column
        self.laid = Laid(source, found)
        self._line = self._section = -1
        self._anew = False  # what comes next goes on with nothing
        self._frames = [OpenFrame("")]
        self._declares = _declares(found)

    def declares(self, at: int) -> bool:
        """Whether ``x, y :`` begins with a token."""
        return self._declares[at]

    # --- terminals -------------------------------------------------------------------------------------------

    def _emit(self, kind: str, at: int, end: int | None = None) -> None:
        token = self.tokens[at]
        laid = self.laid
        laid.kinds.append(kind)
        laid.starts.append(token.start)
        laid.ends.append(token.end if end is None else end)
        laid.origins.append(at)
        laid.lines.append(self._line)
        laid.sections.append(self._section)

    def _gap(self, kind: str, at: int) -> None:
        """A terminal that stands for no token, behind the last one."""
        laid = self.laid
        place = laid.ends[-1]
        laid.kinds.append(kind)
        laid.starts.append(place)
        laid.ends.append(place)
        laid.origins.append(at)
        laid.lines.append(self._line)
        laid.sections.append(self._section)

    @property
    def _last(self) -> str:
        return self.laid.kinds[-1] if self.laid.kinds else ""

    def _peek(self, at: int) -> Token:
        return self.tokens[min(at, len(self.tokens) - 1)]

    def _closed(self) -> None:
        """No bracket goes over the beginning of a section or a line of its own."""
        self._frames = [OpenFrame("")]

    # --- lines -----------------------------------------------------------------------------------------------

    def _begins_line(self, at: int, *, operation: bool = False, names: bool = False) -> bool:
        """Whether a token begins a line that does not go on with the one before."""
        token = self.tokens[at]
        if not token.first or self._last not in COMPLETE:
            return False
        if self._last in ("UNREAD", "UNREAD_SECTION"):
            return True
        if token.kind in _GOES_ON or self._frames[-1].goes_on(token.kind):
            return names and (token.kind in (".", "==", "::=") or (self._last == "]" and token.kind != ";"))
        if operation and token.kind in _OPERATION_GOES_ON:
            return False
        if len(self._frames) > 1:
            return not (token.kind in INFIX or token.kind in CLOSERS.values() or token.kind in ("|", "@", "inrel"))
        return not continues(token)

    def _one_line(self, at: int, *, operation: bool = False, definition: bool = False, names: bool = False) -> int:
        """Lay out a line from a token on; where the next one begins."""
        while not self.tokens[at].section:
            token = self.tokens[at]
            if self._begins_line(at, operation=operation, names=names):
                if len(self._frames) == 1:
                    break
                self._gap("_BREAK", at)
            if len(self._frames) == 1 and not operation and not self._frames[-1].declaring:
                following = self._peek(at + 1)
                if definition and token.kind in (";", ">>") and not token.first and not following.section:
                    self._emit("_COMPOSES" if token.kind == ";" else "_PIPES", at)
                    at += 1
                    continue
                if token.kind == ";":
                    self._emit(";", at)
                    return at + 1
            self._term(at, operation=operation)
            at += 1
        self._closed()
        return at

    def _declarations(self, at: int, *, only: bool = False) -> int:
        """Lay out declarations up to the next section; with *only* up to a line that is none."""
        first = len(self.laid.lines)
        at = self._lines(at, only_declarations=only)
        self.laid.declaring.update(self.laid.lines[first:])
        return at

    def _lines(self, at: int, *, only_declarations: bool = False) -> int:
        """Lay out lines up to the next section; with *only_declarations* up to one that does not declare."""
        self._line, self._anew = at, True
        behind = True  # at the beginning of what is read
        while not self.tokens[at].section:
            token = self.tokens[at]
            new = not behind and self._begins_line(at)
            if (
                only_declarations
                and token.first
                and (behind or (new and len(self._frames) == 1))
                and not (self._declares[at] or token.kind == "UNREAD")
            ):
                break
            behind = False
            if new:
                if len(self._frames) > 1:
                    self._gap("_BREAK", at)
                else:
                    self._gap("_NEWLINE", at)
                    if not self._frames[-1].conditionals:  # else a conjunct between `then` and `else`
                        self._closed()
                        self._line = at
            if token.kind == ";" and len(self._frames) == 1 and not self._frames[-1].declaring:
                self._emit(";", at)
                self._closed()
                self._line = at + 1
                behind = True
            else:
                self._term(at)
            self._anew = behind
            at += 1
        self._closed()
        self._line, self._anew = -1, False
        return at

    def _where(self, at: int) -> int:
        """Lay out ``where`` and the predicates behind it, if they are there."""
        if self.tokens[at].kind != "where":
            return at
        self._emit("where", at)
        return self._lines(at + 1)

    # --- terms -----------------------------------------------------------------------------------------------

    def _term(self, at: int, *, operation: bool = False) -> None:
        """Lay out a token of a term."""
        token = self.tokens[at]
        frame = self._frames[-1]
        start, frame.start = frame.start, False
        kind = token.kind
        if operation and self._last == "[" and token.value == "Delta":
            kind = "Delta"
        elif kind == "NAME" or kind in NAMING:
            kind = self._name(at, frame, start)
        elif kind in PREFIX:
            kind = "-" if kind == "-" else "PREFIX"
        elif kind in INFIX:
            if operation and kind in DISTRIBUTED and self._last not in COMPLETE:
                frame.binds()
            kind = kind if kind in _QUOTED else "INFIX"
        elif kind in POSTFIX:
            kind = "POSTFIX"
        elif kind in CLOSERS:
            self._opened(at)
            return
        elif kind == CLOSERS.get(frame.opener):
            self._frames.pop()
        elif kind in BINDERS or kind == "let":
            frame.binds()
        elif kind in ("|", "@") and frame.binders:
            if kind == "|":
                frame.binders[-1] = False
            else:
                frame.binders.pop()
        elif kind in ("if", "else"):
            frame.conditionals += 1 if kind == "if" else -1
        elif operation and kind in DISTRIBUTED and self._last not in COMPLETE:
            frame.binds()
        elif kind == ";":
            frame.start = frame.declaring
        self._emit(kind, at)

    def _name(self, at: int, frame: OpenFrame, start: bool) -> str:
        """What a name, or an operator that may be one, is."""
        following = self._peek(at + 1).kind
        if self._declares[at]:
            return "DECLARED"
        if frame.listing or (start and following in ("in", ",")):
            frame.listing = following == ","
            return "DECLARED"
        if self.tokens[at].kind == "NAME":
            return "NAME"
        return "PREFIX" if self._applies(at) else "WORD"

    def _applies(self, at: int) -> bool:
        """Whether the operator that is a word has something to be applied to; else it is a name, such as ``id``."""
        following = self._peek(at + 1)
        if following.section or (following.first and len(self._frames) == 1):
            return False
        if following.kind == "[":
            return self._declares[min(at + 2, len(self.tokens) - 1)]  # a schema: `finset [x : nat]`
        return following.kind != "-" and following.kind in _APPLIED_TO

    def _opened(self, at: int) -> None:
        """Lay out an opening bracket: what it is, its neighbours tell."""
        token = self.tokens[at]
        kind = token.kind
        following, second = self._peek(at + 1), self._peek(at + 2)
        behind_operand = self._last in COMPLETE and not token.first and not self._anew
        frame = OpenFrame(kind)
        if kind == "(" and behind_operand and token.tight:
            kind = "_CALL"
        elif kind == "(|" and following.kind == "NAME" and second.kind == "==":
            kind = "_BINDING"
        elif kind == "[" and behind_operand:
            tight = token.tight and self._last == "NAME" and self.laid.kinds[-2:-1] != ["."]
            kind = "_RENAMING" if self._renames(at) else "_GENERICS" if tight else "["
        elif kind == "{" and self._declares[min(at + 1, len(self.tokens) - 1)]:
            kind = "_COMPREHENSION"
            frame.binders.append(True)
        elif kind == "{" and following.kind == "NAME" and second.kind in ("|", "@", ";"):
            kind = "_SCHEMA_SET"
            frame.binds()
        self._emit(kind, at)
        self._frames.append(frame)

    def _renames(self, at: int) -> bool:
        """Whether ``[new/old`` begins here."""
        kinds = [self._peek(at + distance).kind for distance in range(1, 5)]
        return kinds[:3] == ["NAME", "/", "NAME"] and kinds[3] in (",", "]")


def _declares(tokens: Sequence[Token]) -> list[bool]:
    """For each token whether ``x, y :`` begins with it."""
    found = [False] * (len(tokens) + 2)
    for at in range(len(tokens) - 2, -1, -1):
        kind = tokens[at].kind
        if kind == "NAME" or kind in NAMING:
            following = tokens[at + 1].kind
            found[at] = following == ":" or (following == "," and found[at + 2])
    return found
