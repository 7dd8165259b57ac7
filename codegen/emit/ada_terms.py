"""Predicates and terms of Object-Z as expressions of Ada 2012, fit for the contracts of SPARK.

Integers, truth values and enumerations have a counterpart, and what is said of them: arithmetic, order, membership,
quantifiers over ranges. What is composite stands in brackets, since Ada has no order between ``and`` and ``or``.
"""

from __future__ import annotations

import operator
from collections.abc import Callable

from cspcheck.codegen.quoting import ada_name
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.terms import show_term

_INFIX = {
    "less": "<",
    "at_most": "<=",
    "plus": "+",
    "minus": "-",
    "times": "*",
    "mod": "mod",
}


class NoCounterpart(Exception):
    """A term or set has no counterpart in Ada here; the argument says which."""


def bare(text: str) -> str:
    """An expression without brackets around the whole.

    >>> bare("(A and B)"), bare("(A) and (B)")
    ('A and B', '(A) and (B)')
    """
    while text.startswith("(") and text.endswith(")"):
        depth = 0
        for position, sign in enumerate(text):
            depth += (sign == "(") - (sign == ")")
            if depth == 0 and position < len(text) - 1:
                return text
        if text.startswith(("(if ", "(for ", "(-")):
            return text
        text = text[1:-1]
    return text


class AdaTerms:
    """Translates terms.

    Args:
        variable: what a variable is called (with the state that it belongs to).
        enumeration: the name of the type of a given or free type; None if it is none of constants only.
    """

    def __init__(
        self, variable: Callable[[core.Variable], str], enumeration: Callable[[core.Type], str | None]
    ) -> None:
        self._variable = variable
        self._enumeration = enumeration
        self._bound: dict[str, str] = {}

    def all(self, terms: tuple[core.Term, ...]) -> str:
        """That all of some predicates hold.

        Raises:
            NoCounterpart: one has none.
        """
        return "\n         and then ".join(map(self.text, terms)) or "True"

    def text(self, term: core.Term) -> str:
        """A term, in brackets if it is composite.

        Raises:
            NoCounterpart: it has none.
        """
        match term:
            case core.Constant(value=bool() as value):
                return "True" if value else "False"
            case core.Constant(value=int() as value):
                return str(value) if value >= 0 else f"({value})"
            case core.Variable(role="bound"):
                return self._bound.get(term.name) or self._variable(term)
            case core.Variable():
                return self._variable(term)
            case core.Construct(argument=None):
                kind = self._enumeration(term.type)
                if kind is not None:
                    return f"{kind}'({ada_name(term.constructor)})"
            case core.If():
                text = f"(if {self.text(term.test)} then {self.text(term.then)} else {self.text(term.otherwise)})"
                # Literals alone would leave open which integer type is meant.
                return f"Integer'{text}" if isinstance(term.type, core.IntType) else text
            case core.Quantifier(kind="forall" | "exists"):
                return self._quantifier(term)
            case core.Apply():
                return self._apply(term)
        raise NoCounterpart(show_term(term))

    def _apply(self, term: core.Apply) -> str:
        kind, operands = term.operator, term.operands
        value = _number(term)
        if value is not None:  # what has no variable is written as its value
            return str(value) if value >= 0 else f"({value})"
        if kind in _INFIX:
            left, right = map(self.text, operands)
            return f"({left} {_INFIX[kind]} {right})"
        match kind:
            case "not":
                return f"(not {self.text(operands[0])})"
            case "and" | "or":
                word = "and then" if kind == "and" else "or else"
                return f"({f' {word} '.join(map(self.text, operands))})"
            case "implies":
                return f"(if {self.text(operands[0])} then {self.text(operands[1])})"
            case "equal" | "iff":
                return f"({self.text(operands[0])} = {self.text(operands[1])})"
            case "negate" | "abs":
                return f"({'-' if kind == 'negate' else 'abs '}{self.text(operands[0])})"
            case "div":  # Ada's / rounds towards zero, its mod has the sign of the divisor like that of Z
                a, b = map(self.text, operands)
                return f"(({a} - {a} mod {b}) / {b})"
            case "in":
                return self._membership(operands[0], operands[1])
        raise NoCounterpart(show_term(term))

    def _membership(self, value: core.Term, carrier: core.Term) -> str:
        text = self.text(value)
        if isinstance(carrier, core.Apply):
            match carrier.operator:
                case "Int" | "Bool" | "All":
                    return "True"
                case "Nat":
                    return f"({text} >= 0)"
                case "Nat1":
                    return f"({text} >= 1)"
                case "set" if carrier.operands:
                    return f"({' or else '.join(f'({text} = {self.text(one)})' for one in carrier.operands)})"
        return f"({text} in {self.domain(carrier)})"

    def domain(self, carrier: core.Term) -> str:
        """A set as what a loop goes over.

        Raises:
            NoCounterpart: it is no range and no enumeration.
        """
        if isinstance(carrier, core.Apply):
            match carrier.operator:
                case "range":
                    low, high = map(self.text, carrier.operands)
                    return f"{low} .. {high}"
                case "Bool":
                    return "Boolean"
                case "All" if isinstance(carrier.type, core.SetType):
                    kind = self._enumeration(carrier.type.element)
                    if kind is not None:
                        return kind
        raise NoCounterpart(show_term(carrier))

    def _quantifier(self, term: core.Quantifier) -> str:
        before = dict(self._bound)
        heads = []
        word = "all" if term.kind == "forall" else "some"
        for binder in term.binders:
            domain = self.domain(binder.carrier)
            name = f"{ada_name(binder.written)}_{len(self._bound) + 1}"
            self._bound[binder.name] = name
            heads.append(f"(for {word} {name} in {domain} => ")
        body = self.text(term.body)
        if not (isinstance(term.condition, core.Constant) and term.condition.value is True):
            condition = self.text(term.condition)
            body = f"(if {condition} then {body})" if word == "all" else f"({condition} and then {body})"
        self._bound = before
        return f"{''.join(heads)}{body}{')' * len(heads)}"


def _number(term: core.Term) -> int | None:
    """The value of an integer term of constants; None if it is none."""
    if isinstance(term, core.Constant):
        return term.value if isinstance(term.value, int) and not isinstance(term.value, bool) else None
    if not isinstance(term, core.Apply) or term.operator not in _ARITHMETIC:
        return None
    values = [_number(operand) for operand in term.operands]
    numbers = [value for value in values if value is not None]
    if len(numbers) < len(values) or (term.operator in ("div", "mod") and numbers[1] == 0):
        return None
    return _ARITHMETIC[term.operator](*numbers)


_ARITHMETIC: dict[str, Callable[..., int]] = {
    "plus": operator.add,
    "minus": operator.sub,
    "times": operator.mul,
    "div": operator.floordiv,
    "mod": operator.mod,
    "negate": operator.neg,
    "abs": abs,
}
