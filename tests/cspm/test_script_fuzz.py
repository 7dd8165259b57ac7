"""No input crashes what comes behind the parser either: names, types, values and processes end in diagnostics.

Inputs are mutations of the corpus, byte by byte and word by word, and scripts made from the grammar; ``CSPCHECK_FUZZ``
says how many, as for the parser.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.parsing.reading import decode
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from cspcheck.runs import read_records
from tests.cspm import causes
from tests.cspm.damaging import SMALL, chances, damaged_texts, short_patience, told
from tests.cspm.evaluator.test_corpus_evaluate import operands
from tests.cspm.parsing.test_parser_fuzz import CORPUS, SCRIPTS
from tests.cspm.syntax.strategies_syntax import fuzz, scripts
from tests.cspm.typing.test_inference_robustness import WORD, scrambled

pytestmark = pytest.mark.slow

LONG = ("depth", "too_deep", "huge", "infinite_search", "infinite_concat", "infinite_prefix")
"""Scripts that show what happens after a million steps."""
TEXTS = [
    path.read_text(encoding="utf-8")
    for path in sorted([*CORPUS.glob("evaluate/*/*.csp"), *CORPUS.glob("types/*/*.csp"), *CORPUS.glob("names/*/*.csp")])
    if not path.stem.startswith(LONG)
]
TEXTS += causes.SCRIPTS


def through(share: float) -> settings:
    """The settings of the tests: no time limit, for a recursion without end may take seconds to reach its limit."""
    return settings(fuzz(share), deadline=None)


SPECS = Path(__file__).parents[2] / "specs"


@pytest.fixture(autouse=True)
def _short_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    short_patience(monkeypatch)


FEW = 30
"""So many terms of each assertion are unfolded."""


def goes_through(source: Source, typechecks: Sequence[bool] = (True, False)) -> None:
    """Everything that can be asked of a script, with types and without, ends in an answer or in diagnostics."""
    for typecheck in typechecks:
        script = answered(lambda typecheck=typecheck: load(source, typecheck=typecheck))
        if script is None:
            continue
        for assertion in script.assertions:
            terms = answered(lambda script=script, node=assertion.node: operands(script, node))
            for term in terms or ():
                unfold(term)


def answered(ask: Callable[[], Any]) -> Any:
    """What is asked for, or None where the answer is a mistake, which must be one of the register with a text."""
    try:
        return ask()
    except ScriptError as error:
        refused = error
    assert refused.diagnostics
    for diagnostic in refused.diagnostics:
        assert diagnostic.code in MISTAKES
        assert diagnostic.message
    return None


def unfold(term: Process) -> None:
    """Evaluate the bodies of some of the references in a term."""
    seen: set[Process] = set()
    stack: list[object] = [term]
    while stack and len(seen) < FEW:
        item = stack.pop()
        if isinstance(item, tuple):
            stack.extend(item[:FEW])
        elif isinstance(item, Process) and item not in seen:
            seen.add(item)
            if isinstance(item, Reference):
                stack.append(answered(item.body))
            else:
                stack.extend(getattr(item, field, None) for field in item.__dataclass_fields__)


def test_mutations_of_the_corpus_go_through() -> None:
    for content in damaged_texts("scripts", 0.1, SCRIPTS):
        with told(content):
            source = answered(lambda content=content: decode("mutated.csp", content))
            if source is not None and not any(word in source.text for word in ("000", "include")):
                goes_through(source)


def test_scrambled_scripts_of_the_corpus_go_through() -> None:
    """Words of a script in the places of others: most of these parse, and mean something else or nothing."""
    small = [text for text in TEXTS if len(text) <= SMALL and WORD.search(text)]
    for chance in chances("scrambled", 0.07):
        text = scrambled(chance.choice(small), chance)
        with told(text):
            goes_through(Source("scrambled.csp", text))


@pytest.mark.parametrize("text", [*causes.SCRIPTS, *causes.CLASSES])
def test_what_once_failed_goes_through(text: str) -> None:
    goes_through(Source("cause.csp", text))


CLASSES = [text.encode() for text in causes.CLASSES] + [
    (SPECS / name).read_bytes() for name in ("producer_consumer/classes.csp", "stack/stack.csp")
]
DOCUMENTS = [text.encode() for text in causes.DOCUMENTS] + [
    (SPECS / name).read_bytes() for name in ("producer_consumer/classes.tex", "stack/stack.tex")
]


@pytest.mark.parametrize(("name", "contents"), [("mutated.csp", CLASSES), ("mutated.tex", DOCUMENTS)])
def test_mutations_of_classes_go_through(name: str, contents: list[bytes]) -> None:
    for content in damaged_texts(name, 0.03, contents):
        with told(content):
            source = answered(lambda content=content: decode(name, content))
            if source is not None and not any(word in source.text for word in ("000", "include")):
                goes_through(source, typechecks=(True,))


def test_mutations_of_recorded_runs_are_records_or_told() -> None:
    for content in damaged_texts("runs", 0.04, causes.RUNS):
        with told(content):
            lines = content.decode(errors="replace").splitlines()
            answered(lambda lines=lines: list(read_records(lines, "run.jsonl")))


@through(0.01)
@given(scripts(1) | scripts(2))
def test_scripts_from_the_grammar_go_through(script: s.Script) -> None:
    goes_through(Source("made.csp", print_script(script)))


def test_the_scripts_are_there_and_some_are_good() -> None:
    good = [text for text in TEXTS if isinstance(answered(lambda text=text: load(Source("", text))), Script)]
    assert len(TEXTS) > 200
    assert len(good) > 60
