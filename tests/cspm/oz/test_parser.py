"""Classes and other paragraphs in text notation, and the trees that they stand for."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading import messages as classes_syntax  # noqa: F401 -- registers its mistakes
from cspcheck.cspm.parsing.reading import parse, parse_assertion
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from tests.examples import examples

NOWHERE = Source("nowhere", "").span(0, 0)


def make(form, /, **parts):
    return form(span=NOWHERE, **parts)


def ref(name, decoration=""):
    return make(z.Reference, name=name, decoration=decoration)


def num(value):
    return make(z.Number, value=value)


def op(name, *operands):
    return make(z.Operator, name=name, operands=operands)


def chain(*parts):
    return make(z.Chain, relations=parts[1::2], operands=parts[::2])


def declared(text):
    name = text.rstrip("'?!")
    return make(z.Declared, name=name, decoration=text[len(name) :])


def declare(names, carrier):
    return make(z.Declare, names=tuple(map(declared, names.split())), carrier=carrier)


def declaration(text):
    (found,) = parse(Source("x.csp", text)).declarations
    return found


def predicates(text):
    """The predicates in a ``where``."""
    return declaration(f"schema S\n  x : T\nwhere\n{text}\nend").predicates


def expression(text):
    found = parse(Source("x.csp", f"given T\nX == {text}")).declarations[-1]
    return found.body


a, b, c, f, s_, t = map(ref, "abcfst")

EXPRESSIONS = {
    "a + b * c": op("plus", a, op("times", b, c)),
    "a - b - c": op("minus", op("minus", a, b), c),
    "a ∪ b ∩ c": op("union", a, op("inter", b, c)),
    "-a + b": op("plus", op("negate", a), b),
    "#s ^ t": op("concat", op("size", s_), t),
    "0 <= a < 10": chain(num(0), "at_most", a, "less", num(10)),
    "a = b and b = c or a /= c": op(
        "or", op("and", chain(a, "equal", b), chain(b, "equal", c)), chain(a, "not_equal", c)
    ),
    "¬ a ∈ b": op("not", chain(a, "in", b)),
    "a => b => c": op("implies", a, op("implies", b, c)),
    "a <=> b <=> c": op("iff", op("iff", a, b), c),
    "a cross b × c": op("cross", a, b, c),
    "a -> b -> c": op("fun", a, op("fun", b, c)),
    "a --> b": op("fun", a, b),
    "seq a >-|-> b": op("pinj", op("seq", a), b),
    "a <| b |> c": op("ran_restrict", op("dom_restrict", a, b), c),
    "f(a)": make(z.Application, function=f, argument=a),
    "f(a, b)": make(z.Application, function=f, argument=make(z.Display, kind="tuple", items=(a, b))),
    "f a": make(z.Application, function=f, argument=a, bracketed=False),
    "f a b": make(
        z.Application,
        function=make(z.Application, function=f, argument=a, bracketed=False),
        argument=b,
        bracketed=False,
    ),
    "dom f(a)": op("dom", make(z.Application, function=f, argument=a)),
    "f~ (| a |)": op("image", op("inverse", f), a),
    "f⦇a⦈": op("image", f, a),
    "a.b.c'": make(z.Selection, record=make(z.Selection, record=a, field="b"), field="c", decoration="'"),
    "a'.b": make(z.Selection, record=ref("a", "'"), field="b"),
    "<a, b> ^ ⟨⟩": op(
        "concat", make(z.Display, kind="sequence", items=(a, b)), make(z.Display, kind="sequence", items=())
    ),
    "<<a>, <b>>": make(
        z.Display,
        kind="sequence",
        items=(make(z.Display, kind="sequence", items=(a,)), make(z.Display, kind="sequence", items=(b,))),
    ),
    "[[a, a]]": make(z.Display, kind="bag", items=(a, a)),
    "{}": make(z.Display, kind="set", items=()),
    "∅": make(z.Display, kind="set", items=()),
    "{-1, 0}": make(z.Display, kind="set", items=(op("negate", num(1)), num(0))),
    "{a : s | a > 0 @ a + 1}": make(
        z.Binding,
        kind="set",
        declarations=(declare("a", s_),),
        condition=chain(a, "greater", num(0)),
        body=op("plus", a, num(1)),
    ),
    "(mu a : s; b : t | a = b • a)": make(
        z.Grouped,
        inner=make(
            z.Binding,
            kind="mu",
            declarations=(declare("a", s_), declare("b", t)),
            condition=chain(a, "equal", b),
            body=a,
        ),
    ),
    "λ a, b : s @ a": make(z.Binding, kind="lambda", declarations=(declare("a b", s_),), body=a),
    "forall a : s | a = 1 @ a = 2 or b": make(
        z.Quantified,
        kind="forall",
        declarations=(declare("a", s_),),
        condition=chain(a, "equal", num(1)),
        body=op("or", chain(a, "equal", num(2)), b),
    ),
    "∃₁ a : s • a = 2": make(
        z.Quantified,
        kind="exists1",
        declarations=(declare("a", s_),),
        condition=None,
        body=chain(a, "equal", num(2)),
    ),
    "if a then b else c + 1": make(z.Conditional, test=a, then=b, otherwise=op("plus", c, num(1))),
    "let a == 1; b == a @ b": make(
        z.Local,
        definitions=(
            (make(s.NameDeclaration, name="a"), num(1)),
            (make(s.NameDeclaration, name="b"), a),
        ),
        body=b,
    ),
    "(| a == 1, b == c |)": make(
        z.BindingDisplay,
        fields=((make(s.NameDeclaration, name="a"), num(1)), (make(s.NameDeclaration, name="b"), c)),
    ),
    "0..3": op("range", num(0), num(3)),
    "10.0": num(Fraction(10)),
    "0.25": num(Fraction(1, 4)),
    "ℕ": ref("nat"),
    "num": ref("int"),
    "ℙ₁ ℝ": op("power1", ref("real")),
    "a?": ref("a", "?"),
    "a! = b": chain(ref("a", "!"), "equal", b),
    "a!=b": chain(a, "not_equal", b),
    "a < b": chain(a, "less", b),
    "f[a, b]": make(z.Reference, name="f", arguments=(a, b)),
    "id": ref("id"),
    "id = a": chain(ref("id"), "equal", a),
    "id a": op("id", a),
    "disjoint <a, b>": op("disjoint", make(z.Display, kind="sequence", items=(a, b))),
    "a inrel f b": chain(a, "inrel f", b),
    "a < b inrel f' <c> = b": chain(a, "less", b, "inrel f'", make(z.Display, kind="sequence", items=(c,)), "equal", b),
    "f^+": op("closure", f),
    "f(+){a |-> b}": op("override", f, make(z.Display, kind="set", items=(op("maplet", a, b),))),
    "a \\ b": op("diff", a, b),
    "true": make(z.Truth, value=True),
}


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_an_expression(text):
    assert expression(text) == EXPRESSIONS[text]


class TestLines:
    """Each line of a predicate is a conjunct."""

    def test_lines_are_separate(self):
        assert predicates("a = 1\nb = 2") == (chain(a, "equal", num(1)), chain(b, "equal", num(2)))

    def test_a_line_goes_on_behind_an_operator_and_before_one(self):
        expected = (op("and", chain(a, "equal", num(1)), chain(b, "equal", num(2))), c)
        assert predicates("a = 1 and\n b = 2\nc") == predicates("a =\n 1\n  ∧ b = 2\nc") == expected

    @pytest.mark.parametrize("begin", ["-a = b", "<a> = b", "(a) = b", "{a} = b", "#a = b", "¬ b", "not b"])
    def test_what_begins_a_line_of_its_own(self, begin):
        assert len(predicates(f"c\n{begin}")) == 2

    def test_brackets_go_over_lines(self):
        assert len(predicates("(a\n  and b\n)\nf(a,\n b) = c")) == 2

    def test_a_relation_that_is_a_name_ends_no_line(self):
        assert predicates("a inrel f\n  b\nc") == (chain(a, "inrel f", b), c)

    def test_a_binder_in_the_declaration_of_another(self):
        text = "mu a : lambda b : c @ 0;\n  b : false"
        assert [d.names[0].name for d in expression(text).declarations] == ["a", "b"]

    def test_an_inclusion_may_begin_a_line_in_brackets(self):
        apart, together = (
            expression("[x : T;\n  Delta S\n  y : T | x = y]"),
            expression("[x : T; Delta S; y : T | x = y]"),
        )
        assert apart == together
        assert mistakes("class C\n  op m = [x : T | (x\n  state\n    n : nat\n  Delta\n    k : nat\nend") == ["CSP603"]

    def test_lines_between_then_and_else_are_conjuncts(self):
        (found,) = predicates("if a then\n  b = 1\n  c = 2\nelse b = 2")
        assert found.then == op("and", chain(b, "equal", num(1)), chain(c, "equal", num(2)))

    def test_semicolons_separate_too(self):
        assert len(predicates("a = 1; b = 2")) == 2


STACK = """class Stack[T]
  visible push, pop
  inherit Periodic, Base[nat][new/old, this/that]
  chan push, shove : [item? : T]
  chan pop : [a : S; item! : T]
  method m
  local_chan l
  main = push -> main [] pop -> main
  P(x) = SKIP
  const size : nat where size = 10
  STATUS ::= normal | leaf<<nat>>
  state
    items : seq T
  Delta
    n : nat
  where
    #items <= size
    n = #items
  init
    items = <>
  op push
    Delta(items)
    item? : T
  where
    #items < size
    items' = <item?> ^ items
  op m where n > 0
  op l
  op Both = push ; pop [] m
end
"""


class TestClasses:
    def test_a_class(self):
        found = declaration(STACK)
        name = lambda text: make(s.NameDeclaration, name=text)  # noqa: E731
        assert found.name == "Stack"
        assert found.generics == (name("T"),)
        assert found.visibility == (name("push"), name("pop"))
        assert found.inherits == (
            make(z.Inherit, name="Periodic"),
            make(
                z.Inherit,
                name="Base",
                arguments=(ref("nat"),),
                renamings=((name("new"), name("old")), (name("this"), name("that"))),
            ),
        )
        assert [(i.kind, [n.name for n in i.names], i.parameters) for i in found.interface] == [
            ("chan", ["push", "shove"], (declare("item?", ref("T")),)),
            ("chan", ["pop"], (declare("a", ref("S")), declare("item!", ref("T")))),
            ("method", ["m"], ()),
            ("local_chan", ["l"], ()),
        ]
        plain = parse(Source("x", "main = push -> main [] pop -> main\nP(x) = SKIP"))
        assert found.equations == plain.declarations
        constant, free = found.paragraphs
        assert constant == make(
            z.Axiom, declarations=(declare("size", ref("nat")),), predicates=(chain(ref("size"), "equal", num(10)),)
        )
        assert free == make(
            z.FreeType,
            name="STATUS",
            branches=(make(z.Branch, name="normal"), make(z.Branch, name="leaf", argument=ref("nat"))),
        )
        assert found.state == make(
            z.State,
            primary=(declare("items", op("seq", ref("T"))),),
            secondary=(declare("n", ref("nat")),),
            predicates=(
                chain(op("size", ref("items")), "at_most", ref("size")),
                chain(ref("n"), "equal", op("size", ref("items"))),
            ),
        )
        assert len(found.initial.predicates) == 1
        push, m, last, both = found.operations
        assert push.delta == (name("items"),)
        assert push.declarations == (declare("item?", ref("T")),)
        assert len(push.predicates) == 2
        assert (m.delta, m.declarations, len(m.predicates)) == (None, (), 1)
        assert last == make(z.OperationSchema, name="l", delta=None)
        assert both.body == op("choice", op("compose", ref("push"), ref("pop")), ref("m"))

    def test_spans_are_places_in_the_script(self):
        text = "N = 3\n" + STACK
        found = parse(Source("x.csp", text)).declarations[-1]
        assert found.span.text == STACK.strip()
        assert found.equations[0].span.text == "main = push -> main [] pop -> main"
        assert found.operations[0].predicates[1].span.text == "items' = <item?> ^ items"

    def test_signs_of_both_notations(self):
        text = STACK.replace("Delta", "Δ").replace("->", "→").replace("[] pop", "□ pop").replace("<>", "⟨⟩")
        assert declaration(text) == declaration(STACK)

    def test_an_operation_in_one_line(self):
        text = "class C\n  op x = [ Delta(n); i? : T | n' = i?; i? > 0 ]\nend"
        block = "class C\n  op x\n    Delta(n)\n    i? : T\n  where\n    n' = i?\n    i? > 0\nend"
        assert declaration(text) == declaration(block)

    def test_sections_may_have_an_end_of_their_own(self):
        closed = STACK.replace("size = 10", "size = 10 end").replace("items = <>", "items = <>\n  end")
        assert declaration(closed) == declaration(STACK)

    def test_schemas_and_constants_inside(self):
        text = "class C\n  schema R\n    x : nat\n  init\n    x = 0\n  end\n  given A, B\n  state r : R\nend"
        found = declaration(text)
        assert [type(p) for p in found.paragraphs] == [z.Schema, z.GivenTypes]
        assert found.paragraphs[0].initial == (chain(ref("x"), "equal", num(0)),)
        assert found.state.primary == (declare("r", ref("R")),)

    def test_comments_are_those_of_the_script(self):
        script = parse(Source("x.csp", "class C -- one\n  {- two -}\n  chan a\nend -- three"))
        assert [comment.text for comment in script.comments] == ["-- one", "{- two -}", "-- three"]


class TestParagraphs:
    def test_types_and_constants(self):
        text = """given MESSAGE, GID
STATUS ::= normal
  | alert
DATA == {x : nat | 0 <= x <= 10}
SPEED ::= {x : ℝ | -1 ≤ x ≤ 1}
Pair[X, Y] == X cross Y
const LIMIT, OTHER : real where
  0 <= LIMIT
  LIMIT < OTHER
end
const
  N : nat
  M : nat
reading real = {-1, 0, 1}
reading seq MESSAGE = 3
view control
retrieve R between A and B where A.n = B.n end
P = STOP"""
        found = parse(Source("x.csp", text)).declarations
        kinds = "GivenTypes FreeType Abbreviation Abbreviation Abbreviation Axiom Axiom Reading Reading View Retrieve"
        assert [type(d).__name__ for d in found] == [*kinds.split(), "PatternDefinition"]
        assert len(found[5].predicates) == 2
        assert found[6].declarations == (declare("N", ref("nat")), declare("M", ref("nat")))
        assert found[8].subject == op("seq", ref("MESSAGE"))
        assert (found[10].abstract.name, found[10].concrete.name) == ("A", "B")

    def test_what_ordinary_scripts_may_contain(self):
        text = (
            "class = 1\ngiven(x) = x\nschema = {class}\nconst, view :: Int\nconst = 2\nview = 3\nreading(x) = x\n"
            "channel state, init, op, end, where, chan : {0..1}\nretrieve = end.0 -> STOP\n"
            "f(x) = if x\n == 2 then 1 else class\nx =\n  2\n  == 1\n"
            "y = let class = 2 within class\nassert not\n  x == y\n"
        )
        script = parse(Source("x.csp", text))
        assert not any(isinstance(d, s.Paragraph) for d in script.declarations)
        assert len(script.declarations) == 13


CLAIMS = {
    "C :[obligations]": (None, None),
    "C :[invariant preserved]": ("invariant preserved", None),
    "C :[precondition]: push": ("precondition", "push"),
}


class TestAssertions:
    @pytest.mark.parametrize("text", CLAIMS)
    def test_obligations(self, text):
        words, operation = CLAIMS[text]
        found = parse_assertion(text)
        assert found == make(
            z.Obligations,
            subject=make(s.NameDeclaration, name="C"),
            obligation=words,
            operation=operation and make(s.NameDeclaration, name=operation),
        )

    def test_refinements(self):
        name = lambda text: make(s.NameDeclaration, name=text)  # noqa: E731
        both = {"abstract": name("A"), "concrete": name("C"), "retrieve": name("R")}
        assert parse_assertion("A [OZ= C via R") == make(z.DataRefinement, **both)
        assert parse_assertion("A [OZ= C via R :[downward]") == make(z.DataRefinement, **both)
        assert parse_assertion("A [OZ= C via R :[upward]") == make(z.DataRefinement, **both, upward=True)
        assert parse_assertion("not A [OZ= C") == make(
            s.NotAssertion, inner=make(z.Subtype, parent=name("A"), child=name("C"))
        )

    def test_composition_associates_and_needs_brackets_beside_other_parallels(self):
        script = parse(Source("x.csp", "class A\nend\nS = A || A || A"))
        name = make(s.Name, parts=("A",))
        both = make(s.ClassParallel, left=make(s.ClassParallel, left=name, right=name), right=name)
        assert script.declarations[-1].body == both
        with pytest.raises(ScriptError, match="CSP105"):
            parse(Source("x.csp", "class A\nend\nS = A || A [| {} |] A"))

    def test_a_misspelt_property_is_one(self):
        with pytest.raises(ScriptError, match="CSP120"):
            parse(Source("x.csp", "class A\nend\nassert A :[deadlok free]"))


CODES = sorted(code for code in MISTAKES if "CSP601" <= code <= "CSP615")


def mistakes(text):
    try:
        parse(Source("x.csp", text))
    except ScriptError as error:
        return [d.code for d in error.diagnostics]
    return []


class TestMistakes:
    @pytest.mark.parametrize("code", CODES)
    def test_the_example_makes_the_mistake_and_the_repair_does_not(self, code):
        assert mistakes(MISTAKES[code].example) == [code]
        assert mistakes(MISTAKES[code].repair) == []

    def test_several_are_reported(self):
        text = (
            "given A,,\nclass C\n  chann a\n  state\n    x nat\n    y : nat\n  where\n    x = \n    (y = 1\n  op m\n"
            "    Delta n\n  op k\n    Delta(n)\n  where\n    n' = = 2\n    n' = )\nend\nP = a ->\nQ = STOP"
        )
        assert mistakes(text)[:2] == ["CSP601", "CSP608"]
        assert len(mistakes(text)) == 8

    @pytest.mark.parametrize(("rest", "sign"), [("- 1", "`-`"), ("< 3", "`<`")])
    def test_a_sign_that_begins_a_line(self, rest, sign):
        with pytest.raises(ScriptError) as caught:
            parse(Source("x.csp", f"schema S\n  n : nat\nwhere\n  n = n\n    {rest}\nend"))
        (diagnostic,) = caught.value.diagnostics
        assert sign in diagnostic.message
        assert "at the end of the line before" in diagnostic.help

    def test_mistakes_in_equations_are_those_of_csp(self):
        assert mistakes("class C\n  chan a\n  main = a -> ->\nend") == ["CSP110"]

    def test_a_nesting_of_many_thousands(self):
        deep = 20_000
        text = "given T\nX == " + "(" * deep + "1" + ")" * deep
        assert isinstance(parse(Source("x.csp", text)).declarations[-1], z.Abbreviation)
        assert mistakes("given T\nX == " + "not " * deep) == ["CSP601"]
        assert mistakes("given T\nX == " + "{x : {" * deep) == ["CSP603"]


PIECES = st.sampled_from(
    [
        *("class C", "end", "where", "state", "init", "INIT", "Delta(n)", "Delta", "chan a", "method", "main ="),
        *("a -> main", "n : nat", "x?", "y!", "n'", "= 1", "<", ">", "(", ")", "{", "}", "@", "(|", "|)", "[", "]"),
        *("forall", "if", "then", "else", "let", "==", "::=", "\n", "\n", "given A", "schema S", "const k : nat"),
        *("retrieve R", "between", "reading", "view", "{-", "-}", "--", '"', "'a'", "∀", "•", ";", ",", ".", "^", "#s"),
        *("assert C :[obligations]", "assert A [OZ= B via R", "P || Q", "datatype T = A", ">>", "-->", "[[", "]]"),
    ]
)


@settings(max_examples=examples(200), deadline=None)
@given(st.lists(PIECES, max_size=40))
def test_any_text_gives_a_tree_or_diagnostics(pieces):
    text = " ".join(pieces)
    for source in (text, "class C\n" + text + "\nend"):
        try:
            parse(Source("x.csp", source))
        except ScriptError as error:
            for diagnostic in error.diagnostics:
                assert diagnostic.span is None or 0 <= diagnostic.span.start <= diagnostic.span.end <= len(source)


def test_a_quantifier_may_be_written_with_in():
    assert expression("forall a in s @ b") == expression("∀ a : s • b")
    text = "given T\nX == ∀ a ∈ s • b\n"
    assert format_source(Source("x.csp", text)) == text


class TestScriptsWithoutClasses:
    """What only classes give a meaning is refused where there are none, also where an include might bring some."""

    @pytest.mark.parametrize(
        ("text", "code"),
        [
            ("P = STOP || STOP", "CSP101"),
            ("P == STOP", "CSP108"),
            ("assert STOP :[terminating]", "CSP120"),
            ('include "rest.csp"\nP = STOP || STOP', "CSP617"),
            ('include "rest.csp"\nP == STOP', "CSP108"),
            ("given ITEM\nP = STOP || STOP", "CSP617"),
        ],
    )
    def test_in_a_script(self, text, code, tmp_path):
        (tmp_path / "rest.csp").write_text("channel c")
        with pytest.raises(ScriptError) as caught:
            load(Source(str(tmp_path / "x.csp"), text))
        assert [d.code for d in caught.value.diagnostics] == [code]

    def test_in_an_assertion_against_it(self):
        with pytest.raises(ScriptError, match="CSP617"):
            load(Source("x.csp", "P = STOP")).assertion("P || P :[deadlock free]")
