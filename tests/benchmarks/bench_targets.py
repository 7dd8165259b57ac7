"""How many events a second generated programs in C and in Ada let happen, beside what a person would write by hand.

``python tests/benchmarks/bench_targets.py`` compiles and runs, for each shape (two tasks and a channel; eight senders
and one that takes from any of them), the generated program for a desk and a program by hand: pthreads with a mutex and
condition variables in C, a rendezvous in Ada (``accept``, and ``select`` over eight entries). Nothing is recorded. It
prints the events per second of the best of some runs, and the ratio.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cspcheck
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.codegen.design.system import system
from cspcheck.codegen.emit import ada, freertos
from cspcheck.codegen.emit.keeping import write

EVENTS = 30_000
RUNS = 3

SCRIPTS = {
    "pair": """
channel c : {0..9}
P(n) = c!n -> P((n + 1) % 10)
C = c?x -> C
SYSTEM = P(0) [| {| c |} |] C
""",
    "choice of 8": """
channel c : {0..7}.{0..9}
P(i, n) = c.i!n -> P(i, (n + 1) % 10)
C = c?i?x -> C
SYSTEM = (||| i : {0..7} @ P(i, 0)) [| {| c |} |] C
""",
}

C_BY_HAND = """
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t there = PTHREAD_COND_INITIALIZER;
static pthread_cond_t taken[SENDERS];
static bool full[SENDERS];
static int value[SENDERS];

static void *send(void *argument)
{
    long me = (long)argument;
    for (int i = 0;; i = (i + 1) % 10) {
        pthread_mutex_lock(&lock);
        value[me] = i;
        full[me] = true;
        pthread_cond_signal(&there);
        while (full[me]) {
            pthread_cond_wait(&taken[me], &lock);
        }
        pthread_mutex_unlock(&lock);
    }
    return NULL;
}

int main(void)
{
    pthread_t threads[SENDERS];
    struct timespec from, to;
    clock_gettime(CLOCK_MONOTONIC, &from);
    for (long i = 0; i < SENDERS; i++) {
        pthread_cond_init(&taken[i], NULL);
        pthread_create(&threads[i], NULL, send, (void *)i);
    }
    int sum = 0, next = 0;
    for (long event = 0; event < EVENTS; event++) {
        pthread_mutex_lock(&lock);
        for (;;) {
            int tried = 0;
            while (tried < SENDERS && !full[next]) {
                next = (next + 1) % SENDERS;
                tried++;
            }
            if (tried < SENDERS) {
                break;
            }
            pthread_cond_wait(&there, &lock);
        }
        sum += value[next];
        full[next] = false;
        pthread_cond_signal(&taken[next]);
        next = (next + 1) % SENDERS;
        pthread_mutex_unlock(&lock);
    }
    clock_gettime(CLOCK_MONOTONIC, &to);
    printf("%.6f %d\\n", (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec), sum);
    return 0;
}
"""

ADA_BY_HAND = """
with Ada.Real_Time; use Ada.Real_Time;
with Ada.Text_IO;
procedure Hand is
   task Receiver is
{entries}
   end Receiver;
   task type Sender (Index : Natural);
   Sum  : Integer := 0;
   From : Time;
   task body Receiver is
   begin
      From := Clock;
      for Event in 1 .. {events} loop
{accepts}
      end loop;
      Ada.Text_IO.Put_Line (Duration'Image (To_Duration (Clock - From)) & Integer'Image (Sum));
   end Receiver;
   task body Sender is
      N : Integer := 0;
   begin
      loop
{calls}
         N := (N + 1) mod 10;
      end loop;
   end Sender;
{senders}
begin
   null;
end Hand;
"""

ADA_MAIN = """
with Ada.Real_Time; use Ada.Real_Time;
with Ada.Text_IO;
with CSP; use CSP;
with GNAT.OS_Lib;
with Processes;
pragma Unreferenced (Processes);
procedure Bench is
   From : Time;
begin
   CSP.Limit (%d);
   From := Clock;
   CSP.Go;
   while CSP.State = Goes_On loop
      delay until Clock + Microseconds (500);
   end loop;
   Ada.Text_IO.Put_Line (Duration'Image (To_Duration (Clock - From)));
   GNAT.OS_Lib.OS_Exit (0);
end Bench;
"""


def ada_by_hand(senders: int) -> str:
    """A rendezvous, or a choice of several; the senders end when their calls fail."""
    entries = "\n".join(f"      entry E{i} (V : Integer);" for i in range(senders))
    accepts = [f"accept E{i} (V : Integer) do\n Sum := Sum + V;\n end E{i};" for i in range(senders)]
    chosen = accepts[0] if senders == 1 else "select\n" + "\nor\n".join(accepts) + "\nend select;"
    cases = "\n".join(f"when {i} => Receiver.E{i} (N);" for i in range(senders))
    calls = f"case Index is\n{cases}\nwhen others => null;\nend case;"
    tasks = "\n".join(f"   S{i} : Sender ({i});" for i in range(senders))
    return ADA_BY_HAND.format(entries=entries, events=EVENTS, accepts=chosen, calls=calls, senders=tasks)


def run(command: list[str], folder: Path) -> str:
    """What a command prints."""
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


def best(command: list[str], folder: Path) -> float:
    """The events per second of a program that prints its seconds, the best of some runs."""
    return EVENTS / min(float(run(command, folder).split()[0]) for _ in range(RUNS))


def timed(command: list[str], folder: Path) -> float:
    """Those of a program that does not."""
    seconds = []
    for _ in range(RUNS):
        started = time.perf_counter()
        run(command, folder)
        seconds.append(time.perf_counter() - started)
    return EVENTS / min(seconds)


def measure(shape: str, folder: Path) -> None:
    """Build and run all programs of a shape."""
    script = cspcheck.loads(SCRIPTS[shape])._script
    made = system(script, "SYSTEM", Semantics(), "policy")
    senders = len(made.tasks) - 1
    in_c, in_ada, hand = folder / "c", folder / "ada", folder / "hand"
    write(freertos.project(made, str(in_c)), in_c)
    run(["make", "-s", "host"], in_c)
    generated_c = timed(["./host", "--events", str(EVENTS)], in_c)
    hand.mkdir()
    (hand / "hand.c").write_text(C_BY_HAND)
    flags = [f"-DSENDERS={senders}", f"-DEVENTS={EVENTS}L", "-O2"]
    run(["cc", *flags, "hand.c", "-o", "hand_c", "-lpthread"], hand)
    by_hand_c = best(["./hand_c"], hand)
    write(ada.project(made, str(in_ada), script), in_ada)
    (in_ada / "desk" / "bench.adb").write_text(ADA_MAIN % EVENTS)
    makefile = (in_ada / "Makefile").read_text()
    (in_ada / "Makefile").write_text(re.sub(r"-o host desk/host.adb", "-o bench desk/bench.adb", makefile))
    run(["make", "-s", "host", "FLAGS=-gnat2012 -O2"], in_ada)
    generated_ada = best(["./bench"], in_ada)
    (hand / "hand.adb").write_text(ada_by_hand(senders))
    run(["gnatmake", "-q", "-gnat2012", "-O2", "hand.adb"], hand)
    by_hand_ada = best(["./hand"], hand)
    for language, generated, other in (("C", generated_c, by_hand_c), ("Ada", generated_ada, by_hand_ada)):
        speeds = f"{generated:10,.0f} events/s   by hand {other:10,.0f}"
        print(f"{shape:12s} {language:4s} {speeds}   {generated / other:5.2f} x", flush=True)


def main() -> None:
    """Measure and print."""
    for shape in SCRIPTS:
        with tempfile.TemporaryDirectory() as folder:
            measure(shape, Path(folder))


if __name__ == "__main__":
    main()
