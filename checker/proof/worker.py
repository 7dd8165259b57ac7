"""The process of the solver, as it is seen from inside: it answers one request after the other until nobody asks.

The solver is a library of machine code that may crash, hang, or take all memory; here it takes nobody else along.
"""

from __future__ import annotations

import os
import sys
import threading
import time
import traceback
from typing import Any

from cspcheck.checker.proof.channel import ForeignValue, Sources, TooDeep, framed, packed, read, unpacked
from cspcheck.checker.proof.question import Failed, Request, SolverSettings
from cspcheck.cspm.recursion import deep_recursion

LOOK = 1.0
"""Seconds between two looks at whether there is still somebody who asks."""


def serve(parent: int | None = None) -> None:
    """Answer the requests on standard input.

    Args:
        parent: the process that asks.
    """
    if parent is not None:
        leave_with(parent)
    # What a library prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    requests = sys.stdin.buffer
    sources = Sources()
    known: dict[int, Any] = {}
    while True:
        content = read(requests)
        if content is None:
            return
        try:
            answer = _answered(unpacked(content, sources), known)
            reply = packed(answer, sources)
        except TooDeep:
            reply = packed(Failed("the answer is nested too deeply"), sources)
        except KeyboardInterrupt:
            return
        except ForeignValue as foreign:
            reply = packed(Failed(f"the question cannot be read: {foreign}"), sources)
        answers.write(framed(reply))
        answers.flush()


def leave_with(parent: int) -> None:
    """End this process when its parent has ended, whatever it is at.

    Who was killed cannot end us, and that there are no more requests is not seen while the solver works on one.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK)
        os._exit(1)

    threading.Thread(target=watch, daemon=True, name="parent").start()


def _answered(request: Request, known: dict[int, Any]) -> Any:
    from cspcheck.checker.proof.solver import Solver

    if request.specification is not None:
        known[request.subject] = (request.specification, request.model)
    specification, model = known[request.subject]
    texts: list[tuple[str, str]] | None = [] if request.smtlib else None
    settings = SolverSettings(seconds=request.seconds, scopes=request.scopes, seed=request.seed, smtlib=texts)
    solver = Solver(specification, model, settings, first_query=request.first_query)
    solver.name = request.name
    try:
        with deep_recursion():
            match request.verb:
                case "ask":
                    answer: Any = solver.ask(request.what)
                case "conflict":
                    answer = solver.conflict(request.what)
                case "core":
                    answer = solver.core(request.what)
                case "needed":
                    answer = solver.needed(request.what)
                case "eliminate":
                    from cspcheck.checker.proof.elimination import without_quantifiers

                    answer = without_quantifiers(specification, request.what, request.seconds)
                case "solve":
                    from cspcheck.checker.proof.horn import solution
                    from cspcheck.checker.proof.solver import STEPS

                    answer = solution(specification, request.what, int(request.seconds * STEPS))
                case _:
                    answer = Failed(f"nobody knows how to {request.verb}")
    except MemoryError:
        return Failed("the solver is out of memory")
    except RecursionError:
        return Failed("the question is nested too deeply")
    except Exception:
        # A mistake of ours: the other side raises it where it can be reported.
        return Failed(traceback.format_exc(), ours=True)
    return answer, texts
