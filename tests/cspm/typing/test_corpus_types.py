"""Every script of ``tests/corpus/types`` is accepted, or rejected with the mistakes that it says, where it says.

In ``pass``, ``-- type: NAME :: TYPE`` pins the inferred type of a definition. In ``fail``, ``-- error: CODE`` at the
end of a line says that the mistake of that code, and no other, is reported on that line.
"""

import re
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming import resolve as names
from cspcheck.cspm.parsing import reading as parser
from cspcheck.cspm.script import load
from cspcheck.cspm.typing.inference import Types, infer

CORPUS = Path(__file__).parents[2] / "corpus" / "types"
PASS = sorted((CORPUS / "pass").glob("*.csp"))
FAIL = sorted((CORPUS / "fail").glob("*.csp"))
SPECS = sorted((CORPUS.parent.parent.parent / "specs").glob("**/*.csp"))
EVALUATED = sorted((CORPUS.parent / "evaluate" / "pass").glob("*.csp"))


def types_of(path: Path) -> Types:
    script = parser.parse(parser.read_source(path))
    return infer(script, names.resolve(script))


@pytest.mark.parametrize("path", PASS, ids=lambda path: path.stem)
def test_a_good_script_gets_the_types_that_it_says(path: Path) -> None:
    found = dict(types_of(path).listing())
    for name, expected in re.findall(r"-- type: (\S+) :: (.+)", path.read_text()):
        assert f"{name} :: {found[name]}" == f"{name} :: {expected.strip()}"


@pytest.mark.parametrize("path", FAIL, ids=lambda path: path.stem)
def test_a_bad_script_gets_the_mistakes_that_it_says(path: Path) -> None:
    expected = {
        (number, code)
        for number, line in enumerate(path.read_text().splitlines(), 1)
        for code in re.findall(r"-- error: (CSP\d+)", line)
    }
    assert expected, "the script says no mistake"
    with pytest.raises(ScriptError) as raised:
        types_of(path)
    assert {(d.span.line, d.code) for d in raised.value.diagnostics if d.span is not None} == expected


@pytest.mark.parametrize("path", [*SPECS, *EVALUATED], ids=lambda path: path.stem)
def test_what_is_checked_and_evaluated_elsewhere_is_well_typed(path: Path) -> None:
    types = load(path).types

    assert types is not None
    assert all(text for _, text in types.listing())


def test_the_corpus_has_scripts_of_both_kinds() -> None:
    assert len(PASS) >= 20
    assert len(FAIL) >= 40
