"""Settings of a project: the table ``[tool.cspcheck]`` of the nearest ``pyproject.toml``.

They are defaults of options: what the command line says wins. The file is looked for from the folder of the script
upwards, then from the current folder; one without the table is passed over.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.messages import unknown_setting, unreadable_settings, wrong_setting
from cspcheck.quantities import parse_duration, parse_size
from cspcheck.report import FORMATS
from cspcheck.report.style import ColorChoice

FILE = "pyproject.toml"


@dataclass(frozen=True, slots=True)
class Configuration:
    """What a project says.

    Attributes:
        path: the file; None where there is none.
        settings: values by the names of the command's parameters (``max_states``, ``form``).
        definitions: top-level constants to override, as CSPm text.
    """

    path: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    definitions: Mapping[str, str] = field(default_factory=dict)


def configuration_for(script: str | None) -> Configuration:
    """The settings for a script, or for the current folder.

    Args:
        script: the path of a script or folder; None or ``-`` where there is none.

    Raises:
        ScriptError: the table says something that means nothing.
    """
    for path in _candidates(script):
        # A file that cannot be read may be the one with our settings: to go on without them would be to guess.
        try:
            content = path.read_bytes()
        except (FileNotFoundError, NotADirectoryError):
            continue
        except OSError as error:
            raise ScriptError(unreadable_settings(_shown(path), error.strerror or str(error))) from None
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise ScriptError(unreadable_settings(_shown(path), f"it is not UTF-8: {error.reason}")) from None
        source = Source(_shown(path), text)
        try:
            whole = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            raise ScriptError(unreadable_settings(source.name, str(error))) from None
        tools = whole.get("tool", {})
        table = tools.get("cspcheck") if isinstance(tools, dict) else None
        if table is not None and not isinstance(table, dict):
            raise ScriptError(wrong_setting("tool.cspcheck", f"{_toml(table)} is not a table", None))
        if table is not None:
            return _read(table, source)
    return Configuration()


def _candidates(script: str | None) -> Iterator[Path]:
    """Where the file may be, nearest first."""
    starts = [Path.cwd()]
    if script is not None and script != "-":
        place = Path(os.path.abspath(script))
        starts.insert(0, place if place.is_dir() else place.parent)
    seen: set[Path] = set()
    for start in starts:
        for folder in (start, *start.parents):
            if folder not in seen:
                seen.add(folder)
                yield folder / FILE


def _shown(path: Path) -> str:
    try:
        return str(path.relative_to(Path.cwd()))
    except ValueError:
        return str(path)


def _read(table: Mapping[str, Any], source: Source) -> Configuration:
    settings: dict[str, Any] = {}
    definitions: dict[str, str] = {}
    wrong: list[Diagnostic] = []
    for key, value in table.items():
        place = _place(source, key)
        if key == "definitions":
            wrong += _read_definitions(value, source, definitions)
            continue
        if key not in _SETTINGS:
            wrong.append(unknown_setting(key, suggestions(key, [*_SETTINGS, "definitions"]), sorted(_SETTINGS), place))
            continue
        parameter, read = _SETTINGS[key]
        try:
            settings[parameter] = read(value)
        except ValueError as error:
            wrong.append(wrong_setting(key, str(error), place))
    if wrong:
        raise ScriptError(*wrong)
    if "include_roots" in settings:
        # Folders are named as seen from the file that names them.
        here = os.path.dirname(source.name)
        settings["include_roots"] = tuple(os.path.join(here, folder) for folder in settings["include_roots"])
    return Configuration(source.name, settings, definitions)


def _read_definitions(value: Any, source: Source, definitions: dict[str, str]) -> Iterator[Diagnostic]:
    if not isinstance(value, dict):
        yield wrong_setting("definitions", f"{_toml(value)} is not a table of names", _place(source, "definitions"))
        return
    for name, text in value.items():
        if isinstance(text, bool):
            definitions[name] = "true" if text else "false"
        elif isinstance(text, int) or (isinstance(text, str) and text.strip()):
            definitions[name] = str(text).strip()
        else:
            message = f"{_toml(text)} is not a number, a truth value or text in CSPm"
            yield wrong_setting(f"definitions.{name}", message, _place(source, name))


def _flag(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    raise ValueError(f"{_toml(value)} is not true or false")


def _times(value: Any) -> int:
    if isinstance(value, int) and value >= 0:
        return int(value)
    raise ValueError(f"{_toml(value)} is not true, false or how many times")


def _above_zero(value: Any) -> int:
    if isinstance(value, int) and not isinstance(value, bool) and value > 0:
        return value
    raise ValueError(f"{_toml(value)} is not a whole number above zero")


def _quantity(parse: Callable[[str], float | int], what: str) -> Callable[[Any], float | int]:
    def read(value: Any) -> float | int:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError(f"{_toml(value)} is not {what}")
        return parse(str(value))

    return read


def _folders(value: Any) -> tuple[str, ...]:
    named = [value] if isinstance(value, str) else value
    if isinstance(named, list) and named and all(isinstance(folder, str) and folder for folder in named):
        return tuple(named)
    raise ValueError(f"{_toml(value)} is not a folder or a list of folders")


def _one_of(choices: tuple[str, ...]) -> Callable[[Any], str]:
    def read(value: Any) -> str:
        if value in choices:
            return str(value)
        raise ValueError(f"{_toml(value)} is none of {', '.join(choices)}")

    return read


_SETTINGS: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "format": ("form", _one_of(FORMATS)),
    "timeout": ("timeout", _quantity(parse_duration, "a time")),
    "max-memory": ("max_memory", _quantity(parse_size, "a size")),
    "max-states": ("max_states", _above_zero),
    "workers": ("workers", _above_zero),
    "full": ("full", _flag),
    "as-written": ("as_written", _flag),
    "termination": ("termination", _one_of(("success", "deadlock"))),
    "typecheck": ("typecheck", _flag),
    "view": ("view", _one_of(("data", "control"))),
    "outputs": ("outputs", _one_of(("demonic", "angelic"))),
    "color": ("color", _one_of(get_args(ColorChoice))),
    "quiet": ("quiet", _times),
    "verbose": ("verbose", _times),
    "include-root": ("include_roots", _folders),
}
"""The keys beside ``definitions``, each with the parameter that it is the default of and what reads its value."""

KEYS = (*_SETTINGS, "definitions")
"""The keys of the table."""


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "`true`" if value else "`false`"
    return f"`{value}`"


def _place(source: Source, key: str) -> Span | None:
    """Where a key stands below the table's head; TOML readers do not tell."""
    head = re.search(r"^\s*\[\s*tool\s*\.\s*cspcheck\b.*$", source.text, re.MULTILINE)
    start = head.end() if head else 0
    found = re.compile(rf"""^\s*(["']?{re.escape(key)}["']?)\s*=""", re.MULTILINE).search(source.text, start)
    if found is None and head is not None:
        # A table of its own: [tool.cspcheck.definitions].
        found = re.compile(rf"\b({re.escape(key)})\b").search(source.text, head.start())
    return None if found is None else source.span(*found.span(1))
