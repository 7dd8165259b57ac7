"""The comparison notices faults: whatever one operator gets wrong, some random process shows it soon.

One operator of the reference is spoilt at a time; then it must disagree with the transitions within a few hundred
families. That it does is what gives their agreement a meaning.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from itertools import islice

import pytest

from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from tests.differential.families import families
from tests.differential.operational import difference
from tests.reference.denotations import Denotation, Root, Semantics, events_of
from tests.reference.processes import EVENTS

FAMILIES = 400
OPERATORS = {
    "choices": "[]",
    "interrupts": "/\\",
    "throw": "throw",
    "sequence": ";",
    "parallel": "[||]",
    "alphabetised parallel": "||",
    "hiding": "\\",
    "renaming": "[[]]",
}


class Spoilt(Semantics):
    """The denotational semantics with one operator that is wrong in one respect."""

    def __init__(self, operator: str, spoil: Callable[[Root], Root]) -> None:
        self.operator = operator
        self.spoil = spoil
        super().__init__(EVENTS, limit=2_000)

    def _expression(
        self, key: tuple[Hashable, ...], root: Callable[[], Root], after: Callable[[int], Denotation]
    ) -> Denotation:
        if key[0] != self.operator:
            return super()._expression(key, root, after)
        return super()._expression(key, lambda: self.spoil(root()), after)


def without_termination(root: Root) -> Root:
    return root._replace(ticks=False)


def without_divergence(root: Root) -> Root:
    return root._replace(diverges=False)


def without_the_last_event(root: Root) -> Root:
    return root._replace(initials=sum(1 << e for e in events_of(root.initials)[:-1]))


def with_one_refusal_less(root: Root) -> Root:
    return root._replace(refusals=frozenset(sorted(root.refusals)[1:])) if len(root.refusals) > 1 else root


def refusing_more(root: Root) -> Root:
    """Each refusal with the first initial event as well."""
    first = root.initials & -root.initials
    return root._replace(refusals=frozenset(refused | first for refused in root.refusals))


@pytest.mark.parametrize(
    "spoil",
    [without_termination, without_divergence, without_the_last_event, with_one_refusal_less, refusing_more],
    ids=lambda spoil: spoil.__name__,
)
@pytest.mark.parametrize("operator", OPERATORS)
def test_a_fault_shows(operator: str, spoil: Callable[[Root], Root]) -> None:
    for _, members in islice(families(0), FAMILIES):
        for process in members:
            semantics = Spoilt(OPERATORS[operator], spoil)
            try:
                if difference(explore(process, Limits(states=300)).lts, semantics.of(process), semantics):
                    return
            except LimitReached:
                continue
    pytest.fail("nobody noticed")
