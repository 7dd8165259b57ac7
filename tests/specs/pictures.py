"""The pictures of the exhibits: ``python -m tests.specs.pictures`` draws them into the folders of specs/.

Each is what ``cspcheck graph`` draws of a process of a script: its architecture, or its machine.
"""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from cspcheck.cli import front_door
from tests.specs.table import SPECS

PICTURES = {
    "channels/slots.svg": ("data_sync.csp", "SlotEach(ID)", "--architecture"),
    "classics/philosophers.svg": ("philosophers.csp", "Symmetric", "--architecture"),
    "freertps/connection.svg": ("reliability.csp", "Connection(Writer(0, <>), Network(EachKind, 1))", "--architecture"),
    "freertps/original.svg": ("freertps.csp", "Original({})", "--architecture"),
    "freertps/proposed.svg": ("freertps.csp", "Proposed(Drop, Drop, {})", "--architecture"),
    "microautoware/modes.svg": ("tasks.csp", "Modes(AUTOWARE)", "--architecture"),
    "microautoware/thread.svg": ("microautoware.csp", "Thread(SIGNALS, false)", "--architecture"),
    "producer_consumer/architecture.svg": ("producer_consumer.csp", "Repaired", "--architecture"),
    "producer_consumer/classes.svg": ("classes.csp", "SYSTEM", "--architecture"),
    "robot_soccer/link.svg": ("robot_soccer.csp", "Parts(MIROSOT, APART, 1, 1)", "--architecture"),
    "robot_soccer/team.svg": ("robot_soccer.csp", "Team(MIROSOT, {1..3})", "--architecture"),
    "rov/architecture.svg": ("rov.csp", "ROV_Control_Module", "--architecture"),
    "stack/two_pushes.svg": ("stack.csp", "Stack [| {| push |} |] (push?x -> push?y -> STOP)"),
}
"""What each picture is of: a script beside it, a process of that script, and how it is drawn."""


def drawn(picture: str) -> str:
    """What the tool draws now where *picture* is."""
    script, process, *options = PICTURES[picture]
    file = (SPECS / picture).with_name(script)
    said = CliRunner().invoke(front_door, ["graph", str(file), process, *options], catch_exceptions=False)
    assert said.exit_code == 0, said.stderr
    return said.stdout


def main() -> None:
    for picture in PICTURES:
        (SPECS / picture).write_text(drawn(picture), encoding="utf-8")


def stored() -> set[str]:
    """The pictures that lie in specs/."""
    return {path.relative_to(SPECS).as_posix() for path in SPECS.rglob("*.svg")}


def page_of(picture: str) -> Path:
    """The README beside *picture*."""
    return (SPECS / picture).with_name("README.md")


if __name__ == "__main__":
    main()
