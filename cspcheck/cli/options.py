"""The options that verbs share, the forms of their values, and where their defaults come from."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import click

from cspcheck.quantities import parse_duration, parse_size, whole_number
from cspcheck.report import FORMATS

if TYPE_CHECKING:
    from cspcheck.checking import Settings

F = TypeVar("F", bound=Callable[..., Any])


class _Parsed(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.2
    """A value that a function reads from text, which says with ValueError what is wrong with it; ``none`` is None."""

    def __init__(self, name: str, parse: Callable[[str], float | int]) -> None:
        self.name = name
        self._parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number that *value* stands for."""
        if not isinstance(value, str):
            return value
        if value == NONE:
            return None
        try:
            return self._parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class DefineOption(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.2
    """``NAME=EXPR``."""

    name = "name=expr"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The pair of name and expression."""
        if isinstance(value, tuple):
            return value
        name, equals, expression = str(value).partition("=")
        if not equals or not name.strip() or not expression.strip():
            self.fail(f"`{value}` is not NAME=EXPR", param, ctx)
        return name.strip(), expression.strip()


def _above_zero(text: str) -> int:
    number = whole_number(text)
    if not number:
        raise ValueError(f"`{text}` is not a whole number above zero")
    return number


NONE = "none"
"""As the value of a limit: that there is none, whatever the project's settings say."""
DURATION = _Parsed("time", parse_duration)
SIZE = _Parsed("size", parse_size)
NUMBER = _Parsed("number", _above_zero)

_CONFIGURATION = "cspcheck.configuration"


class ConfiguredCommand(click.Command):
    """A verb whose options have the project's settings as their defaults (:mod:`cspcheck.configuration`)."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the settings for the first file that is named, then the arguments."""
        if not ctx.resilient_parsing and not {"-h", "--help"} & set(args):
            self._configure(ctx, args)
        return super().parse_args(ctx, args)

    def _configure(self, ctx: click.Context, args: list[str]) -> None:
        from cspcheck.configuration import configuration_for

        try:
            given, _, _ = self.make_parser(ctx).parse_args(list(args))
        except click.UsageError:
            return  # which is told when the arguments are read again
        named = given.get("at") or given.get("files") or given.get("file")
        first = named[0] if isinstance(named, list | tuple) and named else named
        configuration = configuration_for(_without_line(first) if isinstance(first, str) else None)
        ctx.meta[_CONFIGURATION] = configuration
        parameters = {parameter.name: parameter for parameter in self.params}
        ctx.default_map = {
            name: value
            for name, value in configuration.settings.items()
            if name in parameters and _is_possible(parameters[name], value)
        }


def _without_line(path: str) -> str:
    match = re.fullmatch(r"(.+):\d+", path)
    return match[1] if match and not os.path.exists(path) else path


def _is_possible(parameter: click.Parameter, value: object) -> bool:
    """Whether a setting is one of the choices of a verb that has fewer of them than others."""
    return not isinstance(parameter.type, click.Choice) or value in parameter.type.choices


def configured_definitions() -> dict[str, str]:
    """The top-level constants that the project overrides, for the verb that is running."""
    configuration = click.get_current_context().meta.get(_CONFIGURATION)
    return {} if configuration is None else dict(configuration.definitions)


def definitions(options: Mapping[str, Any]) -> dict[str, str]:
    """The top-level constants to override: the project's, and on top of them those of the command line."""
    return configured_definitions() | dict(options["definitions"])


def settings(options: Mapping[str, Any], overrides: Mapping[str, str]) -> Settings:
    """How scripts are loaded and checked, as the options say."""
    from cspcheck.checking import Settings, limits

    return Settings(
        limits=limits(options["max_states"], options["timeout"], options["max_memory"]),
        workers=options["workers"],
        full=options["full"],
        as_written=options["as_written"],
        termination=options["termination"],
        definitions=overrides,
        typecheck=options["typecheck"],
        view=options["view"],
        outputs=options["outputs"],
        include_roots=options["include_roots"],
        checkpoint=_checkpoint(options),
        resume=options["resume"] is not None,
        spill=options["spill"],
        cluster=options.get("cluster", False),
    )


def _checkpoint(options: Mapping[str, Any]) -> str | None:
    """The folder of checkpoints."""
    if options["checkpoint"] is not None and options["resume"] is not None:
        raise click.UsageError("`--checkpoint` begins anew and `--resume` goes on: say which")
    folder = options["resume"] or options["checkpoint"]
    return None if folder is None else str(folder)


def _all(*options: Callable[[F], F]) -> Callable[[F], F]:
    def decorate(command: F) -> F:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


color_option = click.option(
    "--color",
    type=click.Choice(["auto", "always", "never"]),
    default="auto",
    show_default=True,
    help="Colour; `auto` colours terminals and honours NO_COLOR and FORCE_COLOR.",
)
"""--color."""

manner_options = _all(
    click.option("-q", "--quiet", count=True, help="Only what is wrong: no progress, no warnings."),
    click.option("-v", "--verbose", count=True, help="Everything: nothing folded, tracebacks of internal errors."),
    color_option,
)
"""-q, -v, --color."""

output_option = click.option(
    "-o",
    "--output",
    type=click.Path(),
    metavar="FILE",
    help="Write the result to FILE, whole or not at all, instead of standard output.",
)
"""-o."""

output_options = _all(
    click.option(
        "--format",
        "form",
        type=click.Choice(FORMATS),
        default="full",
        show_default=True,
        help="Output form.",
    ),
    output_option,
)
"""--format, -o."""

include_root_option = click.option(
    "--include-root",
    "include_roots",
    type=click.Path(),
    multiple=True,
    metavar="FOLDER",
    help="Let scripts include files from below FOLDER, too, not only from below their own.",
)
"""--include-root."""

script_options = _all(
    click.option(
        "-D",
        "definitions",
        type=DefineOption(),
        multiple=True,
        metavar="NAME=EXPR",
        help="Override a top-level constant of the scripts.",
    ),
    include_root_option,
)
"""-D, --include-root."""


def defined_names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """For a shell: the names that the script of the command line defines, as far as it can be read."""
    from cspcheck.checking import read
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.cspm.parsing.reading import parse
    from cspcheck.cspm.syntax import tree as syntax

    try:
        tree = parse(read(ctx.params["file"]))
    except (ScriptError, KeyError, TypeError):
        return []
    names: list[str] = []
    pending = list(reversed(tree.declarations))
    while pending:
        declaration = pending.pop()
        if isinstance(declaration, syntax.IncludeDeclaration | syntax.TimedDeclaration):
            pending += reversed(declaration.declarations)
        elif isinstance(declaration, syntax.PatternDefinition) and isinstance(declaration.pattern, syntax.NamePattern):
            names.append(declaration.pattern.text)
    return [name for name in dict.fromkeys(names) if name.startswith(incomplete)]


files_argument = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(allow_dash=True))
"""FILE..."""

assert_option = click.option(
    "--assert",
    "patterns",
    multiple=True,
    metavar="PATTERN",
    help="Only the assertions whose text contains PATTERN; `*` stands for any characters, blanks do not count.",
)
"""--assert."""

typecheck_option = click.option(
    "--typecheck/--no-typecheck",
    default=True,
    show_default=True,
    help="Whether types are checked; not for the odd script that only FDR2 accepted.",
)
"""--typecheck, --no-typecheck."""

class_options = _all(
    click.option(
        "--view",
        type=click.Choice(["data", "control"]),
        help="Read classes with their data, or without.  [default: as the script says, else data]",
    ),
    click.option(
        "--outputs",
        type=click.Choice(["demonic", "angelic"]),
        default="demonic",
        show_default=True,
        help="Who chooses the outputs of classes: the class, or its environment.",
    ),
)
"""--view, --outputs."""

limit_options = _all(
    click.option(
        "--termination",
        type=click.Choice(["success", "deadlock"]),
        default="success",
        show_default=True,
        help="What a process that has terminated is to `deadlock free`; FDR4 takes it for a deadlock.",
    ),
    click.option(
        "--full/--no-full",
        default=False,
        help="Explore the whole state space: no reduction, no early stop, exact counts.",
    ),
    click.option(
        "--as-written/--no-as-written",
        default=False,
        help="Only the reductions that the script itself asks for; counts are then those that FDR states.",
    ),
    click.option("--timeout", type=DURATION, metavar="TIME", help="Give up an assertion after TIME (90s, 5m, 1h30m)."),
    click.option(
        "--max-memory",
        type=SIZE,
        metavar="SIZE",
        help="Give up an assertion that needs more than SIZE (512MiB, 8GiB).  [default: 80% of the machine's memory]",
    ),
    click.option("--max-states", type=NUMBER, metavar="N", help="Give up an assertion with more than N states."),
    click.option(
        "--checkpoint", type=click.Path(), metavar="FOLDER", help="Write long searches down in FOLDER, every minute."
    ),
    click.option(
        "--resume",
        type=click.Path(),
        metavar="FOLDER",
        help="Go on from the checkpoints in FOLDER.",
    ),
    click.option(
        "--spill",
        type=click.Path(),
        metavar="FOLDER",
        help="Where a search goes on, on disk, that is larger than the memory it may use.",
    ),
    click.option("--workers", type=NUMBER, metavar="N", help="Search threads.  [default: the machine's cores]"),
    typecheck_option,
    class_options,
)
"""What every verb takes that searches: reductions, limits, checkpoints, workers, how classes are read."""
