"""Predicates and terms of Object-Z as expressions of Python.

Integers are ``int``, reals ``float``, sequences ``tuple`` (numbered from 1 in Z, from 0 in Python), sets ``frozenset``,
elements of given and free types members of enumerations or :class:`~cspcheck.codegen.runtime.Tagged`. What has no
counterpart here (functions, relations, bags, infinite sets as values) is refused with its place.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from cspcheck.codegen import messages
from cspcheck.codegen.design.expressions import (
    ADD,
    AND,
    ATOM,
    COMPARE,
    MULTIPLY,
    NOT,
    OR,
    SET_OR,
    TERNARY,
    UNARY,
    Code,
    bracketed,
)
from cspcheck.codegen.design.naming import safe
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.isolating import Instead, isolated
from cspcheck.cspm.oz.values.terms import show_term
from cspcheck.cspm.source import Span

_INFIX: dict[str, tuple[str, int]] = {
    "less": ("<", COMPARE),
    "at_most": ("<=", COMPARE),
    "plus": ("+", ADD),
    "minus": ("-", ADD),
    "times": ("*", MULTIPLY),
    "div": ("//", MULTIPLY),
    "mod": ("%", MULTIPLY),
    "divide": ("/", MULTIPLY),
    "union": ("|", SET_OR),
    "inter": ("&", SET_OR),
    "diff": ("-", SET_OR),
    "symdiff": ("^", SET_OR),
    "subset": ("<=", COMPARE),
    "proper_subset": ("<", COMPARE),
}


class TermTranslator:
    """Translates terms.

    Args:
        variable: what a variable is called.
        constructor: a constructor of a free type, or an element of a given one, with its argument's text.
        everything: the set of all values of a given or free type, as an expression; None if there is none.
    """

    def __init__(
        self,
        variable: Callable[[core.Variable], str],
        constructor: Callable[[str, str | None, Span | None], str],
        everything: Callable[[core.Type], str | None],
    ) -> None:
        self._variable = variable
        self._constructor = constructor
        self._everything = everything
        self._bound: dict[str, str] = {}

    def text(self, term: core.Term, strength: int = TERNARY) -> str:
        """A term, in brackets where it binds looser than *strength*.

        Raises:
            ScriptError: it has no counterpart.
        """
        return bracketed(self.code(term), strength)

    def code(self, term: core.Term) -> Code:
        """A term with the strength of its outermost operator."""
        match term:
            case core.Constant(value=bool() | int() as value):
                return (repr(value), ATOM if not isinstance(value, int) or value >= 0 else UNARY)
            case core.Constant(value=Fraction() as value):
                return (repr(float(value)), ATOM if value >= 0 else UNARY)
            case core.Variable(role="bound"):
                return (self._bound.get(term.name) or self._variable(term), ATOM)
            case core.Variable():
                return (self._variable(term), ATOM)
            case core.Construct():
                argument = None if term.argument is None else self.text(term.argument)
                return (self._constructor(term.constructor, argument, term.span), ATOM)
            case core.If():
                then, otherwise = self.text(term.then, OR), self.text(term.otherwise)
                return (f"{then} if {self.text(term.test, OR)} else {otherwise}", TERNARY)
            case core.Quantifier():
                return self._quantifier(term)
            case core.Comprehension(kind="set"):
                return self._comprehension(term)
            case core.Apply():
                return self._apply(term)
        raise self.refused(term)

    def refused(self, term: core.Term) -> ScriptError:
        """The refusal of a term."""
        return ScriptError(messages.not_generated(f"`{show_term(term)}`", term.span))

    def _apply(self, term: core.Apply) -> Code:
        operator, operands = term.operator, term.operands
        if operator in _INFIX:
            sign, strength = _INFIX[operator]
            left, right = (strength + 1, strength + 1) if strength in (COMPARE, SET_OR) else (strength, strength + 1)
            return (f"{self.text(operands[0], left)} {sign} {self.text(operands[1], right)}", strength)
        match operator:
            case "not":
                return self._negation(operands[0])
            case "and":
                return (" and ".join(self.text(o, AND) for o in operands), AND)
            case "or":
                return (" or ".join(self.text(o, OR) for o in operands), OR)
            case "implies":
                return (f"{bracketed(self._negation(operands[0]), OR)} or {self.text(operands[1], OR)}", OR)
            case "iff" | "equal":
                return (f"{self.text(operands[0], COMPARE + 1)} == {self.text(operands[1], COMPARE + 1)}", COMPARE)
            case "in":
                return self._membership(operands[0], operands[1])
            case "negate":
                return (f"-{self.text(operands[0], UNARY)}", UNARY)
            case "abs" | "min" | "max":
                return (f"{operator}({self.text(operands[0])})", ATOM)
            case "int_to_real":
                return self.code(operands[0])
            case "floor":
                return (f"int({self.text(operands[0], MULTIPLY)} // 1)", ATOM)
            case "tuple":
                return (f"({', '.join(map(self.text, operands))})", ATOM)
            case "item":
                return (f"{self.text(operands[0], ATOM)}[{self.text(operands[1])}]", ATOM)
            case "set":
                return (f"frozenset({{{', '.join(map(self.text, operands))}}})" if operands else "frozenset()", ATOM)
            case "range":
                return (f"frozenset({self._range(term)})", ATOM)
            case "card" | "length":
                return (f"len({self.text(operands[0])})", ATOM)
            case "disjoint" if len(operands) == 2:
                return (f"not {self.text(operands[0], ATOM)} & {self.text(operands[1], ATOM)}", NOT)
            case "sequence":
                texts = list(map(self.text, operands))
                return (f"({', '.join(texts)}{',' if len(texts) == 1 else ''})", ATOM)
            case "concat":
                return (f"({', '.join(self._spread(term))})", ATOM)
            case "head" | "last":
                return (f"{self.text(operands[0], ATOM)}[{0 if operator == 'head' else -1}]", ATOM)
            case "tail" | "front":
                return (f"{self.text(operands[0], ATOM)}[{'1:' if operator == 'tail' else ':-1'}]", ATOM)
            case "%drop":
                return (f"{self.text(operands[0], ATOM)}[{self.text(operands[1])}:]", ATOM)
            case "%drop_last":
                return (f"{self.text(operands[0], ATOM)}[: -{self.text(operands[1], ATOM)}]", ATOM)
            case "rev":
                return (f"{self.text(operands[0], ATOM)}[::-1]", ATOM)
            case "ran" if isinstance(operands[0].type, core.SequenceType):
                return (f"frozenset({self.text(operands[0])})", ATOM)
            case "ran" if _of_sequence(operands[0]) is not None:
                inner = _of_sequence(operands[0])
                assert inner is not None
                return (f"frozenset({self.text(inner)})", ATOM)
            case "apply" if isinstance(operands[0].type, core.SequenceType):
                index = operands[1]
                position = (
                    str(index.value - 1)
                    if isinstance(index, core.Constant) and isinstance(index.value, int)
                    else f"{self.text(index, ADD)} - 1"
                )
                return (f"{self.text(operands[0], ATOM)}[{position}]", ATOM)
            case "All" | "Bool":
                assert isinstance(term.type, core.SetType)
                everything = self._everything(term.type.element)
                if everything is not None:
                    return (everything, ATOM)
        raise self.refused(term)

    def _spread(self, term: core.Term) -> list[str]:
        if isinstance(term, core.Apply) and term.operator == "concat":
            return [text for operand in term.operands for text in self._spread(operand)]
        if isinstance(term, core.Apply) and term.operator == "sequence":
            return list(map(self.text, term.operands))
        return [f"*{self.text(term, SET_OR)}"]

    def _range(self, term: core.Apply) -> str:
        low, high = term.operands
        end = str(high.value + 1) if isinstance(high, core.Constant) else f"{self.text(high, ADD)} + 1"
        text = self.text(low)
        return f"range({'' if text == '0' else f'{text}, '}{end})"

    def _negation(self, term: core.Term) -> Code:
        if isinstance(term, core.Apply):
            match term.operator:
                case "not":
                    return self.code(term.operands[0])
                case "equal":
                    a, b = (self.text(o, COMPARE + 1) for o in term.operands)
                    return (f"{a} != {b}", COMPARE)
                case "in" if not (isinstance(term.operands[1], core.Apply) and term.operands[1].operator in _CARRIERS):
                    a, b = (self.text(o, COMPARE + 1) for o in term.operands)
                    return (f"{a} not in {b}", COMPARE)
                case "less" | "at_most":
                    sign = ">=" if term.operator == "less" else ">"
                    a, b = (self.text(o, COMPARE + 1) for o in term.operands)
                    return (f"{a} {sign} {b}", COMPARE)
        return (f"not {self.text(term, NOT)}", NOT)

    def _membership(self, value: core.Term, carrier: core.Term) -> Code:
        text = self.text(value, COMPARE + 1)
        if isinstance(carrier, core.Apply):
            match carrier.operator:
                case "range":
                    low, high = (self.text(o, COMPARE + 1) for o in carrier.operands)
                    return (f"{low} <= {text} <= {high}", COMPARE)
                case "Int" | "Real" | "Bool" | "All":
                    return ("True", ATOM)
                case "Nat":
                    return (f"{text} >= 0", COMPARE)
                case "Nat1":
                    return (f"{text} >= 1", COMPARE)
                case "power" | "finset":
                    return (f"{text} <= {self.text(carrier.operands[0], COMPARE + 1)}", COMPARE)
                case "set":
                    items = [self.text(o) for o in carrier.operands]
                    if items:
                        return (f"{text} in ({', '.join(items)}{',' if len(items) == 1 else ''})", COMPARE)
        return (f"{text} in {self.text(carrier, COMPARE + 1)}", COMPARE)

    def _loops(self, binders: tuple[core.Binder, ...]) -> str:
        clauses = []
        for binder in binders:
            carrier = binder.carrier
            is_range = isinstance(carrier, core.Apply) and carrier.operator == "range"
            source = self._range(carrier) if is_range else self.text(carrier, OR)  # type: ignore[arg-type]
            name = safe(binder.written)
            while name in self._bound.values():
                name = f"{name}_"
            self._bound[binder.name] = name
            clauses.append(f"for {name} in {source}")
        return " ".join(clauses)

    def _quantifier(self, term: core.Quantifier) -> Code:
        if term.kind == "exists1":
            raise self.refused(term)
        before = dict(self._bound)
        loops = self._loops(term.binders)
        condition = "" if _is_true(term.condition) else f" if {self.text(term.condition, OR)}"
        body = self.text(term.body)
        self._bound = before
        return (f"{'all' if term.kind == 'forall' else 'any'}({body} {loops}{condition})", ATOM)

    def _comprehension(self, term: core.Comprehension) -> Code:
        before = dict(self._bound)
        loops = self._loops(term.binders)
        condition = "" if _is_true(term.condition) else f" if {self.text(term.condition, OR)}"
        body = self.text(term.body)
        self._bound = before
        return (f"frozenset({body} {loops}{condition})", ATOM)


_CARRIERS = frozenset({"range", "Int", "Real", "Bool", "All", "Nat", "Nat1", "power", "finset", "set"})


def _is_true(term: core.Term) -> bool:
    return isinstance(term, core.Constant) and term.value is True


def _of_sequence(term: core.Term) -> core.Term | None:
    """The sequence of which a term is the function."""
    if isinstance(term, core.Apply) and term.operator == "sequence_to_function":
        return term.operands[0]
    return None


# --- outcomes ----------------------------------------------------------------------------------------------------

Key = tuple[str, str]
"""A variable that an operation gives a value: its role and name."""


class Way:
    """One way in which a predicate can hold: tests, and equations that give values."""

    def __init__(self, tests: list[core.Term] | None = None, values: dict[Key, core.Term] | None = None) -> None:
        self.tests = tests or []
        self.values = values or {}


MOST_WAYS = 16
"""Predicates with more alternatives are not taken apart."""


def ways(predicates: tuple[core.Term, ...], wanted: frozenset[Key]) -> list[Way] | None:
    """The alternatives of a predicate, if each of them has an equation for everything that is *wanted*.

    Equations may use what others give. None if the predicate leaves something open, or is too branched.
    """
    rows = _rows(core.conjunction(predicates))
    if rows is None:
        return None
    found: list[Way] = []
    for row in rows:
        way = _way(row, wanted)
        if way is None:
            return None
        found.append(way)
    return found


def _rows(term: core.Term) -> list[list[core.Term]] | None:
    """The disjunctive form: alternatives of conjuncts; contradictory ones are left out."""
    if isinstance(term, core.Apply):
        match term.operator:
            case "and":
                rows: list[list[core.Term]] = [[]]
                for operand in term.operands:
                    more = _rows(operand)
                    if more is None:
                        return None
                    rows = [a + b for a in rows for b in more if not _contradict(a, b)]
                    if len(rows) > MOST_WAYS:
                        return None
                return rows
            case "or":
                together: list[list[core.Term]] = []
                for operand in term.operands:
                    more = _rows(operand)
                    if more is None or len(together) + len(more) > MOST_WAYS:
                        return None
                    together += more
                return together
            case "implies":
                negated = core.Apply(type=core.BOOL, operator="not", operands=(term.operands[0],))
                more = _rows(term.operands[1])
                if more is None:
                    return None
                return [[negated], *[[term.operands[0], *row] for row in more]]
    if isinstance(term, core.If):
        then, otherwise = _rows(term.then), _rows(term.otherwise)
        if then is None or otherwise is None or len(then) + len(otherwise) > MOST_WAYS:
            return None
        refuted = core.Apply(type=core.BOOL, operator="not", operands=(term.test,))
        return [*[[term.test, *row] for row in then], *[[refuted, *row] for row in otherwise]]
    if isinstance(term, core.Constant) and term.value is True:
        return [[]]
    return [[term]]


def _contradict(left: list[core.Term], right: list[core.Term]) -> bool:
    return any(_opposite(a, b) for a in left for b in right)


def _opposite(a: core.Term, b: core.Term) -> bool:
    for one, other in ((a, b), (b, a)):
        if isinstance(one, core.Apply) and one.operator == "not" and one.operands[0] == other:
            return True
    return False


def _way(row: list[core.Term], wanted: frozenset[Key]) -> Way | None:
    way = Way()
    pending = list(row)
    progress = True
    while progress:
        progress = False
        for term in list(pending):
            open_ = frozenset(key for key in wanted if key not in way.values)
            if open_.isdisjoint(keys_in(term)):
                continue
            found = _solved(term, open_)
            if isinstance(found, list):
                position = pending.index(term)
                pending[position : position + 1] = found
                progress = True
            elif found is not None:
                key, value = found
                way.values[key] = value
                pending.remove(term)
                progress = True
    way.tests = pending
    return way if wanted <= way.values.keys() else None


def _solved(term: core.Term, open_: frozenset[Key]) -> tuple[Key, core.Term] | list[core.Term] | None:
    """What a conjunct says of something open: its value, simpler conjuncts, or nothing that helps."""
    found = isolated(term, frozenset((name, role) for role, name in open_))  # type: ignore[misc]
    if isinstance(found, Instead):
        return None if any(_private(conjunct) for conjunct in found.conjuncts) else list(found.conjuncts)
    if found is None:
        return None
    (name, role), value = found
    return None if _private(value) else ((role, name), value)


def _private(term: core.Term) -> bool:
    """Whether a term uses an operator that only the evaluator knows."""
    if isinstance(term, core.Apply) and term.operator in ("%rank", "%argument"):
        return True
    if isinstance(term, core.Apply) and term.operator in ("%drop", "%drop_last"):
        return not isinstance(term.operands[1], core.Constant)  # programs take a fixed number of items off
    return any(_private(part) for part in core.parts(term))


def keys_in(term: core.Term) -> set[Key]:
    """The variables of a term by role and name."""
    found: set[Key] = set()
    todo = [term]
    while todo:
        one = todo.pop()
        if isinstance(one, core.Variable):
            found.add((one.role, one.name))
        todo.extend(core.parts(one))
    return found
