"""Scripts as tests: one item for each assertion, and the fixture ``csp``.

pytest loads this module in every run of everybody who has cspcheck installed. It therefore imports nothing of ours,
and nothing large, until there is a script to collect.

``.csp`` files are collected where the command line names them or a folder that they are in. With the ini option
``csp_files`` set, files in folders are collected where one of its patterns matches, however the folder came to be
searched; files that are named are collected all the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from _pytest._code.code import ReprFileLocation, TerminalRepr

if TYPE_CHECKING:
    from _pytest._io import TerminalWriter

    from cspcheck.api import Script
    from cspcheck.checking import GuardedChecker, Settings
    from cspcheck.cli.interrupt import Interrupts
    from cspcheck.cspm import script
    from cspcheck.result import Result

SUFFIX = ".csp"
DOCUMENT = ".tex"
"""LaTeX documents with classes are collected where they are named, not from folders: most have none."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options and the ini setting."""
    group = parser.getgroup("csp", "CSPm scripts (cspcheck)")
    group.addoption("--csp-full", action="store_true", help="explore the whole state space of every assertion")
    group.addoption("--csp-timeout", metavar="TIME", help="give up an assertion after TIME (90s, 5m, 1h)")
    group.addoption("--csp-max-states", metavar="N", help="give up an assertion with more than N states")
    group.addoption("--csp-max-memory", metavar="SIZE", help="give up an assertion that needs more (512MiB, 8GiB)")
    group.addoption("--csp-workers", metavar="N", help="search threads (default: the machine's cores)")
    group.addoption(
        "--csp-define", metavar="NAME=EXPR", action="append", default=[], help="override a constant of the scripts"
    )
    group.addoption("--csp-no-typecheck", action="store_true", help="skip the type checker")
    group.addoption("--csp-view", choices=["data", "control"], help="read classes with their data, or without")
    group.addoption(
        "--csp-outputs", choices=["demonic", "angelic"], help="who chooses the outputs of classes (default: demonic)"
    )
    parser.addini(
        "csp_files",
        "patterns of the .csp files to collect from folders, relative to the root folder (specs/**/*.csp)",
        type="args",
        default=None,
    )


def pytest_configure(config: pytest.Config) -> None:
    """Refuse options that mean nothing before anything runs."""
    if any(config.getoption(name) for name in ("csp_timeout", "csp_max_states", "csp_max_memory", "csp_workers")) or (
        config.getoption("csp_define")
    ):
        _settings(config)


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> ScriptFile | None:
    """A script, if it is one that is meant."""
    if file_path.suffix == DOCUMENT:
        meant = file_path in _named(parent.config)
    else:
        meant = file_path.suffix == SUFFIX and _is_meant(file_path, parent.config)
    if not meant:
        return None
    return ScriptFile.from_parent(parent, path=file_path)


def _is_meant(path: Path, config: pytest.Config) -> bool:
    named = _named(config)
    if path in named:
        return True
    patterns = config.getini("csp_files")
    if patterns is not None:
        try:
            relative = path.relative_to(config.rootpath).as_posix()
        except ValueError:
            return False
        return any(_matches(relative, pattern) for pattern in patterns)
    folders = [folder for folder in named if folder in path.parents]
    return bool(folders) and not any(path in _included_below(folder, config) for folder in folders)


def _named(config: pytest.Config) -> list[Path]:
    """The files and folders that the command line names; none if it names nothing and ``testpaths`` decides."""
    if config.args_source is not pytest.Config.ArgsSource.ARGS:
        return []
    base = config.invocation_params.dir
    return [Path(os.path.abspath(base / argument.split("::", 1)[0])) for argument in config.args]


def _matches(path: str, pattern: str) -> bool:
    """Whether a relative path matches, where ``**/`` also stands for no folder at all."""
    return fnmatch(path, pattern) or ("**/" in pattern and fnmatch(path, pattern.replace("**/", "")))


_INCLUDED: pytest.StashKey[dict[Path, frozenset[Path]]] = pytest.StashKey()


def _included_below(folder: Path, config: pytest.Config) -> frozenset[Path]:
    """The scripts below a folder that others there include: they are parts of those, not tests of their own."""
    known = config.stash.setdefault(_INCLUDED, {})
    if folder not in known:
        from cspcheck.selection import all_below, scripts_below

        whole = set(scripts_below(str(folder)))
        known[folder] = frozenset(Path(path) for path in all_below(str(folder)) if path not in whole)
    return known[folder]


def _settings(config: pytest.Config, script: Path | None = None) -> Settings:
    """How scripts are to be checked: as the options say, else as the project of *script* says.

    Raises:
        pytest.UsageError: an option has a value that means nothing.
        ScriptError: so has a setting of the project.
    """
    from cspcheck.checking import Settings, limits
    from cspcheck.configuration import Configuration, configuration_for
    from cspcheck.quantities import parse_duration, parse_size

    project = Configuration() if script is None else configuration_for(str(script))
    said = project.settings
    try:
        seconds, size = config.getoption("csp_timeout"), config.getoption("csp_max_memory")
        definitions = dict(project.definitions)
        for definition in config.getoption("csp_define"):
            name, equals, expression = definition.partition("=")
            if not equals or not name.strip() or not expression.strip():
                raise ValueError(f"`{definition}` is not NAME=EXPR")
            definitions[name.strip()] = expression.strip()
        return Settings(
            limits=limits(
                _positive("--csp-max-states", config.getoption("csp_max_states")) or said.get("max_states"),
                said.get("timeout") if seconds is None else parse_duration(seconds),
                said.get("max_memory") if size is None else parse_size(size),
            ),
            workers=_positive("--csp-workers", config.getoption("csp_workers")) or said.get("workers"),
            full=config.getoption("csp_full") or said.get("full", False),
            as_written=said.get("as_written", False),
            termination=said.get("termination", "success"),
            definitions=definitions,
            typecheck=not config.getoption("csp_no_typecheck") and said.get("typecheck", True),
            view=config.getoption("csp_view") or said.get("view"),
            outputs=config.getoption("csp_outputs") or said.get("outputs", "demonic"),
            include_roots=said.get("include_roots", ()),
        )
    except ValueError as error:
        raise pytest.UsageError(f"cspcheck: {error}") from None


def _positive(option: str, text: str | None) -> int | None:
    if text is None:
        return None
    from cspcheck.quantities import whole_number

    number = whole_number(text)
    if not number:
        raise ValueError(f"{option} wants a whole number above zero, not `{text}`")
    return number


class ScriptFile(pytest.File):
    """A script. Its items share one checker, and with it the machines of their processes."""

    _loaded: script.Script
    _checker: GuardedChecker | None = None
    _interrupts: Interrupts

    def collect(self) -> Iterator[AssertionItem]:
        """One item for each assertion; a second one with the same text has its line in its name."""
        from cspcheck.checking import load
        from cspcheck.cspm.diagnostics import ScriptError
        from cspcheck.report.style import harmless

        name = _shown(self.path)
        try:
            self._loaded = load(name, _settings(self.config, self.path))
        except ScriptError as error:
            raise self.CollectError(_render(error.diagnostics, self.config)) from None
        except Exception as error:
            raise self.CollectError(_internal(error, f"reading `{name}`", self.config)) from None
        for warning in self._loaded.warnings:
            self.warn(ScriptWarning(_render([warning], None)))
        names: set[str] = set()
        for assertion in self._loaded.assertions:
            name = harmless(" ".join(assertion.text.split()))
            if name in names:
                name = f"{name} (line {assertion.span.line})"
            names.add(name)
            yield AssertionItem.from_parent(self, name=name, assertion=assertion)

    def check(self, assertion: script.Assertion) -> Result:
        """The answer to one of the assertions."""
        from cspcheck.checking import NoWatch, check, checker_for
        from cspcheck.cli.interrupt import Interrupts

        if self._checker is None:
            watch = NoWatch()
            self._interrupts = Interrupts()
            # A search tells now and then where it is: a chance to see that Ctrl-C was pressed.
            watch.progress = lambda progress: self._interrupts.poll()  # type: ignore[method-assign]
            self._checker = checker_for(self._loaded, _settings(self.config, self.path), watch)
        with self._interrupts:
            return check(self._checker, assertion)


class AssertionItem(pytest.Item):
    """An assertion. It passes when the verdict is the one that the script expects."""

    def __init__(self, *, assertion: script.Assertion, **arguments: Any) -> None:
        super().__init__(**arguments)
        self._assertion = assertion

    def runtest(self) -> None:
        """Check the assertion."""
        assert isinstance(self.parent, ScriptFile)
        try:
            result = self.parent.check(self._assertion)
        except KeyboardInterrupt:
            # Anew: of each frame of a traceback pytest reads and parses the whole file before it ends.
            raise KeyboardInterrupt from None
        self.user_properties.extend([("states", result.states), ("transitions", result.transitions)])
        if not result.as_expected:
            raise NotAsExpected(result)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What the command line shows, also for a mistake of ours."""
        if isinstance(excinfo.value, NotAsExpected):
            from cspcheck.report.full import explain, replay_lines
            from cspcheck.report.style import Style, unobeyed

            result, look = excinfo.value.result, Style(color=_has_color(self.config))
            text = "\n".join([explain(result, look), *(f"  {line}" for line in replay_lines(result, look))])
            return _Told(unobeyed(text), excinfo.value)
        if isinstance(excinfo.value, Exception):
            return _internal(excinfo.value, f"checking `{self.name}`", self.config)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str] | str, int | None, str]:
        """Where the assertion stands."""
        return self.path, self._assertion.span.line - 1, f"{self.path.name}::{self.name}"


class _Told(TerminalRepr):
    """What is shown of a failure; pytest's line about it in the summary is the sentence alone."""

    def __init__(self, text: str, error: NotAsExpected) -> None:
        self._text = text
        self.reprcrash = ReprFileLocation(error.result.file, error.result.line, str(error))

    def __str__(self) -> str:
        return self._text

    def toterminal(self, tw: TerminalWriter) -> None:
        """Write it."""
        tw.line(self._text)


class NotAsExpected(Exception):
    """An assertion whose verdict is not the one that the script expects."""

    def __init__(self, result: Result) -> None:
        from cspcheck.report.sentences import sentence

        super().__init__(sentence(result) or f"{result.verdict}")
        self.result = result


class ScriptWarning(pytest.PytestWarning):
    """Something odd about a script."""


def _shown(path: Path) -> str:
    """A path as the user would write it: relative to the current folder if it is below it."""
    try:
        return str(path.relative_to(Path.cwd()))
    except ValueError:
        return str(path)


def _has_color(config: pytest.Config) -> bool:
    return bool(config.get_terminal_writer().hasmarkup)


def _render(diagnostics: Any, config: pytest.Config | None) -> str:
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import Style, unobeyed

    return unobeyed(render_diagnostics(diagnostics, Style(color=config is not None and _has_color(config))).rstrip())


def _internal(error: Exception, doing: str, config: pytest.Config) -> str:
    """What the command line says of an exception that nobody expected."""
    from cspcheck.failure import InternalErrors

    arguments = ["pytest", *map(str, config.invocation_params.args)]
    return _render([InternalErrors(arguments).report(error, doing)], config)


class Scripts:
    """What the fixture ``csp`` gives."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config

    def load(self, path: str | os.PathLike[str], *, definitions: Mapping[str, object] | None = None) -> Script:
        """A script as :func:`cspcheck.load` gives it; the options and the project's settings are its defaults.

        A relative path is looked up in the current folder, then in pytest's root folder.

        Raises:
            ScriptError: the file cannot be read, or there is an error in the script.
        """
        from cspcheck.api import load_with

        place = Path(path)
        if not place.is_absolute() and not place.exists():
            rooted = self._config.rootpath / place
            place = rooted if rooted.exists() else place
        return load_with(os.fspath(place), _settings(self._config, place), definitions or {})


@pytest.fixture(scope="session")
def csp(pytestconfig: pytest.Config) -> Scripts:
    """Load CSPm scripts: ``csp.load("spec.csp").check()``."""
    return Scripts(pytestconfig)
