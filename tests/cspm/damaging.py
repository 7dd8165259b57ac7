"""Texts that are damaged at random: thousands of them in little time, for the tests that nothing crashes.

Small texts are taken oftener than large ones: what breaks is small, and so many more can be tried. The inputs are the
same in every run, unless ``CSPCHECK_SEED`` says otherwise; the one that fails is told with the failure.
"""

from __future__ import annotations

import os
import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType

import pytest

from cspcheck.cspm import recursion
from cspcheck.cspm.evaluator import builtins_data, comprehensions, core
from cspcheck.cspm.values import comparison, values
from tests.cspm.syntax.strategies_syntax import EXAMPLES

SEED = os.environ.get("CSPCHECK_SEED", "")
SMALL = 400
"""Bytes of what is a small text."""
LARGE_SHARE = 0.03
"""How many of the inputs are made of any text."""

PIECES: tuple[bytes, ...] = (
    *(b"(", b")", b"{", b"}", b"<", b">", b"{|", b"|}", b"[|", b"|]", b"[[", b"]]", b"[", b"]", b"(| ", b"|)", b"|>"),
    *(b"->", b"[]", b"|~|", b"|||", b"||", b";", b"\\", b"@", b"@@", b"=", b"==", b"::", b":", b".", b"..", b"_", b"?"),
    *(
        b"let ",
        b" within ",
        b"if ",
        b" then ",
        b" else ",
        b"not ",
        b"channel ",
        b"module M\n",
        b"exports\n",
        b"assert ",
    ),
    *(
        b"\n",
        b"\r\n",
        b" ",
        b"{-",
        b"-}",
        b"--",
        b'"',
        b"'",
        b"\0",
        b"\xff",
        b"\xc3",
        b"[T=",
        b":[",
        b":[deadlock free]",
    ),
    *(b'include "x"\n', b"Timed { ", b"x", b"f(", b"0", b"-", b"# "),
)


def damaged(content: bytes, chance: random.Random) -> bytes:
    """A text with some bytes changed, dropped, added or moved."""
    for _ in range(chance.randint(1, 4)):
        place = chance.randint(0, len(content))
        end = min(place + chance.randint(0, 12), len(content))
        match chance.randint(0, 4):
            case 0:
                content = content[:place] + content[end:]
            case 1:
                content = content[:place] + chance.choice(PIECES) + content[place:]
            case 2:
                content = content[:place] + chance.randbytes(chance.randint(1, 3)) + content[end:]
            case 3:
                content = content[:end] + content[place:]
            case _:
                content = content[end:] + content[:place]
    return content


def chances(name: str, share: float) -> Iterator[random.Random]:
    """Sources of chance for a share of the inputs; *name* is what they are for."""
    for number in range(max(1, int(EXAMPLES * share))):
        yield random.Random(f"{name} {SEED} {number}")


def damaged_texts(name: str, share: float, contents: Sequence[bytes]) -> Iterator[bytes]:
    """A share of the inputs, each one of *contents* that is damaged; *name* is what they are for."""
    small = [content for content in contents if len(content) <= SMALL]
    for chance in chances(name, share):
        yield damaged(chance.choice(small if small and chance.random() >= LARGE_SHARE else contents), chance)


@contextmanager
def told(content: object) -> Iterator[None]:
    """What fails within tells the input that it failed with."""
    try:
        yield
    except BaseException as error:
        error.add_note(f"the input: {content!r}")
        raise


PATIENT: tuple[tuple[ModuleType, tuple[str, ...]], ...] = (
    (values, ("LONGEST", "STEPS", "FRUITLESS")),
    (comparison, ("PATIENCE",)),
    (builtins_data, ("STEPS", "FRUITLESS")),
    (comprehensions, ("FRUITLESS",)),
    (recursion, ("FRAMES",)),
    (core, ("FRAMES",)),
)
"""The limits of evaluation, where they are used."""


def short_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """What has no end is given up after a sixteenth of the usual steps.

    Damaged texts without end are found at once, and the usual number of steps would be most of the time of the tests.
    """
    for module, names in PATIENT:
        for name in names:
            monkeypatch.setattr(module, name, getattr(module, name) // 16)
