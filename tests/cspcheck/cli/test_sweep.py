"""Checking over a range of values: which values, the table, the document, exit codes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.cli import run
from cspcheck.sweeping import combinations, parse_sweep, split_at_commas, varying

SCRIPT = """\
N = 3
M = 1
channel c : {0..100}
Count(n) = if n >= N * M then STOP else c.n -> Count(n + 1)
assert Count(0) :[divergence free]
-- expect: fail
assert Count(0) :[deadlock free]
assert c.0 -> c.1 -> STOP [T= Count(0)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "count.csp").write_text(SCRIPT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def swept(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = run(["sweep", "count.csp", *arguments, "--color", "never"])
    out, err = capsys.readouterr()
    return code, re.sub(r"\d+\.\d\d s\b", "... s", out), err


class TestValues:
    @pytest.mark.parametrize(
        ("text", "values"),
        [
            ("2..5", ["2", "3", "4", "5"]),
            ("2,4,8", ["2", "4", "8"]),
            ("1..3, 10", ["1", "2", "3", "10"]),
            ("-1..1", ["-1", "0", "1"]),
            ("5", ["5"]),
            ("3,3,2..3", ["3", "2"]),
            ("{0..3}", ["{0..3}"]),
            ("{0},{0,1},{0..2}", ["{0}", "{0,1}", "{0..2}"]),
            ("<1,2>,<3>", ["<1,2>", "<3>"]),
            ("true,false", ["true", "false"]),
            ("f(1,2)", ["f(1,2)"]),
        ],
    )
    def test_of_a_constant(self, text: str, values: list[str]) -> None:
        assert list(parse_sweep("N", text).values) == values

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            ("5..2", "`5..2` goes down; write it as `2..5`"),
            ("1..1000000", "are 1,000,000 values"),
            ("1,,2", "a comma without a value"),
        ],
    )
    def test_that_mean_nothing(self, text: str, said: str) -> None:
        with pytest.raises(ValueError, match=re.escape(said)):
            parse_sweep("N", text)

    def test_the_last_constant_changes_fastest(self) -> None:
        both = [parse_sweep("N", "1..2"), parse_sweep("M", "a,b")]
        assert [tuple(values.values()) for values in combinations(both)] == [
            ("1", "a"),
            ("1", "b"),
            ("2", "a"),
            ("2", "b"),
        ]

    def test_constants_with_one_value_are_not_told_in_each_row(self) -> None:
        assert varying([parse_sweep("N", "1..2"), parse_sweep("M", "5")]) == ["N"]
        assert varying([parse_sweep("N", "1"), parse_sweep("M", "5")]) == ["N", "M"]

    def test_text_in_quotes_is_not_split(self) -> None:
        assert split_at_commas('"a,b", c') == ['"a,b"', "c"]


class TestTable:
    def test_one_constant(self, folder: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
        assert swept(capsys, "-D", "N=1..4") == (1, snapshot, "")

    def test_two_constants(self, folder: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
        assert swept(capsys, "-D", "N=1,2", "-D", "M=1..2", "--assert", "divergence") == (0, snapshot, "")

    def test_limits_and_reasons(
        self, folder: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
    ) -> None:
        code, out, _ = swept(capsys, "-D", "N=1,20", "--max-states", "5", "--assert", "divergence")

        assert code == 3
        assert out == snapshot

    def test_what_is_wrong_for_one_value_is_told_with_it(
        self, folder: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
    ) -> None:
        code, out, err = swept(capsys, "-D", "N=2,true", "--assert", "divergence")

        assert code == 2
        assert out == snapshot
        assert "error[CSP301]" in err
        assert "= note: with N=true" in err

    def test_an_evaluation_that_fails_is_a_row(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        code, out, err = swept(capsys, "-D", "N=100,102", "--assert", "divergence")

        assert code == 2
        assert [line.split()[:3] for line in out.splitlines()[-2:]] == [["100", "✓", "pass"], ["102", "!", "error"]]
        assert err.count("CSP409") == 1

    def test_rows_keep_to_eighty_columns(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        _, out, _ = swept(capsys, "-D", "N=1..50", "--max-states", "5")

        assert max(map(len, out.splitlines())) <= 80


class TestDocument:
    def test_each_result_has_its_values(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        code = run(["sweep", "count.csp", "-D", "N=1..3", "-D", "M=2", "--format", "json", "--assert", "free"])
        document = json.loads(capsys.readouterr().out)

        assert code == 0
        assert [(r["definitions"], r["verdict"], r["states"]) for r in document["results"]] == [
            ({"N": n, "M": "2"}, verdict, 2 * int(n) + 1) for n in "123" for verdict in ("pass", "fail")
        ]
        assert document["summary"] == {"pass": 3, "fail": 3, "unknown": 0, "error": 0}
        assert list(document) == ["schema", "version", "interrupted", "results", "diagnostics", "summary"]

    def test_it_goes_to_a_file(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        run(["sweep", "count.csp", "-D", "N=1,true", "--format", "json", "-o", "out.json"])
        document = json.loads((folder / "out.json").read_text())

        assert capsys.readouterr().out == ""
        assert document["diagnostics"][0]["definitions"] == {"N": "true"}
        assert document["summary"]["error"] == 1


class TestWrongUse:
    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            ([], "no values to sweep over"),
            (["-D", "N=9..1"], "`9..1` goes down"),
            (["-D", "N"], "`N` is not NAME=EXPR"),
            (["-D", "K=1..2"], "`K`"),
            (["-D", "N=1", "--assert", "nothing"], "no assertion selected"),
        ],
    )
    def test_is_said(self, folder: Path, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
        code, _, err = swept(capsys, *arguments)

        assert code in (2, 5)
        assert said in err
