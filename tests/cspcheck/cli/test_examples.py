"""``cspcheck examples``: list, print and copy what comes with cspcheck."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck.cli import examples, run


@pytest.fixture
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two examples: one of a single script, one of two scripts and a picture."""
    root = tmp_path / "specs"
    (root / "buffer").mkdir(parents=True)
    (root / "buffer" / "buffer.csp").write_text("-- A buffer of one place.\nP = STOP\n")
    (root / "ring" / "parts").mkdir(parents=True)
    (root / "ring" / "ring.csp").write_text("{- A token ring. -}\nR = STOP\n")
    (root / "ring" / "parts" / "node.csp").write_text("N = STOP\n")
    (root / "ring" / "ring.svg").write_text("<svg/>")
    (root / "empty").mkdir()
    monkeypatch.setattr(examples, "specs", lambda: root)
    return tmp_path


def test_the_list(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples"]) == 0
    assert capsys.readouterr().out == "buffer  A buffer of one place.\nring    A token ring.\n"


def test_an_example_is_printed_so_that_it_can_be_piped(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "buffer"]) == 0
    assert capsys.readouterr().out == "-- A buffer of one place.\nP = STOP\n"


def test_several_scripts_are_told_apart(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "ring"]) == 0
    assert capsys.readouterr().out == (
        "-- ring/parts/node.csp\nN = STOP\n-- ring/ring.csp\n{- A token ring. -}\nR = STOP\n"
    )


def test_one_file_of_an_example(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "ring/parts/node.csp"]) == 0
    assert capsys.readouterr().out == "N = STOP\n"


def test_a_copy_has_everything(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples", "ring", "--copy", str(shelf / "mine")]) == 0
    assert capsys.readouterr().out == f"{shelf}/mine/ring\n"
    assert sorted(p.relative_to(shelf / "mine").as_posix() for p in (shelf / "mine").rglob("*.*")) == [
        "ring/parts/node.csp",
        "ring/ring.csp",
        "ring/ring.svg",
    ]


def test_all_are_copied_where_none_is_named(shelf: Path) -> None:
    assert run(["examples", "--copy", str(shelf / "mine")]) == 0
    assert sorted(p.name for p in (shelf / "mine").iterdir()) == ["buffer", "ring"]


def test_a_copy_never_overwrites(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (shelf / "mine" / "ring").mkdir(parents=True)

    assert run(["examples", "--copy", str(shelf / "mine")]) == 2
    assert capsys.readouterr().err.startswith(f"error[CSP908]: `{shelf}/mine/ring` exists already\n")
    assert [p.name for p in (shelf / "mine").iterdir()] == ["ring"]


@pytest.mark.parametrize("name", ["bufer", "empty", "..", "../x", ".", "/etc/passwd", "ring/nothing.csp"])
def test_what_is_no_example(shelf: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    assert run(["examples", name]) == 2
    assert capsys.readouterr().err.startswith(f"error[CSP907]: there is no example `{name}`\n")


def test_a_name_that_is_nearly_right_gets_a_hint(shelf: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["examples", "bufer"])
    assert "did you mean `buffer`?" in capsys.readouterr().err


def test_the_source_tree_has_the_vehicle(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["examples"]) == 0
    assert "rov " in capsys.readouterr().out
