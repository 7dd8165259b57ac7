"""The values that expressions have, sets, dotted values and processes apart.

=========== ==============================================================================================
integers    Python ``int``
Booleans    :data:`TRUE` and :data:`FALSE`. Not ``bool``: Python holds ``True == 1`` and ``hash(True) == hash(1)``,
            and neither sets nor the arguments that name a process may mix the two up
characters  Python ``str`` of length one
reals       :class:`Real`; only the classes of a script make them
tuples      Python ``tuple``
sequences   :class:`Sequence`
maps        :class:`Map`
functions   :class:`Function`, ``cspcheck.cspm.evaluator.builtins.Builtin``
sets        ``cspcheck.cspm.values.sets``
dotted      ``cspcheck.cspm.values.dots``: constructors, channels, events, and what is dotted together
processes   ``cspcheck.cspm.process.terms``
=========== ==============================================================================================

The items of tuples, sequences and maps may be thunks. :func:`deep` evaluates a value through and through; only then
can it be compared, hashed and kept in a set.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from fractions import Fraction
from math import inf
from typing import Any, Final

from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Env, Thunk

LONGEST: Final = 1 << 22
"""A sequence that is evaluated to its end may have so many elements."""
STEPS: Final = 1 << 18
"""Elements that a sequence gives one by one, each by evaluating what follows, may be so many."""
FRUITLESS: Final = 1 << 20
"""When so many elements were looked through in vain, whoever looks for another one gives up."""
WRITTEN_OUT: Final = 1 << 16
"""A range that is longer than this is listed as far as it is looked at."""
NESTING: Final = 2_000
"""Values may be nested so deep (recursive datatypes apart, which have no limit)."""


class Boolean:
    """``true`` or ``false``; there are two objects of this class."""

    __slots__ = ("truth",)

    def __init__(self, truth: bool) -> None:
        self.truth = truth

    def __bool__(self) -> bool:
        return self.truth

    def __repr__(self) -> str:
        return "true" if self.truth else "false"


TRUE: Final = Boolean(True)
FALSE: Final = Boolean(False)


def boolean(truth: bool) -> Boolean:
    """The value for a Python truth value."""
    return TRUE if truth else FALSE


class Real:
    """A real number. The language has no arithmetic for them: they come and go as values of events."""

    __slots__ = ("_hash", "_key", "value")

    def __init__(self, value: Fraction) -> None:
        self.value = value
        self._key: Fraction | float | None = None
        self._hash: int | None = None

    def is_same(self, other: Any) -> bool:
        """``==`` of the language."""
        return bool(self == other)

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Real) and self.value == other.value)

    def __hash__(self) -> int:
        if self._hash is None:  # that of a fraction takes a modular inverse
            self._hash = hash((Real, self.value))
        return self._hash

    @property
    def key(self) -> Fraction | float:
        """A number of the same size that is compared as fast as can be: a float where one is exact."""
        if self._key is None:
            try:
                near = float(self.value)
            except OverflowError:
                near = inf
            self._key = near if near == self.value else self.value
        return self._key

    def __repr__(self) -> str:
        from cspcheck.cspm.values.text import show_real

        return show_real(self.value)


class Sequence:
    """A finite or infinite sequence, evaluated as far as it has been looked at.

    The elements known so far are kept back to front in a list that sequences share: ``_items[_end - 1]`` down to
    ``_items[0]``. So a tail is another view of the same list, and putting an element in front appends to the list
    unless another sequence has done so already (then it is copied). ``_rest`` is a thunk for the sequence that
    follows them; None if there is none.
    """

    __slots__ = ("_deep", "_end", "_endless", "_hash", "_items", "_native", "_rest")

    _items: list[Any]
    _end: int
    _rest: Thunk | None

    def __init__(self, items: list[Any], end: int, rest: Thunk | None = None, endless: bool = False) -> None:
        self._items = items
        self._end = end
        self._rest = rest
        self._endless = endless
        self._deep = False
        self._hash: int | None = None
        self._native: tuple[Any, ...] | None = None

    @classmethod
    def of(cls, items: Iterable[Any]) -> Sequence:
        """The finite sequence of *items* (values or thunks)."""
        kept = list(items)
        kept.reverse()
        return cls(kept, len(kept))

    @classmethod
    def evaluated(cls, native: tuple[Any, ...]) -> Sequence:
        """The sequence that stands in a key as *native*."""
        made = cls(list(native[1:]), len(native) - 1)
        made._deep = True
        made._native = native
        return made

    @classmethod
    def lazy(cls, items: list[Any], rest: Thunk, *, endless: bool = False) -> Sequence:
        """*items*, then the sequence that *rest* evaluates to; *endless*: it certainly has no end."""
        return cls(items[::-1], len(items), rest, endless)

    @property
    def endless(self) -> bool:
        """Whether the sequence is known to have no end."""
        return self._endless

    @property
    def rest(self) -> Thunk | None:
        """The sequence behind the elements known so far; None if there is nothing."""
        return self._rest

    def with_rest(self, rest: Thunk) -> Sequence:
        """The elements known so far, and behind them the sequence that *rest* evaluates to."""
        return Sequence(self._items, self._end, rest, self._endless)

    def known_backward(self) -> list[Any]:
        """The elements known so far, the last of them first."""
        return self._items[: self._end]

    def uncons(self) -> tuple[Any, Any] | None:
        """First element and the rest (either may be a thunk); None for the empty sequence."""
        sequence: Sequence = self
        while True:
            rest = sequence._rest
            last = sequence._end - 1
            if last >= 0:
                items = sequence._items
                if rest is None:
                    return items[last], Sequence(items, last)
                return items[last], Sequence(items, last, rest, sequence._endless) if last else rest
            if rest is None:
                return None
            sequence = _following(rest)

    def cons(self, item: Any) -> Sequence:
        """*item* in front of this sequence."""
        items, end = self._items, self._end
        if end == 0:
            items = [item]
        elif end == len(items):
            items.append(item)
        elif items[end] is not item:
            items = items[:end]
            items.append(item)
        return Sequence(items, end + 1, self._rest, self._endless)

    def concat(self, other: Sequence) -> Sequence:
        """This sequence, which must be finite, and then *other*."""
        mine = self._backward()
        if not mine:
            return other
        items, end = other._items, other._end
        if end == 0:
            items = mine
        elif end == len(items):
            items.extend(mine)
        else:
            items = items[:end]
            items.extend(mine)
        return Sequence(items, end + len(mine), other._rest, other._endless)

    def forced(self) -> Sequence:
        """This sequence, known to its end.

        Raises:
            Failure: it has no end, as far as can be told, or is longer than :data:`LONGEST` or :data:`STEPS`.
        """
        if self._rest is None:
            return self
        known: list[Any] = []
        passed: list[tuple[Sequence, int]] = []
        seen: set[int] = set()
        sequence: Sequence = self
        while sequence._rest is not None:
            if sequence._endless or id(sequence) in seen:
                raise Failure(messages.infinite_sequence(), is_limit=True)
            passed.append((sequence, len(known)))
            seen.add(id(sequence))
            known.extend(sequence._items[: sequence._end][::-1])
            if len(known) + _still_counted(sequence._rest) > LONGEST:
                raise Failure(messages.too_long(LONGEST), is_limit=True)
            if len(passed) > STEPS:
                raise Failure(messages.too_long(len(known) - 1), is_limit=True)
            sequence = _following(sequence._rest)
        known.extend(sequence.items())
        known.reverse()
        for lazy, offset in passed:
            lazy._items = known
            lazy._end = len(known) - offset
            lazy._rest = None
        return self

    def _backward(self) -> list[Any]:
        self.forced()
        return self._items[: self._end]

    def items(self) -> list[Any]:
        """All elements in order, thunks among them, in a fresh list."""
        kept = self._backward()
        kept.reverse()
        return kept

    def values(self) -> list[Any]:
        """All elements in order, each evaluated."""
        kept = self.items()
        for i, item in enumerate(kept):
            if type(item) is Thunk:
                kept[i] = item.force()
        return kept

    def known(self) -> tuple[list[Any], bool]:
        """The elements known so far, and whether others may follow. Evaluates nothing."""
        items: list[Any] = []
        sequence: Any = self
        while sequence._rest is not None:
            items.extend(sequence._items[: sequence._end][::-1])
            rest = sequence._rest
            if rest.code is not None or len(items) > LONGEST:
                return items, True
            sequence = rest.value
            if type(sequence) is not Sequence:
                return items, True
        items.extend(sequence.items())
        return items, False

    def is_empty(self) -> bool:
        """Whether there is no first element."""
        if self._end or self._rest is None:
            return self._end == 0
        return self.uncons() is None

    def __len__(self) -> int:
        still = 0 if self._rest is None else _still_counted(self._rest)
        if still:
            return self._end + still
        self.forced()
        return self._end

    def __bool__(self) -> bool:
        return not self.is_empty()

    def __iter__(self) -> Iterator[Any]:
        return iter(self.values())

    def deep(self, level: int) -> Sequence:
        """This sequence with all elements evaluated through and through."""
        if not self._deep:
            self.forced()
            items = self._items
            # Mostly there is nothing to evaluate, which Python itself finds out faster.
            if not ATOMS.issuperset(map(type, items[: self._end])):
                for i in range(self._end):
                    item = items[i]
                    if type(item) is not int:
                        items[i] = deep(item, level)
            self._deep = True
        return self

    @property
    def native(self) -> tuple[Any, ...]:
        """What Python itself compares and hashes as it does this sequence: its class and its elements, evaluated.

        The last of them comes first.
        """
        if self._native is None:
            if not self._deep:
                self.deep(1)
            self._native = (Sequence, *self._items[: self._end])
        return self._native

    def _evaluated(self) -> list[Any]:
        if not self._deep:
            deep(self)
        return self._items[: self._end]

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Sequence):
            return False
        return len(self) == len(other) and self._evaluated() == other._evaluated()

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(tuple(self._evaluated()))
        return self._hash

    def __repr__(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)


def _following(rest: Thunk) -> Sequence:
    """What follows in a sequence; without types it may turn out to be something else.

    Raises:
        Failure: it has.
    """
    sequence = rest.force()
    if type(sequence) is not Sequence:
        raise Failure(messages.wrong_kind("a sequence", sequence))
    return sequence


def counting_from(low: int, size: int = 16) -> Sequence:
    """``<low..>``: generated in chunks that double, the first of *size*."""
    rest = Thunk(lambda env: counting_from(low + size, min(2 * size, 1 << 14)), ())
    return Sequence.lazy(list(range(low, low + size)), rest, endless=True)


def counting(low: int, high: int) -> Sequence:
    """``<low..high>``: in chunks like :func:`counting_from` if it is long."""
    if high - low < WRITTEN_OUT:
        return Sequence(list(range(high, low - 1, -1)), max(0, high - low + 1))
    return _count_on((low, high, 16))


def _count_on(env: Env) -> Sequence:
    low, high, size = env
    if high - low < size:
        return Sequence(list(range(high, low - 1, -1)), high - low + 1)
    return Sequence.lazy(list(range(low, low + size)), Thunk(_count_on, (low + size, high, min(2 * size, 1 << 14))))


def _still_counted(rest: Thunk) -> int:
    """How many elements follow if *rest* is the rest of a long range; else 0."""
    if rest.code is not _count_on:
        return 0
    assert rest.env is not None
    low, high, _ = rest.env
    return int(high - low + 1)


EMPTY_SEQUENCE: Final = Sequence([], 0)


def string(text: str) -> Sequence:
    """The sequence of the characters of *text*."""
    return Sequence.of(text)


class Map:
    """A finite map; keys are evaluated through and through, values may be thunks."""

    __slots__ = ("_deep", "_hash", "_native", "entries")

    def __init__(self, entries: dict[Any, Any]) -> None:
        self.entries = entries
        self._deep = False
        self._hash: int | None = None
        self._native: tuple[Any, ...] | None = None

    @classmethod
    def evaluated(cls, native: tuple[Any, ...]) -> Map:
        """The map that stands in a key as *native*."""
        made = cls(dict(native[1]))
        made._deep = True
        made._native = native
        return made

    @property
    def native(self) -> tuple[Any, ...]:
        """What Python itself compares and hashes as it does this map: its class and its entries, evaluated."""
        if self._native is None:
            self._native = (Map, frozenset(deep(self).entries.items()))
        return self._native

    def deep(self, level: int) -> Map:
        """This map with all values evaluated through and through."""
        if not self._deep:
            for key, value in self.entries.items():
                self.entries[key] = deep(value, level)
            self._deep = True
        return self

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Map) and deep(self).entries == deep(other).entries)

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset(deep(self).entries.items()))
        return self._hash

    def __repr__(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)


class Function:
    """A function of the script with the variables around it (``env``) and the arguments that it has so far.

    ``applied`` is the number of its parameter lists that have arguments already.
    ``routine`` is its definition (``cspcheck.cspm.evaluator.routines``). Two functions are the same in a process's
    arguments if they are of the same definition and the variables that it uses have the same values.
    """

    __slots__ = ("_hash", "_key", "applied", "collected", "env", "routine")

    def __init__(self, routine: Any, env: Env, collected: Env = (), applied: int = 0) -> None:
        self.routine = routine
        self.env = env
        self.collected = collected
        self.applied = applied
        self._key: Hashable = None
        self._hash = 0

    @property
    def key(self) -> Hashable:
        """What identifies the function, once :func:`deep` has been applied to it."""
        if self._key is None:
            deep(self)
        return self._key

    def identify(self, level: int) -> None:
        """Evaluate the variables that the function uses, so that it can be compared and hashed."""
        if self._key is None:
            captured = self.routine.captured(self.env, level)
            collected = tuple([deep(value, level) for value in self.collected])
            self._key = (self.routine, captured, collected, self.applied)
            self._hash = hash(self._key)

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, Function)
            and self.routine is other.routine
            and self.key == other.key
            and self._hash == other._hash
        )

    def __hash__(self) -> int:
        if self._key is None:
            deep(self)
        return self._hash

    def __repr__(self) -> str:
        return f"<function {self.routine.name}>"


ATOMS: Final = frozenset({int, str, Boolean, Real})


def deep(value: Any, level: int = 0) -> Any:
    """*value* evaluated through and through, sets in the form in which equal sets are equal objects' contents.

    Raises:
        Failure: an evaluation failed, or there is no end to it.
    """
    kind = type(value)
    if kind in ATOMS:
        return value
    if kind is Thunk:
        return value.settle(deep(value.force(), level))
    if level > NESTING:
        raise Failure(messages.nested_too_deep(NESTING), is_limit=True)
    if kind is tuple:
        for item in value:
            if type(item) not in ATOMS:
                return tuple([deep(item, level + 1) for item in value])
        return value
    if kind is Sequence:
        return value.deep(level + 1)
    if kind is Map:
        return value.deep(level + 1)
    if kind is Function:
        value.identify(level + 1)
        return value
    canonical: Callable[[], Any] | None = getattr(value, "canonical", None)
    return value if canonical is None else canonical()
