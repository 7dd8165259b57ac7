"""One total order on all values, so that whatever ranges over a set does so in the same order each time.

Integers and characters by size, ``false`` before ``true``, constructors and channels in the order of declaration;
tuples and sequences lexicographically (``<>``, ``<1, 1>``, ``<2>``), sets and maps as the ascending lists of what is in
them (``{}``, ``{1, 2, 4}``, ``{4}``). It is the order of FDR, so that ``seq`` and ``show`` say the same.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, Final, NamedTuple

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.values.dots import ChannelHead, Constructor, DotList, Dotted, Event
from cspcheck.cspm.values.values import Boolean, Function, Map, Real, Sequence

_LONGEST_TERM = 10_000
_KEPT: Final = 100
"""A constructor's value keeps its key if that is no longer: it is an element of one set after the other."""
_END: Final = object()
"""Closes what can have more or fewer parts; in a key it comes before all that a part could be."""


class _Closed(NamedTuple):
    """Behind the fields of a value in the stack: where its key begins, which is whole then."""

    value: Dotted
    begun: int


def in_order(values: Iterable[Any]) -> list[Any]:
    """The values, which must be evaluated through and through, in order."""
    found = list(values)
    kinds = set(map(type, found))
    if kinds == {int} or kinds == {str}:
        found.sort()
    elif kinds == {Event}:
        found.sort(key=_number)
    elif len(found) > 1:
        found.sort(key=order_key)
    return found


def _number(event: Event) -> int:
    return event.number


def order_key(value: Any) -> list[Any]:
    """A flat list that compares with those of other values as the values do."""
    key: list[Any] = []
    stack = [value]
    while stack:
        item = stack.pop()
        kind = type(item)
        if kind is Boolean:
            key += (0, item.truth)
        elif kind is int:
            key += (1, item)
        elif kind is str:
            key += (2, item)
        elif kind is Real:
            key += (1, item.key)
        elif kind is tuple:
            key.append(3)
            stack.extend(reversed(item))
        elif kind is Sequence:
            key.append(4)
            stack += (_END, *reversed(item.items()))
        elif kind is Map:
            entries = in_order(item.entries)
            key.append(6)
            stack.append(_END)
            for entry in reversed(entries):
                stack += (item.entries[entry], entry)
        elif kind is Dotted:
            if item.order is not None:
                key += item.order
                continue
            begun = len(key)
            head = item.head
            if isinstance(head, Constructor):
                key += (7, *head.rank)
            else:
                assert isinstance(head, ChannelHead)
                key += (8, head.declared.base, head.declared.order)
            if item.complete:
                stack.append(_Closed(item, begun))
            stack += (_END, *reversed(item.fields))
        elif kind is _Closed:
            if len(key) - item.begun <= _KEPT:
                item.value.order = tuple(key[item.begun :])
        elif kind is Event:
            key += (9, item.number)
        elif kind is DotList:
            key.append(10)
            stack += (_END, *reversed(item.parts))
        elif isinstance(item, Process):
            key.append(12)
            _process_key(item, key)
        elif kind is Function:
            key += (13, item.routine.name)
        elif hasattr(item, "elements") and item.is_finite():
            key.append(5)
            stack += (_END, *reversed(item.finite().elements()))
        elif item is _END:
            key.append(-1)
        else:
            key += (14, repr(item))
    return key


def _process_key(process: Process, key: list[Any]) -> None:
    stack: list[Any] = [process]
    limit = len(key) + _LONGEST_TERM
    while stack and len(key) < limit:
        item = stack.pop()
        if isinstance(item, Reference):
            key += ("Reference", item.text)
        elif isinstance(item, Process):
            key.append(type(item).__name__)
            stack.extend(getattr(item, field.name) for field in reversed(fields(item)))
        elif isinstance(item, EventSet):
            key += (str(len(item.ranges)), str(item.ranges))
        elif isinstance(item, tuple):
            key.append(str(len(item)))
            stack.extend(reversed(item))
        else:
            key.append(str(item))
