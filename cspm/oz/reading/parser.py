"""Reading Object-Z paragraphs in text notation: types, constants, schemas, readings, retrieve relations, classes.

The tokeniser of CSPm finds where a paragraph begins and ends (:func:`cspcheck.cspm.oz.reading.lexer.extent`); here it
becomes a tree. A mistake ends the reading of its line or section, the next one is read again, so that several can be
reported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, Literal, cast

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.lexer import Scan, Token, tokens
from cspcheck.cspm.oz.reading.parser_terms import CLOSERS, Stuck, Terms
from cspcheck.cspm.parsing import class_messages, lexing_messages as lexing
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax.tree import NameDeclaration

MOST_MISTAKES: Final = 20
"""Mistakes of one paragraph that are reported, at most."""


def parse_paragraph(source: Source, start: int, end: int) -> tuple[z.Paragraph, list[Diagnostic]]:
    """The paragraph that fills the range of *source*, with what is wrong in it.

    If there are mistakes, the tree holds what could be read.
    """
    from cspcheck.cspm.oz.reading.parser_classes import Classes

    scan = Scan()
    found = list(tokens(source, start, end, scan))
    if scan.unclosed_comment is not None:
        rest = source.text[scan.unclosed_comment.end :]
        return _nothing(source, start, end), [lexing.unclosed_comment(scan.unclosed_comment, rest)]
    parser = Classes(source, found)
    try:
        with deep_recursion():
            paragraph = parser.paragraph()
    except Stuck as stuck:
        return _nothing(source, start, end), [*parser.errors, stuck.diagnostic]
    except RecursionError:
        return _nothing(source, start, end), [messages.too_deep(source.span(start, min(start + 1, end)))]
    return paragraph, parser.errors[:MOST_MISTAKES]


def _nothing(source: Source, start: int, end: int) -> z.Paragraph:
    return z.GivenTypes(span=source.span(start, end), names=())


class Paragraphs(Terms):
    """Reads all paragraphs but classes."""

    def __init__(self, source: Source, found: Sequence[Token]) -> None:
        super().__init__(source, found)

    def paragraph(self) -> z.Paragraph:
        """Read the paragraph that all tokens make up."""
        start = self.at
        paragraph = self.one()
        if self.token.kind == "end":
            self.errors.append(class_messages.end_too_many(self.span(self.token)))
        elif self.token.kind != "$END":
            self._behind(start)
        return paragraph

    def _behind(self, start: int) -> None:
        try:
            self.refuse("an operator", "a new line")
        except Stuck as stuck:
            self.errors.append(stuck.diagnostic)

    def one(self) -> z.Paragraph:
        """Read one paragraph."""
        start = self.at
        word = self.token.value if self.token.kind == "NAME" else ""
        if self.peek().kind not in ("==", "::="):
            match word:
                case "given":
                    self.take()
                    return z.GivenTypes(names=tuple(self.list_of(self.name)), span=self.since(start))
                case "const":
                    return self.axiom()
                case "schema":
                    return self.schema()
                case "reading":
                    return self._reading()
                case "view":
                    return self._view()
                case "retrieve":
                    return self._retrieve()
        return self._definition_of_type()

    def finish_block(self, start: int) -> None:
        """Read the ``end`` of the block that begins at the token with index *start*."""
        if self.token.kind == "end":
            self.take()
            return
        first = self.tokens[start]
        self.errors.append(messages.unclosed_block(self.span(first), str(first.value), self._last_end()))

    def _last_end(self) -> Span | None:
        ends = [token for token in self.tokens[: self.at] if token.kind == "end"]
        return self.span(ends[-1]) if ends else None

    # --- parts of sections -----------------------------------------------------------------------------------

    def try_line(self, read: Callable[[], None]) -> None:
        """Read one line; after a mistake go on behind it."""
        start = self.at
        try:
            read()
        except Stuck as stuck:
            self.errors.append(stuck.diagnostic)
            self.skip_line(start)

    def skip_line(self, start: int) -> None:
        """Go on to the next line that begins no deeper than the one of the token at index *start*, or section."""
        column = self._column(self.tokens[start])
        depth = len(self.open)
        self.open.clear()
        while True:
            token = self.token
            if token.section and (token.kind == "$END" or self.at > start):
                return
            if token.first and self.at > start and depth <= 0 and self._column(token) <= column:
                return
            depth += (token.kind in CLOSERS) - (token.kind in CLOSERS.values())
            self.at += 1

    def _column(self, token: Token) -> int:
        line_start = self.source.text.rfind("\n", 0, token.start) + 1
        before = self.source.text[line_start : token.start]
        return len(before) - len(before.lstrip()) if before.strip() else len(before)

    def line_ends(self) -> None:
        """Check that a line ends here: by ``;``, a line break, or the end of the section."""
        if self.token.kind == ";":
            self.take()
        elif not self.over():
            self.refuse("an operator", "a new line")

    def declarations(self, *, stop: Callable[[], bool] = lambda: False) -> tuple[z.Declare, ...]:
        """Read declarations up to the next section, or to where *stop* holds."""
        found: list[z.Declare] = []

        def line() -> None:
            token = self.token
            if self._at_inclusion():
                token.section = False
                found.append(self.declare_or_include())
                self.line_ends()
                return
            if not self.at_declaration():
                self._no_declaration(token)
            found.append(self.declare())
            self.line_ends()

        while (not self.token.section or self._at_delta()) and not stop():
            self.try_line(line)
        return tuple(found)

    def _at_delta(self) -> bool:
        """Whether ``Delta S`` comes next, which includes a schema in another one."""
        following = self.peek()
        named = self.at_word("Delta") and following.kind == "NAME" and not following.first
        return self.in_schema and named and self.peek(2).kind not in (":", ",")

    in_schema = False
    """Whether the declarations that are read are those of a schema, where ``Delta`` begins no section."""

    def _at_inclusion(self) -> bool:
        """Whether a line of declarations includes a schema: ``S``, ``S'``, ``S[T]``, ``Xi S``, ``[x : T | p]``."""
        token, following = self.token, self.peek()
        if token.kind == "[":
            return True
        if token.kind != "NAME":
            return False
        if token.value in ("Delta", "Xi") and following.kind == "NAME" and not following.first:
            return self.peek(2).kind not in (":", ",")
        return following.first or following.section or following.kind == ";" or (following.kind == "[")

    def _no_declaration(self, token: Token) -> None:
        if self.peek().kind in (":", ","):
            self.declared()  # says what is wrong with the name
        place = self.at
        while not self.tokens[place].section:
            place += 1
        raise Stuck(messages.no_declaration(self.span(token), self.tokens[place].kind == "where"))

    def predicates(self) -> tuple[z.Term, ...]:
        """Read predicates, each on its own line, up to the next section."""
        found: list[z.Term] = []

        def line() -> None:
            first = self.token
            term = self.expression()
            if found and first.kind == "-" and isinstance(term, z.Operator) and term.name not in _LOGICAL:
                # A number is no predicate: the line was meant to go on with the one before.
                raise Stuck(messages.unexpected(self.span(first), "`-`", ["a predicate"], help=_MINUS))
            found.append(term)
            self.line_ends()

        while not self.token.section:
            self.try_line(line)
        return tuple(found)

    def where(self) -> tuple[z.Term, ...]:
        """Read ``where`` and the predicates behind it, if they are there."""
        if self.token.kind != "where":
            return ()
        self.take()
        return self.predicates()

    # --- paragraphs ------------------------------------------------------------------------------------------

    def axiom(self) -> z.Axiom:
        """Read ``const x : T where p``; at the top of a script it ends with ``end`` if it has a ``where``."""
        start = self.at
        self.take()
        declarations = self.declarations(stop=lambda: self.token.first and not self.at_declaration())
        needs_end = self.token.kind == "where" and self.top
        predicates = self.where()
        if needs_end:
            self.finish_block(start)
        elif self.token.kind == "end" and (self.top or not self.at_block_end()):
            self.take()
        return z.Axiom(span=self.since(start), declarations=declarations, predicates=predicates)

    top = True
    """Whether what is read stands at the top of the script and not in a class."""

    def at_block_end(self) -> bool:
        """Whether the next token is the ``end`` of the block that is read."""
        return False

    def schema(self) -> z.Schema:
        """Read ``schema S ... where ... init ... end``."""
        start = self.at
        self.take()
        name = self.name()
        generics = self.names_in_brackets() if self.token.kind == "[" and not self.token.first else ()
        self.in_schema = True
        try:
            declarations = self.declarations()
        finally:
            self.in_schema = False
        predicates = self.where()
        initial = None
        if self.at_word("init", "INIT"):
            self.take()
            initial = self.predicates()
        self.finish_block(start)
        return z.Schema(
            span=self.since(start),
            name=name.name,
            declarations=declarations,
            predicates=predicates,
            initial=initial,
            generics=generics,
        )

    def at_word(self, *words: str) -> bool:
        """Whether a section comes next that one of *words* begins."""
        return self.token.section and self.token.kind == "NAME" and self.token.value in words

    def _reading(self) -> z.Reading:
        start = self.at
        self.take()
        subject = self.expression(7)
        self.expect("=", help="a reading is written `reading real = {-1, 0, 1}`")
        carrier = self.expression()
        return z.Reading(span=self.since(start), subject=subject, carrier=carrier)

    def _view(self) -> z.View:
        start = self.at
        self.take()
        kind = self.token.value
        if kind not in ("control", "data"):
            self.refuse("`control`", "`data`")
        self.take()
        return z.View(span=self.since(start), kind=cast(Literal["control", "data"], kind))

    def _retrieve(self) -> z.Retrieve:
        start = self.at
        self.take()
        name = self.name()
        if not (self.token.kind == "NAME" and self.token.value == "between"):
            self.refuse("`between`", help=_RETRIEVE)
        self.take()
        abstract = self.name("the name of the abstract class")
        self.expect("and", help=_RETRIEVE)
        concrete = self.name("the name of the concrete class")
        if self.token.kind != "where":
            self.refuse("`where`", help=_RETRIEVE)
        predicates = self.where()
        self.finish_block(start)
        return z.Retrieve(
            span=self.since(start), name=name.name, abstract=abstract, concrete=concrete, predicates=predicates
        )

    def _definition_of_type(self) -> z.Paragraph:
        start = self.at
        name = self.name(at_section=True)
        generics: tuple[NameDeclaration, ...] = ()
        if self.token.kind == "[":
            generics = self.names_in_brackets()
        if self.token.kind == "::=" and self.peek().kind != "{":
            self.take()
            branches = self.list_of(self._branch_of_type, "|")
            return z.FreeType(span=self.since(start), name=name.name, branches=tuple(branches))
        if self.token.kind not in ("==", "::="):
            self.refuse("`==`", "`::=`")
        self.take()
        body = self.expression()
        while self.token.kind in (";", ">>") and not self.token.first and not self.peek().section:
            # Composition and piping of schemas: signs that separate or close elsewhere.
            name_ = "compose" if self.take().kind == ";" else "pipe"
            right = self.expression()
            body = z.Operator(span=self.since(start), name=name_, operands=(body, right))
        return z.Abbreviation(span=self.since(start), name=name.name, body=body, generics=generics)

    def _branch_of_type(self) -> z.Branch:
        start = self.at
        name = self.name()
        argument = None
        if self.token.kind == "<<":
            self.opened()
            argument = self.expression()
            self.closed(">>", "an operator")
        return z.Branch(span=self.since(start), name=name.name, argument=argument)

    def names_in_brackets(self) -> tuple[NameDeclaration, ...]:
        """Read ``[X, Y]``."""
        self.opened()
        names = self.list_of(self.name)
        self.closed("]", "`,`")
        return tuple(names)


_LOGICAL: Final = frozenset(["and", "or", "implies", "iff", "not"])
_MINUS: Final = "a line that begins with `-` is a predicate of its own; put the sign at the end of the line before"
_RETRIEVE: Final = "a retrieve relation is written `retrieve R between A and C where ... end`"
