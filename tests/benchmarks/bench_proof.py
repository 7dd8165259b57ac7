"""How much of what classes claim is proved without help, and whether faults are found.

``python tests/benchmarks/bench_proof.py`` proves the obligations of the classes in ``proof.csp`` and ``proof_more.csp``
and their refinements, and prints how many come out how; then it puts a fault into each class and looks for a
refutation. Counts are asserted: at most one in fifty is left open, and no fault is missed. Answers that are
kept are not used.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from pathlib import Path

from cspcheck.checker.proof.answer import whole_refinement
from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import SolverSettings
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source

TEXT = "\n".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in ("proof.csp", "proof_more.csp"))
FAULTS = (
    # class, what stands there, what is put in its place
    ("Ring", "(first + n) mod MAX |-> x?", "(first + n + 1) mod MAX |-> x?"),
    ("Queue", "#q < MAX\n", "#q <= MAX\n"),
    ("Semaphore", "if #inside < K", "if #inside <= K"),
    ("Library", "#(issued |> {r?}) < M", "#(issued |> {r?}) <= M"),
    ("Exchange", "a? in free and b? in free", "a? in free"),
    ("Root", "m * m <= N then lo' = m", "m * m <= N then lo' = m + 1"),
    ("Crossing", "n' = n + 1", "n' = n"),
    ("TokenRing", "token' = (token + 1) mod N", "token' = (token + 2) mod N"),
    (
        "Cache",
        "#held = K and (exists q : held @ held' = (held \\ {q}) union {p?})",
        "#held = K and held' = held union {p?}",
    ),
    ("Filter", "(if x? in S then good ^ <x?> else good)", "good ^ <x?>"),
    ("Grown", "g' = g union {a? |-> b?}", "g' = g \\ {a? |-> b?}"),
    ("Ledger", "total' = total + x?", "total' = total + 1"),
    ("Cash", "balance >= a? + 1", "balance >= a?"),
    ("Members", "x? notin ran l\n", ""),
    ("Average", "rest' = (sum + x?) mod (count + 1)", "rest' = (sum + x?) mod count"),
    ("Stack", "max {deepest, #s + 1}", "max {deepest, #s}"),
    ("Birthdays", "known' = known union {n?}", "known' = known"),
    ("Access", "r? != owns\n", ""),
    ("Mutex", "waiting' = waiting \\ {w}", "waiting' = waiting"),
    ("Thermostat", "goal' = t?\n    mode' = idle", "goal' = t?\n    mode' = mode"),
    ("Parking", "cars' = cars + 1 and reserved' = reserved - 1", "cars' = cars + 1 and reserved' = reserved"),
    ("History", "undone' = <>\n  op undo", "undone' = undone\n  op undo"),
    ("Votes", "u? notin ayes union noes\n", ""),
    ("Router", "table' = table |/> {p?}", "table' = table"),
    ("Tickets", "served < next\n", ""),
    ("Share", "purse(from?) >= n?\n", ""),
    ("Elevator", "calls' = calls \\ {at}\n", "calls' = calls\n"),
    ("Divider", "r' = r - B", "r' = r - 1"),
    ("TwoStacks", "back_' = <x?> ^ back_", "back_' = back_ ^ <x?>"),
)


def findings(text: str, names: tuple[str, ...] | None = None, owner: str | None = None) -> list[Finding]:
    """The answers for the classes of a text, or one of them, and for its refinements."""
    tree = parse(Source("proof.csp", text))
    specification = elaborate(tree).specification
    settings = SolverSettings()
    found: list[Finding] = []
    for name, model in specification.classes.items():
        if owner in (None, name):
            found += discharge(Prover(specification, model, settings), names)
    if owner in (None, "Ring", "Queue", "TwoStacks"):
        for declaration in tree.declarations:
            node = getattr(declaration, "assertion", None)
            if node is not None:
                found += whole_refinement(node, specification, settings)
    return found


def main() -> None:
    """Print both tables."""
    os.environ["CSPCHECK_PROOFS"] = "new"
    start = time.perf_counter()
    found = findings(TEXT)
    counts = Counter(finding.status for finding in found)
    left = counts["bounded"] + counts["unknown"]
    print(f"{len(found)} obligations, {counts['proved']} proved, {left} open, {time.perf_counter() - start:.1f} s")
    for finding in found:
        if finding.status != "proved":
            print(f"  {finding.status:8} {finding.subject} {finding.obligation} {finding.place}")
    assert left * 50 <= len(found)
    for owner, old, new in FAULTS:
        before, name, rest = TEXT.partition(f"class {owner}\n")
        assert old in rest, owner
        start = time.perf_counter()
        names = ("invariant preserved", "carrier kept", "applied in domain", "initial invariant")
        wrong = findings(before + name + rest.replace(old, new, 1), names, owner)
        refuted = [f"{f.obligation} {f.place}" for f in wrong if f.status == "refuted" and f.severity != "info"]
        print(f"{owner:10} {time.perf_counter() - start:6.1f} s  {refuted[0] if refuted else 'MISSED'}")
        assert refuted, owner


if __name__ == "__main__":
    main()
