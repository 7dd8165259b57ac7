"""What is done with a node, by its class: one table for each thing that is done with trees.

A table is filled by decorating what it holds, so every rule is found by a search for its node::

    PRINTS: Final = Dispatch[Callable[[Any, s.Node, Place], Doc]]("print")

    @PRINTS(s.SetRange)
    def _set_range(self, node: s.SetRange, place: Place) -> Doc: ...

A table asks for the class itself and not for its bases: a form that nobody has thought of is a KeyError, and
``tests/cspm/syntax/test_dispatch.py`` holds every table against every form.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

from cspcheck.cspm.syntax.nodes import Node

Rule = TypeVar("Rule", bound=Callable[..., Any])
Given = TypeVar("Given", bound=Callable[..., Any])


class Dispatch(Generic[Rule]):
    """Rules by class of node. ``purpose`` says what they are for.

    Used as a decorator with the classes that a rule is for; a class can be given once.
    """

    __slots__ = ("_rules", "purpose")

    def __init__(self, purpose: str) -> None:
        self.purpose = purpose
        self._rules: dict[type[Node], Rule] = {}

    def __call__(self, *kinds: type[Node]) -> Callable[[Given], Given]:
        """Register what is decorated for nodes of these classes."""

        def register(rule: Given) -> Given:
            for kind in kinds:
                assert kind not in self._rules, f"two rules to {self.purpose} {kind.__name__}"
                self._rules[kind] = rule  # type: ignore[assignment]
            return rule

        return register

    def __getitem__(self, kind: type[Node]) -> Rule:
        return self._rules[kind]

    def get(self, kind: type[Node]) -> Rule | None:
        """The rule for a class; None if there is none."""
        return self._rules.get(kind)

    def __iter__(self) -> Iterator[type[Node]]:
        return iter(self._rules)

    def __contains__(self, kind: object) -> bool:
        return kind in self._rules
