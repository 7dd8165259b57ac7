"""Laws of hiding and renaming: Roscoe 1997, sections 3.1 and 3.2."""

from __future__ import annotations

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Prefix, Process, Project, Run
from tests.laws.notation import (
    NONE,
    Claim,
    Menu,
    Pairs,
    alphabetised,
    equal,
    external,
    hide,
    internal,
    interrupt,
    law,
    menu_of,
    parallel,
    rename,
    sequence,
    sliding,
)
from tests.reference.processes import EVENTS, SIGMA, recursive


@law()
def hiding_nothing_changes_nothing(p: Process) -> Claim:
    return equal(hide(p, NONE), p)


@law()
def hiding_twice_is_hiding_the_union(p: Process, x: EventSet, y: EventSet) -> Claim:
    return equal(hide(hide(p, x), y), hide(p, x | y))


@law()
def hidings_commute(p: Process, x: EventSet, y: EventSet) -> Claim:
    return equal(hide(hide(p, x), y), hide(hide(p, y), x))


@law()
def hiding_distributes_over_internal_choice(p: Process, q: Process, x: EventSet) -> Claim:
    return equal(hide(internal(p, q), x), internal(hide(p, x), hide(q, x)))


@law()
def hiding_takes_a_hidden_prefix_away(a: int, p: Process, x: EventSet) -> Claim:
    return equal(hide(prefix(a, p), x), hide(p, x) if a in x else prefix(a, hide(p, x)))


@law()
def hiding_steps(menu: Menu, x: EventSet) -> Claim:
    """What is hidden may happen at any time, and then the rest of the menu is gone."""
    seen = menu_of({e: hide(p, x) for e, p in menu if e not in x})
    unseen = [hide(p, x) for e, p in menu if e in x]
    return equal(hide(Prefix(menu), x), sliding(seen, internal(*unseen)) if unseen else seen)


@law()
def hiding_an_alternative_to_termination_leaves_an_internal_choice(a: int, p: Process, x: EventSet) -> Claim:
    hidden = x | EventSet.of([a])
    return equal(hide(external(SKIP, prefix(a, p)), hidden), internal(SKIP, hide(p, hidden)))


@law()
def hiding_goes_into_parallel_past_the_shared_events(p: Process, x: EventSet, q: Process, y: EventSet) -> Claim:
    hidden = y - x
    return equal(hide(parallel(p, x, q), hidden), parallel(hide(p, hidden), x, hide(q, hidden)))


@law()
def hiding_goes_into_alphabetised_parallel_past_the_common_events(
    p: Process, x: EventSet, y: EventSet, q: Process, z: EventSet
) -> Claim:
    hidden = z - (x & y)
    return equal(
        hide(alphabetised(p, x, y, q), hidden),
        alphabetised(hide(p, hidden & x), x, y, hide(q, hidden & y)),
    )


@law()
def hiding_goes_into_sequence(p: Process, q: Process, x: EventSet) -> Claim:
    return equal(hide(sequence(p, q), x), sequence(hide(p, x), hide(q, x)))


@law("T")
def hiding_goes_into_external_choice_to_traces(p: Process, q: Process, x: EventSet) -> Claim:
    return equal(hide(external(p, q), x), external(hide(p, x), hide(q, x)))


@law()
def hiding_leaves_termination(x: EventSet) -> Claim:
    return equal(hide(SKIP, x), SKIP)


@law()
def hiding_what_never_happens_changes_nothing(p2: Process) -> Claim:
    return equal(hide(p2, EventSet.of([EVENTS[2]])), p2)


@law()
def projecting_is_hiding_the_rest(p: Process, x: EventSet) -> Claim:
    return equal(Project(p, x), hide(p, SIGMA - x))


@law()
def hidden_chatter_diverges(a: int, x: EventSet) -> Claim:
    loop = recursive(lambda again: prefix(a, again))
    return equal(hide(loop, x), DIV if a in x else loop)


@law("FD")
def hidden_run_diverges(a: int, x: EventSet) -> Claim:
    hidden = x | EventSet.of([a])
    return equal(hide(Run(SIGMA), hidden), DIV)


@law("FD")
def divergence_stays_when_hidden(p: Process, x: EventSet) -> Claim:
    return equal(hide(external(DIV, p), x), DIV)


@law()
def renaming_everything_to_itself_changes_nothing(p: Process) -> Claim:
    return equal(rename(p, tuple((e, e) for e in EVENTS)), p)


@law()
def renaming_twice_is_renaming_by_the_composition(p: Process, relation: Pairs, second: Pairs) -> Claim:
    def images(e: int, pairs: Pairs) -> list[int]:
        return [new for old, new in pairs if old == e] or [e]

    composed = tuple((e, after) for e in EVENTS for between in images(e, relation) for after in images(between, second))
    return equal(rename(rename(p, relation), second), rename(p, composed))


@law()
def renaming_distributes_over_internal_choice(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(internal(p, q), relation), internal(rename(p, relation), rename(q, relation)))


@law()
def renaming_distributes_over_external_choice(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(external(p, q), relation), external(rename(p, relation), rename(q, relation)))


@law()
def renaming_distributes_over_sliding_choice(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(sliding(p, q), relation), sliding(rename(p, relation), rename(q, relation)))


@law()
def renaming_goes_into_sequence(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(sequence(p, q), relation), sequence(rename(p, relation), rename(q, relation)))


@law()
def renaming_goes_into_interrupt(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(interrupt(p, q), relation), interrupt(rename(p, relation), rename(q, relation)))


@law()
def renaming_steps(menu: Menu, relation: Pairs) -> Claim:
    """Events that get one name become indistinguishable; an event that gets two names offers both."""
    following: dict[int, list[Process]] = {}
    for e, p in menu:
        for new in [new for old, new in relation if old == e] or [e]:
            following.setdefault(new, []).append(rename(p, relation))
    return equal(rename(Prefix(menu), relation), menu_of({e: internal(*ps) for e, ps in following.items()}))


@law()
def renaming_leaves_termination_and_deadlock(relation: Pairs) -> Claim:
    return equal(internal(rename(SKIP, relation), rename(STOP, relation)), internal(SKIP, STOP))


@law()
def renaming_there_and_back_changes_nothing(p: Process, bijection: Pairs) -> Claim:
    return equal(rename(rename(p, bijection), tuple((new, old) for old, new in bijection)), p)


@law()
def hiding_goes_into_bijective_renaming(p: Process, bijection: Pairs, x: EventSet) -> Claim:
    image = EventSet.of(dict(bijection)[e] for e in x)
    return equal(hide(rename(p, bijection), image), rename(hide(p, x), bijection))
