"""Laws of the parallel operators and of termination within them: Roscoe 1997, sections 2.1 to 2.5 and 6.2."""

from __future__ import annotations

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    AlphabetisedParallel,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Run,
)
from tests.laws.notation import (
    NONE,
    Claim,
    Menu,
    Pairs,
    alphabetised,
    equal,
    hide,
    interleave,
    internal,
    law,
    menu_of,
    parallel,
    rename,
    sequence,
)
from tests.reference.processes import SIGMA, C


@law()
def parallel_is_symmetric(p: Process, x: EventSet, q: Process) -> Claim:
    return equal(parallel(p, x, q), parallel(q, x, p))


@law()
def parallel_is_associative_over_one_set(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(parallel(parallel(p, x, q), x, r), parallel(p, x, parallel(q, x, r)))


@law()
def parallel_of_three_is_that_of_two(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(Parallel(x, (p, q, r)), parallel(parallel(p, x, q), x, r))


@law()
def parallel_distributes_over_internal_choice(p: Process, x: EventSet, q: Process, r: Process) -> Claim:
    return equal(parallel(p, x, internal(q, r)), internal(parallel(p, x, q), parallel(p, x, r)))


@law()
def parallel_steps(menu: Menu, x: EventSet, other: Menu) -> Claim:
    """Shared events together, the others one at a time; whose it was stays open where both can."""
    left, right = dict(menu), dict(other)
    p, q = Prefix(menu), Prefix(other)
    branches: dict[int, Process] = {}
    for e in left.keys() | right.keys():
        if e in x:
            if e in left and e in right:
                branches[e] = parallel(left[e], x, right[e])
        else:
            ways = [parallel(left[e], x, q)] if e in left else []
            ways += [parallel(p, x, right[e])] if e in right else []
            branches[e] = internal(*ways)
    return equal(parallel(p, x, q), menu_of(branches))


@law()
def different_shared_events_block_each_other(a: int, b: int, p: Process, q: Process) -> Claim:
    both = parallel(prefix(a, p), EventSet.of([a, b]), prefix(b, q))
    return equal(both, prefix(a, parallel(p, EventSet.of([a, b]), q)) if a == b else STOP)


@law("T")
def lockstep_with_itself_is_itself_to_traces(p: Process) -> Claim:
    return equal(parallel(p, SIGMA, p), p)


@law("T")
def lockstep_with_stop_is_stop_to_traces(p: Process) -> Claim:
    return equal(parallel(p, SIGMA, STOP), STOP)


@law()
def lockstep_with_run_takes_termination_away(p: Process) -> Claim:
    return equal(parallel(p, SIGMA, Run(SIGMA)), sequence(p, STOP))


@law("FD")
def divergence_is_the_zero_of_parallel(p: Process, x: EventSet) -> Claim:
    return equal(parallel(p, x, DIV), DIV)


@law("FD")
def divergence_is_the_zero_of_alphabetised_parallel(p: Process, x: EventSet, y: EventSet) -> Claim:
    return equal(alphabetised(DIV, x, y, p), DIV)


@law()
def interleaving_is_symmetric(p: Process, q: Process) -> Claim:
    return equal(interleave(p, q), interleave(q, p))


@law()
def interleaving_is_associative(p: Process, q: Process, r: Process) -> Claim:
    return equal(interleave(interleave(p, q), r), interleave(p, interleave(q, r)))


@law()
def skip_is_the_unit_of_interleaving(p: Process) -> Claim:
    return equal(interleave(p, SKIP), p)


@law()
def stop_in_interleaving_takes_termination_away(p: Process) -> Claim:
    return equal(interleave(p, STOP), sequence(p, STOP))


@law()
def termination_is_distributed(p: Process, q: Process, r: Process) -> Claim:
    """What follows begins when both are done, whichever was done first."""
    return equal(sequence(interleave(p, q), r), sequence(interleave(q, interleave(SKIP, p)), r))


@law()
def skips_terminate_together(x: EventSet) -> Claim:
    return equal(parallel(SKIP, x, SKIP), SKIP)


@law()
def a_terminated_partner_forbids_the_shared_events(a: int, p: Process, x: EventSet) -> Claim:
    left = parallel(prefix(a, p), x, SKIP)
    return equal(left, STOP if a in x else prefix(a, parallel(p, x, SKIP)))


@law()
def alphabetised_parallel_is_symmetric(p: Process, x: EventSet, y: EventSet, q: Process) -> Claim:
    return equal(alphabetised(p, x, y, q), alphabetised(q, y, x, p))


@law()
def alphabetised_parallel_is_associative(
    p: Process, x: EventSet, y: EventSet, q: Process, z: EventSet, r: Process
) -> Claim:
    return equal(
        alphabetised(alphabetised(p, x, y, q), x | y, z, r), alphabetised(p, x, y | z, alphabetised(q, y, z, r))
    )


@law()
def alphabetised_parallel_of_three_is_that_of_two(
    p: Process, x: EventSet, q: Process, y: EventSet, r: Process, z: EventSet
) -> Claim:
    return equal(AlphabetisedParallel((x, y, z), (p, q, r)), alphabetised(alphabetised(p, x, y, q), x | y, z, r))


@law()
def alphabetised_parallel_distributes_over_internal_choice(
    p: Process, x: EventSet, y: EventSet, q: Process, r: Process
) -> Claim:
    return equal(alphabetised(p, x, y, internal(q, r)), internal(alphabetised(p, x, y, q), alphabetised(p, x, y, r)))


@law()
def alphabetised_parallel_is_parallel_on_the_common_events(p: Process, x: EventSet, y: EventSet, q: Process) -> Claim:
    """Each operand kept within its alphabet, for which lockstep with a terminated process serves."""
    return equal(
        alphabetised(p, x, y, q),
        parallel(parallel(p, SIGMA - x, SKIP), x & y, parallel(q, SIGMA - y, SKIP)),
    )


@law()
def interleaving_is_parallel_on_nothing_within_everything(p: Process, q: Process) -> Claim:
    return equal(interleave(p, q), parallel(p, NONE, q))


@law()
def renaming_goes_into_interleaving(p: Process, q: Process, relation: Pairs) -> Claim:
    return equal(rename(interleave(p, q), relation), interleave(rename(p, relation), rename(q, relation)))


@law()
def bijective_renaming_goes_into_parallel(p: Process, x: EventSet, q: Process, bijection: Pairs) -> Claim:
    image = EventSet.of(dict(bijection)[e] for e in x)
    return equal(rename(parallel(p, x, q), bijection), parallel(rename(p, bijection), image, rename(q, bijection)))


@law()
def linking_is_renaming_synchronising_and_hiding(p2: Process, q2: Process, a: int, b: int) -> Claim:
    """With c as the name of the link, which the operands do not know otherwise."""
    link = EventSet.of([C])
    return equal(
        LinkedParallel(p2, ((a, b),), q2),
        hide(parallel(rename(p2, ((a, C),)), link, rename(q2, ((b, C),))), link),
    )
