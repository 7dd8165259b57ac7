"""The laws of the toolkit: what holds of cardinality, restriction, injectivity, closure and squash, for proofs.

They are lemmas in the text notation (``laws.oz``). Those of the first part say what an operator is, by recursion or as
the least of something; the others follow, and the tests prove each from what it names. The tests hold all of them
against the evaluator of classes, too.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cspcheck.cspm.oz import core

PATH = Path(__file__).with_name("laws.oz")
DEFINING = "-- What operators are"
_NAME = re.compile(r"^lemma (\w+)", re.MULTILINE)


@cache
def text() -> str:
    """The laws as they are written."""
    return PATH.read_text(encoding="utf-8")


@cache
def names() -> tuple[str, ...]:
    """The names of the laws."""
    return tuple(_NAME.findall(text()))


@cache
def defining() -> tuple[str, ...]:
    """The names of those that say what an operator is."""
    first = text().partition(DEFINING)[2].partition("\n-- ")[0]
    return tuple(_NAME.findall(first))


@cache
def laws() -> Mapping[str, core.Lemma]:
    """The laws by their names."""
    from cspcheck.cspm.oz.typing.elaboration import elaborate
    from cspcheck.cspm.parsing.reading import parse_alone
    from cspcheck.cspm.source import Source

    return elaborate(parse_alone(Source(PATH.name, text()))).specification.lemmas
