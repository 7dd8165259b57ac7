"""Mistakes in generating programs (CSP8xx): why something cannot be generated. One builder each."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Severity, mistake
from cspcheck.cspm.source import Span


@mistake(
    "CSP801",
    "which process to generate",
    explanation="""
A program is generated from one process: a composition of named processes. A script with several that nothing else
composes further does not say which one is meant.
""",
    example="""
channel a
P = a -> P
Q = a -> Q
""",
    repair="cspcheck gen script.csp --process SYSTEM -o program",
)
def no_process(candidates: Sequence[str]) -> Diagnostic:
    """*candidates* are the processes that may be meant."""
    found = f"; it may be {', '.join(f'`{c}`' for c in candidates)}" if candidates else ""
    return Diagnostic(
        "CSP801", f"it is not clear which process to generate{found}", help="name it with `--process NAME`"
    )


@mistake(
    "CSP802",
    "a task without a name",
    explanation="""
Every process that runs by itself becomes a task with a module of its own, which is called like the process. An
expression in a composition that is no name (with arguments, if need be) of a definition at the top of the script has no
name to give.
""",
    example="""
channel a, b
SYSTEM = (a -> STOP) ||| (b -> STOP)
""",
    repair="""
channel a, b
Left = a -> STOP
Right = b -> STOP
SYSTEM = Left ||| Right
""",
)
def unnamed_task(text: str, span: Span | None) -> Diagnostic:
    """The process *text* runs in parallel with others and has no name."""
    return Diagnostic(
        "CSP802",
        f"`{text}` has no name to call its task by",
        span,
        help="give it a definition at the top of the script, and compose that",
    )


@mistake(
    "CSP803",
    "processes that come into being later",
    explanation="""
The tasks of a generated program are there from its start to its end. A process that becomes several while it runs (a
parallel composition, hiding or renaming behind an event or a recursion) has no fixed set of tasks.
""",
    example="""
channel a
P = a -> (P ||| P)
""",
    repair="""
channel a
P = a -> P
SYSTEM = P ||| P
""",
)
def dynamic(task: str, operator: str, span: Span | None) -> Diagnostic:
    """*task* contains *operator* behind its beginning."""
    return Diagnostic(
        "CSP803",
        f"`{task}` applies {operator} while it runs, so its tasks are not known from the start",
        span,
        help="compose the processes once, outside the recursion",
    )


@mistake(
    "CSP804",
    "an internal choice that nobody makes",
    explanation="""
`P |~| Q` leaves the choice to whoever builds the system. A program must make it, and the script does not say how.
`--internal-choice policy` leaves it to the program's policy, as it is run: in turn, or at random.
""",
    example="""
channel a, b
P = a -> P |~| b -> P
""",
    repair="cspcheck gen script.csp --internal-choice policy -o program",
)
def internal_choice(span: Span) -> Diagnostic:
    """There is an internal choice, and no policy for it was given."""
    return Diagnostic(
        "CSP804",
        "this internal choice needs a decision, and nobody is named who makes it",
        span,
        help="say `--internal-choice policy`, or write an external choice",
    )


@mistake(
    "CSP805",
    "something that is not generated",
    explanation="""
Tasks are generated from prefixes, external choice, guards, `if`, `let` with values, `;`, STOP, SKIP and calls of
definitions at the top of the script; expressions from numbers, truth values, constants of datatypes, tuples, sequences
and sets. What is outside that is refused before anything is written.
""",
    example=r"""
channel a, b
P = (a -> P) /\ b -> STOP
SYSTEM = P
""",
    repair="""
channel a, b
P = a -> P [] b -> STOP
SYSTEM = P
""",
)
def not_generated(what: str, span: Span | None, help: str | None = None) -> Diagnostic:
    """*what* has no translation."""
    return Diagnostic("CSP805", f"no code is generated for {what}", span, help=help)


@mistake(
    "CSP806",
    "renaming or hiding of a part of a channel",
    explanation="""
A channel of the program is one object that a task has by one name. Renaming is generated where it renames whole
channels, hiding where it hides whole channels.
""",
    example="""
channel a, b : {0..1}
P = a?x -> P
SYSTEM = P[[a.0 <- b.1]]
""",
    repair="""
channel a, b : {0..1}
P = a?x -> P
SYSTEM = P[[a <- b]]
""",
)
def part_of_channel(what: str, channel: str) -> Diagnostic:
    """*what* (``renames``, ``hides``, ``links``) touches a part of *channel*."""
    return Diagnostic(
        "CSP806",
        f"the composition {what} a part of `{channel}`, or not field by field",
        help=f"let it be all of `{channel}`",
    )


@mistake(
    "CSP812",
    "renaming that makes two channels one",
    explanation="""
After a renaming that maps two channels to one, an event of that does not tell any more who has to take part in it: that
may differ between the two. Renaming is generated where different channels stay different.
""",
    example="""
channel a, b
P = a -> b -> P
SYSTEM = (P ||| P)[[a <- b]]
""",
    repair="""
channel a, b, c
P = a -> b -> P
SYSTEM = (P ||| P)[[a <- c]]
""",
)
def merged(channel: str) -> Diagnostic:
    """Two channels are *channel* after a renaming."""
    return Diagnostic(
        "CSP812",
        f"the composition renames two channels to `{channel}`",
        help="rename to a channel that the process does not have",
    )


@mistake(
    "CSP807",
    "a value without a type in Python",
    explanation="A value in the program's text must be a number, a truth value, a constant or made of these.",
    example="""
channel a
P(events) = a -> P(events)
SYSTEM = P({a}) ||| P({a})
""",
    repair="""
channel a
P = a -> P
SYSTEM = P ||| P
""",
)
def no_value(text: str, where: str, span: Span | None = None) -> Diagnostic:
    """The value *text* cannot be written in Python; *where* it was met."""
    return Diagnostic("CSP807", f"`{text}` in {where} has no counterpart in Python", span)


@mistake(
    "CSP808",
    "a generated file was edited",
    explanation="""
Generated files are written anew each time. One that was edited since (its content is not what was written) would lose
the edits, so nothing is written at all. What a person writes belongs in the files that end in `_methods.py`; they are
written once and never touched again.
""",
    example="edit `channels.py` in the folder of a program, and run `cspcheck gen` again",
    repair="move the edits to the `_methods.py` file; or `--force`, which keeps the edited file beside the new one",
)
def edited(paths: Sequence[str]) -> Diagnostic:
    """The files *paths* are not as they were generated."""
    files = ", ".join(f"`{path}`" for path in paths)
    return Diagnostic(
        "CSP808",
        f"{files} {'was' if len(paths) == 1 else 'were'} edited since the last generation; nothing was written",
        help="move the edits to the `_methods.py` files, or say `--force` to have edited files kept as `NAME.edited`",
    )


@mistake(
    "CSP809",
    "hand-written methods do not fit any more",
    explanation="""
The specification has changed: a task has other methods, or methods with other parameters, than its `_methods.py` file
(in C `methods.c`, in Ada `methods.adb`) was written for. The file is never changed by `cspcheck gen`, which ends with
1; the message shows what to change in it.
""",
    example="a method `m` of a process becomes `m!x`, and its body in `p_methods.py` is still `def m(self) -> None`",
    repair="change the definition in the file to the one that the message shows",
)
def interface_changed(path: str, differences: Sequence[str]) -> Diagnostic:
    """What the file *path* has and what it should have, as lines of a difference."""
    return Diagnostic(
        "CSP809",
        f"`{path}` does not fit the specification any more",
        severity=Severity.WARNING,
        notes=("\n".join(differences),),
        help=f"`{path}` is yours and was not touched: change it as shown",
    )


@mistake(
    "CSP810",
    "a folder with other things in it",
    explanation="""
`cspcheck gen` writes into an empty or new folder, or into one that it has written before (it knows it by the file
`.cspcheck-gen.json`). It does not write among other files, which might have the names of its own.
""",
    example="cspcheck gen script.csp -o .",
    repair="cspcheck gen script.csp -o program",
)
def foreign_folder(path: str, files: Sequence[str]) -> Diagnostic:
    """The folder *path* has *files* in it that a generation would overwrite."""
    return Diagnostic(
        "CSP810",
        f"`{path}` has {', '.join(f'`{f}`' for f in files)} in it, which cspcheck did not write",
        help="name a new folder after `-o`",
    )


@mistake(
    "CSP814",
    "a process too large for a table",
    explanation="""
A process that does not read as a program (or is to run on a target that runs tables) is generated as its states and the
events between them. Data that is counted in thousands belongs into variables, not into a table.
""",
    example="""
channel c : {0..9}
P(s) = #s < 6 & c?x -> P(s^<x>)
SYSTEM = P(<>)
""",
    repair="smaller types (`-D N=2`, `reading nat = 0..3`), or a definition that can be translated as it is written",
)
def too_large(name: str, what: str, most: int, span: Span | None) -> Diagnostic:
    """The machine of *name* has more than *most* of *what*."""
    return Diagnostic(
        "CSP814",
        f"`{name}` has more than {most:,} {what}, too many for a table",
        span,
        help="give its data smaller types, or divide it into several processes",
    )


@mistake(
    "CSP813",
    "a list of generated files that names others",
    explanation="""
`.cspcheck-gen.json` says which files of a folder `cspcheck gen` has written; those that are not needed any more are
removed, those that were edited are kept under another name. A list with a name that leads out of the folder was not
written by it, so nothing is done at all.
""",
    example="a cloned repository whose list of generated files has `../notes.txt` in it",
    repair="remove `.cspcheck-gen.json`, or generate into a new folder",
)
def strange_list(path: str, names: Sequence[str]) -> Diagnostic:
    """The list *path* has *names* that no generation gives."""
    shown = ", ".join(f"`{name}`" for name in names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
    return Diagnostic(
        "CSP813",
        f"`{path}` names {shown}, which is no file that `cspcheck gen` writes; nothing was written",
        help="generate into a new folder, or remove the list if the files in the folder are not yours",
    )


@mistake(
    "CSP815",
    "a queue that cannot stand for a channel",
    explanation="""
With `--queue c=4` a channel is a queue of four values: the sender goes on before its value has been received. That is
done only where the composition with such a buffer refines the one without it in failures and divergences, so whatever
has been shown of the process is true of the program. Nobody may see that the sender is ahead: what it does next is
internal, or waits for the receiver anyway. The channel leads from one task, which offers nothing else when it sends, to
one that only receives on it then and takes every value.
""",
    example="""
channel a, b, c
P = a -> c -> P
C = c -> b -> C
SYSTEM = (P [| {c} |] C) \\ {c}
-- with a queue of 2 for c: a, a, a, a before the first b
""",
    repair="""
channel b, c
P = c -> P
C = c -> b -> C
SYSTEM = (P [| {c} |] C) \\ {c}
-- what P does otherwise is seen by nobody
""",
)
def no_queue(channel: str, why: str) -> Diagnostic:
    """The *channel* cannot be a queue for the reason *why*."""
    return Diagnostic(
        "CSP815",
        f"`{channel}` cannot be a queue: {why}",
        help="leave the option out; the channel is a rendezvous then",
    )


@mistake(
    "CSP811",
    "a timing comment that is not understood",
    explanation="""
Comments of the form `-- task NAME: period 100 ms at EVENT, offset 10 ms, priority 5` say how a task is run: `at` names
the event of the process that waits for the next release. Each part may be left out, but a period needs its event.
""",
    example="""
channel a, next
P = a -> next -> P
-- task P: period often at next
SYSTEM = P
""",
    repair="""
channel a, next
P = a -> next -> P
-- task P: period 100 ms at next
SYSTEM = P
""",
)
def wrong_timing(text: str, why: str, span: Span) -> Diagnostic:
    """The comment *text* is wrong for the reason *why*."""
    return Diagnostic("CSP811", f"`{text}`: {why}", span)
