"""Diagnostics as people read them, word for word."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st
from syrupy.assertion import SnapshotAssertion

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.source import Source
from cspcheck.report import excerpt
from cspcheck.report.diagnostics import concise_diagnostic, render_diagnostic
from cspcheck.report.style import Style, columns


def test_each_diagnostic(diagnostic: Diagnostic, snapshot: SnapshotAssertion) -> None:
    assert render_diagnostic(diagnostic, Style()) == snapshot


def test_each_diagnostic_in_color(diagnostic: Diagnostic, snapshot: SnapshotAssertion) -> None:
    assert render_diagnostic(diagnostic, Style(color=True)) == snapshot


def test_each_diagnostic_in_one_line(diagnostic: Diagnostic, snapshot: SnapshotAssertion) -> None:
    line = concise_diagnostic(diagnostic)

    assert "\n" not in line
    assert line == snapshot


def test_no_control_character_reaches_the_terminal(diagnostic: Diagnostic) -> None:
    text = render_diagnostic(diagnostic, Style())

    assert not any(ord(c) < 32 and c != "\n" for c in text)


@pytest.mark.parametrize(
    ("line", "name"), [("P = \tabc\tQ", "abc"), ("日本 = abc", "abc"), ("e\u0301e\u0301 = abc", "abc"), ("abc", "abc")]
)
def test_the_caret_stands_under_the_place(line: str, name: str) -> None:
    source = Source("x.csp", line)
    start = line.index(name)
    shown, carets = render_diagnostic(
        Diagnostic("CSP201", "message", source.span(start, start + len(name))), Style()
    ).splitlines()[-2:]

    assert columns(shown[: shown.index(name)]) == columns(carets[: carets.index("^")])
    assert carets.count("^") == columns(name)


texts = st.text(st.sampled_from("ab \t\n日e\u0301\x1b\r("), max_size=60) | st.text(
    st.sampled_from("a 日\t"), min_size=100, max_size=300
)


@given(texts, st.data())
def test_any_place_in_any_text_can_be_shown(text: str, data: st.DataObject) -> None:
    """Every diagnostic has its header, shows each line that it talks about, and points at least once."""
    source = Source("x.csp", text)
    places = data.draw(
        st.lists(st.tuples(st.integers(0, len(text)), st.integers(0, len(text))).map(sorted), min_size=1, max_size=4)
    )
    spans = [source.span(start, end) for start, end in places]
    labels = tuple(Label(span, f"label {i}") for i, span in enumerate(spans[1:]))
    width = data.draw(st.integers(40, 100))
    rows = render_diagnostic(
        Diagnostic("CSP201", "message", spans[0], annotation="here", labels=labels), Style(width=width)
    ).splitlines()

    assert rows[0] == "error[CSP201]: message"
    assert rows[1].endswith(f"--> x.csp:{spans[0].line}:{spans[0].column}")
    assert any("^" in row for row in rows)
    assert sum(row.count("here") for row in rows) == 1
    for i in range(len(labels)):
        assert sum(row.count(f"label {i}") for row in rows) == 1
    numbers = [int(row.split("|")[0]) for row in rows if "|" in row and row.split("|")[0].strip().isdigit()]
    assert numbers == sorted(set(numbers))
    assert {span.line for span in spans} <= set(numbers)


def test_a_long_line_is_measured_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A line of n characters takes a number of looks that grows as n does, not as its square."""
    looked = 0

    def counted(text: str) -> int:
        nonlocal looked
        looked += len(text)
        return columns(text)

    monkeypatch.setattr(excerpt, "columns", counted)
    source = Source("x.csp", "X = 1 + {- " + 8_000 * "é" + " -}")
    render_diagnostic(Diagnostic("CSP101", "wrong", source.span(8, 9)), Style())
    assert looked < 10 * len(source.text)
