"""Objects of one of several classes: textbook examples, in words of our own, are typed, run as processes and proved."""

from __future__ import annotations

import pytest

from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from tests.cspm.oz.asking import outcome, refusal

SHAPES = """
class Shape
  visible INIT, x, move, area
  state x : 0..2
  init x = 0
  op move = [Delta(x); d? : 0..1 | x' = x + d?]
  op area = [a! : 0..9]
end
class Square
  inherit Shape
  state side : 1..2
  init side = 1
  op area = [a! : 0..9 | a! = side * side]
  op grow = [Delta(side) | side' = side + 1]
end
class Bar
  inherit Shape
  state w, h : 1..3
  init w = 2 and h = 3
  op area = [a! : 0..9 | a! = w * h]
  op grow = [Delta(h) | h' = h + 1]
end
"""
PICTURE = """
class Picture
  state
    a : poly Shape
    b : Square union Bar
  init
    a.INIT
    b.INIT
    a.kind != poly_Shape_is_Shape
  op moved = a.move
  op measured = a.area
  op grown = b.grow
  op wide = a.area || [a? : 0..9 | a? > 3]
  op at = [p! : 0..2 | p! = a.x]
end
"""
AQUARIUM = """
class Fish
  visible INIT, hungry, eat, swim
  state hungry : bool
  init hungry = true
  op eat = [Delta(hungry) | hungry = true; hungry' = false]
  op swim = [Delta(hungry) | hungry' = true]
end
class Shark
  inherit Fish
  state full : 0..2
  init full = 0
  op eat = [Delta(full) | full < 2; full' = full + 1]
end
class Aquarium
  state tank : power (poly Fish)
  init
    tank = {}
    forall f : poly Fish @ f.INIT
  op put = [Delta(tank); f? : poly Fish | f? notin tank; tank' = tank union {f?}]
  op feed = [f? : tank] @ f?.eat
  op swim = and f : tank @ f.swim
  op fed = [tank != {}; forall f : tank @ f.hungry = false]
end
reading poly Fish = 2
"""


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("measured.1, moved.1, at.1", "pass"),
        ("measured.6, moved.1, moved.1, at.2, wide", "pass"),
        ("grown", "pass"),
        ("grown, grown", "fail"),
        ("measured.1, measured.6", "fail"),
        ("measured.1, wide", "fail"),
        ("measured.4", "fail"),
    ],
)
def test_a_shape_is_of_one_kind_for_ever(trace: str, verdict: str) -> None:
    text = SHAPES + PICTURE
    assert outcome(text, f"Picture :[has trace]: <{trace}>")[0] == verdict


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("put.poly_Fish_1, feed.poly_Fish_1, fed, swim, feed.poly_Fish_1", "pass"),
        ("put.poly_Fish_1, put.poly_Fish_2, feed.poly_Fish_1, feed.poly_Fish_2, fed", "pass"),
        ("put.poly_Fish_1, put.poly_Fish_2, feed.poly_Fish_1, fed", "fail"),
        ("put.poly_Fish_1, feed.poly_Fish_1, feed.poly_Fish_1", "fail"),
        ("feed.poly_Fish_1", "fail"),
    ],
)
def test_the_fish_of_an_aquarium(trace: str, verdict: str) -> None:
    assert outcome(AQUARIUM, f"Aquarium :[has trace]: <{trace}>")[0] == verdict


def test_claims_about_them_are_proved() -> None:
    assert outcome(AQUARIUM, "Aquarium :[initialisation]")[0] == "pass"
    assert outcome(SHAPES + PICTURE, "Picture :[invariant preserved]: moved")[0] == "pass"
    assert outcome(SHAPES.replace("d? : 0..1", "d? : 1..1") + PICTURE, "Picture :[feasible]: grown")[0] == "pass"


def test_in_markup_and_back() -> None:
    tex = r"""
\begin{class}{Fish}
\begin{state} n : \nat \end{state}
\begin{op}{eat} \Delta(n) \where n' = n + 1 \end{op}
\end{class}
\begin{class}{Tank}
\begin{state} f : \poly Fish \\ g : Fish \classuni Fish \end{state}
feed \sdef f.eat
\end{class}
"""
    script = parse(Source("tank.tex", tex))
    assert "f : poly Fish" in print_script(script)
    assert print_script(parse(Source("tank.csp", print_script(script)))) == print_script(script)
    assert elaborate(script).specification.classes["Tank"].operations["feed"].delta


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ("s : poly nat", "no class"),
        ("s : poly Stream", "`Stream` has parameters or channels"),
        ("s : Shape union Stream", "`Stream` has parameters or channels"),
        ("s : poly Shape\n  op x = s.grow", "no visible operation `grow`"),
    ],
)
def test_what_has_no_alternatives_is_refused_in_words(state: str, message: str) -> None:
    text = f"{SHAPES}class Stream\n  chan c\n  main = c -> main\nend\nclass C\n  state\n    {state}\nend"
    assert message in refusal(text).message


TANKS = """class Tank
  limit == 2
  levels == 0..limit
  state n : 0..2
  init n = 0
  op fill = [Delta(n) | n' = n + 1]
end
class Cup
  limit == 1
  state n : 0..1; stirred : bool
  init n = 0
  op fill = [Delta(n) | n' = n + 1]
end
class Bath
  inherit Tank
end
class User
  state x : {carrier}
  init x.INIT
  op fill = x.fill
  op full = [x.n = x.limit]
end
"""


@pytest.mark.parametrize(
    ("carrier", "trace", "verdict"),
    [
        ("Tank union Cup", "fill, full", "pass"),
        ("Tank union Cup", "fill, fill, full", "pass"),
        ("Tank union Cup", "fill, fill, fill", "fail"),
        ("Tank union Cup", "full", "fail"),
        ("poly Tank", "fill, fill, full", "pass"),
        ("poly Tank", "fill, full", "fail"),
        ("Cup", "fill, full", "pass"),
        ("Cup", "fill, fill", "fail"),
    ],
)
def test_what_all_alternatives_have_is_an_attribute(carrier: str, trace: str, verdict: str) -> None:
    claim = f"User :[has trace]: <{trace}>"
    assert outcome(TANKS.replace("{carrier}", carrier) + f"assert {claim}\n", claim)[0] == verdict


def test_what_an_abbreviation_of_a_class_stands_for_is_a_feature_of_its_objects() -> None:
    user = "class U\n  state t : Tank; f : 0..1 -> Tank\n  init t.INIT\n"
    user += "  op go = [t.n in t.levels and t.limit = f(0).limit]\nend\n"
    claim = "U :[has trace]: <go>"
    assert outcome(TANKS.replace("{carrier}", "Tank") + user + f"assert {claim}\n", claim)[0] == "pass"


CELL = """class Cell[X]
  kind == X
  state held : X
  op put = [Delta(held); x? : X | held' = x?]
end
Small == Cell[0..2][content/held, store/put]
Either == Cup union Tank
class Both
  state c : Small; d : (Cell[nat][a/held])[b/a]; e : Either
  init c.content = 0 and d.b = 0 and e.INIT
  op put = c.store
  op tell = [y! : 0..2 | y! = c.content and d.b = 0]
  op fill = e.fill
end
"""


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [("put.2, tell.2", "pass"), ("put.2, tell.1", "fail"), ("fill, fill", "pass"), ("fill, fill, fill", "fail")],
)
def test_objects_of_a_class_under_other_names_are_run(trace: str, verdict: str) -> None:
    claim = f"Both :[has trace]: <{trace}>"
    text = TANKS.replace("{carrier}", "Tank") + CELL + f"assert {claim}\n"
    assert outcome(text, claim)[0] == verdict
