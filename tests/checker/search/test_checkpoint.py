"""A search that is ended in the midst and taken up again finds what one finds that was left in peace."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from cspcheck.checker.budget import Budget
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search import checkpoint, levels
from cspcheck.checker.search.checkpoint import Checkpoints, Mismatch
from cspcheck.checker.search.exploration import Exploration, explore
from cspcheck.checker.search.spill import Spill
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

SCRIPT = """
channel a, b, c : {0..1}
P(i) = a.i -> Q(i) [] c.i -> P((i + 1) % 2)
Q(i) = b.i -> P(i) |~| b.((i + 1) % 2) -> Q(i)
S = (P(0) ||| (P(1) \\ {| c |})) [| {| a |} |] (a?x -> Q(x))
"""


class Ended(BaseException):
    """The run ends here, as by a reboot."""


def belongs(**more: str) -> dict[str, str]:
    return {"version": "1", "script": "abc", **more}


@pytest.fixture
def packed() -> PackedNetwork:
    script = load(Source("s.csp", SCRIPT))
    return Machines().packed(script.process("S"), Budget(Limits()))


def told(found: Exploration) -> tuple[object, ...]:
    return (
        found.levels,
        found.transitions,
        found.complete,
        found.stop,
        found.deadlock_level,
        found.divergence_level,
        found.has_tau,
        found.branching,
        sorted(map(tuple, found.states.tolist())),
    )


@pytest.mark.parametrize("on_disk", [False, True])
@pytest.mark.parametrize("aim", ["everything", "deadlock", "divergence"])
def test_a_search_that_is_ended_again_and_again_finds_the_same(
    aim: str, on_disk: bool, packed: PackedNetwork, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    aims = {"stop_at_deadlock": aim == "deadlock", "stop_at_divergence": aim == "divergence"}
    expected = told(explore(packed, compiled=False, **aims))
    monkeypatch.setattr(levels, "INTERPRETED_ROWS", 7)
    chance = random.Random(1)
    check = levels.LevelSearch._check
    looks = 0

    def ending(search: levels.LevelSearch, frontier: int) -> None:
        nonlocal looks
        looks -= 1
        if looks < 0:
            raise Ended
        check(search, frontier)

    monkeypatch.setattr(levels.LevelSearch, "_check", ending)
    runs = 0
    while True:
        folder = Checkpoints(tmp_path / "c", belongs(), resume=runs > 0, every=0.0)
        # Later runs come further: none would ever end if each lost more than it gained.
        looks = chance.randrange(3, 12 + 2 * runs)
        runs += 1
        try:
            spill = Spill(tmp_path / "s", rows=20) if on_disk else None
            found = explore(packed, compiled=False, checkpoints=folder, beyond=spill, **aims)
        except Ended:
            continue
        break
    assert runs > 3 or aim == "divergence"
    # On disk only the states that lead to something are at hand afterwards.
    assert told(found)[:-1] == expected[:-1]
    assert on_disk or told(found) == expected


def test_a_checkpoint_from_disk_is_one_for_memory_and_the_other_way_round(
    packed: PackedNetwork, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With other limits, whatever they were before; and what lies in the folder is what counts."""
    whole = told(explore(packed, compiled=False))
    monkeypatch.setattr(levels, "INTERPRETED_ROWS", 3)
    check, looks = levels.LevelSearch._check, 0

    def ending(search: levels.LevelSearch, frontier: int) -> None:
        nonlocal looks
        looks -= 1
        if looks < 0:
            raise Ended
        check(search, frontier)

    monkeypatch.setattr(levels.LevelSearch, "_check", ending)
    kinds: list[bool] = []
    for run, rows in enumerate([20, None, 20, None, 40, 20, None]):
        folder = Checkpoints(tmp_path / "c", belongs(), resume=run > 0, every=0.0)
        spill = None if rows is None else Spill(tmp_path / "s", rows=rows)
        looks = 10 + 8 * run if run < 6 else 10**6
        try:
            found = explore(packed, compiled=False, checkpoints=folder, beyond=spill)
        except Ended:
            kinds.append(any(path.suffix == ".sorted" for path in (tmp_path / "c").iterdir()))
            assert len([path for path in (tmp_path / "c").iterdir() if path.suffix in (".rows", ".sorted")]) <= 2
    assert told(found) == whole
    assert {True, False} == set(kinds), kinds


def test_a_limit_that_is_reached_is_a_checkpoint(packed: PackedNetwork, tmp_path: Path) -> None:
    whole = told(explore(packed, compiled=False))
    first = Checkpoints(tmp_path / "c", belongs(), resume=False)
    stopped = explore(packed, compiled=False, checkpoints=first, limits=Limits(seconds=0.0))
    assert stopped.stop == "seconds"
    again = Checkpoints(tmp_path / "c", belongs(), resume=True)
    for workers in (1, 2):
        assert told(explore(packed, compiled=False, checkpoints=again, workers=workers)) == whole


def test_wherever_the_counts_of_a_checkpoint_are_damaged_they_are_not_believed(
    packed: PackedNetwork, tmp_path: Path
) -> None:
    """A digit that is another one makes a file that can be read as well."""
    explore(packed, compiled=False, checkpoints=Checkpoints(tmp_path / "c", belongs(), resume=False, every=0.0))
    (path,) = [path for path in (tmp_path / "c").glob("*.json") if path.name != checkpoint.MANIFEST]
    whole = path.read_bytes()
    folder = Checkpoints(tmp_path / "c", belongs(), resume=True)
    assert checkpoint.Checkpoint(folder, path.stem).load(packed.words) is not None
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert checkpoint.Checkpoint(folder, path.stem).load(packed.words) is None


@pytest.mark.parametrize("damage", ["rows", "json", "moved"])
def test_a_damaged_checkpoint_is_told_and_not_believed(damage: str, packed: PackedNetwork, tmp_path: Path) -> None:
    explore(packed, compiled=False, checkpoints=Checkpoints(tmp_path / "c", belongs(), resume=False, every=0.0))
    (path,) = [path for path in (tmp_path / "c").glob(f"*.{damage}") if path.name != checkpoint.MANIFEST]
    content = bytearray(path.read_bytes()) or bytearray(b"x")
    content[len(content) // 2] ^= 1
    path.write_bytes(content if damage != "moved" else b"more than there was")
    said: list[str] = []
    folder = Checkpoints(tmp_path / "c", belongs(), resume=True, tell=said.append)
    found = explore(packed, compiled=False, checkpoints=folder)
    assert told(found) == told(explore(packed, compiled=False))
    assert len(said) == (damage != "moved" or found.has_tau)


def test_a_full_disk_costs_the_checkpoint_and_not_the_search(
    packed: PackedNetwork, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    said: list[str] = []
    folder = Checkpoints(tmp_path / "c", belongs(), resume=False, tell=said.append, every=0.0)
    monkeypatch.setattr(os, "fsync", fail)
    assert told(explore(packed, compiled=False, checkpoints=folder)) == told(explore(packed, compiled=False))
    assert said == [f"no more checkpoints: No space left on device ({tmp_path / 'c'})"]


class TestFolders:
    def test_belong_to_one_script_one_set_of_options_and_one_version(self, tmp_path: Path) -> None:
        Checkpoints(tmp_path / "c", belongs(), resume=False)
        Checkpoints(tmp_path / "c", belongs(), resume=True)
        for key in ("version", "script"):
            with pytest.raises(Mismatch, match=f"its checkpoints are those of another {key}"):
                Checkpoints(tmp_path / "c", belongs(**{key: "other"}), resume=True)

    def test_are_not_written_over(self, tmp_path: Path) -> None:
        Checkpoints(tmp_path / "c", belongs(), resume=False)
        with pytest.raises(Mismatch, match="it has checkpoints already"):
            Checkpoints(tmp_path / "c", belongs(), resume=False)

    def test_must_be_there_to_go_on_from(self, tmp_path: Path) -> None:
        with pytest.raises(Mismatch, match="it has no checkpoints"):
            Checkpoints(tmp_path / "c", belongs(), resume=True)


PROGRAM = """
import sys
from pathlib import Path
from tests.checker.search.test_checkpoint import *
script = load(Source("s.csp", SCRIPT))
packed = Machines().packed(script.process("S"), Budget(Limits()))
levels.INTERPRETED_ROWS = 7
folder = Path(sys.argv[1])
checkpoints = Checkpoints(folder, belongs(), resume=folder.exists(), every=0.0)
print("ready", flush=True)
found = told(explore(packed, compiled=False, checkpoints=checkpoints))
print(found[1], found[0][-1], flush=True)
"""


@pytest.mark.slow
def test_a_run_that_is_killed_goes_on_in_the_next(packed: PackedNetwork, tmp_path: Path) -> None:
    """Wherever the signal meets it, in the midst of writing too."""
    expected = explore(packed, compiled=False)
    chance = random.Random(2)
    for run in range(1000):
        with subprocess.Popen(
            [sys.executable, "-c", textwrap.dedent(PROGRAM), str(tmp_path / "c")],
            stdout=subprocess.PIPE,
            text=True,
            cwd=Path(__file__).parents[3],
        ) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            try:
                # Later runs have more time: on a busy machine some would come no further than to where they began.
                process.wait(chance.uniform(0.01, 0.3 + 0.2 * run))
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                continue
            line = process.stdout.read()
        assert line.split() == [str(expected.transitions), str(expected.levels[-1])]
        break
