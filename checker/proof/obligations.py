"""The proof obligations of classes: their names, what they mean, and the answers for a class.

Numbers are those of the list in ``docs/proof.md``. Obligations are about the real types, never about finite readings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from cspcheck.checker.proof import (
    obligations_domains,
    obligations_operations,
    obligations_outcomes,
    obligations_states,
)
from cspcheck.checker.proof.finding import Finding, Severity
from cspcheck.checker.proof.prover import ObligationReport, Prover
from cspcheck.checker.proof.question import Help, Impossible
from cspcheck.cspm.oz import core

Check: TypeAlias = Callable[[Prover, ObligationReport, core.Operation | None], Iterable[Finding]]


@dataclass(frozen=True, slots=True)
class Obligation:
    """One kind of obligation.

    Attributes:
        name: as assertions and the command line write it.
        about: whether it is asked of the class or of each of its operations.
        severity: how much it matters where it does not hold.
        claim: what holds, in a sentence.
        check: finds out.
        assumes: whether a proof says nothing where the operation cannot be performed (or no state exists).
    """

    name: str
    about: Literal["class", "operation"]
    severity: Severity
    claim: str
    check: Check
    assumes: bool = False


def _class_check(check: Callable[[Prover, ObligationReport], Iterable[Finding]]) -> Check:
    return lambda prover, report, operation: check(prover, report)


def _operation_check(check: Callable[[Prover, ObligationReport, core.Operation], Iterable[Finding]]) -> Check:
    def checked(prover: Prover, report: ObligationReport, operation: core.Operation | None) -> Iterable[Finding]:
        assert operation is not None
        return check(prover, report, operation)

    return checked


OBLIGATIONS: tuple[Obligation, ...] = (
    Obligation(
        "axioms consistent",
        "class",
        "error",
        "constants can have values that satisfy all axioms",
        _class_check(obligations_states.axioms_consistent),
    ),
    Obligation(
        "lemma",
        "class",
        "error",
        "what a lemma says follows",
        _class_check(obligations_states.lemmas),
    ),
    Obligation(
        "state inhabited",
        "class",
        "error",
        "some values of the variables satisfy the invariant",
        _class_check(obligations_states.state_inhabited),
    ),
    Obligation(
        "initialisation",
        "class",
        "error",
        "some state satisfies INIT",
        _class_check(obligations_states.initialisation),
    ),
    Obligation(
        "initial invariant",
        "class",
        "warning",
        "INIT alone implies the invariant",
        _class_check(obligations_states.initial_invariant),
    ),
    Obligation(
        "feasible",
        "operation",
        "error",
        "in some state and for some inputs the operation can be performed",
        _operation_check(obligations_operations.feasible),
    ),
    Obligation(
        "invariant preserved",
        "operation",
        "error",
        "what the operation says leads to a state of the invariant",
        _operation_check(obligations_operations.invariant_preserved),
        assumes=True,
    ),
    Obligation(
        "total function",
        "operation",
        "error",
        "what the operation says keeps total functions total",
        _operation_check(obligations_operations.total_function),
        assumes=True,
    ),
    Obligation(
        "carrier kept",
        "operation",
        "warning",
        "what the operation says leaves no variable or output outside its carrier",
        _operation_check(obligations_operations.carrier_kept),
        assumes=True,
    ),
    Obligation(
        "alternative kept",
        "operation",
        "warning",
        "carriers and invariant cut off no alternative that its own conditions allow",
        _operation_check(obligations_operations.alternative_kept),
        assumes=True,
    ),
    Obligation(
        "guard covers effect",
        "operation",
        "error",
        "wherever the guard holds the effect is possible",
        _operation_check(obligations_operations.guard_covers_effect),
        assumes=True,
    ),
    Obligation(
        "guard satisfiable",
        "operation",
        "error",
        "the guard holds in some state",
        _operation_check(obligations_operations.guard_satisfiable),
    ),
    Obligation(
        "guard not redundant",
        "operation",
        "info",
        "the guard fails in some state",
        _operation_check(obligations_operations.guard_not_redundant),
    ),
    Obligation(
        "guard is precondition",
        "operation",
        "info",
        "wherever the effect is possible the guard holds",
        _operation_check(obligations_operations.guard_is_precondition),
        assumes=True,
    ),
    Obligation(
        "inputs usable",
        "operation",
        "warning",
        "every value of a finite input is accepted in some state",
        _operation_check(obligations_outcomes.inputs_usable),
    ),
    Obligation(
        "branch reachable",
        "operation",
        "error",
        "every branch of the predicate can be taken",
        _operation_check(obligations_outcomes.branch_reachable),
    ),
    Obligation(
        "deterministic operation",
        "operation",
        "info",
        "state and inputs determine the after-state and the outputs",
        _operation_check(obligations_outcomes.deterministic),
        assumes=True,
    ),
    Obligation(
        "output defined",
        "operation",
        "warning",
        "the predicate constrains every output wherever the operation can be performed",
        _operation_check(obligations_outcomes.output_defined),
        assumes=True,
    ),
    Obligation(
        "delta changes",
        "operation",
        "info",
        "every variable of the Delta-list can change",
        _operation_check(obligations_outcomes.delta_changes),
    ),
    Obligation(
        "applied in domain",
        "class",
        "error",
        "functions are applied inside their domain, and nothing else is undefined",
        _class_check(obligations_domains.applied_in_domain),
    ),
    Obligation(
        "no blocked control state",
        "class",
        "warning",
        "wherever the process waits, the data let one of the events happen",
        _class_check(obligations_states.no_blocked_control_state),
    ),
)
"""All kinds of obligations, in the order in which they are answered."""

BY_NAME = {obligation.name: obligation for obligation in OBLIGATIONS}


def discharge(
    prover: Prover, names: Iterable[str] | None = None, operation: str | None = None, help_: Help | None = None
) -> Iterator[Finding]:
    """Answer the obligations of a class.

    Args:
        prover: for the class.
        names: kinds of obligations; None: all.
        operation: the only operation of interest (or lemma); None: all, and what is about the class.
        help_: what the user says that the proofs need, beside what operations and lemmas say themselves.
    """
    help_ = help_ or Help()
    chosen = [o for o in OBLIGATIONS if names is None or o.name in set(names)]
    for obligation in chosen:
        if obligation.about == "class":
            prover.solver.name = f"{prover.model.name}-{obligation.name}".replace(" ", "-")
            prover.help = help_
            for finding in prover.solver.one_after_another(obligation.check(prover, _report(prover, obligation), None)):
                if operation is None or operation in (finding.operation, finding.detail.strip("`")):
                    yield finding
            continue
        for each in prover.model.operations.values():
            if operation is None or each.name == operation:
                prover.solver.name = f"{prover.model.name}-{obligation.name}-{each.name}".replace(" ", "-")
                prover.help = help_.also(each.using)
                for finding in prover.solver.one_after_another(
                    obligation.check(prover, _report(prover, obligation), each)
                ):
                    yield _with_vacuity(prover, obligation, each, finding)


def _report(prover: Prover, obligation: Obligation) -> ObligationReport:
    return ObligationReport(prover, obligation.name, obligation.severity)


def _with_vacuity(prover: Prover, obligation: Obligation, operation: core.Operation, finding: Finding) -> Finding:
    """The finding, marked where it is proved of an operation that can never be performed."""
    if not obligation.assumes or finding.status != "proved":
        return finding
    if isinstance(prover.performed(operation), Impossible):
        return replace(finding, vacuous=True, message="nothing is said: the operation can never be performed")
    return finding
