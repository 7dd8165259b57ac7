"""Mistakes in the predicates of classes: names, types, and decorations out of place."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.source import Span


def _class(predicate: str) -> str:
    return (
        "class C\n  chan c : [v? : nat]\n  main = c -> main\n  state\n    x : nat\n"
        f"  op c\n    Delta(x)\n    v? : nat\n  where\n    {predicate}\nend"
    )


def _meant(names: Sequence[str]) -> str | None:
    if not names:
        return None
    quoted = [f"`{name}`" for name in names]
    return f"did you mean {', '.join(quoted[:-1]) + ' or ' if len(quoted) > 1 else ''}{quoted[-1]}?"


@mistake(
    "CSP630",
    "a name in a predicate is not known",
    explanation=(
        "A predicate speaks of state variables, parameters, constants, bound variables, the script's types and "
        "the functions of the toolkit. Primed names are state variables after an operation."
    ),
    example=_class("x' = vv?"),
    repair=_class("x' = v?"),
)
def unknown_name(name: str, span: Span, suggested: Sequence[str] = ()) -> Diagnostic:
    """A name that means nothing where it stands."""
    return Diagnostic("CSP630", f"`{name}` is not known here", span, annotation="not in scope", help=_meant(suggested))


def unknown_parameter(name: str, span: Span, suggested: Sequence[str] = ()) -> Diagnostic:
    """A decorated name that is no parameter of the operation."""
    return Diagnostic(
        "CSP630",
        f"`{name}` is no parameter of this operation",
        span,
        annotation="not declared",
        help=_meant(suggested),
    )


@mistake(
    "CSP631",
    "types in a predicate differ",
    explanation=(
        "Both sides of `=`, `<`, `in` and of the operators on sets and sequences must have types that fit. Integers "
        "fit reals, sequences fit functions from 1..n, functions fit relations."
    ),
    example=_class("x' = {v?}"),
    repair=_class("x' = v?"),
)
def types_differ(found: str, expected: str, span: Span, *, member: bool = False) -> Diagnostic:
    """Two terms that must have one type."""
    if member:
        return Diagnostic("CSP631", f"a value of type `{found}` is no element of a set of `{expected}`", span)
    one_is_a_set = found == f"power {expected}" or expected == f"power {found}"
    hint = "`x : {0..3}` declares a set, `x : 0..3` one of its numbers" if one_is_a_set else None
    return Diagnostic("CSP631", f"the types `{found}` and `{expected}` differ", span, help=hint)


@mistake(
    "CSP632",
    "an operand is of the wrong kind",
    explanation="Arithmetic needs numbers, `dom` and `ran` a relation, `head` a sequence, and so on.",
    example=_class("x' = #v?"),
    repair=_class("x' = v?"),
)
def wrong_operand(expected: str, found: str, span: Span) -> Diagnostic:
    """An operand that an operator cannot take."""
    return Diagnostic("CSP632", f"{expected} is needed here, not a value of type `{found}`", span)


def no_set(found: str, span: Span) -> Diagnostic:
    """Something that stands where a set is needed."""
    return Diagnostic("CSP632", f"a set is needed here, not a value of type `{found}`", span)


def not_applicable(found: str, span: Span) -> Diagnostic:
    """Something applied that is no function, sequence or bag."""
    return Diagnostic("CSP632", f"a value of type `{found}` cannot be applied", span, annotation="no function")


def relation_applied(found: str, span: Span) -> Diagnostic:
    """A relation applied like a function."""
    return Diagnostic(
        "CSP632",
        "a relation is applied like a function",
        span,
        annotation=f"of type `{found}`",
        help="declare it with `pfun` or `-->`, or use the image `r(| {x} |)`",
    )


def constructor_without_argument(name: str, span: Span) -> Diagnostic:
    """A constructor of a free type that needs an argument."""
    return Diagnostic("CSP632", f"the constructor `{name}` needs an argument", span, help=f"write `{name}(...)`")


def constructor_with_argument(name: str, span: Span) -> Diagnostic:
    """A constant of a free type applied to something."""
    return Diagnostic("CSP632", f"the constructor `{name}` takes no argument", span)


def function_without_argument(name: str, span: Span) -> Diagnostic:
    """A function of the toolkit by itself."""
    return Diagnostic("CSP632", f"the function `{name}` needs an argument", span, help=f"write `{name}(...)`")


def partition_of_no_display(span: Span) -> Diagnostic:
    """``partition`` or ``disjoint`` on sets that are not written out."""
    return Diagnostic(
        "CSP632",
        "the sets must be written out as a sequence",
        span,
        help="write `disjoint <A, B>` or `<A, B> partition C`",
    )


@mistake(
    "CSP633",
    "an expression stands where a predicate is needed, or the other way round",
    explanation="Each line of a predicate is true or false; a number or a set by itself says nothing.",
    example=_class("x' + v?"),
    repair=_class("x' = v?"),
)
def no_predicate(found: str, span: Span) -> Diagnostic:
    """An expression where a predicate is needed."""
    return Diagnostic(
        "CSP633",
        f"a predicate is needed here, not a value of type `{found}`",
        span,
        annotation="neither true nor false",
    )


@mistake(
    "CSP634",
    "the type of an empty collection is open",
    explanation="`{}` and `<>` have the type of what stands beside them; here nothing says what they could hold.",
    example=_class("{} = {}"),
    repair=_class("x' = v?"),
)
def open_type(span: Span | None) -> Diagnostic:
    """An empty collection beside nothing that has a type."""
    return Diagnostic(
        "CSP634",
        "what this empty collection could hold is not said",
        span,
        help="compare it with something of a known type",
    )


@mistake(
    "CSP635",
    "a record has no such field",
    explanation="`r.f` needs a record, declared by a schema, that has the field `f`; `r.INIT` a schema with an INIT.",
    example="schema Pair\n  a, b : nat\nend\nclass C\n  main = STOP\n  state\n    p : Pair\n  where\n    p.c = 0\nend",
    repair="schema Pair\n  a, b : nat\nend\nclass C\n  main = STOP\n  state\n    p : Pair\n  where\n    p.b = 0\nend",
)
def no_such_field(name: str, record: str, span: Span, suggested: Sequence[str] = ()) -> Diagnostic:
    """A field that the schema does not declare."""
    return Diagnostic("CSP635", f"`{record}` has no field `{name}`", span, help=_meant(suggested))


def field_of_no_record(name: str, found: str, span: Span) -> Diagnostic:
    """A field of something that is no record."""
    return Diagnostic("CSP635", f"a value of type `{found}` has no field `{name}`", span, annotation="no record")


def init_of_no_record(found: str, span: Span) -> Diagnostic:
    """``x.INIT`` where x is no record."""
    return Diagnostic(
        "CSP635",
        f"a value of type `{found}` has no INIT",
        span,
        annotation="no record",
        help="only a schema declares an INIT; give the initial value, `x = ...`",
    )


def record_without_init(name: str, span: Span) -> Diagnostic:
    """``x.INIT`` where the schema has none."""
    return Diagnostic("CSP635", f"the schema `{name}` has no INIT", span, help=f"add `init ...` to `schema {name}`")


def no_such_record(fields: Sequence[str], schemas: Sequence[str], span: Span) -> Diagnostic:
    """A record display that fits no schema."""
    return Diagnostic(
        "CSP635",
        f"no schema has just the fields {', '.join(f'`{name}`' for name in fields)} with such values",
        span,
        help=f"the schemas are {', '.join(f'`{name}`' for name in schemas)}" if schemas else None,
    )


@mistake(
    "CSP636",
    "a decoration is out of place",
    explanation=(
        "`x'` is the value of a state variable after an operation: it has no place in INIT, invariants and guards. "
        "Parameters `v?` and `v!` belong to operations; a guard is decided before outputs exist, so it cannot use `v!`."
    ),
    example="class C\n  main = STOP\n  state\n    x : nat\n  init\n    x' = 0\nend",
    repair="class C\n  main = STOP\n  state\n    x : nat\n  init\n    x = 0\nend",
)
def prime_out_of_place(name: str, place: str, span: Span) -> Diagnostic:
    """A primed name outside an operation's effect."""
    where = _PLACES.get(place, "here")
    return Diagnostic(
        "CSP636",
        f"`{name}` has no meaning {where}",
        span,
        annotation="primed",
        help=f"write `{name[:-1]}`"
        if place in ("initial", "invariant")
        else "speak of the state before, without the prime",
    )


def no_schema(found: str, span: Span) -> Diagnostic:
    """Something that is included, or composed with schemas, and is none."""
    return Diagnostic(
        "CSP631", f"this is no schema but of type `{found}`", span, help="a declaration is written `x : T`"
    )


def no_schema_here(span: Span) -> Diagnostic:
    """A schema where only declarations of variables have a meaning."""
    return Diagnostic("CSP631", "a schema cannot be included here", span, help="declare its components")


@mistake(
    "CSP647",
    "a variable is taken from a set of one set of numbers",
    explanation=(
        "In a class `x : S` takes x from the set S. `0..3` is a set of numbers already; `{0..3}` is the set whose one "
        "element is that set, so that x can be nothing but `0..3`. In a channel declaration of CSPm it is the other "
        "way round: `channel c : {0..3}`."
    ),
    example="class C\n  chan tick\n  state\n    x : {0..3}\nend",
    repair="class C\n  chan tick\n  state\n    x : 0..3\nend",
)
def set_of_one_range(written: str, inner: str, span: Span) -> Diagnostic:
    """A declaration whose set has one element, a set of numbers."""
    return Diagnostic(
        "CSP647",
        f"the one element of `{written}` is the set `{inner}`",
        span,
        Severity.WARNING,
        help=f"for a number write `{inner}`",
    )


def no_component(name: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name that is no component of a schema, where one is hidden or renamed."""
    return Diagnostic("CSP630", f"`{name}` is no component of this schema", span, help=_meant(suggested))


def iteration_not_known(span: Span) -> Diagnostic:
    """An iterate of a relation whose number is not written out."""
    return Diagnostic(
        "CSP631",
        "how often the relation is iterated must be a number that is written out, up to 32",
        span,
        help="`r^+` and `r^*` are its closures",
    )


def prime_on_no_state(name: str, span: Span) -> Diagnostic:
    """A prime on something that does not change."""
    return Diagnostic(
        "CSP636", f"`{name[:-1]}` is no state variable, so it has no value after", span, annotation="primed"
    )


def parameter_out_of_place(name: str, place: str, span: Span) -> Diagnostic:
    """A parameter outside an operation."""
    where = _PLACES.get(place, "here")
    return Diagnostic("CSP636", f"`{name}` has no meaning {where}", span, annotation="a parameter of an operation")


def output_in_guard(name: str, span: Span) -> Diagnostic:
    """An output in an enable schema."""
    return Diagnostic(
        "CSP636",
        f"the output `{name}` has no value yet in a guard",
        span,
        annotation="chosen after the guard",
        help="move the condition to the effect schema",
    )


def parameter_without_decoration(name: str, decorated: str, span: Span) -> Diagnostic:
    """A parameter written without its ``?`` or ``!``."""
    return Diagnostic("CSP636", f"`{name}` is not known here", span, help=f"the parameter is written `{decorated}`")


_PLACES = {
    "initial": "in INIT",
    "invariant": "in an invariant",
    "guard": "in a guard",
    "axiom": "in an axiom",
    "record": "in a schema",
    "retrieve": "in a retrieve relation",
}


@mistake(
    "CSP637",
    "a class is used as a value",
    explanation=(
        "A class is a process. An attribute `a : C` or `f : X -> C` is an object for ever, or a family of them, if C "
        "has operations and no channels; objects cannot be exchanged, shared or passed as values. What several "
        "processes share is a process of its own, composed with them and joined by channels."
    ),
    example="class Board\n  main = STOP\nend\nclass C\n  main = STOP\n  state\n    b : Board\nend",
    repair="schema Board\n  direction : nat\nend\nclass C\n  main = STOP\n  state\n    b : Board\nend",
)
def class_is_no_value(name: str, span: Span, declared: Span) -> Diagnostic:
    """A class where a value or a set of values is needed."""
    return Diagnostic(
        "CSP637",
        f"`{name}` is a class, not a type of values",
        span,
        labels=(Label(declared, "declared here"),),
        help="let it be a process beside this one, joined by channels, or declare its data with `schema`",
    )


def object_is_no_value(name: str, span: Span, declared: Span) -> Diagnostic:
    """An object where its identity would be a value."""
    return Diagnostic(
        "CSP637",
        f"`{name}` is an object, not a value",
        span,
        labels=(Label(declared, "declared here"),),
        help="a name is one object for ever: say what holds of its attributes, or call its operations",
    )


def no_such_object(text: str, span: Span) -> Diagnostic:
    """Something that looks like an object and is none, such as a family without an identity."""
    return Diagnostic("CSP637", f"`{text}` is no object", span, help="of a family `f : X -> C`, `f(x)` is one")


@mistake(
    "CSP638",
    "a name is bound or declared twice",
    explanation="A quantifier, a comprehension, a schema or a class can declare each name once.",
    example=_class("exists y : nat; y : nat @ y = v? and x' = y"),
    repair=_class("exists y : nat; z : nat @ y = v? and z = y and x' = z"),
)
def bound_twice(name: str, span: Span) -> Diagnostic:
    """The same name twice in one list of declarations."""
    return Diagnostic("CSP638", f"`{name}` is declared twice", span, annotation="declared again here")


def declared_twice(name: str, first: Span | None, second: Span) -> Diagnostic:
    """The same name twice in one class, schema or script."""
    labels = () if first is None else (Label(first, "first declared here"),)
    return Diagnostic("CSP638", f"`{name}` is declared twice", second, annotation="declared again here", labels=labels)


@mistake(
    "CSP639",
    "generic arguments do not match",
    explanation="A class or an abbreviation with generic parameters needs one argument for each of them.",
    example="Pair[X, Y] == X cross Y\nclass C\n  main = STOP\n  state\n    p : Pair[nat]\nend",
    repair="Pair[X, Y] == X cross Y\nclass C\n  main = STOP\n  state\n    p : Pair[nat, nat]\nend",
)
def generic_arguments(name: str, wanted: int, given: int, span: Span) -> Diagnostic:
    """A wrong number of generic arguments."""
    return Diagnostic("CSP639", f"`{name}` has {wanted} generic parameters, not {given}", span)


def no_operator_here(name: str, span: Span) -> Diagnostic:
    """An operator of operation expressions inside a predicate."""
    return Diagnostic("CSP632", f"the operator `{name}` has no meaning in a predicate", span)


def lambda_without_body(span: Span) -> Diagnostic:
    """``lambda`` without the expression behind ``@``."""
    return Diagnostic("CSP633", "a lambda needs an expression", span, help="write `lambda x : T @ e`")


def ambiguous_variable(name: str, choices: Sequence[str], span: Span) -> Diagnostic:
    """A state variable that both classes of a retrieve relation have."""
    return Diagnostic(
        "CSP630", f"both classes have `{name}`", span, help=f"write {' or '.join(f'`{c}`' for c in choices)}"
    )
