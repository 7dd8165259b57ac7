"""Core terms as the text notation writes them, with no more brackets than needed.

Coercions are left out, bound variables lose their numbers, and negated relations get their own sign, so that a
computed precondition or a counterexample reads as if it stood in the script.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    Apply,
    Comprehension,
    Constant,
    Construct,
    Field,
    If,
    Quantifier,
    Record,
    Term,
    Variable,
)
from cspcheck.cspm.oz.reading.operators import APPLICATION, BY_NAME, NOT, POSTFIX, RELATION, Spelling

_LOOSEST: Final = 0
_ATOM: Final = 100
_ROLES: Final[Mapping[str, str]] = {"after": "'", "input": "?", "output": "!"}
_COERCIONS: Final = ("int_to_real", "sequence_to_function", "function_to_relation", "bag_to_function")
_NUMBER_SETS: Final = {"Bool": "bool", "Int": "int", "Nat": "nat", "Nat1": "nat1", "Real": "real"}
_BRACKETS: Final = {
    "set": ("{", "}"),
    "sequence": ("<", ">"),
    "bag_display": ("[[", "]]"),
    "function": ("{", "}"),
    "tuple": ("(", ")"),
}
_NEGATED: Final = {"equal": "!=", "in": "notin"}
_SIGNS: Final[Mapping[str, str]] = {"card": "size", "length": "size"}


def text(term: Term) -> str:
    """A term in the text notation, in ASCII."""
    return _write(term)[0]


def written(variable: Variable) -> str:
    """A variable as the text writes it: decorated, without the number of a bound one."""
    return variable.name.split("%")[0] + _ROLES.get(variable.role, "")


def real(value: Fraction) -> str:
    """A real number: with a point if it has a short decimal form, else as a quotient."""
    denominator = value.denominator
    while denominator % 2 == 0:
        denominator //= 2
    while denominator % 5 == 0:
        denominator //= 5
    if denominator != 1:
        return f"{value.numerator}.0 / {value.denominator}.0"
    digits = 1
    while (value * 10**digits).denominator != 1:
        digits += 1
    scaled = abs(value * 10**digits)
    whole, rest = divmod(int(scaled), 10**digits)
    return f"{'-' if value < 0 else ''}{whole}.{rest:0{digits}}"


def _write(term: Term) -> tuple[str, int]:
    """The text of a term and how tightly it holds together."""
    match term:
        case Constant(value=bool() as truth):
            return ("true" if truth else "false"), _ATOM
        case Constant(type=core.RealType(), value=value):
            shown = real(Fraction(value))
            return shown, 40 if "/" in shown else 80 if value < 0 else _ATOM
        case Constant(value=value):
            return str(value), 80 if value < 0 else _ATOM
        case Variable():
            return written(term), _ATOM
        case Construct():
            if term.argument is None:
                return term.constructor, _ATOM
            return f"{term.constructor}({text(term.argument)})", APPLICATION
        case Record():
            names = [name for name, _ in term.type.fields] if isinstance(term.type, core.RecordType) else []
            fields = [f"{name} == {text(value)}" for name, value in zip(names, term.values, strict=True)]
            return f"(| {', '.join(fields)} |)", _ATOM
        case Field():
            return f"{_inside(term.record, POSTFIX)}.{term.name}", POSTFIX
        case If():
            return f"if {text(term.test)} then {text(term.then)} else {text(term.otherwise)}", _LOOSEST
        case Quantifier() | Comprehension():
            return _binding(term)
        case Apply():
            return _apply(term)
    raise TypeError(f"not a core term: {term!r}")


def _inside(term: Term, least: int) -> str:
    shown, tightness = _write(term)
    return shown if tightness >= least else f"({shown})"


def _binding(term: Quantifier | Comprehension) -> tuple[str, int]:
    groups: list[tuple[list[str], str]] = []
    for binder in term.binders:
        carrier = text(binder.carrier)
        if groups and groups[-1][1] == carrier:
            groups[-1][0].append(binder.written)
        else:
            groups.append(([binder.written], carrier))
    declared = "; ".join(f"{', '.join(names)} : {carrier}" for names, carrier in groups)
    condition = "" if _is_true(term.condition) else f" | {text(term.condition)}"
    if isinstance(term, Comprehension):
        if term.kind == "set":
            plain = len(term.binders) == 1 and _is_bound(term.body, term.binders[0])
            body = "" if plain else f" @ {text(term.body)}"
            return f"{{ {declared}{condition}{body} }}", _ATOM
        plain = term.kind == "mu" and len(term.binders) == 1 and _is_bound(term.body, term.binders[0])
        return f"({term.kind} {declared}{condition}{'' if plain else f' @ {text(term.body)}'})", _ATOM
    if _is_true(term.body) and condition:
        condition, body = "", text(term.condition)
    else:
        body = text(term.body)
    return f"{term.kind} {declared}{condition} @ {body}", _LOOSEST


def _is_true(term: Term) -> bool:
    return isinstance(term, Constant) and term.value is True


def _is_bound(term: Term, binder: core.Binder) -> bool:
    return isinstance(term, Variable) and term.role == "bound" and term.name == binder.name


def _apply(term: Apply) -> tuple[str, int]:
    operator, operands = term.operator, term.operands
    match operator:
        case _ if operator in _COERCIONS:
            inner = operands[0]
            if operator == "int_to_real" and isinstance(inner, Constant):
                return f"{inner.value}.0", 80 if inner.value < 0 else _ATOM
            return _write(inner)
        case "not":
            return _negation(operands[0])
        case "All" | "Records" | "AllRecords":
            return str(term.type.element if isinstance(term.type, core.SetType) else term.type), _ATOM
        case "function":
            return "{" + ", ".join(_maplet(pair) for pair in operands) + "}", _ATOM
        case "range":
            low, high = operands
            return f"{_inside(low, 21)}..{_inside(high, 21)}", 20
        case "image":
            return f"{_inside(operands[0], POSTFIX)}(| {text(operands[1])} |)", POSTFIX
        case "init":
            return f"{_inside(operands[0], POSTFIX)}.INIT", POSTFIX
        case "apply":
            return _application(operands[0], operands[1]), APPLICATION
        case "item":
            return _item(term)
        case "negate":
            return f"-{_inside(operands[0], 80)}", 80
    if operator in _NUMBER_SETS:
        return _NUMBER_SETS[operator], _ATOM
    if operator in _BRACKETS:
        opening, closing = _BRACKETS[operator]
        return opening + ", ".join(map(text, operands)) + closing, _ATOM
    return _spelt(operator, operands)


def _spelt(operator: str, operands: tuple[Term, ...]) -> tuple[str, int]:
    """An operator of the table of spellings, or a function of the toolkit."""
    name = _SIGNS.get(operator, operator)
    for kind in ("infix", "relation", "prefix", "postfix"):
        spelling = BY_NAME.get((name, kind))
        if spelling is None:
            continue
        sign = spelling.text[0]
        level = spelling.precedence
        match kind:
            case "infix" if operator == "and":
                pieces = _chained(operands)
                return " and ".join(pieces), level if len(pieces) > 1 else RELATION
            case "infix" if operator in ("or", "cross"):
                return f" {sign} ".join(_inside(operand, level + 1) for operand in operands), level
            case "infix":
                return _infix(spelling, *operands), level
            case "relation" if operator == "partition":
                parts = ", ".join(map(text, operands[1:]))
                return f"<{parts}> {sign} {_inside(operands[0], level + 1)}", level
            case "relation":
                left, right = (_inside(operand, level + 1) for operand in operands)
                return f"{left} {sign} {right}", level
            case "prefix" if operator == "disjoint":
                return f"{sign} <{', '.join(map(text, operands))}>", level
            case "prefix":
                gap = " " if sign[0].isalpha() else ""
                return f"{sign}{gap}{_inside(operands[0], level)}", level
            case _:
                return f"{_inside(operands[0], level)}{sign}", level
    return f"{operator}({', '.join(map(text, operands))})", APPLICATION


_COMPARISONS: Final = {"less": "<", "at_most": "<=", "equal": "=", "in": "in", "subset": "subseteq"}


def _chained(operands: tuple[Term, ...]) -> list[str]:
    """The texts of conjuncts; neighbours such as ``0 <= x`` and ``x < 10`` as one chain."""
    pieces: list[str] = []
    end: Term | None = None
    for operand in operands:
        if not isinstance(operand, Apply) or operand.operator not in _COMPARISONS:
            pieces.append(_inside(operand, NOT))
            end = None
            continue
        left, right = operand.operands
        if end is not None and left == end:
            pieces[-1] += f" {_COMPARISONS[operand.operator]} {_inside(right, RELATION + 1)}"
        else:
            pieces.append(_inside(operand, RELATION))
        end = right if operand.operator in ("less", "at_most") else None
    return pieces


def _infix(spelling: Spelling, left: Term, right: Term) -> str:
    level = spelling.precedence
    to_the_right = spelling.associativity == "right"
    first = _inside(left, level + 1 if to_the_right else level)
    second = _inside(right, level if to_the_right else level + 1)
    return f"{first} {spelling.text[0]} {second}"


def _negation(inner: Term) -> tuple[str, int]:
    if isinstance(inner, Apply):
        left_right = inner.operands
        if inner.operator in _NEGATED:
            left, right = (_inside(operand, RELATION + 1) for operand in left_right)
            return f"{left} {_NEGATED[inner.operator]} {right}", RELATION
        if inner.operator in ("less", "at_most"):
            left, right = (_inside(operand, RELATION + 1) for operand in left_right)
            return f"{left} {'>=' if inner.operator == 'less' else '>'} {right}", RELATION
    return f"not {_inside(inner, NOT)}", NOT


def _maplet(pair: Term) -> str:
    if isinstance(pair, Apply) and pair.operator == "tuple" and len(pair.operands) == 2:
        left, right = (_inside(operand, 11) for operand in pair.operands)
        return f"{left} |-> {right}"
    return text(pair)


def _application(function: Term, argument: Term) -> str:
    shown = _inside(function, APPLICATION)
    if isinstance(argument, Apply) and argument.operator == "tuple":
        return f"{shown}{text(argument)}"
    return f"{shown}({text(argument)})"


def _item(term: Apply) -> tuple[str, int]:
    whole, index = term.operands
    assert isinstance(index, Constant)
    if isinstance(whole.type, core.TupleType) and len(whole.type.items) == 2:
        return f"{('first', 'second')[int(index.value)]}({text(whole)})", APPLICATION
    return f"{_inside(whole, POSTFIX)}.{int(index.value) + 1}", POSTFIX
