"""The names of FDR4's Python API, as programs that were written for it use them."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck import fdr

SCRIPT = """
channel a, b
N = 3
P = a -> b -> P
Q = a -> SKIP
print N + 1
assert P :[deadlock free]
assert P [T= a -> a -> STOP
assert Q :[deadlock free]
"""


@pytest.fixture
def session(tmp_path: Path) -> fdr.Session:
    (tmp_path / "s.csp").write_text(SCRIPT)
    fdr.library_init()
    opened = fdr.Session()
    opened.load_file(tmp_path / "s.csp")
    return opened


def test_the_loop_of_every_program(session: fdr.Session) -> None:
    answers = {}
    for assertion in session.assertions():
        assertion.execute(None)
        answers[str(assertion)] = (assertion.passed(), [found.kind for found in assertion.counterexamples()])
    fdr.library_exit()

    assert list(answers.values()) == [(True, []), (False, ["trace"]), (False, ["deadlock"])]
    assert next(iter(answers)).startswith("P :[deadlock free")
    assert session.assertions()[1].to_string() == "P [T= a -> a -> STOP"


def test_further_assertions_and_expressions(session: fdr.Session) -> None:
    assertion = session.parse_assertion("assert a -> STOP [T= P")
    assertion.execute(None)
    assert not assertion.passed()
    assert assertion.counterexamples()[0].event == "b"
    assert session.evaluate_expression("N * 2", None) == 6
    assert session.print_statements() == ["4"]
    assert fdr.version()


def test_what_is_wrong(session: fdr.Session, tmp_path: Path) -> None:
    with pytest.raises(fdr.Error, match="no file is loaded"):
        fdr.Session().assertions()
    with pytest.raises(fdr.FileLoadError, match="no such file"):
        session.load_file(tmp_path / "none.csp")
    (tmp_path / "bad.csp").write_text("P = nobody -> P\n")
    with pytest.raises(fdr.FileLoadError, match="nobody"):
        fdr.Session().load_file(tmp_path / "bad.csp")
    with pytest.raises(fdr.InputFileError, match="nobody"):
        session.parse_assertion("P [T= nobody").execute(None)
    with pytest.raises(fdr.InputFileError):
        session.evaluate_expression("1 +", None)
    with pytest.raises(fdr.Error, match="has not been executed"):
        session.assertions()[0].passed()
