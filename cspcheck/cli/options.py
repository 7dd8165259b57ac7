"""The options that verbs share, and the forms of their values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from cspcheck.quantities import parse_duration, parse_size
from cspcheck.report import FORMATS

F = TypeVar("F", bound=Callable[..., Any])


class _Parsed(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.2
    """A value that a function reads from text, which says with ValueError what is wrong with it."""

    def __init__(self, name: str, parse: Callable[[str], float | int]) -> None:
        self.name = name
        self._parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number that *value* stands for."""
        if not isinstance(value, str):
            return value
        try:
            return self._parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


class _Definition(click.ParamType):  # type: ignore[type-arg]  # not generic before click 8.2
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


DURATION = _Parsed("time", parse_duration)
SIZE = _Parsed("size", parse_size)


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

output_options = _all(
    click.option(
        "--format",
        "form",
        type=click.Choice(FORMATS),
        default="full",
        show_default=True,
        help="Output form.",
    ),
    click.option(
        "-o",
        "--output",
        type=click.Path(),
        metavar="FILE",
        help="Write the result to FILE, whole or not at all, instead of standard output.",
    ),
)
"""--format, -o."""

script_options = _all(
    click.option(
        "-D",
        "definitions",
        type=_Definition(),
        multiple=True,
        metavar="NAME=EXPR",
        help="Override a top-level constant of the scripts.",
    ),
)
"""-D."""

files_argument = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(allow_dash=True))
"""FILE..."""
