"""The commands of ``cspcheck probe``, one line each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.spelling import suggestions
from cspcheck.probing import NoSuchStep, Probe, ProbeStep, step_name
from cspcheck.quantities import count, whole_number
from cspcheck.report.diagnostics import render_diagnostics
from cspcheck.report.probe import MOST_STEPS, show_point, show_term, show_trace
from cspcheck.report.sentences import as_sentence, why
from cspcheck.report.style import Style, harmless, wrapped
from cspcheck.result import Result

WALK = 10
"""Steps of a random walk where no number is given."""


LONGEST_WALK = 100_000
"""More steps at random are asked for by mistake: each of them is kept, to go back."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command: how it is written, its short forms, and what it does."""

    usage: str
    short: tuple[str, ...]
    help: str


COMMANDS = {
    "do": Command("NUMBER | EVENT", (), "take that step (`do trace` for an event that is called `trace`)"),
    "run": Command("run EVENT, EVENT...", (), "perform these events, with the internal steps that they need"),
    "next": Command("next [N]", ("n",), "take the next step of the counterexample (at a terminal: an empty line)"),
    "walk": Command("walk [N [SEED]]", ("w",), f"take N steps at random ({WALK} if not said)"),
    "undo": Command("undo [N]", ("u",), "go back a step, or N"),
    "restart": Command("restart", ("r",), "go back to the start"),
    "trace": Command("trace", ("t",), "show the way so far, and who took part"),
    "term": Command("term [COMPONENT]", (), "show the whole state, or that of one component"),
    "all": Command("all", (), "show where we are, with nothing folded"),
    "help": Command("help", ("h", "?"), "show this list"),
    "quit": Command("quit", ("q", "exit"), "leave (also: the end of the input)"),
}


class Commands:
    """Carries out commands on a probe and writes what comes of them.

    Args:
        probe: the process.
        write: takes the text.
        style: how it looks.
        result: the assertion whose counterexample is followed, if there is one.

    Attributes:
        failed: whether the last command could not be carried out.
    """

    def __init__(
        self, probe: Probe, write: Callable[[str], object], style: Style, result: Result | None = None
    ) -> None:
        self._probe = probe
        self._write = write
        self._style = style
        self._result = result
        self.failed = False
        self._actions: dict[str, Callable[[str], None]] = {
            "do": self._do,
            "run": self._run,
            "next": self._next,
            "walk": self._walk,
            "undo": self._undo,
            "restart": self._restart,
            "trace": self._trace,
            "term": self._term,
            "all": self._all,
            "help": self._help,
        }
        self._names = {form: name for name, command in COMMANDS.items() for form in (name, *command.short)}

    def begin(self) -> None:
        """Say what is probed and where it stands."""
        if self._result is not None:
            self._write(f"{self._style.paint(self._result.assertion, 'bold')}\n")
            self._say(as_sentence(why(self._result)) + "\n")
        self._show()

    def do(self, line: str) -> bool:
        """Carry out a command; False when it was to leave.

        What goes wrong is written, and leaves the process where it was.
        """
        self.failed = False
        words = line.strip()
        if words.endswith(";"):
            words = words[:-1].rstrip()
        head, _, rest = words.partition(" ")
        name = self._names.get(head)
        if name != head and self._is_channel(head):
            name = None  # an event is meant, not the short form of a command
        if name == "quit":
            return False
        try:
            if not words:
                self._next("") if self._result is not None else self._show()
            elif name is None or (name == "do" and not rest):
                self._do(words)
            else:
                self._actions[name](rest.strip())
        except _Refused as refused:
            self._fail(harmless(str(refused)))
        except NoSuchStep as error:
            self._fail(harmless(str(error)))
        except ScriptError as error:
            self._fail(render_diagnostics(error.diagnostics, self._style).rstrip())
        return True

    def _is_channel(self, text: str) -> bool:
        return any(channel.name == text for channel in self._probe.events.channels)

    def completions(self, text: str) -> list[str]:
        """What may be meant by the beginning of a line."""
        events = dict.fromkeys(self._texts(self._probe.steps()[:1000]))
        return [word for word in (*events, *COMMANDS) if word.startswith(text) and word != "do"]

    def _say(self, text: str) -> None:
        self._write("\n".join(wrapped(text.rstrip("\n"), self._style.width)) + "\n" * (1 + text.endswith("\n")))

    def _fail(self, text: str) -> None:
        self.failed = True
        self._write(text + "\n")

    def _show(self, *, everything: bool = False) -> None:
        self._write(show_point(self._probe, self._style, everything=everything, beside=self._specification()))
        if self._result is not None and self._probe.run and self._probe.followed() == len(self._probe.run):
            self._write("\n")
            self._say(f"The counterexample ends here: {why(self._result)}.")

    def _specification(self) -> list[tuple[str, str]]:
        """The state of the specification, as long as its run is followed."""
        counterexample = self._result.counterexample if self._result is not None else None
        if counterexample is None or counterexample.specification is None or self._probe.followed() is None:
            return []
        done = sum(performed.event != TAU for performed in self._probe.trace())
        states = [counterexample.specification.states[0]]
        for event, state in zip(
            counterexample.specification.trace, counterexample.specification.states[1:], strict=True
        ):
            if event == counterexample.tau:
                states[-1] = state
            else:
                states.append(state)
        return [("(specification)", states[done])] if done < len(states) else []

    def _texts(self, steps: list[ProbeStep]) -> list[str]:
        return [self._probe.events.name(step.event) for step in steps]

    def _do(self, text: str) -> None:
        steps = self._probe.steps()
        if text.isdecimal():
            number = whole_number(text)
            if not number or number > len(steps):
                raise _Refused(_how_many(len(steps)))
            self._probe.take(steps[number - 1])
        else:
            self._probe.take(self._named(text, steps))
        self._show()

    def _named(self, text: str, steps: list[ProbeStep]) -> ProbeStep:
        """The one step that is called like that."""
        wanted = "".join(text.split())
        chosen = [step for step in steps if self._probe.events.name(step.event).replace(" ", "") == wanted]
        if not chosen and len(steps) <= 1000:
            # A hidden event may be said by its own name.
            for step in steps:
                performed = self._probe.performed(step)
                own = None if performed.cause is None else self._probe.events.name(performed.cause).replace(" ", "")
                if wanted in (own, step_name(self._probe.events, performed).replace(" ", "")):
                    chosen.append(step)
        if len(chosen) == 1:
            return chosen[0]
        if chosen:
            numbers = ", ".join(str(step.number) for step in chosen[:MOST_STEPS])
            raise _Refused(f"`{text}` may be any of {numbers}: choose by number")
        close = suggestions(text, [*dict.fromkeys(self._texts(steps[:1000])), *COMMANDS])
        hint = f"; did you mean {' or '.join(f'`{name}`' for name in close)}?" if close else ""
        raise _Refused(f"`{text}` cannot happen here" + (hint or "; `help` lists the commands"))

    def _run(self, text: str) -> None:
        events = split_events(text)
        if not events:
            raise _Refused("say which events: `run a, b.1`")
        taken = len(self._probe.way)
        try:
            for name in events:
                if name == self._probe.events.tau:
                    self._probe.take(self._first_tau())
                else:
                    self._probe.perform(name)
        except NoSuchStep as error:
            done = len(self._probe.way) - taken
            self._show()
            raise NoSuchStep(f"{error}; stopped after {count(done, 'step')}") from None
        self._show()

    def _first_tau(self) -> ProbeStep:
        step = next((step for step in self._probe.steps() if step.event == TAU), None)
        if step is None:
            raise NoSuchStep(f"`{self._probe.events.tau}` cannot happen here")
        return step

    def _next(self, text: str) -> None:
        if self._result is None:
            raise _Refused("there is no counterexample to follow: start with `--at FILE:LINE`")
        for _ in range(_number(text, 1)):
            if self._probe.followed() is None:
                raise _Refused("this is not the way of the counterexample: `undo` or `restart`")
            step = self._probe.next_of_run()
            if step is None:
                if text:
                    break
                raise _Refused("the counterexample ends here")
            self._probe.take(step)
        self._show()

    def _walk(self, text: str) -> None:
        words = text.split()
        if len(words) > 2:
            raise _Refused("say `walk`, `walk N` or `walk N SEED`")
        steps = _number(words[0] if words else "", WALK)
        if steps > LONGEST_WALK:
            raise _Refused(f"a walk has {LONGEST_WALK:,} steps at most")
        taken = self._probe.walk(steps, _number(words[1], 0, least=0) if len(words) == 2 else None)
        self._say(trace_end(self._probe, self._style, taken))
        self._show()

    def _undo(self, text: str) -> None:
        if not self._probe.undo(_number(text, 1)):
            raise _Refused("this is the start")
        self._show()

    def _restart(self, text: str) -> None:
        self._probe.restart()
        self._show()

    def _trace(self, text: str) -> None:
        self._write(show_trace(self._probe, self._style))

    def _term(self, text: str) -> None:
        shown = show_term(self._probe, text or None, self._style)
        if shown is None:
            names = [name for name, _, _ in self._probe.components()]
            close = suggestions(text, names) or names[:5]
            raise _Refused(f"there is no component `{text}`; there is {', '.join(f'`{name}`' for name in close)}")
        self._write(shown)

    def _all(self, text: str) -> None:
        self._show(everything=True)

    def _help(self, text: str) -> None:
        width = max(len(command.usage) for command in COMMANDS.values())
        for command in COMMANDS.values():
            forms = f" ({', '.join(command.short)})" if command.short else ""
            self._write(f"  {command.usage:<{width}}  {command.help}{forms}\n")


class _Refused(Exception):
    """A command that means nothing here; the message says why."""


def trace_end(probe: Probe, style: Style, steps: int) -> str:
    """The last steps of the way."""
    done = [step_name(probe.events, performed) for performed in probe.trace()][len(probe.trace()) - steps :]
    shown = done if len(done) <= MOST_STEPS else [style.ellipsis, *done[-MOST_STEPS:]]
    return f"{count(steps, 'step')}: <{', '.join(shown)}>"


def split_events(text: str) -> list[str]:
    """The events of ``a, b.1, c.(1, 2)``, with or without ``<`` and ``>`` around them."""
    text = text.strip()
    if text.startswith("<") and text.endswith(">"):
        text = text[1:-1]
    found, depth = [""], 0
    for character in text:
        depth += (character in "({<") - (character in ")}>")
        if character == "," and depth == 0:
            found.append("")
        else:
            found[-1] += character
    return [event.strip() for event in found if event.strip()]


def _number(text: str, otherwise: int, *, least: int = 1) -> int:
    if not text:
        return otherwise
    number = whole_number(text)
    if number is None or number < least:
        raise _Refused(f"`{text}` is not a whole number{' above zero' if least else ''}")
    return number


def _how_many(steps: int) -> str:
    if not steps:
        return "nothing can happen here"
    return "there is only step 1" if steps == 1 else f"there are only steps 1 to {steps:,}"
