"""Laws of recursion, of the constant processes, and of refinement: Roscoe 1997, sections 1.2, 3.2, 8.2, 8.3 and 9.2."""

from __future__ import annotations

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Chaos, Prefix, Process, Run
from tests.laws.notation import (
    Claim,
    Menu,
    Pairs,
    alphabetised,
    equal,
    external,
    hide,
    interleave,
    internal,
    interrupt,
    law,
    menu_of,
    parallel,
    refined_by,
    rename,
    sequence,
    sliding,
    synchronising_choice,
    synchronising_interrupt,
    throw,
)
from tests.reference.processes import SIGMA, define, recursive


@law()
def a_name_is_its_definition(a: int, b: int, p: Process, q: Process) -> Claim:
    name = recursive(lambda again: external(prefix(a, internal(again, p)), sliding(prefix(b, again), q)))
    return equal(name, name.body())


@law()
def a_guarded_equation_has_one_solution(a: int, b: int, p: Process, q: Process) -> Claim:
    """X = F(X) and Y = F(F(Y)) are the same for F that does something before it comes back."""

    def step(again: Process) -> Process:
        return sliding(external(prefix(a, again), p), internal(q, prefix(b, sequence(SKIP, again))))

    return equal(recursive(step), recursive(lambda again: step(step(again))))


@law()
def mutual_recursion_can_be_folded_into_one(a: int, b: int, p: Process) -> Claim:
    first, _ = define(lambda names: [prefix(a, names[1]), external(prefix(b, names[0]), p)], 2)
    return equal(first, recursive(lambda again: prefix(a, external(prefix(b, again), p))))


@law()
def a_loop_is_a_sequence_that_repeats(a: int, menu: Menu) -> Claim:
    round_ = external(prefix(a, SKIP), Prefix(menu))
    loop = recursive(lambda again: sequence(round_, again))
    return equal(loop, sequence(round_, loop))


@law()
def a_sequence_of_loops_stays_in_the_first(a: int, p: Process) -> Claim:
    loop = recursive(lambda again: prefix(a, again))
    return equal(sequence(loop, p), loop)


@law()
def two_loops_with_nothing_in_common_interleave(a: int, b: int) -> Claim:
    pair = interleave(recursive(lambda again: prefix(a, again)), recursive(lambda again: prefix(b, again)))
    return equal(pair, Run(EventSet.of([a, b])))


@law()
def run_offers_for_ever(x: EventSet) -> Claim:
    return equal(Run(x), menu_of({e: Run(x) for e in x}))


@law()
def chaos_may_stop_at_any_time(x: EventSet) -> Claim:
    return equal(Chaos(x), internal(STOP, menu_of({e: Chaos(x) for e in x})))


@law()
def chaos_within_chaos_is_chaos(x: EventSet, y: EventSet) -> Claim:
    return equal(interleave(Chaos(x), Chaos(y)), Chaos(x | y))


@law()
def chaos_is_the_least_defined_without_divergence_and_termination(menu: Menu) -> Claim:
    """Everything that neither terminates nor diverges refines CHAOS: here, a menu followed by CHAOS again."""
    return refined_by(Chaos(SIGMA), menu_of({e: internal(Run(SIGMA), Chaos(SIGMA)) for e, _ in menu}))


@law("T", "F")
def chaos_is_refined_by_all_that_does_not_terminate(p: Process) -> Claim:
    return refined_by(Chaos(SIGMA), sequence(p, STOP))


@law("T")
def run_has_all_traces(p: Process) -> Claim:
    return refined_by(Run(SIGMA), sequence(p, STOP))


@law()
def run_on_shared_events_leaves_the_partner_alone(x: EventSet, p: Process) -> Claim:
    return equal(parallel(sequence(p, STOP), x, Run(x)), sequence(p, STOP))


@law("FD")
def divergence_is_refined_by_everything(p: Process) -> Claim:
    return refined_by(DIV, p)


@law("T", "F")
def divergence_refines_everything_where_it_is_not_seen(p: Process) -> Claim:
    return refined_by(p, DIV)


@law("T")
def stop_refines_everything_in_traces(p: Process) -> Claim:
    return refined_by(p, STOP)


@law("FD")
def what_follows_a_divergence_makes_no_difference(a: int, p: Process, q: Process) -> Claim:
    return equal(prefix(a, external(DIV, p)), prefix(a, sliding(q, DIV)))


# Every operator is monotonic in each operand: `p |~| q` is refined by `p`, so what is built from it is too.


@law()
def choices_are_monotonic(p: Process, q: Process, r: Process, x: EventSet) -> Claim:
    def built(s: Process) -> Process:
        return internal(external(s, r), sliding(s, r), sliding(r, s), synchronising_choice(s, x, r))

    return refined_by(built(internal(p, q)), built(p))


@law()
def sequence_interrupt_and_throw_are_monotonic(p: Process, q: Process, r: Process, x: EventSet) -> Claim:
    def left(s: Process) -> Process:
        return internal(sequence(s, r), interrupt(s, r), throw(s, x, r), synchronising_interrupt(s, x, r))

    return refined_by(left(internal(p, q)), left(p))


@law()
def sequence_interrupt_and_throw_are_monotonic_on_the_right(p: Process, q: Process, r: Process, x: EventSet) -> Claim:
    def right(s: Process) -> Process:
        return internal(sequence(r, s), interrupt(r, s), throw(r, x, s), synchronising_interrupt(r, x, s))

    return refined_by(right(internal(p, q)), right(p))


@law()
def parallel_is_monotonic(p: Process, q: Process, r: Process, x: EventSet, y: EventSet) -> Claim:
    def built(s: Process) -> Process:
        return internal(parallel(s, x, r), alphabetised(s, x, y, r), interleave(s, r))

    return refined_by(built(internal(p, q)), built(p))


@law()
def hiding_and_renaming_are_monotonic(p: Process, q: Process, x: EventSet, relation: Pairs) -> Claim:
    def built(s: Process) -> Process:
        return internal(hide(s, x), rename(s, relation))

    return refined_by(built(internal(p, q)), built(p))
