"""Making normal forms of explicit machines.

A machine without taus in which no event leads to two states is its own normal form, whatever its size; this is
decided and done in arrays. Everything else goes through the subset construction
(:mod:`cspcheck.checker.specification.normaliser`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.lts import Lts
from cspcheck.checker.sparse_rows import gather_rows, intern_rows
from cspcheck.checker.specification.acceptances import AcceptanceSet, StateAcceptances
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.cspm.process.events import TAU

MINIMISATION_WORK = 20_000_000
"""Transitions that the minimisation of a normal form may look at, all rounds together, before it is given up."""


def normalise(
    lts: Lts, model: NormalModel, *, minimise: bool = True, poll: Callable[[int], None] | None = None
) -> NormalForm:
    """The normal form of a machine whose states are all reachable.

    Args:
        lts: the machine of the specification.
        model: what the normal form is to be compared in.
        minimise: whether equivalent nodes are to be merged where that is cheap. The verdicts are the same; the
            numbers of nodes and of pairs are smaller.
        poll: called every now and then with the number of nodes so far. What it raises ends the work.
    """
    normal_form = _own_normal_form(lts, model) if is_deterministic(lts) else Normaliser(lts, model).all_nodes(poll)
    return minimised(normal_form) if minimise else normal_form


def is_deterministic(lts: Lts) -> bool:
    """Whether there is no tau and no event leads from one state to two."""
    if (lts.labels == TAU).any():
        return False
    repeated = lts.labels[1:] == lts.labels[:-1]
    starts = lts.offsets[1:-1]
    repeated[starts[(starts > 0) & (starts < lts.transitions)] - 1] = False
    return not repeated.any()


def _own_normal_form(lts: Lts, model: NormalModel) -> NormalForm:
    """The normal form of a machine that :func:`is_deterministic`: the machine itself, in arrays throughout."""
    events: Int64Array = distinct(lts.labels)
    columns = np.searchsorted(events, lts.labels)
    if model == "T":
        acceptance_set = np.zeros(lts.states, dtype=np.int32)
        sets: list[AcceptanceSet] = [((),)]
    else:
        accepting = StateAcceptances(lts, columns)
        acceptance_set = accepting.number.astype(np.int32)
        sets = [(acceptance,) for acceptance in accepting.acceptances]
    return NormalForm(
        model,
        events,
        lts.offsets,
        columns.astype(np.int32),
        lts.targets.astype(np.int32),
        np.zeros(lts.states, dtype=np.bool_),
        acceptance_set,
        tuple(sets),
        lts.root,
    )


def minimised(normal_form: NormalForm, *, work: int = MINIMISATION_WORK) -> NormalForm:
    """The normal form with the fewest nodes, or the one given if finding it takes more than *work* transitions.

    Moore's refinement of partitions: nodes stay together while they agree in what they say and in where their
    events lead. Nodes keep the order of their first representatives.
    """
    offsets, targets = normal_form.offsets, normal_form.targets.astype(np.int64)
    nodes = normal_form.nodes
    lengths = np.diff(offsets)
    keys = normal_form.acceptance_set.astype(np.int64) * 2 + normal_form.divergent
    block, first = intern_rows(np.arange(nodes + 1), keys)
    # A row of the signature, ascending: the block so far, below zero, then (column, block of the target) in one number.
    heads = offsets[:-1] + np.arange(nodes)
    body = np.arange(len(targets)) + np.repeat(np.arange(1, nodes + 1), lengths)
    signature = np.empty(len(targets) + nodes, dtype=np.int64)
    signature_offsets = np.concatenate([heads, [len(signature)]])
    done = 0
    while True:
        done += len(signature)
        if done > work:
            return normal_form
        signature[heads] = -1 - block
        signature[body] = normal_form.columns.astype(np.int64) * nodes + block[targets]
        block, refined = intern_rows(signature_offsets, signature)
        if len(refined) == len(first):
            break
        first = refined
    if len(first) == nodes:
        return normal_form
    rows = gather_rows(offsets, first)
    return NormalForm(
        normal_form.model,
        normal_form.events,
        np.concatenate([[0], np.cumsum(lengths[first])]).astype(np.int64),
        normal_form.columns[rows],
        block[targets[rows]].astype(np.int32),
        normal_form.divergent[first],
        normal_form.acceptance_set[first],
        normal_form.acceptance_sets,
        int(block[normal_form.root]),
    )
