"""No input crashes the parser: it ends in a tree or in diagnostics, within five seconds.

The environment variable ``CSPCHECK_FUZZ`` says how many inputs are tried (5000 without it).
"""

from __future__ import annotations

from collections.abc import Sequence
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
from tests.cspm.syntax.strategies_syntax import fuzz, scripts, without_brackets

pytestmark = pytest.mark.slow

CORPUS = Path(__file__).parents[2] / "corpus"
SCRIPTS = [path.read_bytes() for path in sorted(CORPUS.rglob("*.csp"))]
SCRIPTS += [text.encode() for text in (*causes.SCRIPTS, *causes.CLASSES)]

PIECES = [
    *(b"(", b")", b"{", b"}", b"<", b">", b"{|", b"|}", b"[|", b"|]", b"[[", b"]]", b"[", b"]", b"(| ", b"|)", b"|>"),
    *(b"->", b"[]", b"|~|", b"|||", b"||", b";", b"\\", b"@", b"@@", b"=", b"==", b"::", b":", b".", b"..", b"_", b"?"),
    *(
        b"let ",
        b" within ",
        b"if ",
        b" then ",
        b" else ",
        b"not ",
        b"channel ",
        b"module M\n",
        b"exports\n",
        b"assert ",
    ),
    *(
        b"\n",
        b"\r\n",
        b" ",
        b"{-",
        b"-}",
        b"--",
        b'"',
        b"'",
        b"\0",
        b"\xff",
        b"\xc3",
        b"[T=",
        b":[",
        b":[deadlock free]",
    ),
    *(b'include "x"\n', b"Timed { ", b"x", b"f(", b"0", b"-", b"# "),
]


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


@st.composite
def mutated(draw: st.DrawFn) -> bytes:
    """A script of the corpus with some bytes changed, dropped, added or moved."""
    return draw(damaged(SCRIPTS))


@st.composite
def damaged(draw: st.DrawFn, contents: Sequence[bytes]) -> bytes:
    """One of the texts with some bytes changed, dropped, added or moved."""
    content = draw(st.sampled_from(contents))
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(content)))
        end = min(place + draw(st.integers(0, 12)), len(content))
        match draw(st.integers(0, 4)):
            case 0:
                content = content[:place] + content[end:]
            case 1:
                content = content[:place] + draw(st.sampled_from(PIECES)) + content[place:]
            case 2:
                content = content[:place] + draw(st.binary(min_size=1, max_size=3)) + content[end:]
            case 3:
                content = content[:end] + content[place:]
            case _:
                content = content[end:] + content[:place]
    return content


@fuzz(0.7)
@given(mutated())
def test_mutations_of_the_corpus(content: bytes) -> None:
    try:
        source = decode("mutated.csp", content)
        script = parse(source, include=unreadable)
    except ScriptError as error:
        check_refusal(error)
    else:
        check_tree(source, script)


@fuzz(0.1)
@given(st.lists(st.sampled_from(PIECES), max_size=30))
def test_heaps_of_pieces(pieces: list[bytes]) -> None:
    source = decode("heap.csp", b"".join(pieces).replace(b"\0", b""))
    for read in (lambda source: parse(source, include=unreadable), parse_expression, parse_assertion):
        try:
            read(source)
        except ScriptError as error:
            check_refusal(error)


# What can stand between two tokens: comments of all kinds, and line breaks.
BETWEEN = [
    *("{- b -}", " {- b\n c -} ", " -- l\n", "\n-- o\n", "\n\n-- o\n-- p\n\n", "\n{- b -}\n", "\n", " {- x -} -- l\n"),
    *("\n\n\n", "{--}", " --\n"),
]


@fuzz(0.2)
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
