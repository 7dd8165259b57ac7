"""What an editor is told about a text."""

from pathlib import Path

import pytest
from lsprotocol import types

from cspcheck.editing import answers
from cspcheck.editing.analysis import Analysis, analyse
from cspcheck.editing.places import offset, path_of, position, uri_of

ROOT = Path(__file__).resolve().parents[3]
TEXT = """\
channel a, b : {0..3}
datatype Colour = Red | Green.{0..2}
-- Counts.
-- For ever.
f(0) = 1
f(n) = n
module M
  q = 3
exports
  P(x) = a!x -> P(x)
endmodule
Q = let r(y) = M::P(y) within b?z -> r(z)
assert Q :[deadlock free]
"""


def analysed(text: str = TEXT) -> Analysis:
    return analyse("/models/x.csp", text)


def place(text: str, marked: str) -> types.Position:
    """Where `^` stands in a piece of the text."""
    before, _, after = marked.partition("^")
    start = text.index(before + after)
    line, column = (
        text[: start + len(before)].count("\n"),
        (start + len(before)) - text.rfind("\n", 0, start + len(before)) - 1,
    )
    return types.Position(line, column)


def pieces(found: Analysis, places: list[types.Location]) -> list[str]:
    lines = found.source.text.split("\n")
    return [
        f"{p.range.start.line + 1}:{lines[p.range.start.line][p.range.start.character : p.range.end.character]}"
        for p in places
    ]


@pytest.mark.parametrize(
    ("marked", "expected"),
    [
        ("-> r^(z)", ["12:r"]),
        ("M::P^(y)", ["10:P"]),
        ("assert Q^", ["12:Q"]),
        ("r(^z)", ["12:z"]),
        ("b^?z", ["1:b"]),
        ("a!^x", ["10:x"]),
        ("^f(0)", ["5:f", "6:f"]),
        ("= ^n", ["6:n"]),
    ],
)
def test_definition(marked: str, expected: list[str]) -> None:
    found = analysed()
    assert pieces(found, answers.definitions(found, place(TEXT, marked))) == expected


def test_references() -> None:
    found = analysed()
    assert pieces(found, answers.references(found, place(TEXT, "M::P^(y)"))) == ["10:P", "10:P", "12:P"]
    assert pieces(found, answers.references(found, place(TEXT, "M::P^(y)"), declarations=False)) == ["10:P", "12:P"]


def hovered(marked: str) -> str:
    hover = answers.hover(analysed(), place(TEXT, marked), {"Q :[deadlock free]": "**pass**, 8 states, 0.01 s"})
    assert hover is not None
    assert isinstance(hover.contents, types.MarkupContent)
    return hover.contents.value


def test_hover() -> None:
    assert hovered("^f(0)") == "```cspm\nf :: (Int) -> Int\n```\n\nfunction\n\nCounts.\nFor ever."
    assert hovered("b^?z").startswith("```cspm\nb :: Int => Event\n```")
    assert hovered("asse^rt Q") == "```cspm\nassert Q :[deadlock free]\n```\n**pass**, 8 states, 0.01 s"


def test_rename_changes_every_place_and_nothing_else() -> None:
    found = analysed()
    edits = answers.renamed(found, place(TEXT, "M::P^(y)"), "Send", lambda _: None)
    (changes,) = edits.values()
    text = TEXT
    for edit in sorted(changes, key=lambda e: (e.range.start.line, e.range.start.character), reverse=True):
        start, end = offset(found.source, edit.range.start), offset(found.source, edit.range.end)
        text = text[:start] + edit.new_text + text[end:]
    assert text == TEXT.replace("P(x)", "Send(x)").replace("M::P", "M::Send")


@pytest.mark.parametrize("new", ["b", "channel", "x y", "1x", "r", ""])
def test_rename_refuses_what_would_mean_something_else(new: str) -> None:
    with pytest.raises(answers.CannotRename):
        answers.renamed(
            analysed(), place(TEXT, "^b?z"[1:] and "b^?z") if new != "b" else place(TEXT, "a^!x"), new, lambda _: None
        )


def test_rename_refuses_what_is_built_in() -> None:
    text = "channel a\nP = a -> STOP\n"
    with pytest.raises(answers.CannotRename):
        answers.renamed(analysed(text), place(text, "STO^P"), "HALT", lambda _: None)


def test_a_mistake_has_its_code_place_and_labels() -> None:
    text = "channel a\nchannel a\nP = b -> STOP\n"
    told = answers.diagnostics(analysed(text))[uri_of("/models/x.csp")]
    assert [(d.code, d.range.start.line, d.severity) for d in told] == [
        ("CSP202", 1, types.DiagnosticSeverity.Error),
        ("CSP201", 2, types.DiagnosticSeverity.Error),
    ]
    assert told[0].related_information


def test_mistakes_of_an_included_file_are_told_there() -> None:
    text = 'include "y.csp"\nP = a -> STOP\n'
    found = analyse(
        "/models/x.csp", text, lambda path: "channel a\nQ = c -> STOP\n" if path == "/models/y.csp" else None
    )
    told = answers.diagnostics(found)
    assert told[uri_of("/models/x.csp")] == []
    assert [d.code for d in told[uri_of("/models/y.csp")]] == ["CSP201"]


def test_outline() -> None:
    found = answers.symbols(analysed())
    assert [(s.name, s.kind.name) for s in found] == [
        ("a", "Event"),
        ("b", "Event"),
        ("Colour", "Enum"),
        ("f", "Function"),
        ("M", "Module"),
        ("Q", "Variable"),
        ("assert Q :[deadlock free]", "Boolean"),
    ]
    assert [s.name for s in found[2].children or ()] == ["Red", "Green"]
    assert [s.name for s in found[4].children or ()] == ["q", "P"]


def completed(text: str, marked: str) -> set[str]:
    last = analysed()
    return {item.label for item in answers.completions(analysed(text), text, place(text, marked), last)}


def test_completion() -> None:
    assert completed(TEXT + "R = M::", "R = M::^") == {"P"}
    assert "deadlock free" in completed(TEXT + "assert Q :[de", "Q :[de^")
    found = completed(TEXT + "R = ", "R = ^")
    assert {"Q", "f", "a", "Red", "STOP", "union", "let"} <= found
    assert "sbisim" in completed(TEXT + "transparent s", "transparent s^")


def test_formatting_edits_give_what_the_formatter_gives() -> None:
    from cspcheck.cspm.printing.formatter import format_source

    text = "channel   a\nP=a->P   -- on\n\n\n\nQ = P"
    found = analysed(text)
    for edit in sorted(answers.formatted(found.source), key=lambda e: e.range.start.line, reverse=True):
        start, end = offset(found.source, edit.range.start), offset(found.source, edit.range.end)
        text = text[:start] + edit.new_text + text[end:]
    assert text == format_source(found.source)
    assert answers.formatted(analysed("P = = Q").source) == []


def test_lenses() -> None:
    assert [(lens.command.title, lens.range.start.line) for lens in answers.lenses(analysed()) if lens.command] == [
        ("Check", 12),
        ("Probe", 12),
    ]


CLASS = """\
class Counter
  chan tick
  main = tick -> main
  state
    n : 0..3
  init
    n = 0
  op enable_tick where
    n < 3
  op effect_tick
    Delta(n)
  where
    n' = n + 1
end
assert Counter :[divergence free]
"""


def test_classes() -> None:
    found = analysed(CLASS)
    assert found.diagnostics == []
    assert pieces(found, answers.references(found, place(CLASS, "n^ < 3"))) == [
        "5:n",
        "7:n",
        "9:n",
        "11:n",
        "13:n",
        "13:n",
    ]
    assert pieces(found, answers.definitions(found, place(CLASS, "n^ < 3"))) == ["5:n"]
    assert pieces(found, answers.definitions(found, place(CLASS, "assert Count^er"))) == ["1:Counter"]
    outline = answers.symbols(found)
    assert [(s.name, s.kind.name) for s in outline[0].children or ()] == [
        ("main", "Variable"),
        ("enable_tick", "Method"),
        ("effect_tick", "Method"),
        ("n", "Field"),
    ]


@pytest.mark.parametrize("script", sorted((ROOT / "specs").rglob("*.csp")), ids=lambda p: p.name)
def test_every_name_of_the_exhibits_leads_to_a_declaration(script: Path) -> None:
    found = analyse(str(script), script.read_text(encoding="utf-8"))
    if found.names is None:
        return  # a part of another script
    assert found.occurrences
    for occurrence in found.occurrences:
        assert occurrence.span.text == occurrence.name
        builtin = occurrence.symbol is not None and occurrence.symbol.kind.name == "BUILTIN"
        declared = any(other.declares for other in found.of(occurrence.key))
        assert builtin or declared or (occurrence.symbol is not None and found.tree is not None), occurrence


def test_places_count_as_editors_do() -> None:
    text = "-- 𝔸é\nP = STOP\n"
    found = analysed(text)
    assert position(found.source, 5) == types.Position(0, 6)
    for here in range(len(text)):
        assert offset(found.source, position(found.source, here)) == here
    assert path_of(uri_of("/a b/ü.csp")) == "/a b/ü.csp"
