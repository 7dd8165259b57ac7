"""From a syntax tree back to CSPm.

For every tree that the parser makes, parsing what is printed gives the same tree, spans and comments apart. That
holds for ``Paren`` nodes, too: they are printed, and no others are needed. A tree that was made otherwise may lack
brackets; they are added where the meaning needs them, and parsing gives the tree with these added ``Paren`` (or
``ParenPattern``) nodes. Five things that the concrete syntax cannot say come back in their nearest form:

* a literal with a negative number comes back as the ``Unary`` (in patterns: the literal) it is written as;
* a ``NotAssertion`` of a Boolean comes back as the Boolean ``not (e)``;
* a set, sequence or ``{| |}`` with statements but no items, a ``let`` without declarations, a tuple (or tuple type) of
  fewer than two items, and names that are no CSPm names have no syntax; what is printed for them does not parse;
* adjacent definitions of one function come back as one;
* what an ``include`` brought is not printed, only the ``include``.
"""

from __future__ import annotations

from cspcheck.cspm.printing.declarations import Printer
from cspcheck.cspm.printing.layout import WIDTH, lay_out
from cspcheck.cspm.syntax import tree as s


def print_script(script: s.Script, *, width: int = WIDTH, symbols: bool = False) -> str:
    """The script as text without its comments, in lines of *width* columns where possible.

    With *symbols*, Object-Z is written with mathematical symbols.
    """
    text = lay_out(Printer(symbols=symbols).document(script), width)
    return text + "\n" if text else ""


def print_expression(node: s.Expr | s.Pattern | s.TypeExpr | s.Declaration, *, width: int = WIDTH) -> str:
    """An expression (or any other node but an assertion) as text."""
    return lay_out(Printer().document(node), width)


def print_assertion(node: s.Assertion, *, width: int = WIDTH) -> str:
    """An assertion as text, without the word ``assert``."""
    return lay_out(Printer().document(node), width)
