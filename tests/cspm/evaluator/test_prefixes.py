"""What an input offers, against an obvious reader that holds every event of the channel against the whole pattern."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from hypothesis import given, settings, strategies as st

from cspcheck.cspm.process.terms import Prefix, Stop
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.examples import examples

DECLARED = "datatype T = A | B.{0..1} | C.{0..1}.Bool\n"
Field = tuple[str, ...]
"""A value of one field, as the parts between its dots."""

VALUES: dict[str, list[Field]] = {
    "{0..1}": [("0",), ("1",)],
    "Bool": [("false",), ("true",)],
    "T": [("A",), ("B", "0"), ("B", "1"), *[("C", i, b) for i in "01" for b in ("false", "true")]],
}


@dataclass(frozen=True)
class Input:
    """The fields of a prefix as they are written, and what each part of them is for: None for anything."""

    channel: tuple[str, ...]
    written: str
    parts: tuple[str | None, ...]
    takes_rest: bool

    def offers(self, event: tuple[Field, ...]) -> bool:
        """Whether the event fits: each part stands for a field, behind a constructor for a part of one."""
        fields = [list(field) for field in event]
        waiting: list[str] = []  # parts of a field that has been opened
        for i, part in enumerate(self.parts):
            if self.takes_rest and i == len(self.parts) - 1:
                return True
            if waiting:
                found = [waiting.pop(0)]
            else:
                found = fields.pop(0)
            if part is None:
                continue
            if found[0] != part:
                return False
            waiting += found[1:]
        return not fields and not waiting


@st.composite
def inputs(draw: st.DrawFn) -> Input:
    channel = tuple(draw(st.lists(st.sampled_from(sorted(VALUES)), min_size=1, max_size=3)))
    groups: list[list[str | None]] = []  # what must stay between the dots of one pattern
    outputs: list[bool] = []
    takes_rest = False
    for i, kind in enumerate(channel):
        value = draw(st.sampled_from(VALUES[kind]))
        form = draw(st.sampled_from(["any", "any", "value", "output"]))
        if form == "any":
            groups.append([None])
            if i < len(channel) - 1 and draw(st.integers(0, 3)) == 0:
                outputs.append(False)
                takes_rest = True
                break
        else:
            groups.append(
                [p if j == 0 or draw(st.booleans()) or form == "output" else None for j, p in enumerate(value)]
            )
        outputs.append(form == "output")
    if len(groups) == 1 and outputs == [True]:
        outputs = [False]
    written = ""
    number = 0
    mark = ""
    for group, output in zip(groups, outputs, strict=True):
        texts = []
        for part in group:
            number += part is None
            texts.append(part if part is not None else draw(st.sampled_from([f"x{number}", "_"])))
        joined = mark == "?" and not output and draw(st.booleans())
        mark = "!" if output else "?"
        written += ("." if joined else mark) + ".".join(texts)
    return Input(channel, written, tuple(part for group in groups for part in group), takes_rest)


@settings(max_examples=examples(60))
@given(inputs())
def test_an_input_offers_the_events_that_fit_its_pattern(found: Input) -> None:
    text = f"{DECLARED}channel c : {'.'.join(found.channel)}\nP = c{found.written} -> STOP\n"
    script = load(Source("input.csp", text))
    wanted = {
        "c." + ".".join(".".join(field) for field in event)
        for event in product(*[VALUES[kind] for kind in found.channel])
        if found.offers(event)
    }
    term = script.process(f"c{found.written} -> STOP")
    assert isinstance(term, Prefix | Stop)
    branches = term.branches if isinstance(term, Prefix) else ()
    assert {script.events.name(number) for number, _ in branches} == wanted
