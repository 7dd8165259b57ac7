"""Process terms as CSPm text with all their definitions, for messages of failed tests."""

from __future__ import annotations

from collections.abc import Iterable

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    Buffer,
    Chaos,
    Compressed,
    Diverge,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Project,
    Reference,
    Rename,
    Run,
    Sequential,
    Skip,
    SlidingChoice,
    Stop,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)
from tests.reference.processes import COMPRESSIONS, EVENTS, TABLE


def script(**processes: Process) -> str:
    """The processes by their names, as a script that can be loaded."""
    definitions: dict[Reference, str] = {}
    lines = [f"{name} = {_text(process, definitions)}" for name, process in processes.items()]
    pending = list(definitions)
    for reference in pending:
        before = len(definitions)
        lines.append(f"{reference.text} = {_text(reference.body(), definitions)}")
        pending.extend(list(definitions)[before:])
    head = ["channel " + ", ".join(TABLE.name(e) for e in EVENTS)]
    if used := [name for name in COMPRESSIONS if any(f"{name}(" in line for line in lines)]:
        head.append("transparent " + ", ".join(used))
    return "\n".join([*head, *lines])


def trace(events: Iterable[int]) -> str:
    return "<" + ", ".join(TABLE.name(e) for e in events) + ">"


def event_set(events: Iterable[int]) -> str:
    return "{" + ", ".join(TABLE.name(e) for e in events) + "}"


def _alphabetised(alphabets: tuple[EventSet, ...], texts: list[str]) -> str:
    """There is no infix form for more than two, so it is written as it associates."""
    text, union = texts[0], alphabets[0]
    for alphabet, operand in zip(alphabets[1:], texts[1:], strict=True):
        text = f"({text}) [{event_set(union)} || {event_set(alphabet)}] {operand}"
        union = union | alphabet
    return text


def _generalised(events: EventSet, texts: list[str]) -> str:
    """The operator is not associative in the syntax."""
    text = texts[0]
    for operand in texts[1:]:
        text = f"({text}) [| {event_set(events)} |] {operand}"
    return text


def _text(process: Process, definitions: dict[Reference, str]) -> str:
    def inner(operand: Process) -> str:
        text = _text(operand, definitions)
        return text if isinstance(operand, Stop | Skip | Diverge | Run | Chaos | Reference) else f"({text})"

    match process:
        case Stop():
            return "STOP"
        case Skip():
            return "SKIP"
        case Diverge():
            return "DIV"
        case Run(events):
            return f"RUN({event_set(events)})"
        case Chaos(events):
            return f"CHAOS({event_set(events)})"
        case Prefix(branches):
            return " [] ".join(f"{TABLE.name(event)} -> {inner(then)}" for event, then in branches) or "STOP"
        case ExternalChoice(operands):
            return " [] ".join(map(inner, operands))
        case InternalChoice(operands):
            return " |~| ".join(map(inner, operands))
        case SlidingChoice(left, right):
            return f"{inner(left)} [> {inner(right)}"
        case SynchronisingChoice(events, operands):
            return f" [+ {event_set(events)} +] ".join(map(inner, operands))
        case Interrupt(left, right):
            return rf"{inner(left)} /\ {inner(right)}"
        case SynchronisingInterrupt(left, events, right):
            return rf"{inner(left)} /+ {event_set(events)} +\ {inner(right)}"
        case Throw(left, events, right):
            return f"{inner(left)} [| {event_set(events)} |> {inner(right)}"
        case Sequential(left, right):
            return f"{inner(left)} ; {inner(right)}"
        case Parallel(events, operands):
            return _generalised(events, [*map(inner, operands)]) if events else " ||| ".join(map(inner, operands))
        case AlphabetisedParallel(alphabets, operands):
            return _alphabetised(alphabets, [*map(inner, operands)])
        case LinkedParallel(left, links, right):
            pairs = ", ".join(f"{TABLE.name(a)} <-> {TABLE.name(b)}" for a, b in links)
            return f"{inner(left)} [{pairs}] {inner(right)}"
        case Hide(hidden, events):
            return rf"{inner(hidden)} \ {event_set(events)}"
        case Project(hidden, events):
            return rf"{inner(hidden)} |\ {event_set(events)}"
        case Rename(renamed, pairs):
            return f"{inner(renamed)}[[{', '.join(f'{TABLE.name(a)} <- {TABLE.name(b)}' for a, b in pairs)}]]"
        case Buffer(kind, capacity, signals, pairs, ()):
            moved = ", ".join(f"({TABLE.name(a)}, {TABLE.name(b)})" for a, b in pairs)
            return f"{kind}({', '.join([str(capacity), *map(TABLE.name, signals)])}, {{{moved}}})"
        case Compressed(function, compressed):
            return f"{function}({_text(compressed, definitions)})"
        case Reference():
            definitions.setdefault(process, process.text)
            return process.text
        case _:
            return repr(process)
