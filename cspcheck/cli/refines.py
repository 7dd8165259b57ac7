"""``cspcheck refines FILE...``: FDR4's command line, for what calls it."""

from __future__ import annotations

import re
import sys
from typing import Any

import click

from cspcheck import __version__
from cspcheck.cli import finish
from cspcheck.cli.options import NUMBER, SIZE, files_argument, include_root_option

_ENGINE = re.compile(r"--(?:compiler|refinement|cspm|functional)[-.][\w.-]+")
"""Options that say how FDR4 works, not what it is asked."""
_WORKERS = "--refinement-bfs-workers"
_REFUSED = {
    "--archive": "there are no archives here: give the script; its includes are found from it",
    "--remote": "nothing is run on other machines: call cspcheck there",
}


class _Command(click.Command):
    """A command that reads FDR4's options: those of its engine are known, and names may be cut short."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Expand short names, take out what says how FDR4 works, then read the rest."""
        names = [name for option in self.params for name in option.opts if name.startswith("--")]
        kept: list[str] = []
        ignored: list[str] = []
        rest = iter(args)
        for argument in rest:
            name, equals, value = argument.partition("=")
            if argument == "--":
                kept += [argument, *rest]
            elif _ENGINE.fullmatch(name):
                value = value if equals else next(rest, "")
                if name.replace(".", "-") == _WORKERS:
                    kept += ["--workers", value]
                else:
                    ignored.append(name)
            else:
                if name in _REFUSED:
                    raise click.UsageError(f"`{name}`: {_REFUSED[name]}", ctx)
                longer = [known for known in names if known.startswith(name)]
                if name.startswith("--") and name not in names and len(longer) == 1:
                    name = longer[0]
                kept.append(name + equals + value)
        ctx.meta["ignored"] = ignored
        return super().parse_args(ctx, kept)


@click.command(cls=_Command, short_help="Check as FDR4's command line does.", add_help_option=False)
@files_argument
@click.option(
    "-f",
    "--format",
    "form",
    type=click.Choice(["plain", "colour", "json", "framed_json"]),
    help="Output form.  [default: colour on a terminal, else plain]",
)
@click.option("-b", "--brief", is_flag=True, help="Only whether assertions pass.")
@click.option("-q", "--quiet", is_flag=True, help="No log.")
@click.option("-t", "--typecheck", is_flag=True, help="Only read the scripts and check their types.")
@click.option("-d", "--divide", is_flag=True, help="What each component does in a counterexample (always told).")
@click.option("--reveal-taus", is_flag=True, help="Show what was hidden instead of τ.")
@click.option("--workers", type=NUMBER, metavar="N", help="Search threads (also `--refinement-bfs-workers`).")
@click.option("--max-states", type=NUMBER, metavar="N", help="Give up an assertion with more than N states.")
@click.option("--max-memory", type=SIZE, metavar="SIZE", help="Give up an assertion that needs more than SIZE.")
@include_root_option
@click.option("--strict", is_flag=True, help="Exit as `cspcheck check` does: 1 where an assertion fails.")
@click.version_option(__version__, "-v", "--version", message="cspcheck %(version)s, refines")
@click.help_option("-h", "--help")
@click.pass_context
def command(ctx: click.Context, /, **options: Any) -> None:
    """Check all assertions of scripts with the options and the output of FDR4's `refines`.

    A process that has terminated counts as deadlocked, as in FDR4. The exit code is 0 where all assertions were
    answered, whatever the answers, and 1 where a script has an error or an assertion was given up; `--strict` is for
    builds. Options that say how FDR4 works (`--compiler-...`, `--refinement-...`) are read.
    """
    from cspcheck.checking import Settings, limits
    from cspcheck.cli.session import Session
    from cspcheck.cli.streams import Remarks, StandardOutput
    from cspcheck.report.refines import RefinesJson, RefinesText
    from cspcheck.report.style import style_for
    from cspcheck.result import Exit, worst
    from cspcheck.selection import EmptyFolder, targets

    output = StandardOutput()
    color = {"plain": "never", "colour": "always"}.get(options["form"], "auto")
    style = style_for(output.stream, color)  # type: ignore[arg-type]  # one of its choices
    if not options["quiet"]:
        for name in ctx.meta["ignored"]:
            Remarks().write(f"`{name}` has no effect here\n")
    settings = Settings(
        limits=limits(options["max_states"], None, options["max_memory"]),
        workers=options["workers"],
        termination="deadlock",
        include_roots=options["include_roots"],
    )
    codes: list[Exit] = []
    answered = True
    for target in targets(options["files"]):
        if options["form"] in ("json", "framed_json"):
            name = "<stdin>" if target.path == "-" else target.path
            report: Any = RefinesJson(output.write, name, __version__, reveal=options["reveal_taus"])
        else:
            report = RefinesText(output.write, style, brief=options["brief"], reveal=options["reveal_taus"])
        session = Session(settings, report, color=color, verbosity=-1 if options["quiet"] else 0)  # type: ignore[arg-type]
        code = session.typecheck([target]) if options["typecheck"] else session.check([target])
        if code is Exit.INTERRUPTED:
            finish(code)
        codes.append(code)
        counts = session.summary
        answered &= not (counts.verdicts["error"] or counts.verdicts["unknown"] or counts.errors)
        if options["typecheck"] and code is Exit.OK and not isinstance(report, RefinesJson):
            output.write(f"{target.path}: types are right\n")
        if isinstance(target, EmptyFolder):
            answered = False
    sys.stdout.flush()
    finish(worst(codes) if options["strict"] else int(not answered))
