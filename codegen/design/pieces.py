"""What processes are translated into: lines of text, methods, states, the alternatives of a choice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.syntax import tree as syntax

InternalChoice = Literal["refuse", "policy"]
WIDTH = 112
"""Lines are so long at most, inside their method."""
DEEPEST = 40
"""Names nested deeper than this in a choice are taken for an unguarded recursion."""
RESERVED = frozenset(
    {"carrier", "begin", "choice", "decide", "follow", "methods", "missed", "name", "offset", "perform", "period"}
    | {"priority", "release", "released", "releases", "run", "select", "stop", "channels", "go", "state"}
)
"""Names that generated tasks use for themselves."""


class TextLines:
    """Text in the making, line by line."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.depth = 0

    def add(self, *lines: str) -> None:
        """Add lines at the present depth."""
        self.lines.extend(f"{'    ' * self.depth}{line}" if line else "" for line in lines)

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Add a line and what stands below it, a step deeper."""
        self.add(head)
        self.depth += 1
        before = len(self.lines)
        yield
        if len(self.lines) == before:
            self.add("pass")
        self.depth -= 1


@dataclass
class Method:
    """What a task does when it performs an event alone: a method to be written by hand.

    ``given`` are the positions of the fields whose values it gets, ``returned`` those whose values it gives.
    """

    channel: str
    name: str
    given: tuple[int, ...]
    returned: tuple[int, ...]


@dataclass
class ChoiceBranch:
    """An alternative of a choice: its guard (a text), its prefix, and the variables that are seen there.

    ``restrictions`` are the sets of replicated variables, ``rest`` what comes after the prefix has come to its end.
    """

    guard: str | None
    prefix: syntax.Prefix
    names: dict[Symbol, str]
    restrictions: dict[Symbol, syntax.Expr] = field(default_factory=dict)
    rest: tuple[syntax.Expr, ...] = ()


@dataclass
class StateMethod:
    """A definition as a method: its lines below the head."""

    name: str
    parameters: list[tuple[str, str]]
    text: str
    lines: list[str]


@dataclass(frozen=True)
class ChannelUse:
    """How a task uses a channel.

    ``own``: it performs the events alone. ``timed``: it waits for its next release first.
    """

    arity: int
    own: bool
    timed: bool


class NeedsStates(Exception):
    """A process goes on as another one, so it is no loop."""


class Plain(Exception):
    """A channel is used in several ways, so there is no one method for it."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel)
        self.channel = channel


@dataclass
class OfferedEvent:
    """The offer of a branch, the variables that take its values, and all that can be seen behind it."""

    offer: str
    targets: list[str]
    names: dict[Symbol, str]
    timed: bool

    def assignment(self) -> str:
        """The left of an assignment of all values, if any is wanted."""
        if all(target == "_" for target in self.targets):
            return ""
        return f"({self.targets[0]},) = " if len(self.targets) == 1 else f"{', '.join(self.targets)} = "

    def unpacked(self, choice: str) -> list[str]:
        """The assignment of the values of a choice."""
        assignment = self.assignment()
        return [f"{assignment}{choice}.values"] if assignment else []


def mentioned(node: object, names: Names) -> set[Symbol]:
    """The symbols of all names in a tree."""
    found: set[Symbol] = set()
    todo = [node]
    while todo:
        one = todo.pop()
        if isinstance(one, syntax.Name):
            symbol = names.find(one)
            if symbol is not None:
                found.add(symbol)
        elif isinstance(one, syntax.Node):
            todo.extend(getattr(one, name) for name in one.__dataclass_fields__ if name != "span")
        elif isinstance(one, tuple):
            todo.extend(one)
    return found


def alternative(condition: str, position: int, count: int) -> str:
    """The head of an alternative of several."""
    if position == 0:
        return f"if {condition}:"
    return "else:" if position == count - 1 else f"elif {condition}:"


def both(left: str | None, right: str) -> str:
    """The condition that two conditions hold; the first may be missing."""
    if left is None:
        return right
    return f"({left}) and ({right})"


def unwrapped(pattern: syntax.Pattern) -> syntax.Pattern:
    """A pattern without brackets around it."""
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return pattern


def is_simple(pattern: syntax.Pattern) -> bool:
    """Whether a pattern is a name or a wildcard."""
    return isinstance(unwrapped(pattern), (syntax.NamePattern, syntax.Wildcard))
