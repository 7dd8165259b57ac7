"""Quantifiers over numbers eliminated by the solver's tactic ``qe``, and what is left read as a term again.

(The tactics ``qe2`` and ``qe_rec`` answer satisfiability only and are of no use here.)
"""

from __future__ import annotations

from fractions import Fraction

import z3

from cspcheck.checker.proof.descriptions import plain
from cspcheck.checker.proof.encode import Encoder
from cspcheck.checker.proof.precondition import compared, opposite
from cspcheck.checker.proof.sorts import Expr, Unsupported
from cspcheck.checker.proof.terms import all_of, any_of, variables_of
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Constant, Term, Variable

_LONGEST = 40
"""An answer of the tactic with more parts than this is not an answer for people."""


def without_quantifiers(specification: core.Specification, term: Term, seconds: float) -> Term | None:
    """A term that says the same without quantifiers; None where the tactic or this reader cannot tell."""
    encoder = Encoder(specification)
    try:
        formula = encoder.term(plain(term))
    except Unsupported:
        return None
    if encoder.approximated or encoder.facts:
        return None
    context = encoder.sorts.context
    goal = z3.Goal(ctx=context)
    goal.add(formula)
    try:
        tactic = z3.TryFor(
            z3.Then(z3.Tactic("qe", context), z3.Tactic("ctx-solver-simplify", context), ctx=context),
            int(seconds * 1000),
            ctx=context,
        )
        results = tactic(goal)
    except z3.Z3Exception:
        return None
    names = {formula.get_id(): key for key, formula in encoder.values.items()}
    occurring = variables_of([term])
    reader = FormulaReader({i: occurring[key] for i, key in names.items() if key in occurring}, specification, encoder)
    try:
        ways = [all_of(reader.read(part) for part in result) for result in results]
    except UnreadableFormula:
        return None
    if reader.parts > _LONGEST:
        return None
    return any_of(ways)


class UnreadableFormula(Exception):
    """A formula that has no plain term."""


class FormulaReader:
    """Reads formulas of arithmetic and logic as core terms."""

    def __init__(self, variables: dict[int, Variable], specification: core.Specification, encoder: Encoder) -> None:
        self._variables = variables
        self._frees = [core.FreeType(name) for name in specification.frees]
        self._encoder = encoder
        self.parts = 0

    def read(self, formula: Expr) -> Term:
        """The term that says the same.

        Raises:
            UnreadableFormula: there is no plain one.
        """
        self.parts += 1
        known = self._variables.get(formula.get_id())
        if known is not None:
            return known
        if z3.is_true(formula) or z3.is_false(formula):
            return Constant(type=BOOL, value=z3.is_true(formula))
        if z3.is_int_value(formula):
            return Constant(type=core.INT, value=formula.as_long())
        if z3.is_rational_value(formula):
            value = Fraction(formula.numerator_as_long(), formula.denominator_as_long())
            return Constant(type=core.REAL, value=value)
        if not z3.is_app(formula):
            raise UnreadableFormula
        if formula.sort().kind() == z3.Z3_DATATYPE_SORT and not formula.children():
            return self._construct(formula)
        operands = [self.read(child) for child in formula.children()]
        return self._applied(formula, operands)

    def _construct(self, formula: Expr) -> Term:
        """A constant of a free type."""
        for type_ in self._frees:
            sort = self._encoder.sorts.sort(type_)
            if sort != formula.sort():
                continue
            for index, (constructor, _) in enumerate(self._encoder.sorts.free(type_).branches):
                if formula.decl().eq(sort.constructor(index)):
                    return core.Construct(type=type_, constructor=constructor)
        raise UnreadableFormula

    def _applied(self, formula: Expr, operands: list[Term]) -> Term:
        kind = formula.decl().kind()
        match kind:
            case z3.Z3_OP_AND:
                return all_of(operands)
            case z3.Z3_OP_OR:
                return any_of(operands)
            case z3.Z3_OP_NOT:
                return opposite(operands[0])
            case z3.Z3_OP_IMPLIES:
                return Apply(type=BOOL, operator="implies", operands=tuple(operands))
            case z3.Z3_OP_EQ:
                operator = "iff" if operands[0].type == BOOL else "equal"
                return compared(operator, operands[0], operands[1])
            case z3.Z3_OP_LE:
                return compared("at_most", operands[0], operands[1])
            case z3.Z3_OP_LT:
                return compared("less", operands[0], operands[1])
            case z3.Z3_OP_GE:
                return compared("at_most", operands[1], operands[0])
            case z3.Z3_OP_GT:
                return compared("less", operands[1], operands[0])
            case z3.Z3_OP_ADD | z3.Z3_OP_SUB | z3.Z3_OP_MUL:
                names = {z3.Z3_OP_ADD: "plus", z3.Z3_OP_SUB: "minus", z3.Z3_OP_MUL: "times"}
                result = operands[0]
                for operand in operands[1:]:
                    result = Apply(type=result.type, operator=names[kind], operands=(result, operand))
                return result
            case z3.Z3_OP_MOD | z3.Z3_OP_IDIV if isinstance(operands[1], Constant) and operands[1].value > 0:
                # For positive divisors both have the meaning that they have in Z.
                name = "mod" if kind == z3.Z3_OP_MOD else "div"
                return Apply(type=core.INT, operator=name, operands=tuple(operands))
            case z3.Z3_OP_UMINUS:
                return Apply(type=operands[0].type, operator="negate", operands=tuple(operands))
            case z3.Z3_OP_TO_REAL:
                return Apply(type=core.REAL, operator="int_to_real", operands=tuple(operands))
        raise UnreadableFormula
