"""Many at once with an empty cache: nothing fails, and every verdict is the one that a single process comes to.

``python -m tests.benchmarks.load`` does the same with a hundred commands and with eight workers of pytest.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CHILDREN = 4

PROGRAM = textwrap.dedent(
    """
    import json, os, sys, traceback

    import cspcheck
    import cspcheck.checker.check, cspcheck.cspm.typing.inference
    from cspcheck.checker.kernels import jit, table
    from tests.checker.kernels.test_machine_code import MOVED, move

    # Few kernels, so that they compile at once; all that many processes could do to each other is the same.
    whole = jit.MODULES, jit.ENTRIES
    jit.MODULES, jit.ENTRIES = (table,), {"move": (), "enter_all": ()}
    TEXT = '''
    N = 3
    channel a, b : {0..N-1}
    P(i) = a.i -> b.i -> P(i)
    ALL = ||| i : {0..N-1} @ P(i)
    Q(n) = a?x -> (if n == 0 then STOP else Q(n - 1))
    '''
    CHECKS = ["ALL :[deadlock free]", "Q(K) :[deadlock free]", "ALL [T= Q(K)", "Q(K) [F= a.0 -> STOP |~| STOP",
              "P(0) :[deterministic]", "ALL \\\\ {| a |} :[divergence free]"]


    def work():
        # To be found in the cache, or to be made by all at the same time.
        right = move(jit.kernels(True)) == MOVED
        jit._forms.clear()
        jit.MODULES, jit.ENTRIES = whole  # which small searches interpret
        script = cspcheck.loads(TEXT)
        found = [script.check(check.replace("K", str(k))) for k in range(4) for check in CHECKS]
        return [right, *((one.verdict, one.states, one.transitions, str(one.counterexample)) for one in found)]


    gate, barrier = os.pipe()
    children = []
    for number in range(int(sys.argv[1])):
        out, into = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(barrier)
            os.read(gate, 1)  # all begin when the first process lets go
            try:
                told = json.dumps(work())
            except BaseException:
                told = json.dumps(traceback.format_exc())
            with os.fdopen(into, "w") as stream:
                stream.write(told)
            os._exit(0)
        os.close(into)
        children.append((child, out))
    os.close(barrier)
    answers = [json.loads(os.fdopen(out).read()) for _, out in children]
    states = [os.waitpid(child, 0)[1] for child, _ in children]
    print(json.dumps([answers, states]))
    """
)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_many_processes_at_once(tmp_path: Path) -> None:
    program = tmp_path / "many.py"
    program.write_text(PROGRAM)
    cache = tmp_path / "cache"
    place = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(cache)}
    done = subprocess.run(
        [sys.executable, str(program), str(CHILDREN)], env=place, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    answers, states = json.loads(done.stdout)
    assert states == [0] * CHILDREN
    assert len(answers[0]) == 25
    assert answers[0][0] is True
    assert {answer[0] for answer in answers[0][1:]} == {"pass", "fail"}
    assert all(answer == answers[0] for answer in answers)
    # All made the same file, and nobody left a half of one.
    kept = sorted(path.name for path in (cache / "cspcheck").iterdir())
    assert [name.split("-")[0] for name in kept if name.startswith("kernels")] == ["kernels"]
    assert not any(name.startswith(".") for name in kept)
