"""What the page of the explorer is answered."""

from pathlib import Path

import pytest

from cspcheck import checking
from cspcheck.exploring.model import Explorer, Unanswerable

SCRIPT = """\
channel a, b, c : {0..1}
Left = a?x -> c!x -> Left
Right = c?x -> b!x -> Right
System = Left [| {| c |} |] Right
Stuck = (a.0 -> b.0 -> STOP) [| {| a, b |} |] (a.0 -> b.1 -> STOP)
assert System :[deadlock free]
assert Stuck :[deadlock free]
"""


@pytest.fixture(scope="module")
def explorer(tmp_path_factory: pytest.TempPathFactory) -> Explorer:
    path: Path = tmp_path_factory.mktemp("x") / "x.csp"
    path.write_text(SCRIPT)
    script = checking.load(str(path), checking.Settings())
    return Explorer(script, checking.Settings())


def test_script(explorer: Explorer) -> None:
    found = explorer.answer("script", {})
    assert found["processes"] == ["Left", "Right", "System", "Stuck"]
    assert [(a["number"], a["line"], a["text"]) for a in found["assertions"]] == [
        (0, 6, "System :[deadlock free]"),
        (1, 7, "Stuck :[deadlock free]"),
    ]


def test_a_place_is_its_root_and_its_way(explorer: Explorer) -> None:
    start = explorer.answer("place", {"root": "System", "way": ""})
    assert [step["event"] for step in start["steps"]] == ["a.0", "a.1"]
    there = explorer.answer("place", {"root": "System", "way": "2.1"})
    assert [step["event"] for step in there["trace"]] == ["a.1", "c.1"]
    assert [(c["name"], c["line"], c["state"], c["offers"], c["waits"]) for c in there["components"]] == [
        (
            "Left",
            2,
            "a.0 -> c.0 -> Left [] a.1 -> c.1 -> Left",
            ["a.0", "a.1"],
            [],
        ),
        ("Right", 3, "b.1 -> Right", ["b.1"], []),
    ]
    assert explorer.answer("place", {"root": "System", "way": ""}) == start


def test_a_counterexample_is_a_way(explorer: Explorer) -> None:
    found = explorer.answer("check", {"number": "1"})
    assert (found["verdict"], found["way"]) == ("fail", [1])
    assert "<svg" in found["chart"]
    end = explorer.answer("place", {"root": "@1", "way": "1"})
    assert end["steps"] == []
    assert "wait" in end["circle"]
    before = explorer.answer("place", {"root": "@1", "way": ""})
    assert [step["next"] for step in before["steps"]] == [True]
    assert explorer.answer("script", {})["assertions"][1]["verdict"] == "fail"


def test_pictures(explorer: Explorer) -> None:
    drawn = explorer.answer("machine", {"root": "System", "way": "1"})
    assert "<svg" in drawn["svg"]
    assert drawn["number"] == 1
    assert explorer.answer("place", {"root": "System", "way": "1"})["number"] == 1
    assert "Left" in explorer.answer("architecture", {"root": "System"})["svg"]


def test_events_and_walks(explorer: Explorer) -> None:
    assert explorer.answer("perform", {"root": "System", "way": "", "event": "a.1"}) == {"way": [2]}
    walked = explorer.answer("walk", {"root": "System", "way": "", "steps": "7", "seed": "3"})["way"]
    assert len(walked) == 7
    assert explorer.answer("walk", {"root": "System", "way": "", "steps": "7", "seed": "3"})["way"] == walked
    trace = explorer.answer("place", {"root": "System", "way": ".".join(map(str, walked))})["trace"]
    assert len(trace) == 7


@pytest.mark.parametrize(
    ("question", "arguments", "message"),
    [
        ("nothing", {}, "no question"),
        ("place", {"root": "System", "way": "9"}, "no step 9"),
        ("place", {"root": "System", "way": "x"}, "no number"),
        ("place", {"root": "Nobody"}, "not defined"),
        ("check", {"number": "7"}, "no assertion 7"),
        ("perform", {"root": "System", "event": "zzz"}, "cannot happen"),
        ("machine", {"root": "let C(n) = a.0 -> C(n + 1) within C(0)"}, "more than 300 states"),
    ],
)
def test_what_makes_no_sense(explorer: Explorer, question: str, arguments: dict[str, str], message: str) -> None:
    with pytest.raises(Unanswerable, match=message):
        explorer.answer(question, arguments)


def test_the_data_of_classes_at_each_point_of_the_way(tmp_path: Path) -> None:
    path = tmp_path / "tank.csp"
    path.write_text("""\
class Tank
  chan fill
  state level : 0..2
  init level = 0
  op fill
    Delta(level)
  where
    level' = level + 1
end
Other = fill -> Other
System = Tank [| {fill} |] Other
""")
    explorer = Explorer(checking.load(str(path), checking.Settings()), checking.Settings())
    place = explorer.answer("place", {"root": "System", "way": "1.1"})

    assert place["data"] == [{"Tank": {"level": "0"}}, {"Tank": {"level": "1"}}, {"Tank": {"level": "2"}}]
    assert [(part["name"], part["data"]) for part in place["components"]] == [("Tank", {"level": "2"}), ("Other", {})]
