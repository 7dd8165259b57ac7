"""From trees to LaTeX and back, and the dialects that are read."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.writing.latex_writer import Writer, write_latex
from cspcheck.cspm.oz.writing.printer import print_paragraph
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Source
from tests.cspm.oz.strategies_oz import make, paragraphs, plain, terms
from tests.examples import examples


def read(text):
    """The declarations of a document, which has nothing odd about it."""
    script = parse(Source("x.tex", text))
    assert script.remarks == ()
    return script.declarations


@settings(max_examples=examples(200), deadline=None)
@given(terms(3))
def test_terms_come_back(term):
    box = make(z.Schema, name="S", declarations=(), predicates=(term,))
    (found,) = read(Writer().paragraph(box))
    assert plain(found) == plain(box)


def with_records(paragraph):
    """The paragraph without the schemas of a class that are set like operations: with decorations, or of a channel."""
    if not isinstance(paragraph, z.Class):
        return paragraph
    channels = {name.name for interface in paragraph.interface for name in interface.names}
    kept = [
        local
        for local in paragraph.paragraphs
        if not isinstance(local, z.Schema)
        or not (local.name in channels or set("'?!") & set(Writer().paragraph(local)))
    ]
    return replace(paragraph, paragraphs=tuple(kept))


@settings(max_examples=examples(150), deadline=None)
@given(paragraphs(terms(1)).map(with_records))
def test_paragraphs_come_back(paragraph):
    text = Writer().paragraph(paragraph)
    (found,) = read(text)
    assert plain(found) == plain(paragraph)
    assert read(Writer().paragraph(found)) == (found,)


@pytest.mark.parametrize("included", ["Delta S", "Xi S", "S"])
def test_a_schema_of_a_class_that_includes_another_comes_back(included):
    text = f"class C\n  schema T\n    {included}\n    y : nat\n  end\n  state\n    x : nat\nend\n"
    script = parse(Source("x.csp", text))
    assert read(write_latex(script)) == script.declarations


def test_a_binder_before_a_relation_with_a_name_is_in_brackets():
    text = "schema S\n  x : nat\nwhere\n  ((lambda y : x @ y) inrel f x).a\n  (lambda y : x @ y) inrel f x\nend\n"
    script = parse(Source("x.csp", text))
    assert read(write_latex(script)) == script.declarations
    assert parse(Source("x.csp", print_paragraph(script.declarations[0]))).declarations == script.declarations


def test_a_whole_script_comes_back():
    text = (
        "given G\nN = 3\nchannel c : {0..N}\nclass C[T]\n  chan a_b : [x? : T]\n  local_chan z\n"
        "  main = a_b?x!1 -> (if x == 1 then SKIP else P(x)) \\ {| z |} [[ z <- z ]]\n"
        "  P(n) = let y = 1\n             q(k) = k within <1, y> ^ <> == <2> & STOP [| {z} |] SKIP\n"
        "  Q = [] i : {0..3} @ z -> STOP |~| STOP ||| CHAOS({z})\n  op q = (a ; b) \\ (x) [] d\nend\n"
        "reading G = 2\nview control\nP = C || C\nassert C :[obligations]\n"
    )
    script = parse(Source("x.csp", text))
    document = write_latex(script)
    assert read(document) == script.declarations
    assert write_latex(parse(Source("x.tex", document))) == document


@pytest.mark.parametrize("text", ["(" * 3000 + "1" + ")" * 3000, "not " * 3000 + "p", "{" * 3000 + "}" * 3000])
def test_deep_terms_come_back(text):
    script = parse(Source("x.csp", f"given T\nX == {text}\n"))
    with deep_recursion():
        assert read(write_latex(script)) == script.declarations
        assert parse(Source("x.csp", print_script(script))) == script


def box(text):
    """What a class with this inside is, as text."""
    script = parse(Source("x.tex", f"\\begin{{class}}{{C}}\n{text}\n\\end{{class}}"))
    (found,) = script.declarations
    return print_paragraph(found), [remark.message for remark in script.remarks]


def same(markup, text, remarks=()):
    found, told = box(markup)
    assert found == print_paragraph(parse(Source("x.csp", f"class C\n{text}\nend")).declarations[0])
    assert told == list(remarks)


class TestDialects:
    """Forms that are in use, and what they stand for."""

    def test_interfaces_with_and_without_backslash(self):
        text = "chan a : [ id : G; t? : nat ]\nmethod m\nlocal_chan l"
        same(r"\chan a : [ id : G; t? : \nat ] \\ \method m \\ \localchan l", text)
        same(r"chan a : [ id : G; t? : \nat ] \\ method m \\ local\_chan l \\", text)
        same(r"\textbf{chan} a : [ id : G; t? : \nat ] \\ \mbox{\bf method} m \\ \mathsf{local\_chan}~l", text)

    def test_processes(self):
        text = "main = a -> (b -> main [] c -> Q)\nQ = SKIP |~| STOP"
        same(
            r"\main \sdef a \then (b \then main \\ \extchoice c \then Q) \\ Q \sdef \Skip \intchoice \Stop \\",
            text,
        )
        same(r"main = a \rightarrow (b \to main \Box c \then Q) \\ Q = \Skip \sqcap \Stop", text)

    def test_sets_of_events_and_parallels(self):
        text = "main = a -> STOP [| {| b |} |] (P ||| Q) \\ {c}"
        same(r"main = a \then \Stop \lpar | \lchanset b \rchanset | \rpar (P \interleave Q) \circhide \{c\}", text)

    def test_inheritance_and_visibility(self):
        text = "visible a, b\ninherit P\ninherit Q[nat][c/d]"
        same(r"\visibility (a, b) \\ P \\ Q[\nat][c/d] \\", text)
        same(r"\visibility (a, b) \\ \inherit P, Q[\nat][c/d] \\", text)
        same(
            r"\upharpoonright (a, b) \\ \inherit P [this is a periodic process] \\ Q[\num][c/d] \endinherit",
            text.replace("nat", "int"),
            ["`\\upharpoonright` is read as `\\visibility`"],
        )

    def test_boxes(self):
        text = "const k : nat where k = 1\nstate\n n : nat\nDelta\n m : nat\nwhere\n n = m\ninit\n n = 0"
        same(
            r"\begin{axdef} k : \nat [a constant] \where k = 1 \end{axdef} \begin{state} n : \nat \\ \Delta \\ "
            r"m : \nat \where n = m [redundant, of course] \end{state} \begin{init} n = 0 \end{init}",
            text,
        )
        same(
            r"\begin{const} k : \nat \ST k = 1 \end{const} \also \begin{anonschema} n : \nat \\ \Delta \\ m : \nat "
            r"\where n = m \end{anonschema} \classbreak \begin{schema}{INIT} n = 0 \end{schema}",
            text,
            ["`\\ST` is read as `\\where`"],
        )
        same(r"[ n : \nat | n = 1 ] \\ \Init \sdef [ n = 0 ] \\", "state\n n : nat\nwhere\n n = 1\ninit\n n = 0")

    def test_operations(self):
        text = "method m\nop com_a\n Delta(n)\n x? : nat\nwhere\n n' = x?\nop m where n = 0\nop s = com_a ; m"
        same(
            r"\method m \\ \begin{op}{com\_a} \Delta (n) \\ x? : \nat \where n' = x? \end{op} "
            r"\begin{op}{m} \where n = 0 \end{op} s \sdef com\_a \semi m \\",
            text,
        )
        same(
            r"\method m \\ \begin{schema}{com\_a} \Delta (n) \\ x? : \nat \where n' = x? \end{schema} "
            r"\begin{schema}{m} \where n = 0 \end{schema} s $\stackrel{\wedge}{=}$ com\_a \semi m \\",
            text,
            ["`\\stackrel{\\wedge}{=}` is read as `\\sdef`"],
        )
        same(r"com\_a \sdef [ \Delta (n) ; x? : \nat | n' = x? ] \\", "op com_a = [Delta(n); x? : nat | n' = x?]")

    def test_types(self):
        text = "given A, B\nT ::= p | q\nU == {x : nat | x < 3}"
        same(r"[A, B] \\ T ::= p | q \\ U == \{ x : \nat | x < 3 \} \\", text)
        same(r"\begin{zed} [A, B] \\ T ::= p \\ | q \end{zed} \begin{zed} U == \{ x : \nat | x < 3 \} \end{zed}", text)

    def test_expressions(self):
        def init(markup, text, *remarks):
            same(
                rf"\begin{{init}} {markup} \end{{init}}",
                f"init\n {text}",
                [f"`{a}` is read as `{b}`" for a, b in remarks],
            )

        init(r"f \in \nat_1 \pfun \power_1 A", "f in nat1 -|-> power1 A")
        init(
            r"\all x : \finset~A @ x \neq \varnothing",
            "forall x : finset A @ x != {}",
            (r"\all", r"\forall"),
            (r"\varnothing", r"\emptyset"),
        )
        init(r"\exists_1 x : A \spot x = y \land \lnot (y = z)", "exists1 x : A @ x = y and not (y = z)")
        init(r"a \to b \in f", "a |-> b in f", (r"\to", r"\mapsto"))
        init(
            r"dom~f = \mathbb{N} \times A",
            "dom f = nat cross A",
            ("dom", r"\dom"),
            (r"\mathbb{N}", r"\nat"),
            (r"\times", r"\cross"),
        )
        init(r"x^{\prime} = r^+ \comp s\inv", "x' = r^+ comp s~", (r"^{\prime}", "'"), ("^+", r"\plus"))
        init(r"\IF p \THEN a \ELSE \negate b.c", "if p then a else -b.c")
        init(r"s = \langle a, b \rangle \cat tail~t \filter \{1\upto 3\}", "s = <a, b> ^ tail t filter {1..3}")
        init(r"r \limg \{a\} \rimg = \mu x : A | p", "r(| {a} |) = mu x : A | p")
        init(r"x \inrel{near} y \land 1 \inrel{f'} 2", "x inrel near y and 1 inrel f' 2")
        init(r"c = \lblot x == 1, y == 2 \rblot", "c = (| x == 1, y == 2 |)")
        init(r"x\_y = readings_{i}", "x_y = readings_i", ("readings_{i}", r"readings\_i"))
        init(r"a \leq b \\ \t1 \land c \\ d > 1.50", "a <= b and c\n d > 1.5")
        init(r"A \ooalign{$\lhd$\cr$-$} f = g", "A </| f = g", (r"\ooalign", r"\ndres"))

    def test_a_projection_is_no_visibility_list(self):
        (found,) = parse(Source("x.tex", r"\begin{zed} S \sdef T \project U \end{zed}")).declarations
        assert print_paragraph(found) == "S == T filter U"

    def test_a_hard_space_before_a_decoration(self):
        (found,) = parse(Source("x.tex", r"\begin{schema}{T} S~' \where \Label{r} x~' = x \end{schema}")).declarations
        assert print_paragraph(found) == "schema T\n  S'\nwhere\n  x' = x\nend"

    def test_arrows_of_plain_latex(self):
        same(
            r"\begin{state} f : A \rightarrow B \leftrightarrow C \end{state} main = a \rightarrow main",
            "state\n f : A -> B <-> C\nmain = a -> main",
            [r"`\rightarrow` is read as `\fun`", r"`\leftrightarrow` is read as `\rel`"],
        )

    def test_a_xi_list_is_read_over(self):
        found, told = box(r"\begin{op}{m} \Xi (n) \\ v! : \nat \where v! = n \end{op}")
        assert found == "class C\n  op m\n    v! : nat\n  where\n    v! = n\nend"
        assert told == ["there is no `\\Xi` on operations"]

    def test_text_around_is_ignored(self):
        text = (
            "\\documentclass{article} \\begin{document} A \\begin{itemize} \\item a $x$ \\end{itemize}\n"
            "% \\begin{class}{Old} \\end{class}\n\\begin{verbatim}\n\\begin{class}{No}\n\\end{verbatim}\n"
            "\\begin{class}{A} \\chan a \\end{class} and \\begin{class}{B} \\begin{classcom} nothing [ \\end{classcom} "
            "\\chan b \\end{class} \\begin{axdef} n : \\nat \\end{axdef}"
        )
        found = parse(Source("x.tex", text)).declarations
        assert [type(d).__name__ for d in found] == ["Class", "Class", "Axiom"]
        assert [d.name for d in found[:2]] == ["A", "B"]

    def test_spans_are_places_in_the_document(self):
        text = r"\begin{class}{A} main = a \then main \\ \begin{init} n' = 0 \end{init} \end{class}"
        (found,) = parse(Source("x.tex", text)).declarations
        assert found.equations[0].span.text == r"main = a \then main"
        assert found.initial.predicates[0].span.text == "n' = 0"


def refused(markup):
    with pytest.raises(ScriptError) as caught:
        parse(Source("x.tex", markup))
    return [(d.code, d.span.text, d.help) for d in caught.value.diagnostics]


class TestMistakes:
    def test_a_misspelt_command(self):
        assert refused(r"\begin{class}{C} \begin{init} n \lec 3 \end{init} \end{class}")[0] == (
            "CSP622",
            r"\lec",
            r"did you mean `\leq` or `\le`?",
        )

    def test_a_misspelt_environment(self):
        found = refused(r"\begin{class}{C} \begin{stat} n : \nat \end{stat} \end{class}")
        assert found[0] == ("CSP624", r"\begin{stat}", "did you mean `state`?")

    def test_an_environment_that_is_not_closed(self):
        found = refused(r"\begin{class}{C} \begin{state} n : \nat \end{class}")
        assert found == [("CSP623", r"\begin{state}", r"add `\end{state}`")]

    def test_what_is_not_read(self):
        found = refused(r"\begin{class}{C} \begin{state} s : \dplo \end{state} \end{class}")
        assert found[0][:2] == ("CSP625", r"\dplo")

    @pytest.mark.parametrize(
        "line",
        [r"\relation (near \_)", r"\function 40 \leftassoc (\_ \otimes \_)"],
    )
    def test_a_line_that_is_not_read_is_told_once(self, line):
        found = refused(rf"\begin{{zed}} {line} \\ S \sdef [x : \nat] \end{{zed}}")
        assert [(code, text) for code, text, _ in found] == [("CSP625", line.split("?")[0].split(" ")[0])]

    def test_mistakes_in_equations_and_predicates(self):
        assert refused(r"\begin{class}{C} main = a \then \then b \end{class}")[0][:2] == ("CSP110", r"\then")
        found = refused(r"\begin{class}{C} \begin{init} (n = 1 \end{init} \end{class}")
        assert found[0][:2] == ("CSP603", "(")


PIECES = [
    *(r"\begin{class}{C}", r"\end{class}", r"\begin{state}", r"\end{state}", r"\begin{op}{x}", r"\end{op}", r"\where"),
    *(r"\begin{zed}", r"\end{zed}", r"\begin{cspm}", r"\end{cspm}", r"\begin{schema}{INIT}", r"\end{schema}"),
    *(r"\\", r"\Delta", "(n)", r"\chan", r"\main", r"\sdef", r"\then", r"\Skip", "n : ", r"\nat", "=", "1", "x?", "y!"),
    *("n'", "{", "}", "[", "]", r"\{", r"\}", r"\langle", r"\rangle", r"\limg", "|", "@", ";", ",", "~", "$", "%", "&"),
    *(
        r"\forall",
        r"\lpar",
        r"\rpar",
        "^",
        "^{-1}",
        "_",
        r"\_",
        r"\mathbb{N}",
        r"\Xi",
        r"\foo",
        '"',
        "[A]",
        "T ::=",
        "a",
    ),
    *(
        r"\begin{retrieve}{R}{A}{B}",
        r"\end{retrieve}",
        r"\text{a}",
        r"\mathit{b}",
        r"\IF",
        r"\ELSE",
        r"\stackrel",
        "\\",
    ),
]


@settings(max_examples=examples(150), deadline=None)
@given(st.lists(st.sampled_from(PIECES), max_size=25))
def test_any_document_gives_declarations_or_diagnostics(pieces):
    text = " ".join(pieces)
    for source in (text, f"\\begin{{class}}{{C}} {text} \\end{{class}}"):
        try:
            parse(Source("x.tex", source))
        except ScriptError as error:
            for diagnostic in error.diagnostics:
                assert diagnostic.span is None or 0 <= diagnostic.span.start <= diagnostic.span.end <= len(source)


@pytest.mark.parametrize("blank", ["\u00a0", "\u2028", "\u2029", "\u0085", "\x1c", "\x1f", "\u3000", "\x0b"])
def test_blanks_as_they_come_out_of_printed_documents(blank: str) -> None:
    plain = "\\begin{zed}\n[A]\\\\\nB == 1\n\\end{zed}\n"
    kinds = [declaration.__class__ for declaration in parse(Source("x.tex", plain)).declarations]
    other = plain.replace("B ==", f"B{blank}==").replace("== 1", f"=={blank}{blank}1")
    assert [declaration.__class__ for declaration in parse(Source("x.tex", other)).declarations] == kinds
