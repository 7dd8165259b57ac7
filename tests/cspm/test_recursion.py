"""Deep recursion does not end the process by a signal, not even through functions that are written in C."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("resource")

DEEP = """
from cspcheck.cspm.recursion import deep_recursion

def follow(level):
    if level < 4_000:
        sorted([level + 1], key=follow)
    return level

with deep_recursion():
    print(follow(0))
"""
"""Twice as deep as the usual stack has room for."""


def test_the_stack_has_room_for_functions_written_in_c() -> None:
    done = subprocess.run([sys.executable, "-c", DEEP], capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stdout) == (0, "0\n")
