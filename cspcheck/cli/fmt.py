"""``cspcheck fmt FILE...``: scripts in the standard layout."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from difflib import unified_diff
from pathlib import Path
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import files_argument


@click.command(short_help="Print scripts in the standard layout, or rewrite them.")
@files_argument
@click.option("-i", "--in-place", is_flag=True, help="Rewrite the files, each whole or not at all.")
@click.option("--check", is_flag=True, help="Write nothing; name the files that would change, exit 1 if there are any.")
@click.option("--diff", is_flag=True, help="Write nothing; show what would change.")
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour of errors.")
def command(files: tuple[str, ...], in_place: bool, check: bool, diff: bool, color: Any) -> None:
    """Print scripts in the standard layout. Comments are kept.

    FILE is a CSPm script, a folder (every .csp file below it), or `-` for standard input.
    """
    from cspcheck.checking import STDIN_NAME, read
    from cspcheck.cli.streams import Remarks, StandardOutput, replace_text
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.cspm.printing.formatter import format_source
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import harmless, style_for
    from cspcheck.result import Exit
    from cspcheck.selection import STDIN

    say = StandardOutput().write
    remarks = Remarks()
    code = Exit.OK
    for path in _files(files):
        try:
            source = read(path)
            text = format_source(source)
            if diff:
                say("".join(_difference(source.text, text, path)))
            if check and text != source.text:
                remarks.write(f"would change {harmless(path) if path != STDIN else STDIN_NAME}\n")
                code = max(code, Exit.FAILED)
            if in_place and path != STDIN and not check and not diff:
                original = Path(path).read_bytes()
                if text != source.text:
                    replace_text(path, _with_its_line_breaks(text, original), _encoding(path, original))
            elif not check and not diff:
                say(text)
        except ScriptError as error:
            remarks.write(render_diagnostics(error.diagnostics, style_for(remarks.stream, color)))
            code = Exit.NOT_RUN
    finish(code)


def _files(arguments: Iterable[str]) -> Iterator[str]:
    """The files that are meant: folders stand for every script below them, those that others include as well."""
    from cspcheck.selection import all_below

    for argument in dict.fromkeys(arguments):
        if os.path.isdir(argument):
            yield from all_below(argument)
        else:
            yield argument


def _difference(old: str, new: str, path: str) -> Iterator[str]:
    """The lines of a unified diff."""
    for line in unified_diff(old.splitlines(keepends=True), new.splitlines(keepends=True), path, path):
        yield line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"


def _with_its_line_breaks(text: str, original: bytes) -> str:
    return text.replace("\n", "\r\n") if b"\r\n" in original else text


def _encoding(path: str, original: bytes) -> str:
    """The encoding that a file is kept in: UTF-8 (with its mark, if it has one), or else Windows-1252.

    Raises:
        ScriptError: the file is in neither, and would lose something.
    """
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import cannot_write

    for encoding in ("utf-8", "cp1252"):
        try:
            original.decode(encoding)
        except UnicodeDecodeError:
            continue
        return "utf-8-sig" if original.startswith(b"\xef\xbb\xbf") else encoding
    raise ScriptError(cannot_write(path, "it is neither UTF-8 nor Windows-1252, and would lose characters"))
