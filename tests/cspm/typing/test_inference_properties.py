"""Expressions that are well typed by construction are accepted, get their type, and evaluate to a value of it.

Each strategy below writes an expression of a wanted type, out of literals, variables, local definitions, functions
of the script and of the language, and comprehensions. A wrong type put into one place makes it unacceptable.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.cspm import script
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.resolve import resolve_more
from cspcheck.cspm.parsing.reading import parse_expression
from cspcheck.cspm.source import Source
from cspcheck.cspm.typing.inference import infer_expression
from tests.examples import examples

TEXT = """
datatype T = A.{0..2} | B.Bool.T0 | C
datatype T0 = K.{0..1} | L
channel c : {0..2}.T
channel d : T0
channel e
id(x) = x
pair(x, y) = (x, y)
fst((x, _)) = x
snd((_, y)) = y
apply(f, x) = f(x)
compose(f, g) = \\ x @ f(g(x))
map(f)(<>) = <>
map(f)(<x>^xs) = <f(x)>^map(f)(xs)
foldr(f, z, <>) = z
foldr(f, z, <x>^xs) = f(x, foldr(f, z, xs))
first(<x>^_) = x
const(x)(y) = x
field(c._.t) = t
number(A.n) = n
number(_) = 7
"""
SCRIPT = script.load(Source("typed.csp", TEXT))


# --- types ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Kind:
    """A type, with what can be done with its values."""

    text: str
    head: str
    parts: tuple[Kind, ...] = ()
    equality: bool = True
    ordered: bool = False


INT, BOOL, CHAR = Kind("Int", "Int", ordered=True), Kind("Bool", "Bool"), Kind("Char", "Char", ordered=True)
T, T0, EVENT = Kind("T", "T"), Kind("T0", "T0"), Kind("Event", "Event")
PROC = Kind("Proc", "Proc", equality=False)


def set_of(kind: Kind) -> Kind:
    return Kind(f"{{{kind.text}}}", "set", (kind,), kind.equality, ordered=kind.equality)


def sequence_of(kind: Kind) -> Kind:
    return Kind(f"<{kind.text}>", "sequence", (kind,), kind.equality, ordered=kind.equality)


def tuple_of(*kinds: Kind) -> Kind:
    text = f"({', '.join(kind.text for kind in kinds)})"
    return Kind(text, "tuple", kinds, all(k.equality for k in kinds), all(k.ordered for k in kinds))


def map_of(key: Kind, value: Kind) -> Kind:
    text = f"(| {key.text} => {value.text} |)"
    return Kind(text, "map", (key, value), key.equality and value.equality, key.ordered and value.ordered)


ATOMS = st.sampled_from([INT, BOOL, CHAR, T, T0, EVENT])
COMPARABLE = st.recursive(
    ATOMS,
    lambda inner: st.one_of(
        inner.map(set_of),
        inner.map(sequence_of),
        st.builds(tuple_of, inner, inner),
        st.builds(map_of, ATOMS, inner),
    ),
    max_leaves=3,
)
ANY = COMPARABLE | st.sampled_from([PROC, set_of(PROC), sequence_of(PROC), tuple_of(INT, PROC)])


# --- expressions ------------------------------------------------------------------------------------------------


@dataclass
class Writer:
    """Writes expressions; ``scope`` has the variables in reach with their types."""

    draw: Any
    scope: list[tuple[str, Kind]] = field(default_factory=list)
    names: int = 0

    def fresh(self) -> str:
        self.names += 1
        return f"v{self.names}"

    def choose(self, options: list[Any]) -> Any:
        return options[self.draw(st.integers(0, len(options) - 1))]

    def write(self, kind: Kind, depth: int) -> str:
        variables = [name for name, known in self.scope if known == kind]
        if variables and self.draw(st.booleans()):
            return self.choose(variables)
        if depth <= 0:
            return self.literal(kind)
        forms = [self.literal, self.structured, self.conditional, self.local, self.applied, self.specific]
        return f"({self.choose(forms)(kind, depth - 1)})"

    def within(self, bound: list[tuple[str, Kind]], kind: Kind, depth: int) -> str:
        """An expression with more variables in reach."""
        self.scope.extend(bound)
        text = self.write(kind, depth)
        del self.scope[len(self.scope) - len(bound) :]
        return text

    def literal(self, kind: Kind, depth: int = 0) -> str:
        """The simplest form of a value; without brackets only where nothing needs them."""
        match kind.head:
            case "Int":
                return str(self.draw(st.integers(0, 9)))
            case "Bool":
                return self.choose(["true", "false"])
            case "Char":
                return self.choose(["'a'", "'b'"])
            case "T":
                return self.choose(["(A.1)", "(B.true.K.0)", "(B.false.L)", "C"])
            case "T0":
                return self.choose(["(K.1)", "L"])
            case "Event":
                return self.choose(["(c.0.A.2)", "(c.1.C)", "(d.L)", "(d.K.0)", "e", "(c.2.B.true.L)"])
            case "Proc":
                return self.choose(["STOP", "SKIP", "(e -> STOP)", "(d?x -> SKIP)"])
            case "set":
                return f"{{{self.literal(kind.parts[0])}}}"
            case "sequence":
                return f"<{self.literal(kind.parts[0])}>"
            case "tuple":
                return f"({', '.join(self.literal(part) for part in kind.parts)})"
        return f"(| {self.literal(kind.parts[0])} => {self.literal(kind.parts[1])} |)"

    def structured(self, kind: Kind, depth: int) -> str:
        """The form in which the values of the type are written, around smaller expressions."""
        part = kind.parts[0] if kind.parts else kind
        # An empty set alone would be one of any type.
        items = [self.write(part, depth) for _ in range(self.draw(st.integers(1, 2)))]
        match kind.head:
            case "Int":
                return f"{self.write(INT, depth)} {self.choose(['+', '-', '*'])} {self.write(INT, depth)}"
            case "Bool":
                return f"{self.write(BOOL, depth)} {self.choose(['and', 'or'])} not {self.write(BOOL, depth)}"
            case "Char":
                return f"first({self.write(sequence_of(CHAR), 0)})"
            case "T":
                return self.choose(
                    [f"A.({self.write(INT, depth)} % 3)", f"B.{self.write(BOOL, depth)}.{self.write(T0, 0)}"]
                )
            case "T0":
                return f"K.({self.write(INT, depth)} % 2)"
            case "Event":
                return self.choose(
                    [f"c.({self.write(INT, depth)} % 3).{self.write(T, depth)}", f"d.{self.write(T0, depth)}"]
                )
            case "Proc":
                return self.process(depth)
            case "set":
                return f"{{{', '.join(items)}}}"
            case "sequence":
                return f"<{', '.join(items)}> ^ {self.write(kind, depth)}"
            case "tuple":
                return f"{', '.join(self.write(part, depth) for part in kind.parts)}"
        return f"mapUpdate({self.write(kind, depth)}, {self.write(part, depth)}, {self.write(kind.parts[1], depth)})"

    def process(self, depth: int) -> str:
        return self.choose(
            [
                f"{self.write(EVENT, depth)} -> {self.write(PROC, depth)}",
                f"{self.write(PROC, depth)} [] {self.write(PROC, depth)}",
                f"{self.write(PROC, depth)} [| {self.write(set_of(EVENT), depth)} |] {self.write(PROC, depth)}",
                f"{self.write(BOOL, depth)} & {self.write(PROC, depth)}",
                f"{self.write(PROC, depth)} \\ {self.write(set_of(EVENT), 0)}",
            ]
        )

    def conditional(self, kind: Kind, depth: int) -> str:
        return f"if {self.write(BOOL, depth)} then {self.write(kind, depth)} else {self.write(kind, depth)}"

    def local(self, kind: Kind, depth: int) -> str:
        """A ``let``, whose pattern takes its value apart in one of the ways that its type allows."""
        other = self.draw(COMPARABLE)
        x, y = self.fresh(), self.fresh()
        value, bound, pattern = self.write(other, depth), [(x, other)], x
        match other.head:
            case "tuple":
                pattern, bound = f"({x}, {y})", [(x, other.parts[0]), (y, other.parts[1])]
            case "sequence":
                value, pattern = f"<{self.literal(other.parts[0])}>^{value}", f"<{x}>^{y}"
                bound = [(x, other.parts[0]), (y, other)]
            case "T":
                value, pattern, bound = (
                    f"B.{self.write(BOOL, 0)}.{self.write(T0, 0)}",
                    f"B.{x}.{y}",
                    [(x, BOOL), (y, T0)],
                )
            case "Event":
                value, pattern, bound = f"c.1.{self.write(T, 0)}", f"c._.{x}", [(x, T)]
        if self.draw(st.booleans()) and pattern == x:
            # A function of one argument instead.
            body = self.within([(y, other)], kind, depth)
            return f"let {x}({y}) = {body} within {x}({value})"
        return f"let {pattern} = {value} within {self.within(bound, kind, depth)}"

    def applied(self, kind: Kind, depth: int) -> str:
        """A function that works at every type."""
        other, x, y = self.draw(COMPARABLE), self.fresh(), self.fresh()
        key = self.literal(other)
        options = [
            lambda: f"id({self.write(kind, depth)})",
            lambda: f"fst(pair({self.write(kind, depth)}, {self.write(other, depth)}))",
            lambda: f"snd(({self.write(other, depth)}, {self.write(kind, depth)}))",
            lambda: f"apply(\\ {x} @ {self.within([(x, other)], kind, depth)}, {self.write(other, depth)})",
            lambda: f"compose(\\ {x} @ {self.within([(x, other)], kind, depth)}, id)({self.write(other, depth)})",
            lambda: f"first(<{self.write(kind, depth)}>^{self.write(sequence_of(kind), depth)})",
            lambda: f"head(<{self.write(kind, depth)}>)",
            lambda: f"const({self.write(kind, depth)})({self.write(other, depth)})",
            lambda: (
                f"foldr(\\ {x}, {y} @ {self.within([(x, other), (y, kind)], kind, 0)}, {self.write(kind, depth)}, "
                f"{self.write(sequence_of(other), depth)})"
            ),
            lambda: f"mapLookup((| {key} => {self.write(kind, depth)} |), {key})",
        ]
        if kind.equality:
            options.append(lambda: f"head(seq({{{self.write(kind, depth)}}}))")
        return self.choose(options)()

    def specific(self, kind: Kind, depth: int) -> str:
        """An operation whose result is of this type."""
        other = self.draw(COMPARABLE)
        x = self.fresh()
        match kind.head:
            case "Int":
                return self.choose(
                    [
                        f"card({self.write(set_of(other), depth)})",
                        f"#{self.write(sequence_of(other), depth)}",
                        f"number({self.write(T, depth)})",
                        f"-{self.write(INT, depth)}",
                    ]
                )
            case "Bool":
                operators = ["==", "!=", *(["<", "<=", ">", ">="] if other.ordered else [])]
                return self.choose(
                    [
                        f"{self.write(other, depth)} {self.choose(operators)} {self.write(other, depth)}",
                        f"member({self.write(other, depth)}, {self.write(set_of(other), depth)})",
                        f"elem({self.write(other, depth)}, {self.write(sequence_of(other), depth)})",
                        f"null({self.write(sequence_of(other), depth)})",
                    ]
                )
            case "T":
                return f"field(c.0.{self.write(T, depth)})"
            case "set":
                return self.set_(kind, kind.parts[0], other, x, depth)
            case "sequence":
                part = kind.parts[0]
                source = self.write(sequence_of(other), depth)
                return self.choose(
                    [
                        f"<{self.within([(x, other)], part, depth)} | {x} <- {source}>",
                        f"map(\\ {x} @ {self.within([(x, other)], part, depth)})({source})",
                        f"concat(<{self.write(kind, depth)}, {self.write(kind, depth)}>)",
                    ]
                )
            case "tuple" | "map":
                return self.structured(kind, depth)
        return self.conditional(kind, depth)

    def set_(self, kind: Kind, part: Kind, other: Kind, x: str, depth: int) -> str:
        source = self.write(set_of(other), depth)
        options = [
            f"{{{self.within([(x, other)], part, depth)} | {x} <- {source}}}",
            f"union({self.write(kind, depth)}, {self.write(kind, depth)})",
            f"set({self.write(sequence_of(part), depth)})",
            f"Union({{{self.write(kind, depth)}}})",
        ]
        if part.head == "Int":
            options += [f"{{1..{self.draw(st.integers(0, 3))}}}", "{n | c.n._ <- {| c |}}"]
        if part.head == "Event":
            options += ["{| c.1, d |}", "{| c.0.B.true |}"]
        if part.head == "T":
            options += ["T", "extensions(c.2)", "{| A, B.false |}"]
        return self.choose(options)


@st.composite
def expressions(draw: Any, kinds: st.SearchStrategy[Kind] = ANY) -> tuple[str, Kind]:
    kind = draw(kinds)
    return Writer(draw).write(kind, draw(st.integers(1, 3))), kind


def type_of(text: str) -> str:
    node = parse_expression(text)
    resolve_more(SCRIPT.names, node)
    assert SCRIPT.types is not None
    return str(infer_expression(node, SCRIPT.types))


def fits(value: Any, kind: Kind) -> bool:
    """Whether a Python value is one of the type."""
    match kind.head:
        case "Int":
            return type(value) is int
        case "Bool":
            return type(value) is bool
        case "Char":
            return type(value) is str and len(value) == 1
        case "T":
            return type(value) is str and value.split(".")[0] in ("A", "B", "C")
        case "T0":
            return type(value) is str and value.split(".")[0] in ("K", "L")
        case "Event":
            return type(value) is str and value.split(".")[0] in ("c", "d", "e")
        case "Proc":
            return type(value) is str
        case "set":
            return type(value) is frozenset and all(fits(item, kind.parts[0]) for item in value)
        case "sequence":
            return type(value) in (tuple, str) and all(fits(item, kind.parts[0]) for item in value)
        case "tuple":
            return type(value) is tuple and all(map(fits, value, kind.parts))
    pairs = value.items() if type(value) is dict else value
    return all(fits(key, kind.parts[0]) and fits(kept, kind.parts[1]) for key, kept in pairs)


SLOW = settings(max_examples=examples(60), deadline=None, suppress_health_check=[HealthCheck.too_slow])


@SLOW
@given(expressions())
def test_an_expression_that_is_well_typed_by_construction_has_its_type(written: tuple[str, Kind]) -> None:
    text, kind = written
    assert type_of(text) == kind.text


@SLOW
@given(expressions())
def test_a_definition_that_is_well_typed_by_construction_meets_its_annotation(written: tuple[str, Kind]) -> None:
    text, kind = written
    loaded = script.load(Source("x.csp", f"{TEXT}\ndefined :: {kind.text}\ndefined = {text}\nagain = defined\n"))
    assert loaded.types is not None
    assert dict(loaded.types.listing())["again"] == kind.text


@SLOW
@given(expressions())
def test_a_value_has_the_type_of_its_expression(written: tuple[str, Kind]) -> None:
    text, kind = written
    assert fits(SCRIPT.evaluate(text), kind)


@SLOW
@given(expressions(), ANY)
def test_an_expression_is_refused_where_another_type_is_needed(written: tuple[str, Kind], other: Kind) -> None:
    text, kind = written
    if other == kind:
        return
    with pytest.raises(ScriptError):
        script.load(Source("x.csp", f"{TEXT}\ndefined :: {other.text}\ndefined = {text}\n"))


@SLOW
@given(expressions(st.just(INT)), st.sampled_from([BOOL, CHAR, T, T0, EVENT, PROC, set_of(INT)]), st.data())
def test_an_expression_with_one_wrong_literal_is_refused(
    written: tuple[str, Kind], other: Kind, data: st.DataObject
) -> None:
    text, _ = written
    wrong = Writer(data.draw).literal(other)
    with pytest.raises(ScriptError):
        type_of(f"{text} + {wrong}")
    with pytest.raises(ScriptError):
        type_of(f"first(<{text}, {wrong}>)")
