"""Channels that are queues in a program: what may be one, and the composition with a buffer in its place.

A queue lets the sender go on before its value has been received. The composition that has it is explored here as the
program runs it: sending is an internal step, what happens on the channel is the receipt. Whether that is as good as the
channel is for refinement to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cspcheck.codegen import messages
from cspcheck.codegen.design.links import links
from cspcheck.codegen.design.system import System
from cspcheck.cspm.diagnostics import ScriptError

TAU, TICK = 0, 1
MOST_STATES = 100_000

Node = tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]
"""The states of the tasks, and what is in the queues."""


@dataclass(frozen=True)
class Buffer:
    """A channel, by number, that is a queue of so many values from one task to another."""

    channel: int
    sender: int
    receiver: int
    length: int


def buffer(system: System, label: str, length: int) -> Buffer:
    """The queue in place of a channel.

    Raises:
        ScriptError: there is no such channel, or a queue cannot stand for it.
    """
    found = [i for i, one in enumerate(system.channels) if label in (one.label, one.name)]
    if len(found) != 1:
        known = ", ".join(f"`{one.label}`" for one in system.channels)
        raise ScriptError(messages.no_queue(label, f"the channels of `{system.process}` are {known}"))
    if any(one.clocked or one.rank for one in system.channels):
        raise ScriptError(messages.no_queue(label, "the composition counts time or has priorities"))
    (channel,) = found
    for link in links(system):
        if link.channels == (channel,) and len(link.senders) == 1:
            _always_takes(system, link.receiver, channel, label)
            return Buffer(channel, link.senders[0], link.receiver, length)
    why = "it must lead from one task, which offers nothing else when it sends, to one that only receives on it then"
    raise ScriptError(messages.no_queue(label, why))


def _always_takes(system: System, receiver: int, channel: int, label: str) -> None:
    """Make sure that a receiver that receives takes whatever comes."""
    it = system.channels[channel]
    for state in system.machines[system.tasks[receiver].machine].states:
        offered = {event for event, _ in state.moves if it.first <= event < it.first + it.count}
        if offered and len(offered) < it.count:
            name = system.tasks[receiver].name
            raise ScriptError(messages.no_queue(label, f"`{name}` takes only some of its values where it receives"))


def rows(system: System, buffers: Sequence[Buffer]) -> list[list[tuple[int, int]]]:
    """The machine of the composition with its buffers: the (label, target) pairs of each state, from the first on.

    Labels are the events of the script; hidden ones are internal steps. Without buffers it is the composition itself.

    Raises:
        ScriptError: it has more states than can be looked at.
    """
    machines = [system.machines[task.machine].states for task in system.tasks]
    queue_of = {one.channel: place for place, one in enumerate(buffers)}
    labels = [TAU if system.channels[e.channel].hidden else e.identifier for e in system.events]
    start: Node = (tuple(task.start for task in system.tasks), ((),) * len(buffers))
    numbers: dict[Node | None, int] = {start: 0}
    waiting: list[Node | None] = [start]
    found: list[list[tuple[int, int]]] = []

    def number(node: Node | None) -> int:
        if node not in numbers:
            if len(numbers) >= MOST_STATES:
                raise ScriptError(messages.too_large(system.process, "states with its queues", MOST_STATES, None))
            numbers[node] = len(numbers)
            waiting.append(node)
        return numbers[node]

    for node in waiting:
        row: list[tuple[int, int]] = []
        found.append(row)
        if node is None:  # terminated
            continue
        at, queues = node
        states = [machine[state] for machine, state in zip(machines, at, strict=True)]
        if all(state.ends for state in states):
            row.append((TICK, number(None)))
        offers: dict[int, dict[int, list[int]]] = {}
        for task, state in enumerate(states):
            for way in state.ways:
                row.append((TAU, number((_with(at, {task: way}), queues))))
            for event, target in state.moves:
                offers.setdefault(event, {}).setdefault(task, []).append(target)
        for event, by_task in offers.items():
            place = queue_of.get(system.events[event].channel)
            if place is not None:
                one = buffers[place]
                if len(queues[place]) < one.length:
                    for target in by_task.get(one.sender, ()):
                        longer = _put(queues, place, (*queues[place], event))
                        row.append((TAU, number((_with(at, {one.sender: target}), longer))))
                if queues[place][:1] == (event,):
                    for target in by_task.get(one.receiver, ()):
                        shorter = _put(queues, place, queues[place][1:])
                        row.append((labels[event], number((_with(at, {one.receiver: target}), shorter))))
                continue
            for group in system.events[event].groups:
                if group <= by_task.keys():
                    ways: list[dict[int, int]] = [{}]
                    for task in group:
                        ways = [{**way, task: target} for way in ways for target in by_task[task]]
                    row += [(labels[event], number((_with(at, way), queues))) for way in ways]
    return found


def _with(at: tuple[int, ...], changes: dict[int, int]) -> tuple[int, ...]:
    return tuple(changes.get(task, state) for task, state in enumerate(at))


def _put(queues: tuple[tuple[int, ...], ...], place: int, queue: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    return (*queues[:place], queue, *queues[place + 1 :])
