"""Channels: what tasks synchronise on, and what a task offers to do on one.

A channel is a constant of the program. It says which tasks must take part in its events; who waits on it at the
moment is the business of a run (``alternation``), so one program can be run many times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Never, cast

from .data import DataType

Group = frozenset[str]
"""The tasks that perform an event together."""
Values = tuple[Any, ...]
"""What an event carries, field by field."""


class _Open:
    """The field of an offer that takes any value."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "?"


ANY: Final = _Open()
"""``?x``: takes any value of the field."""


@dataclass(frozen=True, slots=True)
class OneOf:
    """``?x:S``: takes a value of the given ones."""

    values: frozenset[Any]

    def __repr__(self) -> str:
        return f"?{set(self.values)!r}"


def one_of(values: Iterable[Any]) -> OneOf:
    """The field of an offer that takes any of *values*."""
    return OneOf(frozenset(values))


class Undecided:
    """What a method gives that has not been written yet."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "undecided"


UNDECIDED: Final[Never] = cast(Never, Undecided())
"""Instead of the values that a method is to give: the program's policy decides."""


KEPT = 256
"""So many offers of a channel are kept, to be made again: what they meet is known then."""


class Channel:
    """A synchronous channel.

    Args:
        name: as in the specification.
        types: the set that each field is of.
        parties: the groups of tasks that can perform its events: every event is performed by all tasks of one of
            the groups at once. A text is the group of the one task that is called so. A mapping gives the groups for
            each event by the values that it carries; events that are not in it never happen.
        never: tasks that offer its events and never find everybody that is needed for them.
        hidden: whether its events are internal: recorded as such.
        inner: whether they are hidden by a part of the composition, not by the whole of it.
        rank: its events happen only when no event of a channel of a lower rank is possible; None: whenever they are.
    """

    def __init__(
        self,
        name: str,
        types: Iterable[DataType] = (),
        *,
        parties: Iterable[str | Iterable[str]] | Mapping[Values, Iterable[str | Iterable[str]]],
        never: Iterable[str] = (),
        hidden: bool = False,
        inner: bool = False,
        rank: int | None = None,
    ) -> None:
        self.name = name
        self.types = tuple(types)
        self.hidden = hidden
        self.inner = inner
        self.rank = rank
        self.by_event: dict[Values, frozenset[Group]] | None = None
        if isinstance(parties, Mapping):
            self.by_event = {values: frozenset(map(_group, groups)) for values, groups in parties.items()}
            groups = [_group(group) for some in parties.values() for group in some]
        else:
            groups = [_group(group) for group in parties]
        self.groups: tuple[Group, ...] = tuple(dict.fromkeys(groups))
        self.tasks: tuple[str, ...] = tuple(sorted({task for group in self.groups for task in group}))
        """The tasks that can take part in its events."""
        self.partners: dict[str, tuple[tuple[Group, tuple[str, ...]], ...]] = {
            task: tuple((group, tuple(sorted(group - {task}))) for group in self.groups if task in group)
            for task in self.tasks
        }
        self.partners.update((task, ()) for task in never if task not in self.partners)
        """For each task the groups that it is in, with the others in them."""
        self.pairs: dict[str, tuple[str, ...]] = {
            task: tuple([others[0] for _, others in groups])
            for task, groups in self.partners.items()
            if all(len(others) == 1 for _, others in groups)
        }
        """For tasks that only meet one other at a time, who that may be."""
        self._kept: dict[Values, Offer] = {}
        self.open = Offer(self, (ANY,) * len(self.types), kept=True)
        """What :meth:`get` gives: not to be changed."""

    def put(self, *values: Any) -> Offer:
        """Offer the event with these values, and no other."""
        return self._offer(values)

    def meet(self) -> Offer:
        """Offer the event of a channel without fields."""
        return self._offer(())

    def get(self) -> Offer:
        """Offer all events of the channel: whatever values come."""
        return self.open

    def offer(
        self,
        *fields: Any,
        accept: Callable[..., bool] | None = None,
        after: float | None = None,
    ) -> Offer:
        """Offer some events of the channel.

        Args:
            fields: for each field a value, :data:`ANY` or :func:`one_of`.
            accept: further condition on the values of all fields.
            after: from which time on (of the program's clock) the offer stands.
        """
        return self._offer(fields) if accept is None and after is None else Offer(self, fields, accept, None, after)

    def own(self, body: Callable[..., Any], *fields: Any, after: float | None = None) -> Offer:
        """Offer an event that the task performs alone: a method.

        When the offer is taken, ``body`` is called with the values among *fields*; if there are open fields, it
        returns a value for the only one, or a tuple of values for several. The event is recorded after that.
        """
        return Offer(self, fields, None, body, after)

    def _offer(self, fields: tuple[Any, ...]) -> Offer:
        """The offer with these fields: the one that was made before, as long as there are few."""
        try:
            offer = self._kept.get(fields)
        except TypeError:  # unhashable: no value of any type
            return Offer(self, fields)
        kinds = tuple(map(type, fields))  # 1 and True are two values, and equal
        if offer is not None and tuple(map(type, offer.fields)) == kinds:
            return offer
        if offer is None and len(self._kept) < KEPT and _KEEPABLE.issuperset(kinds):
            return self._kept.setdefault(fields, Offer(self, fields, kept=True))
        return Offer(self, fields)

    def field_name(self, position: int) -> str:
        """What messages call a field, counted from 0."""
        return self.name if len(self.types) == 1 else f"{self.name}, field {position + 1}"

    def text(self, values: Values) -> str:
        """An event as the specification writes it."""
        return ".".join([self.name, *[t.text(value) for t, value in zip(self.types, values, strict=True)]])

    def __repr__(self) -> str:
        return f"<channel {self.name}>"


_KEEPABLE = frozenset((int, bool, str, _Open))
"""The types of values that are the same wherever they are equal."""


def _group(tasks: str | Iterable[str]) -> Group:
    return frozenset((tasks,)) if isinstance(tasks, str) else frozenset(tasks)


@dataclass(slots=True, eq=False)
class Offer:
    """What a task is ready to do on a channel. Make with the methods of :class:`Channel`; not to be changed."""

    channel: Channel
    fields: tuple[Any, ...]
    accept: Callable[..., bool] | None = None
    body: Callable[..., Any] | None = None
    after: float | None = None
    plain: bool = False
    """Whether it is known that its fields are values, all of them."""
    kept: bool = False
    """Whether the same object is used again for the same offer."""

    def check(self, task: str) -> None:
        """Make sure that the values among the fields are of the channel's types.

        Raises:
            OutOfRange: one is not.
            WrongOffer: the task is no party of the channel, or the number of fields is wrong.
        """
        channel = self.channel
        if task not in channel.partners:
            raise WrongOffer(f"{task} takes no part in {channel.name}, which joins {', '.join(channel.tasks)}")
        if len(self.fields) != len(channel.types):
            raise WrongOffer(f"{channel.name} has {len(channel.types)} fields, {task} offers {len(self.fields)}")
        plain = True
        for i, declared in enumerate(channel.types):
            value = self.fields[i]
            if value is ANY or type(value) is OneOf:
                plain = False
            elif not declared.contains(value):
                declared.check(value, task, channel.field_name(i))
        self.plain = plain

    def standing_from(self, time: float | None) -> Offer:
        """The same offer, which stands from some time on."""
        return Offer(self.channel, self.fields, self.accept, self.body, time)

    def groups(self) -> frozenset[Group] | None:
        """The groups that can perform the event, if the offer is of one event of a channel that lists them."""
        by_event = self.channel.by_event
        if by_event is None or any(field is ANY or isinstance(field, OneOf) for field in self.fields):
            return None
        return by_event.get(self.fields, frozenset())

    def text(self) -> str:
        """``c.3?``, for messages."""
        out = self.channel.name
        for declared, value in zip(self.channel.types, self.fields, strict=True):
            if value is ANY:
                out += "?"
            elif isinstance(value, OneOf):
                out += f"?{{{', '.join(sorted(map(declared.text, value.values)))}}}"
            else:
                out += f".{declared.text(value)}"
        return out


class WrongOffer(Exception):
    """An offer that the channel does not know: a mistake in the program."""
