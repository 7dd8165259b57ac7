"""``cspcheck man``: pages that ``man`` can set, with all that the help has."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import click
import pytest

from cspcheck.cli import VERBS, front_door, run
from cspcheck.cli.man import pages
from cspcheck.report.manual import escaped, flowing


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    code = run(["man", *arguments])
    return code, capsys.readouterr().out


def test_the_page_of_the_command_names_every_verb(capsys: pytest.CaptureFixture[str]) -> None:
    code, page = said(capsys)

    assert code == 0
    assert re.findall(r"^\.TP\n\\fB([a-z]+)\\fR$", page, re.MULTILINE) == list(VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_the_page_of_a_verb_has_every_option(verb: str) -> None:
    page = pages()[f"cspcheck-{verb}"]
    with front_door.make_context("cspcheck", [verb], resilient_parsing=True) as context:
        command = front_door.get_command(context, verb)
    assert command is not None

    assert page.startswith(f'.TH "CSPCHECK\\-{verb.upper()}" 1 ')
    for option in command.params:
        if isinstance(option, click.Option) and not option.hidden:
            assert all(f"\\fB{escaped(name)}" in page for name in option.opts)


def test_help_is_asked_for_as_everywhere() -> None:
    assert "\\fB\\-h\\fR, \\fB\\-\\-help\\fR" in pages()["cspcheck-check"]


def test_text_is_set_as_it_stands() -> None:
    assert escaped(".x\n'y\na\\b -c") == "\\&.x\n\\&'y\na\\eb \\-c"
    assert escaped("τ") == "\\[u03C4]"
    assert flowing("Say `--x`\n  now.") == "Say \\fB\\-\\-x\\fR now."


def test_a_verb_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["man", "nothing"]) == 2
    assert "there is no verb `nothing`" in capsys.readouterr().err


def test_all_are_written_to_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _ = said(capsys, "--folder", str(tmp_path / "man1"))

    assert code == 0
    assert {path.name: path.read_text() for path in (tmp_path / "man1").iterdir()} == {
        f"{name}.1": text for name, text in pages().items()
    }


@pytest.mark.skipif(shutil.which("groff") is None, reason="groff is not installed: pages are not set")
def test_the_typesetter_has_no_complaints() -> None:
    for text in pages().values():
        done = subprocess.run(
            ["groff", "-man", "-Tutf8", "-ww", "-z"], input=text, capture_output=True, encoding="utf-8", check=True
        )
        assert done.stderr == ""
