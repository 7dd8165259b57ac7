"""Asking the solver: the whole question first, then in small scopes; no model is believed before it is replayed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import z3

from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.descriptions import extremes_exist, plain
from cspcheck.checker.proof.encode import Encoder
from cspcheck.checker.proof.functional import functional
from cspcheck.checker.proof.one_point import eliminated, simplified, taken_apart
from cspcheck.checker.proof.question import (
    CLAIM,
    Answer,
    Constraint,
    Found,
    Impossible,
    NotUpTo,
    Question,
    SolverSettings,
    Unanswered,
)
from cspcheck.checker.proof.read_back import ModelReader, Unreadable
from cspcheck.checker.proof.replay import PredicateReplay, Replayed
from cspcheck.checker.proof.sorts import Expr, Unsupported
from cspcheck.checker.proof.terms import Key, Unknown, is_false, is_true, substitute, universe, variables_of
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term, Variable

STEPS = 500_000
"""So many of the solver's steps count as a second: what it takes on an ordinary machine, within a factor of three."""
_SMALL = (3, 10, 100)
"""Counterexamples are looked for with numbers up to these first."""


@dataclass(slots=True)
class _Attempt:
    """One check: ``sat``, ``unsat`` or ``unknown``, with values where there are some."""

    result: str
    found: Found | None = None
    reason: str = ""


class Solver:
    """Answers questions about one specification.

    Args:
        specification: that the questions are about.
        model: the class whose constants they may speak of.
        settings: how hard to try. Seconds are counted in steps of the solver, so the answers depend on nothing else.
        first_query: how many queries have been written out before.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel | None = None,
        settings: SolverSettings | None = None,
        *,
        first_query: int = 0,
    ) -> None:
        self.specification = specification
        self.model = model
        self.settings = settings or SolverSettings()
        self.definedness = Definedness(specification.frees)
        self._queries = first_query
        self._left = 0.0
        self.name = "query"
        """What queries are called when they are written out."""

    def ask(self, question: Question) -> Answer:
        """Whether there are values that satisfy all parts of a question."""
        parts = [part for part in question.parts if not is_true(part.term)]
        if any(is_false(part.term) for part in parts):
            return Impossible()
        seconds = self._left = self.settings.seconds
        sized = any(map(_sized, parts))
        if question.proof:
            proof = self._attempt(question, parts, None, seconds * question.proof)
            return Impossible() if proof.result == "unsat" else Unanswered(proof.reason)
        if sized and self.settings.scopes:
            # Values are found, if there are any, most easily where collections are written out.
            small = self._attempt(question, parts, min(2, self.settings.scopes[-1]), seconds * 0.1)
            if small.found is not None:
                return small.found
        whole = self._attempt(question, parts, None, seconds * 0.4)
        if whole.result == "unsat":
            return Impossible()
        if whole.found is not None:
            return whole.found
        return self._bounded(question, parts, whole.reason) if sized else Unanswered(whole.reason)

    def _bounded(self, question: Question, parts: list[Constraint], reason: str) -> Answer:
        """The question in small scopes."""
        searched = 0
        given = any(_has_given(part.term) for part in parts)
        for number, scope in enumerate(self.settings.scopes):
            if self._left <= 0.05:
                break
            share = self._left / (len(self.settings.scopes) - number)
            attempt = self._attempt(question, parts, scope, share)
            if attempt.found is not None:
                return attempt.found
            if attempt.result != "unsat":
                break
            # A given set has as many elements as the scope says, not fewer: a gap in the scopes is a gap in the search.
            if not given or scope == searched + 1:
                searched = scope
        return NotUpTo(searched, reason) if searched else Unanswered(reason)

    def _attempt(self, question: Question, parts: list[Constraint], scope: int | None, seconds: float) -> _Attempt:
        encoder = Encoder(self.specification, scope)
        try:
            formulas = self._formulas(encoder, parts, solve=True)
            for variable in question.shown:
                encoder.variable(variable)
        except Unsupported as unsupported:
            return _Attempt("unknown", reason=f"there is no formula for {unsupported}")
        solver = z3.Solver(ctx=encoder.sorts.context)
        solver.set("random_seed", self.settings.seed)
        solver.add(*formulas, *encoder.facts)
        self._write_out(solver, scope)
        result = self._check(solver, seconds)
        if result == z3.unsat:
            if self._confirmed([*formulas, *encoder.facts], encoder, seconds):
                return _Attempt("unsat")
            return _Attempt("unknown", reason="the solver contradicts itself")
        if result == z3.unknown:
            return _Attempt("unknown", reason=_because(solver.reason_unknown(), seconds))
        if question.proof:
            return _Attempt("sat", reason="it does not follow from what is known")
        return self._read(question, parts, encoder, solver, seconds)

    def _confirmed(self, formulas: Sequence[Expr], encoder: Encoder, seconds: float) -> bool:
        """Whether the solver finds a contradiction by another way, too.

        With quantifiers over arrays it has been seen to find one where there is none, for a seed alone. By instances of
        terms that occur (E-matching) it does not, and hardly twice for different seeds.
        """
        for options in ({"mbqi": False}, {"random_seed": self.settings.seed + 1}):
            again = z3.Solver(ctx=encoder.sorts.context)
            again.set("random_seed", self.settings.seed)
            for name, value in options.items():
                again.set(name, value)
            again.add(*formulas)
            if self._check(again, seconds) == z3.unsat:
                return True
        return False

    def _formulas(self, encoder: Encoder, parts: Iterable[Constraint], *, solve: bool = False) -> list[Expr]:
        """The formulas of parts. With *solve* what equations say of after-values and outputs is put in their place."""
        terms: list[Term] = []
        for part in parts:
            # Simplification drops what makes no difference to the truth, undefined terms included: it comes second.
            for term in (part.term,) if part.total else self.definedness.holding([part.term]):
                terms.append(taken_apart(plain(simplified(functional(term))), _result))
        terms += [plain(lemma) for term in list(terms) for lemma in extremes_exist(term)]
        if solve:
            results = [Unknown(v, universe(v.type)) for v in variables_of(terms).values() if _result(v)]
            values: list[tuple[Variable, Term]] = []
            _, solved = eliminated(results, terms, values)
            terms = list(solved)
            for variable, value in reversed(values):
                encoder.values[variable.name, variable.role] = encoder.term(value)
        return [encoder.term(term) for term in terms]

    def _write_out(self, solver: Expr, scope: int | None) -> None:
        if self.settings.smtlib is not None:
            self._queries += 1
            suffix = "" if scope is None else f"-scope{scope}"
            self.settings.smtlib.append((f"{self.name}-{self._queries:03}{suffix}", solver.to_smt2()))

    def _check(self, solver: Expr, seconds: float) -> Expr:
        """Have the solver decide, in as many of its steps as make so many seconds."""
        solver.set("rlimit", max(1, int(seconds * STEPS)))
        try:
            return solver.check()
        except z3.Z3Exception:
            return z3.unknown
        finally:
            self._left -= _steps(solver) / STEPS

    # --- values ------------------------------------------------------------------------------------------------------

    def _read(
        self, question: Question, parts: list[Constraint], encoder: Encoder, solver: Expr, seconds: float
    ) -> _Attempt:
        """The values of a model, replayed; with small numbers if there are such."""
        reason = "the solver's values are not values of the specification"
        for model in self._models(encoder, solver, seconds):
            try:
                values, sizes = _values(question, parts, encoder, model)
            except (Unreadable, z3.Z3Exception) as unreadable:
                reason = f"the solver's values cannot be written: {unreadable}"
                continue
            found = self._believed(parts, values, sizes)
            if found is not None:
                return _Attempt("sat", found)
        return _Attempt("unknown", reason=reason)

    def _models(self, encoder: Encoder, solver: Expr, seconds: float) -> Iterable[Expr]:
        """Models, those with small numbers first."""
        first = solver.model()
        numbers = [formula for (_, role), formula in encoder.values.items() if role != "bound" and z3.is_arith(formula)]
        lengths = [formula for name_role, formula in _sequence_lengths(encoder) if name_role[1] != "bound"]
        for bound in _SMALL if numbers or lengths else ():
            solver.push()
            solver.add(*[z3.And(number >= -bound, number <= bound) for number in numbers])
            solver.add(*[length <= bound for length in lengths])
            small = solver.model() if self._check(solver, min(seconds, 1.0)) == z3.sat else None
            solver.pop()
            if small is not None:
                yield small
                break
        yield first

    def _believed(self, parts: list[Constraint], values: dict[Variable, Term], sizes: dict[str, int]) -> Found | None:
        """The values, if the evaluator finds that they satisfy all parts, as far as it can tell."""
        replay = PredicateReplay(self.specification, self.model, sizes, values)
        vouched = []
        for part in parts:
            said = replay.holds(part.term)
            if said is Replayed.FAILS:
                return None
            if said is Replayed.UNDECIDED:
                if not self._sure(part, values, sizes):
                    return None
                vouched.append(part)
        return Found(values, tuple(vouched))

    def _sure(self, part: Constraint, values: dict[Variable, Term], sizes: dict[str, int]) -> bool:
        """Whether the solver can prove a part at the values: without approximations, its negation impossible."""
        if any(isinstance(value.type, core.GivenType) for value in values.values()) and sizes:
            return self._sure_with_elements(part, values)
        table: dict[Key, Term] = {(v.name, v.role): value for v, value in values.items()}
        return self._proved(substitute(part.term, table), [])

    def _sure_with_elements(self, part: Constraint, values: dict[Variable, Term]) -> bool:
        table: dict[Key, Term] = {(v.name, v.role): value for v, value in values.items()}
        term = substitute(part.term, table)
        elements = [v for v in variables_of([term]).values() if isinstance(v.type, core.GivenType)]
        distinct = [
            core.Apply(
                type=core.BOOL,
                operator="not",
                operands=(core.Apply(type=core.BOOL, operator="equal", operands=(a, b)),),
            )
            for i, a in enumerate(elements)
            for b in elements[i + 1 :]
            if a.type == b.type
        ]
        return self._proved(term, distinct)

    def _proved(self, term: Term, premises: Sequence[Term]) -> bool:
        encoder = Encoder(self.specification)
        try:
            goal = encoder.all(self._formulas(encoder, [Constraint(term, "")]))
            given = self._formulas(encoder, [Constraint(premise, "") for premise in premises])
        except Unsupported:
            return False
        solver = z3.Solver(ctx=encoder.sorts.context)
        solver.set("random_seed", self.settings.seed)
        solver.add(*given, *encoder.facts, z3.Not(goal))
        return bool(self._check(solver, self.settings.seconds * 0.2) == z3.unsat)

    # --- reasons -----------------------------------------------------------------------------------------------------

    def conflict(self, parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
        """A smallest set of parts that cannot hold together, of parts that cannot.

        Parts without a line of their own are left out of the result, and removed last.
        """
        left = [part for part in parts if not is_true(part.term)]
        seconds = self.settings.seconds / 10
        core_ = self._core(left, seconds)
        if core_ is not None:
            left = core_
        for part in sorted(left, key=lambda p: p.span is None):
            rest = [other for other in left if other is not part]
            if self._impossible(rest, seconds):
                left = rest
        return tuple(left)

    def core(self, parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
        """Parts that cannot hold together already, of parts that cannot; all of them where the solver cannot tell."""
        left = [part for part in parts if not is_true(part.term)]
        found = self._core(left, self.settings.seconds * 0.4)
        return tuple(left if found is None else found)

    def needed(self, question: Question) -> tuple[Constraint, ...] | None:
        """Parts of a question that cannot hold together, as few as one by one can be left out; None: not found again.

        A core that the solver tells is shortened by asking without each of its parts: the plainest reasons are left.
        """
        left = [part for part in question.parts if not is_true(part.term)]
        false = next((part for part in left if is_false(part.term)), None)
        if false is not None:
            return (false,)
        self._left = self.settings.seconds
        told = self._core(left, self.settings.seconds * 0.1)
        if told is None or not self._impossible(told, self.settings.seconds * 0.1, solve=True):
            told = left
            if not self._impossible(left, self.settings.seconds * (question.proof or 0.4), solve=True):
                return None
        left = told
        for part in sorted(left, key=_plainness):
            if self._left <= 0.2 * self.settings.seconds:
                break
            rest = [other for other in left if other is not part]
            if self._impossible(rest, self.settings.seconds * 0.03, solve=True):
                left = rest
        return tuple(left)

    def _core(self, parts: list[Constraint], seconds: float) -> list[Constraint] | None:
        encoder = Encoder(self.specification)
        try:
            formulas = [encoder.all(self._formulas(encoder, [part])) for part in parts]
        except Unsupported:
            return None
        solver = z3.Solver(ctx=encoder.sorts.context)
        solver.set("random_seed", self.settings.seed)
        solver.set("unsat_core", True)
        solver.add(*encoder.facts)
        names = {}
        for i, formula in enumerate(formulas):
            label = z3.Bool(f"part%{i}", encoder.sorts.context)
            names[f"part%{i}"] = parts[i]
            solver.assert_and_track(formula, label)
        if self._check(solver, seconds) != z3.unsat:
            return None
        chosen = {str(label) for label in solver.unsat_core()}
        return [part for name, part in names.items() if name in chosen]

    def _impossible(self, parts: list[Constraint], seconds: float, *, solve: bool = False) -> bool:
        encoder = Encoder(self.specification)
        try:
            formulas = self._formulas(encoder, parts, solve=solve)
        except Unsupported:
            return False
        solver = z3.Solver(ctx=encoder.sorts.context)
        solver.set("random_seed", self.settings.seed)
        solver.add(*formulas, *encoder.facts)
        return bool(self._check(solver, seconds) == z3.unsat)


def _plainness(part: Constraint) -> int:
    """How plain a reason for something a part is; of the claim itself, as what should be left."""
    plain = ("axiom", "invariant", "guard", "effect")
    kinds = [number for number, kind in enumerate(plain, 1) if part.what.startswith(kind)]
    return len(plain) + 2 if part.what == CLAIM else kinds[0] if kinds else len(plain) + 1 if part.span else 0


def _result(variable: Variable) -> bool:
    """Whether a variable belongs to what an operation gives."""
    return variable.role in ("after", "output")


def _sized(part: Constraint) -> bool:
    """Whether a scope makes a difference to a predicate: it speaks of given sets or collections."""
    todo = [part.term]
    while todo:
        term = todo.pop()
        if _has_size(term.type) or (isinstance(term, Variable) and isinstance(term.type, core.SetType)):
            return True
        todo.extend(core.parts(term))
    return False


def _has_given(term: Term) -> bool:
    """Whether a term speaks of given sets."""
    return _mentions_given(term.type) or any(map(_has_given, core.parts(term)))


def _mentions_given(type_: core.Type) -> bool:
    match type_:
        case core.GivenType():
            return True
        case core.TupleType(items=items):
            return any(map(_mentions_given, items))
        case core.RecordType(fields=fields):
            return any(_mentions_given(part) for _, part in fields)
        case core.SetType(element=element) | core.SequenceType(element=element) | core.BagType(element=element):
            return _mentions_given(element)
        case core.FunctionType(domain=domain, range=range_):
            return _mentions_given(domain) or _mentions_given(range_)
    return False


def _has_size(type_: core.Type) -> bool:
    match type_:
        case core.GivenType() | core.SequenceType() | core.FunctionType() | core.BagType():
            return True
        case core.TupleType(items=items):
            return any(map(_has_size, items))
        case core.RecordType(fields=fields):
            return any(_has_size(part) for _, part in fields)
        case core.SetType(element=element):
            # Carriers are sets as well; an interval or a display is no collection that the solver chooses.
            return _has_size(element)
    return False


def _steps(solver: Expr) -> int:
    """How many steps the solver has taken."""
    statistics = solver.statistics()
    for key in statistics.keys():  # noqa: SIM118 (no mapping)
        if key == "rlimit count":
            return int(statistics.get_key_value(key))
    return 0


def _because(reason: str, seconds: float) -> str:
    """The solver's reason in a user's words."""
    if reason in ("timeout", "canceled", "interrupted from keyboard") or "resource limit" in reason:
        return f"the solver gave up after {seconds:.3g} s of work"
    if "incomplete" in reason:
        return "the solver cannot decide the quantifiers"
    return f"the solver gave up: {reason}"


def _sequence_lengths(encoder: Encoder) -> list[tuple[tuple[str, str], Expr]]:
    found = []
    for name_role, formula in encoder.values.items():
        sort = formula.sort()
        if sort.kind() == z3.Z3_DATATYPE_SORT and sort.name().startswith("seq%"):
            found.append((name_role, sort.accessor(0, 0)(formula)))
    return found


def _values(
    question: Question, parts: list[Constraint], encoder: Encoder, model: Expr
) -> tuple[dict[Variable, Term], dict[str, int]]:
    """The values of the variables, and the sizes of the given sets."""
    reader = ModelReader(encoder, model)
    occurring = variables_of(part.term for part in parts)
    wanted: dict[Key, Variable] = {(v.name, v.role): v for v in question.shown}
    values = {
        variable: reader.value(encoder.variable(variable), variable.type)
        for variable in {**wanted, **occurring}.values()
    }
    return values, reader.sizes()
