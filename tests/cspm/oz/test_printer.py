"""From trees to the text notation and back."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.oz.writing.printer import print_paragraph, print_term
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.source import Source
from tests.cspm.oz.strategies_oz import paragraphs, plain, terms
from tests.cspm.oz.test_parser import EXPRESSIONS, declaration, expression
from tests.examples import examples

widths = st.sampled_from([10, 30, 100])


@settings(max_examples=examples(300), deadline=None)
@given(terms(3), st.booleans(), widths)
def test_terms_come_back(term, symbols, width):
    text = print_term(term, symbols=symbols, width=width)
    found = declaration(f"class C\n  init\n    {text}\nend").initial.predicates
    assert len(found) == 1
    assert plain(found[0]) == plain(term)
    # What the parser made needs no further brackets.
    assert declaration(f"class C\n  init\n    {print_term(found[0], symbols=symbols)}\nend").initial.predicates == found


@settings(max_examples=examples(150), deadline=None)
@given(paragraphs(terms(1)), st.booleans(), widths)
def test_paragraphs_come_back(paragraph, symbols, width):
    text = print_paragraph(paragraph, symbols=symbols, width=width)
    (_, found) = parse(Source("x.csp", f"given G\n{text}")).declarations
    assert plain(found) == plain(paragraph)
    again = print_paragraph(found, symbols=symbols, width=width)
    assert parse(Source("x.csp", f"given G\n{again}")).declarations[1:] == (found,)


@pytest.mark.parametrize("symbols", [False, True])
@pytest.mark.parametrize("text", EXPRESSIONS)
def test_what_was_written_comes_back(text, symbols):
    assert expression(print_term(EXPRESSIONS[text], symbols=symbols)) == EXPRESSIONS[text]


def commented(text, places):
    """The text with comments at the ends of some lines and above some, and blank lines."""
    lines = []
    for number, line in enumerate(text.splitlines()):
        kind = places.get(number)
        if kind == "above":
            lines += [f"  -- comment {number}", line]
        elif kind == "behind":
            lines.append(f"{line} -- comment {number}")
        elif kind == "block":
            lines.append(f"{line} {{- comment\n {number} -}}")
        elif kind == "blank":
            lines += ["", line]
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


@settings(max_examples=examples(60), deadline=None)
@given(
    paragraphs(terms(2)),
    widths,
    st.booleans(),
    st.dictionaries(st.integers(0, 30), st.sampled_from(["above", "behind", "block", "blank"])),
)
def test_formatting_keeps_trees_and_comments(paragraph, width, symbols, places):
    text = commented(f"given G\n{print_paragraph(paragraph, symbols=symbols, width=width)}\nP = STOP", places)
    source = Source("x.csp", text)
    script = parse(source)

    formatted = format_source(source)

    again = parse(Source("x.csp", formatted))
    assert again.declarations == script.declarations
    assert [c.text.split() for c in again.comments] == [c.text.split() for c in script.comments]
    assert format_source(Source("x.csp", formatted)) == formatted


def test_formatting_keeps_how_things_are_spelt():
    text = """given MESSAGE, GID -- of the network
DATA ::= {x : ℕ | 0 ≤ x ≤ 10}
class Stack[T] -- generic
  visible (push, m)
  inherit Periodic, Base[nat][new/old]

  chan push:[item?:T]
  {- dynamic -} main = push -> main
     [] m -> main
  const size : ℕ where size = 10
  state
    items : seq T; k : nat -- two of them
  Δ
    n : nat
  where
    -- the invariant
    #items<=size /\\ n = #items
    {-1,0} ⊆ {n}
  INIT
    items = ⟨⟩ -- empty

  op push
    Delta(items)
    item? : T
  where
    if n = 0 then
      items' = <item?>^items
      k = 1
    else
      items' = <>
  op m = [ Δ(n) ; x? : nat | n = 0; n = 1 ]
  op q = a comp b \\ {x} ∧ c
end
"""
    assert (
        format_source(Source("x.csp", text))
        == """given MESSAGE, GID  -- of the network
DATA ::= {x : ℕ | 0 ≤ x ≤ 10}
class Stack[T]  -- generic
  visible push, m
  inherit Periodic, Base[nat][new/old]

  chan push : [item? : T]
  {- dynamic -} main =
    push -> main
    [] m -> main
  const size : ℕ where size = 10
  state
    items : seq T
    k : nat  -- two of them
  Δ
    n : nat
  where
    -- the invariant
    #items <= size /\\ n = #items
    {-1, 0} ⊆ {n}
  INIT
    items = ⟨⟩  -- empty

  op push
    Delta(items)
    item? : T
  where
    if n = 0
      then items' = <item?> ^ items
           k = 1
      else items' = <>
  op m = [Δ(n); x? : nat | n = 0; n = 1]
  op q = a comp b \\ {x} ∧ c
end
"""
    )
