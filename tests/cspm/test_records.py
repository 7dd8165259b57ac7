"""Data classes that are completed when they are first used are those of the standard library."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import FrozenInstanceError, field, fields, is_dataclass, replace
from itertools import product
from typing import Any, ClassVar

import pytest

from cspcheck.cspm import records

OPTIONS = [
    dict(zip(("frozen", "slots", "eq", "repr", "kw_only"), chosen, strict=True))
    for chosen in product((False, True), repeat=5)
]


def made(dataclass: Callable[..., Any], options: dict[str, bool]) -> tuple[type[Any], type[Any]]:
    """A class and one derived from it, of the same text whoever makes them."""

    @dataclass(**options)
    class Base:
        """Some fields."""

        kind: ClassVar[str] = "base"
        first: int
        second: str = "two"
        hidden: int = field(default=5, compare=False, repr=False)

        def __post_init__(self) -> None:
            if self.first < 0:
                raise ValueError(self.first)

        @property
        def doubled(self) -> int:
            return 2 * self.first

    @dataclass(**options)
    class Derived(Base):
        """More of them, and one again with another default."""

        kind: ClassVar[str] = "derived"
        second: str = "zwei"
        items: list[int] = field(default_factory=list)

    return Base, Derived


def seen(make: Callable[[], Any]) -> Any:
    """What can be seen of a call: its value as text, or its exception."""
    try:
        return re.sub(r"0x[0-9a-f]+", "0x", repr(make()))
    except Exception as error:
        return type(error), str(error)


def everything(cls: type[Any], options: dict[str, bool]) -> list[Any]:
    """All that a data class does."""
    found = [
        seen(lambda: cls(first=1)),
        seen(lambda: cls(1, "b")),
        seen(lambda: cls()),
        seen(lambda: cls(first=-1)),
        seen(lambda: cls(first=1, other=2)),
        seen(lambda: (cls.second, cls.hidden) if not options["slots"] else ""),
        seen(lambda: cls.items),
        seen(lambda: cls(first=1) == cls(first=1, hidden=7)),
        seen(lambda: cls(first=1) == cls(first=2)),
        seen(lambda: cls(first=1) == 1),
        seen(lambda: len({hash(one) for one in [cls(first=1), cls(first=1)]})),
        seen(lambda: {f.name: (f.default, f.compare) for f in fields(cls)}),
        seen(lambda: replace(cls(first=1), second="c").second),
        seen(lambda: copy.copy(cls(first=3)).first),
        seen(lambda: cls.__match_args__),
        seen(lambda: (cls.kind, cls.__doc__, cls.__qualname__.split(".")[-1], is_dataclass(cls))),
        seen(lambda: cls(first=4).doubled),
        seen(lambda: hasattr(cls(first=1), "__dict__")),
        seen(lambda: sorted(cls.__slots__) if options["slots"] else ""),
    ]
    one = cls(first=1)

    def change(name: str) -> Any:
        setattr(one, name, 9)
        return getattr(one, name)

    def delete() -> None:
        del one.first

    unknown = seen(lambda: change("unknown"))
    if options["frozen"] and options["slots"]:
        unknown = isinstance(unknown, tuple)  # it is refused; Python 3.11 has a TypeError about `super` for it
    return [*found, seen(lambda: change("first")), unknown, seen(delete)]


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: "-".join(n for n in options if options[n]) or "plain")
def test_a_class_does_what_one_of_the_standard_library_does(options: dict[str, bool]) -> None:
    """Whatever is asked first, and of the derived class first or of its base."""
    theirs = [everything(cls, options) for cls in made(dataclasses.dataclass, options)]
    assert [everything(cls, options) for cls in made(records.dataclass, options)] == theirs
    assert [everything(cls, options) for cls in reversed(made(records.dataclass, options))] == theirs[::-1]
    for look in (fields, is_dataclass, lambda cls: cls.__match_args__):
        ours = made(records.dataclass, options)[1]
        look(ours)
        assert everything(ours, options) == theirs[1]


@records.dataclass(frozen=True, slots=True)
class Pickled:
    """On the level of the module, where pickle finds it."""

    first: int
    second: tuple[int, ...] = (1,)


def test_pickled_before_anything_else_is_asked() -> None:
    """An object can come out of a pickle before one was ever made."""
    text = pickle.dumps(Pickled(3))
    code = (
        "import pickle, sys; from tests.cspm.test_records import Pickled;"
        f"one = pickle.loads({text!r}); print(hash(one) == hash(Pickled(3)), one)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert found.stdout == "True Pickled(first=3, second=(1,))\n"


def test_matched_before_anything_else_is_asked() -> None:
    """Patterns by position know the fields."""

    @records.dataclass(frozen=True)
    class Pair:
        left: int
        right: int

    def left_of(value: Any) -> int:
        match value:
            case Pair(left, _):
                return left
        return 0

    assert (left_of(1), left_of(Pair(5, 6))) == (0, 5)


def test_many_threads_may_be_the_first() -> None:
    """The class is completed once."""
    for _ in range(20):

        @records.dataclass(frozen=True, slots=True)
        class Value:
            number: int
            name: str = "n"

        start = threading.Barrier(8)
        found: list[Any] = []

        def use(start: threading.Barrier = start, found: list[Any] = found, cls: Any = Value) -> None:
            start.wait()
            found.append(cls(1))

        threads = [threading.Thread(target=use) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert found == [Value(1)] * 8


def test_a_class_with_methods_of_its_own_keeps_them() -> None:
    """What the class says itself is not replaced."""

    @records.dataclass(frozen=True, slots=True)
    class Own:
        number: int

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Own)

        def __hash__(self) -> int:
            return 3

        def __repr__(self) -> str:
            return "own"

    assert (Own(1) == Own(2), hash(Own(1)), repr(Own(1))) == (True, 3, "own")
    with pytest.raises(FrozenInstanceError):
        Own(1).number = 2  # type: ignore[misc]


def test_nothing_is_written_for_a_class_that_nobody_uses() -> None:
    """That is what it is for: no text is compiled."""
    code = (
        "import builtins, sys; from cspcheck.cspm.records import dataclass;"
        "sys.addaudithook(lambda event, _: print(event) if event in ('exec', 'compile') else None);"
        "dataclass(frozen=True, slots=True)(type('A', (), {'__annotations__': {'a': 'int'}}));"
        "print('dataclasses' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert found.stdout == "False\n"
