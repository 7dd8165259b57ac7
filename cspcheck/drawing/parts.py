"""Which picture shows what: machines and architectures of processes of a script."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.terms import Process
from cspcheck.drawing.picture import Picture

if TYPE_CHECKING:
    from cspcheck.cspm.process.events import EventTable

MOST_STATES = 300
"""A picture of more states shows nothing."""


def machine(title: str, process: Process, events: EventTable, most: int = MOST_STATES) -> Picture:
    """The machine of a process. Its states are numbered in the order of discovery; state 0 is the initial one.

    Raises:
        ScriptError: it has more than *most* states, or cannot be evaluated.
    """
    return numbered_machine(title, process, events, most)[0]


def numbered_machine(
    title: str, process: Process, events: EventTable, most: int = MOST_STATES
) -> tuple[Picture, tuple[Process, ...]]:
    """The machine of a process with the term of each state, by the number in the picture.

    Raises:
        ScriptError: it has more than *most* states, or cannot be evaluated.
    """
    from cspcheck.checker.semantics.transitions import LimitReached, explore
    from cspcheck.cspm.process.text import describe
    from cspcheck.drawing.machines import machine_picture
    from cspcheck.messages import too_large_to_draw

    try:
        lts, terms = explore(process, Limits(states=most))
    except LimitReached:
        raise ScriptError(too_large_to_draw(title, most)) from None
    return machine_picture(title, lts, events, lambda state: describe(terms[state], events)), tuple(terms)


def architecture(title: str, process: Process, events: EventTable) -> Picture:
    """The components of a process and the channels between them.

    Raises:
        ScriptError: a component is too large to be explored, or cannot be evaluated.
    """
    from cspcheck.checker.budget import LimitReached
    from cspcheck.checker.network.compiler import Compiler
    from cspcheck.drawing.machines import architecture_picture, without_priority

    try:
        network = Compiler().network(process, Limits(), lambda _: None)
        if len(network.slots) == 1:
            # What is one component to the engine need not be one to the reader.
            network = Compiler(slot_states=2).network(without_priority(process), Limits(), lambda _: None)
    except LimitReached as limit:
        raise ScriptError(limit.diagnostic) from None
    return architecture_picture(title, network, events)
