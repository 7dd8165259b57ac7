"""Networks read as they are written: what rules, taus, switches and slots mean."""

from __future__ import annotations

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.interpretation import Interpretation, interpret, participants
from cspcheck.checker.network.network import Network, Rule, Slot, Switch
from cspcheck.cspm.process.events import TAU

a, b, c = 2, 3, 4


def slot(*rows: list[tuple[int, int]]) -> Slot:
    return Slot("", None, Lts.from_successors(rows), ())


TWO_WAYS = slot([(a, 1), (a, 2)], [(b, 0)], [])
BACK_AND_FORTH = slot([(a, 1)], [(a, 0), (c, 1)])


def test_participants_move_and_the_others_stay() -> None:
    network = Network(
        (TWO_WAYS, BACK_AND_FORTH, BACK_AND_FORTH),
        (Rule(c, ((0, a), (2, a)), c), Rule(TAU, ((1, a),), a)),
        initial=((0, 0), (1, 0), (2, 0)),
    )
    successors = interpret(network)
    assert Interpretation(network).initial == (0, (0, 0, 0))
    assert successors((0, (0, 0, 0))) == [
        (c, (0, (1, 0, 1)), 0),
        (c, (0, (2, 0, 1)), 0),
        (TAU, (0, (0, 1, 0)), 1),
    ]
    assert successors((0, (1, 1, 0))) == [(TAU, (0, (1, 0, 0)), 1)]
    assert [participants(rule) for rule in network.rules] == [(0, 2), (1,)]


def test_rules_apply_in_their_format_and_switches_clear_before_they_start() -> None:
    network = Network(
        (TWO_WAYS, BACK_AND_FORTH, BACK_AND_FORTH),
        (
            Rule(b, ((0, b),), b, format=0, switch=Switch(1, cleared=(0, 1), started=((1, 1), (2, 1)))),
            Rule(c, ((1, c), (2, c)), c, format=1),
            Rule(a, ((2, a),), a, format=1, switch=Switch(0, cleared=(1,), started=((0, 1),))),
        ),
        formats=2,
        initial=((0, 1), (1, 1)),
    )
    successors = interpret(network)
    assert Interpretation(network).initial == (0, (1, 1, 0))
    assert successors((0, (1, 1, 0))) == [(b, (1, (0, 1, 1)), 0)]
    assert successors((1, (0, 1, 1))) == [(c, (1, (0, 1, 1)), 1), (a, (0, (1, 0, 0)), 2)]
