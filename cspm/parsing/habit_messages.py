"""What is said to people who come from another language: one message for each habit, and it names the repair.

Codes 116-119, and 014 and 015 for whole files.
"""

from __future__ import annotations

from cspcheck.cspm.diagnostics import Diagnostic, mistake
from cspcheck.cspm.source import Span

HABITS = ("CSP116", "CSP117", "CSP118", "CSP119")
"""Codes of which the first of a kind is told: who writes one `;` too many writes it on each line."""


@mistake(
    "CSP116",
    "a sign or word of another language",
    explanation="CSPm writes some things otherwise than programming languages and other tools do: `and`, `or` and "
    "`not` for `&&`, `||` and `!`, `->` for `=>`, `=` for `:=`, `^` for `++`, `|` between the "
    "constructors of a datatype, a set of numbers as `{0..3}`, one `channel` line for each type, `let ... within ...`.",
    example="f(x) = if x == 1 && x != 2 then 1 else 0",
    repair="f(x) = if x == 1 and x != 2 then 1 else 0",
)
def borrowed(span: Span, instead: str) -> Diagnostic:
    """What stands at *span* is not CSPm; *instead* says what to write, behind "write"."""
    return Diagnostic("CSP116", f"`{' '.join(span.text.split())}` is not CSPm here", span, help=f"write {instead}")


@mistake(
    "CSP117",
    "a comment of another language",
    explanation="A comment begins with `--` and goes to the end of the line; one over several lines stands between "
    "`{-` and `-}`.",
    example="channel a // what happens",
    repair="channel a -- what happens",
)
def borrowed_comment(span: Span) -> Diagnostic:
    """The sign at *span* begins a comment in another language."""
    return Diagnostic(
        "CSP117",
        f"`{span.text}` begins no comment",
        span,
        help="a comment begins with `--`, or stands between `{-` and `-}`",
    )


@mistake(
    "CSP118",
    "the form of an assertion",
    explanation="A refinement is written `assert SPEC [T= IMPL`, with `T`, `F` or `FD` for the model, and a property "
    "`assert P :[deadlock free]`, with the model inside: `:[deadlock free [F]]`.",
    example="channel a\nP = a -> P\nassert P [deadlock free]",
    repair="channel a\nP = a -> P\nassert P :[deadlock free]",
)
def assertion_form(span: Span, instead: str) -> Diagnostic:
    """The words at *span* claim something in a form that assertions do not have; *instead* is one that they have."""
    return Diagnostic("CSP118", "this is not how an assertion is written", span, help=f"write {instead}")


@mistake(
    "CSP119",
    "a semicolon at the end of a line",
    explanation="A line break ends a declaration. `;` is sequential composition: `P ; Q` behaves as P, and as Q when P "
    "has terminated.",
    example="channel a;\nP = a -> P;",
    repair="channel a\nP = a -> P",
)
def semicolon(span: Span) -> Diagnostic:
    """A `;` that was meant to end a declaration."""
    return Diagnostic("CSP119", "`;` ends no declaration", span, help="leave it out: the end of the line is enough")


@mistake(
    "CSP014",
    "the file is a Markdown document",
    explanation="The text has a fence of three backticks, as Markdown has around code. A script is what stands between "
    "the fences.",
    example="```csp\nP = STOP\n```",
    repair="P = STOP",
)
def markdown(span: Span) -> Diagnostic:
    """A fence of Markdown stands at *span*."""
    return Diagnostic(
        "CSP014",
        "this is Markdown, not a script",
        span,
        help="take the text between the fences, without the lines that have ```",
    )


@mistake(
    "CSP015",
    "the file is a script of PAT",
    explanation="PAT's language CSP# looks like CSPm and is another one: variables, `#assert` and `#define`, a `;` "
    "behind each declaration.",
    example="channel c 0;\nP() = c!1 -> P();\n#assert P() deadlockfree;",
    repair="channel c : {0..1}\nP = c!1 -> P\nassert P :[deadlock free]",
)
def pat_script(span: Span) -> Diagnostic:
    """A line that only PAT has stands at *span*."""
    return Diagnostic(
        "CSP015",
        "this is a script of PAT, not CSPm",
        span,
        help="in CSPm channels have types (`channel c : {0..3}`), constants are `N = 3`, nothing ends with `;`, and "
        "claims are `assert P :[deadlock free]`",
    )
