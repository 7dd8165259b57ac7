"""The parse table: computed once, kept in the user's cache folder, and never in the way."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cspcheck.cspm import caches
from cspcheck.cspm.parsing.table import GRAMMAR, compute, from_json, table

PROGRAM = """
import sys
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
parse(Source("", "P = a -> P"))
print("lark" in sys.modules)
"""


def run(cache: Path, said: str = "") -> bool:
    """Whether a fresh process with this cache folder had to import Lark to parse a script; *said* on standard error."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=os.environ | {"XDG_CACHE_HOME": str(cache), "LOCALAPPDATA": str(cache), "HOME": str(cache)},
        cwd=Path(__file__).parents[3],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == said
    return done.stdout.strip() == "True"


def test_only_the_first_process_computes_the_table(tmp_path: Path) -> None:
    assert run(tmp_path)
    assert not run(tmp_path)


def test_a_damaged_table_is_replaced(tmp_path: Path) -> None:
    run(tmp_path)
    (file,) = tmp_path.rglob("grammar-*")
    whole = file.read_text()
    for damage in ("", '{"rules":[],"rows":[],"states":[],"starts":{}}', whole[: len(whole) // 2], whole + " "):
        file.write_text(damage)
        assert run(tmp_path, f"the cache file `{file}` was damaged and is made anew\n")
        assert file.read_text() == whole


def test_a_folder_that_cannot_be_made_costs_time_only(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert run(tmp_path / "file")


def test_nothing_but_the_table_is_left_in_the_folder(tmp_path: Path) -> None:
    run(tmp_path)
    assert len([path for path in tmp_path.rglob("*") if path.is_file()]) == 1


def test_the_stored_table_is_the_computed_one() -> None:
    value = compute(GRAMMAR.read_text(encoding="utf-8"))
    assert from_json(json.loads(json.dumps(value))) == table()


def test_a_conflict_in_the_grammar_is_refused() -> None:
    from lark.exceptions import GrammarError

    grammar = "script: script script | NAME\nlone_expression: NAME\nlone_assertion: NAME\n%declare NAME"
    with pytest.raises(GrammarError, match="Shift/Reduce conflict"):
        compute(grammar)


def test_every_action_of_the_grammar_has_its_method() -> None:
    from cspcheck.cspm.parsing.builder import TreeBuilder

    actions = {rule.action for rule in table().rules if rule.action} - {"nothing", "first", "more"}
    assert all(hasattr(TreeBuilder, action) for action in actions)
    for rule in table().rules:
        assert rule.action is not None or len(rule.kept) == 1


def test_the_folder_follows_the_custom_of_the_system(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(caches.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert caches.cache_folder() == tmp_path / "cspcheck"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert caches.cache_folder() == tmp_path / ".cache" / "cspcheck"
    monkeypatch.setattr(caches.sys, "platform", "darwin")
    assert caches.cache_folder() == tmp_path / "Library" / "Caches" / "cspcheck"
    monkeypatch.setattr(caches.sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path))
    assert caches.cache_folder() == tmp_path / "cspcheck" / "cache"
