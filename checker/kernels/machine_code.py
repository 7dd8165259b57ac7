"""The compiled kernels in the user's cache: made by a process of its own, checked before each use.

The compiler takes some twenty seconds and cannot be interrupted, so it runs in another process, which the one that
waits can leave: it goes on to its end, and the next run finds what it made. A folder of machine code appears whole,
with the digests of its files; a damaged one is made anew. Where nothing can be kept, the compiler runs here, in a
thread that nothing interrupts.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from cspcheck.cspm.caches import cache_folder, digests, tell, usable
from cspcheck.cspm.interruption import during

READY = "ready"
"""The file with the digests; a folder without it is not finished."""
WAIT = 0.05
"""Seconds between two looks at whether the compiler has ended."""


def folder_for(fingerprint: str) -> Path | None:
    """Where the machine code of kernels with a fingerprint is kept; None if nothing can be."""
    base = Path(os.environ["NUMBA_CACHE_DIR"]) if os.environ.get("NUMBA_CACHE_DIR") else cache_folder()
    if base is None or not usable(base):
        return None
    return base / f"kernels-{fingerprint}"


def is_ready(folder: Path) -> bool:
    """Whether a folder holds machine code, all of it as it was made. A damaged folder is told and taken away."""
    ready = folder / READY
    try:
        if not ready.exists():
            return False
        sound = usable(folder) and json.loads(ready.read_text(encoding="ascii")) == digests(folder, READY)
    except (OSError, ValueError):
        sound = False
    if not sound:
        tell(f"the compiled kernels in `{folder}` were damaged and are made anew")
        remove(folder)
    return sound


def remove(folder: Path) -> None:
    """Take a folder of machine code away, first what says that it is ready."""
    with contextlib.suppress(OSError):
        (folder / READY).unlink()
    shutil.rmtree(folder, ignore_errors=True)


def compile_elsewhere(folder: Path, names: Iterable[str]) -> bool:
    """Have another process put machine code of kernels into a folder; whether it is there in the end.

    Who is stopped while it waits leaves the other process to its work, which ends soon; an interrupt ends it, too.
    """
    command = [sys.executable, "-c", f"from {__name__} import make; make({str(folder)!r}, {list(names)!r})"]
    try:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError:
        return False
    try:
        with during("compiling the search kernels for this machine, which happens once"):
            while process.poll() is None:
                time.sleep(WAIT)
    except KeyboardInterrupt:
        process.kill()
        process.wait()
        raise
    return process.returncode == 0 and is_ready(folder)


def make(name: str, kernels: Iterable[str]) -> None:
    """Compile the kernels into a folder, unless another process has just done so. Ends this process if it cannot."""
    from cspcheck.checker.kernels import jit

    folder = Path(name)
    with _alone(folder.with_name(folder.name + ".lock")):
        if is_ready(folder):
            return
        unfinished = folder.with_name(f"{folder.name}.{os.getpid()}.tmp")
        try:
            unfinished.mkdir(mode=0o700)
            jit.compile_into(unfinished, kernels)
            (unfinished / READY).write_text(json.dumps(digests(unfinished, READY)), encoding="ascii")
            shutil.rmtree(folder, ignore_errors=True)
            os.replace(unfinished, folder)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


@contextlib.contextmanager
def _alone(lock: Path) -> Iterator[None]:
    """One process after the other."""
    with open(lock, "w") as file:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        except ImportError:  # a system without such locks: two may do the same work, and one result stays
            pass
        yield


def uninterrupted(work: Callable[[], None]) -> None:
    """Do *work* in a thread of its own: what stops or interrupts this one does not arrive there."""
    failure: list[BaseException] = []

    def run() -> None:
        try:
            work()
        except BaseException as error:
            failure.append(error)

    thread = threading.Thread(target=run, daemon=True, name="compiler")
    thread.start()
    with during("compiling the search kernels for this machine"):
        while thread.is_alive():
            thread.join(WAIT)
    if failure:
        raise failure[0]
