"""``cspcheck examples``: the systems that come with cspcheck."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import click

from cspcheck.cli.streams import StandardOutput
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.spelling import suggestions
from cspcheck.messages import unknown_example, would_overwrite
from cspcheck.report.style import WIDTH, wrapped


def _names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    return [name for name in _examples(specs()) if name.startswith(incomplete)]


@click.command(short_help="List, print or copy the examples that come with cspcheck.")
@click.argument("names", nargs=-1, metavar="[NAME]...", shell_complete=_names)
@click.option(
    "--copy", "folder", type=click.Path(file_okay=False, path_type=Path), metavar="FOLDER", help="Copy to FOLDER."
)
def command(names: tuple[str, ...], folder: Path | None) -> None:
    """List the examples; with NAME print its scripts; with --copy copy it (or all) to FOLDER.

    NAME is an example, as in `rov`, or one of its files, as in `rov/rov.csp`.
    """
    root = specs()
    say = StandardOutput().write
    found = [_find(root, name) for name in names]
    if folder is not None:
        _copy(root, found or [root / name for name in _examples(root)], folder, say)
    elif found:
        scripts = [script for place in found for script in _scripts(place)]
        for script in scripts:
            if len(scripts) > 1:
                say(f"-- {script.relative_to(root).as_posix()}\n")
            say(script.read_text(encoding="utf-8"))
    else:
        width = max(map(len, _examples(root)), default=0)
        for name in _examples(root):
            for line in wrapped(_title(root / name), WIDTH, f"{name:<{width}}  ", " " * (width + 2)):
                say(line + "\n")


def specs() -> Path:
    """The folder of the examples: inside the installed package, or beside it in a source tree."""
    package = Path(__file__).resolve().parent.parent
    inside = package / "specs"
    return inside if inside.is_dir() else package.parent / "specs"


def _examples(root: Path) -> list[str]:
    return sorted(place.name for place in root.glob("*/") if _scripts(place)) if root.is_dir() else []


def _scripts(place: Path) -> list[Path]:
    return [place] if place.is_file() else sorted(place.rglob("*.csp"))


def _find(root: Path, name: str) -> Path:
    place = (root / name).resolve()
    inside = place.is_relative_to(root.resolve()) and place != root.resolve()
    if not inside or not place.exists() or not _scripts(place):
        known = _examples(root)
        raise ScriptError(unknown_example(name, suggestions(name, known)))
    return place


def _title(place: Path) -> str:
    """The first sentence of what an example says of itself: below the title of its page, or in its main script."""
    page = place / "README.md"
    if page.is_file():
        paragraphs = page.read_text(encoding="utf-8").split("\n\n")
        said = " ".join(paragraphs[1].split()) if len(paragraphs) > 1 else ""
        return f"{said} ".partition(". ")[0].strip().removesuffix(".") + "."
    scripts = _scripts(place)
    main = next((script for script in scripts if script.stem == place.name), scripts[0])
    said = ""
    for line in main.read_text(encoding="utf-8").splitlines():
        if not line.startswith(("--", "{-")):
            if said:
                break
            continue
        said = f"{said} {line.strip('{}- ')}".strip()
        sentence, stop, _ = f"{said} ".partition(". ")
        if stop:
            return sentence + "."
    return said


def _copy(root: Path, places: list[Path], folder: Path, say: Callable[[str], object]) -> None:
    """Copy files and folders with their path below the examples, and say where; none if one is there already."""
    copies = [(place, folder / place.relative_to(root)) for place in places]
    for _, target in copies:
        if target.exists():
            raise ScriptError(would_overwrite(str(target)))
    for place, target in copies:
        target.parent.mkdir(parents=True, exist_ok=True)
        if place.is_dir():
            shutil.copytree(place, target)
        else:
            shutil.copyfile(place, target)
        say(f"{target}\n")
