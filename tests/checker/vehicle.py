"""The control part of an underwater vehicle as a network built by hand: fourteen cyclic processes."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.network import Network, Rule, Slot
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK
from cspcheck.cspm.process.terms import Stop

STATES = 2_519_424
TRANSITIONS = 23_549_616

# Each process as its transitions (state, event, state); the processes that name an event synchronise on it.
Transitions = list[tuple[int, str, int]]


def cycle(*events: str) -> Transitions:
    return [(i, event, (i + 1) % len(events)) for i, event in enumerate(events)]


PROCESSES: dict[str, Transitions] = {
    "BaseReader": cycle("getMessage", "saveReceptionTime", "baseReader_remote"),
    "Remote": cycle("baseReader_remote", "decodeMessage", "remote_s1"),
    "S1": [(0, "remote_s1", 1), (0, "autonomo_s1", 1), (1, "s1_move", 0)],
    "Autonomo": [(0, "tick", 1)],
    "Move": cycle("s1_move", "avoid_move", "getNextMovement", "move_s2"),
    "S2": [(0, "stop_s2", 1), (0, "move_s2", 1), (1, "s2_actuator", 0)],
    "Actuator": cycle("s2_actuator", "generateSetpoints", "actuator_thruster"),
    "ThrusterWriter": cycle("actuator_thruster", "generateMessage", "sendMessageTwt"),
    "Stop": [
        (0, "checkLastReception", 1),
        (1, "stop_s2", 2),
        (1, "getNextExecutionStp", 0),
        (2, "getNextExecutionStp", 0),
    ],
    "AvoidCollision": cycle("generateAvoid", "avoid_move", "getNextExecutionAvd"),
    "Sensor": cycle("getSensors", "structureToMessage", "sensor_baseWriter", "getNextExecutionSns"),
    "BaseWriter": cycle("sensor_baseWriter", "sendMessageBwt"),
    "Altimeter": cycle("getDepth", "saveDepth", "getNextExecutionAlt"),
    "Compass": cycle("getDirection", "saveDirection", "getNextExecutionCps"),
    "Sonar": cycle("getSonar", "saveSonar", "getNextExecutionSnr"),
}


def synchronised(
    processes: dict[str, Transitions], silent: AbstractSet[str] = frozenset(), blocked: AbstractSet[str] = frozenset()
) -> Network:
    """Each process in a slot; an event is performed by all processes that name it.

    *silent* events are hidden; *blocked* ones need a partner that never performs them.
    """
    names = sorted({event for transitions in processes.values() for _, event, _ in transitions} - {"tick"})
    number = {"tick": TICK} | {name: FIRST_EVENT + i for i, name in enumerate(names)}
    slots, users = [], {name: [] for name in names}
    for place, (process, transitions) in enumerate(processes.items()):
        states = 1 + max(max(source, target) for source, _, target in transitions)
        rows: list[list[tuple[int, int]]] = [[] for _ in range(states)]
        for source, event, target in transitions:
            rows[source].append((number[event], target))
        slots.append(Slot(process, None, Lts.from_successors(rows), (Stop(),) * states))
        for event in {event for _, event, _ in transitions} - {"tick"}:
            users[event].append(place)
    rules = []
    for name in names:
        if name in blocked:
            continue
        result = TAU if name in silent else number[name]
        rules.append(Rule(result, tuple((place, number[name]) for place in sorted(users[name])), number[name]))
    return Network(tuple(slots), tuple(rules), initial=tuple((i, 0) for i in range(len(slots))))


def vehicle(independent_loops: int = 0) -> Network:
    """The vehicle, with further processes beside it that each cycle through three events of their own."""
    loops = {f"Loop{i}": cycle(f"loop{i}a", f"loop{i}b", f"loop{i}c") for i in range(independent_loops)}
    return synchronised(PROCESSES | loops, blocked={"autonomo_s1"})
