"""The corpus of the parser, one script a row of the language; what is expected stands in the scripts.

A comment ``-- error: CODE`` at the end of a line says that a mistake with this code is reported on that line (several
codes for several mistakes, in their order). Where no comment can stand on the line it says ``-- error: CODE line 2``;
for a mistake in an included file ``-- error: CODE in pieces/file.csp``; for one without a place
``-- error: CODE nowhere``.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.parsing.reading import parse, read_source
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source

CORPUS = Path(__file__).parents[2] / "corpus" / "parse"
PASSING = sorted((CORPUS / "pass").glob("*.csp"))
FAILING = sorted((CORPUS / "fail").glob("*.csp"))

EXPECTED = re.compile(
    r"-- error: (?P<codes>CSP\d+(?: CSP\d+)*)(?P<where> line \d+| in \S+| nowhere)?\s*$", re.MULTILINE
)


def expected(text: str) -> list[tuple[str, str]]:
    """Code and place of each mistake that a script says it makes."""
    found = []
    for match in EXPECTED.finditer(text):
        where = (match["where"] or f" line {text.count(chr(10), 0, match.start()) + 1}").strip()
        found += [(code, where) for code in match["codes"].split()]
    return found


def test_the_corpus_is_there() -> None:
    assert len(PASSING) > 50
    assert len(FAILING) > 150


@pytest.mark.parametrize("path", PASSING, ids=lambda path: path.stem)
def test_a_script_that_passes(path: Path) -> None:
    source = read_source(path)

    script = parse(source)

    # `included` is where the root file lies, so that its includes are found again.
    again = parse(Source(source.name, print_script(script)))
    assert again == script
    assert print_script(again) == print_script(script)


@pytest.mark.parametrize("path", PASSING, ids=lambda path: path.stem)
def test_formatting_a_script_that_passes(path: Path) -> None:
    source = read_source(path)
    script = parse(source)

    formatted = format_source(source)

    again = parse(Source(source.name, formatted))
    assert again == script
    assert [comment.text.split() for comment in again.comments] == [comment.text.split() for comment in script.comments]
    assert format_source(Source(source.name, formatted)) == formatted


@pytest.mark.parametrize("path", FAILING, ids=lambda path: path.stem)
def test_a_script_that_fails(path: Path) -> None:
    text = path.read_bytes().decode("utf-8", errors="replace")
    wanted = expected(text)
    assert wanted, "the script does not say how it fails"

    with pytest.raises(ScriptError) as caught:
        parse(read_source(path))

    reported = []
    for diagnostic in caught.value.diagnostics:
        span = diagnostic.span
        if span is None:
            reported.append((diagnostic.code, "nowhere"))
        elif Path(span.source.name) == path:
            reported.append((diagnostic.code, f"line {span.line}"))
        else:
            reported.append((diagnostic.code, f"in {Path(span.source.name).relative_to(path.parent).as_posix()}"))
    assert reported == wanted
    for diagnostic in caught.value.diagnostics:
        assert diagnostic.code in MISTAKES
        assert diagnostic.message
        assert not diagnostic.message.endswith(".")
        assert diagnostic.message[0] == diagnostic.message[0].lower()


def test_every_mistake_of_form_is_made_by_a_script() -> None:
    made = {code for path in FAILING for code, _ in expected(path.read_bytes().decode("utf-8", errors="replace"))}
    of_form = {code for code in MISTAKES if code < "CSP200"}

    # What cannot be read, nests too deeply or includes a hundred files has tests of its own; three are warnings.
    assert of_form - made == {"CSP001", "CSP012", "CSP013", "CSP016", "CSP017", "CSP136"}
