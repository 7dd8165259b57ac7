"""Core terms as expressions of CSPm, as far as CSPm has words for them.

Closed terms are written as their values, functions as maps, records as tuples, quantifiers as questions to
comprehensions. Every translation means the same where the term has a value.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, Final

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Binder, Comprehension, Construct, Field, If, Quantifier, Record, Term, Variable
from cspcheck.cspm.oz.values.evaluation import TermEvaluator
from cspcheck.cspm.oz.values.readings import COLLECTIONS
from cspcheck.cspm.oz.values.terms import conjuncts, free_variables, shape
from cspcheck.cspm.oz.writing import relations
from cspcheck.cspm.oz.writing.operators_cspm import AND, ATOM, CALLED, COMPARED, HELPERS, INFIX, NOT, OR
from cspcheck.cspm.values.failure import Failure

MOST_LISTED: Final = 4_096
"""A set with more elements than this is not written out."""
LONGEST: Final = 60
"""A value with a longer text gets a name."""

Key = tuple[str, core.Role]
Written = tuple[str, int]
"""A text, and how tightly its outermost operator binds."""

_WORD: Final = re.compile(r"[A-Za-z]\w*'*")
_INTERVAL: Final = re.compile(r"\{(-?\d+)\.\.(-?\d+)\}")
_EVERYTHING: Final = frozenset({"Bool", "Int", "Real", "All"})


class Unwritable(Exception):
    """CSPm has no short form for a term."""


class ExpressionWriter:
    """Writes the terms of one class.

    Args:
        evaluator: of the class.
        literal: the text of a value of a type.
        taken: the names that variables must not have, since they are those of constructors, channels or functions.
        fresh: a name for a definition like the one given, which nothing else has.
    """

    def __init__(
        self,
        evaluator: TermEvaluator,
        literal: Callable[[Any, core.Type], str],
        taken: Container[str],
        fresh: Callable[[str], str],
    ) -> None:
        self._evaluator = evaluator
        self._literal = literal
        self._taken = taken
        self._fresh = fresh
        self.known: dict[Key, Written] = {}
        """What stands for each variable."""
        self.ranges: dict[str, frozenset[Any]] = {}
        """The values that some variables have, by what they are called."""
        self.terms: dict[Key, Term] = {}
        """What variables are that equations give."""
        self._carriers: dict[Key, Term] = {}
        self.definitions: list[str] = []
        """Definitions that the expressions use."""
        self._named: dict[str, str] = {}
        self._helpers: dict[str, str] = {}
        self._locals: dict[str, str] = {}
        for letter in "afknsvxy":
            self._locals[letter] = self._unused(f"{letter}_", self._locals.values())
        self._temporary = 0

    # --- variables -----------------------------------------------------------------------------------------------

    def variable(self, name: str, role: core.Role) -> str:
        """Write a variable by a name of its own from now on; gives the name."""
        used = {word for text, _ in self.known.values() for word in _WORD.findall(text)}
        base = re.sub(r"[^A-Za-z0-9_]", "_", name.split("%")[0])
        base = base if base[:1].isalpha() else f"v{base}"
        text = self._unused(base + ("'" if role == "after" else ""), used | set(self._locals.values()))
        self.known[name, role] = (text, ATOM)
        self.ranges.pop(text, None)
        return text

    def _unused(self, name: str, used: Container[str]) -> str:
        while name in self._taken or name in used:
            name = f"{name.rstrip(chr(39))}_{chr(39) if name.endswith(chr(39)) else ''}"
        return name

    def local(self, letter: str) -> str:
        """The name of a variable that only short expressions bind, none of which stands free inside another."""
        return self._locals[letter]

    def element(self) -> str:
        """The name of an element of something, unlike all others."""
        while True:
            self._temporary += 1
            name = f"e{self._temporary}"
            used = {word for text, _ in self.known.values() for word in _WORD.findall(text)}
            if name not in self._taken and name not in used:
                return name

    @contextmanager
    def _bound(self, binders: Sequence[Binder], condition: Term, *, sequence: bool = False) -> Iterator[list[str]]:
        """The generators and conditions of some binders, whose variables are known inside."""
        before = dict(self.known)
        items = []
        for binder in binders:
            carrier = self.values(binder.carrier)
            name = self.variable(binder.name, "bound")
            self.ranging((binder.name, "bound"), binder.carrier)
            items.append(f"{name} <- seq({carrier})" if sequence else f"{name} <- {carrier}")
        items += [self.text(term, AND) for term in conjuncts([condition])]
        yield items
        self.known = before

    def is_known(self, term: Term) -> bool:
        """Whether all variables of a term can be written."""
        return all(role in ("constant", "bound") or (name, role) in self.known for name, role in free_variables(term))

    # --- terms ---------------------------------------------------------------------------------------------------

    def text(self, term: Term, at_least: int = 0) -> str:
        """A term, in brackets where it binds less tightly than *at_least*.

        Raises:
            Untranslatable: CSPm has no form for it.
        """
        text, tight = self.written(term)
        return text if tight >= at_least else f"({text})"

    def written(self, term: Term) -> Written:
        """A term with how tightly it binds."""
        closed = self._closed(term)
        if closed is not None:
            return closed, ATOM
        match term:
            case Variable():
                found = self.known.get((term.name, term.role))
                if found is None:
                    raise Unwritable(term.name)
                return found
            case Construct(argument=None):
                return term.constructor, ATOM
            case Construct():
                assert term.argument is not None
                return f"({term.constructor}.{self.text(term.argument, 50)})", ATOM
            case Record():
                return self._tuple([self.text(value) for value in term.values]), ATOM
            case Field():
                assert isinstance(term.record.type, core.RecordType)
                names = [name for name, _ in term.record.type.fields]
                return self._item(self.text(term.record), names.index(term.name), len(names)), ATOM
            case If():
                parts = [self.text(part) for part in (term.test, term.then, term.otherwise)]
                return f"(if {parts[0]} then {parts[1]} else {parts[2]})", ATOM
            case Quantifier():
                return self._quantified(term)
            case Comprehension():
                return self._comprehension(term), ATOM
            case Apply():
                return self._applied(term)
        raise Unwritable(term)

    def _closed(self, term: Term) -> str | None:
        """The value of a term without variables, if it can be written."""
        if any(role != "constant" for _, role in free_variables(term)):
            return None
        try:
            return self.value(self._evaluator.value(term), term.type)
        except (Failure, ScriptError, Unwritable):
            return None

    def value(self, value: Any, type_: core.Type) -> str:
        """A value, by a name if it is long."""
        return self._short(self._literal(value, type_), "values" if isinstance(type_, core.SetType) else "value")

    def _short(self, text: str, kind: str) -> str:
        if len(text) <= LONGEST:
            return text
        found = self._named.get(text)
        if found is None:
            found = self._named[text] = self._fresh(kind)
            self.definitions.append(f"{found} = {text}")
        return found

    @staticmethod
    def _tuple(texts: Sequence[str]) -> str:
        return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"

    def _item(self, whole: str, place: int, size: int) -> str:
        if size == 1:
            return f"({whole})"
        names = [self.element() if i == place else "_" for i in range(size)]
        return f"(\\ ({', '.join(names)}) @ {names[place]})({whole})"

    def _quantified(self, term: Quantifier) -> Written:
        with self._bound(term.binders, term.condition) as items:
            names = [self.known[binder.name, "bound"][0] for binder in term.binders]
            if term.kind == "forall":
                return f"empty({{0 | {', '.join([*items, self.negated(term.body)])}}})", ATOM
            items += [self.text(part, AND) for part in conjuncts([term.body])]
            if term.kind == "exists":
                return f"not empty({{0 | {', '.join(items)}}})", NOT
            return f"card({{{self._tuple(names)} | {', '.join(items)}}}) == 1", COMPARED

    def negated(self, term: Term) -> str:
        """That a predicate does not hold."""
        if isinstance(term, Apply) and term.operator == "not":
            return self.text(term.operands[0], AND)
        return f"not {self.text(term, COMPARED)}"

    def _comprehension(self, term: Comprehension) -> str:
        with self._bound(term.binders, term.condition, sequence=term.kind == "lambda") as items:
            body = self.text(term.body, 50)
            if term.kind == "lambda":
                key = self._tuple([self.known[binder.name, "bound"][0] for binder in term.binders])
                return f"mapFromList(<({key}, {body}) | {', '.join(items)}>)"
            found = f"{{{body} | {', '.join(items)}}}"
            return found if term.kind == "set" else f"head(seq({found}))"

    def _applied(self, term: Apply) -> Written:
        operator, operands = term.operator, term.operands
        if any(isinstance(operand.type, core.RealType) for operand in operands) and operator not in ("equal", "in"):
            raise Unwritable("CSPm has no arithmetic of real numbers")
        if operator in INFIX:
            sign, tight = INFIX[operator]
            left_too = tight in (COMPARED,)
            texts = [self.text(operand, tight + (i > 0 or left_too)) for i, operand in enumerate(operands)]
            if operator in ("and", "or"):
                texts = [self.text(operand, tight + 1) for operand in operands]
            return f" {sign} ".join(texts), tight
        if operator in CALLED:
            return f"{CALLED[operator]}({', '.join(self.text(operand) for operand in operands)})", ATOM
        of_pairs = relations.RULES.get(operator)
        if of_pairs is not None:
            return of_pairs(self, term)
        if operator in HELPERS:
            return f"{self.helper(operator)}({self.text(operands[0])})", ATOM
        rule = _RULES.get(operator)
        if rule is None:
            raise Unwritable(operator)
        return rule(self, *operands)

    def helper(self, operator: str) -> str:
        """The name of a function for an operator, which is defined once."""
        found = self._helpers.get(operator)
        if found is None:
            found = self._helpers[operator] = self._fresh(operator)
            names = {letter: self.local(letter) for letter in "afknsvxy"}
            self.definitions.append(HELPERS[operator].format(name=found, **names))
        return found

    # --- sets ----------------------------------------------------------------------------------------------------

    def values(self, carrier: Term) -> str:
        """A set to go through: all of a carrier, as far as the finite readings go."""
        if not any(role != "constant" for _, role in free_variables(carrier)):
            listed = self._listed(carrier)
            functions = isinstance(carrier, Apply) and carrier.operator == "fun" and len(listed) > LONGEST
            if not functions or self._evaluator.readings.of(carrier) is not None:
                return self._short(listed, "values")
        match carrier:
            case Apply(operator="fun", operands=(domain, ranged)):
                return f"{self.helper('functions')}(seq({self.values(domain)}), {self.values(ranged)})"
            case Apply(operator="power" | "finset", operands=(inner,)):
                return f"Set({self.values(inner)})"
            case Apply(operator="rel", operands=(first, second)):
                left, right = self.element(), self.element()
                pairs = f"{left} <- {self.values(first)}, {right} <- {self.values(second)}"
                return f"Set({{({left}, {right}) | {pairs}}})"
            case Apply(operator="cross", operands=operands):
                names = [self.element() for _ in operands]
                generators = [f"{name} <- {self.values(part)}" for name, part in zip(names, operands, strict=True)]
                return f"{{({', '.join(names)}) | {', '.join(generators)}}}"
        if isinstance(carrier, Apply) and carrier.operator in COLLECTIONS:
            raise Unwritable(carrier.operator)
        return self.text(carrier)

    def _listed(self, carrier: Term) -> str:
        assert isinstance(carrier.type, core.SetType)
        try:
            found = self._evaluator.enumerate(carrier)
        except (Failure, ScriptError):
            raise Unwritable("an infinite set") from None
        if len(found) > MOST_LISTED:
            raise Unwritable("a large set")
        return self._literal(frozenset(found), carrier.type)

    def members(self, value: Written, carrier: Term) -> list[str]:
        """What has to be said for a value of the right type to be in a carrier."""
        if self._surely(value[0], carrier):
            return []
        compared, atom = (value[0] if value[1] >= tight else f"({value[0]})" for tight in (COMPARED + 1, ATOM))
        reading = self._evaluator.readings.of(carrier)
        if reading is not None and reading.values is not None:
            return self._among(value, carrier)
        size: list[str] = []
        if reading is not None and isinstance(carrier, Apply) and carrier.operator in COLLECTIONS:
            if "seq" in carrier.operator:
                size = [f"#{atom} <= {reading.bound}"]
            elif carrier.operator in ("power", "power1", "finset", "finset1"):
                size = [f"card({value[0]}) <= {reading.bound}"]
            else:
                raise Unwritable(carrier.operator)
        if not isinstance(carrier, Apply):
            return self._among(value, carrier)
        operands = carrier.operands
        match carrier.operator:
            case operator if operator in _EVERYTHING:
                return []
            case "Nat":
                return [f"0 <= {compared}"]
            case "Nat1":
                return [f"1 <= {compared}"]
            case "range":
                low, high = (self.text(operand, COMPARED + 1) for operand in operands)
                return [f"{low} <= {compared}", f"{compared} <= {high}"]
            case "power" | "finset":
                return [*size, *self._all_of(value[0], operands[0])]
            case "power1" | "finset1":
                return [f"not empty({value[0]})", *size, *self._all_of(value[0], operands[0])]
            case "seq":
                return [*size, *self._all_of(f"set({value[0]})", operands[0])]
            case "seq1":
                return [f"not null({value[0]})", *size, *self._all_of(f"set({value[0]})", operands[0])]
            case "iseq":
                once = f"card(set({value[0]})) == #{atom}"
                return [*size, once, *self._all_of(f"set({value[0]})", operands[0])]
            case "cross":
                names = [self.element() for _ in operands]
                return self._none(f"({', '.join(names)}) <- {{{value[0]}}}", names, operands)
            case "rel":
                names = [self.element() for _ in operands]
                return self._none(f"({', '.join(names)}) <- {value[0]}", names, operands)
            case "bag":
                name = self.element()
                return [*size, *self._none(f"({name}, _) <- set(mapToList({value[0]}))", [name], operands)]
            case "pfun" | "ffun":
                names = [self.element() for _ in operands]
                return self._none(f"({', '.join(names)}) <- set(mapToList({value[0]}))", names, operands)
            case "fun":
                names = [self.element() for _ in operands]
                domain = f"{_keys(self, value[0])} == {self.values(operands[0])}"
                ranged = self._none(f"(_, {names[1]}) <- set(mapToList({value[0]}))", names[1:], operands[1:])
                return [domain, *ranged]
        return self._among(value, carrier)

    def _surely(self, text: str, carrier: Term) -> bool:
        """Whether a variable has values of a carrier alone."""
        values = self.ranges.get(text)
        if values is None or any(role != "constant" for _, role in free_variables(carrier)):
            return False
        try:
            return values <= frozenset(self._evaluator.enumerate(carrier))
        except (Failure, ScriptError):
            return False

    def ranging(self, key: Key, carrier: Term) -> None:
        """Remember that a variable has values of a carrier."""
        name = self.known[key][0]
        self.terms.pop(key, None)
        self._carriers[key] = carrier
        self.ranges.pop(name, None)
        if not any(role != "constant" for _, role in free_variables(carrier)):
            with suppress(Failure, ScriptError):
                self.ranges[name] = frozenset(self._evaluator.enumerate(carrier))

    def is_true(self, predicate: Term) -> bool:
        """Whether a predicate without variables holds."""
        return self._closed(predicate) == "true"

    def inside(self, term: Term, carrier: Term) -> bool:
        """Whether a term is a part of what lies in such carriers, so that it lies in this one."""
        if self._evaluator.readings.of(carrier) is not None:
            return False
        if isinstance(carrier, Apply) and carrier.operator == "seq":
            return self._of_elements(term, carrier.operands[0])
        if isinstance(term, Apply) and term.operator in ("head", "last"):
            return self._of_elements(term.operands[0], carrier)
        if isinstance(term, Variable):
            key = (term.name, term.role)
            if key in self.terms:
                return self.inside(self.terms[key], carrier)
            return key in self._carriers and shape(self._carriers[key]) == shape(carrier)
        return False

    def _of_elements(self, term: Term, carrier: Term) -> bool:
        """Whether all elements of a sequence lie in a carrier."""
        match term:
            case Variable():
                key = (term.name, term.role)
                if key in self.terms:
                    return self._of_elements(self.terms[key], carrier)
                of = self._carriers.get(key)
                return (
                    isinstance(of, Apply)
                    and of.operator in ("seq", "seq1", "iseq")
                    and shape(of.operands[0]) == shape(carrier)
                )
            case Apply(operator="tail" | "front" | "rev" | "filter"):
                return self._of_elements(term.operands[0], carrier)
            case Apply(operator="concat"):
                return all(self._of_elements(operand, carrier) for operand in term.operands)
            case Apply(operator="sequence"):
                return all(self.inside(operand, carrier) for operand in term.operands)
        return False

    def _among(self, value: Written, carrier: Term) -> list[str]:
        listed = self.values(carrier)
        bounds = _INTERVAL.fullmatch(listed)
        if bounds is None:
            return [f"member({value[0]}, {listed})"]
        compared = value[0] if value[1] > COMPARED else f"({value[0]})"
        return [f"{bounds[1]} <= {compared}", f"{compared} <= {bounds[2]}"]

    def _all_of(self, whole: str, carrier: Term) -> list[str]:
        name = self.element()
        return self._none(f"{name} <- {whole}", [name], [carrier])

    def _none(self, generator: str, names: Sequence[str], carriers: Sequence[Term]) -> list[str]:
        """That nothing generated lies outside its carrier."""
        said = [
            text for name, carrier in zip(names, carriers, strict=True) for text in self.members((name, ATOM), carrier)
        ]
        return [f"empty({{0 | {generator}, not ({' and '.join(said)})}})"] if said else []


# --- operators that need more than a name ----------------------------------------------------------------------------


def _keys(self: ExpressionWriter, value: str) -> str:
    k = self.local("k")
    return f"{{{k} | ({k}, _) <- set(mapToList({value}))}}"


def _display(left: str, right: str) -> Callable[..., Written]:
    def rule(self: ExpressionWriter, *operands: Term) -> Written:
        return f"{left}{', '.join(self.text(operand, 50) for operand in operands)}{right}", ATOM

    return rule


def _implies(self: ExpressionWriter, left: Term, right: Term) -> Written:
    return f"{self.negated(left)} or {self.text(right, OR + 1)}", OR


def _not(self: ExpressionWriter, operand: Term) -> Written:
    if isinstance(operand, Apply) and operand.operator == "equal":
        left, right = (self.text(part, COMPARED + 1) for part in operand.operands)
        return f"{left} != {right}", COMPARED
    return f"not {self.text(operand, COMPARED)}", NOT


def _in(self: ExpressionWriter, value: Term, carrier: Term) -> Written:
    said = self.members(self.written(value), carrier)
    if len(said) == 1:
        return said[0], ATOM if said[0].startswith(("member(", "empty(")) else NOT
    return (" and ".join(said), AND) if said else ("true", ATOM)


def _apply(self: ExpressionWriter, function: Term, argument: Term) -> Written:
    if isinstance(function.type, core.SequenceType):
        return f"{self.helper('nth')}({self.text(function)}, {self.text(argument)})", ATOM
    if isinstance(function.type, core.BagType):
        return relations.counted(self, function, argument)
    if not isinstance(function.type, core.FunctionType):
        raise Unwritable("apply")
    if isinstance(function, Apply) and function.operator == "sequence_to_function":
        return _apply(self, function.operands[0], argument)
    return f"mapLookup({self.text(function)}, {self.text(argument)})", ATOM


def _function(self: ExpressionWriter, *pairs: Term) -> Written:
    return f"mapFromList(<{', '.join(self.text(pair) for pair in pairs)}>)", ATOM


def _peeled(term: Term) -> Term:
    while isinstance(term, Apply) and term.operator in ("sequence_to_function", "function_to_relation"):
        term = term.operands[0]
    return term


def _domain(self: ExpressionWriter, function: Term) -> Written:
    function = _peeled(function)
    return _keys(self, self.text(function)) if isinstance(function.type, core.FunctionType) else _side(
        self, function, 0
    ), ATOM


def _range(self: ExpressionWriter, function: Term) -> Written:
    return _side(self, _peeled(function), 1), ATOM


def _side(self: ExpressionWriter, relation: Term, place: int) -> str:
    if isinstance(relation.type, core.SequenceType):
        text = self.text(relation, ATOM)
        return f"set({text})" if place else f"{{1..#{text}}}"
    x = self.local("v" if place else "x")
    pattern = f"(_, {x})" if place else f"({x}, _)"
    return f"{{{x} | {pattern} <- {relations.pairs_of(self, relation)}}}"


def _restricted(*, place: int, keep: bool) -> Callable[..., Written]:
    """``S <| f`` and its like; *place*: which operand is the set, which is also the side of the pairs that it is of."""

    def rule(self: ExpressionWriter, *operands: Term) -> Written:
        chosen, whole = operands[place], operands[1 - place]
        k, v = self.local("k"), self.local("v")
        test = f"{'' if keep else 'not '}member({v if place else k}, {self.text(chosen)})"
        if isinstance(whole.type, core.FunctionType):
            return f"mapFromList(<({k}, {v}) | ({k}, {v}) <- mapToList({self.text(whole)}), {test}>)", ATOM
        return f"{{({k}, {v}) | ({k}, {v}) <- {relations.pairs_of(self, whole)}, {test}}}", ATOM

    return rule


def _relation(self: ExpressionWriter, function: Term) -> Written:
    return f"set(mapToList({self.text(function)}))", ATOM


def _filter(self: ExpressionWriter, sequence: Term, chosen: Term) -> Written:
    x = self.local("x")
    return f"<{x} | {x} <- {self.text(sequence)}, member({x}, {self.text(chosen)})>", ATOM


def _symmetric_difference(self: ExpressionWriter, left: Term, right: Term) -> Written:
    a, b = self.text(left), self.text(right)
    return f"union(diff({a}, {b}), diff({b}, {a}))", ATOM


def _disjoint(self: ExpressionWriter, *operands: Term) -> Written:
    texts = [self.text(operand) for operand in operands]
    found = [f"empty(inter({a}, {b}))" for i, a in enumerate(texts) for b in texts[i + 1 :]]
    return (" and ".join(found), AND) if found else ("true", ATOM)


def _item_of(self: ExpressionWriter, whole: Term, place: Term) -> Written:
    assert isinstance(whole.type, core.TupleType)
    assert isinstance(place, core.Constant)
    return self._item(self.text(whole), int(place.value), len(whole.type.items)), ATOM


_RULES: Final[Mapping[str, Callable[..., Written]]] = {
    "not": _not,
    "implies": _implies,
    "in": _in,
    "negate": lambda self, operand: (f"(0 - {self.text(operand, 61)})", ATOM),
    "set": _display("{", "}"),
    "sequence": _display("<", ">"),
    "tuple": lambda self, *operands: (f"({', '.join(self.text(operand) for operand in operands)})", ATOM),
    "item": _item_of,
    "range": lambda self, low, high: (f"{{{self.text(low, 50)}..{self.text(high, 50)}}}", ATOM),
    "symdiff": _symmetric_difference,
    "disjoint": _disjoint,
    "length": lambda self, sequence: (f"#{self.text(sequence, ATOM)}", 75),
    "apply": _apply,
    "function": _function,
    "dom": _domain,
    "ran": _range,
    "dom_restrict": _restricted(place=0, keep=True),
    "dom_subtract": _restricted(place=0, keep=False),
    "ran_restrict": _restricted(place=1, keep=True),
    "ran_subtract": _restricted(place=1, keep=False),
    "function_to_relation": _relation,
    "filter": _filter,
}
