"""Binding powers: from a row of operands and operators to a tree, by the table of operators.

The method is Dijkstra's shunting yard (operator precedence with two stacks), so that long rows need no recursion and
an operator is a line of a table. A prefix operator takes in what binds at least as tightly as it does; relations
side by side form one chain, and ``A cross B cross C`` is a set of triples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, Literal, NamedTuple

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading.operators import RELATION, Spelling
from cspcheck.cspm.source import Span

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


class Infix(NamedTuple):
    """An operator between two operands."""

    spelling: Spelling


class PrefixedOperand(NamedTuple):
    """An operand behind prefix operators, each with its place, the innermost first."""

    signs: list[tuple[Spelling, Span]]
    operand: z.Term


Row = list["z.Term | PrefixedOperand | Infix"]
"""Operands, perhaps signed, with an operator between each two."""


class _Pending:
    """An operator whose last operand is still to be read, with its operands so far on the stack.

    ``least`` is how tightly an operator must bind to belong to that operand.
    """

    __slots__ = ("least", "operands", "relations", "spelling", "start")

    def __init__(self, spelling: Spelling, least: int, start: Span | None) -> None:
        self.spelling = spelling
        self.least = least
        self.start = start  # of a prefix operator
        self.operands = 1 if start is not None else 2
        self.relations = [spelling.name]


def tree(row: Sequence[z.Term | PrefixedOperand | Infix]) -> z.Term:
    """The tree of a row."""
    operands: list[z.Term] = []
    pending: list[_Pending] = []

    def reduce() -> None:
        top = pending.pop()
        taken = tuple(operands[-top.operands :])
        del operands[-top.operands :]
        span = (taken[0].span if top.start is None else top.start).to(taken[-1].span)
        if top.start is None and top.spelling.kind == "relation":
            operands.append(z.Chain(span=span, relations=tuple(top.relations), operands=taken))
        else:
            operands.append(z.Operator(span=span, name=top.spelling.name, operands=taken))

    for item in row:
        if isinstance(item, Infix):
            spelling = item.spelling
            while pending and spelling.precedence < pending[-1].least:
                top = pending[-1]
                if top.start is None and _goes_on(top.spelling, spelling):
                    break
                reduce()
            if pending and pending[-1].start is None and _goes_on(pending[-1].spelling, spelling):
                pending[-1].operands += 1
                pending[-1].relations.append(spelling.name)
            else:
                tighter = spelling.kind == "relation" or spelling.associativity == "left"
                pending.append(_Pending(spelling, spelling.precedence + tighter, None))
        elif isinstance(item, PrefixedOperand):
            for spelling, span in reversed(item.signs):
                least = RELATION + 1 if spelling.precedence == RELATION else spelling.precedence
                pending.append(_Pending(spelling, least, span))
            operands.append(item.operand)
        else:
            operands.append(item)
    while pending:
        reduce()
    return operands.pop()


def _goes_on(before: Spelling, spelling: Spelling) -> bool:
    """Whether an operator goes on with what the one before it began."""
    return before.kind == spelling.kind == "relation" or before.name == spelling.name == "cross"


OperationRow = list["z.Term | str"]
"""Operations with the token of an operator between each two; what ``\\`` hides is an operand."""


def operation_tree(row: Sequence[z.Term | str]) -> z.Term:
    """The tree of a row of operations; all operators associate to the left."""
    operands: list[z.Term] = []
    pending: list[tuple[str, int]] = []

    def reduce() -> None:
        name, _ = pending.pop()
        left, right = operands[-2:]
        operands[-2:] = [z.Operator(span=left.span.to(right.span), name=name, operands=(left, right))]

    for item in row:
        if isinstance(item, str):
            operator = OPERATION_OPERATORS[item]
            while pending and pending[-1][1] >= operator[1]:
                reduce()
            pending.append(operator)
        else:
            operands.append(item)
    while pending:
        reduce()
    return operands.pop()
