"""Each form of the concrete syntax and the tree that stands for it; and where each node lies."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

from cspcheck.cspm.parsing.reading import parse, parse_assertion, parse_expression, read_source
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as s
from tests.cspm.syntax.strategies_syntax import NOWHERE, scripts
from tests.examples import examples

CORPUS = sorted((Path(__file__).parents[2] / "corpus" / "parse" / "pass").glob("*.csp"))


def make(form: Any, *values: Any, **parts: Any) -> Any:
    """A node with its parts in the order of the class's definition."""
    names = [f.name for f in fields(form) if f.name != "span"]
    return form(span=NOWHERE, **dict(zip(names, values, strict=False)), **parts)


def n(text: str) -> s.Name:
    return make(s.Name, tuple(text.split("::")))


def i(value: int) -> s.LiteralExpr:
    return make(s.LiteralExpr, "int", value)


def p(text: str) -> s.Pattern:
    return make(s.Wildcard) if text == "_" else make(s.NamePattern, (text,))


def gen(pattern: str, source: str, colon: bool = False) -> s.Generator:
    return make(s.Generator, p(pattern), n(source), colon)


P, Q, A, B, a, b, c, x = (n(text) for text in ("P", "Q", "A", "B", "a", "b", "c", "x"))

EXPRESSIONS = {
    "x": x,
    "M::N::x": n("M::N::x"),
    "12": i(12),
    "true": make(s.LiteralExpr, "bool", True),
    "'a'": make(s.LiteralExpr, "char", "a"),
    "'\\n'": make(s.LiteralExpr, "char", "\n"),
    "'\\''": make(s.LiteralExpr, "char", "'"),
    "'\\\\'": make(s.LiteralExpr, "char", "\\"),
    '"ab"': make(s.LiteralExpr, "string", "ab"),
    '"a\\n\\t\\r"': make(s.LiteralExpr, "string", "a\n\t\r"),
    # An escape that is not known is a quote, as FDR has it.
    '"a\\"b\\qc"': make(s.LiteralExpr, "string", 'a"b"c'),
    '"a\\\\"': make(s.LiteralExpr, "string", "a\\"),
    "(x)": make(s.Paren, x),
    "(a, b, c)": make(s.TupleExpr, (a, b, c)),
    "{}": make(s.SetExpr, ()),
    "{a, b}": make(s.SetExpr, (a, b)),
    "{a, b | x <- A, c}": make(s.SetExpr, (a, b), (gen("x", "A"), make(s.Qualifier, c))),
    "{1..2}": make(s.SetRange, i(1), i(2)),
    "{1..}": make(s.SetRange, i(1), None),
    "{1..x | x : A}": make(s.SetRange, i(1), x, (gen("x", "A", True),)),
    "{x.. | x <- A}": make(s.SetRange, x, None, (gen("x", "A"),)),
    "{| |}": make(s.Productions, ()),
    "{| a, b |}": make(s.Productions, (a, b)),
    "{| a | x <- A |}": make(s.Productions, (a,), (gen("x", "A"),)),
    "<>": make(s.SequenceExpr, ()),
    "<a, b>": make(s.SequenceExpr, (a, b)),
    "<a | x <- A>": make(s.SequenceExpr, (a,), (gen("x", "A"),)),
    "<1..2>": make(s.SequenceRange, i(1), i(2)),
    "<1..>": make(s.SequenceRange, i(1), None),
    "<1..x | x <- A>": make(s.SequenceRange, i(1), x, (gen("x", "A"),)),
    "<x.. | x <- A>": make(s.SequenceRange, x, None, (gen("x", "A"),)),
    "(| |)": make(s.MapExpr, ()),
    "(| a => b, b => c |)": make(s.MapExpr, ((a, b), (b, c))),
    "a + b": make(s.Binary, "+", a, b),
    "a < b": make(s.Binary, "<", a, b),
    "a > b": make(s.Binary, ">", a, b),
    "-a": make(s.Unary, "-", a),
    "not a": make(s.Unary, "not", a),
    "#a": make(s.Unary, "#", a),
    "a.b.c": make(s.Dot, a, make(s.Dot, b, c)),
    "a()": make(s.Apply, a, ()),
    "a(b, c)": make(s.Apply, a, (b, c)),
    "a(b)(c)": make(s.Apply, make(s.Apply, a, (b,)), (c,)),
    "\\ x, _ @ a": make(s.Lambda, (p("x"), p("_")), a),
    "if a then b else c": make(s.If, a, b, c),
    "let x = a within b": make(s.Let, (make(s.PatternDefinition, p("x"), a),), b),
    "a -> P": make(s.Prefix, a, (), P),
    "a.b!c -> P": make(s.Prefix, make(s.Dot, a, b), (make(s.Field, "!", c),), P),
    "a?x -> P": make(s.Prefix, a, (make(s.Field, "?", pattern=p("x")),), P),
    "a?x.y -> P": make(s.Prefix, a, (make(s.Field, "?", pattern=make(s.DotPattern, p("x"), p("y"))),), P),
    "a?x:A$y:B!c -> P": make(
        s.Prefix,
        a,
        (
            make(s.Field, "?", pattern=p("x"), restriction=A),
            make(s.Field, "$", pattern=p("y"), restriction=B),
            make(s.Field, "!", c),
        ),
        P,
    ),
    "a & P": make(s.Guard, a, P),
    **{f"P {o} Q": make(s.ProcessBinary, o, P, Q) for o in (";", "[]", "|~|", "[>", "/\\", "|||")},
    "P [| A |] Q": make(s.Synchronised, "[|", P, A, Q),
    "P [+ A +] Q": make(s.Synchronised, "[+", P, A, Q),
    "P /+ A +\\ Q": make(s.Synchronised, "/+", P, A, Q),
    "P [| A |> Q": make(s.Synchronised, "[|>", P, A, Q),
    "P [ A || B ] Q": make(s.AlphabetisedParallel, P, A, B, Q),
    "P [ a <-> b ] Q": make(s.LinkedParallel, P, ((a, b),), Q),
    "P [ a <-> b, b <-> c | x <- A ] Q": make(s.LinkedParallel, P, ((a, b), (b, c)), Q, (gen("x", "A"),)),
    "P \\ A": make(s.Hide, P, A),
    "P |\\ A": make(s.Hide, P, A, True),
    "P[[a <- b]]": make(s.Rename, P, ((a, b),)),
    "P[[a <- b, b <- c | x : A]]": make(s.Rename, P, ((a, b), (b, c)), (gen("x", "A", True),)),
    **{f"{o} x : A @ P": make(s.Replicated, o, (gen("x", "A", True),), P) for o in ("[]", "|~|", "|||", ";")},
    "|| x : A @ [B] P": make(s.Replicated, "||", (gen("x", "A", True),), P, B),
    "[| B |] x : A @ P": make(s.Replicated, "[|", (gen("x", "A", True),), P, B),
    "[+ B +] x <- A, b @ P": make(s.Replicated, "[+", (gen("x", "A"), make(s.Qualifier, b)), P, B),
    "[ a <-> b ] x : A @ P": make(s.Replicated, "<->", (gen("x", "A", True),), P, links=((a, b),)),
    "[ a <-> b | x <- B ] x : A @ P": make(
        s.Replicated, "<->", (gen("x", "A", True),), P, links=((a, b),), link_statements=(gen("x", "B"),)
    ),
}


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expressions(text: str) -> None:
    assert parse_expression(text) == EXPRESSIONS[text]


PATTERNS: dict[str, Any] = {
    "x": p("x"),
    "M::x": make(s.NamePattern, ("M", "x")),
    "_": p("_"),
    "7": make(s.LiteralPattern, "int", 7),
    "-7": make(s.LiteralPattern, "int", -7),
    "true": make(s.LiteralPattern, "bool", True),
    "'c'": make(s.LiteralPattern, "char", "c"),
    '"s"': make(s.LiteralPattern, "string", "s"),
    "(x)": make(s.ParenPattern, p("x")),
    "(x, _)": make(s.TuplePattern, (p("x"), p("_"))),
    "<>": make(s.SequencePattern, ()),
    "<x, y>": make(s.SequencePattern, (p("x"), p("y"))),
    "<x>^xs": make(s.ConcatPattern, make(s.SequencePattern, (p("x"),)), p("xs")),
    "{}": make(s.SetPattern, ()),
    "{x}": make(s.SetPattern, (p("x"),)),
    "x.y.z": make(s.DotPattern, p("x"), make(s.DotPattern, p("y"), p("z"))),
    "x @@ y": make(s.BothPattern, p("x"), p("y")),
}


@pytest.mark.parametrize("text", PATTERNS)
def test_patterns(text: str) -> None:
    lambda_ = parse_expression(f"\\ {text} @ 0")
    assert isinstance(lambda_, s.Lambda)
    assert lambda_.parameters == (PATTERNS[text],)
    (definition,) = parse(Source("", f"f({text}) = 0")).declarations
    assert isinstance(definition, s.FunctionDefinition)
    assert definition.clauses[0].groups == ((PATTERNS[text],),)


def clause(groups: tuple[tuple[s.Pattern, ...], ...], body: s.Expr) -> Any:
    return make(s.Clause, groups, body)


def names(*texts: str) -> tuple[Any, ...]:
    return tuple(make(s.NameDeclaration, text) for text in texts)


def t(text: str) -> Any:
    return make(s.TypeName, (text,))


def scheme(body: Any, *constraints: tuple[str, str]) -> Any:
    return make(s.TypeScheme, tuple(make(s.TypeConstraint, *c) for c in constraints), body)


ONE = make(s.PatternDefinition, p("x"), i(1))
DECLARATIONS: dict[str, list[Any]] = {
    "x = 1": [ONE],
    "(x, y) = a": [make(s.PatternDefinition, make(s.TuplePattern, (p("x"), p("y"))), a)],
    "f() = a": [make(s.FunctionDefinition, "f", (clause(((),), a),))],
    "f(x, y)(_) = a": [make(s.FunctionDefinition, "f", (clause(((p("x"), p("y")), (p("_"),)), a),))],
    # Adjacent clauses of one function are one definition; others are not.
    "f(x) = a\nf(y) = b": [make(s.FunctionDefinition, "f", (clause(((p("x"),),), a), clause(((p("y"),),), b)))],
    "f(x) = a\nx = 1\nf(y) = b": [
        make(s.FunctionDefinition, "f", (clause(((p("x"),),), a),)),
        ONE,
        make(s.FunctionDefinition, "f", (clause(((p("y"),),), b),)),
    ],
    "channel a, b": [make(s.ChannelDeclaration, names("a", "b"))],
    "channel a : A.B": [make(s.ChannelDeclaration, names("a"), make(s.Dot, A, B))],
    "datatype T = C | D.A.B": [
        make(s.DatatypeDeclaration, "T", (make(s.Constructor, "C"), make(s.Constructor, "D", make(s.Dot, A, B))))
    ],
    "subtype T = C": [make(s.DatatypeDeclaration, "T", (make(s.Constructor, "C"),), True)],
    "nametype N = A": [make(s.NametypeDeclaration, "N", A)],
    "external f, g": [make(s.ImportDeclaration, "external", names("f", "g"))],
    "transparent f": [make(s.ImportDeclaration, "transparent", names("f"))],
    "print a": [make(s.PrintDeclaration, a)],
    "module M\nx = 1\nexports\nendmodule": [make(s.ModuleDeclaration, "M", (), (ONE,), ())],
    "module M(y, _)\nexports\nx = 1\nendmodule": [make(s.ModuleDeclaration, "M", (p("y"), p("_")), (), (ONE,))],
    "instance I = M(a, b)": [make(s.InstanceDeclaration, "I", n("M"), (a, b))],
    "instance I = M::N": [make(s.InstanceDeclaration, "I", n("M::N"), ())],
    "Timed { x = 1 }": [make(s.TimedDeclaration, None, (ONE,))],
    "Timed(a) {\nx = 1\n}": [make(s.TimedDeclaration, a, (ONE,))],
    "x :: Int\nx = 1": [make(s.AnnotationDeclaration, names("x"), scheme(t("Int"))), ONE],
    "assert a": [make(s.AssertDeclaration, make(s.BooleanAssertion, a))],
    'include "other"': [make(s.IncludeDeclaration, "other", (ONE,))],
}


@pytest.mark.parametrize("text", DECLARATIONS)
def test_declarations(text: str) -> None:
    script = parse(Source("", text), include=lambda path: Source(path, "x = 1"))
    assert list(script.declarations) == DECLARATIONS[text]


TYPES: dict[str, Any] = {
    "a": scheme(t("a")),
    "M::T": scheme(make(s.TypeName, ("M", "T"))),
    "{a}": scheme(make(s.SetType, t("a"))),
    "<a>": scheme(make(s.SequenceType, t("a"))),
    "(a, b)": scheme(make(s.TupleType, (t("a"), t("b")))),
    "((a))": scheme(t("a")),
    "(| a => b |)": scheme(make(s.MapType, t("a"), t("b"))),
    "() -> a": scheme(make(s.FunctionType, (), t("a"))),
    "(a) -> b": scheme(make(s.FunctionType, (t("a"),), t("b"))),
    "(a, b) -> (c) -> d": scheme(make(s.FunctionType, (t("a"), t("b")), make(s.FunctionType, (t("c"),), t("d")))),
    "((a, b)) -> c": scheme(make(s.FunctionType, (make(s.TupleType, (t("a"), t("b"))),), t("c"))),
    "a.b.c": scheme(make(s.DotType, t("a"), make(s.DotType, t("b"), t("c")))),
    "a => b.c => d": scheme(make(s.DotableType, t("a"), make(s.DotableType, make(s.DotType, t("b"), t("c")), t("d")))),
    "a =>* b": scheme(make(s.DotableType, t("a"), t("b"), True)),
    "(a) -> b => c": scheme(make(s.FunctionType, (t("a"),), make(s.DotableType, t("b"), t("c")))),
    "Eq a => a": scheme(t("a"), ("Eq", "a")),
    "(Eq a, Ord b) => a": scheme(t("a"), ("Eq", "a"), ("Ord", "b")),
    "Set a => b => a": scheme(make(s.DotableType, t("b"), t("a")), ("Set", "a")),
}


@pytest.mark.parametrize("text", TYPES)
def test_types(text: str) -> None:
    annotation, _ = parse(Source("", f"f, x :: {text}\n(f, x) = 1")).declarations
    assert isinstance(annotation, s.AnnotationDeclaration)
    assert annotation.names == names("f", "x")
    assert annotation.scheme == TYPES[text]


PRIORITY = make(s.AssertOption, "tau priority", A)
ASSERTIONS: dict[str, Any] = {
    **{f"P [{m}= Q": make(s.Refinement, P, m, Q) for m in ("T", "F", "FD", "V", "VD", "R", "RD")},
    "P :[deadlock free]": make(s.Property, P, "deadlock free"),
    "P :[deadlock-free [F]]": make(s.Property, P, "deadlock free", "F"),
    "P :[livelock free]": make(s.Property, P, "divergence free"),
    "P :[divergence-free [FD]]": make(s.Property, P, "divergence free", "FD"),
    "P :[deterministic]": make(s.Property, P, "deterministic"),
    "P :[has trace]: <a>": make(s.Property, P, "has trace", None, make(s.SequenceExpr, (a,))),
    "P :[has trace [F]] <a>": make(s.Property, P, "has trace", "F", make(s.SequenceExpr, (a,))),
    "not P [T= Q": make(s.NotAssertion, make(s.Refinement, P, "T", Q)),
    "not not P :[deterministic]": make(s.NotAssertion, make(s.NotAssertion, make(s.Property, P, "deterministic"))),
    "a": make(s.BooleanAssertion, a),
    "not a and b": make(s.BooleanAssertion, make(s.Binary, "and", make(s.Unary, "not", a), b)),
    "P [T= Q :[tau priority]: A": make(s.Refinement, P, "T", Q, (PRIORITY,)),
    "P [T= Q :[tau priority over]: A :[partial order reduce]": make(
        s.Refinement, P, "T", Q, (PRIORITY, make(s.AssertOption, "partial order reduce"))
    ),
    "P :[deadlock free] :[partial order reduce [fast]]": make(
        s.Property, P, "deadlock free", options=(make(s.AssertOption, "partial order reduce", mode="fast"),)
    ),
    "P ||| Q [T= a -> Q \\ A": make(
        s.Refinement, make(s.ProcessBinary, "|||", P, Q), "T", make(s.Hide, make(s.Prefix, a, (), Q), A)
    ),
}


@pytest.mark.parametrize("text", ASSERTIONS)
def test_assertions(text: str) -> None:
    assert parse_assertion(text) == ASSERTIONS[text]
    assert parse_assertion(f"assert {text}") == ASSERTIONS[text]
    (declaration,) = parse(Source("", f"assert {text}")).declarations
    assert declaration == make(s.AssertDeclaration, ASSERTIONS[text])


def test_comments_are_kept_in_their_order() -> None:
    script = parse(Source("", "-- one\nx = {- two -} 1 -- three"))
    assert [(comment.text, comment.span.line) for comment in script.comments] == [
        ("-- one", 1),
        ("{- two -}", 2),
        ("-- three", 2),
    ]


def test_a_lone_expression_goes_over_lines() -> None:
    assert parse_expression("x\n- 1\n") == make(s.Binary, "-", x, i(1))


# --- spans ---------------------------------------------------------------------------------------------------


def nodes(tree: Any) -> list[Any]:
    """All nodes of a tree."""
    found = []
    work = [tree]
    while work:
        item = work.pop()
        if isinstance(item, s.Node):
            found.append(item)
            work += [getattr(item, f.name) for f in fields(item) if f.name != "span"]
        elif isinstance(item, tuple):
            work += item
    return found


def reread(node: Any) -> Any:
    """What the text of a node's span is when it is read alone."""
    span: Span = node.span
    if isinstance(node, s.Expr):
        return parse_expression(span.text)
    if isinstance(node, s.Pattern):
        lambda_ = parse_expression(f"\\ {span.text} @ 0")
        assert isinstance(lambda_, s.Lambda)
        return lambda_.parameters[0]
    if isinstance(node, s.Assertion):
        return parse_assertion(span.text)
    return node


def check_spans(script: s.Script) -> None:
    for node in nodes(script):
        assert node.span.text == node.span.text.strip()
        assert node.span.text or isinstance(node, s.Script)
        assert reread(node) == node
        for f in fields(node):
            parts = getattr(node, f.name)
            for part in parts if isinstance(parts, tuple) else (parts,):
                if isinstance(part, s.Node) and part.span.source is node.span.source:
                    assert node.span.start <= part.span.start
                    assert part.span.end <= node.span.end


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: path.stem)
def test_the_span_of_a_node_is_its_text(path: Path) -> None:
    script = parse(read_source(path))
    for declaration in script.declarations:
        check_spans(make(s.Script, (declaration,)))


@settings(max_examples=examples(100), deadline=None)
@given(scripts(1))
def test_the_span_of_a_node_is_its_text_in_random_scripts(script: s.Script) -> None:
    for declaration in parse(Source("", print_script(script))).declarations:
        check_spans(make(s.Script, (declaration,)))


def test_spans_in_an_included_file_lie_in_that_file() -> None:
    included = Source("other.csp", "\n\n  y = 2")
    script = parse(Source("root.csp", 'x = 1\ninclude "other.csp"'), include=lambda _: included)
    include = script.declarations[1]
    assert isinstance(include, s.IncludeDeclaration)
    assert (include.span.source.name, include.span.line, include.span.column) == ("root.csp", 2, 1)
    span = include.declarations[0].span
    assert (span.source, span.line, span.column) == (included, 3, 3)
