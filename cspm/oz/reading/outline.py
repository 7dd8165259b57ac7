"""The outline of a paragraph: which sections it has, which of them are lines, and where the equations of a class stand.

What begins a section, the lexers have marked; the rest of the layout is in :mod:`cspcheck.cspm.oz.reading.layout`.
"""

from __future__ import annotations

from typing import Final

from cspcheck.cspm.oz.reading.layout import COMPLETE, Laid, LineLayout, OpenFrame
from cspcheck.cspm.oz.reading.lexer import INFIX
from cspcheck.cspm.oz.reading.operators import RELATION
from cspcheck.cspm.spelling import suggestions

SECTIONS: Final = (
    *("visible", "inherit", "chan", "method", "local_chan", "given", "const", "schema", "state", "init", "op"),
    "lemma",
)
"""The words that begin a section of a class."""

TWO_WORDS: Final = "TWO_WORDS"
UNKNOWN_SECTION: Final = "UNKNOWN_SECTION"
MISPLACED: Final = "MISPLACED"
BEHIND: Final = "BEHIND"
"""Kinds that the grammar has nowhere: ``enable up``, a line that begins no section, a part of a section alone, what
stands behind a paragraph.
"""

_SCHEMAS: Final = ("com", "enable", "effect")


class ParagraphLayout(LineLayout):
    """Lays out one paragraph."""

    def run(self) -> Laid:
        """Everything."""
        last = len(self.tokens) - 1
        at = self._paragraph() if last else 0
        self._line = self._section = -1
        if at < last:
            self._emit(BEHIND, at)
        self._emit("$END", last)
        return self.laid

    def _refuse(self, kind: str, at: int) -> int:
        """A terminal that the grammar has nowhere; what stands behind it does not matter."""
        self._emit(kind, at)
        return len(self.tokens) - 1

    # --- paragraphs ------------------------------------------------------------------------------------------

    def _paragraph(self) -> int:
        first, second = self.tokens[0], self._peek(1)
        word = str(first.value) if first.kind == "NAME" else ""
        if word == "class" and second.kind == "NAME":
            return self._class()
        if second.kind not in ("==", "::="):
            match word:
                case "given":
                    self._emit(word, 0)
                    return self._one_line(1, names=True)
                case "const":
                    return self._axiom(0, top=True)
                case "schema":
                    return self._schema(0)
                case "reading":
                    return self._reading()
                case "view":
                    self._emit(word, 0)
                    self._emit("VIEW_OF" if second.value in ("control", "data") else second.kind, 1)
                    return 2
                case "retrieve":
                    return self._retrieve()
                case "lemma":
                    return self._lemma(0)
        return self._definition(0)

    def _axiom(self, at: int, *, top: bool) -> int:
        self._emit("const", at)
        at += 1
        if self.tokens[at].kind == "[" and not self.tokens[at].first:
            at = self._generics(at)
        at = self._declarations(at, only=True)
        block = top and self.tokens[at].kind == "where"
        at = self._where(at)
        if block:
            return self._block_end(at)
        if self.tokens[at].kind == "end" and (top or not self._is_last(at)):
            self._emit("_END_OF_SECTION", at)
            return at + 1
        return at

    def _block_end(self, at: int) -> int:
        """Lay out the ``end`` of a block, or that it is missing."""
        if self.tokens[at].kind == "end":
            self._emit("end", at)
            return at + 1
        self._gap("UNCLOSED", at)
        return at

    def _is_last(self, at: int) -> bool:
        """Whether the ``end`` at a place is that of the class."""
        return self._peek(at + 1).kind == "$END"

    def _schema(self, at: int) -> int:
        self._emit("schema", at)
        content = at = self._head(at + 1)
        while True:
            at = self._declarations(at)
            following = self._peek(at + 1)
            includes = self._is_word(at, "Delta") and following.kind == "NAME" and not following.first
            if not includes or self._peek(at + 2).kind in (":", ","):
                break
            self.tokens[at].section = False  # `Delta S` includes a schema
            if at > content and self._last in COMPLETE:
                self._gap("_NEWLINE", at)
        at = self._where(at)
        if self._is_word(at, "init", "INIT"):
            self._emit("init", at)
            at = self._lines(at + 1)
        return self._block_end(at)

    def _is_word(self, at: int, *words: str) -> bool:
        token = self.tokens[at]
        return token.section and token.kind == "NAME" and token.value in words

    def _head(self, at: int) -> int:
        """Lay out the name of a section or block, and generic parameters in brackets; where its content begins."""
        token = self.tokens[at]
        if token.section:
            return at
        self._emit(token.kind, at)
        at += 1
        if self.tokens[at].kind == "[" and not self.tokens[at].first:
            at = self._generics(at)
        return at

    def _generics(self, at: int) -> int:
        self._emit("_GENERICS", at)
        at += 1
        while self.tokens[at].kind in ("NAME", ",") and not self.tokens[at].section:
            self._emit(self.tokens[at].kind, at)
            at += 1
        if not self.tokens[at].section:
            self._emit(self.tokens[at].kind, at)
            at += 1
        return at

    def _reading(self) -> int:
        self._emit("reading", 0)
        at, found = 1, False
        while not self.tokens[at].section and not self._begins_line(at):
            token = self.tokens[at]
            infix = INFIX.get(token.kind)
            if not found and infix is not None and infix.precedence <= RELATION and len(self._frames) == 1:
                found = token.kind == "="
                self._emit("_READ_AS" if found else "BAD", at)
            else:
                self._term(at)
            at += 1
        return at

    def _retrieve(self) -> int:
        self._emit("retrieve", 0)
        at = 1
        while not self.tokens[at].section:
            token = self.tokens[at]
            between = token.kind == "NAME" and token.value == "between" and self._last == "NAME"
            self._emit("between" if between else token.kind, at)
            at += 1
        at = self._where(at)
        return self._block_end(at) if "where" in self.laid.kinds else at

    def _lemma(self, at: int) -> int:
        """Lay out ``lemma N : p`` with what helps to prove it."""
        self._emit("lemma", at)
        at = self._head(at + 1)
        if self.tokens[at].kind == ":" and not self.tokens[at].section:
            self._emit(":", at)
            at = self._one_line(at + 1)
        at = self._using(at)
        if self._is_word(at, "by"):
            for word in ("by", "induction", "on", "NAME"):
                self._emit(word, at)
                at += 1
        return at

    def _using(self, at: int) -> int:
        """Lay out the names of lemmas, with what they are used for, if they are there."""
        if not self._is_word(at, "using"):
            return at
        self._emit("using", at)
        at += 1
        while self.tokens[at].kind in ("NAME", ",") and not self.tokens[at].section:
            if self.tokens[at].first and self.tokens[at - 1].kind != "," and self.tokens[at].kind != ",":
                break
            self._emit(self.tokens[at].kind, at)
            at += 1
            if self.tokens[at].kind == "(" and self._last == "NAME":
                at = self._arguments(at)
        return at

    def _arguments(self, at: int) -> int:
        """Lay out what a lemma is used for: expressions in brackets."""
        self._emit("_CALL", at)
        self._frames.append(OpenFrame("("))
        at += 1
        while len(self._frames) > 1 and not self.tokens[at].section:
            if self._begins_line(at):
                self._gap("_BREAK", at)
            self._term(at)
            at += 1
        self._closed()
        return at

    def _definition(self, at: int) -> int:
        """Lay out ``N == ...``, ``N[X] == ...`` or ``N ::= ...``."""
        token = self.tokens[at]
        self._emit("DEFINED" if token.kind == "NAME" else token.kind, at)
        at += 1
        if self.tokens[at].kind == "[":
            at = self._generics(at)
        sign = self.tokens[at].kind
        if sign == "::=" and self._peek(at + 1).kind == "{":
            sign = "=="
        if self.tokens[at].section:
            return at
        self._emit(sign, at)
        if sign == "::=":
            self._frames[-1].binders.append(False)  # each `|` goes on with the branches
        return self._one_line(at + 1, definition=sign == "==")

    # --- classes ---------------------------------------------------------------------------------------------

    def _class(self) -> int:
        self._emit("class", 0)
        self._emit("BAD" if self.tokens[1].section else "NAME", 1)
        at = 2
        if self.tokens[at].kind == "[":
            at = self._generics(at)
        if self.tokens[at].kind == "NAME" and self.tokens[at].value == "inherit" and self._peek(at + 1).kind == "NAME":
            self.tokens[at].section = True  # the one section that may stand in the line of the name
        while True:
            token = self.tokens[at]
            self._section = at
            self._closed()
            if token.kind == "$END":
                self._gap("UNCLOSED", at)
                return at
            if token.kind == "end":
                self._emit("end" if self._is_last(at) else "STRAY_END", at)
                at += 1
                if self._is_last(at - 1):
                    return at
                continue
            at = self._section_at(at)

    def _section_at(self, at: int) -> int:
        token = self.tokens[at]
        if token.kind == "UNREAD_SECTION":
            self._emit(token.kind, at)
            return at + 1
        if self.two_words(at):
            return self._refuse(TWO_WORDS, at)
        word = str(token.value) if token.kind == "NAME" else token.kind
        if word in ("given", "const", "schema") and self._peek(at + 1).kind in ("==", "::="):
            return self._definition(at)
        if token.section:
            match word:
                case "visible" | "inherit" | "given" | "chan" | "method" | "local_chan":
                    self._emit(word, at)
                    return self._parents(at + 1) if word == "inherit" else self._one_line(at + 1, names=True)
                case "const":
                    return self._axiom(at, top=False)
                case "schema":
                    return self._schema(at)
                case "lemma":
                    return self._lemma(at)
                case "state":
                    return self._state(at)
                case "init" | "INIT":
                    self._emit("init", at)
                    at = self._where(at + 1) if self.tokens[at + 1].kind == "where" else self._lines(at + 1)
                    return self._section_end(at)
                case "op":
                    return self._operation(at)
                case "Delta" | "where" | "using" | "by":
                    return self._refuse(MISPLACED, at)
        if token.kind == "NAME" and self._is_definition(at):
            return self._definition(at)
        if token.kind == "NAME" and not token.section and self._looks_like_section(at):
            return self._refuse(UNKNOWN_SECTION, at)
        return self._equations(at)

    def two_words(self, at: int) -> bool:
        """Whether the name of a schema is written in two words: ``enable up`` for ``enable_up``."""
        token, following = self.tokens[at], self._peek(at + 1)
        both = token.kind == following.kind == "NAME" and token.value in _SCHEMAS
        return both and not following.first and not following.section

    def _section_end(self, at: int) -> int:
        """Lay out the ``end`` of a section, if there is one."""
        if self.tokens[at].kind == "end" and not self._is_last(at):
            self._emit("_END_OF_SECTION", at)
            return at + 1
        return at

    def _parents(self, at: int) -> int:
        """Lay out the classes that are inherited; a bracket with parameters or renamings may begin a line."""
        while not self.tokens[at].section:
            token = self.tokens[at]
            outside = len(self._frames) == 1
            if outside and token.kind == "[" and self._last in ("NAME", "]"):
                renames = self._peek(at + 1).kind == "NAME" and self._peek(at + 2).kind == "/"
                self._emit("_RENAMING" if renames else "[", at)
                self._frames.append(OpenFrame("["))
                at += 1
                continue
            if self._begins_line(at, names=outside) and not (outside and token.kind == ","):
                if outside:
                    break
                self._gap("_BREAK", at)
            if outside and token.kind == ";":
                self._emit(";", at)
                return at + 1
            self._term(at)
            at += 1
        self._closed()
        return at

    def _state(self, at: int) -> int:
        self._emit("state", at)
        at = self._declarations(at + 1)
        if self._is_word(at, "Delta"):
            self._emit("Delta", at)
            at = self._declarations(at + 1)
        return self._section_end(self._where(at))

    def _operation(self, at: int) -> int:
        self._emit("op", at)
        at += 1
        if self.two_words(at):
            return self._refuse(TWO_WORDS, at)
        token = self.tokens[at]
        if token.section:
            return at
        self._emit(token.kind, at)
        at += 1
        if self.tokens[at].kind == "=" and not self.tokens[at].section:
            self._emit("=", at)
            return self._section_end(self._using(self._one_line(at + 1, operation=True)))
        if self.tokens[at].kind == "NAME" and self.tokens[at].value == "Delta":
            self._emit("Delta", at)
            at += 1
            if self.tokens[at].kind == "(" and not self.tokens[at].section:
                at = self._delta(at)
        return self._section_end(self._using(self._where(self._declarations(at))))

    def _delta(self, at: int) -> int:
        """Lay out the names of a Delta-list in brackets, and the ``;`` behind it."""
        self._emit("(", at)
        at += 1
        while self.tokens[at].kind in ("NAME", ",") and not self.tokens[at].section:
            self._emit(self.tokens[at].kind, at)
            at += 1
        if self.tokens[at].section:
            return at
        self._emit(self.tokens[at].kind, at)
        at += 1
        if self.tokens[at].kind == ";":
            self._emit(";", at)
            at += 1
        return at

    def _is_definition(self, at: int) -> bool:
        """Whether ``N ==``, ``N ::=`` or ``N[X] ==`` begins here."""
        following = self._peek(at + 1).kind
        if following in ("==", "::="):
            return True
        if following != "[":
            return False
        at += 2
        while self.tokens[at].kind in ("NAME", ","):
            at += 1
        return self.tokens[at].kind == "]" and self._peek(at + 1).kind == "=="

    def _looks_like_section(self, at: int) -> bool:
        """Whether a word is followed by a name, or stands alone, as no equation does."""
        following = self._peek(at + 1)
        annotated = following.kind == ":" and self._peek(at + 2).kind == ":"
        return (following.first or following.kind in ("NAME", ":", "$END")) and not annotated

    # --- equations -------------------------------------------------------------------------------------------

    def _equations(self, at: int) -> int:
        """Lay out the lines up to the next section as one terminal."""
        column = self.column(self.tokens[at])
        end = at + 1
        while not self._equations_end(end, column):
            end += 1
        self._emit("EQUATIONS", at, self.tokens[end - 1].end)
        return end

    def _equations_end(self, at: int, column: int) -> bool:
        token = self.tokens[at]
        if token.section:
            return not (token.kind == "NAME" and token.value == "main")
        if not token.first or token.kind != "NAME":
            return token.kind == "UNREAD_SECTION"
        if self._peek(at + 1).kind == "::=":
            return True
        return self.column(token) <= column and (self._is_definition(at) or self._misspelt(at))

    def _misspelt(self, at: int) -> bool:
        """Whether a line begins with two names, the first of which is nearly that of a section."""
        return self._peek(at + 1).kind == "NAME" and bool(suggestions(str(self.tokens[at].value), SECTIONS))
