"""Mistakes that show when a process becomes a machine (CSP5xx): one builder each."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, mistake
from cspcheck.cspm.source import Span


@mistake(
    "CSP501",
    "unguarded recursion",
    explanation="""
A process calls itself before it has performed an event or made an internal choice, so there is no telling what it
does first. Every recursive call needs an event (or `|~|`, or the right of `;`) between the name and the call.
""",
    example="""
channel a
P = P [] a -> STOP
assert P :[deadlock free]
""",
    repair="""
channel a
P = a -> P
assert P :[deadlock free]
""",
)
def unguarded_recursion(cycle: Sequence[tuple[str, Span | None]]) -> Diagnostic:
    """*cycle*: the calls, as (text, definition), each the first thing the one before does; the last calls the first."""
    names = [text for text, _ in cycle]
    if len(names) == 1:
        message = f"`{names[0]}` calls itself before any event"
    else:
        through = ", ".join(f"`{name}`" for name in names[1:])
        message = f"`{names[0]}` calls itself before any event, through {through}"
    labels = tuple(
        Label(span, f"`{text}` calls `{names[(i + 1) % len(names)]}` before any event")
        for i, (text, span) in enumerate(cycle)
        if i and span is not None
    )
    return Diagnostic(
        "CSP501",
        message,
        cycle[0][1],
        annotation="unguarded recursion",
        labels=labels,
        help="put an event before the recursive call, as in `P = a -> P`",
    )


@mistake(
    "CSP502",
    "endless unfolding",
    explanation="""
A process calls itself with ever new arguments and none of the calls performs an event first, so unfolding the
definitions never ends.
""",
    example="""
channel a
P(n) = P(n + 1) [] a -> STOP
assert P(0) :[deadlock free]
""",
    repair="""
channel a
P(n) = if n == 3 then a -> STOP else P(n + 1)
assert P(0) :[deadlock free]
""",
)
def endless_unfolding(first: Sequence[str], span: Span | None, depth: int) -> Diagnostic:
    """*first*: texts of the first calls; *depth*: how many were nested when we gave up."""
    calls = ", ".join(f"`{text}`" for text in first)
    return Diagnostic(
        "CSP502",
        f"{calls}, ... call one another before any event",
        span,
        annotation="unguarded recursion",
        notes=(f"given up after {depth:,} nested calls",),
        help="put an event before the recursive call, or let the recursion end",
    )


@mistake(
    "CSP503",
    "too many states: arguments that keep growing",
    explanation="""
The limit on states was reached while one definition was called with more and more different arguments. If the
argument has no bound, the process has infinitely many states and cannot be explored to the end. The verdict is
`unknown`.
""",
    example="""
channel a
P(n) = a -> P(n + 1)
assert P(0) :[divergence free]
""",
    repair="""
channel a
P(n) = n < 10 & a -> P(n + 1)
assert P(0) :[divergence free]
""",
)
def growing_arguments(name: str, states: int, calls: Sequence[str], number: int, span: Span | None) -> Diagnostic:
    """*calls*: texts of the first few of *number* different calls of the definition *name*."""
    shown = ", ".join(f"`{text}`" for text in calls)
    return Diagnostic(
        "CSP503",
        f"more than {_states(states)}: `{name}` is called with {number:,} different arguments: {shown}, ...",
        span,
        annotation="the arguments may grow for ever",
        help="bound the argument, for instance `n < 10 & ...`, or raise the limit with `--max-states`",
    )


@mistake(
    "CSP504",
    "too many states: a process that keeps growing",
    explanation="""
The limit on states was reached while the process itself grew: each round of a recursion left something behind (the
right of a `;`, a parallel partner, a hiding), so that no state ever came back. The verdict is `unknown`.
""",
    example="""
channel a, b
P = (a -> P) ; (b -> SKIP)
assert P :[deadlock free]
""",
    repair="""
channel a, b
P = a -> b -> P
assert P :[deadlock free]
""",
)
def growing_process(name: str, states: int, operator: str, depth: int, span: Span | None) -> Diagnostic:
    """*name* as in :func:`too_many_states`; *operator* is nested *depth* deep in the last state found."""
    return Diagnostic(
        "CSP504",
        f"more than {_states(states)}: {name} keeps growing, `{operator}` is nested {depth:,} deep",
        span,
        annotation="grows with every round",
        help=f"let the recursive call be the last thing that happens, outside `{operator}`",
    )


@mistake(
    "CSP505",
    "too many states",
    explanation="""
The limit on states was reached before the process was explored to its end. The verdict is `unknown`: nothing wrong
was found in the part that was explored, and nothing is known of the rest.
""",
    example="""
channel a : {0..3}.{0..3}.{0..3}.{0..3}.{0..3}.{0..3}
P = a?x?y?z?u?v?w -> a.w.v.u.z.y.x -> P
assert P :[deadlock free]
""",
    repair="raise the limit with `--max-states`, or make the ranges of the data smaller",
)
def too_many_states(name: str, states: int, span: Span | None) -> Diagnostic:
    """*name*: the process as it is called, in backticks, or ``the process`` if it has no name."""
    return Diagnostic(
        "CSP505",
        f"more than {_states(states)} in {name}",
        span,
        help="raise the limit with `--max-states`, or make the ranges of the data smaller",
    )


@mistake(
    "CSP506",
    "functions around one another without end",
    explanation="""
Each round of a recursion applies functions to what is left of the round before (`chase`, `deter`, a watchdog), so that
they stand around one another ever deeper and no state comes back. One function around itself is no trouble.
""",
    example="""
channel a
external chase, deter
P = a -> chase(Q)
Q = a -> deter(P)
assert P :[deadlock free]
""",
    repair="""
channel a
external chase, deter
P = a -> Q
Q = a -> P
assert chase(deter(P)) :[deadlock free]
""",
)
def nested_functions(function: str, depth: int) -> Diagnostic:
    """*function* is the innermost of *depth* functions that each follow their operand."""
    return Diagnostic(
        "CSP506",
        f"`{function}` and other functions are applied to one another {depth} deep",
        annotation="nested without end",
        help="apply the function to the whole process, outside the recursion",
    )


def _states(number: int) -> str:
    return "1 state" if number == 1 else f"{number:,} states"
