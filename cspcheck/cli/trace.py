"""``cspcheck trace SCRIPT --process NAME RUN``: is a recorded run a trace of the specification?"""

from __future__ import annotations

import json
import os
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any, BinaryIO

import click

from cspcheck.cli import finish
from cspcheck.cli.options import script_options


@click.command(short_help="Say whether a recorded run is a trace of a process.")
@click.argument("file", type=click.Path())
@click.argument("run", type=click.Path(allow_dash=True))
@click.option("--process", required=True, metavar="NAME", help="The process that the run should be a trace of.")
@click.option("--pattern", metavar="FILE", type=click.Path(), help="How lines of a log, a CSV or JSON become events.")
@click.option("--inside", is_flag=True, help="Follow hidden events too: the process without its outermost hiding.")
@click.option("--format", "form", type=click.Choice(["full", "json"]), default="full", help="Output form.")
@script_options
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour of messages.")
def command(**options: Any) -> None:
    """Say whether a recorded run is a trace of a process, and if not, where and why it leaves it.

    FILE is a script, RUN a file with a line of JSON for each event (or `-`), as generated programs record it; with
    --pattern it is any log, a CSV or lines of other JSON.
    """
    from cspcheck.checking import Settings, load
    from cspcheck.cli.streams import Remarks, StandardOutput
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.following import Follower, TooManyStates
    from cspcheck.messages import cannot_read, too_many_at_a_time
    from cspcheck.patterns import read_pattern
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import harmless, style_for, unobeyed
    from cspcheck.result import Exit
    from cspcheck.runs import follow, read_records

    remarks = Remarks()
    say = StandardOutput().write
    name, process = options["run"], options["process"]
    started = time.perf_counter()
    try:
        settings = Settings(definitions=dict(options["definitions"]), include_roots=options["include_roots"])
        script = load(options["file"], settings)
        try:
            follower = Follower(script, script.process(process), hidden=options["inside"])
            # Not by waiting for ever: what is neither a file nor a pipe that somebody has opened is refused.
            with sys.stdin.buffer if name == "-" else _file(name) as lines:
                pattern, texts = options["pattern"], _texts(lines)
                records = read_records(texts, name) if pattern is None else read_pattern(pattern).records(texts, name)
                verdict = follow(follower, records)
        except OSError as error:
            raise ScriptError(cannot_read(name, error.strerror or str(error))) from None
        except UnicodeDecodeError as error:
            raise ScriptError(cannot_read(name, f"it is not UTF-8: {error.reason}")) from None
        except TooManyStates:
            remarks.write(
                render_diagnostics([too_many_at_a_time(process)], style_for(remarks.stream, options["color"]))
            )
            finish(Exit.UNKNOWN)
    except ScriptError as error:
        remarks.write(render_diagnostics(error.diagnostics, style_for(remarks.stream, options["color"])))
        finish(Exit.NOT_RUN)
    departure = verdict.departure
    if options["form"] == "json":
        document = {
            "schema": "cspcheck-trace/1",
            "process": process,
            "run": name,
            "verdict": "pass" if departure is None else "fail",
            "events": verdict.events,
            "followed": verdict.followed,
            "line": verdict.line,
            "event": None if departure is None else departure.event,
            "why": None if departure is None else departure.why,
            "allowed": None if departure is None else list(departure.allowed),
            "before": None if departure is None else list(departure.before),
        }
        say(json.dumps(document, indent=2) + "\n")
    else:
        seconds = time.perf_counter() - started
        if departure is None:
            unseen = verdict.events - verdict.followed
            hidden = f", {unseen:,} of them hidden" if unseen else ""
            events = f"{verdict.events:,} event{'' if verdict.events == 1 else 's'}{hidden}"
            say(f"{harmless(name)} is a trace of `{process}`: {events}, {seconds:.2f} s\n")
        else:
            say(unobeyed(f"{harmless(name)} leaves `{process}` in line {verdict.line}\n{departure.explain()}\n"))
            record = verdict.record
            if record is not None and record.tasks:
                at = "" if record.time is None else f" at {record.time:g} s"
                say(f"  performed by {harmless(', '.join(record.tasks))}{at}\n")
    finish(Exit.OK if departure is None else Exit.FAILED)


def _file(name: str) -> BinaryIO:
    number = os.open(name, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    file = os.fdopen(number, "rb")
    mode = os.fstat(number).st_mode
    if stat.S_ISFIFO(mode) and name.startswith("/dev/fd/"):
        os.set_blocking(number, True)
    elif not stat.S_ISREG(mode):
        file.close()
        raise OSError(0, "it is a folder, a device or a pipe, not a file")
    return file


def _texts(lines: Iterable[bytes]) -> Iterator[str]:
    for line in lines:
        yield line.decode("utf-8")
