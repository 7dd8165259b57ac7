"""Laws of sequence, interrupt and exception: Roscoe 1997, section 6.1 and 6.3; 2010, section 7 (throw, interrupt)."""

from __future__ import annotations

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Prefix, Process
from tests.laws.notation import (
    NONE,
    Claim,
    Menu,
    equal,
    external,
    internal,
    interrupt,
    law,
    menu_of,
    parallel,
    sequence,
    sliding,
    synchronising_interrupt,
    throw,
)
from tests.reference.processes import EVENTS, SIGMA


@law()
def skip_is_the_left_unit_of_sequence(p: Process) -> Claim:
    return equal(sequence(SKIP, p), p)


@law()
def skip_is_the_right_unit_of_sequence(p: Process) -> Claim:
    return equal(sequence(p, SKIP), p)


@law()
def sequence_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(sequence(sequence(p, q), r), sequence(p, sequence(q, r)))


@law()
def sequence_distributes_on_the_left(p: Process, q: Process, r: Process) -> Claim:
    return equal(sequence(internal(p, q), r), internal(sequence(p, r), sequence(q, r)))


@law()
def sequence_distributes_on_the_right(p: Process, q: Process, r: Process) -> Claim:
    return equal(sequence(p, internal(q, r)), internal(sequence(p, q), sequence(p, r)))


@law()
def sequence_steps(menu: Menu, p: Process) -> Claim:
    return equal(sequence(Prefix(menu), p), menu_of({e: sequence(q, p) for e, q in menu}))


@law()
def nothing_follows_stop(p: Process) -> Claim:
    return equal(sequence(STOP, p), STOP)


@law()
def nothing_follows_divergence(p: Process) -> Claim:
    return equal(sequence(DIV, p), DIV)


@law()
def an_offered_termination_may_be_taken_at_once(p: Process, q: Process) -> Claim:
    return equal(sequence(sliding(p, SKIP), q), sliding(sequence(p, q), q))


@law("T")
def sequence_goes_into_external_choice_to_traces(p: Process, q: Process, r: Process) -> Claim:
    return equal(sequence(external(p, q), r), external(sequence(p, r), sequence(q, r)))


@law()
def a_parallel_that_cannot_terminate_is_never_followed(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    both = parallel(sequence(p, STOP), x, q)
    return equal(sequence(both, r), both)


@law()
def stop_is_interrupted_at_once(p: Process) -> Claim:
    return equal(interrupt(STOP, p), p)


@law()
def stop_never_interrupts(p: Process) -> Claim:
    return equal(interrupt(p, STOP), p)


@law()
def interrupt_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(interrupt(interrupt(p, q), r), interrupt(p, interrupt(q, r)))


@law()
def interrupt_distributes_on_the_left(p: Process, q: Process, r: Process) -> Claim:
    return equal(interrupt(internal(p, q), r), internal(interrupt(p, r), interrupt(q, r)))


@law()
def interrupt_steps(menu: Menu, p: Process) -> Claim:
    return equal(interrupt(Prefix(menu), p), external(p, menu_of({e: interrupt(q, p) for e, q in menu})))


@law()
def skip_can_be_interrupted_before_it_terminates(p: Process) -> Claim:
    return equal(interrupt(SKIP, p), external(SKIP, p))


@law()
def termination_interrupts_as_well(menu: Menu) -> Claim:
    interrupted = menu_of({e: interrupt(p, SKIP) for e, p in menu})
    return equal(interrupt(Prefix(menu), SKIP), external(interrupted, SKIP))


@law("FD")
def divergence_is_the_left_zero_of_interrupt(p: Process) -> Claim:
    return equal(interrupt(DIV, p), DIV)


@law("FD")
def divergence_is_the_right_zero_of_interrupt(p: Process) -> Claim:
    return equal(interrupt(p, DIV), DIV)


@law()
def interrupting_without_synchronisation_is_interrupt(p: Process, q: Process) -> Claim:
    return equal(synchronising_interrupt(p, NONE, q), interrupt(p, q))


@law()
def synchronising_interrupt_distributes(p: Process, q: Process, x: EventSet, r: Process) -> Claim:
    return equal(
        synchronising_interrupt(internal(p, q), x, r),
        internal(synchronising_interrupt(p, x, r), synchronising_interrupt(q, x, r)),
    )


@law()
def synchronising_interrupt_steps(menu: Menu, x: EventSet, other: Menu) -> Claim:
    """A synchronised event needs both; any other one of the right operand ends the left one."""
    left, right = dict(menu), dict(other)
    q = Prefix(other)
    branches: dict[int, Process] = {}
    for e in left.keys() | right.keys():
        if e in x:
            if e in left and e in right:
                branches[e] = synchronising_interrupt(left[e], x, right[e])
        elif e in left:
            going_on = synchronising_interrupt(left[e], x, q)
            branches[e] = internal(going_on, right[e]) if e in right else going_on
        else:
            branches[e] = right[e]
    return equal(synchronising_interrupt(Prefix(menu), x, q), menu_of(branches))


@law()
def throwing_at_nothing_never_happens(p: Process, q: Process) -> Claim:
    return equal(throw(p, NONE, q), p)


@law()
def throw_steps(menu: Menu, x: EventSet, p: Process) -> Claim:
    return equal(throw(Prefix(menu), x, p), menu_of({e: p if e in x else throw(q, x, p) for e, q in menu}))


@law()
def throw_distributes_on_the_left(p: Process, q: Process, x: EventSet, r: Process) -> Claim:
    return equal(throw(internal(p, q), x, r), internal(throw(p, x, r), throw(q, x, r)))


@law()
def throw_distributes_on_the_right(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(throw(p, x, internal(q, r)), internal(throw(p, x, q), throw(p, x, r)))


@law()
def throw_goes_into_external_choice(p: Process, q: Process, x: EventSet, r: Process) -> Claim:
    return equal(throw(external(p, q), x, r), external(throw(p, x, r), throw(q, x, r)))


@law()
def the_outer_handler_takes_what_both_catch(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(throw(throw(p, x, q), x, r), throw(p, x, r))


@law()
def termination_is_not_thrown(p: Process, x: EventSet) -> Claim:
    return equal(throw(SKIP, x, p), SKIP)


@law()
def what_never_happens_is_not_thrown(p2: Process, q: Process) -> Claim:
    return equal(throw(p2, EventSet.of([EVENTS[2]]), q), p2)


@law()
def throwing_at_everything_takes_the_first_event_only(menu: Menu, p: Process) -> Claim:
    return equal(throw(Prefix(menu), SIGMA, p), menu_of({e: p for e, _ in menu}))
