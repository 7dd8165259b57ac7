"""Files: encodings, what is refused, and includes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.parsing.reading import DEEPEST_INCLUDE, MOST_BYTES, parse, parse_expression, read_source
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s


def refusal(path: Path) -> Diagnostic:
    with pytest.raises(ScriptError) as caught:
        parse(read_source(path))
    (diagnostic,) = caught.value.diagnostics
    return diagnostic


class TestReading:
    @pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252"])
    def test_utf_8_and_windows_1252(self, tmp_path: Path, encoding: str) -> None:
        path = tmp_path / "a.csp"
        path.write_bytes('x = "gr\u00fcn"'.encode(encoding))
        assert read_source(path).text == 'x = "gr\u00fcn"'

    @pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
    def test_line_breaks_of_all_systems(self, tmp_path: Path, end: str) -> None:
        path = tmp_path / "a.csp"
        path.write_bytes(f"x = 1 -- one{end}y = 2{end}".encode())
        source = read_source(path)
        assert source.text == "x = 1 -- one\ny = 2\n"
        assert parse(source).declarations[1].span.line == 2

    def test_line_breaks_that_were_not_read_from_a_file(self) -> None:
        script = parse(Source("", "x = 1\r\ny = 2\r\n"))
        assert [declaration.span.line for declaration in script.declarations] == [1, 2]

    def test_the_name_is_the_one_that_was_given(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (tmp_path / "a.csp").write_text("x = 1")
        monkeypatch.chdir(tmp_path)
        assert read_source("a.csp").name == "a.csp"

    def test_a_missing_file(self, tmp_path: Path) -> None:
        diagnostic = refusal(tmp_path / "no.csp")
        assert diagnostic.code == "CSP001"
        assert diagnostic.message == f"cannot read `{tmp_path / 'no.csp'}`: no such file or directory"
        assert diagnostic.span is None

    def test_a_folder(self, tmp_path: Path) -> None:
        assert refusal(tmp_path).message.endswith("is a directory")

    def test_a_name_that_no_file_can_have(self) -> None:
        with pytest.raises(ScriptError, match="CSP001"):
            read_source("a\0b")

    def test_rich_text(self, tmp_path: Path) -> None:
        path = tmp_path / "a.csp"
        path.write_bytes(b"{\\rtf1\\ansi P = STOP}")
        diagnostic = refusal(path)
        assert diagnostic.code == "CSP002"
        assert diagnostic.help == "save the script as plain text and try again"

    @pytest.mark.parametrize("content", [b"x = 1\0", "x = 1".encode("utf-16")])
    def test_bytes_that_are_no_text(self, tmp_path: Path, content: bytes) -> None:
        path = tmp_path / "a.csp"
        path.write_bytes(content)
        assert refusal(path).code == "CSP003"


class TestIncludes:
    def test_are_looked_for_in_the_folder_of_the_root_file(self, tmp_path: Path) -> None:
        (tmp_path / "sub").mkdir()
        (tmp_path / "root.csp").write_text('include "sub/one.csp"\n')
        # Not in the folder of the file that includes.
        (tmp_path / "sub" / "one.csp").write_text('include "two.csp"\ninclude "sub/three.csp"\n')
        (tmp_path / "two.csp").write_text("y = 2\n")
        (tmp_path / "sub" / "three.csp").write_text("z = 3\n")
        script = parse(read_source(tmp_path / "root.csp"))

        one = script.declarations[0]
        assert isinstance(one, s.IncludeDeclaration)
        assert one.path == "sub/one.csp"
        assert [type(d) for d in one.declarations] == [s.IncludeDeclaration, s.IncludeDeclaration]

    def test_can_be_found_by_the_caller(self) -> None:
        texts = {"a": 'include "b"', "b": "x = 1"}
        script = parse(Source("root", 'include "a"'), include=lambda path: Source(path, texts[path]))
        a = script.declarations[0]
        assert isinstance(a, s.IncludeDeclaration)
        assert isinstance(a.declarations[0], s.IncludeDeclaration)

    def test_of_one_file_twice(self) -> None:
        script = parse(Source("root", 'include "a"\ninclude "a"'), include=lambda path: Source(path, ""))
        assert len(script.declarations) == 2

    def test_stand_in_modules_and_timed_sections(self) -> None:
        text = 'module M\n  include "a"\nexports\n  include "a"\nendmodule\nTimed {\n  include "a"\n}\n'
        script = parse(Source("root", text), include=lambda path: Source(path, "-- nothing\n"))
        module, timed = script.declarations
        assert isinstance(module, s.ModuleDeclaration)
        assert isinstance(module.private[0], s.IncludeDeclaration)
        assert isinstance(timed, s.TimedDeclaration)

    def test_of_a_missing_file(self, tmp_path: Path) -> None:
        path = tmp_path / "root.csp"
        path.write_text('x = 1\ninclude "no.csp"\n')
        diagnostic = refusal(path)
        assert diagnostic.code == "CSP010"
        assert diagnostic.message == "cannot include `no.csp`: no such file or directory"
        assert diagnostic.span is not None
        assert (diagnostic.span.line, diagnostic.span.text) == (2, '"no.csp"')

    def test_of_a_binary_file(self, tmp_path: Path) -> None:
        (tmp_path / "b.csp").write_bytes(b"\0")
        path = tmp_path / "root.csp"
        path.write_text('include "b.csp"\n')
        assert refusal(path).code == "CSP010"

    def test_of_each_other(self, tmp_path: Path) -> None:
        (tmp_path / "a.csp").write_text('include "b.csp"\n')
        (tmp_path / "b.csp").write_text('\ninclude "./a.csp"\n')
        diagnostic = refusal(tmp_path / "a.csp")
        assert diagnostic.code == "CSP011"
        assert diagnostic.message == "`./a.csp` includes itself"
        assert diagnostic.span is not None
        assert Path(diagnostic.span.source.name).name == "b.csp"
        assert diagnostic.span.line == 2
        a, b = tmp_path / "a.csp", tmp_path / "b.csp"
        assert diagnostic.notes == (f"`{a}` includes `{b}` includes `{tmp_path / './a.csp'}`",) or diagnostic.notes == (
            f"`{a}` includes `{b}` includes `{tmp_path}/./a.csp`",
        )

    def test_nested_without_end(self) -> None:
        with pytest.raises(ScriptError) as caught:
            parse(Source("0", 'include "1"'), include=lambda path: Source(path, f'include "{int(path) + 1}"'))
        (diagnostic,) = caught.value.diagnostics
        assert diagnostic.code == "CSP012"
        assert diagnostic.span is not None
        assert diagnostic.span.source.name == str(DEEPEST_INCLUDE)

    def test_mistakes_of_all_files_are_reported(self) -> None:
        with pytest.raises(ScriptError) as caught:
            parse(Source("root", 'include "a"\nx = )'), include=lambda path: Source(path, "y = )"))
        assert [d.span.source.name for d in caught.value.diagnostics if d.span] == ["a", "root"]


class TestWhatIsNoFile:
    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes in its file system")
    def test_a_pipe_is_refused_at_once(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe")
        assert refusal(tmp_path / "pipe").message.endswith("it is a device or a pipe, not a file")
        diagnostic = self.including(tmp_path, "pipe")
        assert diagnostic.message == "cannot include `pipe`: it is a device or a pipe, not a file"

    @pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="this system has no such device")
    def test_a_device(self, tmp_path: Path) -> None:
        (tmp_path / "zero").symlink_to("/dev/zero")
        assert refusal(Path("/dev/zero")).message.endswith("it is a device or a pipe, not a file")
        assert "it is not below the folder of the script" in self.including(tmp_path, "zero").message

    def test_a_file_without_measure(self, tmp_path: Path) -> None:
        with open(tmp_path / "large.csp", "wb") as file:
            file.truncate(MOST_BYTES + 1)
        assert refusal(tmp_path / "large.csp").message.endswith("it is larger than 67,108,864 bytes")

    @staticmethod
    def including(folder: Path, path: str) -> Diagnostic:
        (folder / "root.csp").write_text(f'include "{path}"\n')
        return refusal(folder / "root.csp")


class TestWhereIncludesLie:
    """A script names no files of whoever checks it."""

    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        folder = tmp_path / "project" / "specs"
        (folder / "parts").mkdir(parents=True)
        (folder / "parts" / "one.csp").write_text("x = 1\n")
        (tmp_path / "project" / "common.csp").write_text("y = 2\n")
        (tmp_path / "secret").write_text("password\n")
        return folder

    @pytest.mark.parametrize("path", ["parts/one.csp", "./parts/../parts/one.csp", "../specs/parts/one.csp"])
    def test_below_its_folder(self, path: str, folder: Path) -> None:
        (folder / "root.csp").write_text(f'include "{path}"\n')
        assert parse(read_source(folder / "root.csp")).declarations

    @pytest.mark.parametrize("path", ["../common.csp", "../../secret", "SECRET", "link"])
    def test_nowhere_else(self, path: str, folder: Path) -> None:
        secret = folder.parents[1] / "secret"
        (folder / "link").symlink_to(secret)
        (folder / "root.csp").write_text(f'include "{path.replace("SECRET", str(secret))}"\n')
        diagnostic = refusal(folder / "root.csp")
        assert diagnostic.code == "CSP010"
        assert diagnostic.message.endswith(": it is not below the folder of the script")
        assert diagnostic.help == "`--include-root FOLDER` allows includes from below another folder, too"

    def test_below_a_folder_that_is_allowed(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        (folder / "root.csp").write_text('include "../common.csp"\n')
        assert parse(read_source(folder / "root.csp"), include_roots=[str(folder.parent)]).declarations
        monkeypatch.chdir(folder)
        assert parse(read_source("root.csp"), include_roots=[".."]).declarations
        with pytest.raises(ScriptError):
            parse(read_source("root.csp"), include_roots=["parts"])


def test_an_expression_alone_includes_nothing() -> None:
    with pytest.raises(ScriptError) as caught:
        parse_expression('let include "x"\nwithin 1')
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["CSP010"]
