"""Laws of the choices: Roscoe 1997, chapters 1, 2 and 4, and section 8.4 for what differs between the models."""

from __future__ import annotations

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Prefix, Process, SynchronisingChoice
from tests.laws.notation import (
    NONE,
    Claim,
    Menu,
    equal,
    external,
    internal,
    law,
    menu_of,
    refined_by,
    sliding,
    synchronising_choice,
)


@law()
def external_choice_is_idempotent(p: Process) -> Claim:
    return equal(external(p, p), p)


@law()
def external_choice_is_symmetric(p: Process, q: Process) -> Claim:
    return equal(external(p, q), external(q, p))


@law()
def external_choice_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(external(p, external(q, r)), external(external(p, q), r))


@law()
def external_choice_of_three_is_that_of_two(p: Process, q: Process, r: Process) -> Claim:
    return equal(external(p, q, r), external(external(p, q), r))


@law()
def stop_is_the_unit_of_external_choice(p: Process) -> Claim:
    return equal(external(p, STOP), p)


@law()
def external_choice_distributes_over_internal(p: Process, q: Process, r: Process) -> Claim:
    return equal(external(p, internal(q, r)), internal(external(p, q), external(p, r)))


@law()
def internal_choice_distributes_over_external(p: Process, q: Process, r: Process) -> Claim:
    return equal(internal(p, external(q, r)), external(internal(p, q), internal(p, r)))


@law()
def external_choice_steps(menu: Menu, other: Menu) -> Claim:
    """An event that both menus have leaves it open which of the two it was."""
    left, right = dict(menu), dict(other)
    both = {e: internal(left[e], right[e]) for e in left.keys() & right.keys()}
    return equal(external(Prefix(menu), Prefix(other)), menu_of({**left, **right, **both}))


@law()
def external_choice_with_skip_can_withdraw_everything_else(p: Process) -> Claim:
    return equal(external(p, SKIP), sliding(p, SKIP))


@law()
def sliding_from_skip_is_an_internal_choice(p: Process) -> Claim:
    """Tick is signalled: that a tau can take it away does not keep the process from insisting on it."""
    return equal(sliding(SKIP, p), internal(SKIP, p))


@law("F")
def termination_beside_divergence_is_termination_where_divergence_is_not_seen(p: Process) -> Claim:
    return equal(internal(p, external(SKIP, DIV)), internal(p, SKIP))


@law()
def internal_choice_is_idempotent(p: Process) -> Claim:
    return equal(internal(p, p), p)


@law()
def internal_choice_is_symmetric(p: Process, q: Process) -> Claim:
    return equal(internal(p, q), internal(q, p))


@law()
def internal_choice_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(internal(p, internal(q, r)), internal(p, q, r))


@law()
def prefix_distributes_over_internal_choice(a: int, p: Process, q: Process) -> Claim:
    return equal(prefix(a, internal(p, q)), internal(prefix(a, p), prefix(a, q)))


@law()
def the_same_event_twice_is_a_choice_after_it(a: int, p: Process, q: Process) -> Claim:
    return equal(external(prefix(a, p), prefix(a, q)), prefix(a, internal(p, q)))


@law("T")
def the_choices_are_the_same_to_traces(p: Process, q: Process) -> Claim:
    return equal(internal(p, q), external(p, q))


@law()
def internal_choice_is_refined_by_each_operand(p: Process, q: Process) -> Claim:
    return refined_by(internal(p, q), p)


@law()
def internal_choice_is_refined_by_sliding_choice(p: Process, q: Process) -> Claim:
    return refined_by(internal(p, q), sliding(p, q))


@law()
def sliding_choice_is_refined_by_external_choice(p: Process, q: Process) -> Claim:
    return refined_by(sliding(p, q), external(p, q))


@law("FD")
def divergence_is_the_zero_of_external_choice(p: Process) -> Claim:
    return equal(external(p, DIV), DIV)


@law("FD")
def divergence_is_the_zero_of_internal_choice(p: Process) -> Claim:
    return equal(internal(p, DIV), DIV)


@law("T", "F")
def divergence_is_the_unit_of_internal_choice_where_it_is_not_seen(p: Process) -> Claim:
    return equal(internal(p, DIV), p)


@law()
def sliding_choice_is_defined_by_the_others(p: Process, q: Process) -> Claim:
    return equal(sliding(p, q), external(internal(p, STOP), q))


@law()
def sliding_choice_is_an_offer_that_may_be_withdrawn(p: Process, q: Process) -> Claim:
    return equal(sliding(p, q), internal(external(p, q), q))


@law()
def sliding_choice_is_idempotent(p: Process) -> Claim:
    return equal(sliding(p, p), p)


@law()
def sliding_choice_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(sliding(p, sliding(q, r)), sliding(sliding(p, q), r))


@law()
def what_slides_twice_is_offered_together(p: Process, q: Process, r: Process) -> Claim:
    return equal(sliding(sliding(p, q), r), sliding(external(p, q), r))


@law()
def nothing_slides_to_a_process(p: Process) -> Claim:
    return equal(sliding(STOP, p), p)


@law()
def sliding_to_nothing_may_be_nothing(p: Process) -> Claim:
    return equal(sliding(p, STOP), internal(p, STOP))


@law()
def sliding_choice_distributes_on_the_left(p: Process, q: Process, r: Process) -> Claim:
    return equal(sliding(internal(p, q), r), internal(sliding(p, r), sliding(q, r)))


@law()
def sliding_choice_distributes_on_the_right(p: Process, q: Process, r: Process) -> Claim:
    return equal(sliding(p, internal(q, r)), internal(sliding(p, q), sliding(p, r)))


@law()
def synchronising_on_nothing_is_external_choice(p: Process, q: Process) -> Claim:
    return equal(synchronising_choice(p, NONE, q), external(p, q))


@law()
def synchronising_choice_is_symmetric(p: Process, x: EventSet, q: Process) -> Claim:
    return equal(synchronising_choice(p, x, q), synchronising_choice(q, x, p))


@law()
def synchronising_choice_is_associative_over_one_set(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(
        synchronising_choice(synchronising_choice(p, x, q), x, r),
        synchronising_choice(p, x, synchronising_choice(q, x, r)),
    )


@law()
def synchronising_choice_of_three_is_that_of_two(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(SynchronisingChoice(x, (p, q, r)), synchronising_choice(synchronising_choice(p, x, q), x, r))


@law()
def synchronising_choice_distributes_over_internal(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(
        synchronising_choice(p, x, internal(q, r)),
        internal(synchronising_choice(p, x, q), synchronising_choice(p, x, r)),
    )


@law()
def synchronising_choice_steps(menu: Menu, x: EventSet, other: Menu) -> Claim:
    """A synchronised event needs both and keeps the choice open; any other one makes it."""
    left, right = dict(menu), dict(other)
    both = left.keys() & right.keys()
    branches = {e: synchronising_choice(left[e], x, right[e]) for e in both if e in x}
    branches |= {e: internal(left[e], right[e]) for e in both if e not in x}
    branches |= {e: p for e, p in (*menu, *other) if e not in both and e not in x}
    return equal(synchronising_choice(Prefix(menu), x, Prefix(other)), menu_of(branches))
