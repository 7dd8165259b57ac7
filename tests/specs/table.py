"""The tables of the exhibits: ``python -m tests.specs.table [SYSTEM]...`` writes them into the README files of specs/.

A README that has the two marks below gets between them the assertions of the scripts of its folder, with verdict,
states and seconds; ``specs/README.md`` gets a line for each system. Every check explores its whole state space, so the
counts are those of the system and not of the way in which it is explored; the times are those of the machine that
writes the table, and the test that keeps the tables true looks past them.
"""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import cspcheck
from cspcheck.result import Result

SPECS = Path(__file__).resolve().parents[2] / "specs"
BEGIN = "<!-- written by python -m tests.specs.table -->"
END = "<!-- end of the table -->"


def scripts(place: Path) -> list[Path]:
    return sorted(place.rglob("*.csp"))


def systems() -> list[Path]:
    return [place for place in sorted(SPECS.iterdir()) if place.is_dir() and scripts(place)]


@cache
def results(script: Path) -> tuple[Result, ...]:
    """What the whole state spaces of a script's assertions say; found once in a run."""
    return tuple(cspcheck.load(script).check(full=True, workers=1))  # tests run side by side


def own_results(script: Path) -> list[Result]:
    """The results of a script without those of assertions in files that it includes, which are told there."""
    return [result for result in results(script) if Path(result.file).resolve() == script]


def assertions_table(system: Path) -> str:
    """A row for each assertion of the scripts of *system*."""
    rows = ["| line | assertion | verdict | states | seconds |", "|---|---|---|--:|--:|"]
    for script in scripts(system):
        for result in own_results(script):
            verdict = str(result.verdict) if result.verdict == result.expected else f"**{result.verdict}**"
            text = " ".join(result.assertion.split()).replace("|", "\\|")
            states = f"{result.states:,}" if result.states else ""
            path = script.relative_to(system).as_posix()
            place = f"[{path}:{result.line}]({path}#L{result.line})"
            rows.append(f"| {place} | `{text}` | {verdict} | {states} | {result.seconds:.2f} |")
    return "\n".join(rows)


def systems_table() -> str:
    """A row for each system: how many assertions it has, how they come out, what that takes; from their own tables."""
    rows = ["| system | | assertions | pass | fail | states | seconds |", "|---|---|--:|--:|--:|--:|--:|"]
    everything: list[Row] = []
    for system in systems():
        found = written_rows(system)
        everything += found
        rows.append(f"| [{system.name}]({system.name}/) | {title(system)} | {summary(found)} |")
    rows.append(f"| all | | {summary(everything)} |")
    return "\n".join(rows)


class Row(NamedTuple):
    """What a row of a system's table says of an assertion."""

    verdict: str
    states: int
    seconds: float


def written_rows(system: Path) -> list[Row]:
    """The rows of the table that stands in the page of *system*."""
    _, rest = (system / "README.md").read_text(encoding="utf-8").split(BEGIN)
    table, _ = rest.split(END)
    found: list[Row] = []
    for line in table.strip().splitlines()[2:]:
        verdict, states, seconds = (cell.strip() for cell in line.strip("| ").rsplit(" | ", 3)[1:])
        found.append(Row(verdict, int(states.replace(",", "") or 0), float(seconds)))
    return found


def summary(found: list[Row]) -> str:
    """The numbers of some assertions, as the cells of a row."""
    verdicts = [row.verdict.strip("*") for row in found]
    unexpected = sum("*" in row.verdict for row in found)
    failed = f"{verdicts.count('fail')}" + (f" (**{unexpected} not as expected**)" if unexpected else "")
    states, seconds = sum(row.states for row in found), sum(row.seconds for row in found)
    return f"{len(found)} | {verdicts.count('pass')} | {failed} | {states:,} | {seconds:.2f}"


def title(system: Path) -> str:
    """The heading of a system's page."""
    return (system / "README.md").read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")


def readmes() -> list[Path]:
    """The README files that hold a table, that of all systems last: it is made from the others."""
    found = [*(system / "README.md" for system in systems()), SPECS / "README.md"]
    return [readme for readme in found if readme.exists() and BEGIN in readme.read_text(encoding="utf-8")]


def as_it_should_be(readme: Path) -> str:
    """The text of *readme* with its table as the scripts are now."""
    before, rest = readme.read_text(encoding="utf-8").split(BEGIN)
    _, after = rest.split(END)
    table = systems_table() if readme.parent == SPECS else assertions_table(readme.parent)
    return f"{before}{BEGIN}\n{table}\n{END}{after}"


def without_times(text: str) -> str:
    """*text* without the last cell of the rows of its tables, the seconds."""
    return re.sub(r"\| [\d.]+ \|$", "| |", text, flags=re.MULTILINE)


def main(names: list[str]) -> None:
    """Write the tables of the named systems and that of all; without names, those in which more than times differ."""
    for readme in readmes():
        if names and readme.parent != SPECS and readme.parent.name not in names:
            continue
        text, wanted = readme.read_text(encoding="utf-8"), as_it_should_be(readme)
        if names or without_times(text) != without_times(wanted):
            readme.write_text(wanted, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
