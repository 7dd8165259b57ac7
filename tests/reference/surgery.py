"""Taking process terms apart: parts, rebuilding, near relatives of a process, and smaller ones for shrinking.

Relatives are what makes refinement tests worth running: two independent random processes nearly always differ after the
empty trace; a process and one in which a single operand was changed refine each other about half the time.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields

from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    ExternalChoice,
    InternalChoice,
    Process,
    Reference,
    SlidingChoice,
)
from tests.reference.processes import Generator, Scope, define


def parts(process: Process) -> list[Process]:
    """The operands and continuations of a term; a reference has none."""
    if isinstance(process, Reference):
        return []
    found: list[Process] = []
    for field in fields(process):
        _collect(getattr(process, field.name), found)
    return found


def _collect(value: object, found: list[Process]) -> None:
    if isinstance(value, Process):
        found.append(value)
    elif isinstance(value, tuple):
        for item in value:
            _collect(item, found)


def rebuilt(process: Process, new: list[Process]) -> Process:
    """The term with other parts in place of its own, in the order of :func:`parts`."""
    if isinstance(process, Reference):
        return process
    supply = iter(new)

    def exchange(value: object) -> object:
        if isinstance(value, Process):
            return next(supply)
        if isinstance(value, tuple):
            return tuple(exchange(item) for item in value)
        return value

    rebuilt_process: Process = type(process)(*(exchange(getattr(process, field.name)) for field in fields(process)))
    return rebuilt_process


def references(process: Process) -> list[Reference]:
    """All names that a process leads to."""
    found: dict[Reference, None] = {}
    todo = [process]
    while todo:
        term = todo.pop()
        if isinstance(term, Reference):
            if term not in found:
                found[term] = None
                todo.append(term.body())
        else:
            todo.extend(parts(term))
    return list(found)


def closed(process: Process) -> bool:
    return not references(process)


def substituted(process: Process, new: Mapping[Reference, Process]) -> Process:
    if isinstance(process, Reference):
        return new.get(process, process)
    return rebuilt(process, [substituted(part, new) for part in parts(process)])


def with_body(process: Process, changed: Reference, body: Process) -> Process:
    """The process with another definition of one of its names: all its names are defined anew."""
    names = references(process)

    def bodies(fresh: tuple[Reference, ...]) -> list[Process]:
        renaming = dict(zip(names, fresh, strict=True))
        return [substituted(body if name is changed else name.body(), renaming) for name in names]

    fresh = define(bodies, len(names))
    return substituted(process, dict(zip(names, fresh, strict=True)))


def positions(process: Process) -> Iterator[tuple[Process, Callable[[Process], Process]]]:
    """Each subterm with the function that puts another one in its place. Names are not looked into."""
    yield process, lambda new: new
    own = parts(process)
    for i, part in enumerate(own):
        for subterm, put in positions(part):
            yield subterm, lambda new, i=i, put=put: rebuilt(process, [*own[:i], put(new), *own[i + 1 :]])  # type: ignore[misc]


def relative(process: Process, rng: random.Random, letters: int = 3) -> Process:
    """The process with one small change somewhere: in the term, or in the definition of one of its names.

    It has finitely many states as well, but the change may have taken away the guard of a recursion.
    """
    names = references(process)
    if names and rng.random() < 0.6:
        name = rng.choice(names)
        return with_body(process, name, _changed(name.body(), rng, letters))
    return _changed(process, rng, letters)


def _changed(process: Process, rng: random.Random, letters: int) -> Process:
    subterm, put = rng.choice(list(positions(process)))
    fresh = Generator(rng.randrange, letters).term(rng.randrange(1, 4), Scope())
    ways: list[Callable[[], Process]] = [
        lambda: fresh,
        lambda: InternalChoice((subterm, fresh)),
        lambda: InternalChoice((subterm, STOP)),
        lambda: ExternalChoice((subterm, fresh)),
        lambda: SlidingChoice(subterm, fresh),
        lambda: SlidingChoice(fresh, subterm),
    ]
    own = parts(subterm)
    if own and closed(subterm):
        ways += [lambda: rng.choice(own)] * 2
    if len(own) > 1 and closed(subterm):
        ways += [lambda: rebuilt(subterm, [own[-1], *own[1:-1], own[0]])]
    return put(rng.choice(ways)())


def smaller(process: Process) -> Iterator[Process]:
    """Simpler processes, the simplest first: what to try when a process shows a fault.

    Repeated trying comes to an end: each is smaller, or has smaller definitions, or has one name less.
    """
    yield from _smaller_term(process)
    names = references(process)
    for name in names:
        for body in _smaller_term(name.body()):
            yield with_body(process, name, body)
    for name in names:
        if name not in references(name.body()):  # then unfolding it everywhere gets rid of it
            yield _unfolded(process, name)


def _unfolded(process: Process, name: Reference) -> Process:
    if process is name:
        return name.body()
    return substituted(process, {name: name.body()})


def _smaller_term(process: Process) -> Iterator[Process]:
    for simple in (STOP, SKIP, DIV):
        if process is simple:
            return
        yield simple
    own = parts(process)
    yield from own
    if isinstance(process, ExternalChoice | InternalChoice) and len(own) > 2:
        for i in range(len(own)):
            yield type(process)((*own[:i], *own[i + 1 :]))
    for i, part in enumerate(own):
        for new in _smaller_term(part):
            yield rebuilt(process, [*own[:i], new, *own[i + 1 :]])
