"""Built-in functions as values, and how a call of one is compiled.

A kind says what a parameter is given: ``v`` an evaluated value, ``l`` a value or thunk, ``p`` a process term.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, force

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator


class Builtin:
    """A function of the language. ``key`` tells apart what was made with values: ``relational_image(R)``."""

    __slots__ = ("call", "key", "kinds", "name")

    def __init__(self, name: str, kinds: str, call: Callable[..., Any], key: Hashable = None) -> None:
        self.name = name
        self.kinds = kinds
        self.call = call
        self.key = key

    def apply(self, arguments: Env, span: Span) -> Any:
        """The function's value for *arguments*, given where the call is not known before it happens.

        Raises:
            Failure: their number is wrong, or the function fails.
        """
        if len(arguments) != len(self.kinds):
            raise Failure(messages.argument_count(self.name, len(self.kinds), len(arguments), span, None))
        try:
            given = [_given(value, kind) for value, kind in zip(arguments, self.kinds, strict=True)]
            return self.call(*given)
        except Failure as failure:
            failure.at(span)
            raise

    def compile(self, evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Code:
        """Code for a call of this function."""
        span = node.span
        expected, given = len(self.kinds), len(node.arguments)
        if expected != given:

            def fail(env: Env) -> Any:
                raise Failure(messages.argument_count(self.name, expected, given, span, None))

            return fail
        ways = {"v": evaluator.value, "l": evaluator.delayed, "p": evaluator.process}
        arguments = [ways[kind](node.arguments[i], frame) for i, kind in enumerate(self.kinds)]
        call = self.call
        if len(arguments) == 1:
            (only,) = arguments

            def call_one(env: Env) -> Any:
                try:
                    return call(only(env))
                except Failure as failure:
                    failure.at(span)
                    raise

            return call_one
        if len(arguments) == 2:
            first, second = arguments

            def call_two(env: Env) -> Any:
                try:
                    return call(first(env), second(env))
                except Failure as failure:
                    failure.at(span)
                    raise

            return call_two

        def call_all(env: Env) -> Any:
            try:
                return call(*[argument(env) for argument in arguments])
            except Failure as failure:
                failure.at(span)
                raise

        return call_all

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, Builtin) and self.key is not None and (self.name, self.key) == (other.name, other.key)
        )

    def __hash__(self) -> int:
        return hash((self.name, self.key))

    def __repr__(self) -> str:
        return f"<function {self.name}>"


def _given(value: Any, kind: str) -> Any:
    if kind == "l":
        return value
    value = force(value)
    if kind == "p" and not isinstance(value, Process):
        raise Failure(messages.wrong_kind("a process", value))
    return value
