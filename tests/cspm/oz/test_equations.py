"""The equations of a class are CSPm of any kind, in both notations."""

from __future__ import annotations

from hypothesis import assume, given, settings

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.writing.latex_writer import Writer
from cspcheck.cspm.oz.writing.printer import print_paragraph
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from tests.cspm.oz.strategies_oz import make
from tests.cspm.syntax.strategies_syntax import expressions
from tests.examples import examples


def class_with(expression):
    """A class with two equations for the expression, which has all its brackets."""
    bodies = [
        make(s.PatternDefinition, pattern=make(s.NamePattern, parts=(name,)), body=expression) for name in ("main", "P")
    ]
    try:
        equations = parse(Source("x.csp", print_script(make(s.Script, declarations=tuple(bodies))))).declarations
    except ScriptError:
        assume(False)
    return make(z.Class, name="C", equations=equations)


@settings(max_examples=examples(60), deadline=None)
@given(expressions(3).map(class_with))
def test_they_come_back_from_text(node):
    text = print_paragraph(node)
    assert parse(Source("x.csp", text)).declarations == (node,)
    assert parse(Source("x.csp", format_source(Source("x.csp", text)))).declarations == (node,)


@settings(max_examples=examples(60), deadline=None)
@given(expressions(3).map(class_with))
def test_they_come_back_from_latex(node):
    script = parse(Source("x.tex", Writer().paragraph(node)))
    assert script.declarations == (node,)
    assert script.remarks == ()
