# ruff: noqa: D102 - an action is documented by the alternative of the grammar that it is named in
"""From the parts of each grammar rule to the node of the syntax tree: the actions of ``grammar/oz.lark`` for terms.

A part that the grammar keeps as a token arrives as the token's index. Mistakes that a grammar cannot express are
collected in ``errors``, each with the index of the token at which it shows.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Final, Literal, cast

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as messages
from cspcheck.cspm.oz.reading.layout import Laid
from cspcheck.cspm.oz.reading.lexer import INFIX, NAMING, POSTFIX, PREFIX, Token
from cspcheck.cspm.oz.reading.operators import inrel
from cspcheck.cspm.oz.reading.precedence import DISTRIBUTED, Infix, PrefixedOperand, Row, operation_tree, tree
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax.tree import NameDeclaration

LONGEST_INTEGER: Final = 4000
"""Digits beyond which a number is refused (Python converts no more than 4300)."""

_LOGICAL: Final = frozenset(["and", "or", "implies", "iff", "not"])
_MINUS: Final = "a line that begins with `-` is a predicate of its own; put the sign at the end of the line before"

Suffix = Callable[[Span, z.Term], z.Term]
Part = z.Term | PrefixedOperand | Row
Names = tuple[NameDeclaration, ...]


class RefusedToken(Exception):
    """The grammar admits the token at ``index``, but it cannot be what it would be taken for."""

    def __init__(self, index: int) -> None:
        self.index = index
        super().__init__(index)


class TermBuilder:
    """Builds names, declarations, expressions and predicates."""

    def __init__(self, laid: Laid) -> None:
        self.laid = laid
        self.errors: list[tuple[int, Diagnostic]] = []

    # --- tokens ----------------------------------------------------------------------------------------------

    def token(self, index: int) -> Token:
        """The token that a terminal stands for."""
        return self.laid.found[self.laid.origins[index]]

    def index_at(self, span: Span) -> int:
        """The first terminal of a part."""
        index = bisect_left(self.laid.starts, span.start)
        while self.laid.kinds[index].startswith("_") and self.laid.starts[index] == self.laid.ends[index]:
            index += 1  # of no width, behind the part before
        return index

    def _decorated(self, index: int) -> tuple[str, z.Decoration]:
        """A name with its last stroke apart: ``c!!`` is the output of ``c!``."""
        token = self.token(index)
        name, decoration = str(token.value), token.decoration
        if len(decoration) > 1 and set(decoration) == {"'"}:
            self.errors.append((index, messages.several_primes(self.laid.span(index))))
            return name, "'"
        return name + decoration[:-1], cast(z.Decoration, decoration[-1:])

    def name(self, span: Span, index: int) -> NameDeclaration:
        token = self.token(index)
        if token.decoration:
            raise RefusedToken(index)
        return NameDeclaration(span=span, name=str(token.value))

    # --- declarations ----------------------------------------------------------------------------------------

    def declared(self, span: Span, index: int) -> z.Declared:
        token = self.token(index)
        if token.kind != "NAME" and token.kind not in NAMING:
            raise RefusedToken(index)
        name, decoration = self._decorated(index)
        return z.Declared(span=span, name=name, decoration=decoration)

    def declare(self, span: Span, names: list[z.Declared], carrier: z.Term) -> z.Declare:
        return z.Declare(span=span, names=tuple(names), carrier=carrier)

    def inclusion(self, span: Span, carrier: z.Term) -> z.Declare:
        return z.Declare(span=span, names=(), carrier=carrier)

    def inclusion_line(self, span: Span, carrier: z.Term) -> z.Declare:
        index = self.index_at(span)
        if not self.laid.includes(self.laid.origins[index]):
            raise RefusedToken(index)
        return self.inclusion(span, carrier)

    def unread(self, span: Span, index: int) -> None:
        return None

    def predicate(self, span: Span, term: z.Term) -> z.Term:
        if isinstance(term, z.Operator) and term.name not in _LOGICAL:
            index = self.index_at(span)
            if self.laid.kinds[index] == "-" and self.laid.kinds[index - 1] in ("_NEWLINE", ";"):
                # A number is no predicate: the line was meant to go on with the one before.
                found = messages.unexpected(self.laid.span(index), "`-`", ["a predicate"], help=_MINUS)
                self.errors.append((index, found))
        return term

    def pair(self, span: Span, left: object, right: object) -> tuple[object, object]:
        return left, right

    # --- rows ------------------------------------------------------------------------------------------------

    def row(self, span: Span, row: Part, operator: int, operand: z.Term | PrefixedOperand) -> Row:
        token = self.token(operator)
        named = self.laid.kinds[operator] == "RELATION"
        infix = Infix(inrel("".join(self._decorated(operator))) if named else INFIX[token.kind])
        if isinstance(row, list):
            row += (infix, operand)
            return row
        return [row, infix, operand]

    def prefixed(self, span: Span, sign: int, operand: z.Term | PrefixedOperand) -> PrefixedOperand:
        if not isinstance(operand, PrefixedOperand):
            operand = PrefixedOperand([], operand)
        operand.signs.append((PREFIX[self.token(sign).kind], self.laid.span(sign)))
        return operand

    def term(self, span: Span, row: Part) -> z.Term:
        if isinstance(row, z.Term):
            return row
        return tree(row if isinstance(row, list) else [row])

    # --- what is open ----------------------------------------------------------------------------------------

    def _quantified(
        self,
        span: Span,
        kind: Literal["forall", "exists", "exists1"],
        declarations: list[z.Declare],
        condition: z.Term,
        body: z.Term,
    ) -> z.Term:
        return z.Quantified(
            span=span, kind=kind, declarations=tuple(declarations), condition=condition or None, body=body
        )

    def forall(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._quantified(span, "forall", declarations, condition, body)

    def exists(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._quantified(span, "exists", declarations, condition, body)

    def exists1(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._quantified(span, "exists1", declarations, condition, body)

    def _binding(
        self,
        span: Span,
        kind: Literal["set", "lambda", "mu"],
        declarations: list[z.Declare],
        condition: z.Term,
        body: z.Term,
    ) -> z.Term:
        return z.Binding(
            span=span, kind=kind, declarations=tuple(declarations), condition=condition or None, body=body or None
        )

    def lambda_(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._binding(span, "lambda", declarations, condition, body)

    def mu(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._binding(span, "mu", declarations, condition, body)

    def comprehension(self, span: Span, declarations: list[z.Declare], condition: z.Term, body: z.Term) -> z.Term:
        return self._binding(span, "set", declarations, condition, body)

    def conditional(self, span: Span, test: z.Term, then: z.Term, otherwise: z.Term) -> z.Term:
        return z.Conditional(span=span, test=test, then=then, otherwise=otherwise)

    def conjunction(self, span: Span, left: z.Term, right: z.Term) -> z.Term:
        return z.Operator(span=span, name="and", operands=(left, right))

    def local(self, span: Span, definitions: list[tuple[NameDeclaration, z.Term]], body: z.Term) -> z.Term:
        return z.Local(span=span, definitions=tuple(definitions), body=body)

    # --- applications ----------------------------------------------------------------------------------------

    def applied(self, span: Span, function: z.Term, argument: z.Term) -> z.Term:
        return z.Application(span=span, function=function, argument=argument, bracketed=False)

    def suffixed(self, span: Span, term: z.Term, suffix: Suffix) -> z.Term:
        return suffix(span, term)

    def arguments(self, span: Span, items: Sequence[z.Term] = ()) -> Suffix:
        argument = items[0] if len(items) == 1 else z.Display(span=span, kind="tuple", items=tuple(items))
        return lambda span, term: z.Application(span=span, function=term, argument=argument)

    def field(self, span: Span, index: int) -> Suffix:
        name, decoration = self._decorated(index)
        return lambda span, term: z.Selection(span=span, record=term, field=name, decoration=decoration)

    def image(self, span: Span, argument: z.Term) -> Suffix:
        return lambda span, term: z.Operator(span=span, name="image", operands=(term, argument))

    def renaming_suffix(self, span: Span, renamings: list[tuple[z.Declared, z.Declared]]) -> Suffix:
        return lambda span, term: z.Renamed(term=term, renamings=tuple(renamings), span=span)

    def postfix(self, span: Span, index: int) -> Suffix:
        name = POSTFIX[self.token(index).kind].name
        return lambda span, term: z.Operator(span=span, name=name, operands=(term,))

    # --- atoms -----------------------------------------------------------------------------------------------

    def number(self, span: Span, index: int) -> z.Term:
        token = self.token(index)
        text = str(token.value)
        if len(text) > LONGEST_INTEGER:
            self.errors.append((index, messages.unexpected(span, f"number of {len(text)} digits", [])))
            text = "0"
        return z.Number(span=span, value=int(text) if token.kind == "INT" else Fraction(text))

    def true(self, span: Span) -> z.Term:
        return z.Truth(span=span, value=True)

    def false(self, span: Span) -> z.Term:
        return z.Truth(span=span, value=False)

    def reference(self, span: Span, index: int, arguments: Sequence[z.Term] = ()) -> z.Term:
        name, decoration = self._decorated(index)
        return z.Reference(span=span, name=name, decoration=decoration, arguments=tuple(arguments))

    def word(self, span: Span, index: int) -> z.Term:
        return z.Reference(span=span, name=str(self.token(index).value))

    def bracketed(self, span: Span, items: list[z.Term]) -> z.Term:
        if len(items) == 1:
            return z.Grouped(span=span, inner=items[0])
        return z.Display(span=span, kind="tuple", items=tuple(items))

    def set_(self, span: Span, items: Sequence[z.Term] | int = ()) -> z.Term:
        return z.Display(span=span, kind="set", items=() if isinstance(items, int) else tuple(items))

    def sequence(self, span: Span, opening: int, *rest: Sequence[z.Term] | int) -> z.Term:
        items = rest[0]
        return z.Display(span=span, kind="sequence", items=() if isinstance(items, int) else tuple(items))

    def bag(self, span: Span, items: Sequence[z.Term] = ()) -> z.Term:
        return z.Display(span=span, kind="bag", items=tuple(items))

    def binding_display(self, span: Span, fields: list[tuple[NameDeclaration, z.Term]]) -> z.Term:
        return z.BindingDisplay(span=span, fields=tuple(fields))

    def schema_text(self, span: Span, declarations: list[z.Declare], predicates: Sequence[z.Term] = ()) -> z.Term:
        return z.SchemaText(span=span, declarations=tuple(declarations), predicates=tuple(predicates))

    def schema_of_nothing(self, span: Span, predicates: list[z.Term]) -> z.Term:
        return z.SchemaText(span=span, declarations=(), predicates=tuple(predicates))

    # --- operations by others --------------------------------------------------------------------------------

    def operation_row(self, span: Span, row: z.Term | list[z.Term | str], operator: int, operand: z.Term) -> object:
        row = row if isinstance(row, list) else [row]
        row += (self.laid.kinds[operator], operand)
        return row

    def hiding(self, span: Span, row: z.Term | list[z.Term | str], hidden: z.Term) -> object:
        row = row if isinstance(row, list) else [row]
        row += ("\\", hidden)
        return row

    def operation(self, span: Span, row: z.Term | list[z.Term | str]) -> z.Term:
        return operation_tree(row) if isinstance(row, list) else row

    def hidden(self, span: Span, names: list[z.Term]) -> z.Term:
        return z.Display(span=span, kind="set", items=tuple(names))

    def grouped(self, span: Span, inner: z.Term) -> z.Term:
        return z.Grouped(span=span, inner=inner)

    def operation_reference(self, span: Span, index: int) -> z.Term:
        name, decoration = self._decorated(index)
        return z.Reference(span=span, name=name, decoration=decoration)

    def operation_of_object(self, span: Span, record: z.Term, field: NameDeclaration) -> z.Term:
        return z.Selection(span=span, record=record, field=field.name)

    def renamed_operation(
        self, span: Span, term: z.Term, bracket: int, renamings: list[tuple[z.Declared, z.Declared]]
    ) -> z.Term:
        return z.Renamed(term=term, renamings=tuple(renamings), span=span)

    def guard_text(self, span: Span, guards: Sequence[z.Term] = ()) -> z.OperationText:
        return z.OperationText(span=span, delta=None, predicates=tuple(guards))

    def declared_text(self, span: Span, declarations: list[z.Declare], guards: list[z.Term]) -> z.OperationText:
        return z.OperationText(span=span, delta=None, declarations=tuple(declarations), predicates=tuple(guards))

    def delta_text(self, span: Span, delta: Names, guards: list[z.Term]) -> z.OperationText:
        return z.OperationText(span=span, delta=delta, predicates=tuple(guards))

    def delta_and_declared_text(
        self, span: Span, delta: Names, declarations: list[z.Declare], guards: list[z.Term]
    ) -> z.OperationText:
        return z.OperationText(span=span, delta=delta, declarations=tuple(declarations), predicates=tuple(guards))

    def delta(self, span: Span, names: Sequence[NameDeclaration] = ()) -> Names:
        return tuple(names)

    def distributed(
        self, span: Span, operator: int, declarations: list[z.Declare], condition: z.Term, body: z.Term
    ) -> z.Term:
        kind = DISTRIBUTED[self.laid.kinds[operator]]
        return z.Distributed(
            span=span, kind=kind, declarations=tuple(declarations), condition=condition or None, body=body
        )
