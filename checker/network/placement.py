"""Where the components of a network of formats are: holes of formats become slots, actions become rules.

Holes that a component passes through as the format changes must be one slot. Other holes get slots of their own as
long as states take no more words for it, since a slot with one kind of component is easier to explain. Otherwise
holes share slots if they are never there at the same time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.actions import Path
from cspcheck.checker.network.bounded_machines import FIRST_PRIVATE_LABEL, Entry
from cspcheck.checker.network.formats import Changes, Format, Formats, Started, kept
from cspcheck.checker.network.network import Network, Rule, Slot, Switch
from cspcheck.checker.network.shapes import slot_key
from cspcheck.checker.network.skeleton import Told, never
from cspcheck.checker.semantics.head_normal import HeadNormalForms, definition_name
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import Reference
from cspcheck.cspm.source import Span

MOST_NAMES = 3
"""So many definitions give their names to a slot that they share."""
WORD_BITS = 63


@dataclass(eq=False, slots=True)
class _Room:
    """A slot in the making: the components that can be in it, and the numbers of their states."""

    entries: dict[Entry, None] = field(default_factory=dict)
    states: dict[Entry, int] = field(default_factory=dict)

    @property
    def bits(self) -> int:
        return (len(self.states) - 1).bit_length()


def network_of(formats: Formats, heads: HeadNormalForms, has_machines: Told = never) -> Network:
    """The network of the formats of a process.

    Args:
        formats: the formats.
        heads: knows what components are called.
        has_machines: tells in which states of a component a machine takes part.
    """
    slots = _slots_of_their_own(formats)
    rooms = _rooms(formats, slots)
    if _words(rooms) > 1:
        shared = _shared_slots(formats)
        fewer = _rooms(formats, shared)
        if _words(fewer) < _words(rooms):
            slots, rooms = shared, fewer
    return _Placement(formats, slots, rooms, has_machines).network(heads)


def _slots_of_their_own(formats: Formats) -> list[int]:
    """A slot for each place; one for all places that components pass between ."""
    passed = [
        (format.places[path], after.format.places[path])
        for format in formats.all
        for after in format.nexts.values()
        for path in kept(format, after)
    ]
    places = {place for format in formats.all for place in format.places.values()}
    return _numbered(first_of_joined(len(places), passed))


def first_of_joined(number: int, pairs: Iterable[tuple[int, int]]) -> list[int]:
    """For each of the numbers from 0 the smallest of those that the pairs join it with, one after the other."""
    # Disjoint sets whose root is the smallest. NetworkX has them, too, but takes longer to be imported than all the
    # rest of a small check.
    above = list(range(number))

    def first(one: int) -> int:
        while above[one] != one:
            above[one] = above[above[one]]
            one = above[one]
        return one

    for pair in pairs:
        one, other = sorted(map(first, pair))
        above[other] = one
    return [first(one) for one in range(number)]


def _shared_slots(formats: Formats) -> list[int]:
    """A slot for each place; one for all places that no format has two of."""
    return _numbered(slot_key(path) for format in formats.all for path in format.places)


def _numbered(keys: Iterable[int] | Iterable[Path]) -> list[int]:
    numbers: dict[int | Path, int] = {}
    return [numbers.setdefault(key, len(numbers)) for key in keys]


def _rooms(formats: Formats, slots: list[int]) -> list[_Room]:
    rooms = [_Room() for _ in range(max(slots) + 1)]
    for format in formats.all:
        for path, entries in format.entries.items():
            rooms[slots[format.places[path]]].entries.update(entries)
    for room in rooms:
        for entry in room.entries:
            role, _ = entry
            for term in formats.machines.of(entry).terms:
                room.states.setdefault((role, term), len(room.states))
    return rooms


def _words(rooms: Iterable[_Room]) -> int:
    return -(-sum(room.bits for room in rooms) // WORD_BITS)


class _Placement:
    """Formats with a slot for each of their places."""

    def __init__(self, formats: Formats, slots: list[int], rooms: list[_Room], has_machines: Told) -> None:
        self._has_machines = has_machines
        self._formats = formats
        self._slots = slots
        self._rooms = rooms

    def network(self, heads: HeadNormalForms) -> Network:
        formats = self._formats.all
        terminated = any(a.result == TICK for format in formats for a in format.actions)
        return Network(
            slots=tuple([self._slot(number, room, heads) for number, room in enumerate(self._rooms)]),
            rules=tuple([rule for format in formats for rule in self._rules(format)]),
            formats=len(formats) + terminated,
            initial=self._filled(formats[0], self._formats.started),
            terminated=terminated,
            first_private_label=FIRST_PRIVATE_LABEL,
            private_labels=self._formats.machines.private_labels,
        )

    def _rules(self, format: Format) -> list[Rule]:
        """The actions of a format, ordered, and one of each kind: the one with the least cause."""
        end = Switch(len(self._formats.all), self._of(format, format.places), ())
        switches: dict[Changes, Switch] = {
            changes: Switch(
                after.format.number, self._of(format, after.cleared), self._filled(after.format, after.started)
            )
            for changes, after in format.nexts.items()
        }
        causes: dict[tuple[int, tuple[tuple[int, int], ...], Changes], int] = {}
        for a in format.actions:
            moves = tuple(sorted([(self._slots[place], label) for place, label in a.moves]))
            key = (a.result, moves, a.changes)
            causes[key] = min(a.cause, causes.get(key, a.cause))
        # Two actions with the same moves and result change the same, so there is an order without the changes.
        return [
            Rule(result, moves, cause, format.number, end if result == TICK else switches.get(changes))
            for (result, moves, changes), cause in sorted(causes.items(), key=lambda item: item[0][:2])
        ]

    def _of(self, format: Format, paths: Iterable[Path]) -> tuple[int, ...]:
        return tuple([self._slots[format.places[path]] for path in paths])

    def _filled(self, format: Format, started: Started) -> tuple[tuple[int, int], ...]:
        slots = [(self._slots[format.places[path]], entry) for path, entry in started]
        return tuple([(slot, self._rooms[slot].states[entry]) for slot, entry in slots])

    def _slot(self, number: int, room: _Room, heads: HeadNormalForms) -> Slot:
        """A slot, named after the definitions of what runs in it."""
        rows: list[set[tuple[int, int]]] = [set() for _ in room.states]
        for entry in room.entries:
            role, _ = entry
            lts, terms = self._formats.machines.of(entry)
            numbers = [room.states[role, term] for term in terms]
            for source, state in enumerate(numbers):
                if not rows[state]:
                    rows[state] = {(label, numbers[target]) for label, target in lts.successors(source)}
        calls: dict[Span | str, Reference] = {}
        for _, term in room.entries:
            call = heads.name(term)
            if call is not None:
                calls.setdefault(call.span or definition_name(call), call)
        names = [call.text for call in calls.values()]
        if len(names) > MOST_NAMES:
            names[MOST_NAMES:] = ["..."]
        span = next((call.span for call in calls.values()), None)
        terms = tuple([term for _, term in room.states])
        compressed = next(filter(self._has_machines, terms), None)
        return Slot(" / ".join(names) or f"part {number + 1}", span, Lts.from_successors(rows), terms, compressed)
