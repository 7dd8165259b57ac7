"""The obvious interpreter of core terms over small finite sets, and random terms: what the evaluator is held against.

Everything is enumerated, nothing is planned. None stands for an undefined value; a predicate is undefined if it
depends on one, in the logic of Kleene.
"""

from __future__ import annotations

from itertools import combinations, product
from typing import Any

from hypothesis import strategies as st

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    BOOL,
    INT,
    Apply,
    Binder,
    Comprehension,
    Constant,
    If,
    Quantifier,
    SetType,
    Term,
    Variable,
)
from cspcheck.cspm.oz.values.values import Graph

INTS = SetType(INT)
SEQ = core.SequenceType(INT)
FUN = core.FunctionType(INT, INT)
PAIR = core.TupleType((INT, INT))
REL = SetType(PAIR)
NAMES = {"i": INT, "j": INT, "b": BOOL, "s": INTS, "q": SEQ, "f": FUN, "r": REL}


def interpret(term: Term, env: dict[Any, Any]) -> Any:
    """The value of a term, or None. Variables are looked up by name and role, or by name alone."""
    match term:
        case Constant():
            return term.value
        case Variable():
            return env[term.name, term.role] if (term.name, term.role) in env else env[term.name]
        case If():
            test = interpret(term.test, env)
            return None if test is None else interpret(term.then if test else term.otherwise, env)
        case Quantifier():
            return _quantified(term, env)
        case Comprehension():
            return _comprehended(term, env)
        case Apply():
            return _applied(term, env)
    raise TypeError(term)


def _bindings(binders: tuple[Binder, ...], env: dict[str, Any]) -> list[dict[str, Any]]:
    carriers = [interpret(binder.carrier, env) for binder in binders]
    return [dict(env, **dict(zip([b.name for b in binders], values, strict=True))) for values in product(*carriers)]


def _both(a: bool | None, b: bool | None) -> bool | None:
    if a is False or b is False:
        return False
    return None if a is None or b is None else True


def _quantified(term: Quantifier, env: dict[str, Any]) -> bool | None:
    negate = term.kind == "forall"
    found = []
    for inner in _bindings(term.binders, env):
        body = interpret(term.body, inner)
        found.append(_both(interpret(term.condition, inner), body if not negate or body is None else not body))
    if term.kind == "exists1":
        return None if None in found else found.count(True) == 1
    some = True if True in found else None if None in found else False
    return some if not negate or some is None else not some


def _comprehended(term: Comprehension, env: dict[str, Any]) -> Any:
    values = set()
    for inner in _bindings(term.binders, env):
        holds = interpret(term.condition, inner)
        if holds is None:
            return None
        if holds:
            value = interpret(term.body, inner)
            if value is None:
                return None
            values.add(value)
    return frozenset(values)


def _applied(term: Apply, env: dict[str, Any]) -> Any:
    operator = term.operator
    values = [interpret(operand, env) for operand in term.operands]
    if operator == "and":
        return False if False in values else None if None in values else True
    if operator == "or":
        return True if True in values else None if None in values else False
    if operator == "implies":
        left = None if values[0] is None else not values[0]
        return True if True in (left, values[1]) else None if None in (left, values[1]) else False
    if None in values:
        return None
    return _STRICT[operator](*values)


def _pairs(f: Any) -> Any:
    return f.items() if isinstance(f, dict) else f


def _like(f: Any, pairs: Any) -> Any:
    return Graph(pairs) if isinstance(f, dict) else frozenset(pairs)


_STRICT: dict[str, Any] = {
    "not": lambda a: not a,
    "iff": lambda a, b: a == b,
    "equal": lambda a, b: a == b,
    "in": lambda a, s: a in s,
    "less": lambda a, b: a < b,
    "at_most": lambda a, b: a <= b,
    "plus": lambda a, b: a + b,
    "minus": lambda a, b: a - b,
    "times": lambda a, b: a * b,
    "negate": lambda a: -a,
    "div": lambda a, b: None if b == 0 else a // b,
    "mod": lambda a, b: None if b == 0 else a % b,
    "min": lambda s: min(s, default=None),
    "max": lambda s: max(s, default=None),
    "card": len,
    "length": len,
    "range": lambda a, b: frozenset(range(a, b + 1)),
    "set": lambda *items: frozenset(items),
    "union": lambda a, b: a | b,
    "inter": lambda a, b: a & b,
    "diff": lambda a, b: a - b,
    "symdiff": lambda a, b: a ^ b,
    "subset": lambda a, b: a <= b,
    "proper_subset": lambda a, b: a < b,
    "disjoint": lambda a, b: not a & b,
    "power": lambda s: frozenset(frozenset(c) for n in range(len(s) + 1) for c in combinations(sorted(s), n)),
    "tuple": lambda *items: items,
    "item": lambda t, i: t[i],
    "sequence": lambda *items: items,
    "concat": lambda a, b: a + b,
    "head": lambda q: q[0] if q else None,
    "tail": lambda q: q[1:] if q else None,
    "last": lambda q: q[-1] if q else None,
    "front": lambda q: q[:-1] if q else None,
    "rev": lambda q: q[::-1],
    "filter": lambda q, s: tuple(x for x in q if x in s),
    "extract": lambda s, q: tuple(x for i, x in enumerate(q) if i + 1 in s),
    "prefix": lambda a, b: b[: len(a)] == a,
    "dom": lambda f: frozenset(a for a, _ in _pairs(f)),
    "ran": lambda f: frozenset(b for _, b in _pairs(f)),
    "apply": lambda f, a: f.get(a) if isinstance(f, dict) else f[a - 1] if 0 < a <= len(f) else None,
    "override": lambda f, g: _like(
        f, [*[(a, b) for a, b in _pairs(f) if a not in {c for c, _ in _pairs(g)}], *_pairs(g)]
    ),
    "function": lambda *pairs: Graph(pairs) if len({a for a, _ in pairs}) == len(set(pairs)) else None,
    "function_to_relation": lambda f: frozenset(f.items()),
    "sequence_to_function": lambda q: Graph(enumerate(q, 1)),
    "dom_restrict": lambda s, f: _like(f, [(a, b) for a, b in _pairs(f) if a in s]),
    "ran_restrict": lambda f, s: _like(f, [(a, b) for a, b in _pairs(f) if b in s]),
    "dom_subtract": lambda s, f: _like(f, [(a, b) for a, b in _pairs(f) if a not in s]),
    "inverse": lambda r: frozenset((b, a) for a, b in r),
    "image": lambda r, s: frozenset(b for a, b in _pairs(r) if a in s),
    "compose": lambda r, s: frozenset((a, c) for a, b in r for d, c in s if b == d),
    "closure": lambda r: _closed(r),
}


def _closed(relation: frozenset[Any]) -> frozenset[Any]:
    while True:
        more = relation | frozenset((a, d) for a, b in relation for c, d in relation if b == c)
        if more == relation:
            return relation
        relation = more


# --- random terms ----------------------------------------------------------------------------------------------------


def apply(operator: str, type_: core.Type, *operands: Term) -> Apply:
    """An operator applied."""
    return Apply(type=type_, operator=operator, operands=operands)


def number(value: int) -> Constant:
    """An integer literal."""
    return Constant(type=INT, value=value)


TRUE = Constant(type=BOOL, value=True)

_SHAPES: dict[core.Type, list[tuple[str, tuple[core.Type, ...]]]] = {
    BOOL: [
        *[("not", (BOOL,)), ("and", (BOOL, BOOL)), ("or", (BOOL, BOOL)), ("implies", (BOOL, BOOL))],
        *[("iff", (BOOL, BOOL)), ("equal", (INT, INT)), ("equal", (INTS, INTS)), ("equal", (SEQ, SEQ))],
        *[("equal", (PAIR, PAIR)), ("equal", (FUN, FUN)), ("in", (INT, INTS)), ("less", (INT, INT))],
        *[("at_most", (INT, INT)), ("subset", (INTS, INTS)), ("proper_subset", (INTS, INTS))],
        *[("disjoint", (INTS, INTS)), ("prefix", (SEQ, SEQ)), ("equal", (REL, REL))],
    ],
    INT: [
        *[("plus", (INT, INT)), ("minus", (INT, INT)), ("times", (INT, INT)), ("negate", (INT,))],
        *[("div", (INT, INT)), ("mod", (INT, INT)), ("min", (INTS,)), ("max", (INTS,)), ("card", (INTS,))],
        *[("length", (SEQ,)), ("head", (SEQ,)), ("last", (SEQ,)), ("apply", (FUN, INT)), ("apply", (SEQ, INT))],
    ],
    INTS: [
        *[("set", ()), ("set", (INT,)), ("set", (INT, INT)), ("range", (INT, INT)), ("union", (INTS, INTS))],
        *[("inter", (INTS, INTS)), ("diff", (INTS, INTS)), ("symdiff", (INTS, INTS)), ("dom", (FUN,))],
        *[("ran", (FUN,)), ("image", (REL, INTS)), ("dom", (REL,)), ("ran", (REL,))],
    ],
    SEQ: [
        *[("sequence", ()), ("sequence", (INT,)), ("sequence", (INT, INT)), ("concat", (SEQ, SEQ)), ("tail", (SEQ,))],
        *[("front", (SEQ,)), ("rev", (SEQ,)), ("filter", (SEQ, INTS)), ("extract", (INTS, SEQ))],
    ],
    FUN: [
        *[("function", ()), ("function", (PAIR,)), ("function", (PAIR, PAIR)), ("override", (FUN, FUN))],
        *[("dom_restrict", (INTS, FUN)), ("ran_restrict", (FUN, INTS)), ("dom_subtract", (INTS, FUN))],
        ("sequence_to_function", (SEQ,)),
    ],
    PAIR: [("tuple", (INT, INT))],
    REL: [
        *[("set", ()), ("set", (PAIR,)), ("set", (PAIR, PAIR)), ("function_to_relation", (FUN,)), ("inverse", (REL,))],
        *[("compose", (REL, REL)), ("closure", (REL,)), ("override", (REL, REL)), ("union", (REL, REL))],
    ],
}


@st.composite
def terms(draw: st.DrawFn, type_: core.Type, bound: tuple[str, ...] = (), depth: int = 3) -> Term:
    """A term of a type over the variables ``NAMES`` and the bound integers *bound*."""
    leaves: list[Term] = [Variable(type=t, name=n, role="before") for n, t in NAMES.items() if t == type_]
    if type_ == INT:
        leaves += [Variable(type=INT, name=name, role="bound") for name in bound]
        leaves += [number(draw(st.integers(-1, 3)))]
    if type_ == BOOL:
        leaves += [TRUE]
    if type_ == PAIR:
        leaves += [apply("tuple", PAIR, number(0), number(1))]
    if depth == 0:
        return draw(st.sampled_from(leaves))
    kind = draw(st.integers(0, 9))
    if kind == 0:
        return draw(st.sampled_from(leaves))
    if kind == 1:
        test = draw(terms(BOOL, bound, depth - 1))
        then, otherwise = draw(terms(type_, bound, depth - 1)), draw(terms(type_, bound, depth - 1))
        return If(type=type_, test=test, then=then, otherwise=otherwise)
    if kind in (2, 3) and type_ in (BOOL, INTS) and len(bound) < 3:
        return draw(binding(type_, bound, depth))
    operator, types = draw(st.sampled_from(_SHAPES[type_]))
    return apply(operator, type_, *[draw(terms(t, bound, depth - 1)) for t in types])


@st.composite
def binding(draw: st.DrawFn, type_: core.Type, bound: tuple[str, ...], depth: int) -> Term:
    """A quantifier or a set comprehension with one or two bound integers."""
    names = tuple(f"x%{len(bound) + i}" for i in range(draw(st.integers(1, 2))))
    binders = tuple(
        Binder(name, INT, apply("range", INTS, number(draw(st.integers(-2, 0))), number(draw(st.integers(0, 2)))), "x")
        for name in names
    )
    inner = (*bound, *names)
    condition = draw(terms(BOOL, inner, depth - 1))
    if type_ == BOOL:
        kind = draw(st.sampled_from(["forall", "exists", "exists1"]))
        body = draw(terms(BOOL, inner, depth - 1))
        return Quantifier(type=BOOL, kind=kind, binders=binders, condition=condition, body=body)
    body = draw(terms(INT, inner, depth - 1))
    return Comprehension(type=INTS, kind="set", binders=binders, condition=condition, body=body)


small = st.integers(-2, 3)
environments = st.fixed_dictionaries(
    {
        "i": small,
        "j": small,
        "b": st.booleans(),
        "s": st.frozensets(small, max_size=3),
        "q": st.lists(small, max_size=3).map(tuple),
        "f": st.dictionaries(small, small, max_size=3).map(Graph),
        "r": st.frozensets(st.tuples(small, small), max_size=3),
    }
)
