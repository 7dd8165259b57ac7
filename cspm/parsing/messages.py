"""What can be wrong with the form of a script.

Codes 101-119 are about expressions and brackets, 120-122 (in :mod:`cspcheck.cspm.parsing.lexing_messages`) about the
words of an assertion, 123-139 about words and signs that are missing or wrong, 140-199 (in
:mod:`cspcheck.cspm.parsing.declaration_messages`, from where they are handed on) about patterns, declarations and
types.
"""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, mistake
from cspcheck.cspm.parsing.declaration_messages import (
    annotated_twice,
    annotation_without_definition,
    both_outside_pattern,
    channels_annotated_apart,
    concerns_whole_script,
    definition_over_files,
    described,
    empty_type,
    function_type_without_list,
    invalid_function_head,
    invalid_pattern,
    misplaced_declaration,
    sequence_pattern,
    set_pattern,
    unknown_constraint,
    wildcard_outside_pattern,
)
from cspcheck.cspm.parsing.lexing_messages import listed
from cspcheck.cspm.source import Span

# --- what follows what ---------------------------------------------------------------------------------------


@mistake(
    "CSP101",
    "something else was expected here",
    explanation="The text up to here begins something that this word or sign cannot continue.",
    example="P = STOP [] * STOP",
    repair="P = STOP [] STOP",
)
def unexpected(
    span: Span, found: str, wanted: Sequence[str], *, labels: tuple[Label, ...] = (), help: str | None = None
) -> Diagnostic:
    """The words *found* stand where one of *wanted* was due."""
    return Diagnostic(
        "CSP101",
        f"unexpected {found}",
        span,
        annotation=f"expected {listed(wanted)}" if wanted else "",
        labels=labels,
        help=help,
    )


@mistake(
    "CSP102",
    "a bracket is not closed",
    explanation="Each bracket needs its counterpart: `(`...`)`, `{`...`}`, `{|`...`|}`, `<`...`>`, `[|`...`|]`, "
    "`[[`...`]]`, `(| `...`|)`.",
    example="P = (a -> STOP\nQ = STOP",
    repair="P = (a -> STOP)\nQ = STOP",
)
def unclosed_bracket(span: Span, opener: str, closer: str, found: Span, found_words: str) -> Diagnostic:
    """The bracket at *span* is still open where *found* shows that it should be closed."""
    return Diagnostic(
        "CSP102",
        f"this `{opener}` is never closed",
        span,
        labels=(Label(found, f"expected `{closer}` before {found_words}"),),
        help=f"close it with `{closer}`",
    )


@mistake(
    "CSP103",
    "a bracket is closed that is not open",
    explanation="A closing bracket has no opening bracket before it in the same declaration.",
    example="P = a -> STOP)",
    repair="P = (a -> STOP)",
)
def unopened_bracket(span: Span) -> Diagnostic:
    """A closing bracket where nothing is open."""
    return Diagnostic("CSP103", f"`{span.text}` closes no bracket", span, help="remove it, or open the bracket before")


@mistake(
    "CSP104",
    "a bracket is closed by another kind of bracket",
    explanation="The innermost open bracket must be closed first, and by its own counterpart.",
    example="S = {(1, 2}",
    repair="S = {(1, 2)}",
)
def wrong_closing_bracket(span: Span, opener: Span, wanted: str) -> Diagnostic:
    """A closing bracket that is not the one of the innermost open bracket."""
    return Diagnostic(
        "CSP104",
        f"`{span.text}` does not close `{opener.text}`",
        span,
        annotation=f"expected `{wanted}`",
        labels=(Label(opener, "the innermost open bracket"),),
        help=f"close it with `{wanted}` first",
    )


@mistake(
    "CSP105",
    "operators that need brackets between them",
    explanation="The parallel operators `[| |]`, `[ || ]`, `[| |>` and `[ <-> ]` do not associate: `P [|A|] Q [|B|] "
    "R` can be read in two "
    "ways that mean different things. The same holds for `@@`.",
    example="P = STOP [| {} |] STOP [| {} |] STOP",
    repair="P = (STOP [| {} |] STOP) [| {} |] STOP",
)
def chained_operator(span: Span, before: Span, first: str, second: str, *, in_front: bool = False) -> Diagnostic:
    """Two operators of the same strength that do not associate, side by side; the first may stand *in front* only."""
    left = first if in_front else f"P {first}"
    return Diagnostic(
        "CSP105",
        f"`{second}` beside `{first}` needs brackets",
        span,
        labels=(Label(before, "the operator before it"),),
        help=f"write `({left} Q) {second} R` or `{left} (Q {second} R)`",
    )


@mistake(
    "CSP106",
    "comparisons in a row",
    explanation="A comparison gives a Boolean, so that `a < b < c` would compare a Boolean with a number.",
    example="f(a, b, c) = a < b < c",
    repair="f(a, b, c) = a < b and b < c",
)
def chained_comparison(span: Span, before: Span) -> Diagnostic:
    """Two comparisons side by side."""
    return Diagnostic(
        "CSP106",
        f"`{span.text}` cannot follow a comparison",
        span,
        labels=(Label(before, "the comparison before it"),),
        help=f"join two comparisons with `and`: `a {before.text} b and b {span.text} c`",
    )


@mistake(
    "CSP107",
    "`=` where `==` is meant",
    explanation="`=` defines, `==` compares. Inside an expression only `==` makes sense.",
    example="f(x) = if x = 0 then 1 else 2",
    repair="f(x) = if x == 0 then 1 else 2",
)
def definition_sign_in_expression(span: Span) -> Diagnostic:
    """A `=` inside an expression."""
    return Diagnostic("CSP107", "`=` does not compare", span, help="write `==` to compare; `=` only defines")


@mistake(
    "CSP108",
    "`==` where `=` is meant",
    explanation="A declaration is written with `=`; `==` compares two values.",
    example="P == STOP",
    repair="P = STOP",
)
def comparison_for_definition(span: Span) -> Diagnostic:
    """A whole declaration that is only a comparison."""
    return Diagnostic("CSP108", "`==` does not define", span, help="write `=` to define; `==` only compares")


@mistake(
    "CSP109",
    "a comparison behind a closed sequence",
    explanation="Inside `<...>` the first `>` closes the sequence. A comparison with `>` inside a sequence needs "
    "brackets.",
    example="s = <x | x <- <1, 2, 3>, x>2>",
    repair="s = <x | x <- <1, 2, 3>, (x>2)>",
)
def greater_closes_sequence(span: Span, found: str, closing: Span, opening: Span) -> Diagnostic:
    """Something stands behind the `>` that closed a sequence as if it was meant to compare."""
    return Diagnostic(
        "CSP109",
        f"unexpected {found} behind the end of a sequence",
        span,
        labels=(Label(closing, "this `>` closes the sequence"), Label(opening, "which is opened here")),
        help="put a comparison with `>` inside a sequence in brackets: `(x > y)`",
    )


@mistake(
    "CSP110",
    "no process behind `->`",
    explanation="A prefix is an event, `->`, and the process that follows. A process that does nothing more is "
    "`STOP`; one that ends "
    "successfully is `SKIP`.",
    example="channel a\nP = a ->",
    repair="channel a\nP = a -> STOP",
)
def missing_process(span: Span, arrow: Span) -> Diagnostic:
    """`->` with nothing behind it; *span* is what stands there instead."""
    return Diagnostic(
        "CSP110",
        "no process behind `->`",
        arrow,
        labels=(Label(span, "here"),) if span.start != span.end else (),
        help="every prefix needs a process: `a -> STOP`",
    )


@mistake(
    "CSP111",
    "a reserved word used as a name",
    explanation="The words `and or not if then else let within channel assert datatype subtype nametype external "
    "transparent module exports "
    "endmodule instance Timed include print true false` belong to the language.",
    example="channel = 1",
    repair="channel1 = 1",
)
def reserved_word(span: Span) -> Diagnostic:
    """A keyword where a name is due."""
    return Diagnostic("CSP111", f"`{span.text}` is a reserved word", span, help="choose another name")


@mistake(
    "CSP112",
    "a line begins with what could begin a declaration",
    explanation="A line break ends a declaration unless it stands in brackets, behind an operator, or before an "
    "operator that "
    "cannot begin a declaration. `-`, `<`, `(`, `{` and `#` can begin one.",
    example="x = 3\n  - 1",
    repair="x = 3 -\n  1",
)
def line_begins_declaration(span: Span, end: Span) -> Diagnostic:
    """An expression that goes on in the next line with a sign that begins a declaration; *end* is where it ended."""
    return Diagnostic(
        "CSP112",
        f"`{span.text}` at the beginning of a line begins a new declaration",
        span,
        labels=(Label(end, "the declaration ends here"),),
        help="leave the operator at the end of the line above, or put the expression in brackets",
    )


@mistake(
    "CSP113",
    "an indented line that continues nothing",
    explanation="The line before it is complete, so this line begins a new declaration; its indentation suggests that "
    "an operator is "
    "missing between the two.",
    example="channel a, b\nP = a -> STOP\n    b -> STOP",
    repair="channel a, b\nP = a -> STOP\n    [] b -> STOP",
)
def line_continues_nothing(span: Span, end: Span) -> Diagnostic:
    """An expression on a line of its own, indented, with no operator between it and the line above."""
    return Diagnostic(
        "CSP113",
        "this line is neither a declaration nor the rest of one",
        span,
        labels=(Label(end, "the declaration above ends here"),),
        help="join it to the line above with an operator, such as `[]`, or define something with `=`",
    )


@mistake(
    "CSP114",
    "an operator without an operand before it",
    explanation="Where an operand is due, `[]`, `|~|`, `|||` and `;` begin a replicated operator, with generators and "
    "`@`. Between two "
    "processes they need a process on both sides.",
    example="P = [] STOP",
    repair="P = STOP [] STOP",
)
def operator_without_operand(span: Span) -> Diagnostic:
    """An operator between processes where an operand is due, with no generators behind it."""
    return Diagnostic(
        "CSP114",
        f"`{span.text}` has no operand before it",
        span,
        help=f"write `P {span.text} Q`, or `{span.text} x : S @ P(x)` for the replicated operator",
    )


@mistake(
    "CSP115",
    "an annotation without a blank beside `::`",
    explanation="`M::x` without blanks is one name, the `x` of the module `M`. The `::` of an annotation needs a blank "
    "on one side at least.",
    example="x::Int\nx = 1",
    repair="x :: Int\nx = 1",
)
def annotation_without_blank(span: Span) -> Diagnostic:
    """A qualified name that stands alone as a declaration."""
    name, _, rest = span.text.partition("::")
    return Diagnostic("CSP115", f"`{span.text}` is one name", span, help=f"to give a type write `{name} :: {rest}`")


# --- what is missing -----------------------------------------------------------------------------------------


@mistake(
    "CSP123",
    "`let` without `within`",
    explanation="`let` introduces declarations for the expression behind `within`.",
    example="f(x) = let y = x + 1\nz = 2",
    repair="f(x) = let y = x + 1 within y * y",
)
def missing_within(let: Span, span: Span, found: str) -> Diagnostic:
    """The declarations of the `let` end at *span* without `within`."""
    return Diagnostic(
        "CSP123",
        "this `let` has no `within`",
        let,
        labels=(Label(span, f"expected `within` before {found}"),),
        help="write `let declarations within expression`",
    )


@mistake(
    "CSP124",
    "`if` without `then` or `else`",
    explanation="`if` always has both branches; a process that is only offered under a condition is a guard, `b & P`.",
    example="f(x) = if x == 0 then 1",
    repair="f(x) = if x == 0 then 1 else 2",
)
def missing_branch(span: Span, word: str, opening: Span, found: str) -> Diagnostic:
    """An `if` that ends without the *word* `then` or `else`."""
    return Diagnostic(
        "CSP124",
        f"expected `{word}` before {found}",
        span,
        labels=(Label(opening, f"this `{opening.text}` has no `{word}`"),),
        help="`if` needs both branches: `if b then P else Q`; a guard is `b & P`",
    )


@mistake(
    "CSP125",
    "a replicated operator or lambda without `@`",
    explanation="The generators of a replicated operator, and the parameters of a lambda, end with `@`.",
    example="channel a : {0..3}\nP = [] x : {0..3} a.x -> STOP",
    repair="channel a : {0..3}\nP = [] x : {0..3} @ a.x -> STOP",
)
def missing_at(span: Span, opening: Span, found: str, what: str) -> Diagnostic:
    """The generators or parameters of *what* (`[]`, the lambda) do not end with `@`."""
    return Diagnostic(
        "CSP125",
        f"expected `@` before {found}",
        span,
        labels=(Label(opening, f"{what} begins here"),),
        help="write `[] x : S @ P(x)`" if what != "the lambda" else "write `\\ x @ expression`",
    )


@mistake(
    "CSP126",
    "the text ends too early",
    explanation="The script ends in the middle of a declaration.",
    example="P =",
    repair="P = STOP",
)
def unexpected_end(
    span: Span, wanted: Sequence[str], before: Span | None, labels: tuple[Label, ...] = ()
) -> Diagnostic:
    """The end of the text where one of *wanted* was due, behind *before*."""
    behind = f" behind `{before.text}`" if before is not None else ""
    return Diagnostic(
        "CSP126",
        f"the text ends{behind} where {listed(wanted)} was expected",
        before or span,
        labels=labels,
    )


@mistake(
    "CSP127",
    "a declaration ends too early",
    explanation="A line break ended the declaration before it was complete, or a declaration begins where an "
    "expression is due.",
    example="channel c :\nP = STOP",
    repair="channel c : {0..1}\nP = STOP",
)
def declaration_cut_short(span: Span, found: str, wanted: Sequence[str], last: Span) -> Diagnostic:
    """A new declaration begins (with *found*) behind *last*, where one of *wanted* was due."""
    return Diagnostic(
        "CSP127",
        f"the declaration before {found} is not complete",
        span,
        annotation=f"expected {listed(wanted)}",
        labels=(Label(last, "nothing follows this"),),
    )


@mistake(
    "CSP128",
    "an expression stands alone",
    explanation="A script is a list of declarations; an expression alone declares nothing.",
    example="1 + 1",
    repair="print 1 + 1",
)
def expression_alone(span: Span, found: str) -> Diagnostic:
    """An expression where a declaration is due; *span* is where its `=` is missing."""
    return Diagnostic(
        "CSP128",
        f"expected `=` before {found}",
        span,
        help="a declaration is `name = expression`; to show a value write `print expression`, to claim something "
        "`assert`",
    )


@mistake(
    "CSP129",
    "a map opener without a blank",
    explanation="A map is opened by `(|` and a blank, because `(|` also begins a bracketed `|~|` or `|||`.",
    example="m = (|0 => 1|)",
    repair="m = (| 0 => 1 |)",
)
def map_without_blank(span: Span) -> Diagnostic:
    """`(|` with something else than a blank behind it."""
    return Diagnostic("CSP129", "a map is opened by `(|` and a blank", span, help="write `(| key => value |)`")


@mistake(
    "CSP130",
    "an empty pair of brackets",
    explanation="`()` is no value. A function without arguments is called as `f()`, the empty sequence is `<>`, the "
    "empty set `{}`.",
    example="x = ()",
    repair="x = <>",
)
def empty_brackets(span: Span) -> Diagnostic:
    """`()` as a value."""
    return Diagnostic("CSP130", "`()` is no value", span, help="the empty sequence is `<>`, the empty set `{}`")


@mistake(
    "CSP131",
    "a number with too many digits",
    explanation="Numbers of several thousand digits are refused; no model has a use for them.",
    example="A number with 5000 digits.",
    repair="A smaller number.",
)
def number_too_long(span: Span, limit: int) -> Diagnostic:
    """An integer of more than *limit* digits."""
    return Diagnostic("CSP131", f"this number has more than {limit} digits", span)


@mistake(
    "CSP132",
    "an empty `let`",
    explanation="`let` introduces at least one declaration.",
    example="x = let within 1",
    repair="x = let y = 1 within y",
)
def empty_let(span: Span) -> Diagnostic:
    """A `let` with nothing before `within`."""
    return Diagnostic("CSP132", "this `let` declares nothing", span, help="leave out `let` and `within`")


@mistake(
    "CSP133",
    "a module without a line break behind its header",
    explanation="The header of a module, `module M` or `module M(x)`, stands on its own line.",
    example="module M x = 1 exports endmodule",
    repair="module M\n  x = 1\nexports\nendmodule",
)
def module_header(span: Span, found: str) -> Diagnostic:
    """Something stands behind the header of a module on the same line."""
    return Diagnostic(
        "CSP133", f"expected a new line before {found}", span, help="the header of a module stands on its own line"
    )


@mistake(
    "CSP134",
    "an option is given twice",
    explanation="Each option of an assertion is given at most once.",
    example="assert STOP [T= STOP :[tau priority]: {} :[tau priority]: {}",
    repair="assert STOP [T= STOP :[tau priority]: {}",
)
def option_given_twice(span: Span, option: str, first: Span) -> Diagnostic:
    """The second `:[tau priority]:` or `:[partial order reduce]` of an assertion."""
    return Diagnostic(
        "CSP134", f"the option `{option}` is given twice", span, labels=(Label(first, "first given here"),)
    )


@mistake(
    "CSP135",
    "a module with empty brackets",
    explanation="A module without parameters is declared and instantiated without brackets.",
    example="module M()\nexports\nendmodule",
    repair="module M\nexports\nendmodule",
)
def empty_module_brackets(span: Span) -> Diagnostic:
    """`()` behind the name of a module or in an instance."""
    return Diagnostic("CSP135", "a module has no empty brackets", span, help="leave out `()`")


__all__ = [
    "annotated_twice",
    "annotation_without_blank",
    "annotation_without_definition",
    "both_outside_pattern",
    "chained_comparison",
    "chained_operator",
    "channels_annotated_apart",
    "comparison_for_definition",
    "concerns_whole_script",
    "declaration_cut_short",
    "definition_over_files",
    "definition_sign_in_expression",
    "described",
    "empty_brackets",
    "empty_let",
    "empty_module_brackets",
    "empty_type",
    "expression_alone",
    "function_type_without_list",
    "greater_closes_sequence",
    "invalid_function_head",
    "invalid_pattern",
    "line_begins_declaration",
    "line_continues_nothing",
    "map_without_blank",
    "misplaced_declaration",
    "missing_at",
    "missing_branch",
    "missing_process",
    "missing_within",
    "module_header",
    "number_too_long",
    "operator_without_operand",
    "option_given_twice",
    "reserved_word",
    "sequence_pattern",
    "set_pattern",
    "unclosed_bracket",
    "unexpected",
    "unexpected_end",
    "unknown_constraint",
    "unopened_bracket",
    "wildcard_outside_pattern",
    "wrong_closing_bracket",
]
