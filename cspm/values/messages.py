"""Mistakes that show when a script is evaluated.

The builders take the values themselves and show them shortened. Those without a span get the place of the
expression that was being evaluated when they pass it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cspcheck.cspm.diagnostics import Diagnostic, Label, mistake
from cspcheck.cspm.source import Span


def _show(value: Any) -> str:
    from cspcheck.cspm.values.text import show_short  # the texts of values know the values, which know these messages

    return show_short(value)


def _kind(value: Any) -> str:
    """What sort of value it is, with its article."""
    from cspcheck.cspm.process import terms as process
    from cspcheck.cspm.values import dots, sets, values

    match value:
        case int():
            return "a number"
        case str():
            return "a character"
        case values.Boolean():
            return "a truth value"
        case tuple():
            return "a tuple"
        case values.Sequence():
            return "a sequence"
        case values.Map():
            return "a map"
        case dots.Event():
            return "an event"
        case dots.Dotted() if value.head.is_channel:
            return "an incomplete event"
        case dots.Dotted():
            return "a datatype value" if value.complete else "an incomplete datatype value"
        case dots.DotList():
            return "a dotted value"
        case sets.Set():
            return "a set"
        case process.Process():
            return "a process"
    return "a function"


_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


def _ordinal(position: int) -> str:
    return _ORDINALS[position] if position < len(_ORDINALS) else f"{position + 1}th"


def _declared(span: Span | None) -> tuple[Label, ...]:
    return () if span is None else (Label(span, "declared here"),)


@mistake(
    "CSP401",
    "division by zero",
    explanation="The right side of `/` and `%` must not be zero.",
    example="x = 1 / 0\nprint x",
    repair="f(n) = if n == 0 then 0 else 1 / n\nprint f(0)",
)
def division_by_zero(operator: str, left: int, span: Span) -> Diagnostic:
    """``left / 0`` or ``left % 0``."""
    return Diagnostic("CSP401", f"division by zero: `{left} {operator} 0`", span)


@mistake(
    "CSP402",
    "the first element or the rest of an empty sequence",
    explanation="`head` and `tail` need a sequence with at least one element.",
    example="print head(<>)",
    repair="f(s) = if null(s) then 0 else head(s)\nprint f(<>)",
)
def empty_sequence(function: str) -> Diagnostic:
    """``head(<>)`` or ``tail(<>)``."""
    return Diagnostic("CSP402", f"`{function}` of an empty sequence", help="test it with `null` first")


@mistake(
    "CSP403",
    "a value that no pattern matches",
    explanation=(
        "The arguments of a function must match the patterns of one of its clauses, and the value of a definition "
        "`pattern = e` must match the pattern."
    ),
    example="f(0) = 1\nprint f(2)",
    repair="f(0) = 1\nf(n) = n\nprint f(2)",
)
def no_clause(name: str, arguments: Sequence[Any], span: Span | None, declared: Span | None) -> Diagnostic:
    """A function none of whose clauses matches its *arguments*."""
    shown = ", ".join(map(_show, arguments))
    return Diagnostic(
        "CSP403",
        f"no clause of `{name}` matches `({shown})`",
        span,
        labels=_declared(declared),
        help="add a clause for it",
    )


def no_match(value: Any, pattern: str, span: Span | None) -> Diagnostic:
    """A definition or a lambda whose pattern does not match the *value*."""
    return Diagnostic("CSP403", f"`{_show(value)}` does not match the pattern `{pattern}`", span)


@mistake(
    "CSP404",
    "the script calls `error`",
    explanation="`error(text)` stops the evaluation with that text.",
    example='print error("not possible")',
    repair="Find out from the notes why the script came there.",
)
def error_called(text: str) -> Diagnostic:
    """``error("...")``."""
    return Diagnostic("CSP404", f"the script says: {text}")


@mistake(
    "CSP405",
    "a key that is not in the map",
    explanation="`mapLookup` needs a key that the map has.",
    example="print mapLookup((| 1 => 2 |), 3)",
    repair="m = (| 1 => 2 |)\nf(k) = if mapMember(m, k) then mapLookup(m, k) else 0\nprint f(3)",
)
def missing_key(key: Any, known: Any) -> Diagnostic:
    """A lookup of a *key* that the map *known* does not have."""
    return Diagnostic(
        "CSP405", f"the key `{_show(key)}` is not in the map `{_show(known)}`", help="test it with `mapMember` first"
    )


@mistake(
    "CSP406",
    "an internal choice between nothing",
    explanation="`|~|` over an empty set and a `$` field without values have no meaning: there is nothing to choose.",
    example="channel c : {0..1}\nP = |~| x : {} @ c.x -> STOP\nassert P :[deadlock free]",
    repair="channel c : {0..1}\nP = |~| x : {0} @ c.x -> STOP\nassert P :[deadlock free]",
)
def empty_internal_choice(what: str, span: Span) -> Diagnostic:
    """``|~|`` over an empty set, or a ``$`` field that no value can take."""
    return Diagnostic("CSP406", f"{what} has nothing to choose from", span, help="an internal choice needs one value")


@mistake(
    "CSP407",
    "a replicated linked parallel of nothing",
    explanation="A chain of linked processes needs at least one.",
    example="channel a, b\nP = [a <-> b] x : <> @ STOP\nassert P :[deadlock free]",
    repair="channel a, b\nP = [a <-> b] x : <1> @ STOP\nassert P :[deadlock free]",
)
def empty_linked_parallel(span: Span) -> Diagnostic:
    """``[a <-> b] x : <> @ P``."""
    return Diagnostic("CSP407", "a replicated linked parallel has no processes", span)


@mistake(
    "CSP408",
    "an event is linked twice",
    explanation="In a linked parallel each event can be linked once on each side.",
    example="channel a, b, c\nP = STOP [a <-> b, a <-> c] STOP\nassert P :[deadlock free]",
    repair="channel a, b, c\nP = STOP [a <-> b, c <-> c] STOP\nassert P :[deadlock free]",
)
def linked_twice(event: Any, side: str, span: Span) -> Diagnostic:
    """An event that stands twice on one *side* of the links."""
    return Diagnostic("CSP408", f"the event `{_show(event)}` is linked twice on the {side} side", span)


@mistake(
    "CSP409",
    "a value outside its field",
    explanation="Each field of a channel or constructor can hold the values of its declared set only.",
    example="channel c : {0..1}\nP = c.2 -> STOP\nassert P :[deadlock free]",
    repair="channel c : {0..2}\nP = c.2 -> STOP\nassert P :[deadlock free]",
)
def outside_field(name: str, is_channel: bool, position: int, value: Any, domain: Any) -> Diagnostic:
    """A *value* for a field (counted from 0) that is not in its *domain*."""
    what = "channel" if is_channel else "constructor"
    return Diagnostic(
        "CSP409",
        f"`{_show(value)}` is outside the {_ordinal(position)} field of {what} `{name}`",
        notes=(f"the field holds `{_show(domain)}`",),
        help=f"widen the declaration of `{name}`, or keep the value inside",
    )


@mistake(
    "CSP410",
    "a set of dotted values that is no product of its fields",
    explanation=(
        "A field type of dotted values stands for several fields; it must hold every combination of the values "
        "that its fields take."
    ),
    example="channel c : {0.0, 1.1}\nP = c.0.0 -> STOP\nassert P :[deadlock free]",
    repair="channel c : {0..1}.{0..1}\nP = c.0.0 -> STOP\nassert P :[deadlock free]",
)
def not_rectangular(name: str, found: Any, absent: Sequence[Any]) -> Diagnostic:
    """The set *found* in the declaration of *name* lacks the combinations *absent* (none: the lengths differ)."""
    if absent:
        shown = ", ".join(f"`{_show(value)}`" for value in absent[:3])
        note = f"missing: {shown}{', ...' if len(absent) > 3 else ''}"
    else:
        note = "its values have different numbers of fields"
    return Diagnostic(
        "CSP410",
        f"the field type `{_show(found)}` of `{name}` is not a product of sets",
        notes=(note,),
        help="write a product `S.T`, or put the values into a datatype",
    )


@mistake(
    "CSP411",
    "an infinite set where a finite one is needed",
    explanation="Sets such as `Int` and `Seq(S)` can be tested and combined, but not counted or gone through.",
    example="print card(Int)",
    repair="print card({0..9})",
)
def infinite_set(found: Any) -> Diagnostic:
    """The infinite set *found* would have to be listed."""
    return Diagnostic("CSP411", f"the set `{_show(found)}` is infinite", help="use a finite set, such as `{0..9}`")


def infinite_channel(name: str, position: int, domain: Any) -> Diagnostic:
    """All events of a channel with an infinite field are wanted."""
    return Diagnostic(
        "CSP411",
        f"channel `{name}` has infinitely many events",
        notes=(f"its {_ordinal(position)} field holds `{_show(domain)}`",),
        help="give the field a finite type, or name the values: `{c.x | x <- S}`, `c?x:S`",
    )


@mistake(
    "CSP412",
    "a question about infinite sets that cannot be decided",
    explanation="Membership, inclusion and differences of infinite sets are decided by their form, if that tells.",
    example="print inter(Set({0..}), Set({1..})) == Set({1..})\nprint diff(Int, {0})",
    repair="print diff({0..9}, {0})",
)
def undecidable(what: str, left: Any, right: Any) -> Diagnostic:
    """*what* (``inclusion``, ``the difference``) of two sets cannot be worked out."""
    return Diagnostic("CSP412", f"{what} of `{_show(left)}` and `{_show(right)}` cannot be worked out")


@mistake(
    "CSP413",
    "priorities without levels",
    explanation="`prioritise` needs at least one set of events.",
    example="external prioritise\nP = prioritise(STOP, <>)\nassert P :[deadlock free]",
    repair="external prioritise\nchannel a\nP = prioritise(STOP, <{a}>)\nassert P :[deadlock free]",
)
def no_priorities() -> Diagnostic:
    """``prioritise(P, <>)``."""
    return Diagnostic("CSP413", "`prioritise` needs at least one set of events", help="`prioritise(P, <{}, A>)`")


@mistake(
    "CSP414",
    "a wrong order of priorities",
    explanation=(
        "The order that `prioritisepo` is given must have no cycles, must mention prioritised events only, and its "
        "maximal events must have nothing above them."
    ),
    example=(
        "external prioritisepo\nchannel a, b\n"
        "P = prioritisepo(STOP, {a, b}, {(a, b), (b, a)}, {})\nassert P :[deadlock free]"
    ),
    repair=(
        "external prioritisepo\nchannel a, b\nP = prioritisepo(STOP, {a, b}, {(a, b)}, {a})\nassert P :[deadlock free]"
    ),
)
def cyclic_priorities(cycle: Sequence[Any]) -> Diagnostic:
    """The order of ``prioritisepo`` has a *cycle* (first event again at the end)."""
    return Diagnostic("CSP414", f"the order of priorities has a cycle: `{' > '.join(map(_show, cycle))}`")


def not_maximal(event: Any, above: Any) -> Diagnostic:
    """A maximal event of ``prioritisepo`` that has another *above* it."""
    return Diagnostic("CSP414", f"the maximal event `{_show(event)}` has `{_show(above)}` above it")


def not_prioritised(event: Any) -> Diagnostic:
    """An event in the order of ``prioritisepo`` that is not in the prioritised set."""
    return Diagnostic("CSP414", f"the event `{_show(event)}` is ordered but not in the set of prioritised events")


@mistake(
    "CSP415",
    "a buffer without room",
    explanation="The capacity of a buffer is at least one.",
    example="channel a, b\nP = BUFFER(0, {(a, b)})\nassert P :[deadlock free]",
    repair="channel a, b\nP = BUFFER(1, {(a, b)})\nassert P :[deadlock free]",
)
def buffer_capacity(name: str, capacity: int) -> Diagnostic:
    """A capacity below one."""
    return Diagnostic("CSP415", f"the capacity of `{name}` must be at least 1, not {capacity}")


@mistake(
    "CSP416",
    "an event is used twice in a buffer",
    explanation="Each event of a buffer has one part: input, output or signal.",
    example="channel a, b, c\nP = BUFFER(1, {(a, b), (a, c)})\nassert P :[deadlock free]",
    repair="channel a, b, c, d\nP = BUFFER(1, {(a, b), (d, c)})\nassert P :[deadlock free]",
)
def buffer_event_twice(name: str, event: Any) -> Diagnostic:
    """An *event* that has two parts in a buffer."""
    return Diagnostic("CSP416", f"the event `{_show(event)}` is used twice in `{name}`")


@mistake(
    "CSP417",
    "the wrong number of arguments",
    explanation="A function takes as many arguments as its definition has parameters.",
    example="f(x, y) = x\nprint f(1)",
    repair="f(x, y) = x\nprint f(1, 2)",
)
def argument_count(name: str, expected: int, given: int, span: Span | None, declared: Span | None) -> Diagnostic:
    """A call with too many or too few arguments."""
    return Diagnostic(
        "CSP417",
        f"`{name}` takes {expected} argument{'' if expected == 1 else 's'}, {given} given",
        span,
        labels=_declared(declared),
    )


@mistake(
    "CSP418",
    "a value of the wrong sort",
    explanation="An operator or function is given something that it is not defined for.",
    example="print 1 + true",
    repair="print 1 + 1",
)
def wrong_kind(expected: str, value: Any, span: Span | None = None) -> Diagnostic:
    """*expected* is needed (with its article) where *value* is."""
    return Diagnostic("CSP418", f"expected {expected}, found {_kind(value)}: `{_show(value)}`", span)


def not_comparable(value: Any) -> Diagnostic:
    """``==`` on functions or processes."""
    return Diagnostic(
        "CSP418",
        f"{_kind(value)} cannot be compared with `==`",
        help="compare processes with an assertion: `assert P [FD= Q`",
    )


def not_ordered(left: Any, right: Any) -> Diagnostic:
    """``<`` and its like on values that have no order."""
    return Diagnostic("CSP418", f"`{_show(left)}` and `{_show(right)}` have no order")


def not_a_type(value: Any, name: str) -> Diagnostic:
    """The type of a field of *name* is not a set."""
    return Diagnostic("CSP418", f"the type of `{name}` must be a set, found {_kind(value)}: `{_show(value)}`")


def no_productions(value: Any) -> Diagnostic:
    """``productions`` or ``{| |}`` of something that is neither a channel nor of a datatype."""
    return Diagnostic("CSP418", f"expected a channel, an event or a datatype value, found {_kind(value)}")


def no_extensions(value: Any) -> Diagnostic:
    """``extensions`` of something complete."""
    return Diagnostic("CSP418", f"`{_show(value)}` is complete: nothing can extend it")


def not_a_set_of_events(value: Any) -> Diagnostic:
    """Something else where a set of events is needed."""
    return Diagnostic("CSP418", f"expected a set of events, found {_kind(value)}: `{_show(value)}`")


@mistake(
    "CSP419",
    "an incomplete event",
    explanation="Only an event with all its fields can happen, or stand in a set of events.",
    example="channel c : {0..1}\nP = c -> STOP\nassert P :[deadlock free]",
    repair="channel c : {0..1}\nP = c?x -> STOP\nassert P :[deadlock free]",
)
def incomplete_event(value: Any, span: Span | None) -> Diagnostic:
    """An event without all its fields where it should happen."""
    return Diagnostic(
        "CSP419", f"the event `{_show(value)}` is incomplete", span, help="give its other fields: `c.x`, `c?x`, `c!e`"
    )


def not_an_event_in_set(value: Any) -> Diagnostic:
    """An element of a set of events that is none, or incomplete."""
    if _kind(value) == "an incomplete event":
        shown = _show(value)
        return Diagnostic(
            "CSP419",
            f"`{shown}` in a set of events is incomplete",
            help=f"`{{| {shown} |}}` is the set of all events that start with `{shown}`",
        )
    return Diagnostic("CSP418", f"expected a set of events, but it contains {_kind(value)}: `{_show(value)}`")


@mistake(
    "CSP420",
    "an event with too many fields",
    explanation="An event has exactly the fields of its channel.",
    example="channel a\nP = a.1 -> STOP\nassert P :[deadlock free]",
    repair="channel a : {0..1}\nP = a.1 -> STOP\nassert P :[deadlock free]",
)
def too_many_fields(value: Any, span: Span) -> Diagnostic:
    """Fields behind an event that is complete already."""
    return Diagnostic("CSP420", f"`{_show(value)}` has more fields than its channel", span)


def complete_already(event: Any, span: Span) -> Diagnostic:
    """A ``?``, ``!`` or ``$`` behind an event that is complete."""
    return Diagnostic("CSP420", f"the event `{_show(event)}` is complete: it takes no further field", span)


@mistake(
    "CSP421",
    "a value that needs itself",
    explanation="The evaluation of a definition came back to the same definition: it has no value.",
    example="x = x + 1\nprint x",
    repair="y = 0\nx = y + 1\nprint x",
)
def depends_on_itself(name: str | None = None, span: Span | None = None) -> Diagnostic:
    """A definition whose value needs its own value."""
    what = "this value" if name is None else f"the value of `{name}`"
    return Diagnostic("CSP421", f"{what} depends on itself", span)


def declaration_needs_itself(name: str, span: Span | None) -> Diagnostic:
    """A channel or constructor whose field types mention its own events or values."""
    return Diagnostic("CSP421", f"the fields of `{name}` depend on `{name}` itself", span)


@mistake(
    "CSP422",
    "a process that never begins",
    explanation=(
        "A process was unfolded again and again and came to no operator: a recursion must pass a prefix, or at "
        "least end in another process."
    ),
    example="P = Q\nQ = P\nassert P :[deadlock free]",
    repair="channel a\nP = a -> Q\nQ = P\nassert P :[deadlock free]",
)
def process_is_itself(names: Sequence[str], span: Span | None) -> Diagnostic:
    """*names* are the processes that stand for each other, the first again at the end."""
    text = f"`{names[0]}` is defined as itself"
    if len(names) > 2:
        text += f" by way of {', '.join(f'`{name}`' for name in names[1:-1])}"
    return Diagnostic("CSP422", text, span, help=f"put an event in front: `a -> {names[0]}`")


def never_begins(name: str, limit: int, span: Span | None) -> Diagnostic:
    """A process *name* that stands for ever other processes, *limit* of them."""
    return Diagnostic(
        "CSP422",
        f"`{name}` was unfolded {limit:,} times and came to no event",
        span,
        help="put an event in front of the recursion, or end it",
    )


@mistake(
    "CSP423",
    "recursion without end",
    explanation=(
        "Calls of functions were nested so deep that the evaluation was given up; most often a recursion lacks the "
        "case in which it stops."
    ),
    example="f(n) = 1 + f(n + 1)\nprint f(0)",
    repair="f(n) = if n == 10 then 0 else 1 + f(n + 1)\nprint f(0)",
)
def too_deep(span: Span | None) -> Diagnostic:
    """Nesting beyond what the evaluator has room for."""
    return Diagnostic(
        "CSP423",
        "the recursion is too deep",
        span,
        annotation="while evaluating this",
        help="check that the recursion comes to an end",
    )


def nested_too_deep(limit: int) -> Diagnostic:
    """A value nested deeper than *limit*."""
    return Diagnostic("CSP423", f"a value is nested more than {limit:,} deep")


@mistake(
    "CSP424",
    "a sequence without end",
    explanation=(
        "The end or the length of an infinite sequence is needed, or an element of it that does not seem to come."
    ),
    example="print #<0..>",
    repair="print #<0..9>",
)
def infinite_sequence() -> Diagnostic:
    """An infinite sequence would have to be evaluated to its end."""
    return Diagnostic("CSP424", "the sequence is infinite", help="use a finite part of it, such as `<0..9>`")


def nothing_found(limit: int) -> Diagnostic:
    """More than *limit* elements were looked through for one that there may not be."""
    return Diagnostic(
        "CSP424",
        f"more than {limit:,} elements of a sequence were looked through in vain",
        help="use a finite part of it, such as `<0..9>`",
    )


@mistake(
    "CSP425",
    "a value too large to be listed",
    explanation="A set or a sequence has more elements than the evaluator is willing to list.",
    example="print card({x | x <- Set({0..40})})",
    repair="print card({x | x <- Set({0..4})})",
)
def too_large(found: Any, limit: int) -> Diagnostic:
    """The set *found* has more than *limit* elements."""
    return Diagnostic("CSP425", f"the set `{_show(found)}` has more than {limit:,} elements")


def too_many_completions(found: Any, limit: int) -> Diagnostic:
    """There are more than *limit* events or datatype values that start with *found*, a value or a channel's name."""
    shown = found if type(found) is str else _show(found)
    return Diagnostic(
        "CSP425",
        f"more than {limit:,} values start with `{shown}`",
        help="restrict the fields to what is needed, as in `c?x:S`",
    )


def too_long(limit: int) -> Diagnostic:
    """A sequence of more than *limit* elements."""
    return Diagnostic("CSP425", f"a sequence has more than {limit:,} elements")


@mistake(
    "CSP440",
    "a number too large",
    explanation="A product has more digits than the evaluator is willing to work with. Numbers have no bound in CSPm, "
    "but one of some hundred thousand digits comes from a recursion that multiplies without end, not from a model.",
    example="power(n) = if n == 0 then 2 else power(n - 1) * power(n - 1)\nprint power(40)",
    repair="power(n) = if n == 0 then 2 else power(n - 1) * power(n - 1)\nprint power(4)",
)
def number_too_large(bits: int) -> Diagnostic:
    """A product of more than *bits* bits."""
    return Diagnostic("CSP440", f"a product has more than {bits * 30_103 // 100_000:,} digits")


@mistake(
    "CSP426",
    "a subtype with too many fields",
    explanation="A constructor in a subtype has at most the fields that it has in its datatype.",
    example="datatype T = A.{0..1}\nsubtype S = A.{0}.{0}\nprint S",
    repair="datatype T = A.{0..1}\nsubtype S = A.{0}\nprint S",
)
def subtype_fields(name: str, expected: int, given: int, span: Span) -> Diagnostic:
    """A constructor *name* with more fields in a subtype than in its datatype."""
    return Diagnostic(
        "CSP426", f"`{name}` has {expected} field{'' if expected == 1 else 's'} in its datatype, {given} here", span
    )


@mistake(
    "CSP427",
    "a negative duration",
    explanation="`WAIT` and the durations of events are numbers of `tock`s: zero or more.",
    example="channel tock\nTimed {\nP = WAIT(-1)\n}\nassert P :[deadlock free]",
    repair="channel tock\nTimed {\nP = WAIT(1)\n}\nassert P :[deadlock free]",
)
def negative_duration(value: int, span: Span | None) -> Diagnostic:
    """A duration below zero."""
    return Diagnostic("CSP427", f"a duration must not be negative: `{value}`", span)


@mistake(
    "CSP428",
    "too many module instances",
    explanation="Modules that instantiate modules that instantiate modules multiply; there is a limit.",
    example="Modules nested thirty deep, each with two instances of the next.",
    repair="Use fewer instances.",
)
def too_many_instances(limit: int, span: Span) -> Diagnostic:
    """More than *limit* instances of modules."""
    return Diagnostic("CSP428", f"the script makes more than {limit:,} module instances", span)
