"""Where values of one datatype are in the types of CSPm."""

from __future__ import annotations

from cspcheck.checker.independence.uses import total
from cspcheck.cspm.typing.types import (
    EVENT,
    PROC,
    Datatype,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    SetOf,
    TupleOf,
    Type,
    Variable,
    components,
    parts,
    resolve,
)


class Touched:
    """Which types have values of a datatype inside, and how many.

    *event_slots* is the most of them that an event has; None: no bound is known.
    """

    def __init__(self, datatype: Datatype) -> None:
        self.datatype = datatype
        self.event_slots: int | None = 0
        self._known: dict[int, bool] = {}
        self._kept: list[Type] = []

    def touches(self, type_: Type) -> bool:
        """Whether values of the type may have some inside; of a type that is not known they may. Events count not."""
        head = resolve(type_)
        if head is self.datatype or isinstance(head, Variable | Rigid):
            return True
        known = self._known.get(id(head))
        if known is None:
            self._known[id(head)] = False  # of a recursive type the other constructors tell
            self._kept.append(head)
            inner = [f for fields in head.fields.values() for f in fields] if isinstance(head, Datatype) else []
            known = self._known[id(head)] = any(map(self.touches, [*inner, *components(head)]))
        return known

    def compares(self, type_: Type) -> bool:
        """Whether values of the type keep some apart by equality: sets of them, maps from them."""
        head = resolve(type_)
        if isinstance(head, SetOf):
            return self.touches(head.element)
        if isinstance(head, MapOf):
            return self.touches(head.key) or self.compares(head.value)
        if isinstance(head, Variable | Rigid | Datatype | Function):
            return False
        return any(map(self.compares, components(head)))

    def has_events(self, type_: Type) -> bool:
        """Whether values of the type have events inside, or channels, which carry some."""
        head = resolve(type_)
        if head is EVENT:
            return self.event_slots != 0
        if isinstance(head, Datatype):
            return False
        return any(map(self.has_events, components(head)))

    def slots(self, type_: Type, inside: tuple[Datatype, ...] = ()) -> int | None:
        """The most values of the datatype in one value of the type; None: no bound is known."""
        head = resolve(type_)
        if head is self.datatype:
            return 1
        if head is EVENT or isinstance(head, Dotable | Extendable):
            return self.event_slots
        if head is PROC or isinstance(head, Function):
            return None
        if not self.touches(head):
            return None if self.has_events(head) else 0
        if isinstance(head, Datatype):
            if head in inside:
                return None
            found: list[int | None] = [
                total([self.slots(field, (*inside, head)) for field in fields]) for fields in head.fields.values()
            ]
            return None if None in found else max(count for count in found if count is not None)
        flat = parts(head)
        if len(flat) > 1:
            return total([self.slots(part, inside) for part in flat])
        if isinstance(head, TupleOf):
            return total([self.slots(part, inside) for part in components(head)])
        return None
