"""Violations few steps away, where internal steps lead to more states than are looked at before the first event.

The search for a counterexample goes by visible events: all that taus lead to comes before the next event. Where most
of a system is hidden that may be nearly everything, though a violation is near. Here taus are counted as steps, for
which they are shown by an event that the specification has no say in.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cspcheck.checker.arrays import Int32Array, Int64Array
from cspcheck.checker.budget import Budget
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.pair_search import PairExploration
from cspcheck.checker.search.paths import PathStep
from cspcheck.checker.specification.normal_form import NormalForm
from cspcheck.cspm.process.events import TAU

BEFORE_STEPS = 500_000
"""Only where taus lead to more pairs than this before the first event are steps counted in the place of events."""
BY_STEPS = 1_000_000
"""So many pairs are looked at."""


def pairs_by_steps(
    machines: Machines, normal_form: NormalForm, packed: PackedNetwork, budget: Budget
) -> PairExploration:
    """The pairs of a specification's node and a state that the fewest steps lead to, in the traces model.

    Args:
        machines: does the search.
        normal_form: the specification, of whose acceptances nothing is asked.
        packed: the implementation, which is searched with its taus shown.
        budget: what may be used; no more than ``BY_STEPS`` pairs are looked at.
    """
    shown = int(max(packed.events.max(), normal_form.events.max(initial=0))) + 1
    return machines.pairs_of(
        pack(_with_taus_shown(packed.network, shown)),
        _with_taus_allowed(normal_form, shown),
        "T",
        budget.narrowed(BY_STEPS),
        full=False,
    )


def with_taus(path: tuple[PathStep, ...], packed: PackedNetwork) -> tuple[PathStep, ...]:
    """A path through the network with taus shown, as one through the network itself."""
    return tuple(replace(step, event=packed.network.rules[step.rule].result) for step in path)


def _with_taus_shown(network: Network, shown: int) -> Network:
    rules = tuple(replace(rule, result=shown) if rule.result == TAU else rule for rule in network.rules)
    return replace(network, rules=rules)


def _with_taus_allowed(normal_form: NormalForm, shown: int) -> NormalForm:
    """The normal form with an event that changes nothing at every node that does not allow everything."""
    going_on = np.flatnonzero(~normal_form.divergent)
    ends: Int64Array = normal_form.offsets[1:][going_on]
    columns: Int32Array = np.insert(normal_form.columns, ends, len(normal_form.events)).astype(np.int32)
    targets: Int32Array = np.insert(normal_form.targets, ends, going_on).astype(np.int32)
    return replace(
        normal_form,
        model="T",
        events=np.append(normal_form.events, shown),
        offsets=normal_form.offsets + np.concatenate([[0], np.cumsum(~normal_form.divergent)]),
        columns=columns,
        targets=targets,
        acceptance_set=normal_form.divergent.astype(np.int32),
        acceptance_sets=(((),), ()),
    )
