r"""Binding powers: from a row of operands and operators to a tree.

The levels are those of the CSPm operator table, tightest first. Three things make CSPm's expressions special:
``.`` binds less tightly than arithmetic, comparison and logic; the parallel operators do not associate (but for the
composition of classes); and ``\``
hides in everything to its left, while what stands to its right takes the hidden process as its left operand:
``P ||| Q \ A`` is ``(P ||| Q) \ A`` and ``P \ A ||| Q`` is ``(P \ A) ||| Q``. And ``|| x : S @ [A] P`` takes in no more
than the right operand of ``[A || B]`` would: ``|| x : S @ [A] P \ H`` hides in all of it.

The method is Dijkstra's shunting yard (operator precedence with two stacks), so that long rows need no recursion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, cast

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing import messages as messages
from cspcheck.cspm.parsing.patterns import BothExpr
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as s

VALUE_LEVELS: Final = {
    "^": 3,
    "*": 5,
    "/": 5,
    "%": 5,
    "+": 6,
    "-": 6,
    "==": 7,
    "!=": 7,
    "<": 7,
    "<=": 7,
    ">": 7,
    ">=": 7,
    "and": 9,
    "or": 10,
    ".": 12,
}
SIGN_LEVELS: Final = {"#": 4, "-": 6, "not": 8}
PROCESS_LEVELS: Final = {
    ";": 16,
    "[>": 17,
    "/\\": 18,
    "/+": 18,
    "[]": 19,
    "[+": 19,
    "|~|": 20,
    "[|": 21,
    "||": 21,
    "[|>": 21,
    "<->": 21,
    "COMPOSES": 21,
    "|||": 22,
    "\\": 23,
    "|\\": 23,
    "@@": 24,
}
COMPARISON: Final = 7
STEP: Final = 15
PARALLEL: Final = 21
BOTH: Final = 24


@dataclass(frozen=True, slots=True)
class RowOperator:
    """An operator in a row: its symbol (as in the level tables), place, and what stands in its brackets."""

    symbol: str
    span: Span
    events: s.Expr | None = None
    right_alphabet: s.Expr | None = None
    links: tuple[tuple[s.Expr, s.Expr], ...] = ()
    statements: tuple[s.Statement, ...] | None = None


@dataclass(frozen=True, slots=True)
class Signed:
    """An operand behind signs (``-``, ``not``, ``#``), outermost first."""

    signs: list[RowOperator]
    operand: s.Expr


@dataclass(frozen=True, slots=True)
class ProcessHead:
    """What stands in front of a process and takes it in: a prefix, a guard, or ``|| x : S @ [A]``."""

    symbol: str
    level: int
    span: Span
    around: Callable[[s.Expr], s.Expr]


@dataclass(slots=True)
class Headed:
    """A process behind heads, innermost first; the innermost is ``|| x : S @ [A]``, which may take in what follows."""

    heads: list[ProcessHead]
    process: s.Expr

    def whole(self) -> s.Expr:
        """The process with its heads, if nothing follows that belongs to it."""
        process = self.process
        for head in self.heads:
            process = head.around(process)
        return process


class OperandRow(list["s.Expr | Signed | Headed | RowOperator"]):
    """Operands (perhaps signed, or behind heads) with an operator between each two."""


Refuse = Callable[[Diagnostic], None]


def values(row: OperandRow | Signed | s.Expr, refuse: Refuse) -> s.Expr:
    """The tree of a row of operators on values; a comparison in a comparison goes to *refuse*."""
    if isinstance(row, s.Expr):
        return row
    operands: list[s.Expr] = []
    pending: list[tuple[int, RowOperator, bool]] = []  # level, operator, whether it is a sign

    def reduce() -> None:
        _, operator, sign = pending.pop()
        right = operands.pop()
        if sign:
            operands.append(
                s.Unary(
                    span=operator.span.to(right.span),
                    operator=cast(s.UnaryOperator, operator.symbol),
                    operand=right,
                )
            )
            return
        left = operands.pop()
        span = left.span.to(right.span)
        if operator.symbol == ".":
            operands.append(s.Dot(span=span, left=left, right=right))
        else:
            operands.append(
                s.Binary(span=span, operator=cast(s.BinaryOperator, operator.symbol), left=left, right=right)
            )

    for item in row if isinstance(row, OperandRow) else (row,):
        if isinstance(item, RowOperator):
            level = VALUE_LEVELS[item.symbol]
            # `.` associates to the right, the others to the left.
            bound = level - 1 if item.symbol == "." else level
            while pending and pending[-1][0] <= bound:
                if level == COMPARISON and pending[-1][0] == COMPARISON:
                    refuse(messages.chained_comparison(item.span, pending[-1][1].span))
                reduce()
            pending.append((level, item, False))
        elif isinstance(item, Signed):
            pending.extend((SIGN_LEVELS[sign.symbol], sign, True) for sign in item.signs)
            operands.append(item.operand)
        else:
            operands.append(cast(s.Expr, item))
    while pending:
        reduce()
    return operands.pop()


def processes(row: OperandRow | Headed | s.Expr, refuse: Refuse, only_pattern: Callable[[s.Expr], None]) -> s.Expr:
    """The tree of a row of process operators.

    Parallel operators side by side go to *refuse*; *only_pattern* is told of each ``@@``.
    """
    if isinstance(row, s.Expr):
        return row
    operands: list[s.Expr] = []
    pending: list[tuple[int, RowOperator | ProcessHead]] = []
    hiding: RowOperator | None = None  # the next operand is the set of this `\` or `|\`

    def reduce() -> None:
        _, operator = pending.pop()
        right = operands.pop()
        if isinstance(operator, ProcessHead):
            operands.append(operator.around(right))
            return
        left = operands.pop()
        made = _process(operator, left, right)
        if isinstance(made, BothExpr):
            only_pattern(made)
        operands.append(made)

    for item in row if isinstance(row, OperandRow) else (row,):
        if isinstance(item, RowOperator):
            level = PROCESS_LEVELS[item.symbol]
            while pending and pending[-1][0] <= level:
                before = pending[-1][1]
                associates = before.symbol == item.symbol == "COMPOSES"
                if level in (PARALLEL, BOTH) and pending[-1][0] == level and not associates:
                    refuse(
                        messages.chained_operator(
                            item.span,
                            before.span,
                            shown(before.symbol),
                            shown(item.symbol),
                            in_front=isinstance(before, ProcessHead),
                        )
                    )
                reduce()
            if item.symbol in ("\\", "|\\"):
                # All to the left is done, and the result is an operand like any other.
                hiding = item
            else:
                pending.append((level, item))
        elif hiding is not None:
            events = item.whole() if isinstance(item, Headed) else cast(s.Expr, item)
            process = operands.pop()
            operands.append(
                s.Hide(span=process.span.to(events.span), process=process, events=events, keep=hiding.symbol == "|\\")
            )
            hiding = None
        elif isinstance(item, Headed):
            pending.extend((head.level, head) for head in reversed(item.heads))
            operands.append(item.process)
        else:
            operands.append(cast(s.Expr, item))
    while pending:
        reduce()
    return operands.pop()


def _process(operator: RowOperator, left: s.Expr, right: s.Expr) -> s.Expr:
    span = left.span.to(right.span)
    symbol = operator.symbol
    match symbol:
        case "[|" | "[+" | "/+" | "[|>":
            assert operator.events is not None
            return s.Synchronised(span=span, operator=symbol, left=left, events=operator.events, right=right)
        case "||":
            assert operator.events is not None
            assert operator.right_alphabet is not None
            return s.AlphabetisedParallel(
                span=span,
                left=left,
                left_alphabet=operator.events,
                right_alphabet=operator.right_alphabet,
                right=right,
            )
        case "<->":
            return s.LinkedParallel(
                span=span, left=left, links=operator.links, right=right, statements=operator.statements
            )
        case "COMPOSES":
            return s.ClassParallel(span=span, left=left, right=right)
        case "@@":
            return BothExpr(span=span, left=left, right=right)
        case _:
            return s.ProcessBinary(span=span, operator=cast(s.ProcessOperator, symbol), left=left, right=right)


def shown(symbol: str) -> str:
    """A process operator as a user writes it."""
    return {
        "[|": "[| A |]",
        "||": "[ A || B ]",
        "[|>": "[| A |>",
        "<->": "[ a <-> b ]",
        "[+": "[+ A +]",
        "/+": "/+ A +\\",
        "COMPOSES": "||",
    }.get(symbol, symbol)
