"""Process terms as CSPm text, for people who look at a state: ``getDirection -> saveDirection -> Compass``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.events import EventSet, EventTable

WIDTH = 120
DEEPEST = 40
"""Operators nested deeper than this are folded whatever the width."""


def describe(term: process.Process, events: EventTable, *, width: int = WIDTH) -> str:
    """*term* in about *width* characters; what does not fit is ``...``. References are named, not looked into."""
    writer = _Writer(events, width)
    writer.write(term, 0, DEEPEST)
    text = "".join(writer.out)
    return text if len(text) <= width + 3 else text[:width].rstrip() + "..."


def describe_events(events: EventSet, table: EventTable, *, width: int = WIDTH) -> str:
    """A set of events: whole channels as ``{| c |}``, what does not fit as ``...``."""
    whole: list[str] = []
    single: list[str] = []
    used = 0
    everything: list[tuple[int, int]] = []
    for channel in table.channels:
        if channel.size and channel.size > 1:
            all_of_it = (channel.base, channel.base + channel.size)
            if events.has_range(*all_of_it):
                whole.append(channel.name)
                everything.append(all_of_it)
    for event in events - EventSet(everything):
        if used > width:
            single.append("...")
            break
        single.append(table.name(event))
        used += len(single[-1]) + 2
    if not whole:
        return f"{{{', '.join(single)}}}"
    return f"{{| {', '.join([*whole, *single])} |}}"


class _Writer:
    """Collects the text of a term. Operators of loose binding get brackets inside tighter ones."""

    def __init__(self, events: EventTable, width: int) -> None:
        self.events = events
        self.width = width
        self.out: list[str] = []
        self.used = 0

    def add(self, text: str) -> None:
        self.out.append(text)
        self.used += len(text)

    def set(self, events: EventSet) -> str:
        return describe_events(events, self.events, width=max(20, self.width // 3))

    def write(self, term: process.Process, outside: int, depth: int) -> None:
        if self.used > self.width or depth == 0:
            self.add("...")
            return
        form = _FORMS.get(type(term))
        if form is None:
            self.add(str(term))
            return
        level, write = form
        if isinstance(term, process.Prefix) and len(term.branches) > 1:
            level = _CHOICE
        if level < outside:
            self.add("(")
            write(self, term, depth - 1)
            self.add(")")
        else:
            write(self, term, depth - 1)

    def chain(self, operands: Iterable[process.Process], separator: str, inside: int, depth: int) -> None:
        for i, operand in enumerate(operands):
            if i:
                self.add(separator)
                if self.used > self.width:
                    self.add("...")
                    return
            self.write(operand, inside, depth)


# How tightly operators bind, loosest first.
_HIDE, _PARALLEL, _INTERNAL, _CHOICE, _INTERRUPT, _SLIDING, _SEQUENCE, _PREFIX, _ATOM = range(9)

Form = Callable[[_Writer, Any, int], None]


def _prefix(w: _Writer, t: process.Prefix, depth: int) -> None:
    # A long chain of events is followed here: its end may be thousands of operators away.
    term: process.Process = t
    while isinstance(term, process.Prefix) and len(term.branches) == 1 and w.used <= w.width:
        event, term = term.branches[0]
        w.add(f"{w.events.name(event)} -> ")
    if isinstance(term, process.Prefix) and len(term.branches) > 1:
        bracket = term is not t
        w.add("(" if bracket else "")
        for i, (event, then) in enumerate(term.branches):
            w.add(" [] " if i else "")
            if w.used > w.width:
                w.add("...")
                break
            w.add(f"{w.events.name(event)} -> ")
            w.write(then, _PREFIX, depth)
        w.add(")" if bracket else "")
    else:
        w.write(term, _PREFIX, depth)


def _infix(separator: str, level: int) -> Form:
    def write(w: _Writer, t: Any, depth: int) -> None:
        w.chain((t.left, t.right), separator, level + 1, depth)

    return write


def _choice(separator: str, level: int) -> Form:
    def write(w: _Writer, t: Any, depth: int) -> None:
        w.chain(t.operands, separator, level + 1, depth)

    return write


def _synchronised(w: _Writer, t: process.Parallel, depth: int) -> None:
    if not t.events:
        w.chain(t.operands, " ||| ", _PARALLEL + 1, depth)
        return
    # Only interleaving may be chained; of the others each needs brackets inside the next.
    separator = f" [| {w.set(t.events)} |] "
    w.add("(" * (len(t.operands) - 2))
    for i, operand in enumerate(t.operands):
        if i:
            w.add(")" if i > 1 else "")
            w.add(separator)
            if w.used > w.width:
                w.add("...")
                return
        w.write(operand, _PARALLEL + 1, depth)


def _alphabetised(w: _Writer, t: process.AlphabetisedParallel, depth: int) -> None:
    if len(t.operands) == 2:
        left, right = map(w.set, t.alphabets)
        w.chain(t.operands, f" [ {left} || {right} ] ", _PARALLEL + 1, depth)
        return
    w.add("|| <")
    for i, (alphabet, operand) in enumerate(zip(t.alphabets, t.operands, strict=True)):
        w.add(", " if i else "")
        if w.used > w.width:
            w.add("...")
            break
        w.add(f"{w.set(alphabet)}: ")
        w.write(operand, 0, depth)
    w.add(">")


def _links(w: _Writer, t: process.LinkedParallel, depth: int) -> None:
    shown = [f"{w.events.name(a)} <-> {w.events.name(b)}" for a, b in t.links[:4]]
    shown += ["..."] if len(t.links) > 4 else []
    w.chain((t.left, t.right), f" [ {', '.join(shown)} ] ", _PARALLEL + 1, depth)


def _between(opening: str, closing: str, level: int) -> Form:
    def write(w: _Writer, t: Any, depth: int) -> None:
        w.chain((t.left, t.right), f" {opening} {w.set(t.events)} {closing} ", level + 1, depth)

    return write


def _synchronising_choice(w: _Writer, t: process.SynchronisingChoice, depth: int) -> None:
    w.chain(t.operands, f" [+ {w.set(t.events)} +] ", _CHOICE + 1, depth)


def _hide(sign: str) -> Form:
    def write(w: _Writer, t: Any, depth: int) -> None:
        w.write(t.process, _HIDE, depth)
        w.add(f" {sign} {w.set(t.events)}")

    return write


def _rename(w: _Writer, t: process.Rename, depth: int) -> None:
    w.write(t.process, _ATOM, depth)
    shown = [f"{w.events.name(old)} <- {w.events.name(new)}" for old, new in t.pairs[:6]]
    shown += ["..."] if len(t.pairs) > 6 else []
    w.add(f"[[{', '.join(shown)}]]")


def _of_events(name: str) -> Form:
    return lambda w, t, depth: w.add(f"{name}({w.set(t.events)})")


def _applied(w: _Writer, t: Any, depth: int) -> None:
    w.add(f"{t.function}(")
    w.write(t.process, 0, depth)
    arguments = getattr(t, "arguments", ())
    w.add(", ...)" if arguments else ")")


def _watchdog(w: _Writer, t: process.Watchdog, depth: int) -> None:
    """The least text of the specification's states stands for all of them."""
    texts = sorted(describe(member, w.events) for member in t.members)
    more = f" or {len(texts) - 1} more" if len(texts) > 1 else ""
    w.add(f"{t.function} of {texts[0]}{more}")
    if t.insists is not None:
        w.add(f" insisting on {{{', '.join(w.events.name(event) for event in sorted(t.insists))}}}")


def _prioritised(w: _Writer, t: process.Prioritised, depth: int) -> None:
    w.add("prioritise(")
    w.write(t.process, 0, depth)
    w.add(f", <{', '.join(map(w.set, t.levels))}>)")


def _buffer(w: _Writer, t: process.Buffer, depth: int) -> None:
    contents = [w.events.name(t.pairs[i][0]) for i in t.contents[:6]]
    contents += ["..."] if len(t.contents) > 6 else []
    w.add(f"{t.kind}({t.capacity}, ...) holding <{', '.join(contents)}>")


def _word(text: str) -> Form:
    return lambda w, t, depth: w.add(text)


def _machine_state(w: _Writer, t: process.MachineState, depth: int) -> None:
    w.add(f"(state {t.state} of ")
    w.write(t.machine.source, 0, depth)
    w.add(")")


_FORMS: dict[type[process.Process], tuple[int, Form]] = {
    process.Stop: (_ATOM, _word("STOP")),
    process.Skip: (_ATOM, _word("SKIP")),
    process.Terminated: (_ATOM, _word("(terminated)")),
    process.Diverge: (_ATOM, _word("DIV")),
    process.Beyond: (_ATOM, _word("beyond the finite reading")),
    process.Run: (_ATOM, _of_events("RUN")),
    process.Chaos: (_ATOM, _of_events("CHAOS")),
    process.Prefix: (_PREFIX, _prefix),
    process.ExternalChoice: (_CHOICE, _choice(" [] ", _CHOICE)),
    process.InternalChoice: (_INTERNAL, _choice(" |~| ", _INTERNAL)),
    process.SlidingChoice: (_SLIDING, _infix(" [> ", _SLIDING)),
    process.SynchronisingChoice: (_CHOICE, _synchronising_choice),
    process.Interrupt: (_INTERRUPT, _infix(" /\\ ", _INTERRUPT)),
    process.SynchronisingInterrupt: (_INTERRUPT, _between("/+", "+\\", _INTERRUPT)),
    process.Throw: (_PARALLEL, _between("[|", "|>", _PARALLEL)),
    process.Sequential: (_SEQUENCE, _infix("; ", _SEQUENCE)),
    process.Parallel: (_PARALLEL, _synchronised),
    process.AlphabetisedParallel: (_PARALLEL, _alphabetised),
    process.LinkedParallel: (_PARALLEL, _links),
    process.Hide: (_HIDE, _hide("\\")),
    process.Project: (_HIDE, _hide("|\\")),
    process.Rename: (_ATOM, _rename),
    process.Buffer: (_ATOM, _buffer),
    process.Compressed: (_ATOM, _applied),
    process.Fused: (_ATOM, lambda w, t, depth: w.write(t.process, _ATOM, depth)),
    process.External: (_ATOM, _applied),
    process.Watchdog: (_ATOM, _watchdog),
    process.Prioritised: (_ATOM, _prioritised),
    process.MachineState: (_ATOM, _machine_state),
    process.Reference: (_ATOM, lambda w, t, depth: w.add(t.text)),
}
