"""``cspcheck explain CODE``: what a mistake is, an example of it, and its repair."""

from __future__ import annotations

import textwrap
from typing import Any

import click

from cspcheck.cspm.diagnostics import Mistake
from cspcheck.report.style import Style, style_for


def _codes(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    from cspcheck.register import all_mistakes

    return [mistake.code for mistake in all_mistakes() if mistake.code.startswith(incomplete.upper())]


@click.command(short_help="Say what an error code means.")
@click.argument("codes", nargs=-1, metavar="[CODE]...", shell_complete=_codes)
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour.")
def command(codes: tuple[str, ...], color: Any) -> None:
    """Say what error codes mean, each with an example and its repair. Without a code: list them all.

    CODE is what stands in square brackets behind `error` or `warning`, as in CSP201.
    """
    import sys

    from cspcheck.cli.streams import StandardOutput
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import unknown_code
    from cspcheck.register import all_mistakes, close_codes, find

    style = style_for(sys.stdout, color)
    say = StandardOutput().write
    if not codes:
        for mistake in all_mistakes():
            say(f"{style.paint(mistake.code, 'bold')}  {mistake.title}\n")
        return
    known = [(code, find(code)) for code in codes]
    unknown = [unknown_code(code, close_codes(code)) for code, mistake in known if mistake is None]
    texts = [explain(mistake, style) for _, mistake in known if mistake is not None]
    if texts:
        say("\n\n".join(texts) + "\n")
    if unknown:
        raise ScriptError(*unknown)


def explain(mistake: Mistake, style: Style) -> str:
    """A mistake as text."""
    parts = [
        style.paint(mistake.code, "bold", "red") + style.paint(f": {mistake.title}", "bold"),
        _prose(mistake.explanation, style.width),
        style.paint("Example", "bold"),
        _block(mistake.example, style.width),
        style.paint("Repair", "bold"),
        _block(mistake.repair, style.width),
    ]
    return "\n\n".join(parts)


def _prose(text: str, width: int) -> str:
    paragraphs = text.strip().split("\n\n")
    return "\n\n".join(
        textwrap.fill(" ".join(paragraph.split()), width, break_long_words=False, break_on_hyphens=False)
        for paragraph in paragraphs
    )


def _block(text: str, width: int) -> str:
    """Code as it stands; a single long line is prose and is wrapped."""
    stripped = text.strip("\n")
    if "\n" not in stripped and len(stripped) > width - 4:
        stripped = _prose(stripped, width - 4)
    return textwrap.indent(stripped, "    ")
