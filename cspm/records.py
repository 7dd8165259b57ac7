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
_written: dict[type[Any], tuple[dict[str, Any], dict[str, Any]]] = {}
"""What the fields of a class are as it is written, in order, with their defaults; and its options."""


def _prepared(cls: type[T], options: dict[str, Any]) -> type[T]:
    """The class with stand-ins for its methods; the class itself, or with ``slots`` one in its place."""
    if not _AT_ONCE.isdisjoint(options) or not vars(cls).keys().isdisjoint({"__eq__", "__hash__", "__slots__"}):
        return _finished(cls, options)
    options = dict(options)
    frozen = options.get("frozen", False)
    slots = options.pop("slots", False)
    defaults = {name: vars(cls)[name] for name in _own_fields(cls) if name in vars(cls)}
    if slots:
        cls = _with_slots(cls, frozen=frozen)
    else:
        for name, default in defaults.items():
            if type(default).__module__ == "dataclasses":
                _set_default(cls, name, default)
    given = vars(cls)
    stand_ins: dict[str, Any] = {name: _Attribute(cls, name) for name in _FIRST_LOOKED_AT if name not in given}
    methods = []
    if "__init__" not in given:
        stand_ins["__init__"] = _first_init(cls)
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
    _written[cls] = ({name: defaults.get(name, _NONE) for name in _own_fields(cls)}, options)

    def complete() -> None:
        for name in stand_ins:
            delattr(cls, name)
        # The standard library reads the defaults where slots are, which have to come back afterwards.
        members = {name: vars(cls).get(name) for name in defaults} if slots else {}
        for name, default in defaults.items():
            setattr(cls, name, default)
        _finished(cls, options)
        for name, member in members.items():
            if member is None:
                delattr(cls, name)
            else:
                setattr(cls, name, member)

    _waiting[cls] = complete
    return cls


def _set_default(cls: type[Any], name: str, field: Any) -> None:
    """What a class shows in the place of a field: its default, if it has one."""
    from dataclasses import MISSING

    if field.default is MISSING:
        delattr(cls, name)
    else:
        setattr(cls, name, field.default)


def _own_fields(cls: type[Any]) -> list[str]:
    annotations: dict[str, str] = vars(cls).get("__annotations__", {})
    return [name for name, written in annotations.items() if not written.startswith(("ClassVar", "typing.ClassVar"))]


_NONE: Any = object()
"""In the place of a default that there is not."""


def _first_init(cls: type[Any]) -> Callable[..., None]:
    """What makes the first object: most classes that are used at all are only made objects of."""

    def stand_in(self: Any, *arguments: Any, **named: Any) -> None:
        with _completing:
            if vars(cls).get("__init__") is stand_in:
                init = _init_of(cls)
                if init is None:
                    _completed(cls)
                else:
                    cls.__init__ = init
        cls.__init__(self, *arguments, **named)

    return stand_in


def _init_of(cls: type[Any]) -> Callable[..., None] | None:
    """The method ``__init__`` alone, as the standard library writes it; None where it has to do more than usual."""
    from dataclasses import MISSING, Field

    fields: dict[str, tuple[Any, bool]] = {}
    for base in reversed(cls.__mro__):
        if base in _written:
            written, options = _written[base]
            for name, default in written.items():
                fields[name] = default, options.get("kw_only", False)
        elif "__dataclass_fields__" in vars(base):
            return None
    frozen = _written[cls][1].get("frozen", False)
    scope: dict[str, Any] = {"_set": object.__setattr__, "_missing": MISSING}
    positional: list[str] = []
    named: list[str] = []
    body: list[str] = []
    for name, (default, kw_only) in fields.items():
        value = name
        if isinstance(default, Field):
            if not default.init or default.kw_only is not MISSING:
                return None
            if default.default_factory is not MISSING:
                scope[f"_make_{name}"] = default.default_factory
                value = f"_make_{name}() if {name} is _missing else {name}"
                default = MISSING
            else:
                default = _NONE if default.default is MISSING else default.default
        scope[f"_default_{name}"] = default
        parameter = name if default is _NONE else f"{name}=_default_{name}"
        (named if kw_only else positional).append(parameter)
        body.append(f"_set(self, {name!r}, {value})" if frozen else f"self.{name} = {value}")
    if not set(scope).isdisjoint(fields) or "self" in fields:
        return None
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    parameters = ", ".join(["self", *positional, *(["*", *named] if named else [])])
    try:
        exec(f"def __init__({parameters}):\n " + "\n ".join(body or ["pass"]), scope)
    except SyntaxError:
        return None  # a field without a default behind one that has one, of which the standard library speaks
    init: Callable[..., None] = scope["__init__"]
    init.__qualname__ = f"{cls.__qualname__}.__init__"
    return init


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


def _with_slots(cls: type[Any], *, frozen: bool) -> type[Any]:
    """The same class with slots for its fields, without their defaults, which a class with slots cannot keep."""
    attributes = dict(vars(cls))
    names = _own_fields(cls)
    inherited = set(chain.from_iterable(vars(base).get("__slots__", ()) for base in cls.__mro__[1:-1]))
    attributes["__slots__"] = tuple(name for name in names if name not in inherited)
    for name in (*names, "__dict__", "__weakref__"):
        attributes.pop(name, None)
    kind: Callable[..., type[Any]] = type(cls)
    made = kind(cls.__name__, cls.__bases__, attributes)
    made.__qualname__ = cls.__qualname__
    if frozen:
        made.__getstate__ = attributes.get("__getstate__", _state)
        made.__setstate__ = attributes.get("__setstate__", _set_state)
    return made


def _state(self: Any) -> list[Any]:
    """What is pickled of an object with slots that cannot be changed."""
    from dataclasses import fields

    return [getattr(self, field.name) for field in fields(self)]


def _set_state(self: Any, state: list[Any]) -> None:
    from dataclasses import fields

    for field, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, field.name, value)
