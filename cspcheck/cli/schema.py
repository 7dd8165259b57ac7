"""``cspcheck schema [NAME]``: the JSON Schemas of what is written for programs."""

from __future__ import annotations

import json

import click

from cspcheck.cli.streams import StandardOutput


def _names(ctx: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    from cspcheck.report.schemas import SCHEMAS

    return [name for name in SCHEMAS if name.startswith(incomplete)]


@click.command(short_help="Print the JSON Schema of an output.")
@click.argument("name", required=False, shell_complete=_names)
def command(name: str | None) -> None:
    """Print the JSON Schema of an output for programs; without NAME list them.

    NAME is check, lines, sweep, prove, mutate, refines, trace or record.
    """
    from cspcheck.report.schemas import SCHEMAS, schema

    say = StandardOutput().write
    if name is None:
        width = max(map(len, SCHEMAS))
        for known, (what, _) in SCHEMAS.items():
            say(f"{known:<{width}}  {what}\n")
        return
    if name not in SCHEMAS:
        raise click.UsageError(f"there is no schema `{name}`; there are {', '.join(SCHEMAS)}")
    say(json.dumps(schema(name), indent=2) + "\n")
