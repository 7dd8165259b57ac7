"""Classes for the tests of proofs: from text to findings."""

from __future__ import annotations

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import SolverSettings
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source


def specification(text: str) -> core.Specification:
    """The specification that a text is."""
    return elaborate(parse(Source("test.csp", text))).specification


def prover(text: str, name: str | None = None, seconds: float = 10.0) -> Prover:
    """A prover for a class of a text, by default the last."""
    spec = specification(text)
    model = spec.classes[name] if name is not None else list(spec.classes.values())[-1]
    return Prover(spec, model, SolverSettings(seconds=seconds))


def findings(text: str, *names: str, operation: str | None = None) -> list[Finding]:
    """The findings for the last class of a text."""
    return list(discharge(prover(text), names or None, operation))


def told(found: list[Finding]) -> list[str]:
    """The findings as lines: what of which, and how it came out."""
    return [f"{f.obligation} {f.place}".strip() + f": {f.status}" for f in found]


def wrong(text: str) -> list[str]:
    """The obligations that are refuted, with the place of each."""
    return [f"{f.obligation} {f.place}".strip() for f in findings(text) if f.status == "refuted"]


def cell(
    *,
    state: str = "n : nat",
    invariant: str = "",
    init: str = "n = 0",
    delta: str = "n",
    parameters: str = "",
    effect: str = "",
    enable: str = "",
    more: str = "",
    inside: str = "",
    main: str = "go -> main [] idle -> main",
) -> str:
    """A class with an operation ``go`` and an event ``idle``; lines of each part are separated by ``;``."""

    def lines(text: str, indent: str = "    ") -> str:
        return "".join(f"{indent}{line.strip()}\n" for line in text.split(";") if line.strip())

    where = f"  where\n{lines(invariant)}" if invariant else ""
    declared = lines(parameters)
    body = f"  op {'effect_go' if enable else 'go'}\n    Delta({delta})\n{declared}"
    body += f"  where\n{lines(effect)}" if effect else ""
    guards = f"  op enable_go\n{declared}  where\n{lines(enable)}" if enable else ""
    return (
        f"{more}\nclass Cell\n  chan go : [{parameters}]\n  chan idle : []\n  main = {main}\n{lines(inside, '  ')}"
        f"  state\n{lines(state)}{where}  init\n{lines(init)}{guards}{body}end\n"
    )
