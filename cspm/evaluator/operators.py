"""Literals and the operators on values. Where both sides are numbers, nothing stands in their way."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from cspcheck.cspm.evaluator.builtins_data import append, length
from cspcheck.cspm.evaluator.core import CONDITIONS, DELAYED, VALUES, Condition, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.comparison import equal, less
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, Thunk
from cspcheck.cspm.values.values import FALSE, TRUE, Sequence, string

# --- literals ------------------------------------------------------------------------------------------------


@VALUES(syntax.LiteralExpr)
@DELAYED(syntax.LiteralExpr)
def _literal(evaluator: Evaluator, node: syntax.LiteralExpr, frame: Frame) -> Code:
    value: Any = node.value
    if node.kind == "bool":
        value = TRUE if value else FALSE
    elif node.kind == "string":
        value = string(str(value))
    return lambda env: value


# --- arithmetic ----------------------------------------------------------------------------------------------

MOST_BITS = 1 << 20
"""Numbers have no more bits than this: some 300,000 digits. One step of arithmetic is then a matter of milliseconds."""
SMALL = 1 << 64
"""Products below this are not measured."""


def product(a: int, b: int) -> int:
    """The product of two numbers.

    Raises:
        Failure: it is too large.
    """
    result = a * b
    return result if -SMALL < result < SMALL else bounded(result)


def bounded(number: int) -> int:
    """*number*, if it is not too large.

    Raises:
        Failure: it is.
    """
    if number.bit_length() > MOST_BITS:
        raise Failure(messages.number_too_large(MOST_BITS), is_limit=True)
    return number


_ARITHMETIC: dict[str, Callable[[int, int], int]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": product,
    "/": operator.floordiv,
    "%": operator.mod,
}


def _refuse(left: Any, right: Any, node: syntax.Binary) -> Failure:
    """The failure of an arithmetic operator on what is not two numbers."""
    if type(left) is int:
        return Failure(messages.wrong_kind("a number", right, node.right.span))
    return Failure(messages.wrong_kind("a number", left, node.left.span))


def _number(node: syntax.Expr) -> int | None:
    """The number that *node* is literally."""
    node = syntax.bare(node)
    if isinstance(node, syntax.LiteralExpr) and node.kind == "int":
        return int(node.value)
    return None


def _arithmetic(evaluator: Evaluator, node: syntax.Binary, frame: Frame) -> Code:
    left = evaluator.value(node.left, frame)
    constant = _number(node.right)
    if constant is not None and (constant or node.operator not in ("/", "%")):
        return _with_constant(left, node, constant)
    right = evaluator.value(node.right, frame)
    if node.operator in ("/", "%"):
        return _division(left, right, node)
    if node.operator == "+":

        def add(env: Env) -> Any:
            a = left(env)
            b = right(env)
            if type(a) is int and type(b) is int:
                return a + b
            raise _refuse(a, b, node)

        return add
    if node.operator == "-":

        def subtract(env: Env) -> Any:
            a = left(env)
            b = right(env)
            if type(a) is int and type(b) is int:
                return a - b
            raise _refuse(a, b, node)

        return subtract

    def multiply(env: Env) -> Any:
        a = left(env)
        b = right(env)
        if type(a) is int and type(b) is int:
            return product(a, b)
        raise _refuse(a, b, node)

    return multiply


def _division(left: Code, right: Code, node: syntax.Binary) -> Code:
    operation = _ARITHMETIC[node.operator]

    def divide(env: Env) -> Any:
        a = left(env)
        b = right(env)
        if type(a) is int and type(b) is int:
            if b == 0:
                raise Failure(messages.division_by_zero(node.operator, a, node.span))
            return operation(a, b)
        raise _refuse(a, b, node)

    return divide


def _with_constant(left: Code, node: syntax.Binary, constant: int) -> Code:
    if node.operator == "+":

        def add(env: Env) -> Any:
            a = left(env)
            if type(a) is int:
                return a + constant
            raise _refuse(a, constant, node)

        return add
    if node.operator == "-":

        def subtract(env: Env) -> Any:
            a = left(env)
            if type(a) is int:
                return a - constant
            raise _refuse(a, constant, node)

        return subtract
    operation = _ARITHMETIC[node.operator]

    def compute(env: Env) -> Any:
        a = left(env)
        if type(a) is int:
            return operation(a, constant)
        raise _refuse(a, constant, node)

    return compute


# --- comparison and logic ------------------------------------------------------------------------------------

_ORDERS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def _located(compare: Callable[[], bool], span: Span) -> bool:
    try:
        return compare()
    except Failure as failure:
        failure.at(span)
        raise


@CONDITIONS(syntax.Binary)
def _condition(evaluator: Evaluator, node: syntax.Binary, frame: Frame) -> Condition:
    symbol = node.operator
    if symbol == "and":
        first = evaluator.condition(node.left, frame)
        second = evaluator.condition(node.right, frame)
        return lambda env: first(env) and second(env)
    if symbol == "or":
        first = evaluator.condition(node.left, frame)
        second = evaluator.condition(node.right, frame)
        return lambda env: first(env) or second(env)
    left = evaluator.value(node.left, frame)
    constant = _number(node.right)
    span = node.span
    if symbol in ("==", "!="):
        wanted = symbol == "=="
        if constant is not None:

            def same_as_constant(env: Env) -> bool:
                a = left(env)
                return (type(a) is int and a == constant) is wanted

            return same_as_constant
        right = evaluator.value(node.right, frame)

        def same(env: Env) -> bool:
            a = left(env)
            b = right(env)
            if type(a) is int and type(b) is int:
                return (a == b) is wanted
            return _located(lambda: equal(a, b), span) is wanted

        return same
    if symbol in _ORDERS:
        return _order(node, left, evaluator.value(node.right, frame))
    value = evaluator.value(node, frame)

    def test(env: Env) -> bool:
        found = value(env)
        raise Failure(messages.wrong_kind("a truth value", found, span))

    return test


def _order(node: syntax.Binary, left: Code, right: Code) -> Condition:
    compare = _ORDERS[node.operator]
    strict = node.operator in ("<", ">")
    swapped = node.operator in (">", ">=")
    span = node.span

    def test(env: Env) -> bool:
        a = left(env)
        b = right(env)
        if type(a) is int and type(b) is int:
            return compare(a, b)
        if swapped:
            return _located(lambda: less(b, a, strict=strict), span)
        return _located(lambda: less(a, b, strict=strict), span)

    return test


@VALUES(syntax.Binary)
def _binary(evaluator: Evaluator, node: syntax.Binary, frame: Frame) -> Code:
    if node.operator in _ARITHMETIC:
        return _arithmetic(evaluator, node, frame)
    if node.operator == "^":
        return _concatenation(evaluator, node, frame)
    condition = _condition(evaluator, node, frame)
    return lambda env: TRUE if condition(env) else FALSE


@CONDITIONS(syntax.Unary)
def _condition_unary(evaluator: Evaluator, node: syntax.Unary, frame: Frame) -> Condition:
    if node.operator == "not":
        condition = evaluator.condition(node.operand, frame)
        return lambda env: not condition(env)
    value = _unary(evaluator, node, frame)
    span = node.span

    def test(env: Env) -> bool:
        raise Failure(messages.wrong_kind("a truth value", value(env), span))

    return test


@VALUES(syntax.Unary)
def _unary(evaluator: Evaluator, node: syntax.Unary, frame: Frame) -> Code:
    if node.operator == "not":
        condition = evaluator.condition(node.operand, frame)
        return lambda env: FALSE if condition(env) else TRUE
    operand = evaluator.value(node.operand, frame)
    span = node.operand.span
    if node.operator == "#":

        def count(env: Env) -> Any:
            try:
                return length(operand(env))
            except Failure as failure:
                failure.at(span)
                raise

        return count
    literal = _number(node.operand)
    if literal is not None:
        return lambda env: -literal

    def negate(env: Env) -> Any:
        a = operand(env)
        if type(a) is int:
            return -a
        raise Failure(messages.wrong_kind("a number", a, span))

    return negate


# --- sequences -----------------------------------------------------------------------------------------------


def _concatenation(evaluator: Evaluator, node: syntax.Binary, frame: Frame) -> Code:
    right = evaluator.delayed(node.right, frame)
    span = node.span
    front = syntax.bare(node.left)
    if isinstance(front, syntax.SequenceExpr) and front.statements is None and len(front.items) == 1:
        item = evaluator.delayed(front.items[0], frame)

        def prepend(env: Env) -> Any:
            rest = right(env)
            if type(rest) is Thunk:
                if rest.code is not None:
                    return Sequence.lazy([item(env)], rest)
                rest = rest.value
            if type(rest) is Sequence:
                return rest.cons(item(env))
            raise Failure(messages.wrong_kind("a sequence", rest, span))

        return prepend
    left = evaluator.value(node.left, frame)
    left_span = node.left.span

    def concatenate(env: Env) -> Any:
        a = left(env)
        if type(a) is not Sequence:
            raise Failure(messages.wrong_kind("a sequence", a, left_span))
        try:
            return append(a, right(env))
        except Failure as failure:
            failure.at(span)
            raise

    return concatenate


# --- what need not be delayed --------------------------------------------------------------------------------


@DELAYED(syntax.Binary)
def _delayed_binary(evaluator: Evaluator, node: syntax.Binary, frame: Frame) -> Code:
    """Sums, differences, products and comparisons of numbers that are there already are worked out at once."""
    delay = evaluator.thunk(node, frame)
    slots = _arithmetic_slots(evaluator, node, frame)
    if slots is None:
        return delay
    value = evaluator.value(node, frame)
    if len(slots) == 1:
        (only,) = slots

        def one(env: Env) -> Any:
            return value(env) if type(env[only]) is int else delay(env)

        return one

    def several(env: Env) -> Any:
        for slot in slots:
            if type(env[slot]) is not int:
                return delay(env)
        return value(env)

    return several


def _arithmetic_slots(evaluator: Evaluator, node: syntax.Expr, frame: Frame) -> tuple[int, ...] | None:
    """The positions of the variables in an expression of local variables and numbers that cannot fail; or None."""
    found: set[int] = set()
    stack = [node]
    while stack:
        current = syntax.bare(stack.pop())
        if isinstance(current, syntax.Binary) and current.operator in ("+", "-", "*", "<", "<=", ">", ">=", "==", "!="):
            stack += (current.left, current.right)
        elif isinstance(current, syntax.Binary) and current.operator in ("/", "%") and _number(current.right):
            stack.append(current.left)
        elif isinstance(current, syntax.Name):
            slot = frame.slots.get(evaluator.names.symbol(current))
            if slot is None:
                return None
            found.add(slot)
        elif _number(current) is None:
            return None
    return tuple(found)


@DELAYED(syntax.Unary)
def _delayed_unary(evaluator: Evaluator, node: syntax.Unary, frame: Frame) -> Code:
    if node.operator == "-" and _number(node.operand) is not None:
        return _unary(evaluator, node, frame)
    return evaluator.thunk(node, frame)
