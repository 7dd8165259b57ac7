"""The rules of the external functions: chase, deter, prioritisepo and the watchdogs.

``prioritisepo`` looks at what its operand can do next, like any operator. The others look further: along taus to where
their operand settles, or at all states that a trace can lead to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from cspcheck.checker.semantics.steps import Normalise, Row, Step
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import STOP, TERMINATED, External, Process, Watchdog

Rows = Callable[[Process], Row]
"""The transitions of a state."""


def chase(state: Normalise, p: External, rows: Rows) -> list[Step]:
    """``chase(P)``: P's first tau is followed until there is none; nothing else is looked at as long as there is one.

    What P does then is the same as P's behaviour only if the choice of taus makes no difference. A cycle of taus is
    followed for ever.
    """
    end = _chased(p.process, rows)
    if end is None:
        return [(TAU, p)]
    return [(event, _again(p, after, _chased, rows)) for event, after in rows(end)]


def _chased(start: Process, rows: Rows) -> Process | None:
    """Where the first taus lead to; None if nowhere."""
    seen = {start}
    here = start
    while True:
        following = next((after for event, after in rows(here) if event == TAU), None)
        if following is None:
            return here
        if following in seen:
            return None
        seen.add(following)
        here = following


def deter(state: Normalise, p: External, rows: Rows) -> list[Step]:
    """``deter(P)``: a deterministic process that refines P in every model.

    After each trace one of the states is chosen in which P can settle, the first that taus lead to: one that can
    terminate, which is then all that it does, or a stable one, of which one target is kept for each event. Where P
    settles in none, whatever its taus, the result can only diverge as P does, and is then not deterministic in FD.
    (The choice is the one of Lazic's check of determinism: Roscoe, Understanding Concurrent Systems, section 10.5.)
    """
    settled = _settled(p.process, rows)
    if settled is None:
        return [(TAU, p)]
    row = rows(settled)
    if any(event == TICK for event, _ in row):
        return [(TICK, TERMINATED)]
    first: dict[int, Process] = {}
    for event, after in row:
        first.setdefault(event, after)
    return [(event, _again(p, after, _settled, rows)) for event, after in first.items()]


def _settled(start: Process, rows: Rows) -> Process | None:
    """The first state on the ways along taus, depth first, that can tick or is stable; None if there is none."""
    seen = {start}
    pending = [start]
    while pending:
        here = pending.pop()
        events = {event for event, _ in rows(here)}
        if TAU not in events or TICK in events:
            return here
        following = [after for event, after in rows(here) if event == TAU and after not in seen]
        seen.update(following)
        pending.extend(reversed(following))
    return None


def _again(p: External, after: Process, ahead: Callable[[Process, Rows], Process | None], rows: Rows) -> Process:
    """The function applied to what comes after an event, once taus have been followed there; so states are few."""
    if after is TERMINATED or (isinstance(after, External) and after.function == p.function):
        return after
    return p.with_active((ahead(after, rows) or after,))


def prioritise_by_order(p: External, row: Row) -> list[Step]:
    """``prioritisepo(P, A, order, maximal)``: an event gives way to a greater one that is possible in the same state.

    An event of A that is not maximal also gives way to tau and tick. Events outside A are not affected.
    (Roscoe, Understanding Concurrent Systems, chapter 20, the operator Pri; the order has been closed and checked when
    the term was made.)
    """
    events, order, maximal = p.arguments
    possible = {event for event, _ in row}
    urgent = TAU in possible or TICK in possible
    lower = {low for high, low in order if high in possible}  # type: ignore[attr-defined]
    return [
        (event, after if after is TERMINATED else p.with_active((after,)))
        for event, after in row
        if event in (TAU, TICK)
        or event not in events  # type: ignore[operator]
        or (event not in lower and (not urgent or event in maximal))  # type: ignore[operator]
    ]


def begin_watch(state: Normalise, p: External, rows: Rows) -> list[Step]:
    """A watchdog before anything has happened."""
    events, bark = p.arguments
    watching = Watchdog(p.function, _closed((p.process,), rows), events, bark)  # type: ignore[arg-type]
    return watch(state, watching, rows)


def watch(state: Normalise, p: Watchdog, rows: Rows) -> list[Step]:
    r"""``trace_watchdog(P, A, bark)`` and ``failure_watchdog(P, A, bark)``: P as an observer of events of A.

    Both follow an implementation Q in ``Q [|A|] W``, where A must have all of Q's visible events and not *bark*. After
    an event that P does not allow they bark: ``P [T= Q`` exactly if ``Q [|A|] trace_watchdog(P, A, bark)`` never
    barks. The watchdog for failures can moreover, at any time, insist on one event of each set that P must offer then
    (a least choice of such events); if Q refuses them all, nothing can happen any more. ``P [F= Q`` exactly if
    ``Q [|A|] failure_watchdog(P, A, bark)`` never barks and has no deadlock in F. Where P may refuse everything, and
    where it is not insisting, it has an internal step, so that a deadlock of Q alone does not count.
    Termination cannot be watched this way: neither P nor Q should terminate.

    Source: the watchdog transformations of Goldsmith, Moffat, Roscoe, Whitworth and Zakiuddin (FM 2003), whose idea
    this is; which sets of events are insisted on is worked out here from the minimal acceptances of P's normal form.
    """
    after: dict[int, set[Process]] = {}
    acceptances: set[frozenset[int]] = set()
    for member in p.members:
        row = rows(member)
        offered = frozenset(event for event, _ in row)
        for event, target in row:
            if event not in (TAU, TICK):
                after.setdefault(event, set()).add(target)
        if TICK in offered:
            acceptances.add(frozenset())
        elif TAU not in offered:
            acceptances.add(offered)

    def follow(event: int) -> Process:
        return Watchdog(p.function, _closed(after[event], rows), p.events, p.bark)

    if p.insists is not None:
        return [(event, follow(event)) for event in sorted(p.insists)]
    barking = prefix(p.bark, STOP)
    steps: list[Step] = [(event, follow(event) if event in after else barking) for event in p.events]
    if p.function == "failure_watchdog":
        choices = [] if frozenset() in acceptances else _least_choices(acceptances)
        steps += [(TAU, Watchdog(p.function, p.members, p.events, p.bark, choice)) for choice in choices]
        if not choices:
            steps.append((TAU, p))
    return steps


def _closed(states: Iterable[Process], rows: Rows) -> frozenset[Process]:
    """All states that taus lead to from some, these included."""
    seen = set(states)
    pending = list(seen)
    while pending:
        for event, after in rows(pending.pop()):
            if event == TAU and after not in seen:
                seen.add(after)
                pending.append(after)
    return frozenset(seen)


def _least_choices(sets: Iterable[frozenset[int]]) -> list[frozenset[int]]:
    """The least sets that have a member of each of some sets (Berge: one set after another); in a fixed order."""
    choices = [frozenset[int]()]
    for events in sorted(sets, key=sorted):
        more = {choice if choice & events else choice | {event} for choice in choices for event in events}
        choices = [choice for choice in more if not any(other < choice for other in more)]
    return sorted(choices, key=sorted)


FOLLOWING: dict[str, Callable[[Normalise, External, Rows], list[Step]]] = {
    "chase": chase,
    "chase_nocache": chase,
    "deter": deter,
    "trace_watchdog": begin_watch,
    "failure_watchdog": begin_watch,
}
"""The functions whose rules need the transitions of more than the operand."""
