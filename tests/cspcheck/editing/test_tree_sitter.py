"""The tree-sitter grammar in ``editors``: its trees are those of its corpus, and scripts have no errors in theirs.

The parser that was generated is compiled with the C compiler of the machine and read by the package ``tree-sitter``.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import warnings
from pathlib import Path
from typing import Any

import pytest

from cspcheck.highlighting import KEYWORDS

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "editors" / "tree-sitter-cspm"
CORPUS = ROOT / "tests" / "corpus"
SCRIPTS = [
    path
    for folder in (ROOT / "specs", CORPUS / "parse" / "pass", CORPUS / "types" / "pass")
    for path in folder.rglob("*.csp")
]


@pytest.fixture(scope="module")
def language(tmp_path_factory: pytest.TempPathFactory) -> Any:
    tree_sitter = pytest.importorskip("tree_sitter", reason="the package tree-sitter is not installed")
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    library = tmp_path_factory.mktemp("grammar") / "cspm.so"
    sources = [str(FOLDER / "src" / name) for name in ("parser.c", "scanner.c")]
    command = [compiler, "-shared", "-fPIC", "-O0", "-I", str(FOLDER / "src"), *sources, "-o", str(library)]
    subprocess.run(command, check=True, timeout=600)
    make = ctypes.CDLL(str(library)).tree_sitter_cspm
    make.restype = ctypes.c_void_p
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # an address is a number here
        return tree_sitter.Language(make())


def shape(node: Any, depth: int = 0, field: str | None = None) -> str:
    """A tree as the corpus writes it."""
    children = [(node.field_name_for_child(i), child) for i, child in enumerate(node.children) if child.is_named]
    head = "  " * depth + (f"{field}: " if field else "") + f"({node.type}"
    return "\n".join([head, *(shape(child, depth + 1, name) for name, child in children)]) + ")"


def test_the_corpus(language: Any) -> None:
    import tree_sitter

    text = (FOLDER / "test" / "corpus" / "cspm.txt").read_text(encoding="utf-8")
    cases = re.split(r"^={5,}\n(.*)\n={5,}\n", text, flags=re.MULTILINE)[1:]
    assert len(cases) == 22
    for name, case in zip(cases[::2], cases[1::2], strict=True):
        source, expected = case.split("\n---\n")
        root = tree_sitter.Parser(language).parse((source.strip("\n") + "\n").encode()).root_node
        assert not root.has_error, name
        assert shape(root) == expected.strip("\n"), name


def test_scripts_have_no_errors(language: Any) -> None:
    import tree_sitter

    parser = tree_sitter.Parser(language)
    assert len(SCRIPTS) > 100
    assert [path for path in SCRIPTS if parser.parse(path.read_bytes()).root_node.has_error] == []


def test_highlights(language: Any) -> None:
    import tree_sitter

    query = tree_sitter.Query(language, (FOLDER / "queries" / "highlights.scm").read_text())
    text = b'-- a\nchannel c : {0..1}\nP(i) = c!i -> "x" -> STOP\nassert P(0) :[deadlock free [F]]\n'
    root = tree_sitter.Parser(language).parse(text).root_node
    found = tree_sitter.QueryCursor(query).captures(root)
    words = {name: {node.text.decode() for node in nodes} for name, nodes in found.items()}
    assert words["keyword"] == {"channel", "assert"}
    assert words["comment"] == {"-- a"}
    assert words["function"] == {"P"}
    assert words["attribute"] == {"deadlock free"}
    assert {"STOP"} <= words["constant.builtin"]
    assert {"->", "!", "="} <= words["operator"]


def test_every_keyword_is_known() -> None:
    grammar = (FOLDER / "grammar.js").read_text()
    assert [word for word in KEYWORDS if f'"{word}"' not in grammar] == []
