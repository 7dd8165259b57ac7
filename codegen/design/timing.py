"""Comments that say how tasks are run: ``-- task Compass: period 100 ms at nextCps, offset 30 ms, priority 5``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from cspcheck.codegen import messages
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.syntax import tree as syntax

_COMMENT = re.compile(r"^(?:--|\{-)\s*task\s+([A-Za-z_]\w*)\s*:\s*(.*?)\s*(?:-\})?$", re.DOTALL)
_TOCK = re.compile(r"^(?:--|\{-)\s*tock\s*:\s*(.*?)\s*(?:-\})?$", re.DOTALL)
_TIME = re.compile(r"^(\d+(?:\.\d+)?)\s*(ms|s|min)$")
_SECONDS = {"ms": 0.001, "s": 1.0, "min": 60.0}


@dataclass(frozen=True, slots=True)
class TaskTiming:
    """How a task is run; ``at`` is the event that waits for its next release."""

    period: float | None = None
    offset: float = 0.0
    priority: int = 0
    at: str | None = None


def timings(script: syntax.Script) -> dict[str, TaskTiming]:
    """What the comments of a script say, by the name of the definition.

    Raises:
        ScriptError: a comment of this form is not understood.
    """
    found: dict[str, TaskTiming] = {}
    for comment in script.comments:
        match = _COMMENT.match(comment.text.strip())
        if match is None:
            continue
        name, text = match.groups()
        period: float | None = None
        offset, priority, at = 0.0, 0, None
        for part in filter(None, (piece.strip() for piece in text.split(","))):
            word, _, rest = part.partition(" ")
            if word == "period":
                amount, _, event = rest.partition(" at ")
                period, at = _time(amount), event.strip() or None
                if period is None or at is None:
                    why = "a period is written as `period 100 ms at EVENT`"
                    raise ScriptError(messages.wrong_timing(part, why, comment.span))
            elif word == "offset" and (time := _time(rest)) is not None:
                offset = time
            elif word == "priority" and rest.strip().lstrip("-").isdigit():
                priority = int(rest)
            else:
                why = "expected `period TIME at EVENT`, `offset TIME` or `priority NUMBER`"
                raise ScriptError(messages.wrong_timing(part, why, comment.span))
        found[name] = TaskTiming(period, offset, priority, at)
    return found


def tock(script: syntax.Script) -> float:
    """The seconds that an event of `tock` stands for, as a comment says: ``-- tock: 10 ms``; one if none does.

    Raises:
        ScriptError: a comment of this form is not understood.
    """
    found = 1.0
    for comment in script.comments:
        match = _TOCK.match(comment.text.strip())
        if match is not None:
            time = _time(match[1])
            if time is None or time <= 0:
                why = "the time of a tock is written as `tock: 10 ms`"
                raise ScriptError(messages.wrong_timing(comment.text.strip(), why, comment.span))
            found = time
    return found


def _time(text: str) -> float | None:
    match = _TIME.match(text.strip())
    return None if match is None else round(float(match[1]) * _SECONDS[match[2]], 9)
