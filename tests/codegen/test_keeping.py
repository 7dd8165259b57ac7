"""Generating again: what a person wrote is never lost, and what does not fit is said."""

from __future__ import annotations

import hashlib
import json
import tempfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

import cspcheck
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.codegen.design.program import design
from cspcheck.codegen.design.system import system
from cspcheck.codegen.emit import ada, freertos
from cspcheck.codegen.emit.keeping import LIST, Written, orphans, write
from cspcheck.codegen.emit.project import ProjectFiles, project
from tests.examples import examples

ONE = """
channel link : {0..3}
channel make, use
Maker = make -> link!1 -> Maker
User = link?x -> use -> User
SYSTEM = Maker [| {| link |} |] User
"""
TWO = """
channel link : {0..3}
channel make : {0..3}
channel use, rest
Maker = make?x -> link!x -> rest -> Maker
User = link?x -> use -> User
Other = rest -> Other
SYSTEM = Maker [| {| link |} |] User
"""
THREE = """
channel link : {0..3}
channel use
Sender = link!1 -> Sender
User = link?x -> use -> User
SYSTEM = Sender [| {| link |} |] User
"""


def texts(script: str) -> ProjectFiles:
    return project(design(cspcheck.loads(script)._script, "SYSTEM"), "program")


def contents(folder: Path) -> dict[str, bytes]:
    """What is in the files of a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


PROJECTS = {text: texts(text) for text in (ONE, TWO, THREE)}


def test_a_second_generation_of_the_same_writes_nothing(tmp_path: Path) -> None:
    first = write(texts(ONE), tmp_path)
    assert "maker_methods.py" in first.written
    again = write(texts(ONE), tmp_path)
    assert again == Written(unchanged=again.unchanged, kept=["maker_methods.py", "user_methods.py"])
    assert sorted(again.unchanged) == sorted(texts(ONE).generated)


def test_a_changed_interface_is_shown_and_not_touched(tmp_path: Path) -> None:
    write(texts(ONE), tmp_path)
    mine = (tmp_path / "maker_methods.py").read_text() + "\n# mine\n"
    (tmp_path / "maker_methods.py").write_text(mine)
    result = write(texts(TWO), tmp_path)
    (warning,) = result.warnings
    assert warning.code == "CSP809"
    assert warning.message == "`maker_methods.py` does not fit the specification any more"
    assert warning.notes == ("- def make(self) -> None\n+ def make(self) -> int\n+ def rest(self) -> None",)
    assert (tmp_path / "maker_methods.py").read_text() == mine


MADE = "channel make, link, show : {0..3}\nMaker = make?x -> link!x -> Maker\nUser = link?x -> show!x -> User\n"
PAIRS = MADE.replace("make, link, show : {0..3}", "make, link : {0..3}\nchannel show : {0..3}.{0..3}").replace(
    "show!x", "show!x!x"
)
COMPOSED = "SYSTEM = Maker [| {| link |} |] User\n"


@pytest.mark.parametrize(
    ("target", "file", "difference"),
    [
        (
            "freertos",
            "methods.c",
            ("- void user_show(int32_t it)", "+ void user_show(int32_t field_1, int32_t field_2)"),
        ),
        (
            "ada",
            "methods.adb",
            ("- procedure User_show (It : Type_0)", "+ procedure User_show (Field_1 : Type_0; Field_2 : Type_0)"),
        ),
    ],
)
def test_a_changed_interface_in_c_and_ada_is_shown_too(
    target: str, file: str, difference: tuple[str, str], tmp_path: Path
) -> None:
    def written(text: str) -> Written:
        script = cspcheck.loads(text + COMPOSED)._script
        made = system(script, "SYSTEM", Semantics())
        return write(ada.project(made, "o", script) if target == "ada" else freertos.project(made, "o"), tmp_path)

    assert written(MADE).warnings == []
    mine = (tmp_path / file).read_text().replace("field_1", "it").replace("User_show (Field_1", "User_show (It")
    (tmp_path / file).write_text(mine + ("\nstatic void helper(void)\n{\n}\n" if target == "freertos" else ""))
    assert written(MADE).warnings == []  # names of parameters are the person's own, and so are helpers
    (warning,) = written(PAIRS).warnings
    assert (warning.code, warning.notes) == ("CSP809", ("\n".join(difference),))


def test_a_task_that_is_gone_leaves_its_methods(tmp_path: Path) -> None:
    write(texts(ONE), tmp_path)
    result = write(texts(THREE), tmp_path)
    assert result.removed == ["maker.py"]
    assert (tmp_path / "maker_methods.py").exists()
    assert list(orphans(texts(THREE), tmp_path)) == ["maker_methods.py"]


def test_an_edited_generated_file_stops_everything(tmp_path: Path) -> None:
    write(texts(ONE), tmp_path)
    (tmp_path / "maker.py").write_text("# edited\n")
    before = contents(tmp_path)
    for script in (ONE, TWO, THREE):
        with pytest.raises(cspcheck.ScriptError, match=r"CSP808: .maker\.py. was edited since"):
            write(texts(script), tmp_path)
    assert contents(tmp_path) == before
    assert write(texts(TWO), tmp_path, force=True).saved == ["maker.py.edited"]
    assert (tmp_path / "maker.py.edited").read_text() == "# edited\n"


def test_a_folder_with_other_things_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "main.py").write_text("print('mine')\n")
    (tmp_path / "user_methods.py").write_text("# mine\n")
    with pytest.raises(cspcheck.ScriptError, match=r"CSP810: .* has `main.py`, `user_methods.py` in it"):
        write(texts(ONE), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["main.py", "user_methods.py"]


@settings(max_examples=examples(60))
@given(st.data())
def test_nothing_that_a_person_wrote_is_ever_lost(data: st.DataObject) -> None:
    """Edit anything, change the script, generate again, with force or without: every line is still in some file."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(PROJECTS[ONE], folder)
        marks: list[str] = []
        for _ in range(data.draw(st.integers(1, 5))):
            files = sorted(path for path in folder.rglob("*") if path.is_file() and not path.name.startswith("."))
            path = data.draw(st.sampled_from(files))
            mark = f"# mine {len(marks)}"
            if data.draw(st.booleans()):
                path.write_text(path.read_text() + mark + "\n")
            else:
                (folder / f"helper_{len(marks)}.py").write_text(mark + "\n")
            marks.append(mark)
            script = data.draw(st.sampled_from(sorted(PROJECTS)))
            with suppress(cspcheck.ScriptError):
                write(PROJECTS[script], folder, force=data.draw(st.booleans()))
            everything = "\n".join(path.read_text() for path in folder.rglob("*") if path.is_file())
            assert [mark for mark in marks if mark not in everything] == []


class TestAFolderThatSomebodyElsePrepared:
    """It cannot make a generation write, rename or remove anything outside."""

    @pytest.mark.parametrize(
        "name", ["../precious.txt", "a/b.py", "runtime/../../precious.txt", "..", "", "{absolute}"]
    )
    @pytest.mark.parametrize("right", [True, False])
    def test_a_list_with_other_names_stops_everything(self, name: str, right: bool, tmp_path: Path) -> None:
        precious = tmp_path / "precious.txt"
        precious.write_text("mine\n")
        digest = hashlib.sha256(b"mine\n" if right else b"other").hexdigest()
        folder = tmp_path / "program"
        folder.mkdir()
        listed = {"generated": {name.format(absolute=precious): digest}}
        (folder / LIST).write_text(json.dumps(listed))
        with pytest.raises(cspcheck.ScriptError, match="CSP813"):
            write(texts(ONE), folder, force=True)
        assert contents(tmp_path) == {"precious.txt": b"mine\n", f"program/{LIST}": json.dumps(listed).encode()}

    def test_nothing_is_written_through_a_link(self, tmp_path: Path) -> None:
        precious = tmp_path / "precious.txt"
        precious.write_text("mine\n")
        folder = tmp_path / "program"
        write(texts(ONE), folder)
        for name in ("main.py", ".main.py.new", "maker_methods.py.new"):
            (folder / name).unlink(missing_ok=True)
            (folder / name).symlink_to(precious)
        with suppress(cspcheck.ScriptError):
            write(texts(TWO), folder, force=True)
        write(texts(TWO), folder, force=True)
        assert precious.read_text() == "mine\n"
        assert not (folder / "main.py").is_symlink()

    @pytest.mark.parametrize("name", [LIST, "runtime"])
    def test_a_linked_list_or_runtime_is_foreign(self, name: str, tmp_path: Path) -> None:
        folder = tmp_path / "program"
        folder.mkdir()
        (tmp_path / "elsewhere").mkdir()
        (folder / name).symlink_to(tmp_path / "elsewhere")
        with pytest.raises(cspcheck.ScriptError, match="CSP810"):
            write(texts(ONE), folder)
        assert list((tmp_path / "elsewhere").iterdir()) == []
