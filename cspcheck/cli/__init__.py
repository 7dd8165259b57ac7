"""The command line: one verb a file, imported when it is used."""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import sys
import threading
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NoReturn

import click

from cspcheck import __version__

VERBS = {
    "check": "Check the assertions of scripts (the default).",
    "sweep": "Check scripts for several values of their constants.",
    "mutate": "Say which changes of a script no assertion notices.",
    "refines": "Check as FDR4's command line does, for what calls it.",
    "typecheck": "Read scripts and check their names and types.",
    "prove": "Prove the obligations of classes, or compute a precondition.",
    "fmt": "Print scripts in the standard layout, or rewrite them.",
    "latex": "Write classes as LaTeX, or LaTeX as text.",
    "probe": "Step through a process, or through a counterexample.",
    "repl": "Evaluate and check at a prompt.",
    "explore": "Explore a script in the browser.",
    "graph": "Draw a machine, an architecture or a counterexample.",
    "cspm": "Write a script as plain CSPm, for FDR.",
    "gen": "Generate a program of tasks and channels.",
    "trace": "Say whether a recorded run is a trace of a process.",
    "monitor": "Generate a monitor that holds running code against a process.",
    "explain": "Say what an error code means, with an example and its repair.",
    "examples": "List, print or copy the examples that come with cspcheck.",
    "schema": "Print the JSON Schema of an output for programs.",
    "lsp": "Serve an editor: diagnostics, navigation, checks (LSP).",
    "man": "Show the manual of the command or of a verb.",
    "completion": "Print the completion script for a shell.",
}
"""The verbs with what ``--help`` says of them, so that it need not import them."""

_ENDINGS = """\
Exit codes: 0 all pass (or fail as the script expects); 1 an assertion fails; 2 not run: usage, file, or error in a
script; 3 none fails but one is unknown; 4 internal error; 5 nothing to check; 130 interrupted."""


class FrontDoor(click.Group):
    """A group of verbs in which ``check`` need not be said, and options may stand before the verb."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The verbs, in the order of the help."""
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a verb; only its own module is imported."""
        if cmd_name not in VERBS:
            return None
        command: click.Command = import_module(f"cspcheck.cli.{cmd_name}").command
        return command

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the verb first, ``check`` where there is none."""
        if not args and not ctx.resilient_parsing:
            click.echo(ctx.get_help(), err=True)
            ctx.exit(2)
        return super().parse_args(ctx, self._arrange(ctx, args))

    def _arrange(self, ctx: click.Context, args: list[str]) -> list[str]:
        position = 0
        valued = None
        while position < len(args) and args[position].startswith("-") and args[position] not in ("-", "--"):
            if args[position] in ("--help", "-h", "--version"):
                return args if position == 0 else ["check", *args]
            valued = valued if valued is not None else self._options_with_values(ctx)
            position += 2 if args[position] in valued else 1
        if position < len(args) and args[position] in VERBS:
            return [args[position], *args[:position], *args[position + 1 :]]
        if position < len(args):
            _refuse_mistyped_verb(ctx, args[position])
        return ["check", *args] if args else args

    def _options_with_values(self, ctx: click.Context) -> set[str]:
        check = self.get_command(ctx, "check")
        assert check is not None
        return {
            name
            for option in check.params
            if isinstance(option, click.Option) and not option.is_flag and not option.count
            for name in option.opts
        }

    def format_help(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The verbs, the options of ``check``, and the exit codes."""
        check = self.get_command(ctx, "check")
        assert check is not None
        formatter.write_usage(ctx.command_path, "[VERB] [OPTIONS] FILE...")
        formatter.write_paragraph()
        with formatter.indentation():
            formatter.write_text(self.help or "")
        with formatter.section("Verbs"):
            formatter.write_dl(list(VERBS.items()))
        with formatter.section("Options of check (`cspcheck VERB --help` for those of the others)"):
            records = [record for parameter in check.params if (record := parameter.get_help_record(ctx))]
            records.append(("--version", "Show the version and exit."))
            records.append(("-h, --help", "Show this message and exit."))
            formatter.write_dl(records)
        formatter.write_paragraph()
        formatter.write_text(_ENDINGS)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[Any]:
        """Verbs, the options of ``check``, and files."""
        from click.shell_completion import CompletionItem

        found = super().shell_complete(ctx, incomplete)
        if incomplete.startswith("-"):
            check = self.get_command(ctx, "check")
            assert check is not None
            with click.Context(check, info_name="check", parent=ctx, resilient_parsing=True) as inner:
                known = {item.value for item in found}
                found += [item for item in check.shell_complete(inner, incomplete) if item.value not in known]
        else:
            found.append(CompletionItem(incomplete, type="file"))
        return found


def _refuse_mistyped_verb(ctx: click.Context, word: str) -> None:
    """Stop where the first word is neither a verb nor anything like a file: it was meant as a verb.

    As a missing file it would be told and passed over, and the long check of the others would begin.

    Raises:
        click.UsageError: with the verbs that look like it.
    """
    if ctx.resilient_parsing or not word.isalpha() or os.path.exists(word):
        return
    from difflib import get_close_matches

    from cspcheck.cspm.spelling import suggestions

    close = suggestions(word, VERBS) or get_close_matches(word, VERBS, n=1)
    hint = f"did you mean {' or '.join(f'`{verb}`' for verb in close)}?" if close else "a script ends in `.csp`"
    raise click.UsageError(f"`{word}` is neither a verb nor a file; {hint}", ctx)


@click.group(
    cls=FrontDoor,
    help="Check CSPm scripts: `cspcheck rov.csp` checks every assertion in rov.csp.",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="%(prog)s %(version)s")
def front_door() -> None:
    """The root of all verbs."""


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command line with *arguments* (default: those of the process); the exit code."""
    from cspcheck.cli.streams import STANDARD_OUTPUT, OutputLost, ReaderGone, prepare_standard_streams

    prepare_standard_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        code = front_door.main(args=given, prog_name="cspcheck", standalone_mode=False)
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except click.UsageError as error:
        return _wrong_usage(error)
    except ReaderGone:
        # The code is the one that the shell gives to a program that the signal of a broken pipe ends. What is still
        # buffered must not fail again when the interpreter closes.
        _drop_output()
        return 141
    except OutputLost as lost:
        _drop_output()
        _tell(lost.diagnostic)
        return 2
    except (KeyboardInterrupt, click.Abort):
        return 130
    except MemoryError:
        from cspcheck.messages import out_of_memory

        _tell(out_of_memory())
        return 3
    except OSError as error:
        # Reading has its own messages; what is left is text that click or the interpreter could not write.
        if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO):
            return _stopped(error, given)
        _drop_output()
        _tell(OutputLost(STANDARD_OUTPUT, error).diagnostic)
        return 2
    except Exception as error:
        return _stopped(error, given)


def _drop_output() -> None:
    """Have what is still buffered go nowhere: it must not fail again when the interpreter closes."""
    with contextlib.suppress(OSError, ValueError):  # a stream that is no file
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main() -> NoReturn:
    """Run the command line of the process and end it. The command itself begins in ``cspcheck.__main__``."""
    end(run())


def end(code: int) -> NoReturn:
    """End the process with an exit code.

    What a search has in memory is left to the system, which takes it back at once: taking a million terms apart one by
    one, as the end of a Python program would, takes seconds. Where the process was interrupted nobody waits until the
    kernels are compiled, either. Nothing of them is half written then: files are put in their places whole.
    """
    if "mpi4py" in sys.modules:  # which says good-bye to the others in the last step of all
        sys.exit(code)
    if code != 130:
        threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def finish(code: int) -> NoReturn:
    """End a verb with an exit code."""
    raise SystemExit(int(code))


def _wrong_usage(error: click.UsageError) -> int:
    from cspcheck.messages import wrong_usage

    text = " ".join(error.format_message().split()).rstrip(".")
    command = error.ctx.command_path if error.ctx else "cspcheck"
    _tell(wrong_usage(text[:1].lower() + text[1:], command))
    return 2


def _stopped(error: Exception, given: list[str]) -> int:
    """An exception that ended a verb: wrong files and scripts, or a mistake of ours."""
    from cspcheck.cspm.diagnostics import ScriptError

    if isinstance(error, ScriptError):
        _tell(*error.diagnostics)
        return 2
    from cspcheck.failure import InternalErrors

    verbose = any(argument in ("-v", "--verbose", "-vv") for argument in given)
    _tell(InternalErrors(given, verbose=verbose).report(error, "running the command"))
    return 4


def _tell(*diagnostics: Any) -> None:
    from cspcheck.cli.streams import Remarks
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for

    Remarks().write(render_diagnostics(diagnostics, style_for(sys.stderr)))
