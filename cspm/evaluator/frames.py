"""Where the compiled code finds variables: their positions in the environment, known before anything runs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.values.dots import ChannelHead, Event
from cspcheck.cspm.values.thunks import Code

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.units import Unit


@dataclass(frozen=True, slots=True, eq=False)
class Timing:
    """A Timed section: its clock, and how long each event takes (None: one tock).

    ``duration`` is code for the section's function; it needs the first ``size`` variables of any environment inside,
    of which it ``mentions`` some.
    """

    unit: Unit
    clock: Symbol
    duration: Code | None
    size: int
    mentions: frozenset[Symbol]

    @property
    def tock(self) -> ChannelHead:
        """The channel ``tock``, which may be declared behind the section."""
        head = self.unit.head(self.clock)
        assert isinstance(head, ChannelHead)
        return head

    @property
    def event(self) -> Event:
        """The event ``tock``."""
        event: Event = self.tock.value
        return event


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The local variables at some place of a script, by position, and what surrounds the place.

    ``evaluated`` are the variables that can hold no thunks.
    """

    unit: Unit
    timing: Timing | None
    slots: dict[Symbol, int]
    size: int
    evaluated: frozenset[Symbol]

    @classmethod
    def outermost(cls, unit: Unit, timing: Timing | None = None) -> Frame:
        """No local variables."""
        return cls(unit, timing, {}, 0, frozenset())

    def with_variables(self, symbols: Iterable[Symbol | None], *, evaluated: bool) -> Frame:
        """Further variables behind these; None takes up a position without a name."""
        slots = dict(self.slots)
        size = self.size
        new: list[Symbol] = []
        for symbol in symbols:
            if symbol is not None:
                slots[symbol] = size
                new.append(symbol)
            size += 1
        known = self.evaluated.union(new) if evaluated and new else self.evaluated
        return Frame(self.unit, self.timing, slots, size, known)

    def knowing(self, symbols: Iterable[Symbol]) -> Frame:
        """The same variables, *symbols* among them known to hold no thunks."""
        known = self.evaluated.union(symbols)
        return Frame(self.unit, self.timing, self.slots, self.size, known)

    def with_timing(self, timing: Timing | None) -> Frame:
        """The same variables inside a Timed section."""
        return Frame(self.unit, timing, self.slots, self.size, self.evaluated)
