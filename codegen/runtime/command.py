"""The command line of a generated program."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence

from . import contracts
from .alternation import Fair, InOrder, NobodyDecides, Policy, Randomly
from .channel import WrongOffer
from .clock import MonotonicClock, VirtualClock
from .data import OutOfRange
from .program import Program
from .recorder import JsonLines
from .task import Task, WrongMethods
from .waiting import Deadlock


def command(tasks: Sequence[Task] | Callable[[], Sequence[Task]], arguments: Sequence[str] | None = None) -> int:
    """Run some tasks, or those that a function makes, as the command line says.

    Returns:
        The exit code: 0 the program ended or was stopped as asked; 1 deadlock, a value outside its range, a broken
        contract, methods that do not fit; 2 wrong usage; 130 interrupted.
    """
    options = _parser().parse_args(arguments)
    contracts.switch(options.contracts == "on")
    policy: Policy = {"fair": Fair, "in-order": InOrder}.get(options.policy, Fair)()
    if options.policy == "random":
        policy = Randomly(options.seed)
    try:
        program = Program(tasks() if callable(tasks) else tasks)
        summary = program.run(
            options.runner,
            clock=VirtualClock() if options.clock == "virtual" else MonotonicClock(),
            policy=policy,
            recorder=JsonLines(options.record) if options.record else None,
            events=options.events,
            seconds=options.seconds,
        )
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    except (Deadlock, OutOfRange, WrongMethods, WrongOffer, NobodyDecides, contracts.Broken) as error:
        notes = "".join(f" ({note})" for note in dict.fromkeys(getattr(error, "__notes__", ())))
        print(f"{error}{notes}", file=sys.stderr)
        return 1
    end = "all tasks have ended" if summary.terminated else "stopped"
    print(f"{summary.events} events in {summary.seconds:.3f} s; {end}", file=sys.stderr)
    for task, missed in summary.missed.items():
        if missed:
            print(f"{task} missed {missed} releases", file=sys.stderr)
    for task in summary.lingering:
        print(f"{task} did not stop", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description="Run the program.", allow_abbrev=False)
    parser.add_argument("--record", metavar="FILE", help="write every event to FILE, a line of JSON each")
    parser.add_argument("--events", type=int, metavar="N", help="stop after N events")
    parser.add_argument("--seconds", type=float, metavar="S", help="stop at this time of the program's clock")
    parser.add_argument(
        "--runner", choices=["threads", "asyncio", "loop"], default="threads", help="who carries the tasks"
    )
    parser.add_argument("--clock", choices=["monotonic", "virtual"], default="monotonic", help="virtual: time is free")
    parser.add_argument(
        "--policy",
        choices=["fair", "in-order", "random"],
        default="fair",
        help="what decides between several possible events, and what no task decides",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="for --policy random")
    parser.add_argument("--contracts", choices=["on", "off"], default="on", help="off: do not check methods")
    return parser
