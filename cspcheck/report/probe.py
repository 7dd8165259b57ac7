"""A probed process as text: the components, what can happen next, and the way there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from cspcheck.checker.explain.blocked_slots import shortest_cycle
from cspcheck.checker.explain.running import Performed, RunningComponent, is_composed
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.process.text import describe
from cspcheck.probing import Probe, ProbeStep, step_name
from cspcheck.quantities import count
from cspcheck.report.sentences import circle_sentence
from cspcheck.report.style import Style, columns, harmless, pad, wrapped

MOST_STEPS = 20
"""So many possible steps are shown unless all are asked for."""
WHOLE_TERM = 4_000
"""Characters of a state that is shown by itself."""
_NARROWEST = 16


def show_point(probe: Probe, style: Style, *, everything: bool = False, beside: Sequence[tuple[str, str]] = ()) -> str:
    """Where the process is and what it can do.

    Args:
        probe: the process.
        style: how it looks.
        everything: nothing is folded or cut.
        beside: names and states of what is shown under the components (the specification).
    """
    lines = [
        _where(probe, style),
        *_components(probe, style, everything, beside),
        "",
        *_steps(probe, style, everything),
    ]
    return "\n".join(lines) + "\n"


def show_trace(probe: Probe, style: Style) -> str:
    """The way so far, a row a step."""
    done = probe.trace()
    if not done:
        return "nothing has happened yet\n"
    names = _Names(probe)
    texts = [harmless(step_name(probe.events, performed)) for performed in done]
    width = max(map(columns, texts))
    digits = len(str(len(done)))
    data = probe.data()
    rows = []
    for i, (text, performed) in enumerate(zip(texts, done, strict=True), 1):
        who = "; ".join([t for t in (names.parts(performed), *_changes(data[i - 1], data[i], names.alone)) if t])
        row = f"  {i:>{digits}}  {pad(text, width)}  {style.paint(harmless(who), 'dim')}"
        rows.append(row.rstrip())
    return "\n".join(rows) + "\n"


def show_term(probe: Probe, name: str | None, style: Style) -> str | None:
    """The whole state as a process expression, or that of one component; None if there is no such component."""
    if name is None:
        return harmless(describe(probe.here.state, probe.events, width=WHOLE_TERM)) + "\n"
    for own, component, state in probe.components():
        if name in (own, component.name):
            place = f" ({component.span.source.name}:{component.span.line})" if component.span is not None else ""
            text = harmless(describe(state, probe.events, width=WHOLE_TERM))
            return f"{style.paint(harmless(own), 'bold')}{place}\n  {text}\n"
    return None


def _changes(
    before: Mapping[str, Mapping[str, str]], after: Mapping[str, Mapping[str, str]], alone: bool
) -> Iterator[str]:
    """What the variables of classes are after a step, where they have changed in it."""
    for name, variables in after.items():
        old = before.get(name, {})
        new = {variable: value for variable, value in variables.items() if old.get(variable) != value}
        if new:
            yield _values(new) if alone else f"{name}: {_values(new)}"


class _Names:
    """The names of components, also of those that have been left behind."""

    def __init__(self, probe: Probe) -> None:
        self._probe = probe
        self._here = {component: name for name, component, _ in probe.components()}
        self.alone = len(self._here) == 1

    def of(self, component: RunningComponent) -> str:
        return self._here.get(component, component.name)

    def parts(self, performed: Performed) -> str:
        """Who takes part in a step, each with the own name of the event where it is another."""
        if self.alone and len(performed.parts) == 1 and set(performed.parts) == set(self._here):
            return ""
        shown = {performed.event, performed.cause}
        names = []
        for component, own in performed.parts.items():
            name = self.of(component)
            names.append(name if own in shown else f"{name} ({self._probe.events.name(own)})")
        return harmless(", ".join(names))


def _where(probe: Probe, style: Style) -> str:
    done = [step_name(probe.events, performed) for performed in probe.trace()]
    if not done:
        return style.paint("at the start", "bold")
    words = ", ".join(done)
    room = style.width - len("after <>") - len(str(len(done))) - 12
    # The end of the way is what matters.
    while columns(words) > room and ", " in words:
        words = words.partition(", ")[2]
    folded = "" if columns(words) == columns(", ".join(done)) else f"{style.ellipsis} "
    return style.paint(f"after {count(len(done), 'step')}", "bold") + f"  <{folded}{harmless(words)}>"


def _state(probe: Probe, state: Process, variables: Mapping[str, str]) -> str:
    """A state as a process expression; of the data of a class the values of its variables."""
    if not variables:
        return describe(state, probe.events)
    values = _values(variables)
    return f"{values}; {describe(state, probe.events)}" if is_composed(state) else values


def _values(variables: Mapping[str, str]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in variables.items())


def _components(probe: Probe, style: Style, everything: bool, beside: Sequence[tuple[str, str]]) -> list[str]:
    waits = probe.waiting()
    names = _Names(probe)
    data = probe.data()[-1]
    rows = [
        (
            name,
            _state(probe, state, data.get(name, {})),
            ", ".join(names.of(other) for other in waits.get(component, ())),
        )
        for name, component, state in probe.components()
    ]
    rows += [(name, text, "") for name, text in beside]
    heads = ("component", "state", "waits for")
    cells = [[harmless(cell) for cell in row] for row in rows]
    kept = [0, 1, 2] if any(row[2] for row in rows) else [0, 1]
    widths = {i: max(columns(row[i]) for row in [*cells, list(heads)]) for i in kept}
    while not everything and sum(widths.values()) > style.width - 2 - 2 * len(kept):
        able = [i for i in kept if widths[i] > _NARROWEST]
        if not able:
            break
        widths[max(able, key=lambda i: (widths[i], i))] -= 1
    lines = ["", "  " + style.paint("  ".join(pad(heads[i], widths[i]) for i in kept).rstrip(), "dim")]
    for row in cells:
        shown = [row[i] if everything else style.fit(row[i], widths[i]) for i in kept]
        lines.append(("  " + "  ".join(pad(text, widths[i]) for text, i in zip(shown, kept, strict=True))).rstrip())
    return lines


def _steps(probe: Probe, style: Style, everything: bool) -> list[str]:
    steps = probe.steps()
    if not steps:
        return _nothing(probe, style)
    shown = steps if everything else steps[:MOST_STEPS]
    wanted = probe.next_of_run()
    if wanted is not None and wanted not in shown:
        shown = [*shown, wanted]
    names = _Names(probe)
    done = [probe.performed(step) for step in shown]
    texts = [harmless(step_name(probe.events, performed)) for performed in done]
    who = [names.parts(performed) for performed in done]
    alike = _alike(shown, texts, who)
    width = max(map(columns, texts))
    digits = len(str(shown[-1].number))
    arrow = "→" if style.unicode else ">"
    lines = []
    for step, text, actors in zip(shown, texts, who, strict=True):
        mark = arrow if wanted is not None and step == wanted else " "
        number = style.paint(f"{step.number:>{digits}}", "bold")
        row = f"{mark} {number}  {pad(text, width)}  {style.paint(actors, 'dim')}"
        if step.number in alike:
            row = row.rstrip() + "  " + _then(probe, step)
        lines.append(row.rstrip() if everything or style.color else style.fit(row.rstrip(), style.width))
    if len(shown) < len(steps):
        lines.append(f"  {style.ellipsis} {count(len(steps) - len(shown), 'step')} more; `all` shows them")
    return lines


def _alike(steps: Sequence[ProbeStep], texts: Sequence[str], who: Sequence[str]) -> set[int]:
    """The numbers of steps that look the same and lead to different states."""
    met: dict[tuple[str, str], list[int]] = {}
    for step, text, actors in zip(steps, texts, who, strict=True):
        met.setdefault((text, actors), []).append(step.number)
    return {number for numbers in met.values() if len(numbers) > 1 for number in numbers}


def _then(probe: Probe, step: ProbeStep) -> str:
    """What the components that take part in a step become."""
    after = probe.after(step)
    before = dict(probe.here.components())
    changed = [state for component, state in after.components() if before.get(component) is not state]
    return harmless("then " + ", ".join(describe(state, probe.events, width=40) for state in changed or [after.state]))


def _nothing(probe: Probe, style: Style) -> list[str]:
    if probe.has_terminated:
        return ["it has terminated"]
    components = [component for _, component, _ in probe.components()]
    number = {component: i for i, component in enumerate(components)}
    waits = probe.surely_waiting()
    cycle = shortest_cycle({number[one]: {number[other] for other in others} for one, others in waits.items()})
    lines = [style.paint("deadlock", "bold", "red") + ": nothing can happen, and it has not terminated"]
    if cycle is not None:
        names = _Names(probe)
        lines += wrapped(circle_sentence([names.of(components[i]) for i in cycle]), style.width)
    return lines
