"""The equations of a class are CSPm of any kind, in both notations."""

from __future__ import annotations

from hypothesis import assume, given, settings

from cspm import syntax as s
from cspm.diagnostics import ScriptError
from cspm.formatter import format_source
from cspm.oz import syntax as z
from cspm.oz.latex_writer import Writer
from cspm.oz.printer import print_paragraph
from cspm.parser import parse
from cspm.printer import print_script
from cspm.source import Source
from tests.cspm.oz.strategies_oz import make
from tests.cspm.strategies_syntax import expressions


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


@settings(max_examples=60, deadline=None)
@given(expressions(3).map(class_with))
def test_they_come_back_from_text(node):
    text = print_paragraph(node)
    assert parse(Source("x.csp", text)).declarations == (node,)
    assert parse(Source("x.csp", format_source(Source("x.csp", text)))).declarations == (node,)


@settings(max_examples=60, deadline=None)
@given(expressions(3).map(class_with))
def test_they_come_back_from_latex(node):
    script = parse(Source("x.tex", Writer().paragraph(node)))
    assert script.declarations == (node,)
    assert script.remarks == ()
