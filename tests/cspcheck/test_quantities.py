"""Times and sizes as people write and read them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck.cli import run
from cspcheck.quantities import count, parse_duration, parse_size, show_bytes, show_seconds, whole_number


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("90", 90.0),
        ("90s", 90.0),
        ("5m", 300.0),
        ("5 min", 300.0),
        ("1h", 3600.0),
        ("1h30m", 5400.0),
        ("1.5h", 5400.0),
        ("500ms", 0.5),
        ("2d", 172800.0),
        ("0.25", 0.25),
        (" 5M ", 300.0),
    ],
)
def test_times(text: str, seconds: float) -> None:
    assert parse_duration(text) == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["", "soon", "5x", "-5", "5m!", "h", "1h soon", "m5", "1..5", "nan", "inf"])
def test_what_is_no_time(text: str) -> None:
    with pytest.raises(ValueError, match="is not a time; write it like 90s, 5m or 1h30m"):
        parse_duration(text)


@pytest.mark.parametrize("text", ["0", "0s", "0h0m"])
def test_no_time_at_all(text: str) -> None:
    with pytest.raises(ValueError, match=f"`{text}` is not a time above zero"):
        parse_duration(text)


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("1024", 1024),
        ("1B", 1),
        ("512MiB", 512 * 1024**2),
        ("8GiB", 8 * 1024**3),
        ("8G", 8 * 1024**3),
        ("2GB", 2 * 1000**3),
        ("2 kb", 2000),
        ("1.5KiB", 1536),
        ("1TiB", 1024**4),
    ],
)
def test_sizes(text: str, size: int) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "big", "8XiB", "-1", "8 8", "GiB", "8iB"])
def test_what_is_no_size(text: str) -> None:
    with pytest.raises(ValueError, match="is not a size; write it like 512MiB, 8GiB or 2GB"):
        parse_size(text)


def test_no_size_at_all() -> None:
    with pytest.raises(ValueError, match="`0GiB` is not a size above zero"):
        parse_size("0GiB")


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0.00 s"),
        (1.234, "1.23 s"),
        (9.994, "9.99 s"),
        (9.996, "10.0 s"),
        (99.94, "99.9 s"),
        (99.96, "1 min 40 s"),
        (3599.4, "59 min 59 s"),
        (3600, "1 h 0 min"),
        (7500, "2 h 5 min"),
    ],
)
def test_times_are_shown_in_the_precision_that_matters(seconds: float, text: str) -> None:
    assert show_seconds(seconds) == text


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 B"),
        (1023, "1023 B"),
        (1024, "1.0 KiB"),
        (1536 * 1024, "1.5 MiB"),
        (3 * 1024**3, "3.0 GiB"),
        (5 * 1024**4, "5.0 TiB"),
    ],
)
def test_sizes_are_shown_in_binary_units(size: int, text: str) -> None:
    assert show_bytes(size) == text


def test_counts() -> None:
    assert [count(n, "state") for n in (0, 1, 2_519_424)] == ["0 states", "1 state", "2,519,424 states"]


@pytest.mark.parametrize(
    ("text", "number"),
    [("0", 0), ("007", 7), ("9" * 18, 10**18 - 1), ("0" * 5_000 + "3", 3)]
    + [(text, None) for text in ("", "-1", "+1", "1.0", " 1", "\u00b2", "\u0663", "9" * 19, "9" * 5_000)],
)
def test_whole_numbers_have_few_digits(text: str, number: int | None) -> None:
    assert whole_number(text) == number


@pytest.mark.parametrize("text", ["9" * 5_000, "9" * 400 + "GiB", "1000000TiB"])
def test_sizes_beyond_all_machines(text: str) -> None:
    with pytest.raises(ValueError, match="is more than any machine has"):
        parse_size(text)


NINES = "9" * 5_000


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["check", f"SCRIPT:{NINES}"], "no assertion"),
        (["check", "SCRIPT", "--max-states", NINES], "is not a whole number above zero"),
        (["check", "SCRIPT", "--workers", NINES], "is not a whole number above zero"),
        (["check", "SCRIPT", "--max-memory", f"{NINES}GiB"], "is more than any machine has"),
        (["probe", "--at", f"SCRIPT:{NINES}"], "is not FILE:LINE"),
        (["sweep", "SCRIPT", "-D", f"N=1..{NINES}"], "has too many digits for a bound of a range"),
    ],
)
def test_numbers_of_a_command_line_without_end(
    arguments: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "p.csp"
    script.write_text("channel a\nN = 1\nP = a -> P\nassert P :[deadlock free]\n")
    code = run([argument.replace("SCRIPT", str(script)) for argument in arguments])
    shown = capsys.readouterr()
    assert code in (2, 5)
    assert told in shown.out + shown.err
