"""What the page of the explorer asks, answered as plain data.

A place is a *root* (a process expression, or ``@3`` for what the assertion number 3 is about) and a *way*: the numbers
of the steps taken from there. Both stand in the address of the page, so that a place can be shared; nothing about a
visitor is kept here but caches.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

from cspcheck import checking
from cspcheck.checker.budget import OUT_OF_MEMORY, why
from cspcheck.checker.explain.blocked_slots import shortest_cycle
from cspcheck.checker.explain.running import Performed
from cspcheck.checker.guard import Guard
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.process.text import describe
from cspcheck.cspm.script import Script
from cspcheck.drawing import parts, sequence, svg
from cspcheck.probing import NoSuchStep, Probe, step_name
from cspcheck.report.full import explain
from cspcheck.report.sentences import circle_sentence
from cspcheck.result import Result

KEPT = 200
"""So many places are kept ready."""
MOST_STEPS = 400
"""So many possible steps are told."""
TERM = 2_000
"""Characters of a state that are told."""


class Unanswerable(Exception):
    """A question that makes no sense here; the message says why."""


class Explorer:
    """A script that is explored. One question is answered at a time.

    Args:
        script: the script.
        settings: limits of the checks.
        first: the process that is shown at first.
    """

    def __init__(self, script: Script, settings: checking.Settings, first: str | None = None) -> None:
        self._settings = settings
        self._first = first
        self._lock = threading.Lock()
        self._begin(script)

    def _begin(self, script: Script) -> None:
        """Have nothing but a script."""
        self._script = script
        self._checker = checking.checker_for(script, self._settings, checking.NoWatch())
        self._probes: OrderedDict[tuple[str, tuple[int, ...]], Probe] = OrderedDict()
        self._results: dict[int, Result] = {}
        self._numbers: dict[str, dict[Process, int]] = {}

    def answer(self, question: str, arguments: dict[str, str]) -> dict[str, Any]:
        """The answer to a question of the page.

        Raises:
            Unanswerable: there is none.
        """
        questions: dict[str, Callable[[dict[str, str]], dict[str, Any]]] = {
            "script": self._of_script,
            "place": self._of_place,
            "check": self._of_assertion,
            "machine": self._of_machine,
            "architecture": self._of_architecture,
            "perform": self._of_event,
            "walk": self._of_walk,
        }
        if question not in questions:
            raise Unanswerable(f"there is no question `{question}`")
        limits = self._settings.limits
        guard = Guard(limits.seconds, limits.memory_bytes)
        with self._lock:
            try:
                # A check looks at its limits itself, and has a result when it reaches one.
                if question == "check":
                    return questions[question](arguments)
                return guard.run(lambda: questions[question](arguments))
            except ScriptError as error:
                raise Unanswerable("; ".join(d.message for d in error.diagnostics)) from None
            except Stopped as stopped:
                reason = why(guard, limits, stopped)
            except MemoryError:
                reason = OUT_OF_MEMORY
            # What was half done is of no use to anybody.
            self._begin(self._script.again())
        raise Unanswerable(reason)

    # --- the script ------------------------------------------------------------------------------------------

    def _of_script(self, arguments: dict[str, str]) -> dict[str, Any]:
        source = self._script.source
        return {
            "name": source.name,
            "source": source.text,
            "first": self._first or (self._processes() or ["STOP"])[-1],
            "processes": self._processes(),
            "assertions": [
                {
                    "number": i,
                    "text": assertion.text,
                    "line": assertion.span.line,
                    "expected": assertion.expected or "pass",
                    "verdict": str(self._results[i].verdict) if i in self._results else None,
                }
                for i, assertion in enumerate(self._script.assertions)
            ],
        }

    def _processes(self) -> list[str]:
        """The names of the script that are processes without arguments."""
        from cspcheck.cspm.typing.types import PROC, resolve

        types = self._script.types
        if types is None:
            return []
        found = []
        for symbol in types.declared:
            scheme = types.scheme(symbol)
            if resolve(scheme.type) is PROC and not symbol.name.endswith("%") and symbol.owner is None:
                found.append(symbol.name)
        return found

    # --- places ----------------------------------------------------------------------------------------------

    def _root(self, text: str) -> tuple[str, Process, Sequence[tuple[int, Process]]]:
        """The title and the process of a root, and a run of it that is of interest."""
        if text.startswith("@"):
            result = self._checked(_number(text[1:]))
            run = None if result.counterexample is None else result.counterexample.run
            if run is not None:
                return result.assertion, run.process, run.steps
            text = result.process
        return text, self._script.process(text), ()

    def _probe(self, root: str, way: tuple[int, ...]) -> Probe:
        """A probe at a place; one of its own, since probes move."""
        known = self._probes.get((root, way))
        if known is None:
            known = self._probed(root, way)
            self._probes[root, way] = known
            while len(self._probes) > KEPT:
                self._probes.popitem(last=False)
        self._probes.move_to_end((root, way))
        return known

    def _probed(self, root: str, way: tuple[int, ...]) -> Probe:
        """A probe that has gone a way, from the last place on it that is known."""
        taken = next((taken for taken in range(len(way) - 1, -1, -1) if (root, way[:taken]) in self._probes), None)
        if taken is None:
            taken = 0
            _, process, run = self._root(root)
            probe = Probe(process, self._script.events, run=run)
        else:
            probe = self._probes[root, way[:taken]].copy()
        for number in way[taken:]:
            steps = probe.steps()
            if not 0 < number <= len(steps):
                raise Unanswerable(f"the way of the address ends after {taken}: there is no step {number}")
            probe.take(steps[number - 1])
            taken += 1
        return probe

    def _of_place(self, arguments: dict[str, str]) -> dict[str, Any]:
        root, way = arguments.get("root", "STOP"), _way(arguments.get("way", ""))
        probe = self._probe(root, way)
        before = dict(self._states(self._probe(root, way[:-1]))) if way else {}
        waits = probe.waiting()
        names = {component: name for name, component, _ in probe.components()}
        steps = probe.steps()
        following = probe.next_of_run()
        circle = None if steps else self._circle(probe)
        data = [{name: dict(values) for name, values in point.items()} for point in probe.data()]
        return {
            "title": root if not root.startswith("@") else self._root(root)[0],
            "state": self._text(probe.here.state),
            "number": self._numbers.get(root, {}).get(probe.here.state),
            "terminated": probe.has_terminated,
            "trace": [self._performed(probe, performed, names) for performed in probe.trace()],
            "components": [
                {
                    "name": name,
                    "line": component.span.line if component.span is not None else None,
                    "file": component.span.source.name if component.span is not None else None,
                    "state": self._text(state),
                    "data": data[-1].get(name, {}),
                    "changed": bool(way) and before.get(name) != self._text(state),
                    "offers": self._offers(probe, state),
                    "waits": [names.get(other, other.name) for other in waits.get(component, ())],
                }
                for name, component, state in probe.components()
            ],
            "circle": circle,
            "data": data,
            "steps": [
                {
                    "number": step.number,
                    **self._performed(probe, probe.performed(step), names),
                    "next": following is not None and following.number == step.number,
                }
                for step in steps[:MOST_STEPS]
            ],
            "more": max(0, len(steps) - MOST_STEPS),
        }

    def _circle(self, probe: Probe) -> str | None:
        """Who waits for whom in a circle, in a sentence."""
        components = probe.components()
        number = {component: i for i, (_, component, _) in enumerate(components)}
        waits = probe.surely_waiting()
        cycle = shortest_cycle({number[one]: {number[other] for other in others} for one, others in waits.items()})
        return None if cycle is None else circle_sentence([components[i][0] for i in cycle])

    def _states(self, probe: Probe) -> list[tuple[str, str]]:
        return [(name, self._text(state)) for name, _, state in probe.components()]

    def _text(self, state: Process) -> str:
        return describe(state, self._script.events, width=TERM)

    def _offers(self, probe: Probe, state: Process) -> list[str]:
        return [self._script.events.name(event) for event in probe.offers(state)]

    def _performed(self, probe: Probe, performed: Performed, names: dict[Any, str]) -> dict[str, Any]:
        return {
            "event": step_name(self._script.events, performed),
            "parts": [
                {"name": names.get(component, component.name), "event": self._script.events.name(event)}
                for component, event in performed.parts.items()
            ],
        }

    def _of_event(self, arguments: dict[str, str]) -> dict[str, Any]:
        """The way to an event that is typed, through internal steps."""
        root, way = arguments.get("root", "STOP"), _way(arguments.get("way", ""))
        return {"way": self._moved(root, way, lambda probe: probe.perform(arguments.get("event", "")))}

    def _of_walk(self, arguments: dict[str, str]) -> dict[str, Any]:
        """The way of a random walk."""
        root, way = arguments.get("root", "STOP"), _way(arguments.get("way", ""))
        steps, seed = min(_number(arguments.get("steps", "10")), 1_000), _number(arguments.get("seed", "0"))
        return {"way": self._moved(root, way, lambda probe: probe.walk(steps, seed))}

    def _moved(self, root: str, way: tuple[int, ...], move: Callable[[Probe], object]) -> list[int]:
        probe = self._probe(root, way).copy()
        start = len(probe.way)
        try:
            move(probe)
        except NoSuchStep as error:
            raise Unanswerable(str(error)) from None
        taken = [
            (point.performed.event, point.running.state) for point in probe.way[start:] if point.performed is not None
        ]
        return [*way, *self._numbers_of(self._probe(root, way), taken)]

    def _numbers_of(self, probe: Probe, steps: Sequence[tuple[int, Process]]) -> list[int]:
        """The numbers of steps that are known by their events and what comes after."""
        probe = probe.copy()
        found = []
        for event, after in steps:
            step = next(s for s in probe.steps() if (s.event, s.after) == (event, after))
            probe.take(step)
            found.append(step.number)
        return found

    # --- assertions ------------------------------------------------------------------------------------------

    def _checked(self, number: int) -> Result:
        if not 0 <= number < len(self._script.assertions):
            raise Unanswerable(f"there is no assertion {number}")
        if number not in self._results:
            self._results[number] = checking.check(self._checker, self._script.assertions[number])
        return self._results[number]

    def _of_assertion(self, arguments: dict[str, str]) -> dict[str, Any]:
        number = _number(arguments.get("number", ""))
        result = self._checked(number)
        found: dict[str, Any] = {
            "number": number,
            "verdict": str(result.verdict),
            "expected": str(result.expected),
            "text": explain(result),
            "states": result.states,
            "transitions": result.transitions,
            "seconds": round(result.seconds, 3),
            "way": None,
            "chart": None,
        }
        if result.counterexample is not None:
            if result.counterexample.run is not None:
                steps = result.counterexample.run.steps
                found["way"] = self._numbers_of(self._probe(f"@{number}", ()), steps)
            if result.counterexample.kind != "obligation":
                found["chart"] = sequence.render(result.assertion, result.counterexample)
        return found

    # --- pictures --------------------------------------------------------------------------------------------

    def _of_machine(self, arguments: dict[str, str]) -> dict[str, Any]:
        root = arguments.get("root", "STOP")
        title, process, _ = self._root(root)
        picture, terms = parts.numbered_machine(title, process, self._script.events)
        self._numbers[root] = {term: i for i, term in enumerate(terms)}
        number = self._numbers[root].get(self._probe(root, _way(arguments.get("way", ""))).here.state)
        return {"svg": svg.render(picture), "number": number}

    def _of_architecture(self, arguments: dict[str, str]) -> dict[str, Any]:
        title, process, _ = self._root(arguments.get("root", "STOP"))
        return {"svg": svg.render(parts.architecture(title, process, self._script.events))}


def _number(text: str) -> int:
    if not (text.isascii() and text.isdecimal() and len(text) < 10):
        raise Unanswerable(f"`{text}` is no number")
    return int(text)


def _way(text: str) -> tuple[int, ...]:
    return tuple(_number(part) for part in text.split(".") if part)
