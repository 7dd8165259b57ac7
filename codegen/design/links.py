"""Channels that need no arbiter: their senders offer nothing else when they send, their receiver only receives then.

Such a channel can be a protected object with a slot for each sender, as ``specs/channels/data_sync.csp`` checks it;
channels between which a receiver chooses share one. Everything else needs the commit protocol.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cspcheck.codegen.design.system import System, SystemState


@dataclass(frozen=True)
class Link:
    """Channels with one receiver, by number, and the tasks that send on them, each with a slot."""

    channels: tuple[int, ...]
    receiver: int
    senders: tuple[int, ...]


def links(system: System) -> tuple[Link, ...]:
    """The links of a program, each channel in at most one.

    A channel is left to the board if it counts time or is timed, if an event of it has other than two parties or no
    party that all of them share, if a party has another choice where it sends, or if its receiver offers, beside it,
    something that is no link.
    """
    receivers = {}
    for channel in range(len(system.channels)):
        receiver = _receiver(system, channel)
        if receiver is not None:
            receivers[channel] = receiver
    while True:
        wrong = {
            channel
            for channel, receiver in receivers.items()
            if not _only_receives(system, receiver, channel, receivers)
        }
        if not wrong:
            break
        for channel in wrong:
            del receivers[channel]
    return tuple(_together(system, receivers))


def _states(system: System, task: int) -> tuple[SystemState, ...]:
    return system.machines[system.tasks[task].machine].states


def _receiver(system: System, channel: int) -> int | None:
    """The task that may be the receiver of a channel; None if there is none."""
    it = system.channels[channel]
    if it.clocked or it.count == 0 or any(task.timed == channel for task in system.tasks):
        return None
    groups = {group for event in system.events[it.first : it.first + it.count] for group in event.groups}
    if any(len(group) != 2 for group in groups):
        return None
    shared = frozenset.intersection(*groups)
    parties = frozenset.union(*groups)
    for receiver in sorted(shared, reverse=True):
        senders = parties - {receiver}
        if all(_commits(system, task, channel) for task in senders):
            return receiver
    return None


def _offered(system: System, state: SystemState) -> set[int]:
    return {system.events[event].channel for event, _ in state.moves}


def _commits(system: System, task: int, channel: int) -> bool:
    """Whether a task offers nothing but one event wherever it offers the channel."""
    return all(
        len(state.moves) == 1 and not state.ends
        for state in _states(system, task)
        if channel in _offered(system, state)
    )


def _only_receives(system: System, receiver: int, channel: int, receivers: dict[int, int]) -> bool:
    """Whether a task that offers the channel offers only such as it receives on."""
    for state in _states(system, receiver):
        offered = _offered(system, state)
        if channel in offered and (state.ends or any(receivers.get(other) != receiver for other in offered)):
            return False
    return True


def _together(system: System, receivers: dict[int, int]) -> Iterable[Link]:
    """Links of the channels that are chosen between, in the order of their first channels."""
    group = {channel: {channel} for channel in receivers}
    for channel, receiver in receivers.items():
        for state in _states(system, receiver):
            offered = _offered(system, state)
            if channel in offered:
                whole = set().union(*[group[other] for other in offered])
                for other in whole:
                    group[other] = whole
    for channel in sorted(receivers):
        channels = group[channel]
        if channel == min(channels):
            receiver = receivers[channel]
            senders = {
                task
                for one in channels
                for event in system.events[system.channels[one].first :][: system.channels[one].count]
                for parties in event.groups
                for task in parties
            }
            yield Link(tuple(sorted(channels)), receiver, tuple(sorted(senders - {receiver})))
