"""Call by need: an expression with its environment, evaluated at most once, when its value is first asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure

Env: TypeAlias = tuple[Any, ...]
"""The values (or thunks) of the local variables in scope, by position."""
Code: TypeAlias = Callable[[Env], Any]
"""A compiled expression: from the environment to a value, never to a thunk."""


class Thunk:
    """A value that may still have to be evaluated. ``code`` is None once ``value`` is there."""

    __slots__ = ("code", "env", "value")

    code: Code | None
    env: Env | None
    value: Any

    def __init__(self, code: Code, env: Env) -> None:
        self.code = code
        self.env = env

    def force(self) -> Any:
        """The value.

        Raises:
            Failure: the evaluation failed (it fails in the same way each time), or needs its own result.
        """
        code = self.code
        if code is None:
            return self.value
        env = self.env
        assert env is not None
        self.code = _black_hole
        try:
            value = code(env)
        except BaseException as error:
            self.code = code
            error.__traceback__ = None  # tracebacks of deep recursion would keep all its frames alive
            raise
        self.value = value
        self.code = None
        self.env = None
        return value

    @property
    def is_being_evaluated(self) -> bool:
        """Whether someone further out waits for this very value."""
        return self.code is _black_hole

    def settle(self, value: Any) -> Any:
        """Give the thunk its value from outside."""
        self.value = value
        self.code = None
        self.env = None
        return value


def _black_hole(env: Env) -> Any:
    raise Failure(messages.depends_on_itself())


def force(value: Any) -> Any:
    """*value*, evaluated if it is a thunk."""
    return value.force() if type(value) is Thunk else value
