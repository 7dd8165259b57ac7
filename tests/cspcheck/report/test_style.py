"""Colour, width and characters are those of the stream."""

from __future__ import annotations

import io
from typing import Any

import pytest

from cspcheck.report.style import Style, columns, harmless, style_for


class Stream(io.StringIO):
    def __init__(self, *, terminal: bool = True, encoding: str = "utf-8") -> None:
        super().__init__()
        self._terminal = terminal
        self._encoding = encoding

    def isatty(self) -> bool:
        return self._terminal

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self._encoding


@pytest.mark.parametrize(
    ("choice", "terminal", "environment", "color"),
    [
        ("auto", True, {}, True),
        ("auto", False, {}, False),
        ("auto", True, {"TERM": "dumb"}, False),
        ("auto", True, {"NO_COLOR": "1"}, False),
        ("auto", True, {"NO_COLOR": ""}, True),
        ("auto", False, {"FORCE_COLOR": "1"}, True),
        ("auto", True, {"NO_COLOR": "1", "FORCE_COLOR": "1"}, False),
        ("always", False, {"NO_COLOR": "1"}, True),
        ("never", True, {"FORCE_COLOR": "1"}, False),
    ],
)
def test_color(choice: Any, terminal: bool, environment: dict[str, str], color: bool) -> None:
    assert style_for(Stream(terminal=terminal), choice, environment).color is color


@pytest.mark.parametrize(("encoding", "unicode"), [("utf-8", True), ("ascii", False), ("cp1252", False), ("?", False)])
def test_marks_that_the_stream_cannot_show_are_not_used(encoding: str, unicode: bool) -> None:
    assert style_for(Stream(encoding=encoding), environment={}).unicode is unicode


def test_the_width_is_the_terminals_and_eighty_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")

    assert style_for(Stream(), environment={}).width == 100
    assert style_for(Stream(terminal=False), environment={}).width == 80


@pytest.mark.parametrize(("text", "width"), [("abc", 3), ("日本", 4), ("e\u0301", 1), ("", 0)])
def test_columns(text: str, width: int) -> None:
    assert columns(text) == width


@pytest.mark.parametrize(("width", "fitted"), [(7, "日本語x"), (6, "日本…"), (4, "日…"), (1, "…")])
def test_cutting_counts_columns(width: int, fitted: str) -> None:
    assert Style().fit("日本語x", width) == fitted


def test_text_that_would_steer_a_terminal_is_made_harmless() -> None:
    assert harmless("a\x1b[31m\x07\u202eb\tc\nd\x9b") == "a\ufffd[31m\ufffd\ufffdb\tc\u2424d\ufffd"
