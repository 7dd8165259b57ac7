"""How much of what classes claim is proved without help, and whether faults are found.

``python tests/benchmarks/bench_proof.py`` proves the obligations of the classes in ``proof.csp`` and the like
and their refinements, and prints how many come out how; then it puts a fault into each class and each refinement, and
looks for a refutation. Counts are asserted: at most one in fifty is left open, and no fault is missed. Answers that are
kept are not used. Times are the processor's, of this program and of the solver, in seconds.

``bench_proof.py proofs Queue Ring`` and ``bench_proof.py faults Queue`` do a part of it.
"""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from cspcheck.checker.proof import client
from cspcheck.checker.proof.answer import whole_refinement
from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import SolverSettings
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source

_FILES = (("proof.csp", "proof_more.csp"), ("proof_others.csp",))
TEXTS = ["\n".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in names) for names in _FILES]
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
    ("Vending", "stock(g?) > 0 and credit >= price(g?)", "stock(g?) > 0"),
    ("Blocks", "(clear \\ {next(at(t?))}) union {at(t?)}", "clear \\ {next(at(t?))}"),
    ("Lights", "north = amber => north' = red", "north = amber => north' = amber"),
    ("Window", "open' = open \\ (base..n?)", "open' = open \\ {n?}"),
    ("Euclid", "b' = a mod b", "b' = a - b"),
    ("Bucket", "if level + v? <= SPACE", "if level <= SPACE"),
    ("Table", "left(p?) in dom owner and owner(left(p?)) = p?\n", ""),
    ("Sorted", "s' = a ^ <x?> ^ b", "s' = a ^ b ^ <x?>"),
    ("Pages", "p? notin dirty\n", ""),
    ("Clock", "{i? |-> own(i?)}", "{i? |-> own(i?) + 1}"),
    ("SmallRing", "count' = count - 1", "count' = count"),
    ("Odometer", "digit' = 0 and rounds' = rounds + 1", "digit' = 0 and rounds' = rounds"),
    ("R", "(first + i - 1) mod MAX", "(first + i) mod MAX"),
    ("S", "q = front_ ^ rev back_", "q = front_ ^ back_"),
    ("Reading", "n = rounds * BASE + digit", "n = rounds + digit"),
)


def answered(
    text: str, names: tuple[str, ...] | None = None, owner: str | None = None
) -> Iterator[tuple[Finding, float]]:
    """The answers for the classes of a text, or one of them, and for its refinements; each with its time."""
    tree = parse(Source("proof.csp", text))
    specification = elaborate(tree).specification
    settings = SolverSettings()
    start = _processor()

    def timed(found: Iterable[Finding]) -> Iterator[tuple[Finding, float]]:
        nonlocal start
        for finding in found:
            now = _processor()
            yield finding, now - start
            start = now

    for name, model in specification.classes.items():
        if owner in (None, name):
            yield from timed(discharge(Prover(specification, model, settings), names))
    for declaration in tree.declarations:
        node = getattr(declaration, "assertion", None)
        if node is not None and (owner is None or owner in _compared(node)):
            yield from timed(whole_refinement(node, specification, settings))


def _compared(node: object) -> tuple[str, ...]:
    """The classes that an assertion compares, and how."""
    names = (getattr(node, part, None) for part in ("abstract", "concrete", "parent", "child", "retrieve"))
    return tuple(name.name for name in names if name is not None)


def _processor() -> float:
    """Seconds of processor time so far, of this process and the solver's."""
    solver = client._shared._process
    return time.process_time() + ((client._processor_seconds(solver.pid) or 0.0) if solver is not None else 0.0)


def findings(text: str, names: tuple[str, ...] | None = None, owner: str | None = None) -> list[Finding]:
    """The answers for the classes of a text, or one of them, and for its refinements."""
    return [finding for finding, _ in answered(text, names, owner)]


def text_of(owner: str) -> tuple[str, str, str]:
    """The text with a class or a retrieve relation: what stands before its name, the name, and what is behind it."""
    for text in TEXTS:
        for head in (f"class {owner}\n", f"retrieve {owner} "):
            if head in text:
                return text.partition(head)
    raise LookupError(owner)


def with_fault(owner: str, old: str, new: str) -> str:
    """The text with something else in a class, or in what relates two."""
    before, name, rest = text_of(owner)
    assert old in rest, owner
    return before + name + rest.replace(old, new, 1)


def proofs(owners: list[str]) -> None:
    """Print what comes of the claims as they are."""
    found: list[Finding] = []
    start = _processor()
    parts = [("".join(text_of(owner)), owner) for owner in owners] or [(text, None) for text in TEXTS]
    for text, owner in parts:
        for finding, seconds in answered(text, None, owner):
            found.append(finding)
            if finding.status != "proved" or seconds > 5:
                place = f"{finding.subject} {finding.obligation} {finding.place}"
                print(f"  {finding.status:8} {seconds:5.1f} s  {place}", flush=True)
    counts = Counter(finding.status for finding in found)
    left = counts["bounded"] + counts["unknown"]
    print(f"{len(found)} obligations, {counts['proved']} proved, {counts['refuted']} refuted, {left} open,", end=" ")
    print(f"{_processor() - start:.1f} s")
    if not owners:
        assert len(found) >= 758
        assert left * 50 <= len(found)


def faults(owners: list[str]) -> None:
    """Print what is refuted where there is a fault, and how long the claim took."""
    for owner, old, new in FAULTS:
        if owners and owner not in owners:
            continue
        names = ("invariant preserved", "carrier kept", "applied in domain", "initial invariant")
        start = _processor()
        for finding, seconds in answered(with_fault(owner, old, new), names, owner):
            if finding.status == "refuted" and finding.severity != "info":
                place = f"{finding.subject} {finding.obligation} {finding.place}"
                print(f"{owner:12} {seconds:5.2f} s of {_processor() - start:5.1f} s  {place}", flush=True)
                break
        else:
            raise AssertionError(f"{owner}: the fault was missed")


def main() -> None:
    """Print both tables, or a part of one."""
    os.environ["CSPCHECK_PROOFS"] = "new"
    what, *owners = sys.argv[1:] or ["all"]
    if what in ("all", "proofs"):
        proofs(owners)
    if what in ("all", "faults"):
        faults(owners)


if __name__ == "__main__":
    main()
