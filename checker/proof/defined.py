"""Constants that are defined by recursion: that they exist, and what need not be said where they are computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from cspcheck.checker.proof.question import Answer, Constraint, Impossible
from cspcheck.checker.proof.situation import Situation
from cspcheck.checker.proof.terms import member, substitute, variables
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term, Variable
from cspcheck.cspm.oz.values.recursion import Recursion, recursions
from cspcheck.cspm.oz.values.substitution import rebuilt

Refutes = Callable[[list[Constraint], Term], Answer]


def defined(situation: Situation, refutes: Refutes) -> dict[str, Recursion]:
    """The constants that are there by construction, whatever the other constants are.

    Of each it is shown that its values are in its range where those for smaller arguments are, with nothing known of
    the constants that depend on it. (Definition by recursion: Spivey, *The Z Notation*, 1992, section 4.4.)
    """
    candidates = recursions(situation.constants, situation.axioms)
    found: dict[str, Recursion] = {}
    left = list(candidates)
    while left:
        ready = [name for name in left if _depends(situation, candidates[name]).isdisjoint(left)]
        good = [name for name in ready if _stays_in_range(candidates[name], refutes)]
        found |= {name: candidates[name] for name in good}
        left = [name for name in left if name not in good]
        if not good:
            break
    return found


def _depends(situation: Situation, recursion: Recursion) -> set[str]:
    """The constants that its definition speaks of, and those that axioms tie to them, itself perhaps among them."""
    terms = [recursion.base, recursion.step, recursion.constant.carrier]
    names = {name for term in terms for name, role in variables(term) if role == "constant"}
    parts = [
        Constraint(Apply(type=core.BOOL, operator="equal", operands=(v, v)), "") for v in _constants(situation, names)
    ]
    known = situation.with_constants(parts)
    return names | {name for part in known for name, role in variables(part.term) if role == "constant"}


def _constants(situation: Situation, names: set[str]) -> list[Variable]:
    return [Variable(type=c.type, name=c.name, role="constant") for c in situation.constants if c.name in names]


def _stays_in_range(recursion: Recursion, refutes: Refutes) -> bool:
    table: dict[tuple[str, str], Term] = {}
    premises: list[Constraint] = []
    carriers = [*[(b.name, b.type, b.carrier) for b in recursion.binders]]
    carriers.append((recursion.value.name, recursion.value.type, recursion.range))
    for name, type_, carrier in carriers:
        variable = Variable(type=type_, name=name, role="simple")
        table[name, "bound"] = variable
        premises.append(Constraint(member(variable, carrier), "argument"))
    base = refutes([], member(recursion.base, recursion.range))
    step = refutes(premises, member(substitute(recursion.step, table), recursion.range))
    return isinstance(base, Impossible) and isinstance(step, Impossible)


def without_definitions(parts: Iterable[Constraint], known: Mapping[str, Recursion]) -> list[Constraint]:
    """The parts of a question without those that say what computed constants are."""
    said = {axiom for recursion in known.values() for axiom in recursion.axioms}
    for recursion in known.values():
        constant = recursion.constant
        itself = Variable(type=constant.type, name=constant.name, role="constant")
        said.add(member(itself, constant.carrier))
    return [part for part in parts if part.term not in said]


def with_domains(term: Term, known: Mapping[str, Recursion]) -> Term:
    """The term with the sets that computed constants are defined on for their domains."""
    term = rebuilt(term, lambda part: with_domains(part, known))
    match term:
        case Apply(operator="dom", operands=(Variable(role="constant", name=name),)) if name in known:
            return known[name].domain
    return term
