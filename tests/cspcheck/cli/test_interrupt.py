"""Ctrl-C is never lost, wherever it comes."""

from __future__ import annotations

import ctypes
import io
import os
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import cspcheck.cli
from cspcheck.__main__ import asked_to_end
from cspcheck.cli.interrupt import Interrupts


def press() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def press_in_a_callback_from_machine_code() -> None:
    """What Python does with an interrupt here is to print it and go on."""
    numbers = (ctypes.c_int * 2)(1, 2)
    compare_type = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)

    def compare(left: int, right: int) -> int:
        press()
        return 0

    ctypes.CDLL(None).qsort(numbers, 2, ctypes.sizeof(ctypes.c_int), compare_type(compare))


def test_it_comes_at_once_where_python_runs() -> None:
    with pytest.raises(KeyboardInterrupt), Interrupts():
        press()


def test_one_that_was_dropped_comes_at_the_next_poll(capfd: pytest.CaptureFixture[str]) -> None:
    with Interrupts() as interrupts:
        interrupts.poll()
        press_in_a_callback_from_machine_code()
        with pytest.raises(KeyboardInterrupt):
            interrupts.poll()

    assert capfd.readouterr().err == ""


def test_afterwards_everything_is_as_before() -> None:
    import sys

    before = (signal.getsignal(signal.SIGINT), sys.unraisablehook)
    with Interrupts():
        assert signal.getsignal(signal.SIGINT) is not before[0]

    assert (signal.getsignal(signal.SIGINT), sys.unraisablehook) == before


@pytest.mark.parametrize("where", ["cspcheck.cli", "cspcheck.__main__"])
def test_the_end_does_not_wait_for_the_compiler(where: str) -> None:
    """Kernels that are being compiled when the run is interrupted are of no use to anybody; what was said gets out."""
    program = f"""
import sys, time
import cspcheck.cli
from cspcheck.checker.kernels.machine_code import Apart
from {where} import main
def run():
    Apart(lambda: time.sleep(600))
    print("said")
    return 130
cspcheck.cli.run = run
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "said\n", "")


def test_the_end_leaves_the_memory_to_the_system() -> None:
    """A million objects are not taken apart; what is to be done at the end is done, and what was said gets out."""
    program = """
import atexit, sys
import cspcheck.cli
class Held:
    def __del__(self):
        print("taken apart")
held = Held()
held.circle = held
atexit.register(print, "at the end")
def run():
    print("said")
    return 3
cspcheck.cli.run = run
cspcheck.cli.main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (3, "said\nat the end\n", "")


@pytest.mark.parametrize(
    ("verb", "carried_out", "arguments"),
    [("repl", "Prompt", ["repl"]), ("probe", "Commands", ["probe", "SCRIPT", "P"])],
)
def test_ctrl_c_goes_back_to_the_prompt_and_the_signal_to_end_ends_it(
    verb: str, carried_out: str, arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While something is carried out: the one is for what goes on, the other for the whole."""
    module = import_module(f"cspcheck.cli.{'probe_commands' if verb == 'probe' else verb}")
    do = getattr(module, carried_out).do

    def interrupted(self: object, line: str) -> bool:
        if line.strip() in ("once", "at all"):
            os.kill(os.getpid(), signal.SIGINT if line.strip() == "once" else signal.SIGTERM)
        return bool(do(self, line))

    script = tmp_path / "p.csp"
    script.write_text("channel a\nP = a -> P\n")
    monkeypatch.setattr(getattr(module, carried_out), "do", interrupted)
    monkeypatch.setattr(sys, "stdin", io.StringIO("once\nonce\nat all\nonce\n"))
    told = io.StringIO()
    monkeypatch.setattr(sys, "stdout", told)
    before = signal.signal(signal.SIGTERM, asked_to_end)
    try:
        assert cspcheck.cli.run([str(script) if one == "SCRIPT" else one for one in arguments]) == 130
    finally:
        signal.signal(signal.SIGTERM, before)
    assert told.getvalue().count("interrupted\n") == 2
