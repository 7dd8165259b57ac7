"""The engine asked about process terms, and its counterexamples held against the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import Counterexample, Limits, Outcome
from cspcheck.cspm.process.events import TAU, TICK, EventTable
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.script import Script
from tests.reference.denotations import TICK_BIT, Denotation, mask
from tests.reference.processes import EVENTS, TABLE
from tests.reference.verdicts import Model, Trace

Kind = Literal["deadlock free", "divergence free", "deterministic"]
IDENTIFIERS = {TABLE.name(event): event for event in (TAU, TICK, *EVENTS)}


@dataclass(frozen=True)
class _Events:
    """All that the engine needs of a script when it is given terms."""

    events: EventTable = TABLE


def checker(*, full: bool = False, as_written: bool = False, states: int = 1_000) -> Checker:
    """A new checker that shares nothing with others."""
    limits = Limits(states=states)
    return Checker(cast(Script, _Events()), limits=limits, workers=1, full=full, as_written=as_written)


def visible(names: tuple[str, ...]) -> Trace:
    return tuple(IDENTIFIERS[name] for name in names if name != "tau")


def after(tree: Denotation, trace: Trace) -> Denotation | None:
    """The tree after a trace, None if it is not possible."""
    for event in trace:
        if not tree.root.initials >> event & 1:
            return None
        tree = tree.after(event)
    return tree


def may_do(tree: Denotation | None, event: int) -> bool:
    if tree is None:
        return False
    return tree.root.ticks if event == TICK else bool(tree.root.initials >> event & 1)


def may_refuse(tree: Denotation | None, events: int) -> bool:
    return tree is not None and any(events & ~refused == 0 for refused in tree.root.refusals)


def diverged(tree: Denotation, trace: Trace) -> bool:
    """Whether the trace, or one that it prolongs, is a divergence."""
    return any(
        (there := after(tree, trace[:length])) is not None and there.root.diverges for length in range(len(trace) + 1)
    )


def refutes_refinement(found: Counterexample, spec: Denotation, impl: Denotation, model: Model) -> bool:
    """Whether a counterexample is a behaviour of the implementation that the specification does not have."""
    trace = visible(found.trace)
    allowed, there = after(spec, trace), after(impl, trace)
    if there is None or (model == "FD" and diverged(spec, trace)):
        return False
    match found.kind:
        case "trace":
            assert found.event is not None
            event = IDENTIFIERS[found.event]
            return allowed is not None and may_do(there, event) and not may_do(allowed, event)
        case "refusal":
            refused = _mask(found.refusal)
            return model != "T" and may_refuse(there, refused) and not may_refuse(allowed, refused)
        case "divergence":
            return model == "FD" and there.root.diverges
        case _:
            return False


def refutes_property(found: Counterexample, process: Denotation, kind: Kind, model: Model) -> bool:
    """Whether a counterexample is a behaviour of the process that the property forbids."""
    there = after(process, visible(found.trace))
    if there is None:
        return False
    if found.kind == "divergence":
        return there.root.diverges and (kind == "divergence free" or model == "FD")
    if kind == "deadlock free" and found.kind == "deadlock":
        return may_refuse(there, there.root.initials | TICK_BIT)
    if kind == "deterministic" and found.kind == "nondeterminism":
        assert found.event is not None
        event = IDENTIFIERS[found.event]
        return may_do(there, event) and may_refuse(there, 1 << event)
    return False


def refutes_trace(found: Counterexample, process: Denotation, trace: Trace, model: Model) -> bool:
    """Whether a counterexample shows where a trace can be refused, is impossible, or is lost to divergence."""
    done = visible(found.trace)
    there = after(process, done)
    if there is None or done != trace[: len(done)] or len(done) == len(trace):
        return False
    if found.kind == "divergence":
        return model == "FD" and there.root.diverges
    event = trace[len(done)]
    return not may_do(there, event) or (model != "T" and may_refuse(there, 1 << event))


def _mask(names: tuple[str, ...] | None) -> int:
    assert names is not None
    return mask(IDENTIFIERS[name] for name in names)


def said(outcome: Outcome) -> bool | None:
    """True for pass, False for fail, None where the engine gave up."""
    return {"pass": True, "fail": False}.get(outcome.verdict.value)


__all__ = [
    "Kind",
    "Process",
    "after",
    "checker",
    "refutes_property",
    "refutes_refinement",
    "refutes_trace",
    "said",
    "visible",
]
