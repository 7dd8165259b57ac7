"""The colours of scripts: the Pygments lexer, and the grammars that are made from its words."""

import json
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

from cspcheck.highlighting import CspmLexer

ROOT = Path(__file__).resolve().parents[3]


def kinds(text: str) -> list[tuple[str, str]]:
    return [(str(kind).removeprefix("Token."), value) for kind, value in CspmLexer().get_tokens(text) if value.strip()]


@pytest.mark.parametrize("script", sorted((ROOT / "specs").rglob("*.csp")), ids=lambda p: p.name)
def test_every_character_of_the_exhibits_is_known(script: Path) -> None:
    text = script.read_text(encoding="utf-8")
    tokens = list(CspmLexer(stripnl=False, ensurenl=False).get_tokens(text))
    assert "".join(value for _, value in tokens) == text
    odd = [value for kind, value in tokens if str(kind) in ("Token.Error", "Token.Text")]
    assert odd == []


def test_kinds() -> None:
    assert kinds("Q(x) = c!x -> STOP -- on") == [
        ("Name.Function", "Q"),
        ("Punctuation", "("),
        ("Name", "x"),
        ("Punctuation", ")"),
        ("Operator", "="),
        ("Name", "c"),
        ("Operator", "!"),
        ("Name", "x"),
        ("Operator", "->"),
        ("Name.Builtin", "STOP"),
        ("Comment.Single", "-- on"),
    ]
    assert kinds("assert P' :[deadlock free [FD]]")[2:] == [
        ("Operator", ":["),
        ("Keyword.Pseudo", "deadlock free [FD]"),
        ("Operator", "]"),
    ]
    assert kinds("{-1, 0 -} { -1, 0}")[0] == ("Comment.Multiline", "{-")  # as the language reads it
    assert kinds("{- a {- b -} c -} { -1, 0}")[-5:] == [
        ("Operator", "-"),
        ("Literal.Number.Integer", "1"),
        ("Punctuation", ","),
        ("Literal.Number.Integer", "0"),
        ("Punctuation", "}"),
    ]


def test_the_files_of_the_editors_are_those_that_are_made() -> None:
    made = runpy.run_path(str(ROOT / "editors" / "generate.py"))["FILES"]
    for name, make in made.items():
        assert (ROOT / "editors" / name).read_text(encoding="utf-8") == make(), "run python editors/generate.py"


def test_the_extension_is_whole() -> None:
    folder = ROOT / "editors" / "vscode"
    package = json.loads((folder / "package.json").read_text())
    contributes = package["contributes"]
    for path in [
        package["main"],
        *[grammar["path"] for grammar in contributes["grammars"]],
        *[language["configuration"] for language in contributes["languages"]],
    ]:
        assert (folder / path).exists()
    from cspcheck import __version__

    assert package["version"] == __version__
    source = (folder / package["main"]).read_text()
    for command in contributes["commands"]:
        assert f'"{command["command"]}"' in source


@pytest.mark.skipif(shutil.which("vim") is None, reason="there is no vim")
def test_vim_takes_scripts_for_cspm(tmp_path: Path) -> None:
    (tmp_path / "x.csp").write_text("-- a\nP = STOP\n")
    asked = "[&filetype, &makeprg, synIDattr(synID(1, 1, 1), 'name'), synIDattr(synID(2, 1, 1), 'name')]"
    commands = [
        f"set runtimepath^={ROOT / 'editors' / 'vim'}",
        "filetype plugin on",
        "syntax on",
        f"edit {tmp_path / 'x.csp'}",
        f"call writefile({asked}, '{tmp_path / 'said'}')",
        "quitall!",
    ]
    arguments = [word for command in commands for word in ("-c", command)]
    subprocess.run(["vim", "-u", "NONE", "-N", "-e", "-s", *arguments], check=False, timeout=60)
    said = (tmp_path / "said").read_text().splitlines()
    assert said == ["cspm", "cspcheck --format concise %:S", "cspmComment", "cspmDefinition"]
