"""Looking at core terms: as text, up to the names of bound variables, and the variables that they use."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import replace
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
    parts,
)

_INFIX: Final = {
    "and": "and",
    "or": "or",
    "implies": "=>",
    "iff": "<=>",
    "equal": "=",
    "in": "in",
    "less": "<",
    "at_most": "<=",
    "plus": "+",
    "minus": "-",
    "times": "*",
    "divide": "/",
    "div": "div",
    "mod": "mod",
    "range": "..",
    "union": "union",
    "inter": "inter",
    "diff": "\\",
    "symdiff": "symdiff",
    "subset": "subseteq",
    "proper_subset": "subset",
    "cross": "cross",
    "rel": "<->",
    "pfun": "-|->",
    "fun": "-->",
    "pinj": ">-|->",
    "inj": ">-->",
    "psurj": "-|->>",
    "surj": "-->>",
    "bij": ">-->>",
    "ffun": "-||->",
    "finj": ">-||->",
    "compose": "comp",
    "dom_restrict": "<|",
    "ran_restrict": "|>",
    "dom_subtract": "</|",
    "ran_subtract": "|/>",
    "override": "(+)",
    "concat": "^",
    "filter": "filter",
    "extract": "extract",
    "prefix": "prefix",
    "suffix": "suffix",
    "infix": "infix",
    "bag_union": "bag_union",
    "in_bag": "inbag",
    "partition": "partition",
}
_PREFIX: Final = {
    "not": "not",
    "negate": "-",
    "power": "power",
    "power1": "power1",
    "finset": "finset",
    "finset1": "finset1",
    "seq": "seq",
    "seq1": "seq1",
    "iseq": "iseq",
    "bag": "bag",
    "dom": "dom",
    "ran": "ran",
    "id": "id",
    "Union": "bigunion",
    "Inter": "biginter",
    "card": "#",
    "length": "#",
    "flatten": "flatten",
    "disjoint": "disjoint",
}
_SETS: Final = {"Bool": "bool", "Int": "int", "Nat": "nat", "Nat1": "nat1", "Real": "real"}
_COERCIONS: Final = ("int_to_real", "sequence_to_function", "function_to_relation", "bag_to_function")
_DISPLAYS: Final = {
    "tuple": ("(", ")"),
    "set": ("{", "}"),
    "sequence": ("<", ">"),
    "bag_display": ("[[", "]]"),
    "function": ("{", "}"),
}
_ROLES: Final[Mapping[str, str]] = {"after": "'", "input": "?", "output": "!"}


def show_term(term: Term) -> str:
    """A term in the text notation. Bracketed more than a person would, coercions left out."""
    match term:
        case Constant(value=bool()):
            return "true" if term.value else "false"
        case Constant(value=Fraction() as real):
            from cspcheck.cspm.values.text import show_real

            text = show_real(real)
            return text if "." in text or "/" in text else f"{text}.0"
        case Constant():
            return str(term.value)
        case Variable():
            return term.name.split("%")[0] + _ROLES.get(term.role, "")
        case Construct():
            return term.constructor if term.argument is None else f"{term.constructor}({show_term(term.argument)})"
        case Record():
            kind = term.type
            names = [name for name, _ in kind.fields] if isinstance(kind, core.RecordType) else []
            fields = zip(names, term.values, strict=True)
            return "(| " + ", ".join(f"{name} == {show_term(value)}" for name, value in fields) + " |)"
        case Field():
            return f"{_inside(term.record)}.{term.name}"
        case Apply():
            return _show_apply(term)
        case Quantifier() | Comprehension():
            declared = "; ".join(f"{b.written} : {show_term(b.carrier)}" for b in term.binders)
            condition = "" if _is_true(term.condition) else f" | {show_term(term.condition)}"
            if isinstance(term, Comprehension) and term.kind == "set":
                return f"{{{declared}{condition} @ {show_term(term.body)}}}"
            return f"{term.kind} {declared}{condition} @ {show_term(term.body)}"
        case If():
            return f"if {show_term(term.test)} then {show_term(term.then)} else {show_term(term.otherwise)}"
    return str(term)


def _is_true(term: Term) -> bool:
    return isinstance(term, Constant) and term.value is True


def _inside(term: Term) -> str:
    text = show_term(term)
    compound = isinstance(term, Quantifier | If) or (
        (isinstance(term, Apply) and (term.operator in _INFIX or term.operator in _PREFIX))
        or (isinstance(term, Comprehension) and term.kind != "set")
    )
    return f"({text})" if compound else text


def _show_apply(term: Apply) -> str:
    operator, operands = term.operator, term.operands
    if operator in _COERCIONS:
        return show_term(operands[0])
    if operator in _SETS:
        return _SETS[operator]
    if operator in ("All", "Records"):
        kind = term.type
        return str(kind.element) if isinstance(kind, core.SetType) else operator
    if operator in _DISPLAYS:
        left, right = _DISPLAYS[operator]
        items = [show_term(item) for item in operands]
        if operator == "function":
            items = [_maplet(item) for item in operands]
        return left + ", ".join(items) + right
    if operator in _PREFIX:
        return f"{_PREFIX[operator]} {_inside(operands[0])}".replace("# ", "#").replace("- ", "-")
    if operator in _INFIX and operands:
        return f" {_INFIX[operator]} ".join(map(_inside, operands)).replace(" .. ", "..")
    if operator == "apply":
        return f"{_inside(operands[0])}({show_term(operands[1])})"
    if operator == "item" and isinstance(operands[1], Constant):
        return f"{_inside(operands[0])}.{int(operands[1].value) + 1}"
    return (
        f"{operator}({', '.join(map(show_term, operands))})"
        if len(operands) != 1
        else (f"{operator} {_inside(operands[0])}")
    )


def _maplet(pair: Term) -> str:
    if isinstance(pair, Apply) and pair.operator == "tuple" and len(pair.operands) == 2:
        return f"{show_term(pair.operands[0])} |-> {show_term(pair.operands[1])}"
    return show_term(pair)


def shape(term: Term) -> Hashable:
    """What a term is up to the names of its bound variables: equal for terms that mean the same by their form."""
    return _shape(term, {})


def _shape(term: Term, bound: Mapping[str, int]) -> Hashable:
    match term:
        case Variable():
            if term.role == "bound" and term.name in bound:
                return ("bound", bound[term.name])
            return ("variable", term.name, term.role)
        case Constant():
            return ("constant", term.type, term.value)
        case Construct():
            return ("construct", term.constructor, term.argument and _shape(term.argument, bound))
        case Field():
            return ("field", term.name, _shape(term.record, bound))
        case Apply():
            return (term.operator, term.type, *[_shape(operand, bound) for operand in term.operands])
        case Quantifier() | Comprehension():
            inside = dict(bound)
            carriers = []
            for binder in term.binders:
                carriers.append(_shape(binder.carrier, inside))
                inside[binder.name] = len(inside)
            return (term.kind, tuple(carriers), _shape(term.condition, inside), _shape(term.body, inside))
    return (type(term).__name__, term.type, *[_shape(part, bound) for part in parts(term)])


Name = tuple[str, core.Role]


def free_variables(term: Term) -> frozenset[Name]:
    """The names and roles of the variables that a term uses and does not bind."""
    match term:
        case Variable():
            return frozenset([(term.name, term.role)])
        case Quantifier() | Comprehension():
            found = free_variables(term.condition) | free_variables(term.body)
            for binder in reversed(term.binders):
                found = (found - {(binder.name, "bound")}) | free_variables(binder.carrier)
            return found
    found = frozenset()
    for part in parts(term):
        found |= free_variables(part)
    return found


def conjuncts(terms: Iterable[Term]) -> Iterator[Term]:
    """The conjuncts of all *terms*, taken apart; what is trivially true is left out."""
    for term in terms:
        if isinstance(term, Apply) and term.operator == "and":
            yield from conjuncts(term.operands)
        elif not _is_true(term):
            yield term


def primed(term: Term) -> Term:
    """A predicate on a state, said of the state afterwards."""
    return mapped(term, lambda v: replace(v, role="after") if v.role == "before" else v)


def mapped(term: Term, change: Callable[[Variable], Term]) -> Term:
    """The term with every variable changed by a function from variables to terms."""
    match term:
        case Variable():
            return change(term)
        case Construct():
            return term if term.argument is None else replace(term, argument=mapped(term.argument, change))
        case Record():
            return replace(term, values=tuple([mapped(value, change) for value in term.values]))
        case Field():
            return replace(term, record=mapped(term.record, change))
        case Apply():
            return replace(term, operands=tuple([mapped(operand, change) for operand in term.operands]))
        case Quantifier() | Comprehension():
            return replace(
                term,
                binders=tuple([replace(b, carrier=mapped(b.carrier, change)) for b in term.binders]),
                condition=mapped(term.condition, change),
                body=mapped(term.body, change),
            )
        case If():
            return replace(
                term,
                test=mapped(term.test, change),
                then=mapped(term.then, change),
                otherwise=mapped(term.otherwise, change),
            )
    return term


def negated(term: Term) -> Term:
    """``not term``, with the negation moved inwards as far as that leaves the term readable for the solver."""
    match term:
        case Constant(value=bool()):
            return replace(term, value=not term.value)
        case Apply(operator="not"):
            return term.operands[0]
        case Apply(operator="and"):
            return replace(term, operator="or", operands=tuple(map(negated, term.operands)))
        case Apply(operator="or"):
            return replace(term, operator="and", operands=tuple(map(negated, term.operands)))
        case Apply(operator="implies"):
            return replace(term, operator="and", operands=(term.operands[0], negated(term.operands[1])))
        case If(type=core.BoolType()):
            return replace(term, then=negated(term.then), otherwise=negated(term.otherwise))
        case Apply(operator="less", operands=(a, b)):
            return replace(term, operator="at_most", operands=(b, a))
        case Apply(operator="at_most", operands=(a, b)):
            return replace(term, operator="less", operands=(b, a))
    return Apply(type=core.BOOL, operator="not", operands=(term,), span=term.span)
