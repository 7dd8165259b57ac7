"""``cspcheck repl [FILE]``: a prompt against a script."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.interrupt import goes_on
from cspcheck.cli.options import ConfiguredCommand, color_option, definitions, script_options
from cspcheck.quantities import count, whole_number
from cspcheck.report.style import harmless

PROMPT = "> "
_HELP = """\
an expression       its value
assert ...          checks an assertion
:type EXPR          the type of an expression
:assertions         the assertions of the script, with their numbers
:run [N]            checks the assertion of that number, or all
:graph PROCESS FILE draws a machine to FILE (.svg, .html or .dot)
:probe PROCESS      what a process can do at first
:load FILE          takes another script
:reload             reads the script again
:quit               ends
"""


@click.command(cls=ConfiguredCommand, short_help="Evaluate and check at a prompt.")
@click.argument("file", metavar="[FILE]", required=False, type=click.Path())
@script_options
@color_option
def command(**options: Any) -> None:
    """Evaluate expressions and check assertions against the script FILE, or against none, at a prompt.

    Commands begin with a colon, as in FDR; `:help` lists them. They are read from standard input, one a line.
    """
    from cspcheck.cli.streams import StandardOutput
    from cspcheck.report.style import is_terminal

    output = StandardOutput()
    prompt = Prompt(output.write, options)
    prompt.do(f":load {options['file']}" if options["file"] else ":load")
    asked = is_terminal(sys.stdin) and is_terminal(sys.stdout)
    for line in _typed(prompt) if asked else sys.stdin:
        try:
            if not prompt.do(line.strip()):
                break
        except KeyboardInterrupt as interrupt:
            goes_on(interrupt)
            output.write("interrupted\n")
    finish(int(prompt.failed and not asked))


class Prompt:
    """Carries out what is typed. ``failed``: whether something could not be carried out."""

    def __init__(self, write: Callable[[str], None], options: dict[str, Any]) -> None:
        from cspcheck import checking

        self._write = write
        self._settings = checking.Settings(definitions=definitions(options))
        self._color = options["color"]
        self._path: str | None = None
        self._script: Any = None
        self.failed = False

    def do(self, line: str) -> bool:
        """Carry out a line; whether to go on."""
        from cspcheck.cspm.diagnostics import ScriptError
        from cspcheck.report.diagnostics import render_diagnostics
        from cspcheck.report.style import style_for

        if not line or line.startswith("--"):
            return True
        if line in (":quit", ":q", ":exit"):
            return False
        try:
            self._carry_out(line)
        except ScriptError as error:
            self.failed = True
            self._write(render_diagnostics(error.diagnostics, style_for(sys.stdout, self._color)))
        return True

    def completions(self, text: str) -> list[str]:
        """Names of the script and commands that begin with *text*."""
        names = [] if self._script is None else [*self._script.names.top_level]
        commands = [line.split()[0] for line in _HELP.splitlines() if line.startswith(":")]
        return sorted(name for name in [*names, *commands, "assert"] if name.startswith(text) and "%" not in name)

    def _carry_out(self, line: str) -> None:
        word, _, rest = line.partition(" ")
        rest = rest.strip()
        commands: dict[str, Callable[[str], None]] = {
            ":help": lambda _: self._write(_HELP),
            ":type": self._type,
            ":t": self._type,
            ":assertions": self._assertions,
            ":run": self._run,
            ":graph": self._graph,
            ":probe": self._probe,
            ":load": self._load,
            ":reload": lambda _: self._load(self._path or ""),
        }
        if word in commands:
            commands[word](rest)
        elif word.startswith(":"):
            from cspcheck.cspm.spelling import suggestions

            close = suggestions(word, list(commands))
            hint = f"; did you mean `{close[0]}`?" if close else "; `:help` lists the commands"
            self._refuse(f"there is no command `{word}`{hint}")
        elif word == "assert":
            self._check(self._script.assertion(rest))
        else:
            self._write(harmless(self._script.show(line)) + "\n")

    def _refuse(self, text: str) -> None:
        self.failed = True
        self._write(f"{harmless(text)}\n")

    def _load(self, path: str) -> None:
        from cspcheck import checking
        from cspcheck.cspm import script
        from cspcheck.cspm.source import Source

        if self._script is None:
            self._script = script.load(Source("<prompt>", ""))
        if path:
            self._path = path
            self._script = checking.load(path, self._settings)
            self._write(f"{harmless(path)}: {count(len(self._script.assertions), 'assertion')}\n")

    def _type(self, text: str) -> None:
        from cspcheck.cspm.naming.resolve import resolve_more
        from cspcheck.cspm.parsing.reading import parse_expression
        from cspcheck.cspm.typing.inference import infer_expression
        from cspcheck.cspm.typing.types import show_scheme

        expression = parse_expression(text)
        resolve_more(self._script.names, expression)
        self._write(f"{harmless(text)} :: {show_scheme(infer_expression(expression, self._script.types))}\n")

    def _assertions(self, _: str) -> None:
        for i, assertion in enumerate(self._script.assertions, 1):
            self._write(f"{i:>3}  {harmless(assertion.text)}\n")

    def _run(self, number: str) -> None:
        chosen = self._script.assertions
        if number:
            place = whole_number(number)
            if not place or place > len(chosen):
                self._refuse(f"there is no assertion {number}; `:assertions` lists them")
                return
            chosen = chosen[place - 1 : place]
        for assertion in chosen:
            self._check(assertion)

    def _check(self, assertion: Any) -> None:
        from cspcheck import checking
        from cspcheck.report.full import explain
        from cspcheck.report.style import style_for

        checker = checking.checker_for(self._script, self._settings, checking.NoWatch())
        self._write(explain(checking.check(checker, assertion), style_for(sys.stdout, self._color)) + "\n")

    def _graph(self, text: str) -> None:
        from cspcheck.cli.streams import replace_text
        from cspcheck.drawing import dot, html, parts, svg

        process, _, path = text.rpartition(" ")
        if not process.strip():
            self._refuse("say which process and which file: `:graph P p.svg`")
            return
        picture = parts.machine(process, self._script.process(process), self._script.events)
        if path.endswith(".dot"):
            drawn = dot.render(picture)
        else:
            drawn = svg.render(picture)
            drawn = html.page(picture.title, drawn) if path.endswith(".html") else drawn
        replace_text(path, drawn)
        self._write(f"{harmless(path)}\n")

    def _probe(self, text: str) -> None:
        from cspcheck.probing import Probe
        from cspcheck.report.probe import show_point
        from cspcheck.report.style import style_for

        probe = Probe(self._script.process(text), self._script.events)
        self._write(show_point(probe, style_for(sys.stdout, self._color)))


def _typed(prompt: Prompt) -> Iterator[str]:
    """The lines that a person types, with history and completion where the system has them."""
    with contextlib.suppress(ImportError):
        import readline

        readline.set_completer(lambda text, number: [*prompt.completions(text), None][number])
        readline.set_completer_delims(" ()[]{}<>,.;|\\!?&=+-*/")
        readline.parse_and_bind("tab: complete")
    while True:
        try:
            yield input(PROMPT)
        except KeyboardInterrupt as interrupt:
            goes_on(interrupt)
            print("\n(`:quit` leaves)")
        except EOFError:
            print()
            return
