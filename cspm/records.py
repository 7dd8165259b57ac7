"""Data classes whose methods are written when one of them is first called.

:func:`dataclasses.dataclass` writes the text of up to six methods for each class and compiles it, half a millisecond a
class. Of the hundreds of classes of this package a run uses few; here the others cost nothing. The first call of a
method, or the first look at the fields, has the standard library complete the class, which is then what it would have
been from the beginning.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from threading import RLock
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from dataclasses import dataclass as dataclass
else:

    def dataclass(cls: type[Any] | None = None, /, **options: Any) -> Any:
        """As :func:`dataclasses.dataclass`, with its options."""
        if cls is None:
            return lambda cls: _prepared(cls, options)
        return _prepared(cls, options)


T = TypeVar("T")

_AT_ONCE = frozenset({"order", "unsafe_hash", "weakref_slot", "init", "match_args"})
"""Options that are too rare to be worth waiting for."""
_FIRST_LOOKED_AT = ("__dataclass_fields__", "__dataclass_params__", "__match_args__")

_completing = RLock()
_waiting: dict[type[Any], Callable[[], None]] = {}
"""How each class is completed that has not been."""


def _prepared(cls: type[T], options: dict[str, Any]) -> type[T]:
    """The class with stand-ins for its methods; the class itself, or with ``slots`` one in its place."""
    if not _AT_ONCE.isdisjoint(options) or not vars(cls).keys().isdisjoint({"__eq__", "__hash__", "__slots__"}):
        return _finished(cls, options)
    options = dict(options)
    frozen = options.get("frozen", False)
    defaults: dict[str, Any] | None = None
    if options.pop("slots", False):
        cls, defaults = _with_slots(cls, frozen=frozen)
    given = vars(cls)
    stand_ins: dict[str, Any] = {name: _Attribute(cls, name) for name in _FIRST_LOOKED_AT if name not in given}
    methods = ["__init__"]
    if options.get("repr", True):
        methods.append("__repr__")
    if options.get("eq", True):
        methods.append("__eq__")
        if frozen:
            methods.append("__hash__")
        else:
            cls.__hash__ = None  # type: ignore[assignment]
    if frozen:
        methods += ["__setattr__", "__delattr__"]
    stand_ins |= {name: _method(cls, name) for name in methods if name not in given}
    for name, value in stand_ins.items():
        setattr(cls, name, value)

    def complete() -> None:
        for name in stand_ins:
            delattr(cls, name)
        members = _put_back(cls, defaults or {})
        _finished(cls, options)
        for name, member in members.items():
            if member is None:
                delattr(cls, name)
            else:
                setattr(cls, name, member)

    _waiting[cls] = complete
    return cls


def _finished(cls: type[T], options: dict[str, Any]) -> type[T]:
    # With it comes `inspect`: a third of the time that `cspcheck --help` may take.
    import dataclasses

    return dataclasses.dataclass(**options)(cls)


def _completed(cls: type[Any]) -> None:
    with _completing:
        complete = _waiting.pop(cls, None)
        if complete is not None:
            complete()


def _method(cls: type[Any], name: str) -> Callable[..., Any]:
    def stand_in(self: Any, *arguments: Any, **named: Any) -> Any:
        _completed(cls)
        return getattr(cls, name)(self, *arguments, **named)

    return stand_in


class _Attribute:
    """An attribute of a class that the class has when it is complete."""

    def __init__(self, owner: type[Any], name: str) -> None:
        self._owner = owner
        self._name = name

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        _completed(self._owner)
        return getattr(self._owner, self._name)


def _with_slots(cls: type[Any], *, frozen: bool) -> tuple[type[Any], dict[str, Any]]:
    """The same class with slots for its fields, and their defaults, which a class with slots cannot keep."""
    attributes = dict(vars(cls))
    names = [
        name
        for name, written in attributes.get("__annotations__", {}).items()
        if not written.startswith(("ClassVar", "typing.ClassVar"))
    ]
    inherited = set(chain.from_iterable(vars(base).get("__slots__", ()) for base in cls.__mro__[1:-1]))
    attributes["__slots__"] = tuple(name for name in names if name not in inherited)
    defaults = {name: attributes.pop(name) for name in names if name in attributes}
    attributes.pop("__dict__", None)
    attributes.pop("__weakref__", None)
    kind: Callable[..., type[Any]] = type(cls)
    made = kind(cls.__name__, cls.__bases__, attributes)
    made.__qualname__ = cls.__qualname__
    if frozen:
        made.__getstate__ = attributes.get("__getstate__", _state)
        made.__setstate__ = attributes.get("__setstate__", _set_state)
    return made, defaults


def _put_back(cls: type[Any], defaults: dict[str, Any]) -> dict[str, Any]:
    """Give the fields their defaults, for the standard library to read; the slots that have to come back afterwards."""
    members = {name: vars(cls).get(name) for name in defaults}
    for name, default in defaults.items():
        setattr(cls, name, default)
    return members


def _state(self: Any) -> list[Any]:
    """What is pickled of an object with slots that cannot be changed."""
    from dataclasses import fields

    return [getattr(self, field.name) for field in fields(self)]


def _set_state(self: Any, state: list[Any]) -> None:
    from dataclasses import fields

    for field, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, field.name, value)
