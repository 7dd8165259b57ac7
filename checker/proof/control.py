"""What the CSP part of a class waits for: its control states, as far as they can be read off the equations.

A control state is a place in an equation: the start of ``main``, and what stands behind each event. Read off are
prefixes, choices, conditionals, sequences and names; an expression with anything else (parallel composition, hiding,
interrupts) is left to the search of the state space.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

from cspcheck.cspm.oz.core import ClassModel, ProcessPart
from cspcheck.cspm.oz.typing.equations import defined_name
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax

_DEEPEST = 20
_MOST = 32


@dataclass(frozen=True, slots=True)
class WaitingState:
    """One way in which a control state can wait.

    Attributes:
        channels: one of these events must happen next.
        exact: whether the process takes any values of these events' parameters.
    """

    channels: frozenset[str]
    exact: bool = True


@dataclass(frozen=True, slots=True)
class ControlState:
    """A place in the equations with the ways in which the process can wait there."""

    span: Span
    ways: tuple[WaitingState, ...]


class NotReadable(Exception):
    """An expression whose first events are not read off."""


def control_states(model: ClassModel) -> Iterator[ControlState]:
    """The control states of all CSP parts of a class from which it can wait for events, in the order of the text."""
    for part in model.processes:
        yield from _Part(part, model).states()


class _Part:
    """The equations of one part."""

    def __init__(self, part: ProcessPart, model: ClassModel) -> None:
        self._model = model
        self._bodies: dict[str, tuple[syntax.Expr, ...]] = {}
        for equation in part.equations:
            named = defined_name(equation)
            if named is not None:
                self._bodies[named[0]] = tuple(_bodies(equation))

    def states(self) -> Iterator[ControlState]:
        todo: list[tuple[syntax.Expr, bool]] = [(body, True) for body in self._bodies.get("main", ())]
        seen: set[tuple[int, bool]] = set()
        reached: list[syntax.Expr] = []
        while todo:
            place, is_state = todo.pop(0)
            if (id(place), is_state) in seen:
                continue
            seen.add((id(place), is_state))
            if is_state:
                reached.append(place)
            todo += self._inside(place)
        known: set[tuple[WaitingState, ...]] = set()
        for place in reached:
            try:
                ways = tuple(dict.fromkeys(self._ways(place, 0)))
            except NotReadable:
                continue
            ways = tuple(way for way in ways if way.channels)
            if ways and ways not in known:
                known.add(ways)
                yield ControlState(place.span, ways)

    def _inside(self, place: syntax.Expr) -> Iterator[tuple[syntax.Expr, bool]]:
        """The parts of an expression, and the bodies of what it calls; with each, whether the process waits there."""
        match place:
            case syntax.Prefix():
                yield place.body, True
            case syntax.Paren():
                yield place.inner, False
            case syntax.ProcessBinary():
                # Behind a semicolon the process waits anew; interleaved parts wait each for itself.
                yield place.left, place.operator == "|||"
                yield place.right, place.operator in ("|||", ";")
            case syntax.If():
                yield place.then, False
                yield place.otherwise, False
            case syntax.Guard() | syntax.Let():
                yield place.body, False
            case syntax.Name() | syntax.Apply():
                yield from ((body, False) for body in self._called(place))

    def _called(self, place: syntax.Expr) -> tuple[syntax.Expr, ...]:
        name = place.function if isinstance(place, syntax.Apply) else place
        return self._bodies.get(name.parts[0], ()) if isinstance(name, syntax.Name) else ()

    def _ways(self, place: syntax.Expr, depth: int) -> list[WaitingState]:
        """The ways to wait at the start of an expression; one without channels for what need not wait."""
        if depth > _DEEPEST:
            raise NotReadable
        match place:
            case syntax.Paren():
                return self._ways(place.inner, depth + 1)
            case syntax.Prefix():
                return [self._prefix(place)]
            case syntax.If():
                return [*self._ways(place.then, depth + 1), *self._ways(place.otherwise, depth + 1)]
            case syntax.Guard():
                # Where the guard fails there is nothing to wait for here; where it holds, this.
                return [WaitingState(way.channels, exact=False) for way in self._ways(place.body, depth + 1)]
            case syntax.ProcessBinary(operator="|~|"):
                return [*self._ways(place.left, depth + 1), *self._ways(place.right, depth + 1)]
            case syntax.ProcessBinary(operator="[]"):
                return list(_either(self._ways(place.left, depth + 1), self._ways(place.right, depth + 1)))
            case syntax.ProcessBinary(operator=";"):
                first = self._ways(place.left, depth + 1)
                if all(way.channels for way in first):
                    return first
                return [*[way for way in first if way.channels], *self._ways(place.right, depth + 1)]
            case syntax.Name(parts=("SKIP",)) | syntax.Name(parts=("STOP",)):
                return [WaitingState(frozenset())]
            case syntax.Name() | syntax.Apply():
                bodies = self._called(place)
                if not bodies:
                    raise NotReadable
                return [way for body in bodies for way in self._ways(body, depth + 1)]
        raise NotReadable

    def _prefix(self, prefix: syntax.Prefix) -> WaitingState:
        channel = prefix.channel
        channel = syntax.bare(channel)
        if isinstance(channel, syntax.Name) and len(channel.parts) == 1 and channel.parts[0] in self._model.channels:
            exact = all(field.kind == "?" and field.restriction is None and _open(field) for field in prefix.fields)
            return WaitingState(frozenset([channel.parts[0]]), exact)
        if isinstance(channel, syntax.Dot | syntax.Apply):
            first = channel.function if isinstance(channel, syntax.Apply) else channel.left
            if isinstance(first, syntax.Name) and first.parts[0] in self._model.channels:
                return WaitingState(frozenset([first.parts[0]]), exact=False)
        raise NotReadable


def _open(field: syntax.Field) -> bool:
    """Whether a field takes any value."""
    return isinstance(field.pattern, syntax.NamePattern | syntax.Wildcard)


def _either(left: Iterable[WaitingState], right: Iterable[WaitingState]) -> Iterator[WaitingState]:
    """The ways to wait for one of two."""
    for number, (one, other) in enumerate(product(left, right)):
        if number > _MOST:
            raise NotReadable
        if not one.channels or not other.channels:
            # The other side terminates or stops: with it there is always something, or nothing is demanded.
            yield WaitingState(one.channels | other.channels, exact=False)
            continue
        yield WaitingState(one.channels | other.channels, one.exact and other.exact)


def _bodies(equation: syntax.Declaration) -> Iterator[syntax.Expr]:
    match equation:
        case syntax.PatternDefinition():
            yield equation.body
        case syntax.FunctionDefinition():
            for clause in equation.clauses:
                yield clause.body
