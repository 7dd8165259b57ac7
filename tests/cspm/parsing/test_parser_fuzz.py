"""No input crashes the parser: it ends in a tree or in diagnostics.

The environment variable ``CSPCHECK_FUZZ`` says how many inputs are tried (20,000 without it, those of
``tests/cspm/test_script_fuzz.py`` included).
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.parsing.lexer import tokenise
from cspcheck.cspm.parsing.reading import decode, parse, parse_assertion, parse_expression
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from tests.cspm import causes
from tests.cspm.damaging import PIECES, chances, damaged_texts, told
from tests.cspm.syntax.strategies_syntax import fuzz, scripts, without_brackets

pytestmark = pytest.mark.slow

CORPUS = Path(__file__).parents[2] / "corpus"
SCRIPTS = [path.read_bytes() for path in sorted(CORPUS.rglob("*.csp"))]
SCRIPTS += [text.encode() for text in (*causes.SCRIPTS, *causes.CLASSES)]


def unreadable(path: str) -> Source:
    return Source(f"<{path}>", "y = )" if len(path) % 2 else "y = 1")


def check_refusal(error: ScriptError) -> None:
    assert error.diagnostics
    for diagnostic in error.diagnostics:
        assert diagnostic.code in MISTAKES
        for span in [diagnostic.span, *(label.span for label in diagnostic.labels)]:
            if span is not None:
                assert 0 <= span.start <= span.end <= len(span.source.text)


def check_tree(source: Source, script: s.Script) -> None:
    """What must hold of every text that parses."""
    printed = print_script(script)
    again = parse(Source(source.name, printed), include=unreadable)
    assert again == script
    if any(remark.code == "CSP017" for remark in script.remarks):
        with pytest.raises(ScriptError):
            format_source(source)
        return
    formatted = format_source(source)
    tidied = parse(Source(source.name, formatted), include=unreadable)
    assert tidied == script
    assert [c.text.split() for c in tidied.comments] == [c.text.split() for c in script.comments]
    assert format_source(Source(source.name, formatted)) == formatted


def goes_through(content: bytes) -> None:
    """A text is decoded and read, or refused in words; and what is read can be written."""
    try:
        source = decode("mutated.csp", content)
        script = parse(source, include=unreadable)
    except ScriptError as error:
        check_refusal(error)
    else:
        check_tree(source, script)


@pytest.mark.parametrize("part", range(4))
def test_mutations_of_the_corpus(part: int) -> None:
    for content in damaged_texts(f"parser {part}", 0.15, SCRIPTS):
        with told(content):
            goes_through(content)


def test_heaps_of_pieces() -> None:
    for chance in chances("heaps", 0.11):
        pieces = chance.choices(PIECES, k=chance.randint(0, 30))
        source = decode("heap.csp", b"".join(pieces).replace(b"\0", b""))
        for read in (lambda source: parse(source, include=unreadable), parse_expression, parse_assertion):
            with told(source.text):
                try:
                    read(source)
                except ScriptError as error:
                    check_refusal(error)


# What can stand between two tokens: comments of all kinds, and line breaks.
BETWEEN = [
    *("{- b -}", " {- b\n c -} ", " -- l\n", "\n-- o\n", "\n\n-- o\n-- p\n\n", "\n{- b -}\n", "\n", " {- x -} -- l\n"),
    *("\n\n\n", "{--}", " --\n"),
]


@fuzz(0.01)
@given(
    scripts(1) | scripts(2),
    st.sampled_from([20, 60, 100]),
    st.lists(st.tuples(st.integers(0, 10_000), st.sampled_from(BETWEEN)), max_size=5),
)
def test_random_scripts_with_comments_anywhere(script: s.Script, width: int, between: list[tuple[int, str]]) -> None:
    printed = print_script(script, width=width)
    again = parse(Source("", printed))
    # What is printed says the same; brackets may be added, and once they are there it is exact.
    assert without_brackets(again) == without_brackets(script)
    assert parse(Source("", print_script(again))) == again

    starts = tokenise(Source("", printed)).starts
    text = printed
    for number, comment in sorted(((number % len(starts), comment) for number, comment in between), reverse=True):
        text = text[: starts[number]] + comment + text[starts[number] :]
    source = Source("random.csp", text)
    try:
        commented = parse(source)
    except ScriptError as error:
        check_refusal(error)  # a line break in the wrong place
    else:
        check_tree(source, commented)
