"""Nothing that a script says becomes code of the program: hostile names, texts, file names and comments."""

from __future__ import annotations

import ast
import tempfile
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

import cspcheck
from cspcheck.codegen import quoting
from cspcheck.codegen.design.program import design
from cspcheck.codegen.emit.project import environment, project
from tests.examples import examples

PIECES = (
    '"',
    "'",
    '"""',
    "'''",
    "\\",
    "\n",
    "\r",
    "\t",
    "{",
    "}",
    "{{",
    "%}",
    "#",
    "`",
    "|",
    "$(x)",
    "\x00",
    "\x1b[31m",
)
PIECES += ("\u2028", "\x85", "\u202e", "é", "+str(__import__('os'))+", "]", ")", "--", "x", " ", "\ud800")
hostile = st.lists(st.sampled_from(PIECES), min_size=1, max_size=6).map("".join)


@given(hostile)
def test_a_literal_is_the_text(text: str) -> None:
    made = quoting.literal(text)
    assert ast.literal_eval(made) == text
    assert made.isprintable()
    made.encode()


@given(hostile, st.booleans())
def test_prose_stays_inside_its_docstring(text: str, one_line: bool) -> None:
    made = quoting.phrase(text) if one_line else quoting.prose(text)
    (statement,) = ast.parse(f'"""{made}"""').body
    assert isinstance(statement, ast.Expr)
    assert isinstance(statement.value, ast.Constant)
    assert made.replace("\n", "").isprintable()


@given(hostile)
def test_a_word_of_a_shell_is_one_word(text: str) -> None:
    import shlex

    assert len(shlex.split(quoting.shell(text))) == 1


@given(hostile)
def test_a_project_has_a_name(text: str) -> None:
    assert tomllib.loads(f'name = "{quoting.project_name(text)}"')["name"]


def test_a_template_takes_nothing_unquoted() -> None:
    template = environment().from_string("x = {{ value }}")
    with pytest.raises(quoting.Unquoted, match="reaches a template unquoted"):
        template.render(value="1")
    assert template.render(value=quoting.code("1")) == "x = 1"


def calls(text: str) -> set[str]:
    """The names that a module calls."""
    return {ast.unparse(node.func) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)}


PLAIN = """
channel s
datatype T = A | B.{0, 1}
channel c : {<'x'>, <'y'>}
channel d : T
P(t) = s -> c!<'x'> -> P(t)   -- COMMENT
Q = s -> c?x -> d?y -> Q
S = P("TEXT") [| {| s, c |} |] Q
"""


def generated(text: str, name: str, folder: str) -> dict[str, str]:
    """The files of the program of a script."""
    # A file name that no file system has is taken too: what reads a script may call it anything.
    script = cspcheck.loads(text, name=name)
    made = project(design(script._script, "S"), folder)
    return {name: text for name, text in {**made.generated, **made.yours}.items() if not name.startswith("runtime/")}


EXPECTED = {name: calls(text) for name, text in generated(PLAIN, "s.csp", "f").items() if name.endswith(".py")}


@settings(max_examples=examples(60))
@given(
    text=st.lists(st.sampled_from(['\\"', "'", "\\\\", "\\n", "{", "#", "+exit()+", "x"]), max_size=5).map("".join),
    comment=hostile.filter(lambda comment: not {"\n", "\r", "\u2028", "\x85", "\ud800"} & set(comment)),
    name=hostile,
    folder=hostile.filter(lambda folder: "\x00" not in folder),
)
def test_hostile_texts_stay_texts(text: str, comment: str, name: str, folder: str) -> None:
    script = PLAIN.replace("TEXT", text).replace("COMMENT", comment)
    files = generated(script, f"{name}.csp", folder)
    assert {name: calls(text) for name, text in files.items() if name.endswith(".py")} == EXPECTED
    tomllib.loads(files["pyproject.toml"])
    for content in files.values():
        content.encode()


def test_a_text_as_an_argument_is_generated_and_runs() -> None:
    from cspcheck.codegen.runtime import Memory, Program
    from tests.codegen.programs import generate, loaded

    text = PLAIN.replace("TEXT", "\\\"+str(__import__('os').system('echo PWNED'))+\\\"")
    with tempfile.TemporaryDirectory() as folder:
        generate(cspcheck.loads(text), "S", Path(folder))
        with loaded(Path(folder)) as main:
            memory = Memory()
            Program(main.tasks()).run("loop", recorder=memory, events=2)
        (name,) = {name for record in memory.records for name in record.tasks if name != "Q"}
    assert name == "P(\"\\\"+str(__import__('os').system('echo PWNED'))+\\\"\")"
