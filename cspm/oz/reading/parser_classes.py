"""Reading classes: their sections in any order, and the equations of CSPm among them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, Literal, cast

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.lexer import Token
from cspcheck.cspm.oz.reading.parser import Paragraphs
from cspcheck.cspm.oz.reading.parser_terms import Stuck
from cspcheck.cspm.parsing import class_messages
from cspcheck.cspm.parsing.lexer import DECLARATION_KEYWORDS, Tokens, tokenise
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as s

SECTIONS: Final = (
    *("visible", "inherit", "chan", "method", "local_chan", "given", "const", "schema", "state", "init", "op"),
)
"""The words that begin a section of a class."""

_NAME_DEFINITION: Final = frozenset(["==", "::="])


class _Parts:
    """What has been read of a class."""

    def __init__(self) -> None:
        self.visibility: tuple[s.NameDeclaration, ...] | None = None
        self.inherits: list[z.Inherit] = []
        self.interface: list[z.Interface] = []
        self.equations: list[s.Declaration] = []
        self.paragraphs: list[z.Paragraph] = []
        self.state: z.State | None = None
        self.initial: z.Initial | None = None
        self.operations: list[z.OperationSchema | z.OperationDefinition] = []
        self.places: dict[str, Span] = {}


class Classes(Paragraphs):
    """Reads any paragraph."""

    def one(self) -> z.Paragraph:
        """Read one paragraph."""
        if self.token.kind == "NAME" and self.token.value == "class" and self.peek().kind == "NAME":
            return self._class()
        return super().one()

    def at_block_end(self) -> bool:
        """Whether the next token is the ``end`` of the class."""
        return self.peek().kind == "$END"

    def _class(self) -> z.Class:
        start = self.at
        self.take()
        name = self.name()
        generics: tuple[s.NameDeclaration, ...] = ()
        if self.token.kind == "[":
            generics = self.names_in_brackets()
        if self.token.kind == "NAME" and self.token.value == "inherit" and self.peek().kind == "NAME":
            self.token.section = True  # the one section that may stand in the line of the name
        self.top = False
        parts = _Parts()
        while self.token.kind != "$END" and not (self.token.kind == "end" and self.at_block_end()):
            self._try_section(parts)
        self.finish_block(start)
        return z.Class(
            span=self.since(start),
            name=name.name,
            generics=generics,
            visibility=parts.visibility,
            inherits=tuple(parts.inherits),
            interface=tuple(parts.interface),
            equations=tuple(parts.equations),
            paragraphs=tuple(parts.paragraphs),
            state=parts.state,
            initial=parts.initial,
            operations=tuple(parts.operations),
        )

    # --- sections --------------------------------------------------------------------------------------------

    def _try_section(self, parts: _Parts) -> None:
        """Read one section; after a mistake go on with the next one."""
        start = self.at
        try:
            self._section(parts)
        except Stuck as stuck:
            self.errors.append(stuck.diagnostic)
            self.skip_line(start)
            while not self.token.section or self.token.kind == "where" or self.at_word("Delta"):
                self.at += 1

    def _section(self, parts: _Parts) -> None:
        token = self.token
        if token.kind == "end":
            self.take()
            self.errors.append(class_messages.end_too_many(self.span(token)))
            return
        self._one_word()
        word = str(token.value) if token.kind == "NAME" else token.kind
        read = self._readers.get(word)
        if read is not None and token.section:
            read(self, parts)
        elif token.kind == "NAME" and self._is_definition():
            parts.paragraphs.append(self.one())
            self.line_ends()
        elif token.kind == "NAME" and not token.section and self._looks_like_section():
            if word in DECLARATION_KEYWORDS:
                raise Stuck(messages.not_in_class(self.span(token), word))
            raise Stuck(messages.unknown_section(self.span(token), word, suggestions(word, SECTIONS)))
        else:
            self._equations(parts)

    def _one_word(self, place: int | None = None) -> None:
        """Check that no name of a schema is written in two words: ``enable up`` for ``enable_up``."""
        place = self.at if place is None else place
        token, following = self.tokens[place], self.tokens[min(place + 1, len(self.tokens) - 1)]
        if (
            token.kind == following.kind == "NAME"
            and token.value in ("com", "enable", "effect")
            and not following.first
            and not following.section
        ):
            span = self.source.span(token.start, following.end)
            raise Stuck(messages.schema_in_two_words(span, str(token.value), str(following.value)))

    def _is_definition(self) -> bool:
        """Whether ``N ==``, ``N ::=`` or ``N[X] ==`` comes next."""
        if self.peek().kind in _NAME_DEFINITION:
            return True
        if self.peek().kind != "[":
            return False
        place = self.at + 2
        while self.tokens[place].kind in ("NAME", ","):
            place += 1
        return self.tokens[place].kind == "]" and self.tokens[min(place + 1, len(self.tokens) - 1)].kind == "=="

    def _looks_like_section(self) -> bool:
        """Whether a word is followed by a name, or stands alone, as no equation does."""
        following = self.peek()
        annotated = following.kind == ":" and self.peek(2).kind == ":"
        return (following.first or following.kind in ("NAME", ":", "$END")) and not annotated

    def _visible(self, parts: _Parts) -> None:
        token = self.take()
        self._once(parts, "visible", token)
        bracketed = self.token.kind == "("
        if bracketed:
            self.opened()
        names: list[s.NameDeclaration] = []
        if not (bracketed and self.token.kind == ")"):
            names = self.list_of(self.name)
        if bracketed:
            self.closed(")", "`,`")
        parts.visibility = tuple(names)
        self.line_ends()

    def _inherit(self, parts: _Parts) -> None:
        self.take()
        parts.inherits += self.list_of(self._parent)
        self.line_ends()

    def _parent(self) -> z.Inherit:
        start = self.at
        name = self.name("the name of a class")
        arguments: tuple[z.Term, ...] = ()
        renamings: tuple[tuple[s.NameDeclaration, s.NameDeclaration], ...] = ()
        if self.token.kind == "[" and not self._renames():
            self.opened()
            arguments = tuple(self.list_of(self.expression))
            self.closed("]", "`,`")
        if self.token.kind == "[":
            self.opened()
            renamings = tuple(self.list_of(self._renaming))
            self.closed("]", "`,`")
        return z.Inherit(span=self.since(start), name=name.name, arguments=arguments, renamings=renamings)

    def _renames(self) -> bool:
        return self.peek().kind == "NAME" and self.peek(2).kind == "/"

    def _renaming(self) -> tuple[s.NameDeclaration, s.NameDeclaration]:
        new = self.name("the new name")
        self.expect("/", help="a renaming is written `[new/old]`")
        return new, self.name("the old name")

    def _interface(self, parts: _Parts) -> None:
        start = self.at
        kind = self.take().value
        names = self.list_of(self.name)
        parameters: tuple[z.Declare, ...] = ()
        if self.token.kind == ":":
            self.take()
            if self.token.kind != "[":
                written = ", ".join(name.name for name in names)
                raise Stuck(messages.parameters_without_brackets(self.span(self.token), written))
            self.opened()
            if self.token.kind != "]":
                parameters = self.bound()
            self.closed("]", "`;`")
        parts.interface.append(
            z.Interface(
                span=self.since(start),
                kind=cast(Literal["chan", "method", "local_chan"], kind),
                names=tuple(names),
                parameters=parameters,
            )
        )
        self.line_ends()

    def _paragraph(self, parts: _Parts) -> None:
        parts.paragraphs.append(self.one())
        if not self.token.section and not self.token.first:
            self.line_ends()

    def _state(self, parts: _Parts) -> None:
        start = self.at
        self._once(parts, "state", self.take())
        primary = self.declarations()
        secondary: tuple[z.Declare, ...] = ()
        if self.at_word("Delta"):
            self.take()
            secondary = self.declarations()
        predicates = self.where()
        if parts.state is None:
            parts.state = z.State(span=self.since(start), primary=primary, secondary=secondary, predicates=predicates)
        self.closed_section()

    def _initial(self, parts: _Parts) -> None:
        start = self.at
        self._once(parts, "init", self.take())
        if self.token.kind == "where":
            self.take()
        predicates = self.predicates()
        if parts.initial is None:
            parts.initial = z.Initial(span=self.since(start), predicates=predicates)
        self.closed_section()

    def closed_section(self) -> None:
        """Read the ``end`` of a section, if there is one."""
        if self.token.kind == "end" and not self.at_block_end():
            self.take()

    def _once(self, parts: _Parts, name: str, token: Token) -> None:
        if name in parts.places:
            self.errors.append(messages.section_twice(self.span(token), name, parts.places[name]))
        parts.places.setdefault(name, self.span(token))

    def _misplaced(self, parts: _Parts) -> None:
        if self.at >= 2 and self.tokens[self.at - 2].first:
            self._one_word(self.at - 2)  # read as one more predicate of the section before
        token = self.take()
        self.errors.append(messages.unexpected(self.span(token), self.found(token), ["a section of the class"]))
        while not self.token.section:
            self.take()

    # --- operations ------------------------------------------------------------------------------------------

    def _operation(self, parts: _Parts) -> None:
        start = self.at
        self.take()
        self._one_word()
        name = self.name("the name of an operation")
        if self.token.kind == "=":
            self.take()
            body = self.operation_expression()
            span = self.since(start)
            if isinstance(body, z.OperationText):
                delta, declarations, predicates = body.delta, body.declarations, body.predicates
                parts.operations.append(
                    z.OperationSchema(
                        span=span, name=name.name, delta=delta, declarations=declarations, predicates=predicates
                    )
                )
            else:
                parts.operations.append(z.OperationDefinition(span=span, name=name.name, body=body))
            self.line_ends()
        else:
            delta = self._delta()
            declarations = self.declarations()
            predicates = self.where()
            parts.operations.append(
                z.OperationSchema(
                    span=self.since(start),
                    name=name.name,
                    delta=delta,
                    declarations=declarations,
                    predicates=predicates,
                )
            )
        self.closed_section()

    def _delta(self) -> tuple[s.NameDeclaration, ...] | None:
        token = self.token
        if not (token.kind == "NAME" and token.value == "Delta"):
            return None
        self.take()
        if self.token.kind != "(":
            raise Stuck(messages.delta_without_brackets(self.span(token)))
        self.opened()
        names = [] if self.token.kind == ")" else self.list_of(self.name)
        self.closed(")", "`,`")
        if self.token.kind == ";":
            self.take()
        return tuple(names)

    def _operation_text(self) -> z.OperationText:
        """Read ``[ Delta(x); i? : T | p ]``."""
        start = self.at
        self.opened()
        delta = self._delta()
        declarations: tuple[z.Declare, ...] = ()
        predicates: tuple[z.Term, ...] = ()
        if self.token.kind not in ("|", "]"):
            declarations = self.bound() if self.at_declaration() else ()
            if not declarations and delta is None:
                predicates = tuple(self.list_of(self.expression, ";"))
        if self.token.kind == "|":
            self.take()
            predicates = tuple(self.list_of(self.expression, ";"))
        self.closed("]", "`|`", "`;`")
        return z.OperationText(span=self.since(start), delta=delta, declarations=declarations, predicates=predicates)

    def operation_expression(self, least: int = 0) -> z.Term:
        """Read an expression over operations: ``||!`` loosest, then ``@``, ``||``, ``[]``, ``or`` and the others."""
        start = self.at
        left = self._operation_operand()
        while True:
            token = self.token
            found = OPERATION_OPERATORS.get(token.kind)
            if found is None or found[1] < least or (token.section or (token.first and self.over_operation())):
                return left
            self.take()
            name, level = found
            right = self._hidden() if name == "hide" else self.operation_expression(level + 1)
            left = z.Operator(span=self.since(start), name=name, operands=(left, right))

    def over_operation(self) -> bool:
        """Whether a line break ends an expression over operations: not before one of its operators."""
        return not self.open and self.token.kind not in OPERATION_OPERATORS

    def _operation_operand(self) -> z.Term:
        start = self.at
        token = self.token
        if token.kind == "(":
            self.opened()
            inner = self.operation_expression()
            self.closed(")", "an operator")
            return self._operation_renamed(start, z.Grouped(span=self.since(start), inner=inner))
        if token.kind == "[":
            return self._operation_text()
        if token.kind in DISTRIBUTED and not token.section:
            return self._distributed()
        if token.kind != "NAME" or token.section:
            self.refuse("the name of an operation")
        self.take()
        term: z.Term = z.Reference(span=self.span(token), name=str(token.value), decoration=self._decoration(token))
        while True:
            if self.token.kind == "." and not self.token.first:
                self.take()
                field = self.name("the name of an operation")
                term = z.Selection(span=self.since(start), record=term, field=field.name)
            elif self.token.kind == "(" and self.token.tight:
                argument = self._arguments()
                term = z.Application(span=self.since(start), function=term, argument=argument)
            else:
                return self._operation_renamed(start, term)

    def _operation_renamed(self, start: int, term: z.Term) -> z.Term:
        """Read the ``[new/old]`` behind an operation, if there is one."""
        while self.token.kind == "[" and not self.token.first:
            term = z.Renamed(term=term, renamings=self.renaming_list(), span=self.since(start))
        return term

    def _distributed(self) -> z.Term:
        """Read ``[] x : S | p @ Op`` and its like, as far to the right as it goes."""
        start = self.at
        kind = DISTRIBUTED[self.take().kind]
        declarations = self.bound(in_quantifier=True)
        condition = None
        if self.token.kind == "|":
            self.take()
            condition = self.expression()
        self.expect("@", "`|`", help="a distributed operation is written `[] x : S @ Op`")
        body = self.operation_expression()
        return z.Distributed(
            span=self.since(start), kind=kind, declarations=declarations, condition=condition, body=body
        )

    def _hidden(self) -> z.Term:
        start = self.at
        opening = self.token.kind
        if opening not in ("(", "{"):
            self.refuse("`(`")
        self.opened()
        names = self.list_of(self.expression)
        self.closed(")" if opening == "(" else "}", "`,`")
        return z.Display(span=self.since(start), kind="set", items=tuple(names))

    # --- equations -------------------------------------------------------------------------------------------

    def _equations(self, parts: _Parts) -> None:
        """Hand the lines up to the next section to the parser of CSPm."""
        first = self.token
        start = self.at
        column = self._column(first)
        self.take()
        while not self._equations_end(column):
            self.take()
        span = self.since(start)
        for declaration in self._read_equations(span):
            parts.equations.append(declaration)

    def _equations_end(self, column: int) -> bool:
        token = self.token
        if token.section:
            return not (token.kind == "NAME" and token.value == "main")
        if not token.first or token.kind != "NAME":
            return False
        if self.peek().kind == "::=":
            return True
        return self._column(token) <= column and (self._is_definition() or self._misspelt(token))

    def _misspelt(self, token: Token) -> bool:
        """Whether a line begins with two names, the first of which is nearly that of a section."""
        return self.peek().kind == "NAME" and bool(suggestions(str(token.value), SECTIONS))

    def _read_equations(self, span: Span) -> tuple[s.Declaration, ...]:
        from cspcheck.cspm.parsing import mistakes as parser_mistakes
        from cspcheck.cspm.parsing.builder import Tree
        from cspcheck.cspm.parsing.driver import Unexpected, run
        from cspcheck.cspm.parsing.table import table

        found = self._equation_tokens(span)
        self.errors += found.errors
        if found.errors:
            return ()
        tree = Tree(found, lambda path, place: ())
        try:
            script: Any = run(table(), "script", found, tree)
        except Unexpected as error:
            finding = parser_mistakes.diagnose(table(), "script", found, error.index)
            self.errors += [*tree.errors, finding.diagnostic]
            return ()
        tree.finish()
        self.errors += tree.errors
        equations: list[s.Declaration] = []
        for declaration in script.declarations:
            if isinstance(declaration, s.PatternDefinition | s.FunctionDefinition | s.AnnotationDeclaration):
                equations.append(declaration)
            else:
                start = declaration.span.start
                word = next((w for w in DECLARATION_KEYWORDS if self.source.text.startswith(w, start)), "this")
                self.errors.append(messages.not_in_class(self.source.span(start, start + len(word)), word))
        return tuple(equations)

    def _equation_tokens(self, span: Span) -> Tokens:
        return tokenise(self.source, start=span.start, end=span.end, form="equations")

    _readers: Final[Mapping[str, Callable[[Classes, _Parts], None]]] = {
        "visible": _visible,
        "inherit": _inherit,
        "chan": _interface,
        "method": _interface,
        "local_chan": _interface,
        "given": _paragraph,
        "const": _paragraph,
        "schema": _paragraph,
        "state": _state,
        "init": _initial,
        "INIT": _initial,
        "op": _operation,
        "Delta": _misplaced,
        "where": _misplaced,
    }


OPERATION_OPERATORS: Final[Mapping[str, tuple[str, int]]] = {
    "||!": ("parallel_open", 1),
    "@": ("enrich", 2),
    "||": ("parallel", 3),
    "[]": ("choice", 4),
    "or": ("or", 5),
    "and": ("and", 6),
    ";": ("compose", 7),
    "comp": ("compose", 7),
    "\\": ("hide", 8),
}
"""Operators over operations by their token, with their canonical name and how tightly they bind."""

DISTRIBUTED: Final[Mapping[str, Literal["choice", "and", "compose", "parallel"]]] = {
    "[]": "choice",
    "and": "and",
    ";": "compose",
    "||": "parallel",
}
"""Operators that distribute over values, by their token."""
