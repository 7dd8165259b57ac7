"""What becomes of files that are there already: generated ones are written anew, a person's are never touched.

A generation leaves a list of what it wrote (``.cspcheck-gen.json``: file names with digests of their contents). So the
next one can tell a generated file from one that a person has edited, and a folder of its own from another. Everything
is looked at before anything is written.

The folder may be somebody else's, and so may the list in it: a name in it that leads anywhere but into the folder stops
the generation, and nothing is written through a link.
"""

from __future__ import annotations

import ast
import difflib
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from cspcheck.codegen import messages
from cspcheck.codegen.emit.project import RUNTIME, ProjectFiles
from cspcheck.codegen.emit.signatures import heads_in
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError

LIST = ".cspcheck-gen.json"
FOLDERS = (RUNTIME, "posix", "desk")
"""The folders in a program: of what it runs on."""
_PLAIN = re.compile(rf"(?:(?:{'|'.join(FOLDERS)})/)?\w[\w.-]*")
"""The names that a generation gives: a file of the folder, or of those in it."""


@dataclass
class Written:
    """What a generation did, by file name; ``warnings`` are about files that do not fit any more."""

    written: list[str] = field(default_factory=list)
    unchanged: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    removed: list[str] = field(default_factory=list)
    saved: list[str] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)


def write(project: ProjectFiles, folder: str | os.PathLike[str], *, force: bool = False) -> Written:
    """Write a program into a folder.

    Args:
        project: the texts.
        folder: made if it is not there.
        force: whether generated files that were edited may be replaced; the edited ones stay as ``NAME.edited``.

    Raises:
        ScriptError: files are in the way that a person made or edited; nothing was written.
        OSError: the folder cannot be written.
    """
    place = Path(folder)
    _check_links(place)
    before = _read_list(place)
    _check_folder(project, place, before)
    edited = [name for name, digest in before.items() if _digest_of(place / name) not in (digest, None)]
    edited = [name for name in edited if project.generated.get(name) != _text_of(place / name)]
    if edited and not force:
        raise ScriptError(messages.edited(sorted(edited)))
    result = Written()
    for name, text in project.yours.items():
        if (place / name).exists():
            result.kept.append(name)
            interface = project.interfaces.get(name)
            mine = _text_of(place / name)
            warning = _unlike(name, mine, text) if interface is None else _misfit(name, mine, interface)
            if warning is not None:
                result.warnings.append(warning)
    place.mkdir(parents=True, exist_ok=True)
    for name in edited:
        saved = _free_name(place, name)
        os.replace(place / name, place / saved)
        result.saved.append(saved)
    for name, text in project.generated.items():
        if _text_of(place / name) == text:
            result.unchanged.append(name)
        else:
            _replace(place / name, text)
            result.written.append(name)
    for name, text in project.yours.items():
        if not (place / name).exists():
            _replace(place / name, text)
            result.written.append(name)
    for name in before:
        if name not in project.generated and (place / name).exists():
            (place / name).unlink()
            result.removed.append(name)
    digests = {name: _digest(text) for name, text in sorted(project.generated.items())}
    _replace(place / LIST, json.dumps({"generated": digests}, indent=2) + "\n")
    return result


def _read_list(place: Path) -> dict[str, str]:
    """The generated files with the digests that they had; none if the folder is not of a generation.

    Raises:
        ScriptError: a name in it is none that a generation gives.
    """
    try:
        listed = json.loads((place / LIST).read_text(encoding="utf-8"))["generated"]
        found = {str(name): str(digest) for name, digest in listed.items()}
    except (OSError, ValueError, KeyError, AttributeError, TypeError, RecursionError):
        return {}
    strange = sorted(name for name in found if _PLAIN.fullmatch(name) is None)
    if strange:
        raise ScriptError(messages.strange_list(str(place / LIST), strange))
    return found


def _check_links(place: Path) -> None:
    """Make sure that what a generation reads and writes in a folder is there and not elsewhere.

    Raises:
        ScriptError: the list, or the folder of the runtime, is a link.
    """
    links = [name for name in (LIST, *FOLDERS) if (place / name).is_symlink()]
    if links:
        raise ScriptError(messages.foreign_folder(str(place), [f"{name} (a link)" for name in links]))


def _check_folder(project: ProjectFiles, place: Path, before: Mapping[str, str]) -> None:
    """Make sure that no generated file takes the place of one that was not generated.

    Raises:
        ScriptError: it would.
    """
    foreign = [
        name
        for name, text in project.generated.items()
        if name not in before and (place / name).exists() and _text_of(place / name) != text
    ]
    if not before:
        foreign += [name for name in project.yours if (place / name).exists() and (place / LIST).exists() is False]
    if foreign:
        raise ScriptError(messages.foreign_folder(str(place), sorted(foreign)))


def _misfit(name: str, text: str | None, interface: Mapping[str, str]) -> Diagnostic | None:
    """What a person's file lacks, or has too much of, for its task."""
    found = methods_in(text or "")
    if found is None:
        return messages.interface_changed(name, ["it has no class `Methods`, or is no Python"])
    missing = {method: signature for method, signature in interface.items() if found.get(method) != signature}
    surplus = [method for method in found if method not in interface and not method.startswith("_")]
    if not missing and not surplus:
        return None
    have = [f"def {signature}" for method, signature in found.items() if method in missing or method in surplus]
    want = [f"def {signature}" for signature in missing.values()]
    lines = [line for line in difflib.ndiff(have, want) if not line.startswith("?")]
    return messages.interface_changed(name, lines)


def _unlike(name: str, mine: str | None, fresh: str) -> Diagnostic | None:
    """What a person's file in C or Ada lacks of the functions that it would be given today.

    A function too much is nobody's business: it may be a helper.
    """
    found = heads_in(name, mine or "")
    want = heads_in(name, fresh)
    wrong = [one for one, head in want.items() if one not in found or found[one].shape != head.shape]
    if not wrong:
        return None
    have = [found[one].shown for one in wrong if one in found]
    lines = [line for line in difflib.ndiff(have, [want[one].shown for one in wrong]) if not line.startswith("?")]
    return messages.interface_changed(name, lines)


def methods_in(text: str) -> dict[str, str] | None:
    """The methods of the class ``Methods`` of a file with their signatures; None if there is no such class."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return None
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name == "Methods":
            return {one.name: _signature(one) for one in node.body if isinstance(one, ast.FunctionDef)}
    return None


def _signature(function: ast.FunctionDef) -> str:
    returns = "" if function.returns is None else f" -> {ast.unparse(function.returns)}"
    return f"{function.name}({ast.unparse(function.args)}){returns}"


def _free_name(place: Path, name: str) -> str:
    """A name beside *name* that no file has."""
    candidate, count = f"{name}.edited", 2
    while (place / candidate).exists():
        candidate, count = f"{name}.edited{count}", count + 1
    return candidate


def _replace(path: Path, text: str) -> None:
    """Write a file whole or not at all; a link of that name is replaced, not followed."""
    path.parent.mkdir(exist_ok=True)
    # A name that nobody can have put there before, opened so that it must be new.
    descriptor, new = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".new", dir=path.parent)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        os.chmod(new, 0o666 & ~_umask())
        os.replace(new, path)
    except BaseException:
        os.unlink(new)
        raise


def write_whole(path: str | os.PathLike[str], text: str) -> None:
    """Write a file whole or not at all; a link of that name is replaced, not followed.

    Raises:
        OSError: it cannot be written.
    """
    _replace(Path(path), text)


def _umask() -> int:
    """The mode bits that the user wants new files not to have."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _text_of(path: Path) -> str | None:
    try:
        return path.read_bytes().decode("utf-8", "surrogateescape")
    except OSError:
        return None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def _digest_of(path: Path) -> str | None:
    text = _text_of(path)
    return None if text is None else _digest(text)


def orphans(project: ProjectFiles, folder: str | os.PathLike[str]) -> Iterable[str]:
    """Methods files in a folder whose task is not in the program any more."""
    place = Path(folder)
    return sorted(
        path.name
        for path in place.glob("*_methods.py")
        if path.name not in project.yours and path.name not in project.generated
    )
