"""Mistakes with types: what does not fit together, lacks a constraint, or is left open where it must be known.

Types come in as texts, written by the caller so that a variable has the same letter throughout one message.
"""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.source import Span

Pair = tuple[str, str]
"""An expected type and the actual one, as texts."""


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _stack(pairs: Sequence[Pair]) -> tuple[str, ...]:
    """The pairs that were being matched, innermost first; the outermost is the message itself."""
    if len(pairs) < 2:
        return ()
    notes = [f"`{pairs[0][1]}` is not `{pairs[0][0]}`"]
    notes.extend(f"while matching `{actual}` with `{expected}`" for expected, actual in pairs[1:])
    return tuple(notes)


@mistake(
    "CSP301",
    "an expression has another type than its place needs",
    explanation=(
        "Every expression has a type, found without running the script, and every place in which it can stand needs "
        "one: the operands of `[]` are processes, the set behind `\\` contains events, the argument of a function "
        "has the type of its parameter. The notes say which parts of the two types differ."
    ),
    example="channel a, b\nP = a -> (a [] b)",
    repair="channel a, b\nP = a -> (a -> STOP [] b -> STOP)",
)
def mismatch(
    span: Span,
    pairs: Sequence[Pair],
    role: str,
    labels: Sequence[Label] = (),
    help_line: str | None = None,
) -> Diagnostic:
    """*pairs* are the types that were being matched, innermost first; *role* is the place, such as "the body"."""
    expected, actual = pairs[-1]
    return Diagnostic(
        "CSP301",
        f"expected type `{expected}`, found `{actual}`",
        span,
        annotation=f"{role} has type `{actual}`" if role else f"this has type `{actual}`",
        labels=tuple(labels),
        notes=_stack(pairs),
        help=help_line,
    )


@mistake(
    "CSP302",
    "a type would contain itself",
    explanation=(
        "No type can be a part of itself, so nothing can be, say, a sequence of its own type or a function that takes "
        "itself as argument."
    ),
    example="f(xs) = if xs == <xs> then 1 else 0",
    repair="f(x, xs) = if xs == <x> then 1 else 0",
)
def infinite_type(span: Span, variable: str, type_: str, role: str, labels: Sequence[Label] = ()) -> Diagnostic:
    """*variable* would have to be *type_*, of which it is a part."""
    return Diagnostic(
        "CSP302",
        f"this needs an infinite type: `{variable}` would be `{type_}`",
        span,
        annotation=f"in {role}" if role else "",
        labels=tuple(labels),
    )


@mistake(
    "CSP303",
    "a type does not have what its use needs",
    explanation=(
        "Some uses need more than a type: `==`, `member` and `card` need values with equality (Eq), `<` needs an "
        "order (Ord), the elements of sets must be values or processes (Set), what a channel carries must be a "
        "complete value (Complete), and `{| |}`, `productions` and `extensions` make events or datatype values "
        "(Yieldable). Processes and functions have no equality; Booleans, events and datatypes have no order."
    ),
    example="channel a\nsame = (a -> STOP) == STOP",
    repair="channel a\nsame = <a> == <>",
)
def lacks_constraint(
    span: Span,
    type_: str,
    what: str,
    role: str,
    reasons: Sequence[str] = (),
    labels: Sequence[Label] = (),
    help_line: str | None = None,
) -> Diagnostic:
    """*what* says what the type lacks ("has no equality (Eq)"); *reasons* name the parts that are to blame."""
    return Diagnostic(
        "CSP303",
        f"`{type_}` {what}",
        span,
        annotation=f"needed for {role}" if role else "",
        labels=tuple(labels),
        notes=tuple(reasons),
        help=help_line,
    )


@mistake(
    "CSP304",
    "a function is called with the wrong number of arguments",
    explanation=(
        "A function takes all arguments of one list at once. `f(x, y)` and `f(x)(y)` are different: the second is a "
        "function that gives a function."
    ),
    example="f(x, y) = x + y\nn = f(1)",
    repair="f(x, y) = x + y\nn = f(1, 2)",
)
def argument_count(
    name: str, span: Span, type_: str, expected: int, given: int, labels: Sequence[Label] = ()
) -> Diagnostic:
    """A call of *name*, of *type_*, with another number of arguments than it has parameters."""
    return Diagnostic(
        "CSP304",
        f"`{name}` takes {_plural(expected, 'argument')}, {given} given",
        span,
        labels=tuple(labels),
        notes=(f"`{name}` has type `{type_}`",),
    )


@mistake(
    "CSP305",
    "something that is no function is applied to arguments",
    explanation="Only functions take arguments in brackets. Channels and constructors take their fields behind dots.",
    example="channel c : {0..3}\nP = c(1) -> STOP",
    repair="channel c : {0..3}\nP = c.1 -> STOP",
)
def not_a_function(name: str, span: Span, type_: str, help_line: str | None) -> Diagnostic:
    """A call of *name*, whose type is not a function's."""
    return Diagnostic("CSP305", f"`{name}` is not a function", span, annotation=f"type `{type_}`", help=help_line)


@mistake(
    "CSP306",
    "a channel or constructor gets more fields than it has",
    explanation=(
        "A channel or constructor takes as many fields as it was declared with. A datatype value counts as one field, "
        "with everything that belongs to it."
    ),
    example="channel c : {0..3}\nP = c.1.2 -> STOP",
    repair="channel c : {0..3}.{0..3}\nP = c.1.2 -> STOP",
)
def surplus_fields(
    span: Span, name: str | None, fields: Sequence[str], given: int, labels: Sequence[Label] = ()
) -> Diagnostic:
    """*fields* are the types of the declared fields of *name* (None: not a plain name), *given* counts those here."""
    takes = _plural(len(fields), "field") if fields else "no fields"
    return Diagnostic(
        "CSP306",
        f"`{name}` takes {takes}, {given} given" if name else f"this takes {takes}, {given} given",
        span,
        labels=tuple(labels),
        notes=(f"the fields are `{'.'.join(fields)}`",) if fields else (),
    )


@mistake(
    "CSP307",
    "fields are missing",
    explanation=(
        "A channel with fields becomes an event, and a constructor with fields a value, only with all of them. To mean "
        "every event of a channel in a set, write `{| c |}`; to take any value, write `c?x`."
    ),
    example="channel c : {0..3}\nP = c -> STOP",
    repair="channel c : {0..3}\nP = c?x -> STOP",
)
def missing_fields(
    span: Span, expected: str, missing: Sequence[str], role: str, labels: Sequence[Label], help_line: str
) -> Diagnostic:
    """An expression that still needs fields of the types *missing* to become an *expected*."""
    fields = _plural(len(missing), "field")
    return Diagnostic(
        "CSP307",
        f"{fields} missing: this needs `.{'.'.join(missing)}` to become `{expected}`",
        span,
        annotation=f"in {role}" if role else "",
        labels=tuple(labels),
        help=help_line,
    )


@mistake(
    "CSP308",
    "the type of a field cannot be told",
    explanation=(
        "The fields of channels and constructors need definite types, for the events and values must be known. A "
        "field that is declared with an empty set, say, could be anything."
    ),
    example="channel c : {}",
    repair="c :: Int => Event\nchannel c : {}",
)
def ambiguous_field(name: str, kind: str, span: Span, type_: str, field: int, count: int, result: str) -> Diagnostic:
    """Field *field* (from 1) of *count* of the channel or constructor (*kind*) *name* has an open type.

    *result* is what it makes: ``Event`` or the datatype.
    """
    which = "its field" if count == 1 else f"field {field}"
    return Diagnostic(
        "CSP308",
        f"the type of {kind} `{name}` is ambiguous: {which} could be of any type",
        span,
        annotation=f"type `{type_}`",
        help=f"constrain {which} with an annotation, such as `{name} :: {' => '.join(_example(field, count))} => "
        f"{result}`",
    )


def _example(field: int, count: int) -> list[str]:
    return ["Int" if i == field else "..." for i in range(1, count + 1)]


@mistake(
    "CSP309",
    "a subtype gives a constructor more fields than it has",
    explanation="A subtype restricts the fields of the constructors of a datatype; it cannot add any.",
    example="datatype T = A.{0..3}\nsubtype S = A.{0}.{1}",
    repair="datatype T = A.{0..3}\nsubtype S = A.{0}",
)
def subtype_fields(name: str, span: Span, declared: int, given: int, labels: Sequence[Label]) -> Diagnostic:
    """The constructor *name* in a subtype has *given* fields, in its datatype *declared*."""
    return Diagnostic(
        "CSP309",
        f"`{name}` has {_plural(declared, 'field')}, the subtype gives it {given}",
        span,
        labels=tuple(labels),
    )


@mistake(
    "CSP310",
    "a subtype mixes the constructors of several datatypes",
    explanation="Every value of a subtype is a value of one datatype.",
    example="datatype T = A\ndatatype U = B\nsubtype S = A | B",
    repair="datatype T = A | C\nsubtype S = A",
)
def subtype_mixes(name: str, span: Span, datatype: str, other: str, labels: Sequence[Label]) -> Diagnostic:
    """The constructor *name* belongs to *other*, those before it to *datatype*."""
    return Diagnostic(
        "CSP310",
        f"`{name}` is a constructor of `{other}`, the subtype is one of `{datatype}`",
        span,
        labels=tuple(labels),
    )


@mistake(
    "CSP311",
    "an annotation promises more than the definition holds",
    explanation=(
        "A variable in an annotation stands for every type: `f :: (a) -> a` says that `f` takes anything. A definition "
        "that works for some types only needs an annotation that says so."
    ),
    example="f :: (a) -> a\nf(x) = x + 1",
    repair="f :: (Int) -> Int\nf(x) = x + 1",
)
def too_general(
    span: Span, variable: str, needed: str, role: str, labels: Sequence[Label] = (), help_line: str | None = None
) -> Diagnostic:
    """*variable* of an annotation would have to be *needed*."""
    return Diagnostic(
        "CSP311",
        f"the annotation allows any type for `{variable}`, but here it must be `{needed}`",
        span,
        annotation=f"in {role}" if role else "",
        labels=tuple(labels),
        help=help_line or f"write `{needed}` in place of `{variable}` in the annotation",
    )


@mistake(
    "CSP312",
    "a dot pattern is matched against a single value",
    explanation=(
        "A pattern `x.y` whose first part is a variable takes plain dotted values apart. An event or a datatype value "
        "is one value: its channel or constructor must be named, as in `c.y`."
    ),
    example="channel c : {0..3}\nsecond(x.y) = y\nn = second(c.1)",
    repair="channel c : {0..3}\nsecond(c.y) = y\nn = second(c.1)",
)
def splits_value(
    span: Span, pattern: str, type_: str, role: str, labels: Sequence[Label] = (), help_line: str | None = None
) -> Diagnostic:
    """A pattern or parameter of the dotted type *pattern* against a value of *type_*."""
    return Diagnostic(
        "CSP312",
        f"a value of type `{type_}` cannot be split by a pattern of type `{pattern}`",
        span,
        annotation=f"{role} has type `{type_}`" if role else "",
        labels=tuple(labels),
        help=help_line or "name the channel or constructor in the pattern, as in `c.x`",
    )


@mistake(
    "CSP313",
    "a comprehension ranges over the wrong kind of collection",
    explanation=(
        "The generators of `{... | x <- s}` and of most replicated operators range over sets, those of "
        "`<... | x <- s>` and of the replicated `;` and linked parallel over sequences."
    ),
    example="squares(s) = {x * x | x <- s}\nt = squares(<1, 2>)\nu = {x | x <- <1, 2>}",
    repair="u = {x | x <- set(<1, 2>)}",
)
def wrong_collection(span: Span, wanted: str, found: str, type_: str, place: str) -> Diagnostic:
    """A generator over a *found* ("sequence") in a *place* whose generators range over *wanted* ("set")."""
    conversion = "set" if wanted == "set" else "seq"
    return Diagnostic(
        "CSP313",
        f"{place} ranges over {wanted}s, this is a {found}",
        span,
        annotation=f"type `{type_}`",
        help=f"convert it with `{conversion}(...)`",
    )


@mistake(
    "CSP314",
    "a module depends on an instance of itself",
    explanation=(
        "An instance exists once its module is complete, so nothing in the module, nor anything that it uses, can use "
        "what the instance declares."
    ),
    example="module M(n)\nexports\nx = I::x + n\nendmodule\ninstance I = M(1)",
    repair="module M(n)\nexports\nx = n + 1\nendmodule\ninstance I = M(1)",
)
def instance_cycle(module: str, instance: str, span: Span, path: Sequence[str], labels: Sequence[Label]) -> Diagnostic:
    """*path* are the names by which *module* comes to use *instance*."""
    return Diagnostic(
        "CSP314",
        f"module `{module}` uses its own instance `{instance}`",
        span,
        labels=tuple(labels),
        notes=(f"the path is {' -> '.join(path)}",),
    )


@mistake(
    "CSP315",
    "an annotation that is not a type",
    explanation=(
        "A constraint speaks of a variable of the type behind it; left of `=>*` stands a "
        "variable; a name with `::` must be that of a datatype."
    ),
    example="f :: Eq b => (a) -> Bool\nf(x) = true",
    repair="f :: Eq a => (a) -> Bool\nf(x) = true",
)
def bad_annotation(span: Span, message: str, help_line: str | None = None) -> Diagnostic:
    """*message* says what is wrong."""
    return Diagnostic("CSP315", message, span, help=help_line)


@mistake(
    "CSP316",
    "an annotation is weaker than its definition needs",
    explanation=(
        "Inside an annotated definition a variable has only what the annotation says: `f :: (a, a) -> Bool` cannot "
        "compare its arguments, since not every type has equality."
    ),
    example="same :: (a, a) -> Bool\nsame(x, y) = x == y",
    repair="same :: Eq a => (a, a) -> Bool\nsame(x, y) = x == y",
)
def unconstrained_variable(
    span: Span, variable: str, constraint: str, role: str, labels: Sequence[Label] = ()
) -> Diagnostic:
    """The variable of an annotation lacks *constraint*."""
    return Diagnostic(
        "CSP316",
        f"the annotation does not give `{variable}` the constraint `{constraint}`",
        span,
        annotation=f"needed for {role}" if role else "",
        labels=tuple(labels),
        help=f"put `{constraint} {variable} =>` in front of the annotated type",
    )


@mistake(
    "CSP317",
    "a deprecated name",
    explanation="`True` and `False` are names that a script can redefine; the literals are `true` and `false`.",
    example="b = True",
    repair="b = true",
)
def deprecated_name(name: str, replacement: str, span: Span) -> Diagnostic:
    """A warning: *name* still works."""
    return Diagnostic(
        "CSP317",
        f"`{name}` is deprecated",
        span,
        severity=Severity.WARNING,
        help=f"write `{replacement}`",
    )


@mistake(
    "CSP318",
    "a field has the wrong type",
    explanation="Each field of a channel or constructor has the type that its declaration gives it.",
    example="channel c : {0..3}.Bool\nP = c.1.2 -> STOP",
    repair="channel c : {0..3}.Bool\nP = c.1.true -> STOP",
)
def field_type(
    span: Span, name: str | None, number: int, expected: str, actual: str, labels: Sequence[Label] = ()
) -> Diagnostic:
    """Field *number* (from 1) of the channel or constructor *name* (None: not a plain name) is an *actual*."""
    field = f"field {number} of `{name}`" if name else "this field"
    return Diagnostic(
        "CSP318",
        f"{field} has type `{expected}`, found `{actual}`",
        span,
        annotation=f"this has type `{actual}`",
        labels=tuple(labels),
    )


@mistake(
    "CSP319",
    "a type is too large",
    explanation=(
        "A definition that contains the one before it twice, in a tuple say, has a type twice as large; after a few "
        "dozen such definitions no computer could write the type down."
    ),
    example="\n".join(f"f{i}(x) = (f{i + 1}(x), f{i + 1}(x))" for i in range(22)) + "\nf22(x) = x",
    repair="f(x) = <x | i <- <1..100>>",
)
def type_too_large(span: Span, name: str | None = None) -> Diagnostic:
    """The type of *name*, or of what stands at *span*, has too many parts to be dealt with."""
    whose = f"the type of `{name}`" if name else "the type of this"
    return Diagnostic("CSP319", f"{whose} is too large", span, help="use sequences or datatypes in place of tuples")


@mistake(
    "CSP320",
    "an annotation leaves fields open that the definition fixes",
    explanation=(
        "`a =>* Event` is an event or something that wants any fields to become one. A definition that needs an event, "
        "or certain fields, must say so in its annotation."
    ),
    example="start :: (a =>* Event) -> Proc\nstart(x) = x -> STOP",
    repair="start :: (Event) -> Proc\nstart(x) = x -> STOP",
)
def too_definite_fields(span: Span, variable: str, fields: str, role: str, labels: Sequence[Label] = ()) -> Diagnostic:
    """The open fields *variable* of an annotation would have to be *fields* (empty: none at all)."""
    needed = f"these must be `{fields}`" if fields else "there must be none"
    return Diagnostic(
        "CSP320",
        f"the annotation allows any fields for `{variable}`, but here {needed}",
        span,
        annotation=f"in {role}" if role else "",
        labels=tuple(labels),
        help="write the fields with `=>`, or leave them out",
    )
