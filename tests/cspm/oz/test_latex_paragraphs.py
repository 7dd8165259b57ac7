r"""Paragraphs of documents that are more than boxes: conjectures, theorems, templates, generic constants, strokes."""

from __future__ import annotations

import pytest

from cspcheck.checker.proof.question import Found, Impossible
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.oz.writing.latex_writer import write_latex
from cspcheck.cspm.oz.writing.printer import print_paragraph
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import prover


def read(text: str) -> list[str]:
    """The paragraphs of a document in the text notation."""
    return [print_paragraph(d) for d in parse(Source("paragraphs.tex", text)).declarations]


NEAR = r"""
\begin{zed} \relation (\varg near \varg) \end{zed}
\begin{axdef} \varg near \varg : \nat \rel \nat \where
  \forall m, n : \nat @ m~near~n \iff m = n \lor m = n + 1
\end{axdef}
"""


@pytest.mark.parametrize(
    ("text", "paragraphs"),
    [
        (r"\begin{zed} \vdash? 1 < 2 \end{zed}", ["lemma conjecture_1 : 1 < 2"]),
        (
            "\\begin{zed} A == 1 \\\\\n \\vdash ? A < 2 \\\\ B == 2 \\end{zed}",
            ["A == 1", "lemma conjecture_2 : A < 2", "B == 2"],
        ),
        (r"\begin{zed} theorem~less\_ two [X] \vdash? 1 < 2 \end{zed}", ["lemma less_two[X] : 1 < 2"]),
        (r"\begin{theorem}{less} 1 < 2 \end{theorem}", ["lemma less : 1 < 2"]),
        (r"\begin{theorem}{disabled rule less}[X] 1 < 2 \end{theorem}", ["lemma less[X] : 1 < 2"]),
        (r"\begin{theorem}{less} \vdash? 1 < 2 \end{theorem}", ["lemma less : 1 < 2"]),
        (r"\begin{zed} A == 1 \end{zed} \begin{theorem} It is so. \end{theorem}", ["A == 1"]),
        (r"\begin{gendef}[X, Y] f, g : X \rel Y \end{gendef}", ["const [X, Y] f, g : X <-> Y"]),
        (r"\begin{axdef} \where 1 < 2 \end{axdef}", ["const\nwhere\n  1 < 2\nend"]),
        (r"\begin{zed} T == [| 1 < 2] \end{zed}", ["T == [ | 1 < 2]"]),
        (r"\begin{zed} P == \finset [x : \nat; y : \nat] \end{zed}", ["P == finset [x : nat; y : nat]"]),
        (r"\begin{zed} E == A[\nat][b/a, c/d] \end{zed}", ["E == A[nat][b/a, c/d]"]),
        (r"\begin{zed} E == (A \classuni B)\copyright \end{zed}", ["E == (A union B)%own"]),
    ],
)
def test_a_paragraph_is_read(text: str, paragraphs: list[str]) -> None:
    assert read(text) == paragraphs


@pytest.mark.parametrize(
    "text",
    [
        r"\begin{gendef}[X] f : X \rel X \where f = f \end{gendef}",
        r"\begin{class}{C} \begin{gendef}[X] f : X \rel X \end{gendef} \end{class}",
        r"\begin{class}{C} Op \sdef [c!!! : \nat; b'! : \nat; b?! : \nat] \hide (b'!~, b?!) \end{class}",
        r"\begin{class}{C} Op \sdef [| true] \land [x' : \nat] \end{class}",
        r"\begin{class}{C} A[\nat][b/a, Q/P][a/b] \\ \begin{state} d : D\copyright \end{state} \end{class}",
        r"\begin{class}{C} \begin{state} d : (D[\nat][b/a])[c/b] \where d.self \in \oid \end{state} \end{class}",
        NEAR,
    ],
)
def test_it_is_the_same_in_both_notations(text: str) -> None:
    script = parse(Source("paragraphs.tex", text))
    for name, written in (("again.csp", print_script(script)), ("again.tex", write_latex(script))):
        assert parse(Source(name, written)).declarations == script.declarations


def test_a_name_with_strokes_is_the_last_of_them_and_the_name_before() -> None:
    (tree,) = parse(Source("c.tex", r"\begin{class}{C} Op \sdef [c!!! : \nat | c!!! = 1] \end{class}")).declarations
    assert isinstance(tree, z.Class)
    (operation,) = tree.operations
    assert isinstance(operation, z.OperationSchema)
    (declaration,) = operation.declarations
    assert [(n.name, n.decoration) for n in declaration.names] == [("c!!", "!")]


def test_what_a_later_renaming_undoes_is_gone() -> None:
    (tree,) = parse(Source("c.tex", r"\begin{class}{C} A[b/a, d/c][a/b, e/d, g/f] \end{class}")).declarations
    assert isinstance(tree, z.Class)
    assert [(new.name, old.name) for new, old in tree.inherits[0].renamings] == [("e", "c"), ("g", "f")]


@pytest.mark.parametrize(("name", "outcome"), [("conjecture_2", Impossible), ("never", Found), ("lengths", Impossible)])
def test_conjectures_are_proved_or_refuted(name: str, outcome: type) -> None:
    text = r"""
    \begin{zed} \vdash? \forall n : \nat @ n + 1 > n \end{zed}
    \begin{theorem}{never} \forall n : \nat @ n > 3 \end{theorem}
    \begin{theorem}{lengths}[X] \forall s, t : \seq X @ \# (s \cat t) = \# s + \# t \end{theorem}
    \begin{class}{C} \begin{state} n : \nat \end{state} \end{class}
    """
    asked = prover(print_script(parse(Source("paragraphs.tex", text))))
    claim = asked.claim(name)
    assert claim is not None
    # What contradicts the claim is not there, or is found.
    assert isinstance(asked.lemma(claim), outcome)


def test_a_name_that_is_a_word_of_the_text_notation_is_another_there() -> None:
    text = r"\begin{class}{C} \begin{op}{end} where : \nat \end{op} Op \sdef end \hide (where) \end{class}"
    script = parse(Source("paragraphs.tex", text))
    (tree,) = script.declarations
    assert isinstance(tree, z.Class)
    assert [operation.name for operation in tree.operations] == ["end_", "Op"]
    assert parse(Source("again.csp", print_script(script))).declarations == script.declarations
    assert parse(Source("again.tex", write_latex(script))).declarations == script.declarations


@pytest.mark.parametrize(
    "text",
    [
        "given G\n\nconst\nwhere\n  1 < 2\nend\n\nA == finset [x, y : nat]\n",
        "class C\n  op q = [x : nat] \\ (x, x)\nend\n",
    ],
)
def test_what_random_documents_found(text: str) -> None:
    script = parse(Source("found.csp", text))
    assert parse(Source("found.tex", write_latex(script))).declarations == script.declarations
    assert parse(Source("again.csp", print_script(script))).declarations == script.declarations
    assert elaborate(script)


def test_a_polymorphic_set_of_classes_that_inherit_in_a_circle_is_refused() -> None:
    text = "class A\n  inherit B\nend\nclass B\n  inherit A\nend\nclass C\n  state a : poly A\nend\n"
    with pytest.raises(ScriptError) as error:
        elaborate(parse(Source("circle.csp", text)))
    assert "CSP655" in {d.code for d in error.value.diagnostics}
