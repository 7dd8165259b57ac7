"""``cspcheck graph`` from a shell: what is drawn, in which formats, and what is refused."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from cspcheck.cli import run

SPECS = Path(__file__).resolve().parents[3] / "specs"
ROV = str(SPECS / "rov" / "rov.csp")
PETERSON = str(SPECS / "classics" / "peterson.csp")
ABP = str(SPECS / "classics" / "abp.csp")
PHILOSOPHERS = str(SPECS / "classics" / "philosophers.csp")


def texts(path: Path) -> list[str]:
    """All words in an SVG, in order."""
    root = ElementTree.parse(path).getroot()
    return [element.text for element in root.iter() if element.text and element.text.strip()]


def test_a_machine_is_drawn_with_all_its_states_and_labels(tmp_path: Path) -> None:
    picture = tmp_path / "move.svg"

    assert run(["graph", ROV, "Move", "-o", str(picture)]) == 0
    words = texts(picture)
    assert [word for word in words if word.isdigit()] == ["0", "1", "2", "3"]
    assert {"s1_move", "avoid_move", "getNextMovement", "move_s2"} <= set(words)
    assert "move_s2 -> Move" in words  # what a state is, where a reader can point at it


def test_an_architecture_joins_the_components_that_share_a_channel(tmp_path: Path) -> None:
    picture = tmp_path / "rov.svg"

    assert run(["graph", ROV, "ROV_Control_Module", "--architecture", "-o", str(picture)]) == 0
    words = texts(picture)
    assert {"BaseReader", "Remote", "S1", "Move", "S2", "Actuator", "Sonar"} <= set(words)
    assert words.count("move_s2") == 1
    assert "own: getSonar, saveSonar, getNextExecutionSnr" in words


def test_a_counterexample_is_drawn_as_a_chart_with_a_row_for_each_event(tmp_path: Path) -> None:
    picture = tmp_path / "deadlock.svg"
    arguments = ["graph", PHILOSOPHERS, "Symmetric :[deadlock free]", "--trace", "-D", "N=2", "-o", str(picture)]

    assert run(arguments) == 0
    words = texts(picture)
    assert words[-11:-5] == ["thinks.0", "thinks.1", "sits.0", "sits.1", "picks.0.0", "picks.1.1"]
    assert words[-5:] == [
        "Nothing more can happen.",
        "Greedy(0) waits for Fork(1).",
        "Fork(1) waits for Greedy(1).",
        "Greedy(1) waits for Fork(0).",
        "Fork(0) waits for Greedy(0).",
    ]


def test_a_chart_shows_the_event_that_is_not_allowed_with_those_who_perform_it(tmp_path: Path) -> None:
    picture = tmp_path / "hasty.svg"

    assert run(["graph", PETERSON, "Exclusion [T= Hasty \\ memory", "--trace", "-o", str(picture)]) == 0
    svg = picture.read_text()
    assert texts(picture)[-2:] == ["enter.1", "The specification does not allow enter.1."]
    assert svg.count('class="part wrong"') == 1


def test_a_chart_frames_the_loop_of_a_divergence(tmp_path: Path) -> None:
    picture = tmp_path / "busy.svg"

    assert run(["graph", PETERSON, "System \\ memory :[divergence free]", "--trace", "-o", str(picture)]) == 0
    words = texts(picture)
    assert words[-3:] == ["tau (level_get.0.1.1)", "tau (last_get.0.1.0)", "The framed events go on for ever."]
    assert picture.read_text().count('class="loop"') == 1


class TestArchitecture:
    """Who talks to whom."""

    @staticmethod
    def dot(tmp_path: Path, script: str, process: str, *options: str) -> str:
        picture = tmp_path / "x.dot"
        assert run(["graph", script, process, "--architecture", "-o", str(picture), *options]) == 0
        return picture.read_text()

    @staticmethod
    def edges(dot: str) -> list[tuple[str, str, str]]:
        names = dict(re.findall(r'^  (n\d+) \[label="(\w*)', dot, re.MULTILINE))
        found = re.findall(r'(n\d+) -> (n\d+) \[label="([^"]*)"(, dir=none)?', dot)
        return [(names[a], names[b], label + (" undirected" if way else "")) for a, b, label, way in found]

    def test_an_arrow_leads_from_who_says_which_value_to_who_takes_any(self, tmp_path: Path) -> None:
        assert sorted(self.edges(self.dot(tmp_path, ABP, "Protocol"))) == [
            ("Acknowledgements", "Sender", "d"),
            ("Messages", "Receiver", "b"),
            ("Receiver", "Acknowledgements", "c"),
            ("Sender", "Messages", "a"),
        ]

    def test_without_data_nobody_can_tell_the_way(self, tmp_path: Path) -> None:
        found = self.edges(self.dot(tmp_path, ROV, "ROV_Control_Module"))
        assert ("Move", "S2", "move_s2 undirected") in found
        assert all(label.endswith("undirected") for _, _, label in found)

    def test_equal_components_have_numbers(self, tmp_path: Path) -> None:
        dot = self.dot(tmp_path, str(SPECS / "classics" / "buffer_chain.csp"), "Chain")
        assert re.findall(r"Copy #\d", dot) == ["Copy #1", "Copy #2", "Copy #3"]

    def test_what_a_component_does_by_itself_stands_in_its_box(self, tmp_path: Path) -> None:
        assert '"Compass\\ngetDirection\\nsaveDirection\\ngetNextExecutionCps"' in self.dot(
            tmp_path, ROV, "ROV_Control_Module"
        )

    def test_priority_and_sequence_do_not_hide_the_components(self, tmp_path: Path) -> None:
        crossing = self.edges(self.dot(tmp_path, str(SPECS / "classics" / "crossing.csp"), "System(DOWN, DOWN)"))
        assert ("Train", "Controller", "near\\nleft_crossing undirected") in crossing
        script = tmp_path / "phases.csp"
        script.write_text(
            "channel a, b, c\nA = a -> b -> SKIP\nB = a -> SKIP\nC = c -> STOP\nP = (A [| {a} |] B) ; C\n"
        )
        assert ("A", "B", "a undirected") in self.edges(self.dot(tmp_path, str(script), "P"))

    def test_three_on_a_channel_meet_in_a_point(self, tmp_path: Path) -> None:
        dot = self.dot(tmp_path, str(SPECS / "classics" / "crossing.csp"), "System(DOWN, DOWN)")
        assert dot.count("shape=point") == 1
        assert len([edge for edge in self.edges(dot) if edge[0] == ""]) == 3


def test_dot_has_a_node_a_state_and_an_edge_a_pair_of_states(tmp_path: Path) -> None:
    picture = tmp_path / "compass.dot"

    assert run(["graph", ROV, "Compass", "-o", str(picture)]) == 0
    text = picture.read_text()
    assert re.findall(r"n\d -> n\d", text) == ["n0 -> n1", "n1 -> n2", "n2 -> n0"]


def test_html_holds_the_picture(tmp_path: Path) -> None:
    picture = tmp_path / "compass.html"

    assert run(["graph", ROV, "Compass", "-o", str(picture)]) == 0
    assert "<svg" in picture.read_text()
    assert "getDirection" in picture.read_text()


def test_without_a_file_the_svg_goes_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["graph", ROV, "Compass"]) == 0
    assert capsys.readouterr().out.startswith("<svg")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["ROV_Control_Module"],
            "error[CSP910]: `ROV_Control_Module` has more than 300 states, too many for a picture",
        ),
        (["Compass", "-o", "compass.png"], "error[CSP911]: no picture format for `compass.png`"),
        (
            ["Compass :[deadlock free]", "--trace"],
            "error[CSP912]: `Compass :[deadlock free]` has no counterexample: its verdict is pass",
        ),
        (["Compas"], "error[CSP201]: `Compas` is not defined"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_words(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["graph", ROV, *arguments]) == 2
    assert capsys.readouterr().err.splitlines()[0] == message


@pytest.mark.slow
def test_a_component_that_grows_without_end_is_refused_in_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cspcheck.checker.network.compiler.MOST_TERMS", 5_000)
    script = tmp_path / "counter.csp"
    script.write_text("channel tick, tock\nCounter(n) = tick -> Counter(n + 1)\nTwo = Counter(0) ||| tock -> STOP\n")

    assert run(["graph", str(script), "Two", "--architecture"]) == 2
    assert capsys.readouterr().err.startswith("error[CSP503]: more than 5,000 states: `Counter` is called with")
