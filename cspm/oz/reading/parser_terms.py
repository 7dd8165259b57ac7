"""Expressions and predicates: recursive descent over the tokens of :mod:`cspcheck.cspm.oz.reading.lexer`, operators
by precedence.

Line breaks count only outside brackets. There a line is a conjunct of its own unless the one before ends with an
operator (an operand is due then) or it begins with an infix operator other than ``-``.

Recursion costs no C stack (see :mod:`cspcheck.cspm.recursion`), so the nesting of a text is bounded by memory.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Final, NoReturn, TypeVar, cast

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.lexer import BINDERS, INFIX, NAMING, POSTFIX, PREFIX, RESERVED, Token, continues
from cspcheck.cspm.oz.reading.operators import RELATION
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax.tree import NameDeclaration

T = TypeVar("T")

LONGEST_INTEGER: Final = 4000
"""Digits beyond which a number is refused (Python converts no more than 4300)."""

CLOSERS: Final = {"(": ")", "{": "}", "[": "]", "[[": "]]", "(|": "|)", "<<": ">>", "SEQUENCE_OPEN": "SEQUENCE_CLOSE"}
_ARGUMENT_STARTS: Final = frozenset(
    ["NAME", "INT", "REAL", "true", "false", "EMPTY", "(", "{", "[[", "SEQUENCE_OPEN", "(|", "LITERAL"]
)
_EXTENDS: Final = frozenset([*BINDERS, "if", "let"])
_WORD_OPERATORS: Final = NAMING
"""Prefix operators that are words: names where nothing follows that they could be applied to."""


class Stuck(Exception):
    """The section that is being read cannot be read further."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic
        super().__init__(diagnostic.message)


class Terms:
    """Reads terms from tokens, the last of which has the kind ``$END``."""

    def __init__(self, source: Source, tokens: Sequence[Token]) -> None:
        self.source = source
        self.tokens = tokens
        self.at = 0
        self.open: list[Token] = []  # brackets, innermost last: inside them line breaks are layout
        self.errors: list[Diagnostic] = []

    # --- tokens ----------------------------------------------------------------------------------------------

    @property
    def token(self) -> Token:
        """The next token."""
        return self.tokens[self.at]

    def peek(self, distance: int = 1) -> Token:
        """A later token."""
        return self.tokens[min(self.at + distance, len(self.tokens) - 1)]

    def span(self, token: Token) -> Span:
        """The place of a token."""
        return self.source.span(token.start, token.end)

    def since(self, start: int) -> Span:
        """The place from the token at index *start* to the last one that was read."""
        return self.source.span(self.tokens[start].start, self.tokens[max(self.at - 1, start)].end)

    def take(self) -> Token:
        """Read the next token."""
        token = self.tokens[self.at]
        self.at += 1
        return token

    def found(self, token: Token) -> str:
        """A token in words."""
        text = self.source.text[token.start : token.end]
        text = text if len(text) <= 40 else text[:37] + "..."
        if token.kind == "$END":
            return "the end of the paragraph"
        if token.kind == "NAME" and not token.section:
            return f"name `{text}`"
        if token.kind in ("INT", "REAL"):
            return f"number `{text}`"
        return f"`{text}`"

    def refuse(self, *wanted: str, help: str | None = None) -> NoReturn:
        """Report the next token, where one of *wanted* was due."""
        token = self.token
        words = self.found(token)
        if token.kind == "LITERAL":
            raise Stuck(messages.literal(self.span(token)))
        if self.open and (token.section or token.kind in CLOSERS.values()):
            opener = self.open[-1]
            closer = self._written(CLOSERS[opener.kind])
            compares = opener.first and closer == ">" and opener is self.open[0]
            raise Stuck(
                messages.unclosed_bracket(self.span(opener), closer, self.span(token), words, compares=compares)
            )
        labels: tuple[Label, ...] = ()
        if self.open:
            labels = (Label(self.span(self.open[-1]), "inside this bracket"),)
            if token.first and help is None:
                help = "inside brackets lines are not separate; write `and` between conjuncts"
        raise Stuck(messages.unexpected(self.span(token), words, wanted, labels=labels, help=help))

    def _written(self, kind: str) -> str:
        return {"SEQUENCE_OPEN": "<", "SEQUENCE_CLOSE": ">"}.get(kind, kind)

    def expect(self, kind: str, *others: str, help: str | None = None) -> Token:
        """Read a token of this kind; *others* are what else could have come, for the message."""
        if self.token.kind != kind:
            self.refuse(f"`{self._written(kind)}`", *others, help=help)
        return self.take()

    def opened(self) -> Token:
        """Read an opening bracket."""
        token = self.take()
        self.open.append(token)
        return token

    def closed(self, kind: str, *others: str) -> Token:
        """Read the closing bracket of the innermost open one."""
        token = self.expect(kind, *others)
        self.open.pop()
        return token

    def over(self) -> bool:
        """Whether what is being read ends before the next token: a line or a section begins."""
        token = self.token
        if token.section:
            return True
        return token.first and not self.open and not continues(token)

    def list_of(self, item: Callable[[], T], separator: str = ",") -> list[T]:
        """One or more items."""
        items = [item()]
        while self.token.kind == separator:
            self.take()
            items.append(item())
        return items

    def name(self, wanted: str = "a name", *, at_section: bool = False) -> NameDeclaration:
        """Read a name without decoration; with *at_section* it may begin a section."""
        token = self.token
        if token.kind != "NAME" or (token.section and not at_section):
            self._no_name(wanted)
        if token.decoration:
            self.refuse(f"{wanted} without decoration")
        self.take()
        return NameDeclaration(span=self.span(token), name=str(token.value))

    def _no_name(self, wanted: str) -> NoReturn:
        token = self.token
        text = self.source.text[token.start : token.end]
        if text in RESERVED and not token.section:
            raise Stuck(messages.reserved_word(self.span(token), text))
        self.refuse(wanted)

    # --- declarations ----------------------------------------------------------------------------------------

    def at_declaration(self) -> bool:
        """Whether ``x, y :`` comes next."""
        place = self.at
        while True:
            token = self.tokens[place]
            if token.kind != "NAME" and token.kind not in _WORD_OPERATORS:
                return False
            following = self.tokens[min(place + 1, len(self.tokens) - 1)]
            if following.kind == ":":
                return True
            if following.kind != ",":
                return False
            place += 2

    def declared(self) -> z.Declared:
        """Read a name with its decoration in a declaration."""
        token = self.token
        word = token.kind in _WORD_OPERATORS
        if (token.kind != "NAME" and not word) or (token.section and token.kind != "NAME"):
            self._no_name("a name")
        self.take()
        return z.Declared(span=self.span(token), name=str(token.value), decoration=self._decoration(token))

    def declare(self, *, in_quantifier: bool = False) -> z.Declare:
        """Read ``x, y : T``; in a quantifier it may be written ``x, y in T``."""
        start = self.at
        names = self.list_of(self.declared)
        if in_quantifier and self.token.kind == "in":
            self.take()
        else:
            self.expect(":", "`,`")
        carrier = self.expression()
        return z.Declare(span=self.since(start), names=tuple(names), carrier=carrier)

    def bound(self, *, in_quantifier: bool = False) -> tuple[z.Declare, ...]:
        """Read the declarations of a binder."""
        if in_quantifier:
            return tuple(self.list_of(lambda: self.declare_or_include(in_quantifier=True), ";"))
        return tuple(self.list_of(self.declare, ";"))

    def _decoration(self, token: Token) -> z.Decoration:
        if len(token.decoration) > 1:
            self.errors.append(messages.several_primes(self.span(token)))
            return "'"
        return cast(z.Decoration, token.decoration)

    # --- operators -------------------------------------------------------------------------------------------

    def expression(self, least: int = 0) -> z.Term:
        """Read a term whose infix operators bind at least as tightly as *least*."""
        start = self.at
        left = self.operand()
        while True:
            token = self.token
            spelling = INFIX.get(token.kind)
            if spelling is None or spelling.precedence < least or self.over():
                return left
            if spelling.kind == "relation":
                left = self._chain(start, left)
            elif spelling.name == "cross":
                left = self._product(start, left)
            else:
                self.take()
                tighter = 1 if spelling.associativity == "left" else 0
                right = self.expression(spelling.precedence + tighter)
                left = z.Operator(span=self.since(start), name=spelling.name, operands=(left, right))

    def _chain(self, start: int, first: z.Term) -> z.Term:
        relations: list[str] = []
        operands = [first]
        while (spelling := INFIX.get(self.token.kind)) and spelling.kind == "relation" and not self.over():
            self.take()
            relations.append(spelling.name)
            operands.append(self.expression(RELATION + 1))
        return z.Chain(span=self.since(start), relations=tuple(relations), operands=tuple(operands))

    def _product(self, start: int, first: z.Term) -> z.Term:
        # A cross B cross C is a set of triples.
        level = INFIX["cross"].precedence
        operands = [first]
        while self.token.kind == "cross" and not self.over():
            self.take()
            operands.append(self.expression(level + 1))
        return z.Operator(span=self.since(start), name="cross", operands=tuple(operands))

    def operand(self) -> z.Term:
        """Read an operand with the prefix operators before it."""
        start = self.at
        token = self.token
        spelling = PREFIX.get(token.kind)
        if spelling is None or token.section or (token.kind in _WORD_OPERATORS and not self._applies()):
            return self._application()
        self.take()
        operand = self.expression(RELATION + 1 if spelling.precedence == RELATION else spelling.precedence)
        return z.Operator(span=self.since(start), name=spelling.name, operands=(operand,))

    def _applies(self) -> bool:
        """Whether the operator that is a word has something to be applied to; else it is a name, such as ``id``."""
        following = self.peek()
        if following.section or (following.first and not self.open):
            return False
        if following.kind == "-":
            return False
        return following.kind in _ARGUMENT_STARTS or following.kind in PREFIX or following.kind in _EXTENDS

    def _application(self) -> z.Term:
        start = self.at
        term = self._postfixed()
        if isinstance(term, z.Number | z.Truth):
            return term
        while self.token.kind in _ARGUMENT_STARTS and not self.token.first and not self.token.section:
            argument = self._postfixed()
            term = z.Application(span=self.since(start), function=term, argument=argument, bracketed=False)
        return term

    def _postfixed(self) -> z.Term:
        start = self.at
        term = self._primary()
        while True:
            token = self.token
            if token.section or (token.first and token.kind != "."):
                return term
            if token.kind == "(" and token.tight:
                argument = self._arguments()
                term = z.Application(span=self.since(start), function=term, argument=argument)
            elif token.kind == ".":
                term = self._selection(start, term)
            elif token.kind == "(|" and not (self.peek().kind == "NAME" and self.peek(2).kind == "=="):
                self.opened()
                image = self.expression()
                self.closed("|)", "an operator")
                term = z.Operator(span=self.since(start), name="image", operands=(term, image))
            elif self.at_renaming():
                term = z.Renamed(term=term, renamings=self.renaming_list(), span=self.since(start))
            elif token.kind in POSTFIX:
                self.take()
                term = z.Operator(span=self.since(start), name=POSTFIX[token.kind].name, operands=(term,))
            else:
                return term

    def _arguments(self) -> z.Term:
        """Read ``(x)`` or ``(x, y)`` behind a function: one term, or a tuple."""
        start = self.at
        self.opened()
        items = [] if self.token.kind == ")" else self.list_of(self.expression)
        self.closed(")", "`,`", "an operator")
        return items[0] if len(items) == 1 else z.Display(span=self.since(start), kind="tuple", items=tuple(items))

    def _selection(self, start: int, term: z.Term) -> z.Term:
        self.take()
        token = self.token
        if token.kind not in ("NAME", "INT"):
            self.refuse("the name of a component")
        self.take()
        decoration = self._decoration(token)
        return z.Selection(span=self.since(start), record=term, field=str(token.value), decoration=decoration)

    # --- operands --------------------------------------------------------------------------------------------

    def _primary(self) -> z.Term:
        token = self.token
        if token.section:
            self.refuse("an expression")
        match token.kind:
            case "NAME":
                return self._reference()
            case "INT" | "REAL":
                return self._number()
            case "true" | "false":
                self.take()
                return z.Truth(span=self.span(token), value=token.kind == "true")
            case "EMPTY":
                self.take()
                return z.Display(span=self.span(token), kind="set", items=())
            case "(":
                return self._bracketed()
            case "{":
                return self._set()
            case "[":
                return self._schema_text()
            case "SEQUENCE_OPEN":
                return self._display("sequence", "SEQUENCE_CLOSE")
            case "[[":
                return self._display("bag", "]]")
            case "(|":
                return self._binding_display()
            case "forall" | "exists" | "exists1":
                return self._quantified()
            case "lambda" | "mu":
                return self._binding()
            case "if":
                return self._conditional()
            case "let":
                return self._local()
        if token.kind in _WORD_OPERATORS:
            self.take()
            return z.Reference(span=self.span(token), name=str(token.value))
        return self.refuse("an expression")

    def _schema_text(self) -> z.Term:
        """Read ``[x : T; S | p; q]``."""
        start = self.at
        self.opened()
        declarations = self._of_schema(lambda: self.declare_or_include())
        predicates: tuple[z.Term, ...] = ()
        if self.token.kind == "|":
            self.take()
            predicates = self._of_schema(self.expression)
        self.closed("]", "`|`", "`;`")
        return z.SchemaText(span=self.since(start), declarations=declarations, predicates=predicates)

    def _of_schema(self, item: Callable[[], T]) -> tuple[T, ...]:
        """Items that ``;`` separates, or the end of a line."""
        found = [item()]
        while self.token.kind == ";" or (self.token.first and self.token.kind not in ("|", "]", "$END")):
            if self.token.kind == ";":
                self.take()
            found.append(item())
        return tuple(found)

    def declare_or_include(self, *, in_quantifier: bool = False) -> z.Declare:
        """Read ``x : T``, or a schema that is included."""
        if self.at_declaration() or (in_quantifier and self.peek().kind in ("in", ",")):
            return self.declare(in_quantifier=in_quantifier)
        start = self.at
        carrier = self.expression()
        return z.Declare(span=self.since(start), names=(), carrier=carrier)

    def renaming_list(self) -> tuple[tuple[z.Declared, z.Declared], ...]:
        """Read ``[new/old, ...]``."""
        self.opened()
        found = self.list_of(self._renamed_name)
        self.closed("]", "`,`")
        return tuple(found)

    def _renamed_name(self) -> tuple[z.Declared, z.Declared]:
        new = self.declared()
        self.expect("/", help="a renaming is written `[new/old]`")
        return new, self.declared()

    def at_renaming(self) -> bool:
        """Whether ``[new/old`` comes next."""
        tokens = (self.token, self.peek(), self.peek(2), self.peek(3), self.peek(4))
        kinds = [token.kind for token in tokens]
        return kinds[:4] == ["[", "NAME", "/", "NAME"] and kinds[4] in (",", "]") and not self.token.first

    def _reference(self) -> z.Term:
        start = self.at
        token = self.take()
        arguments: tuple[z.Term, ...] = ()
        if self.token.kind == "[" and self.token.tight and not self.token.first and not self.at_renaming():
            self.opened()
            arguments = tuple(self.list_of(self.expression))
            self.closed("]", "`,`")
        return z.Reference(
            span=self.since(start),
            name=str(token.value),
            decoration=self._decoration(token),
            arguments=arguments,
        )

    def _number(self) -> z.Term:
        token = self.take()
        text = str(token.value)
        if len(text) > LONGEST_INTEGER:
            raise Stuck(messages.unexpected(self.span(token), f"number of {len(text)} digits", []))
        return z.Number(span=self.span(token), value=int(text) if token.kind == "INT" else Fraction(text))

    def _bracketed(self) -> z.Term:
        start = self.at
        self.opened()
        items = self.list_of(self.expression)
        self.closed(")", "`,`", "an operator")
        span = self.since(start)
        if len(items) == 1:
            return z.Grouped(span=span, inner=items[0])
        return z.Display(span=span, kind="tuple", items=tuple(items))

    def _display(self, kind: str, closer: str) -> z.Term:
        start = self.at
        self.opened()
        items = [] if self.token.kind == closer else self.list_of(self.expression)
        self.closed(closer, "`,`", "an operator")
        return z.Display(span=self.since(start), kind=kind, items=tuple(items))  # type: ignore[arg-type]

    def _set(self) -> z.Term:
        start = self.at
        if not self._is_comprehension():
            if self._includes():
                return self._schema_set()
            return self._display("set", "}")
        self.opened()
        declarations = self.bound()
        condition = body = None
        if self.token.kind == "|":
            self.take()
            condition = self.expression()
        if self.token.kind == "@":
            self.take()
            body = self.expression()
        self.closed("}", "`|`", "`@`")
        return z.Binding(span=self.since(start), kind="set", declarations=declarations, condition=condition, body=body)

    def _includes(self) -> bool:
        """Whether ``{S |`` or ``{S @`` comes next: a schema, perhaps decorated, declares what is collected."""
        return self.peek().kind == "NAME" and self.peek(2).kind in ("|", "@", ";")

    def _schema_set(self) -> z.Term:
        start = self.at
        self.opened()
        declarations = self.bound(in_quantifier=True)
        condition = body = None
        if self.token.kind == "|":
            self.take()
            condition = self.expression()
        if self.token.kind == "@":
            self.take()
            body = self.expression()
        self.closed("}", "`|`", "`@`")
        return z.Binding(span=self.since(start), kind="set", declarations=declarations, condition=condition, body=body)

    def _is_comprehension(self) -> bool:
        self.at += 1
        try:
            return self.at_declaration()
        finally:
            self.at -= 1

    def _binding_display(self) -> z.Term:
        start = self.at
        self.opened()
        fields = self.list_of(self._definition)
        self.closed("|)", "`,`")
        return z.BindingDisplay(span=self.since(start), fields=tuple(fields))

    def _definition(self) -> tuple[NameDeclaration, z.Term]:
        name = self.name()
        self.expect("==")
        return name, self.expression()

    # --- what extends as far to the right as it can ----------------------------------------------------------

    def _quantified(self) -> z.Term:
        start = self.at
        kind = self.take().kind
        declarations = self.bound(in_quantifier=True)
        condition = None
        if self.token.kind == "|":
            self.take()
            condition = self.expression()
        self.expect("@", "`|`", help="a quantifier is written `forall x : T | condition @ predicate`")
        body = self.expression()
        return z.Quantified(
            span=self.since(start),
            kind=kind,  # type: ignore[arg-type]
            declarations=declarations,
            condition=condition,
            body=body,
        )

    def _binding(self) -> z.Term:
        start = self.at
        kind = self.take().kind
        declarations = self.bound(in_quantifier=True)
        condition = body = None
        if self.token.kind == "|":
            self.take()
            condition = self.expression()
        if self.token.kind == "@" or kind == "lambda":
            self.expect("@", "`|`")
            body = self.expression()
        return z.Binding(
            span=self.since(start),
            kind=kind,  # type: ignore[arg-type]
            declarations=declarations,
            condition=condition,
            body=body,
        )

    def _conditional(self) -> z.Term:
        start = self.at
        self.take()
        test = self.expression()
        self.expect("then", "an operator")
        then = self._branch()
        self.expect("else", "an operator", help="every `if` has its `else`")
        otherwise = self.expression()
        return z.Conditional(span=self.since(start), test=test, then=then, otherwise=otherwise)

    def _branch(self) -> z.Term:
        """Read what stands between ``then`` and ``else``: lines of their own are conjuncts there, too."""
        start = self.at
        term = self.expression()
        while self.token.first and not self.open and not self.token.section and self.token.kind != "else":
            right = self.expression()
            term = z.Operator(span=self.since(start), name="and", operands=(term, right))
        return term

    def _local(self) -> z.Term:
        start = self.at
        self.take()
        definitions = self.list_of(self._definition, ";")
        self.expect("@", "`;`")
        body = self.expression()
        return z.Local(span=self.since(start), definitions=tuple(definitions), body=body)
