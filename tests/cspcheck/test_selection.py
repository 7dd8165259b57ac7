"""What FILE, FILE:LINE, FOLDER and --assert PATTERN stand for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from cspcheck.cspm.source import Source, Span
from cspcheck.selection import AssertionPattern, EmptyFolder, Target, select, targets


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: Path, text: str = "") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def paths(arguments: list[str]) -> list[str]:
    return [target.path for target in targets(arguments)]


class TestTargets:
    def test_a_file_is_itself_even_if_there_is_none(self, folder: Path) -> None:
        assert targets(["a.csp", "-"]) == [Target("a.csp"), Target("-")]

    def test_a_line_of_a_file(self, folder: Path) -> None:
        write(folder / "a.csp")

        assert targets(["a.csp:12", "b.csp:3"]) == [Target("a.csp", frozenset({12})), Target("b.csp", frozenset({3}))]

    def test_a_file_with_a_colon_in_its_name(self, folder: Path) -> None:
        write(folder / "a.csp:12")

        assert targets(["a.csp:12"]) == [Target("a.csp:12")]

    def test_several_lines_of_a_file_are_one_target(self, folder: Path) -> None:
        assert targets(["a.csp:12", "./a.csp:3"]) == [Target("a.csp", frozenset({3, 12}))]

    def test_a_file_and_a_line_of_it_are_the_file(self, folder: Path) -> None:
        assert targets(["a.csp:12", "a.csp"]) == [Target("a.csp")]
        assert targets(["a.csp", "a.csp:12"]) == [Target("a.csp")]

    def test_a_folder_is_its_scripts_in_order_without_hidden_folders(self, folder: Path) -> None:
        for name in ("d/z.csp", "d/a/b.csp", "d/.git/c.csp", "d/notes.txt", "d/a/a.csp"):
            write(folder / name)

        assert paths(["d"]) == ["d/z.csp", "d/a/a.csp", "d/a/b.csp"]
        assert not any(isinstance(target, Target) and target.named for target in targets(["d"]))

    def test_a_script_of_a_folder_that_is_named_too_counts_as_named(self, folder: Path) -> None:
        write(folder / "d/a.csp")

        assert targets(["d", "d/a.csp"]) == [Target("d/a.csp", None, named=True)]

    def test_what_others_in_a_folder_include_is_no_script_of_its_own(self, folder: Path) -> None:
        write(folder / "d/main.csp", 'include "parts/types.csp"\n  include"common.csp"\n')
        write(folder / "d/parts/types.csp")
        write(folder / "d/common.csp")
        write(folder / "d/other.csp", '-- include "other.csp"\n')

        assert paths(["d"]) == ["d/main.csp", "d/other.csp"]
        assert paths(["d/common.csp"]) == ["d/common.csp"]

    def test_the_paths_of_nested_includes_count_from_the_first_script(self, folder: Path) -> None:
        write(folder / "d/main.csp", 'include "parts/model.csp"\n')
        write(folder / "d/parts/model.csp", 'include "parts/types.csp"\ninclude "rest.csp"\n')
        write(folder / "d/parts/types.csp")
        write(folder / "d/rest.csp")
        # Not what the model includes, which is the one beside the main script.
        write(folder / "d/parts/rest.csp")

        assert paths(["d"]) == ["d/main.csp", "d/parts/rest.csp"]

    def test_scripts_that_include_each_other_are_told_as_such(self, folder: Path) -> None:
        write(folder / "d/a.csp", 'include "b.csp"\n')
        write(folder / "d/b.csp", 'include "a.csp"\n')
        write(folder / "d/own.csp", 'include "own.csp"\n')

        assert paths(["d"]) == ["d/a.csp", "d/b.csp", "d/own.csp"]

    def test_a_folder_without_scripts(self, folder: Path) -> None:
        (folder / "empty").mkdir()

        assert targets(["empty"]) == [EmptyFolder("empty")]


class TestPattern:
    @pytest.mark.parametrize(
        ("pattern", "matches"),
        [
            ("deadlock", True),
            ("deadlock free", True),
            ("deadlockfree", True),
            ("SYSTEM:[deadlock", True),
            ("SYS*free", True),
            ("*", True),
            ("", True),
            ("free*SYS", False),
            ("Deadlock", False),
            ("d.adlock", False),
            ("[FD]", True),
            ("[dF]", False),
            ("SYSTEM \\ {| a |}", True),
        ],
    )
    def test_a_pattern_matches_where_it_occurs(self, pattern: str, matches: bool) -> None:
        assert (
            AssertionPattern(pattern).matches("SYSTEM \\ {|a|} :[deadlock free [FD]]" if "\\" in pattern else TEXT)
            is matches
        )


TEXT = "SYSTEM :[deadlock free [FD]]"


@dataclass(frozen=True)
class Assertion:
    text: str
    span: Span


def test_lines_and_patterns_select_together() -> None:
    source = Source("x.csp", "one\ntwo\nthree\nfour\n")
    lines = {"one": (0, 3), "two three": (4, 13), "four": (14, 18)}
    assertions = [Assertion(text, source.span(*place)) for text, place in lines.items()]

    def chosen(numbers: frozenset[int] | None, *patterns: str) -> list[str]:
        return [a.text for a in select(assertions, numbers, [AssertionPattern(p) for p in patterns])]  # type: ignore[arg-type,misc]

    assert chosen(None) == ["one", "two three", "four"]
    assert chosen(frozenset({3})) == ["two three"]
    assert chosen(frozenset({1, 4})) == ["one", "four"]
    assert chosen(None, "o*e", "four") == ["one", "two three", "four"]
    assert chosen(frozenset({1, 2}), "three") == ["two three"]
    assert chosen(frozenset({9})) == []
