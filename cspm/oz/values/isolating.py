"""What an equation says of a variable that is sought: its value, or simpler equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Construct, Field, Record, Term, Variable
from cspcheck.cspm.oz.values.terms import Name, free_variables

Free: TypeAlias = Callable[[Term], frozenset[Name]]


@dataclass(frozen=True, slots=True)
class Instead:
    """Simpler conjuncts that say the same as one."""

    conjuncts: tuple[Term, ...]


def isolated(term: Term, keys: frozenset[Name], free: Free = free_variables) -> tuple[Name, Term] | Instead | None:
    """What an equation says of an unknown: its value, or simpler equations; None if it is no such equation."""
    match term:
        case Variable(type=core.BoolType()) if (term.name, term.role) in keys:
            return (term.name, term.role), Constant(type=core.BOOL, value=True)
        case Apply(operator="not", operands=(Variable() as variable,)) if (variable.name, variable.role) in keys:
            return (variable.name, variable.role), Constant(type=core.BOOL, value=False)
        case Apply(operator="equal" | "iff", operands=(a, b)):
            for pattern, value in ((a, b), (b, a)):
                if free(value).isdisjoint(keys):
                    return _matched(pattern, value, keys, free)
    return None


def _equation(a: Term, b: Term) -> Term:
    return Apply(type=core.BOOL, operator="equal", operands=(a, b), span=a.span)


def _matched(pattern: Term, value: Term, keys: frozenset[Name], free: Free) -> tuple[Name, Term] | Instead | None:
    """*pattern* = *value*, where only the pattern has unknowns."""
    match pattern:
        case Variable():
            return (pattern.name, pattern.role), value
        case Record():
            kind = pattern.type
            assert isinstance(kind, core.RecordType)
            fields = [Field(type=t, record=value, name=name, span=value.span) for name, t in kind.fields]
            return Instead(tuple(map(_equation, pattern.values, fields)))
        case Construct(argument=Term() as argument):
            return _constructed(pattern, argument, value)
        case Apply():
            simpler = _SIMPLER.get(pattern.operator)
            if simpler is not None:
                return simpler(pattern, value, keys, free)
    return None


def _constructed(pattern: Construct, argument: Term, value: Term) -> Instead:
    # The rank of a constructor is its place in the definition, which only the evaluator knows.
    bare = Construct(type=pattern.type, constructor=pattern.constructor, span=pattern.span)
    rank = Apply(type=core.INT, operator="%rank", operands=(value,), span=value.span)
    mine = Apply(type=core.INT, operator="%rank", operands=(bare,), span=pattern.span)
    inner = Apply(type=argument.type, operator="%argument", operands=(value,), span=value.span)
    return Instead((_equation(rank, mine), _equation(argument, inner)))


def _integer(value: int) -> Term:
    return Constant(type=core.INT, value=value)


def _apply(operator: str, type_: core.Type, *operands: Term) -> Term:
    return Apply(type=type_, operator=operator, operands=operands, span=operands[0].span)


Simplify: TypeAlias = Callable[[Apply, Term, frozenset[Name], Free], "tuple[Name, Term] | Instead | None"]


def _of_tuple(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> Instead:
    items = [_apply("item", p.type, value, _integer(i)) for i, p in enumerate(pattern.operands)]
    return Instead(tuple(map(_equation, pattern.operands, items)))


def _of_sum(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> tuple[Name, Term] | Instead | None:
    a, b = pattern.operands
    if free(b).isdisjoint(keys):
        inverse = "minus" if pattern.operator == "plus" else "plus"
        return Instead((_equation(a, _apply(inverse, value.type, value, b)),))
    if free(a).isdisjoint(keys):
        operands = (value, a) if pattern.operator == "plus" else (a, value)
        return Instead((_equation(b, _apply("minus", value.type, *operands)),))
    return None


def _of_negation(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> Instead:
    return Instead((_equation(pattern.operands[0], _apply("negate", value.type, value)),))


def _of_real(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> Instead:
    whole = _apply("floor", core.INT, value)
    is_whole = _equation(value, _apply("int_to_real", core.REAL, whole))
    return Instead((is_whole, _equation(pattern.operands[0], whole)))


def _of_sequence(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> Instead:
    length = _equation(_apply("length", core.INT, value), _integer(len(pattern.operands)))
    return Instead((length, *_items(pattern.operands, value, 1)))


def _items(patterns: Sequence[Term], value: Term, first: int) -> list[Term]:
    return [_equation(p, _apply("apply", p.type, value, _integer(i))) for i, p in enumerate(patterns, first)]


def _of_concatenation(pattern: Apply, value: Term, keys: frozenset[Name], free: Free) -> Instead | None:
    """What is known or written out at either end, taken off."""
    items = tuple(concatenated(pattern))
    length = _apply("length", core.INT, value)
    first, last = items[0], items[-1]
    if isinstance(first, Apply) and first.operator == "sequence":
        count = _integer(len(first.operands))
        rest = _apply("%drop", value.type, value, count)
        found = _items(first.operands, value, 1)
        return Instead((_at_most(count, length), *found, _equation(_joined(items[1:]), rest)))
    if free(first).isdisjoint(keys):
        rest = _apply("%drop", value.type, value, _apply("length", core.INT, first))
        return Instead((_apply("prefix", core.BOOL, first, value), _equation(_joined(items[1:]), rest)))
    if isinstance(last, Apply) and last.operator == "sequence":
        count = _integer(len(last.operands))
        rest = _apply("%drop_last", value.type, value, count)
        before = _apply("minus", core.INT, length, count)
        found = [
            _equation(p, _apply("apply", p.type, value, _apply("plus", core.INT, before, _integer(i))))
            for i, p in enumerate(last.operands, 1)
        ]
        return Instead((_at_most(count, length), _equation(_joined(items[:-1]), rest), *found))
    if free(last).isdisjoint(keys):
        rest = _apply("%drop_last", value.type, value, _apply("length", core.INT, last))
        return Instead((_apply("suffix", core.BOOL, last, value), _equation(_joined(items[:-1]), rest)))
    return None


def _at_most(low: Term, high: Term) -> Term:
    return Apply(type=core.BOOL, operator="at_most", operands=(low, high))


def concatenated(term: Term) -> Iterator[Term]:
    """What a sequence is a concatenation of."""
    if isinstance(term, Apply) and term.operator == "concat":
        for operand in term.operands:
            yield from concatenated(operand)
    else:
        yield term


def _joined(items: Sequence[Term]) -> Term:
    result = items[0]
    for item in items[1:]:
        result = _apply("concat", result.type, result, item)
    return result


_SIMPLER: Final[dict[str, Simplify]] = {
    "tuple": _of_tuple,
    "plus": _of_sum,
    "minus": _of_sum,
    "negate": _of_negation,
    "int_to_real": _of_real,
    "sequence": _of_sequence,
    "concat": _of_concatenation,
}
