"""Formatting scripts: tidy lines, every comment in its place, and nothing else changed."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.source import Source

BEFORE = """\
-- The head of the script


-- goes on.
channel a,b   -- both
channel c:{0..3}.Bool {- data -}



{- A comment
     over lines -}
datatype T=A -- first
   |B.{0..2} -- second
P=a->b->STOP    -- at the end
  []c?x->  -- inside
     (let y=x -- y
          -- alone
          z=2
      within STOP)
f(0)=1

f(n)=if n>3 then
   -- big
   n else 0
module M
   -- private
   x=1
   -- last private
exports
   y=2
endmodule
g :: ((Int){- kept -})->Int
g(x)=h( x,{- why -}2 )+ -- plus
  3
-- expect: fail
assert P -- claimed
  [T= Q
-- The end
"""

AFTER = """\
-- The head of the script

-- goes on.
channel a, b  -- both
channel c : {0..3}.Bool {- data -}

{- A comment
     over lines -}
datatype T =
  A           -- first
  | B.{0..2}  -- second
P =
  a -> b -> STOP  -- at the end
  [] c?x ->  -- inside
       (
         let
           y = x  -- y
           -- alone
           z = 2
         within STOP
       )
f(0) = 1

f(n) =
  if n > 3 then
    -- big
    n
  else
    0
module M
  -- private
  x = 1
  -- last private
exports
  y = 2
endmodule
g :: (Int) {- kept -} -> Int
g(x) = h(x, {- why -} 2) +  -- plus
    3
-- expect: fail
assert P  -- claimed
    [T= Q
-- The end
"""


def formatted(text: str) -> str:
    return format_source(Source("script.csp", text))


def test_a_script_with_comments_everywhere() -> None:
    assert formatted(BEFORE) == AFTER


def test_a_tidy_script_stays_as_it_is() -> None:
    assert formatted(AFTER) == AFTER


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", ""),
        ("\n\n", ""),
        ("-- only a comment", "-- only a comment\n"),
        ("x=1", "x = 1\n"),
        ("x = 1   \n\n\n\ny = 2", "x = 1\n\ny = 2\n"),
        ("x = 1\ny = 2", "x = 1\ny = 2\n"),
        ("P = a -> STOP\n []b->STOP", "P =\n  a -> STOP\n  [] b -> STOP\n"),
        ("P = a -> STOP []b->STOP", "P = a -> STOP [] b -> STOP\n"),
        ("P = a ->\nb ->\nSTOP", "P =\n  a ->\n    b ->\n    STOP\n"),
        ("P = a -> b ->\nSTOP", "P = a -> b -> STOP\n"),
        ("x = {1,\n2}", "x = {1, 2}\n"),
        ("x = {1, -- one\n2}", "x = {1,  -- one\n    2}\n"),
        ("{- a -} x = 1", "{- a -} x = 1\n"),
        ("x {- a -} = 1 {- b -}", "x {- a -} = 1 {- b -}\n"),
        ("f({--}) = 1", "f({--}) = 1\n"),
        ("f(x) = 1", "f(x) = 1\n"),
        ("Timed{ -- open\n}", "Timed {  -- open\n}\n"),
        ("module M\nexports\n-- nothing\nendmodule", "module M\nexports\n  -- nothing\nendmodule\n"),
        ('include "x.csp" -- not read', 'include "x.csp"  -- not read\n'),
        ("assert P :[livelock-free]", "assert P :[divergence free]\n"),
    ],
)
def test_small_scripts(before: str, after: str) -> None:
    assert formatted(before) == after
    assert formatted(after) == after


class TestCommentsInColumns:
    def test_comments_that_the_source_aligns_stay_aligned(self) -> None:
        assert formatted("channel a    -- one\nchannel long -- two\n") == "channel a     -- one\nchannel long  -- two\n"

    def test_others_follow_their_lines(self) -> None:
        assert formatted("channel a -- one\nchannel long -- two\n") == "channel a  -- one\nchannel long  -- two\n"

    def test_lines_between_part_the_columns(self) -> None:
        text = "channel a  -- one\n\nchannel long  -- two\n"
        assert formatted("channel a    -- one\n\nchannel long -- two\n") == text


def test_a_script_with_mistakes_is_not_formatted() -> None:
    with pytest.raises(ScriptError, match="CSP103"):
        formatted("x = )")


def test_annotations_of_what_an_include_defines_are_no_mistake() -> None:
    text = 'include "definitions.csp"\nf :: Int\n'
    assert formatted(text) == text
    with pytest.raises(ScriptError, match="CSP162"):
        parse(Source("", text), include=lambda path: Source(path, ""))


def test_a_name_print_stays_a_name() -> None:
    before = (
        "channel print: {0..3}\n"
        "channel other,print'\n"
        "P=print!1->print?x->other->P\n"
        "R=P [[print<-print]] \\ {|print|}\n"
        "f(x)=let y=print\n  within y\n"
        "g(x)=<print|y<-x>\n"
        'print "of print it is"\n'
        "Q=print-- said\n  ?x->STOP\n"
        "S={|print{- in -},other|}\n"
    )
    after = (
        "channel print: {0..3}\n"
        "channel other, print'\n"
        "P = print!1 -> print?x -> other -> P\n"
        "R = P[[ print<- print]] \\ {| print|}\n"
        "f(x) =\n  let\n    y = print\n  within y\n"
        "g(x) = <print| y <- x>\n"
        'print "of print it is"\n'
        "Q =  -- said\n    print?x -> STOP\n"
        "S = {| {- in -} print, other |}\n"
    )

    assert format_source(Source("script.csp", before)) == after
    assert format_source(Source("script.csp", after)) == after


def test_a_name_print_before_a_word_stands_at_the_end_of_a_line() -> None:
    made = format_source(
        Source("script.csp", "f(x, print) = if print\n  and x then 1 else 2\nprint= 3\nprint f(1, 2)\n")
    )

    assert made == "f(x, print) = if print\n  and x then 1 else 2\nprint= 3\nprint f(1, 2)\n"
    assert len(parse(Source("script.csp", made)).declarations) == 3
