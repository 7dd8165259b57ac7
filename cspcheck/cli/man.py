"""``cspcheck man [VERB]``: the manual."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import click

from cspcheck import __version__
from cspcheck.cli import VERBS, finish, front_door
from cspcheck.cli.streams import StandardOutput, replace_text
from cspcheck.report.style import is_terminal


def _names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    return [verb for verb in VERBS if verb.startswith(incomplete)]


@click.command(short_help="Show the manual of the command or of a verb.")
@click.argument("verb", required=False, shell_complete=_names)
@click.option("--folder", type=click.Path(file_okay=False), metavar="FOLDER", help="Write all pages to FOLDER.")
def command(verb: str | None, folder: str | None) -> None:
    """Show the manual page of VERB, or of the command.

    On a terminal `man` shows it; elsewhere it is written as roff. `--folder ~/.local/share/man/man1` installs all
    pages, so that `man cspcheck` and `man cspcheck-check` find them.
    """
    if verb is not None and verb not in VERBS:
        raise click.UsageError(f"there is no verb `{verb}`; there are {', '.join(VERBS)}")
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
        for name, text in pages().items():
            replace_text(str(Path(folder) / f"{name}.1"), text)
        StandardOutput().write(f"{len(VERBS) + 1} pages in {folder}\n")
        return
    text = _page(verb)
    if is_terminal(sys.stdout) and shutil.which("man"):
        with tempfile.TemporaryDirectory() as place:
            file = Path(place) / "cspcheck.1"
            file.write_text(text, encoding="utf-8")
            finish(subprocess.run(["man", str(file)], check=False).returncode)
    StandardOutput().write(text)


def pages() -> dict[str, str]:
    """All manual pages, by name."""
    from cspcheck.report.manual import page_name

    return {"cspcheck": _page(None)} | {page_name(verb): _page(verb) for verb in VERBS}


def _page(verb: str | None) -> str:
    from cspcheck.report.manual import main_page, verb_page

    if verb is None:
        return main_page(front_door, VERBS, __version__)
    # The context of the command says how help is asked for, which click keeps in the verb for good.
    with front_door.make_context("cspcheck", [verb], resilient_parsing=True) as context:
        found = front_door.get_command(context, verb)
        assert found is not None
        return verb_page(verb, VERBS[verb], found, context, __version__)
