"""Small processes on the ways of large ones: machines inside terms, reduction by itself, thresholds at their least."""

from __future__ import annotations

import random
from functools import partial

import pytest

from cspcheck.checker.checks import machine_terms, properties, reducing, refinement, store
from cspcheck.checker.network import compiler
from cspcheck.checker.network.compiler import Compiler
from cspcheck.checker.reduction import composing
from cspcheck.cspm.process.terms import Compressed, Process
from tests.reference.processes import COMPRESSIONS
from tests.reference.surgery import positions

NEUTRAL = (*COMPRESSIONS, "explicate", "lazyenumerate", "lazynorm")
"""The functions that change no trace, failure or divergence."""

SLOTS = (3, 20_000)
"""States from which on a component is large: nearly every one, and none."""


def least_thresholds(monkeypatch: pytest.MonkeyPatch, slots: int) -> None:
    """Everything that can be a machine is one, and everything is reduced, however small it is.

    Args:
        slots: so many states make a component a large one.
    """
    for module in (store, refinement, properties):
        monkeypatch.setattr(module, "FIRST_LOOK", 1)
    monkeypatch.setattr(store, "WHOLE_NORMAL_FORM", 0)
    monkeypatch.setattr(reducing, "WORTH_WHILE", -1_000)
    monkeypatch.setattr(composing, "DIAMONDS", 1_000)
    monkeypatch.setattr(compiler, "FEW", ())
    monkeypatch.setattr(machine_terms, "Compiler", partial(Compiler, slot_states=slots))
    if slots < compiler.SMALL:
        monkeypatch.setattr(compiler, "SMALL", 1)
        monkeypatch.setattr(store, "LISTED_FIRST", 1)  # specifications are followed term by term


def compressed(process: Process, rng: random.Random) -> Process:
    """The same with some functions around parts of it that change nothing of what it means."""
    for _ in range(rng.randrange(3)):
        part, put = rng.choice(list(positions(process)))
        process = put(Compressed(rng.choice(NEUTRAL), part))
    return process
