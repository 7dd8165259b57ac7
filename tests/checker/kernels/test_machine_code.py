"""Machine code is kept whole or not at all, whoever makes it, and is called with what it was made for."""

from __future__ import annotations

import copy
import os
import pickle
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cspcheck
from cspcheck.checker.guard import Guard
from cspcheck.checker.kernels import jit, machine_code, table
from cspcheck.checker.kernels.arrays import no_guide
from cspcheck.cspm import caches
from cspcheck.cspm.interruption import Stopped

MOVED = [5 << 3 | 2, (5 << 3 | 2) - 7, 0, 0, 9, 9]
COMPILING = "compiling the search kernels for this machine; once"


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A cache of its own, for few kernels."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(jit, "MODULES", (table,))
    monkeypatch.setattr(jit, "ENTRIES", {"move": (), "enter_all": ()})
    monkeypatch.setattr(jit, "_forms", {})
    monkeypatch.setattr(caches, "_told", set())


def move(code: jit.Kernels, kind: type[np.signedinteger[Any]] = np.int32) -> list[int]:
    """What one of the kernels does to a state, its entry, and another row."""
    rows = np.array([0, 0, 0, 9], dtype=np.int64)
    place = table.hash_of(rows.tolist(), 3, 1) >> 60
    entries = np.full(8, -1, dtype=kind)
    entries[place] = 5 << 3 | 3
    code.move(rows, 3, 2, 1, 1, entries, 3, 0)  # type: ignore[arg-type]
    return [int(entries[place]), int(entries.sum()), *rows.tolist()]


def use() -> list[str]:
    """Load the kernels as a new process does and use one; the lines that the user is told."""
    told: list[str] = []
    jit._forms.clear()
    assert move(jit.kernels(True, told.append)) == MOVED
    return told


def kept(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "cache" / "cspcheck").iterdir())


def test_it_is_in_the_cache_folder_of_the_user(tmp_path: Path) -> None:
    place = machine_code.place_for(["x"])
    assert place is not None
    assert place.parent == tmp_path / "cache" / "cspcheck"
    assert place != machine_code.place_for(["y"])


def test_it_heals_whatever_happens_to_it(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert use() == [COMPILING]
    assert use() == []
    assert caplog.messages == []
    (place,) = kept(tmp_path)
    original = place.read_bytes()
    for content in (b"", original[: len(original) // 2], bytes(reversed(original)), original + b"more"):
        place.write_bytes(content)
        caplog.clear()
        caches._told.clear()
        assert use() == [COMPILING]
        assert caplog.messages == [f"the cache file `{place}` was damaged and is made anew"]
        assert kept(tmp_path) == [place]
        assert place.read_bytes() == original


def test_nothing_that_is_done_with_it_changes_it(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    use()
    (place,) = kept(tmp_path)
    before = place.read_bytes(), place.stat().st_mtime_ns
    code, rows = jit.kernels(True), np.zeros(1, dtype=np.int64)
    with pytest.raises(TypeError, match="move, argument table: a contiguous array of int32 is expected"):
        code.move(rows, 0, 0, 0, 1, np.zeros(1, dtype=np.int16), 3, 0)  # type: ignore[arg-type]
    use()
    assert (place.read_bytes(), place.stat().st_mtime_ns) == before
    assert caplog.messages == []


def test_installations_with_the_same_text_share_it(tmp_path: Path) -> None:
    """Wherever they are, and whenever their files were written."""
    script = (
        "from cspcheck.checker.kernels import jit, table\n"
        "jit.MODULES, jit.ENTRIES = (table,), {'move': ()}\n"
        "jit.kernels(True, lambda line: print('compiling'))\n"
        "print(jit.__file__)\n"
    )
    package = Path(cspcheck.__file__).parent
    told = []
    for name in ("one", "other"):
        home = tmp_path / name
        for part in ("checker", "cspm"):
            shutil.copytree(package / part, home / "cspcheck" / part, ignore=shutil.ignore_patterns("__pycache__"))
        (home / "cspcheck" / "__init__.py").write_text((package / "__init__.py").read_text())
        for file in home.rglob("*.py"):
            os.utime(file, (len(name), len(name)))
        done = subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONPATH": str(home)},
            cwd=home,
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stderr == ""
        *lines, where = done.stdout.splitlines()
        assert Path(where).is_relative_to(home)
        told.append(lines)
    assert told == [["compiling"], []]
    assert len(kept(tmp_path)) == 1


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="this system has no owners of files")
def test_it_is_not_kept_where_others_can_write(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    cache = tmp_path / "cache" / "cspcheck"
    cache.mkdir(parents=True)
    cache.chmod(0o777)
    assert machine_code.place_for(["x"]) is None
    assert caplog.messages == [f"the cache `{cache}` can be written by everybody and is not used"]
    cache.chmod(0o700)
    monkeypatch.setattr(os, "geteuid", lambda: cache.stat().st_uid + 1)
    assert machine_code.place_for(["x"]) is None
    assert caplog.messages[1:] == [f"the cache `{cache}` belongs to another user and is not used"]


def test_it_is_done_without_a_place_for_it(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("")
    assert use() == ["compiling the search kernels for this machine; there is no folder to keep them in"]


def test_it_is_done_without_room_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "store", lambda place, content: False)
    assert use() == use() == [COMPILING]


def test_who_is_stopped_while_waiting_leaves_the_compiler_to_its_work(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    waited = threading.Event()
    compiled: Callable[..., bytes] = machine_code.compiled

    def slowly(*arguments: object) -> bytes:
        assert waited.wait(60)
        return compiled(*arguments)

    use()
    for place in kept(tmp_path):
        place.unlink()
    monkeypatch.setattr(machine_code, "compiled", slowly)
    with pytest.raises(Stopped) as caught, Guard(seconds=1):
        use()
    assert caught.value.doing == ["compiling the search kernels for this machine, which happens once"]
    waited.set()
    for thread in threading.enumerate():
        if thread.name == "compiler":
            thread.join()
    assert use() == []


def test_llvm_is_called_where_no_limit_arrives() -> None:
    """Its library holds a lock in each call, which somebody who is stopped there would keep for ever."""
    from llvmlite.binding import ffi

    callers: set[str] = set()

    def called() -> None:
        callers.add(threading.current_thread().name)

    def left() -> None:
        pass

    use()
    before = dict(jit._forms)  # machine code that is given up calls the library, too
    ffi.register_lock_callback(called, left)
    try:
        use()
    finally:
        ffi.unregister_lock_callback(called, left)
    assert len(before) == 1
    assert callers == {"compiler"}


def test_arguments_are_what_the_kernel_was_made_for() -> None:
    use()
    code = jit.kernels(True)
    good = np.zeros(8, dtype=np.int64)
    for wrong in (good[::2], good.astype(np.int32), [0] * 8):
        with pytest.raises(TypeError, match="enter_all, argument states: a contiguous array of int64 is expected"):
            code.enter_all(wrong, 0, 1, np.zeros(8, dtype=np.int32), 3, 31, 0, 0, 1)
    with pytest.raises(TypeError, match="enter_all takes 9 arguments, not 1"):
        code.enter_all(good)  # type: ignore[call-arg]
    good.flags.writeable = False
    assert code.enter_all(good, 1, 1, np.full(8, -1, dtype=np.int32), 3, 31, 0, 0, 1) is True


def test_what_machine_code_is_handed_of_a_tuple_is_no_part_of_it() -> None:
    guide = no_guide()
    words = machine_code._words(type(guide), guide)
    assert guide.words is words
    for other in (copy.copy(guide), copy.deepcopy(guide), guide._replace(word=1), pickle.loads(pickle.dumps(guide))):
        assert other.words is None
        assert type(other) is type(guide)


def test_tables_of_wide_entries_have_kernels_of_their_own(tmp_path: Path) -> None:
    """They are made when one is used, and kept as the others are."""
    use()
    code = jit.kernels(True)
    for _ in range(2):
        assert move(code, np.int64) == MOVED
        assert len(kept(tmp_path)) == 2
