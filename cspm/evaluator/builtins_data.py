"""The built-in functions on sets, sequences and maps, and the relational ones that ``external`` imports."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.values import dots, messages as messages
from cspcheck.cspm.values.comparison import equal
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.set_algebra import difference, intersection, union
from cspcheck.cspm.values.sets import EMPTY_SET, EventsSet, Set, set_of
from cspcheck.cspm.values.symbolic_sets import CHARACTERS, INTEGERS, PROCESSES, Maps, Sequences, Subsets
from cspcheck.cspm.values.thunks import Env, Thunk, force
from cspcheck.cspm.values.values import (
    EMPTY_SEQUENCE,
    FALSE,
    FRUITLESS,
    STEPS,
    TRUE,
    Boolean,
    Map,
    Sequence,
    boolean,
    deep,
    string,
)

DATA: dict[str, Any] = {
    "True": TRUE,
    "False": FALSE,
    "Bool": set_of((FALSE, TRUE)),
    "Int": INTEGERS,
    "Char": CHARACTERS,
    "Proc": PROCESSES,
    "emptyMap": Map({}),
}
"""The built-in values and functions that know nothing of the script."""

F = TypeVar("F", bound=Callable[..., Any])


def builtin(name: str, kinds: str) -> Callable[[F], F]:
    """Register the decorated function; for *kinds* see ``cspcheck.cspm.evaluator.builtins``."""

    def register(function: F) -> F:
        DATA[name] = Builtin(name, kinds, function)
        return function

    return register


def as_set(value: Any) -> Set:
    """*value*, which must be a set.

    Raises:
        Failure: it is something else.
    """
    if isinstance(value, Set):
        return value
    raise Failure(messages.wrong_kind("a set", value))


def as_sequence(value: Any) -> Sequence:
    """*value*, which must be a sequence.

    Raises:
        Failure: it is something else.
    """
    if type(value) is Sequence:
        return value
    raise Failure(messages.wrong_kind("a sequence", value))


def as_map(value: Any) -> Map:
    """*value*, which must be a map.

    Raises:
        Failure: it is something else.
    """
    if type(value) is Map:
        return value
    raise Failure(messages.wrong_kind("a map", value))


def as_pair(value: Any) -> tuple[Any, Any]:
    """*value*, which must be a pair.

    Raises:
        Failure: it is something else.
    """
    value = force(value)
    if type(value) is tuple and len(value) == 2:
        return value
    raise Failure(messages.wrong_kind("a pair", value))


# --- sets ----------------------------------------------------------------------------------------------------


@builtin("union", "vv")
def _union(left: Any, right: Any) -> Set:
    return union(as_set(left), as_set(right))


@builtin("inter", "vv")
def _inter(left: Any, right: Any) -> Set:
    return intersection(as_set(left), as_set(right))


@builtin("diff", "vv")
def _diff(left: Any, right: Any) -> Set:
    return difference(as_set(left), as_set(right))


@builtin("Union", "v")
def _union_all(sets: Any) -> Set:
    found = [as_set(s) for s in as_set(sets).elements()]
    events = [s for s in found if type(s) is EventsSet]
    if events and len(events) == len(found):
        return EventsSet.of_ranges([r for s in events for r in s.events.ranges], events[0].channels)
    result: Set = EMPTY_SET
    for s in found:
        result = union(result, s)
    return result


@builtin("Inter", "v")
def _intersection_all(sets: Any) -> Set:
    found = [as_set(s) for s in as_set(sets).elements()]
    if not found:
        return EMPTY_SET
    result = found[0]
    for s in found[1:]:
        result = intersection(result, s)
    return result


@builtin("set", "v")
def _set(sequence: Any) -> Set:
    return set_of([deep(item) for item in as_sequence(sequence).items()])


@builtin("Set", "v")
def _subsets(base: Any) -> Set:
    return Subsets(as_set(base))


@builtin("Seq", "v")
def _sequences(base: Any) -> Set:
    return Sequences(as_set(base))


@builtin("Map", "vv")
def _maps(keys: Any, values: Any) -> Set:
    return Maps(as_set(keys), as_set(values))


@builtin("card", "v")
def _card(elements: Any) -> int:
    found = as_set(elements)
    if not found.is_finite():
        raise Failure(messages.infinite_set(found))
    return found.size()


@builtin("empty", "v")
def _empty(elements: Any) -> Boolean:
    return boolean(as_set(elements).is_empty())


@builtin("member", "vv")
def _member(value: Any, elements: Any) -> Boolean:
    return boolean(as_set(elements).contains(deep(value)))


@builtin("seq", "v")
def _seq(elements: Any) -> Sequence:
    return Sequence.of(as_set(elements).elements())


@builtin("productions", "v")
def _productions(value: Any) -> Set:
    return dots.completions(value)


@builtin("extensions", "v")
def _extensions(value: Any) -> Set:
    return dots.extensions(value)


# --- sequences -----------------------------------------------------------------------------------------------


@builtin("length", "v")
def length(sequence: Any) -> int:
    """The number of elements."""
    return len(as_sequence(sequence))


@builtin("null", "v")
def _null(sequence: Any) -> Boolean:
    return boolean(as_sequence(sequence).is_empty())


@builtin("head", "v")
def _head(sequence: Any) -> Any:
    step = as_sequence(sequence).uncons()
    if step is None:
        raise Failure(messages.empty_sequence("head"))
    return force(step[0])


@builtin("tail", "v")
def _tail(sequence: Any) -> Any:
    step = as_sequence(sequence).uncons()
    if step is None:
        raise Failure(messages.empty_sequence("tail"))
    return force(step[1])


@builtin("concat", "v")
def _concat(sequences: Any) -> Sequence:
    remaining = as_sequence(sequences)
    for _ in range(FRUITLESS):
        step = remaining.uncons()
        if step is None:
            return EMPTY_SEQUENCE
        first = as_sequence(force(step[0]))
        if not first.is_empty():
            return append(first, Thunk(_concat_rest, (step[1],)))
        remaining = as_sequence(force(step[1]))
    raise Failure(messages.nothing_found(FRUITLESS), is_limit=True)


def _concat_rest(env: Env) -> Sequence:
    return _concat(force(env[0]))


def append(left: Sequence, right: Any) -> Sequence:
    """``left ^ right``, where *right* may be a thunk: nothing of it is evaluated before it is needed."""
    rest = left.rest
    if rest is not None:
        return left.with_rest(Thunk(_append_rest, (rest, right)))
    if type(right) is Thunk:
        if right.code is not None:
            return left.with_rest(right) if left else as_sequence(right.force())
        right = right.value
    if type(right) is not Sequence:
        raise Failure(messages.wrong_kind("a sequence", right))
    return left.concat(right)


def _append_rest(env: Env) -> Sequence:
    """``rest ^ right`` for the rest of a sequence.

    Where that is such a concatenation itself, ``(a ^ b) ^ c`` becomes ``a ^ (b ^ c)``: so what has been appended to
    on many levels is passed through once, not once for each level.
    """
    rest, right = env
    while type(rest) is Thunk and rest.code is _append_rest:
        assert rest.env is not None
        first, second = rest.env
        rest, right = first, Thunk(_append_rest, (second, right))
    return append(as_sequence(force(rest)), right)


@builtin("elem", "vv")
def _elem(value: Any, sequence: Any) -> Boolean:
    remaining: Any = as_sequence(sequence)
    passed = 0
    while True:
        step = as_sequence(force(remaining)).uncons()
        if step is None:
            return FALSE
        if equal(value, force(step[0])):
            return TRUE
        remaining = step[1]
        passed += 1
        # What is there already is looked through to its end; only what is still to be made may have none.
        if passed > STEPS and type(remaining) is Thunk and remaining.code is not None:
            raise Failure(messages.nothing_found(STEPS), is_limit=True)


# --- maps ----------------------------------------------------------------------------------------------------


@builtin("mapFromList", "v")
def _map_from_list(pairs: Any) -> Map:
    return _updated({}, as_sequence(pairs).items())


@builtin("mapToList", "v")
def _map_to_list(mapping: Any) -> Sequence:
    from cspcheck.cspm.values.order import in_order

    entries = as_map(mapping).entries
    return Sequence.of([(key, entries[key]) for key in in_order(entries)])


@builtin("mapLookup", "vv")
def _map_lookup(mapping: Any, key: Any) -> Any:
    entries = as_map(mapping).entries
    key = deep(key)
    if key not in entries:
        raise Failure(messages.missing_key(key, mapping))
    return force(entries[key])


@builtin("mapMember", "vv")
def _map_member(mapping: Any, key: Any) -> Boolean:
    return boolean(deep(key) in as_map(mapping).entries)


@builtin("mapUpdate", "vvl")
def _map_update(mapping: Any, key: Any, value: Any) -> Map:
    return Map({**as_map(mapping).entries, deep(key): value})


@builtin("mapUpdateMultiple", "vv")
def _map_update_multiple(mapping: Any, pairs: Any) -> Map:
    # As in FDR the first of several values for one key is the one that stays; in `mapFromList` it is the last.
    return _updated(dict(as_map(mapping).entries), reversed(as_sequence(pairs).items()))


def _updated(entries: dict[Any, Any], pairs: Iterable[Any]) -> Map:
    for pair in pairs:
        key, value = as_pair(pair)
        entries[deep(force(key))] = value
    return Map(entries)


@builtin("mapDelete", "vv")
def _map_delete(mapping: Any, key: Any) -> Map:
    entries = dict(as_map(mapping).entries)
    entries.pop(deep(key), None)
    return Map(entries)


# --- texts ---------------------------------------------------------------------------------------------------


@builtin("show", "v")
def _show(value: Any) -> Sequence:
    from cspcheck.cspm.values.text import show

    return string(show(value))


@builtin("error", "v")
def _error(text: Any) -> Any:
    characters = [str(c) for c in as_sequence(text).values()]
    raise Failure(messages.error_called("".join(characters)))


# --- relations -----------------------------------------------------------------------------------------------


def _pairs(relation: Any) -> list[tuple[Any, Any]]:
    return [as_pair(pair) for pair in as_set(relation).elements()]


@builtin("relational_image", "v")
def _relational_image(relation: Any) -> Builtin:
    images: dict[Any, list[Any]] = {}
    for left, right in _pairs(relation):
        images.setdefault(left, []).append(right)
    known = {left: set_of(found) for left, found in images.items()}
    return Builtin("relational_image(...)", "v", lambda x: known.get(deep(x), EMPTY_SET), as_set(relation).canonical())


@builtin("relational_inverse_image", "v")
def _relational_inverse_image(relation: Any) -> Builtin:
    images: dict[Any, list[Any]] = {}
    for left, right in _pairs(relation):
        images.setdefault(right, []).append(left)
    known = {right: set_of(found) for right, found in images.items()}
    return Builtin(
        "relational_inverse_image(...)", "v", lambda x: known.get(deep(x), EMPTY_SET), as_set(relation).canonical()
    )


@builtin("transpose", "v")
def _transpose(relation: Any) -> Set:
    return set_of([(right, left) for left, right in _pairs(relation)])


@builtin("mtransclose", "vv")
def _mtransclose(relation: Any, elements: Any) -> Set:
    """Pairs (representative, other) of the classes that the relation's symmetric, transitive closure makes.

    The representative of a class is its least element in the set; only elements of the set appear.
    """
    parent: dict[Any, Any] = {}

    def root(x: Any) -> Any:
        while parent.setdefault(x, x) is not x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    for left, right in _pairs(relation):
        parent[root(left)] = root(right)
    least: dict[Any, Any] = {}
    found: list[tuple[Any, Any]] = []
    for element in as_set(elements).elements():
        representative = least.setdefault(root(element), element)
        if representative is not element:
            found.append((representative, element))
    return set_of(found)
