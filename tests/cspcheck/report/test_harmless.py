"""Nothing that a script, a file name or a recorded run says steers a terminal, or is obeyed by a build server."""

from __future__ import annotations

import json
import re
from dataclasses import fields, replace
from typing import Any, get_args

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.verdict import (
    BrokenObligation,
    ComponentBehaviour,
    Counterexample,
    Outcome,
    SpecificationRun,
    Verdict,
)
from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity
from cspcheck.cspm.source import Source
from cspcheck.drawing import dot, html, sequence
from cspcheck.drawing.picture import Edge, Picture, PictureNode
from cspcheck.following import Departure
from cspcheck.report import FORMATS, Format, report, scripts_report
from cspcheck.report.style import Style, harmless, unobeyed
from cspcheck.report.sweep import table
from cspcheck.result import Result, Summary
from cspcheck.sweeping import Swept
from tests.examples import examples

HOSTILE = st.lists(
    st.one_of(
        st.sampled_from(
            ["\n::error::x", "::stop-commands::y", " ##[error]z", "\r", "\x1b[31m", "\x1b]0;t\x07", "\x9b2J"]
        ),
        st.sampled_from(
            ["\u2028", "\u202e", "\x85", "\x00", "a", " ", "`", "event.1", "%", ":", ",", "<&>", '"', "\t"]
        ),
    ),
    min_size=1,
    max_size=6,
).map("".join)

_STEERING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069]")


def hostile_result(text: str, verdict: Verdict, kind: str) -> Result:
    component = ComponentBehaviour(text, (text, None), text, 3, (text,), (text,))
    counterexample = Counterexample(
        kind=kind,  # type: ignore[arg-type]
        trace=(text, "tau"),
        causes=(None, text),
        event=text,
        refusal=(text,),
        allowed=((text,), (text, text)),
        loop=(text, "tau"),
        components=(component, replace(component, name="other")),
        specification=SpecificationRun((text,), (None,), (text, text)),
        event_parts=((text, text),),
        offered=(text,),
        loop_parts=(((text, text),), ()),
        values={text: text, f"{text}'": text},
        obligation=BrokenObligation(text, text, text, text, 3, text, ((3, text),), (text,)),
        waiting_cycle=(text, "other"),
        alternative=(text,),
        refusals=((text,), None),
    )
    outcome = Outcome(verdict, text, 1, 2, 0.5, 7, counterexample, (text,), (text,), True)
    return Result(
        file=text,
        line=3,
        assertion=text,
        kind="refinement",
        model="FD",
        outcome=outcome,
        process=text,
        specification=text,
    )


def hostile_diagnostic(text: str, severity: Severity) -> Diagnostic:
    source = Source(text, f"P = {text}\nQ = {text}\n")
    span = source.span(0, len(source.text) - 1)
    labels = (Label(source.span(4, 5), text),)
    return Diagnostic("CSP999", text, span, severity, text, labels, (text,), text)


def check_lines(out: str, *, commands: bool = False) -> None:
    assert _STEERING.search(out) is None, repr(_STEERING.search(out))
    for line in out.splitlines():
        stripped = line.lstrip()
        if commands:
            assert re.match(r"::(error|warning) (file=|title=)|cspcheck: ", line), line
        else:
            assert not stripped.startswith(("::", "##[")), line


@settings(max_examples=examples(15))
@given(
    HOSTILE,
    st.sampled_from(list(Verdict)),
    st.sampled_from(["trace", "refusal", "deadlock", "divergence", "nondeterminism", "obligation"]),
    st.sampled_from(list(Severity)),
    st.sampled_from([-1, 0, 1]),
)
def test_in_every_format(text: str, verdict: Verdict, kind: str, severity: Severity, verbosity: int) -> None:
    result = hostile_result(text, verdict, kind)
    diagnostic = hostile_diagnostic(text, severity)
    for form in get_args(Format):
        for maker in (report, scripts_report):
            pieces: list[str] = []
            to = maker(form, pieces.append, Style(width=50), verbosity)
            to.script(text, (text,))
            to.diagnostics([diagnostic])
            to.result(result)
            to.result(replace(result, diagnostics=(diagnostic,)))
            to.unreached([result])
            to.end(Summary.empty(), interrupted=True)
            out = "".join(pieces)
            check_lines(out, commands=form == "github")
            if form == "json":
                json.loads(out)
            if form == "concise" and maker is report:
                assert all(re.match(r".*:3: \w+: ", line) for line in out.split("\n")[:-1] if "CSP999" not in line)


@settings(max_examples=examples(15))
@given(HOSTILE)
def test_in_what_is_not_a_report(text: str) -> None:
    result = hostile_result(text, Verdict.FAIL, "trace")
    check_lines(unobeyed(result.explain()))
    check_lines(unobeyed(Departure(1, text, text, (text,), (text,), (text,)).explain()))
    swept = Swept({text: text}, [result], [hostile_diagnostic(text, Severity.ERROR)])
    check_lines(table([swept], [text], Style()))
    assert result.counterexample is not None
    picture = Picture(text, (PictureNode(text, "state", text),), (Edge(0, 0, (text,), "event"),))
    for drawn in (
        dot.render(picture),
        sequence.render(text, result.counterexample),
        html.page(text, sequence.render(text, result.counterexample)),
    ):
        assert _STEERING.search(drawn) is None


@given(st.text())
def test_one_line_stays_one_line(text: str) -> None:
    assert len(harmless(text).splitlines()) <= 1
    assert _STEERING.search(harmless(text)) is None


@given(st.text(alphabet="a :#[error]\n\t\x1b[31m"))
def test_lines_that_would_be_obeyed_get_a_backslash_and_no_others_change(text: str) -> None:
    lines = zip(text.split("\n"), unobeyed(text).split("\n"), strict=True)
    for before, after in lines:
        assert after in (before, re.sub(r"(::|##\[)", r"\\\1", before, count=1))
        assert not re.match(r"\s*(::|##\[)", after)


def test_every_format_is_tried() -> None:
    assert set(get_args(Format)) == set(FORMATS)
    assert {field.name for field in fields(Counterexample)} >= {"trace", "loop", "values"}


@pytest.mark.parametrize("form", ["full", "concise"])
def test_an_error_of_a_script_is_not_a_command(
    form: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cspcheck.cli import run

    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csp").write_text('P = error("boom\\n::error::x")\nassert P :[deadlock free]\n')
    (tmp_path / "::error::y\n::warning::z.csp").write_text("assert true\n")
    assert run(["x.csp", "::error::y\n::warning::z.csp", "--format", form]) == 2
    out, err = capsys.readouterr()
    check_lines(out)
    check_lines(err)
    assert "boom" in out


def test_a_long_line_is_told_in_no_time() -> None:
    """Work in proportion to the line: 40,000 characters took minutes when each prefix was measured."""
    from cspcheck.report.diagnostics import render_diagnostic

    source = Source("long.csp", "X = 1 + {- " + "é漢\t" * 13_000 + " -}\n")
    for place in (4, 20_000, 39_000):
        diagnostic = Diagnostic("CSP999", "here", source.span(place, place + 1), annotation="x")
        assert max(map(len, render_diagnostic(diagnostic, Style()).splitlines())) < 200
