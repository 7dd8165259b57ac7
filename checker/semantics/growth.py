"""Where an exploration of terms ended at its limit, and what was growing there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cspcheck.checker.budget import LimitReached
from cspcheck.checker.messages import growing_arguments, growing_process, too_many_states
from cspcheck.checker.semantics.head_normal import HeadNormalForms, definition_name
from cspcheck.cspm.process.terms import (
    Process,
    Reference,
)
from cspcheck.cspm.source import Span

_FEW = 3
_MANY = 100
SAMPLE = 4_000
"""So many states are looked at to tell in the midst of an exploration what grows."""
_NESTED = 8
"""No one writes one operator inside itself so often; a recursion does."""


def too_many(process: Process, terms: Sequence[Process], heads: HeadNormalForms) -> LimitReached:
    """What to raise when the exploration of *process* has found *terms* and there are more."""
    states = len(terms)
    name, span = _named(process)
    calls = max(_calls(terms, heads).values(), key=len, default=[])
    # A definition that is called in a good part of the states with arguments of its own is what makes them many.
    if len(calls) > _FEW and 10 * len(calls) >= states:
        texts = [call.text for call in calls[:_FEW]]
        definition = definition_name(calls[0])
        return LimitReached(growing_arguments(definition, states, texts, len(calls), calls[0].span), states)
    operator, depth = _growing(terms)
    if operator is not None:
        return LimitReached(growing_process(name, states, operator, depth, span), states)
    return LimitReached(too_many_states(name, states, span), states)


def beyond(process: Process, states: int) -> LimitReached:
    """What to raise when *process* has more than so many states, whatever they are."""
    return LimitReached(too_many_states(_named(process)[0], states, _named(process)[1]), states)


def so_far(terms: Sequence[Process], heads: HeadNormalForms) -> str:
    """What is going on where *terms* have been found and there may be more: how many, and what grows, if anything."""
    states = len(terms)
    going_on = f"exploring a component of the process, {states:,} states of it so far"
    sample = [*terms[: SAMPLE // 2], *terms[max(SAMPLE // 2, states - SAMPLE // 2) : states]]
    if not sample:
        return going_on
    calls = max(_calls(sample, heads).values(), key=len, default=[])
    if len(calls) > _MANY and 10 * len(calls) >= len(sample):
        texts = ", ".join(f"`{call.text}`" for call in calls[:_FEW])
        return f"{going_on}: `{definition_name(calls[0])}` is called with ever new arguments ({texts}, ...)"
    operator, depth = _growing(sample)
    if operator is not None:
        return f"{going_on}: it keeps growing, `{operator}` is nested {depth:,} deep"
    return going_on


def _growing(terms: Sequence[Process]) -> tuple[str | None, int]:
    """The operator that is nested deeper and deeper, and how deep it is in the last term; None if there is none."""
    last, middle, early = (_depths(terms[i]) for i in (-1, len(terms) // 2, len(terms) // 10))
    kind = max(last, key=lambda k: last[k], default=None)
    if kind is None:
        return None, 0
    depth = last[kind]
    grows = depth >= _NESTED and depth > middle.get(kind, 0) > early.get(kind, 0)
    return (kind.symbol, depth) if grows else (None, 0)


def _calls(terms: Iterable[Process], heads: HeadNormalForms) -> dict[Span | str, list[Reference]]:
    """The references that stand for what runs in the terms, in order, by definition: where it is, or its name."""
    calls: dict[Span | str, list[Reference]] = {}
    seen: set[Process] = set()
    for term in terms:
        parts = [term]
        while parts:
            part = parts.pop()
            if part not in seen:
                seen.add(part)
                parts.extend(part.active())
                call = heads.name(part)
                if call is not None:
                    calls.setdefault(call.span or definition_name(call), []).append(call)
    return calls


def _named(process: Process) -> tuple[str, Span | None]:
    if isinstance(process, Reference):
        return f"`{process.text}`", process.span
    return "the process", None


def _depths(term: Process) -> dict[type[Process], int]:
    """How often each operator is met on the way down the running operands."""
    depths: dict[type[Process], int] = {}
    level = {term}
    while level:
        for kind in {type(t) for t in level}:
            if kind.symbol:
                depths[kind] = depths.get(kind, 0) + 1
        level = {operand for t in level for operand in t.active()}
    return depths
