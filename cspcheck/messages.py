"""Mistakes in the use of the tool, and the tool's own (CSP9xx): one builder each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cspcheck.cspm.diagnostics import Diagnostic, Severity, mistake

if TYPE_CHECKING:
    from cspcheck.cspm.source import Span


@mistake(
    "CSP900",
    "internal error",
    explanation="""
Something went wrong in cspcheck itself. It says nothing about your script: no verdict was reached. The exit code is 4.
""",
    example="there is no example: if we knew one, it would be repaired",
    repair="""
report it with the script, the command line and the traceback; until it is repaired, a smaller script or `--full` (which
turns the reductions off) may get you further
""",
)
def internal_error(kind: str, message: str, doing: str) -> Diagnostic:
    """*kind* and *message* of the exception; *doing*: what was going on, as in ``checking `P :[deadlock free]```."""
    text = f"internal error while {doing}: {kind}" + (f": {message}" if message else "")
    return Diagnostic("CSP900", text)


@mistake(
    "CSP901",
    "wrong use of the command",
    explanation="The command line has an option or a value that cspcheck does not understand. Nothing was checked.",
    example="cspcheck rov.csp --timeout soon",
    repair="cspcheck rov.csp --timeout 5m",
)
def wrong_usage(message: str, command: str) -> Diagnostic:
    """*message* says what is wrong; *command* is the one whose help to read."""
    return Diagnostic("CSP901", message, help=f"`{command} --help` lists what there is")


@mistake(
    "CSP902",
    "no assertions",
    explanation="The script has no `assert`, so there is nothing to check in it.",
    example="""
channel a
P = a -> P
""",
    repair="""
channel a
P = a -> P
assert P :[deadlock free]
""",
)
def no_assertions(name: str) -> Diagnostic:
    """The script *name* has no assertion."""
    return Diagnostic(
        "CSP902",
        f"`{name}` has no assertions",
        severity=Severity.WARNING,
        help="add one, as in `assert P :[deadlock free]`, or use `cspcheck typecheck`",
    )


@mistake(
    "CSP903",
    "no assertion selected",
    explanation="""
`--assert PATTERN` and `FILE:LINE` select assertions, and none was left. A pattern matches where it occurs in the text
of an assertion; `*` stands for any characters, blanks do not count. A line matches when the assertion stands on it.
""",
    example="cspcheck rov.csp --assert 'deadlock-free'",
    repair="cspcheck rov.csp --assert 'deadlock free'",
)
def nothing_selected(patterns: Sequence[str], texts: Sequence[str]) -> Diagnostic:
    """*patterns* and lines were asked for; *texts* are the assertions that there are."""
    asked = f" for {', '.join(f'`{p}`' for p in patterns)}" if patterns else ""
    notes = ("the assertions are\n" + "\n".join(texts[:10]) + ("\n..." if len(texts) > 10 else ""),) if texts else ()
    return Diagnostic("CSP903", f"no assertion selected{asked}", severity=Severity.WARNING, notes=notes)


@mistake(
    "CSP904",
    "a folder without scripts",
    explanation="A folder stands for the `.csp` files below it, and this one has none.",
    example="cspcheck docs",
    repair="cspcheck specs",
)
def empty_folder(name: str) -> Diagnostic:
    """There is no script below the folder *name*."""
    return Diagnostic("CSP904", f"no `.csp` files below `{name}`", severity=Severity.WARNING)


@mistake(
    "CSP905",
    "the result cannot be written",
    explanation="The file named with `-o` cannot be created: its folder is missing, or may not be written.",
    example="cspcheck rov.csp -o no/such/folder/result.json",
    repair="cspcheck rov.csp -o result.json",
)
def cannot_write(name: str, reason: str) -> Diagnostic:
    """The file *name* cannot be written; *reason* is the system's word for why."""
    return Diagnostic("CSP905", f"cannot write `{name}`: {reason}")


@mistake(
    "CSP920",
    "a limit reached while reading",
    explanation="""
Reading a script (its includes, its types, what it prints, what its classes become) took more time or memory than the
limits allow. The limits for an assertion, `--timeout` and `--max-memory`, hold for reading as well. Nothing of the
script has been checked.
""",
    example="print {| c |} of a channel with 10^12 events, and `--timeout 5s`",
    repair="raise the limit that the message names, or make smaller what the script computes before any assertion",
)
def too_much_to_read(name: str, why: str) -> Diagnostic:
    """*why*: the limit and what was going on."""
    return Diagnostic("CSP920", f"`{name}` was not read to its end: {why}")


@mistake(
    "CSP930",
    "checkpoints of something else",
    explanation="""
A folder of checkpoints belongs to one script with all that it includes, one set of options and one version of cspcheck:
under another the states in it mean something else. The number of workers and the limits may differ. `--checkpoint`
begins in a folder that has no checkpoints yet, `--resume` goes on from one that has.
""",
    example="`--resume runs/rov` after a change to the script",
    repair="check with `--checkpoint` and a new folder",
)
def unsuited_checkpoint(folder: str, script: str, why: str) -> Diagnostic:
    """*folder* cannot be used for *script*; *why* in words that begin with ``its`` or ``it``."""
    return Diagnostic("CSP930", f"the folder `{folder}` cannot be used for `{script}`: {why}")


@mistake(
    "CSP921",
    "out of memory",
    explanation="""
The system had no more memory to give, outside of any check. (A check that runs out of memory has the verdict
`unknown`.) Nothing is known of what had not been told before.
""",
    example="a script of a gigabyte, on a machine that has no more",
    repair="end other programs, or use a machine with more memory",
)
def out_of_memory() -> Diagnostic:
    """The system has no more memory."""
    return Diagnostic("CSP921", "out of memory")


@mistake(
    "CSP906",
    "unknown code",
    explanation="`cspcheck explain` knows the codes that stand in square brackets behind `error` and `warning`.",
    example="cspcheck explain CSP2",
    repair="cspcheck explain CSP201",
)
def unknown_code(code: str, close: Sequence[str]) -> Diagnostic:
    """There is no mistake with this code; *close* are some that look like it."""
    hint = f"did you mean {' or '.join(f'`{c}`' for c in close)}?" if close else "`cspcheck explain` lists the codes"
    return Diagnostic("CSP906", f"there is no code `{code}`", help=hint)


@mistake(
    "CSP907",
    "unknown example",
    explanation="`cspcheck examples` lists the examples that come with cspcheck.",
    example="cspcheck examples submarine",
    repair="cspcheck examples rov",
)
def unknown_example(name: str, close: Sequence[str]) -> Diagnostic:
    """There is no example of this name; *close* are some that look like it."""
    hint = f"did you mean {' or '.join(f'`{c}`' for c in close)}?" if close else "`cspcheck examples` lists them"
    return Diagnostic("CSP907", f"there is no example `{name}`", help=hint)


@mistake(
    "CSP908",
    "a copy would overwrite",
    explanation="`--copy` writes new files only; what is there already stays as it is, and nothing was copied.",
    example="cspcheck examples rov --copy . (where `./rov` exists)",
    repair="cspcheck examples rov --copy new-folder",
)
def would_overwrite(name: str) -> Diagnostic:
    """The file or folder *name* exists."""
    return Diagnostic("CSP908", f"`{name}` exists already", help="copy to another folder, or remove it first")


@mistake(
    "CSP909",
    "a kind of file that cannot be checked",
    explanation="cspcheck reads CSPm scripts (`.csp`) and LaTeX documents with classes (`.tex`). Files of other kinds, "
    "known by their name, are not read.",
    example="cspcheck paper.pdf",
    repair="cspcheck script.csp",
)
def unknown_kind(name: str, suffix: str) -> Diagnostic:
    """The file *name* ends with *suffix*, which stands for something that is not a script."""
    return Diagnostic("CSP909", f"`{name}` is not a CSPm script: `{suffix}` files cannot be checked")


@mistake(
    "CSP910",
    "machine too large to draw",
    explanation="""
A picture of more than a few hundred states shows nothing. The limit keeps cspcheck from working for minutes on one.
""",
    example="cspcheck graph rov.csp ROV_Control_Module -o rov.svg",
    repair="""
cspcheck graph rov.csp Compass -o compass.svg
cspcheck graph rov.csp ROV_Control_Module --architecture -o rov.svg
""",
)
def too_large_to_draw(process: str, most: int) -> Diagnostic:
    """*process* has more than *most* states."""
    return Diagnostic(
        "CSP910",
        f"`{process}` has more than {most:,} states, too many for a picture",
        help="draw a component of it, draw the `--architecture`, or raise the limit with `--max-states`",
    )


@mistake(
    "CSP911",
    "unknown picture format",
    explanation="The ending of the file after `-o` tells the format of the picture: `.svg`, `.html` or `.dot`.",
    example="cspcheck graph rov.csp Compass -o compass.png",
    repair="cspcheck graph rov.csp Compass -o compass.svg",
)
def unknown_picture_format(path: str) -> Diagnostic:
    """The ending of *path* is none that can be drawn."""
    return Diagnostic(
        "CSP911", f"no picture format for `{path}`", help="the file must end in `.svg`, `.html` or `.dot`"
    )


@mistake(
    "CSP912",
    "no counterexample",
    explanation="""
`graph --trace` draws the counterexample of an assertion, and `probe --at` steps through it. An assertion that passes,
or has no verdict, has none; and one that was found by the solver, or in a reduced process that is too large to be
followed, may have no steps that could be taken one by one.
""",
    example="""
channel a
P = a -> P
assert P :[deadlock free]
""",
    repair="draw or probe the process itself, or name an assertion that fails",
)
def no_counterexample(assertion: str, verdict: str) -> Diagnostic:
    """The verdict of *assertion* came without a counterexample, or without its steps."""
    if verdict == "fail":
        return Diagnostic("CSP912", f"`{assertion}` fails, and there are no steps that lead to it one by one")
    return Diagnostic("CSP912", f"`{assertion}` has no counterexample: its verdict is {verdict}")


@mistake(
    "CSP913",
    "no assertion on that line",
    explanation="`FILE:LINE` means the assertion that stands on that line of the file, and there is none on it.",
    example="cspcheck probe --at philosophers.csp:1",
    repair="cspcheck probe --at philosophers.csp:30",
)
def no_assertion_there(place: str, assertions: Sequence[str]) -> Diagnostic:
    """*place* is ``FILE:LINE``; *assertions* are those that there are, with their places."""
    notes = ("the assertions are\n" + "\n".join(assertions[:10]) + ("\n..." if len(assertions) > 10 else ""),)
    return Diagnostic("CSP913", f"no assertion at `{place}`", notes=notes if assertions else ())


@mistake(
    "CSP914",
    "unknown setting",
    explanation="""
The table `[tool.cspcheck]` of `pyproject.toml` has a key that cspcheck does not know, so what it is meant to do would
not be done. The keys are `format`, `timeout`, `max-memory`, `max-states`, `workers`, `full`, `as-written`,
`termination`, `typecheck`, `view`, `outputs`, `color`, `quiet`, `verbose` and the table `definitions`.
""",
    example="""
[tool.cspcheck]
time-out = "5m"
""",
    repair="""
[tool.cspcheck]
timeout = "5m"
""",
)
def unknown_setting(key: str, close: Sequence[str], known: Sequence[str], place: Span | None) -> Diagnostic:
    """*key* is none of the *known* ones; *close* are those that look like it."""
    hint = f"did you mean {' or '.join(f'`{c}`' for c in close)}?" if close else f"the keys are {', '.join(known)}"
    return Diagnostic("CSP914", f"`[tool.cspcheck]` has no setting `{key}`", place, help=hint)


@mistake(
    "CSP915",
    "a setting with a wrong value",
    explanation="""
A value in the table `[tool.cspcheck]` of `pyproject.toml` means nothing. Values are written as on the command line:
times and sizes as text (`"5m"`, `"8GiB"`), switches as `true` or `false`, definitions as numbers or as text in CSPm.
""",
    example="""
[tool.cspcheck]
timeout = "soon"
""",
    repair="""
[tool.cspcheck]
timeout = "5m"
""",
)
def wrong_setting(key: str, message: str, place: Span | None) -> Diagnostic:
    """*message* says what is wrong with the value of *key*."""
    return Diagnostic("CSP915", f"setting `{key}`: {message}", place)


@mistake(
    "CSP916",
    "a settings file that cannot be read",
    explanation="""
The file `pyproject.toml` is not valid TOML, not UTF-8, or cannot be opened. It may hold settings for cspcheck (limits,
definitions); a verdict without them could be another one, so nothing is checked.
""",
    example="""
[tool.cspcheck
timeout = "5m"
""",
    repair="""
[tool.cspcheck]
timeout = "5m"
""",
)
def unreadable_settings(name: str, message: str) -> Diagnostic:
    """*message* is what the TOML reader says about the file *name*."""
    return Diagnostic("CSP916", f"cannot read `{name}`: {message[:1].lower()}{message[1:]}")


@mistake(
    "CSP917",
    "nothing to sweep over",
    explanation="""
`cspcheck sweep` checks scripts for several values of a constant, given with `-D`: a range `N=2..8`, or values separated
by commas, `N=2,4,8`. Commas inside brackets belong to a value: `S={0},{0,1}` are two. Several `-D` are combined.
""",
    example="cspcheck sweep philosophers.csp",
    repair="cspcheck sweep philosophers.csp -D N=2..8",
)
def nothing_to_sweep() -> Diagnostic:
    """No definition was given."""
    return Diagnostic("CSP917", "no values to sweep over", help="say which: `-D N=2..8`, `-D N=2,4,8`")


@mistake(
    "CSP821",
    "no record of an event",
    explanation="""
A recorded run has a line of JSON for each event: an object with the event as the specification writes it, or that text
alone. Other keys that matter: `hidden` (left out unless `--inside` is given), `time`, `tasks`.
""",
    example='{"evnt": "c.3"}',
    repair='{"event": "c.3"}',
)
def wrong_record(name: str, line: int, why: str) -> Diagnostic:
    """Line *line* of the run *name* is no record for the reason *why*."""
    return Diagnostic("CSP821", f"line {line} of `{name}` is no record of an event: {why}")


@mistake(
    "CSP824",
    "a wrong pattern file",
    explanation="""
A pattern file says how the lines of a log become events: `format` is `"log"`, `"csv"` or `"json"`; each `[[event]]` has
the text of an `event`, in which `{name}` stands for a field, and says which lines are meant: `match`, a regular
expression for a line of a log, or `when`, regular expressions for fields. `[values]` renames values. Lines that nothing
matches are no events.
""",
    example="""
[[event]]
match = "DRIVE (?P<source"
event = "drive.{source}"
""",
    repair="""
[[event]]
match = "DRIVE (?P<source>[A-Z]+)"
event = "drive.{source}"
""",
)
def wrong_pattern(name: str, why: str) -> Diagnostic:
    """The pattern file *name* is wrong for the reason *why*."""
    return Diagnostic("CSP824", f"`{name}`: {why}", help="`cspcheck explain CSP824` shows how such a file looks")


@mistake(
    "CSP825",
    "a process too large for a monitor",
    explanation="""
A monitor is a table: for each set of states that a process can be in after what was seen, what every event makes of it.
It must be finite, and small enough for the place where it is to run.
""",
    example="cspcheck monitor big.csp --process SYSTEM --target c -o monitor",
    repair="cspcheck monitor big.csp --process 'SYSTEM |\\ {| commands |}' --target c -o monitor",
)
def monitor_too_large(process: str, most: int) -> Diagnostic:
    """The table of *process* has more than *most* rows."""
    return Diagnostic(
        "CSP825",
        f"`{process}` has more than {most:,} states after what can be seen of it",
        help="monitor a requirement instead, or a part of the events: `P |\\ {| c |}`; or raise `--max-states`",
    )


@mistake(
    "CSP826",
    "a monitor would watch nothing, or too much",
    explanation="A monitor holds events against a process. A process that performs none that can be seen would let "
    "everything pass, and a monitor in C numbers at most 65,534 events.",
    example="cspcheck monitor buffer.csp --process STOP --target c -o monitor",
    repair="cspcheck monitor buffer.csp --process BUFFER --target c -o monitor",
)
def monitor_of_events(process: str, events: int) -> Diagnostic:
    """*process* performs no *events*, or more than have numbers."""
    if events == 0:
        text = f"`{process}` performs nothing that can be seen: a monitor of it would let everything pass"
        return Diagnostic("CSP826", text, help="is what should be seen hidden, or stopped by the composition?")
    text = f"`{process}` performs {events:,} events, a monitor in C has at most 65,534"
    return Diagnostic("CSP826", text, help="monitor a part of the events: `P |\\ {| c |}`")


@mistake(
    "CSP822",
    "the run cannot be read",
    explanation="The file with the recorded run is missing, or may not be read.",
    example="cspcheck trace rov.csp --process ROV no/such/run.jsonl",
    repair="python program/main.py --events 100 --record run.jsonl",
)
def cannot_read(name: str, reason: str) -> Diagnostic:
    """The file *name* cannot be read; *reason* is the system's word for why."""
    return Diagnostic("CSP822", f"cannot read `{name}`: {reason}")


@mistake(
    "CSP823",
    "too many states to follow",
    explanation="""
A run is followed by keeping all states in which the process can be after it. When these are too many (much happens
unseen), nothing is said about the run.
""",
    example="cspcheck trace big.csp --process 'SYSTEM \\ Events' run.jsonl",
    repair="cspcheck trace big.csp --process SYSTEM --inside run.jsonl",
)
def too_many_at_a_time(process: str) -> Diagnostic:
    """*process* can be in too many states after the same trace."""
    return Diagnostic(
        "CSP823",
        f"`{process}` can be in too many states at a time to follow the run",
        help="show more of what happens: `--inside` follows hidden events too",
    )


@mistake(
    "CSP918",
    "no assertion to notice a change",
    explanation="""
`cspcheck mutate` changes a script in one place after the other and looks which changes turn the verdict of an
assertion. Without an assertion whose verdict is `pass` or `fail` there is nothing to be turned.
""",
    example="""
channel a
P = a -> P
""",
    repair="""
channel a
P = a -> P
assert P :[deadlock free]
""",
)
def nothing_to_mutate(name: str) -> Diagnostic:
    """No assertion of the script *name* has a verdict."""
    return Diagnostic(
        "CSP918",
        f"no assertion of `{name}` has a verdict that a change could turn",
        help="add one, as in `assert P :[deadlock free]`, or raise the limits",
    )


@mistake(
    "CSP919",
    "an extra that is not installed",
    explanation="Some verbs need packages that not everybody wants; they are installed by the extra of that name.",
    example="cspcheck lsp (where pygls is not installed)",
    repair="pip install 'cspcheck[lsp]'",
)
def missing_extra(extra: str, package: str) -> Diagnostic:
    """The *package* of an *extra* is not installed."""
    return Diagnostic("CSP919", f"`{package}` is not installed", help=f"`pip install 'cspcheck[{extra}]'` installs it")
