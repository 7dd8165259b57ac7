"""Whether a queue may stand for a channel: the composition with a buffer there refines the one without it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from cspcheck import checking
from cspcheck.checker.lts import Lts
from cspcheck.checker.verdict import Verdict
from cspcheck.codegen import messages
from cspcheck.codegen.design.buffers import Buffer, buffer, rows
from cspcheck.cspm.diagnostics import ScriptError

if TYPE_CHECKING:
    from cspcheck.codegen.design.system import System
    from cspcheck.cspm.script import Script

SECONDS = 60.0
"""How long the refinement may take."""


def queued(
    system: System, script: Script, asked: Sequence[tuple[str, int]], need: str | None = None
) -> tuple[Buffer, ...]:
    """The queues of a program, shown to be as good as the channels: in failures and divergences, all of them together.

    Args:
        system: the program.
        script: where it comes from.
        asked: channels, each with the length of its queue.
        need: the process that the program must refine; the one without queues if it is None.

    Raises:
        ScriptError: there is a channel that cannot be a queue, or it is not shown that the queues refine the channels.
    """
    from cspcheck.checker.check import Checker
    from cspcheck.checker.semantics.machine_states import ExplicitMachine
    from cspcheck.cspm.process.terms import STOP

    buffers = tuple(buffer(system, label, length) for label, length in asked)
    if not buffers:
        return ()
    lts = Lts.from_successors(rows(system, buffers))
    checker = Checker(script, limits=checking.limits(seconds=SECONDS))
    term = ExplicitMachine(lts, STOP).term(lts.root)
    specification = need or system.process
    outcome = checker.check_refinement(script.process(specification), "FD", term)
    if outcome.verdict is Verdict.PASS:
        return buffers
    names = ", ".join(dict(asked))
    found = outcome.counterexample
    if found is None:
        raise ScriptError(messages.no_queue(names, f"it is not shown to refine `{specification}`: {outcome.reason}"))
    seen = ", ".join(event for event in found.trace if event != found.tau) or "nothing"
    match found.kind:
        case "trace":
            what = f"then `{found.event}` is possible, which `{specification}` does not allow"
        case "divergence":
            what = f"then it can go on by itself for ever, which `{specification}` does not"
        case _:
            what = f"then it may refuse what `{specification}` must offer"
    raise ScriptError(messages.no_queue(names, f"with it the program is no refinement: after {seen}, {what}"))
