"""Contracts: what a method may rely on and what it must bring about, checked when it runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_on = True


class Broken(Exception):
    """A pre- or postcondition, or an invariant, does not hold.

    ``values`` are the variables that it speaks of; before values have their plain name, after values a prime.
    """

    def __init__(self, kind: str, where: str, condition: str, values: Mapping[str, Any]) -> None:
        self.kind = kind
        self.where = where
        self.condition = condition
        self.values = dict(values)
        shown = ", ".join(f"{name} = {value!r}" for name, value in values.items())
        super().__init__(f"{where}: the {kind} `{condition}` does not hold" + (f" with {shown}" if shown else ""))


def switch(on: bool) -> None:
    """Check contracts or not, from now on."""
    global _on
    _on = on


def checked() -> bool:
    """Whether contracts are checked."""
    return _on


def require(holds: bool, where: str, condition: str, **values: Any) -> None:
    """A precondition.

    Raises:
        Broken: it does not hold, and contracts are checked.
    """
    if _on and not holds:
        raise Broken("precondition", where, condition, values)


def ensure(holds: bool, where: str, condition: str, **values: Any) -> None:
    """A postcondition.

    Raises:
        Broken: it does not hold, and contracts are checked.
    """
    if _on and not holds:
        raise Broken("postcondition", where, condition, values)
