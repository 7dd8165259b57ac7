"""Proving that no claim fails in a reachable state: by invariants, one for each place of control.

What an invariant is worth is decided in the end by nothing but the ordinary prover: that it holds at the beginning,
that every step keeps it, and that every claim follows from it. Where it comes from makes no difference. It is looked
for among the predicates of the classes (the largest inductive subset: Flanagan and Leino, *Houdini*, FME 2001) and,
where the data are numbers and truth values, by the solver's engine for Horn clauses (Spacer: Komuravelli, Gurfinkel,
Chaki, *SMT-based model checking for recursive programs*, CAV 2014).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Answer, Constraint, Found, Horn, Impossible, ProofClause
from cspcheck.checker.proof.replay import PredicateReplay, Replayed
from cspcheck.checker.proof.terms import (
    FALSE,
    all_of,
    conjuncts,
    equal,
    integer,
    is_false,
    is_true,
    negation,
    primed,
    renamed,
    substitute,
    variables,
    variables_of,
)
from cspcheck.checker.proof.unbounded.claims import Claim, Problem, Step
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Term, Variable

MOST_CANDIDATES = 60
MOST_QUESTIONS = {"equations": 120, "predicates": 400, "clauses": 400, "smaller": 150}
"""So much is asked of the prover for each way to find an invariant, and to leave out what is not needed of it."""
_GLANCE = 0.5
"""Seconds' worth of the solver's steps for a candidate."""


@dataclass(frozen=True)
class Invariant:
    """What holds at each place, beside the invariants of the classes.

    Attributes:
        places: conjuncts by place; :data:`FALSE` where data never let control get to.
    """

    places: tuple[tuple[Term, ...], ...]


class _Exhausted(Exception):
    """As many questions have been asked as may be."""


class _Hasty(Prover):
    """A prover that answers so many questions, each after a glance."""

    left = 0

    def refutes(self, premises: Iterable[Constraint], goal: Term, shown: Iterable[Variable] = ()) -> Answer:
        """See :class:`Prover`.

        Raises:
            _Exhausted: that was one too many.
        """
        if not self.left:
            raise _Exhausted
        self.left -= 1
        return super().refutes(premises, goal, shown)


class Invariants:
    """Looks for invariants of a problem.

    Args:
        problem: the machine with its claims.
        prover: for its predicates.
    """

    def __init__(self, problem: Problem, prover: Prover) -> None:
        self.problem = problem
        self.prover = prover
        # Most candidates are no invariants, and of those mostly nothing can be proved: each is given little time.
        hasty = replace(prover.solver.settings, seconds=_GLANCE, scopes=())
        self._quick = _Hasty(prover.specification, prover.model, hasty, prover.clock, thorough=False)
        self.nothing = Invariant(tuple(() for _ in problem.places))
        """What the classes guarantee anyway."""

    def at_once(self) -> bool:
        """Whether all claims follow from what the classes guarantee anyway."""
        self._quick.left = MOST_QUESTIONS["equations"]
        try:
            return not self.open_claims(self.nothing, self._quick)
        except _Exhausted:
            return False

    def of_equations(self) -> Invariant | None:
        """An invariant of equations between variables, from which all claims follow; checked."""
        return self._tried("equations", lambda: self._inductive(_comparisons(self.problem.variables())))

    def found(self) -> Invariant | None:
        """An invariant from which all claims follow, checked; None where none is found."""
        return self._tried("predicates", self._by_predicates) or self._tried("clauses", self._by_clauses)

    def _tried(self, way: str, find: Callable[[], Invariant | None]) -> Invariant | None:
        self._quick.left = MOST_QUESTIONS[way]
        try:
            invariant = find()
        except _Exhausted:
            return None
        if invariant is None:
            return None
        small = self._smaller(invariant)
        return small if self.holds(small) else None

    # --- checking ----------------------------------------------------------------------------------------------------

    def holds(self, invariant: Invariant, prover: Prover | None = None) -> bool:
        """Whether it is an invariant, and all claims follow: asked of the prover, whatever is known already."""
        prover = prover or self.prover
        start = all_of(invariant.places[0])
        if not isinstance(prover.refutes(self.problem.initial, start), Impossible):
            return False
        for step in self.problem.steps:
            if not isinstance(self._kept(invariant, step, invariant.places[step.target], prover), Impossible):
                return False
        return not self.open_claims(invariant, prover)

    def open_claims(self, invariant: Invariant, prover: Prover) -> bool:
        """Whether some claim does not follow, or it is not known of one."""
        return any(
            not self._follows(invariant.places[place], claim, prover)
            for place, claims in enumerate(self.problem.claims)
            for claim in claims
        )

    def _follows(self, known: Sequence[Term], claim: Claim, prover: Prover) -> bool:
        if any(map(is_false, known)):
            return True
        premises = (*self.problem.state, *_parts(known), *claim.premises)
        return isinstance(prover.refutes(premises, claim.goal, self.problem.variables()), Impossible)

    def _kept(self, invariant: Invariant, step: Step, goals: Sequence[Term], prover: Prover) -> Answer:
        """Whether goals hold behind a step from a state of which the invariant holds."""
        known = invariant.places[step.source]
        if any(map(is_false, known)) or all(map(is_true, goals)):
            return Impossible()
        after = all_of(substitute(goal, step.unchanged) for goal in primed(goals))
        if not step.move.parts and after in known:
            return Impossible()
        return prover.refutes((*self.problem.state, *_parts(known), *step.parts), after, self._shown())

    def _shown(self) -> list[Variable]:
        states = self.problem.variables()
        return [*states, *(replace(v, role="after") for v in states)]

    # --- the largest inductive subset --------------------------------------------------------------------------------

    def _by_predicates(self) -> Invariant | None:
        """The largest part of what the classes speak of that is an invariant, if the claims follow from it."""
        return self._inductive(self._candidates())

    def _inductive(self, candidates: Iterable[Term], more: Sequence[tuple[Term, ...]] = ()) -> Invariant | None:
        """The candidates that hold at the beginning and are kept together, if the claims follow from them."""
        candidates = list(candidates)
        kept: list[list[Term]] = []
        for place in range(len(self.problem.places)):
            goals = [c.goal for c in self.problem.claims[place] if not c.premises]
            kept.append(list(dict.fromkeys([FALSE, *goals, *(more[place] if more else ()), *candidates])))
        kept[0] = self._initially(kept[0])
        changed = True
        while changed:
            changed = False
            for step in self.problem.steps:
                changed |= self._weakened(kept, step)
        invariant = Invariant(tuple(map(tuple, kept)))
        return None if self.open_claims(invariant, self._quick) else invariant

    def _initially(self, candidates: list[Term]) -> list[Term]:
        return self._surviving(candidates, candidates, self.problem.initial, [])

    def _weakened(self, kept: list[list[Term]], step: Step) -> bool:
        """Drop what a step does not keep; whether anything was dropped."""
        known, goals = kept[step.source], kept[step.target]
        if any(map(is_false, known)) or not goals:
            return False
        if not step.move.parts:
            left = [goal for goal in goals if goal in known]
        else:
            after = [substitute(goal, step.unchanged) for goal in primed(goals)]
            premises = (*self.problem.state, *_parts(known), *step.parts)
            left = self._surviving(goals, after, premises, known)
        kept[step.target] = left
        return len(left) < len(goals)

    def _surviving(
        self, goals: list[Term], after: list[Term], premises: Iterable[Constraint], known: Sequence[Term]
    ) -> list[Term]:
        """The goals that follow, where *after* is what has to follow for each."""
        premises = tuple(premises)
        open_ = list(zip(goals, after, strict=True))
        sure: list[tuple[Term, Term]] = []
        # What does not change is what was known.
        for pair in list(open_):
            if pair[1] in known:
                sure.append(pair)
                open_.remove(pair)
        while open_:
            answer = self._quick.refutes(premises, all_of(t for _, t in open_), self._shown())
            if isinstance(answer, Impossible):
                return [goal for goal in goals if any(goal is g for g, _ in [*sure, *open_])]
            if isinstance(answer, Found):
                replay = PredicateReplay(self.prover.specification, self.prover.model, _sizes(answer), answer.values)
                left = [pair for pair in open_ if replay.holds(pair[1]) is Replayed.HOLDS]
                if len(left) < len(open_):
                    open_ = left
                    continue
            # One by one: what is not proved is not known.
            open_ = [pair for pair in open_ if isinstance(self._quick.refutes(premises, pair[1]), Impossible)]
            break
        return [goal for goal in goals if any(goal is g for g, _ in [*sure, *open_])]

    def _candidates(self) -> list[Term]:
        """Predicates over a state that the classes speak of."""
        found: dict[Term, None] = dict.fromkeys(_comparisons(self.problem.variables()))
        names = {(v.name, v.role) for v in self.problem.variables()}
        for component in self.problem.components:
            model = component.model
            terms = [*(model.initial or ()), *[t for o in model.operations.values() for t in (*o.guard, *o.effect)]]
            for atom in [a for term in terms for a in _atoms(term)]:
                for state in (atom, *_unprimed(atom)):
                    keys = variables(state).keys()
                    if keys & names and all(k in names or k[1] == "constant" for k in keys):
                        found[state] = None
                        found[negation(state)] = None
        for claims in self.problem.claims:
            for claim in claims:
                if not claim.premises:
                    found[claim.goal] = None
        return list(found)[:MOST_CANDIDATES]

    # --- Horn clauses ------------------------------------------------------------------------------------------------

    def _by_clauses(self) -> Invariant | None:
        """What the solver's engine for Horn clauses finds, together with the predicates of the classes."""
        answer = self.prover.solver.solve(horn(self.problem, self.prover), self.prover.solver.settings.seconds)
        if answer is None:
            return None
        places = tuple(tuple(p for p in conjuncts(term) if not is_true(p)) for term in answer.places)
        invariant = Invariant(places)
        if self.holds(invariant, self._quick):
            return invariant
        return self._inductive(self._candidates(), places)

    def _smaller(self, invariant: Invariant) -> Invariant:
        """The invariant without what is not needed, as far as leaving out one conjunct at a time shows it."""
        self._quick.left = MOST_QUESTIONS["smaller"]
        for place, known in enumerate(invariant.places):
            if any(map(is_false, known)):
                only = (FALSE,)
                invariant = Invariant((*invariant.places[:place], only, *invariant.places[place + 1 :]))
        for place, known in enumerate(invariant.places):
            for conjunct in reversed(known):
                if is_false(conjunct):
                    continue
                rest = tuple(other for other in invariant.places[place] if other is not conjunct)
                without = Invariant((*invariant.places[:place], rest, *invariant.places[place + 1 :]))
                try:
                    if self.holds(without, self._quick):
                        invariant = without
                except _Exhausted:
                    return invariant
        return invariant


def horn(problem: Problem, prover: Prover) -> Horn:
    """The problem as Horn clauses over one predicate for each place."""
    total = prover.solver.definedness.holding

    def defined(parts: Iterable[Constraint]) -> tuple[Term, ...]:
        return tuple(t for part in parts for t in ((part.term,) if part.total else total([part.term])))

    everything = [*problem.initial, *problem.state, *[p for step in problem.steps for p in step.parts]]
    everything += [part for claims in problem.claims for claim in claims for part in claim.premises]
    with_axioms = prover.situation.with_constants(everything)
    axioms = [part for part in with_axioms if part not in everything]
    clauses = [ProofClause(None, 0, defined([*axioms, *problem.initial]))]
    for step in problem.steps:
        same = [
            equal(replace(v, role="after"), step.unchanged[v.name, "after"])
            for v in problem.variables()
            if (v.name, "after") in step.unchanged
        ]
        clauses.append(ProofClause(step.source, step.target, (*defined([*problem.state, *step.parts]), *same)))
    for place, claims in enumerate(problem.claims):
        for claim in claims:
            fails = prover.fails(claim.goal)
            clauses.append(ProofClause(place, None, defined([*problem.state, *claim.premises, fails])))
    constants = prover.situation.constant_variables(with_axioms)
    return Horn(len(problem.places), (*problem.variables(), *constants), tuple(clauses))


def _parts(terms: Iterable[Term]) -> tuple[Constraint, ...]:
    return tuple(Constraint(term, "invariant found") for term in terms)


def _sizes(found: Found) -> dict[str, int]:
    """How many elements of each given set the values speak of."""
    sizes: dict[str, int] = {}
    for variable in variables_of(found.values.values()).values():
        if isinstance(variable.type, core.GivenType):
            number = int(variable.name.rsplit("_", 1)[1])
            sizes[variable.type.name] = max(number, sizes.get(variable.type.name, 0))
    return sizes


def _atoms(term: Term) -> Iterable[Term]:
    """The predicates without connectives of which a predicate is made, outside of quantifiers."""
    if isinstance(term, Apply) and term.operator in ("not", "and", "or", "implies", "iff"):
        for operand in term.operands:
            yield from _atoms(operand)
    elif isinstance(term, core.If) and term.type == core.BOOL:
        for part in (term.test, term.then, term.otherwise):
            yield from _atoms(part)
    elif not isinstance(term, Constant):
        yield term


def _unprimed(atom: Term) -> Iterable[Term]:
    """The predicate said of the state before, where it speaks of that afterwards alone."""
    if all(role in ("after", "constant") for _, role in variables(atom)):
        yield from renamed([atom], lambda v: replace(v, role="before") if v.role == "after" else None)


def _comparisons(states: Sequence[Variable]) -> Iterable[Term]:
    """Equations between variables of one type and lengths of sequences, and that numbers are not negative."""
    terms: list[Term] = list(states)
    for variable in states:
        if isinstance(variable.type, core.SequenceType):
            terms.append(Apply(type=core.INT, operator="length", operands=(variable,)))
    for number, one in enumerate(terms):
        for other in terms[number + 1 :]:
            if one.type == other.type:
                yield equal(one, other)
    for one in terms:
        if one.type == core.INT:
            yield Apply(type=core.BOOL, operator="at_most", operands=(integer(0), one))
