"""``cspcheck monitor FILE --process P``: a monitor that holds the events of running code against a process."""

from __future__ import annotations

from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import definitions, script_options

MOST_STATES = 20_000


@click.command(short_help="Generate a monitor that holds running code against a process.")
@click.argument("file", type=click.Path(allow_dash=True))
@click.option("--process", required=True, metavar="NAME", help="The process that events are held against.")
@click.option("--target", type=click.Choice(["python", "c"]), default="python", show_default=True, help="Its language.")
@click.option(
    "-o", "--output", required=True, metavar="FOLDER", help="Where its files go; those of the same names are replaced."
)
@click.option(
    "--max-states",
    type=click.IntRange(1),
    default=MOST_STATES,
    show_default=True,
    help="A larger table is not written.",
)
@script_options
def command(**options: Any) -> None:
    """Generate a monitor of a process, which is told events and says at the first that is not allowed what was.

    It needs nothing but its language and allocates nothing. Events that the process never performs are passed over;
    files of the same names are replaced.
    """
    import os

    from cspcheck.checking import Settings, load
    from cspcheck.cli.streams import StandardOutput
    from cspcheck.codegen.emit import monitor
    from cspcheck.codegen.emit.keeping import write_whole
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.following import Follower, TooManyStates
    from cspcheck.messages import cannot_write, monitor_of_events, monitor_too_large
    from cspcheck.result import Exit

    script = load(options["file"], Settings(definitions=definitions(options), include_roots=options["include_roots"]))
    process, folder = options["process"], options["output"]
    follower = Follower(script, script.process(process))
    try:
        rows = follower.automaton(options["max_states"])
    except TooManyStates:
        raise ScriptError(monitor_too_large(process, options["max_states"])) from None
    numbers = {event: i for i, event in enumerate(sorted({event for row in rows for event in row}))}
    if not numbers or (options["target"] == "c" and len(numbers) > monitor.MOST_EVENTS):
        raise ScriptError(monitor_of_events(process, len(numbers)))
    made = monitor.Automaton(
        os.path.basename(script.source.name),
        process,
        tuple(script.events.name(event) for event in numbers),
        tuple(tuple(sorted((numbers[event], target) for event, target in row.items())) for row in rows),
    )
    files = monitor.c(made) if options["target"] == "c" else monitor.python(made)
    try:
        os.makedirs(folder, exist_ok=True)
        for name, text in files.items():
            write_whole(os.path.join(folder, name), text)
    except OSError as error:
        raise ScriptError(cannot_write(folder, error.strerror or str(error))) from None
    shown = (
        f"{len(rows):,} state{'' if len(rows) == 1 else 's'}, {len(numbers):,} event{'' if len(numbers) == 1 else 's'}"
    )
    if options["target"] == "c":
        shown += f"; a monitor takes {monitor.RAM} bytes, its constant tables {monitor.c_bytes(made):,}"
    StandardOutput().write(f"wrote {', '.join(files)} into {folder}: {shown}\n")
    finish(Exit.OK)
