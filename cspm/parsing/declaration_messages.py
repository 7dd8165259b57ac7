"""What can be wrong with patterns (codes from 140), declarations (160) and written types (180)."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, mistake
from cspcheck.cspm.parsing.lexing_messages import quoted
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as s

# --- patterns ------------------------------------------------------------------------------------------------


@mistake(
    "CSP140",
    "not a pattern",
    explanation="Left of `=`, `<-`, in parameters and behind `?` stand patterns: names, `_`, literals, tuples, "
    "sequences, `p^q`, `{}`, `{p}`, "
    "`p.q` and `p @@ q`. Nothing is computed in a pattern.",
    example="f(x + 1) = x",
    repair="f(x) = x - 1",
)
def invalid_pattern(span: Span, node: s.Expr) -> Diagnostic:
    """The expression *node* where a pattern is due."""
    return Diagnostic(
        "CSP140",
        f"{described(node)} is not a pattern",
        span,
        help="a pattern is a name, `_`, a literal, or a tuple, sequence, set or dotted value of patterns",
    )


@mistake(
    "CSP141",
    "`_` outside a pattern",
    explanation="`_` matches anything and names nothing, so it has no value.",
    example="x = _ + 1",
    repair="f(_) = 1",
)
def wildcard_outside_pattern(span: Span) -> Diagnostic:
    """`_` where a value is due."""
    return Diagnostic("CSP141", "`_` has no value", span, help="`_` stands in patterns only; use a name")


@mistake(
    "CSP142",
    "`@@` outside a pattern",
    explanation="`p @@ q` matches what both patterns match; it computes nothing.",
    example="x = 1 @@ 2",
    repair="f(x @@ (a, b)) = x",
)
def both_outside_pattern(span: Span) -> Diagnostic:
    """`@@` where a value is due."""
    return Diagnostic("CSP142", "`@@` stands in patterns only", span, help="`@` ends the generators of an operator")


@mistake(
    "CSP143",
    "a set pattern with several elements",
    explanation="The elements of a set have no order, so a pattern can only match the empty set and sets of one "
    "element.",
    example="f({x, y}) = x",
    repair="f({x}) = x",
)
def set_pattern(span: Span) -> Diagnostic:
    """A set pattern with more than one element."""
    return Diagnostic("CSP143", "a set pattern has at most one element", span, help="match `{}` or `{x}`")


@mistake(
    "CSP144",
    "a sequence pattern with two open ends",
    explanation="In a pattern `p ^ q` at most one part can match sequences of any length; the others are written out "
    "as `<x, y>`.",
    example="f(xs ^ ys) = xs",
    repair="f(<x> ^ ys) = x",
)
def sequence_pattern(span: Span) -> Diagnostic:
    """A concatenation with more than one part of unknown length."""
    return Diagnostic(
        "CSP144", "more than one part of this pattern can have any length", span, help="write `<x>^xs` or `xs^<x>`"
    )


@mistake(
    "CSP145",
    "not a function that can be defined",
    explanation="A function is defined by its name and its parameters: `f(x, y) = ...`, or `f(x)(y) = ...` in two "
    "steps.",
    example="(f)(x) = x",
    repair="f(x) = x",
)
def invalid_function_head(span: Span) -> Diagnostic:
    """Something else than a name before the parameters of a definition."""
    return Diagnostic("CSP145", f"`{span.text}` cannot be defined", span, help="a function is defined by its name")


# --- declarations --------------------------------------------------------------------------------------------


@mistake(
    "CSP160",
    "a declaration in the wrong place",
    explanation="In `let` stand only definitions, `external`, `transparent`, annotations and `Timed` sections of "
    "these. Assertions stand at the top "
    "or directly in a `Timed` section that does; `print` only at the top.",
    example="f(x) = let channel c within c -> STOP",
    repair="channel c\nf(x) = c -> STOP",
)
def misplaced_declaration(span: Span, keyword: str, place: str) -> Diagnostic:
    """A declaration that begins with *keyword* in a `let`, a module or a `Timed` section."""
    where = {"let": "a `let`", "module": "a module", "Timed": "a `Timed` section"}[place]
    return Diagnostic("CSP160", f"`{keyword}` cannot stand in {where}", span, help="move it to the top of the script")


@mistake(
    "CSP161",
    "a definition goes over the border of a file",
    explanation="The clauses of a function stand in one file.",
    example='f(0) = 1\ninclude "rest_of_f.csp"',
    repair="f(0) = 1\nf(n) = n * f(n - 1)",
)
def definition_over_files(span: Span, name: str, first: Span) -> Diagnostic:
    """Clauses of one function before and behind the border of an included file."""
    return Diagnostic(
        "CSP161",
        f"`{name}` is defined in two files",
        span,
        labels=(Label(first, "defined here, in the other file"),),
        help="put all clauses of a function in one file",
    )


@mistake(
    "CSP162",
    "an annotation without a definition",
    explanation="`x :: T` says the type of something that is defined in the same list of declarations.",
    example="f :: (Int) -> Int\ng(x) = x",
    repair="f :: (Int) -> Int\nf(x) = x",
)
def annotation_without_definition(span: Span, name: str) -> Diagnostic:
    """A type annotation for a name that is not defined beside it."""
    return Diagnostic(
        "CSP162", f"`{name}` has a type but no definition here", span, help="an annotation stands beside the definition"
    )


@mistake(
    "CSP163",
    "two annotations for one name",
    explanation="A name has one type.",
    example="f :: (Int) -> Int\nf :: (Bool) -> Bool\nf(x) = x",
    repair="f :: (Int) -> Int\nf(x) = x",
)
def annotated_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """A second type annotation for a name."""
    return Diagnostic("CSP163", f"`{name}` is annotated twice", span, labels=(Label(first, "first annotated here"),))


@mistake(
    "CSP164",
    "two annotations for one channel declaration",
    explanation="The channels of one declaration have one type, and so one annotation: `a, b :: T`.",
    example="a :: Int => Event\nb :: Int => Event\nchannel a, b : {0..1}",
    repair="a, b :: Int => Event\nchannel a, b : {0..1}",
)
def channels_annotated_apart(span: Span, first: Span, declaration: Span) -> Diagnostic:
    """Two annotations for channels that are declared together."""
    return Diagnostic(
        "CSP164",
        f"`{span.text}` and `{first.text}` are declared together but annotated apart",
        span,
        labels=(Label(first, "first annotated here"), Label(declaration, "declared here")),
        help=f"write `{first.text}, {span.text} :: T`",
    )


# --- types ---------------------------------------------------------------------------------------------------


@mistake(
    "CSP180",
    "a function type without an argument list",
    explanation="The arguments of a function type stand in brackets, even a single one.",
    example="f :: Int -> Int\nf(x) = x",
    repair="f :: (Int) -> Int\nf(x) = x",
)
def function_type_without_list(span: Span) -> Diagnostic:
    """Something else than a list in brackets before `->` in a type."""
    return Diagnostic(
        "CSP180",
        "the arguments of a function type stand in brackets",
        span,
        help=f"write `({span.text}) -> ...`",
    )


@mistake(
    "CSP181",
    "an unknown type constraint",
    explanation="The constraints are `Eq` (can be compared), `Ord` (can be ordered), `Set` (can be in sets), "
    "`Complete` (can be communicated) and "
    "`Yieldable` (events and datatypes).",
    example="f :: Equal a => (a) -> Bool\nf(x) = x == x",
    repair="f :: Eq a => (a) -> Bool\nf(x) = x == x",
)
def unknown_constraint(span: Span, known: Sequence[str]) -> Diagnostic:
    """A constraint that is none of the *known* ones."""
    close = suggestions(span.text, known)
    return Diagnostic(
        "CSP181",
        f"unknown type constraint `{span.text}`",
        span,
        help=f"did you mean `{close[0]}`?" if close else f"the constraints are {quoted(known, 'and')}",
    )


@mistake(
    "CSP182",
    "an empty tuple type",
    explanation="`()` is only an argument list: `() -> Int` is the type of a function without arguments.",
    example="x :: ()\nx = 1",
    repair="x :: Int\nx = 1",
)
def empty_type(span: Span) -> Diagnostic:
    """`()` that is no argument list."""
    return Diagnostic("CSP182", "`()` is no type", span, help="a function without arguments has type `() -> T`")


def described(node: s.Expr) -> str:
    """What an expression is, in words: `a sum`, `the conditional`."""
    match node:
        case s.Binary(operator=operator) | s.Unary(operator=operator) | s.ProcessBinary(operator=operator):
            return f"an expression with `{operator}`"
        case s.Apply():
            return "a function call"
        case s.If():
            return "an `if`"
        case s.Let():
            return "a `let`"
        case s.Lambda():
            return "a lambda"
        case s.SetExpr() | s.SequenceExpr():
            return "a comprehension"
        case s.SetRange() | s.SequenceRange():
            return "a range"
        case s.Productions():
            return "`{| ... |}`"
        case s.MapExpr():
            return "a map"
        case s.Rename():
            return "a renaming"
        case _:
            return "a process"


def concerns_whole_script(error: Diagnostic) -> bool:
    """Whether the mistake is one that a part of a script only seems to make."""
    return error.code in ("CSP161", "CSP162", "CSP163", "CSP164")
