"""Generated programs for tests: written into a folder, loaded from it, run and followed."""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import cspcheck
from cspcheck import testing
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.codegen import runtime
from cspcheck.codegen.design.pieces import InternalChoice
from cspcheck.codegen.design.program import design
from cspcheck.codegen.emit.keeping import write
from cspcheck.codegen.emit.project import project
from cspcheck.codegen.runtime import Deadlock, Program, Randomly, Record, VirtualClock

SPECS = Path(__file__).resolve().parents[2] / "specs"

EXAMPLES: tuple[tuple[str, str, InternalChoice], ...] = (
    ("producer_consumer/producer_consumer.csp", "SYSTEM", "refuse"),
    ("producer_consumer/producer_consumer.csp", "Repaired", "refuse"),
    ("producer_consumer/classes.csp", "SYSTEM", "refuse"),
    ("rov/rov.csp", "ROV_Control_Module", "refuse"),
    ("classics/philosophers.csp", "Symmetric", "refuse"),
    ("classics/buffer_chain.csp", "Chain", "refuse"),
    ("classics/milner.csp", "Scheduler", "refuse"),
    ("classics/peterson.csp", "System", "refuse"),
    ("classics/token_ring.csp", "Ring", "refuse"),
    ("classics/election.csp", "Election", "refuse"),
    ("classics/abp.csp", "Protocol", "policy"),
)
"""Script, process and internal choice of exhibits that are translated as they are written."""

TABLES: tuple[tuple[str, str, InternalChoice], ...] = (
    ("channels/choice.csp", "Should", "policy"),
    ("channels/data_sync.csp", "SlotEach(ID)", "policy"),
    ("freertps/freertps.csp", "Original({})", "refuse"),
    ("freertps/freertps.csp", "Proposed(Drop, Drop, {})", "refuse"),
    ("freertps/freertps.csp", "Discovering", "refuse"),
    ("freertps/reliability.csp", "Connection(Writer(0, <>), Network(EachKind, 1))", "policy"),
    ("microautoware/microautoware.csp", "Required(SIGNALS)", "refuse"),
    ("microautoware/microautoware.csp", "Control(SIGNALS, false)", "refuse"),
    ("microautoware/microautoware.csp", "Repaired(SIGNALS)", "refuse"),
    ("microautoware/serial.csp", "Serial(PLAIN, Line(1), false)", "policy"),
    ("microautoware/service.csp", "Service(Retry(2), Responses(1, 1))", "policy"),
    ("microautoware/tasks.csp", "Sharing(Behind)", "policy"),
    ("microautoware/tasks.csp", "Modes(AUTOWARE)", "policy"),
    ("microautoware/tasks.csp", "Owned", "policy"),
    ("robot_soccer/robot_soccer.csp", "Team(MIROSOT, {1..3})", "policy"),
    ("rov/annex_b.csp", "Architecture", "policy"),
    ("rov/annex_b.csp", "CodeRepaired", "policy"),
)
"""Those that have tasks which are tables of their states."""
SLOW: tuple[tuple[str, str, InternalChoice], ...] = (
    ("channels/commit.csp", "Protocol", "policy"),
    ("rov/data_view.csp", "ChainRepaired", "policy"),
)
"""Those that take longer to load or to follow than a test should."""


def generate(script: cspcheck.Script, process: str, folder: Path, internal_choice: InternalChoice = "refuse") -> None:
    """Write the program of a process."""
    write(project(design(script._script, process, internal_choice, Semantics()), str(folder)), folder)


@contextmanager
def loaded(folder: Path) -> Iterator[Any]:
    """The main module of the program in a folder.

    Its runtime is a copy of ours; here it is ours, so that tests can run the tasks with what they import themselves.
    """
    name = "program_under_test"
    spec = spec_from_file_location(name, folder / "__init__.py")
    assert spec is not None
    sys.modules[name] = module_from_spec(spec)
    sys.modules[f"{name}.runtime"] = runtime
    importlib.invalidate_caches()
    try:
        yield importlib.import_module(f"{name}.main")
    finally:
        for one in [one for one in sys.modules if one.partition(".")[0] == name]:
            del sys.modules[one]


def strictly_typed(folder: Path) -> str:
    """What ``mypy --strict`` has to say of the program in a folder: "" if nothing."""
    # What is found out about the standard library serves all programs.
    kept = Path(__file__).resolve().parents[2] / ".mypy_cache" / "programs"
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(kept), folder.name]
    done = subprocess.run(command, cwd=folder.parent, capture_output=True, text=True, env={"PATH": ""}, check=False)
    return "" if done.returncode == 0 else done.stdout + done.stderr


class Both:
    """Follows a run twice: what can be seen of it, and what is hidden as well."""

    def __init__(self, script: cspcheck.Script, process: str) -> None:
        self.outside = testing.follow(script, process)
        self.inside = testing.follow(script, process, inside=True)
        self.events = 0

    def record(self, record: Record) -> None:
        self.outside.record(record)
        self.inside.record(record)
        self.events += 1

    def close(self) -> None:
        self.outside.close()
        self.inside.close()


def followed(script: cspcheck.Script, process: str, folder: Path, events: int, seed: int) -> tuple[int, bool]:
    """Run random schedules of a program until so many events have been followed; how many, and whether it deadlocks."""
    both = Both(script, process)
    deadlocked = False
    with loaded(folder) as main:
        while both.events < events:
            try:
                Program(main.tasks()).run(
                    "loop",
                    clock=VirtualClock(),
                    policy=Randomly(seed),
                    recorder=both,
                    events=events - both.events,
                )
            except Deadlock:
                deadlocked = True
            seed += 1
    return both.events, deadlocked
