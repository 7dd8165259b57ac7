"""Networks: what is composed is explored as a tuple of small local states, never as terms.

A network has *slots*. In every state of the whole, some slots are in use, each in a local state of its explicit
machine. Which slots are in use and which rules apply is told by the *format* (a number that is part of the
state): operators that change shape when something happens (``;``, ``[]``, interrupt, ...) are rules that change
the format. A composition of parallel, hiding and renaming alone has the one format 0.

A rule fires in its format when each slot named in ``moves`` can step on the local label named with it, whatever
the states of the others; the whole performs ``result``. Hiding and renaming have been worked into ``result``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cspcheck.checker.lts import Lts
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.source import Span


@dataclass(frozen=True, slots=True)
class Slot:
    """A place for a component.

    Attributes:
        name: what the component is called in the script (``Compass``, ``Fork(2)``).
        span: where it is defined, if it has a definition.
        lts: its local machine. Labels are event identifiers, or numbers >= ``Network.first_private_label`` that
            ``Network.private_labels`` explains.
        terms: the process term of each local state, for explanations and for comparison with the terms.
        compressed: for a machine in which states of explicit machines take part, the term that it was made of. Its
            states are no states of that term, only its behaviour is the same.
    """

    name: str
    span: Span | None
    lts: Lts
    terms: Sequence[Process]
    compressed: Process | None = None


@dataclass(frozen=True, slots=True)
class Switch:
    """What a rule does to the shape beside moving its participants.

    Attributes:
        format: the format afterwards.
        cleared: slots that are in use before and not afterwards (participants among them included); they are set
            to local state 0, so that equal states are equal words.
        started: (slot, local state) of slots that are not in use before and are afterwards. A slot that is used
            anew is in both: clearing comes first.
    """

    format: int
    cleared: tuple[int, ...]
    started: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Rule:
    """One way in which components step together.

    Attributes:
        result: the event that the whole performs (tau where hidden).
        moves: (slot, local label) of the participants, slots ascending and distinct.
        cause: the event before hiding and renaming at the outermost place where it was still one event, to show
            ``tau (mid.0)``; equal to ``result`` where nothing was hidden. TAU for a component's own tau.
        format: the format in which the rule applies.
        switch: None when the format stays.
        raises, yields: bits. Where some rule can fire that raises a bit, the rules that yield to this bit cannot: that
            is how a priority is said of rules.
    """

    result: int
    moves: tuple[tuple[int, int], ...]
    cause: int
    format: int = 0
    switch: Switch | None = None
    raises: int = 0
    yields: int = 0


@dataclass(frozen=True, eq=False, slots=True)
class Network:
    """Components and the rules by which they step.

    Attributes:
        slots: all slots of all formats.
        rules: all rules.
        formats: number of formats.
        initial_format: the format of the initial state.
        initial: (slot, local state) of the slots in use initially; unused slots are in local state 0.
        terminated: whether some rule has the result tick. The state after tick is format ``formats - 1`` with all
            slots cleared when ``formats > 1``; in a one-format network it is the state that the tick rule leads to.
        private_labels: the event identifier that a label >= ``first_private_label`` stands for.
    """

    slots: tuple[Slot, ...]
    rules: tuple[Rule, ...]
    formats: int = 1
    initial_format: int = 0
    initial: tuple[tuple[int, int], ...] = ()
    terminated: bool = False
    first_private_label: int = 1 << 63
    private_labels: tuple[int, ...] = ()

    @property
    def is_prioritised(self) -> bool:
        """Whether some rule gives way to others."""
        return any(rule.yields for rule in self.rules)

    @property
    def is_compressed(self) -> bool:
        """Whether some component is a compression of what the script says."""
        return any(slot.compressed is not None for slot in self.slots)
