"""Horn clauses over predicates that are to be found, given to the solver's engine for them.

Its answer is a suggestion: what it finds is read back as predicates and proved by other means, or not used.
"""

from __future__ import annotations

import z3

from cspcheck.checker.proof.descriptions import plain
from cspcheck.checker.proof.elimination import FormulaReader, UnreadableFormula
from cspcheck.checker.proof.encode import Encoder
from cspcheck.checker.proof.question import Horn, Solution
from cspcheck.checker.proof.sorts import Expr, Unsupported
from cspcheck.checker.proof.terms import TRUE, variables_of
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term

_AS_WRITTEN = ("xform.inline_eager", "xform.inline_linear", "xform.slice")
"""What the engine would do to the clauses first; the predicates of all places are wanted."""


def solution(specification: core.Specification, horn: Horn, steps: int) -> Solution | None:
    """Predicates that satisfy the clauses; None where the engine finds none, or there are none.

    Args:
        specification: that the terms belong to.
        horn: the clauses.
        steps: how much work the engine may have.
    """
    encoder = Encoder(specification)
    context = encoder.sorts.context
    try:
        now = [encoder.variable(v) for v in horn.variables]
        later = [encoder.variable(v) for v in horn.afterwards()]
        formulas = [[encoder.term(plain(term)) for term in clause.terms] for clause in horn.clauses]
    except Unsupported:
        return None
    if encoder.facts or encoder.approximated:
        return None  # they are right for some values of what they speak of, which is not what a clause says
    try:
        engine = z3.Fixedpoint(ctx=context)
        engine.set(engine="spacer", rlimit=steps)
        for option in _AS_WRITTEN:
            engine.set(option, False)
        truth = z3.BoolSort(context)
        sorts = [variable.sort() for variable in now]
        places = [z3.Function(f"place{number}", *sorts, truth) for number in range(horn.places)]
        wrong = z3.Function("wrong", truth)
        for relation in (*places, wrong):
            engine.register_relation(relation)
        engine.declare_var(*dict.fromkeys([*now, *later, *encoder.values.values()]))
        for clause, parts in zip(horn.clauses, formulas, strict=True):
            head = (
                wrong()
                if clause.target is None
                else places[clause.target](*(later if clause.source is not None else now))
            )
            body = parts if clause.source is None else [places[clause.source](*now), *parts]
            engine.rule(head, body)
        if engine.query(wrong()) != z3.unsat:
            return None
        found = [engine.get_cover_delta(-1, place) for place in places]
        formulas_ = [z3.substitute_vars(formula, *now) for formula in found]
    except z3.Z3Exception:
        return None
    return Solution(tuple(_read(specification, encoder, horn, formula) for formula in formulas_))


def _read(specification: core.Specification, encoder: Encoder, horn: Horn, formula: Expr) -> Term:
    """A formula as a predicate; true where it has none."""
    known = variables_of(horn.variables)
    names = {encoder.values[key].get_id(): variable for key, variable in known.items()}
    try:
        return FormulaReader(names, specification, encoder).read(formula)
    except UnreadableFormula:
        return TRUE
