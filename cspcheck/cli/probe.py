"""``cspcheck probe FILE PROCESS``: step through a process in the terminal, or replay a counterexample."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from cspcheck.cli import finish
from cspcheck.cli.interrupt import goes_on
from cspcheck.cli.options import ConfiguredCommand, color_option, defined_names, definitions, script_options

if TYPE_CHECKING:
    from cspcheck.checking import Settings
    from cspcheck.cli.probe_commands import Commands
    from cspcheck.cspm.script import Script
    from cspcheck.probing import Probe
    from cspcheck.report.style import Style
    from cspcheck.result import Result

PROMPT = "> "


@click.command(cls=ConfiguredCommand, short_help="Step through a process, or through a counterexample.")
@click.argument("file", metavar="[FILE]", required=False, type=click.Path(allow_dash=True))
@click.argument("process", metavar="[PROCESS]", required=False, shell_complete=defined_names)
@click.option("--at", metavar="FILE:LINE", help="Replay the counterexample of the assertion on that line.")
@click.option("--seed", type=int, default=0, show_default=True, help="Where random walks start from.")
@script_options
@color_option
def command(**options: Any) -> None:
    """Step through PROCESS, any process expression of the script FILE: see its components, choose an event, go back.

    Nothing is explored ahead, so the process may have any number of states. Commands are read from standard input, one
    a line; `help` lists them. With --at the steps of a counterexample are offered one by one.
    """
    from cspcheck import checking
    from cspcheck.cli.probe_commands import Commands
    from cspcheck.cli.streams import StandardOutput
    from cspcheck.report.style import style_for

    settings = checking.Settings(definitions=definitions(options), include_roots=options["include_roots"])
    output = StandardOutput()
    style = style_for(sys.stdout, options["color"])
    probe, result = _counterexample(settings, options) if options["at"] else (_process(settings, options), None)
    commands = Commands(probe, output.write, style, result)
    commands.begin()
    finish(_talk(commands, output.write, style))


def _process(settings: Settings, options: dict[str, Any]) -> Probe:
    """The process that the command line names."""
    from cspcheck import checking

    for name in ("file", "process"):
        if options[name] is None:
            raise click.UsageError(f"missing {name.upper()}: `cspcheck probe FILE PROCESS` steps through a process")
    _keep_standard_input(options["file"])
    script = checking.load(options["file"], settings)
    return _probe(script, script.process(options["process"]), seed=options["seed"])


def _counterexample(settings: Settings, options: dict[str, Any]) -> tuple[Probe, Result]:
    """The process of the assertion that ``--at`` names, with the run of its counterexample, and the answer."""
    from cspcheck import checking
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import no_assertion_there, no_counterexample
    from cspcheck.quantities import whole_number
    from cspcheck.selection import select

    if options["process"] is not None:
        raise click.UsageError("with --at the assertion says what is probed: leave PROCESS out")
    path, _, digits = options["at"].rpartition(":")
    path = path or options["file"] or ""
    line = whole_number(digits)
    if line is None or not path:
        raise click.UsageError(f"`{options['at']}` is not FILE:LINE")
    _keep_standard_input(path)
    script = checking.load(path, settings)
    chosen = select(script.assertions, frozenset({line}), ())
    if not chosen:
        places = [f"{a.span.source.name}:{a.span.line}: {a.text}" for a in script.assertions]
        raise ScriptError(no_assertion_there(f"{path}:{digits}", places))
    result = checking.check(checking.checker_for(script, settings, checking.NoWatch()), chosen[0])
    if result.diagnostics:
        raise ScriptError(*result.diagnostics)
    if result.counterexample is None or result.counterexample.run is None:
        raise ScriptError(no_counterexample(result.assertion, str(result.verdict)))
    run = result.counterexample.run
    return _probe(script, run.process, run.steps, options["seed"]), result


def _keep_standard_input(path: str) -> None:
    if path == "-":
        raise click.UsageError("standard input is where the commands come from: name a file")


def _probe(script: Script, process: Any, run: Any = (), seed: int = 0) -> Probe:
    from cspcheck.probing import Probe

    return Probe(process, script.events, run=run, seed=seed)


def _talk(commands: Commands, write: Any, style: Style) -> int:
    """Carry out what is typed, or what comes in by a pipe, until it ends; 1 if a command could not be carried out."""
    from cspcheck.report.style import is_terminal

    asked = is_terminal(sys.stdin) and is_terminal(sys.stdout)
    failed = False
    for line in _typed(commands) if asked else _piped(write):
        try:
            going_on = commands.do(line)
        except KeyboardInterrupt as interrupt:
            goes_on(interrupt)
            write("interrupted\n")
            continue
        failed = failed or commands.failed
        if not going_on:
            break
    return int(failed and not asked)


def _piped(write: Any) -> Iterator[str]:
    """The lines of standard input, each told before what comes of it, so that the output can be read by itself."""
    from cspcheck.report.style import harmless

    for line in sys.stdin:
        if not line.strip():
            continue
        write(f"\n{PROMPT}{harmless(line.strip())}\n")
        yield line


def _typed(commands: Commands) -> Iterator[str]:
    """The lines that a person types, with history and completion where the system has them."""
    try:
        import readline
    except ImportError:
        pass
    else:
        readline.set_completer_delims("\n")
        readline.set_completer(lambda text, number: [*commands.completions(text), None][number])
        readline.parse_and_bind("tab: complete")
    while True:
        print()
        try:
            yield input(PROMPT)
        except KeyboardInterrupt as interrupt:
            goes_on(interrupt)
            print("\n(`quit` leaves)")
        except EOFError:
            print()
            return
