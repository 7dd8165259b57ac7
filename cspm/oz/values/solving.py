"""Finding the values of variables that satisfy a predicate, without trying more of them than must be tried.

A solver is planned once and run often. Its plan follows the predicate's form: what can be tested is tested first; an
equation whose other side is known gives its variable's value (the one-point rule), through sums, tuples,
constructors and sequences too; a disjunction, an implication, a conditional or an existential quantifier that has such
equations is taken apart into branches; only what is left is tried value by value: from a set that the predicate says
the variable is in, between bounds, or last from the variable's carrier or the finite reading of that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    Apply,
    FiniteReading,
    If,
    Quantifier,
    Term,
    Variable,
)
from cspcheck.cspm.oz.values.carriers import Frame, Unbounded, Undefined
from cspcheck.cspm.oz.values.enumeration import Enumeration, Member, enumeration, membership
from cspcheck.cspm.oz.values.isolating import concatenated, isolated
from cspcheck.cspm.oz.values.terms import Name, conjuncts, free_variables, negated
from cspcheck.cspm.source import Span

if TYPE_CHECKING:
    from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator

Code: TypeAlias = Callable[[Frame], Any]
Emit: TypeAlias = Callable[[Frame], bool]
"""Told of each solution, which the frame holds; True ends the search."""
SolvingStep: TypeAlias = Callable[[Frame, Emit], bool]

MOST_BRANCHES: Final = 2_000
"""A plan is taken apart into so many branches; what is compound beyond that is tested, not taken apart."""


@dataclass(frozen=True, slots=True)
class SoughtVariable:
    """A variable to be found, and the set that it is taken from."""

    name: str
    role: core.Role
    carrier: Term
    span: Span | None = None

    @property
    def key(self) -> Name:
        """Name and role."""
        return (self.name, self.role)

    @property
    def written(self) -> str:
        """The variable as a script writes it."""
        return self.name.split("%")[0] + {"after": "'", "input": "?", "output": "!"}.get(self.role, "")


@dataclass(frozen=True, eq=False, slots=True)
class SolutionPlan:
    """A way to all solutions of a predicate.

    Attributes:
        run: fills a frame with one solution after the other (perhaps the same one several times) and tells of
            each; gives whether it was ended.
        sampled: variables that are tried value by value from a finite reading of their carrier, with the readings.
        bounded: whether there is a finite way to all solutions.
    """

    run: SolvingStep
    sampled: tuple[tuple[SoughtVariable, tuple[FiniteReading, ...]], ...]
    bounded: bool

    @property
    def exact(self) -> bool:
        """Whether all solutions are found."""
        return self.bounded and not self.sampled

    def use_readings(self, evaluator: TermEvaluator) -> None:
        """Remember the finite readings that the way follows."""
        for _, readings in self.sampled:
            evaluator.readings.use(readings)


def solver(
    evaluator: TermEvaluator,
    scope: FrameScope,
    unknowns: Sequence[SoughtVariable],
    predicates: Iterable[Term],
    *,
    lazily: bool = False,
) -> SolutionPlan:
    """Plan how to find *unknowns* that satisfy all *predicates* and lie in their carriers.

    *lazily*: plan a branch when the search first comes to it, as most never are where few values are tried. What the
    solver says of itself, readings and whether it is bounded, is then that of the branches planned so far.
    """
    for unknown in unknowns:
        scope.slot(*unknown.key)
    planner = _Planner(evaluator, scope, lazily)
    run = planner.plan(tuple(conjuncts(predicates)), tuple(unknowns))
    return SolutionPlan(run, tuple(planner.sampled.values()), planner.bounded)


class _Planner:
    def __init__(self, evaluator: TermEvaluator, scope: FrameScope, lazily: bool = False) -> None:
        self.evaluator = evaluator
        self.scope = scope
        self._branch = self._later if lazily else self.plan
        self.sampled: dict[Name, tuple[SoughtVariable, tuple[FiniteReading, ...]]] = {}
        self.bounded = True
        self._branched = 0
        self._free: dict[int, tuple[Term, frozenset[Name]]] = {}

    def free(self, term: Term) -> frozenset[Name]:
        found = self._free.get(id(term))
        if found is None:
            found = self._free[id(term)] = (term, free_variables(term))
        return found[1]

    def plan(self, pending: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...]) -> SolvingStep:
        keys = frozenset(unknown.key for unknown in unknowns)
        tests = [term for term in pending if self.free(term).isdisjoint(keys)]
        if tests:
            rest = tuple([term for term in pending if not self.free(term).isdisjoint(keys)])
            return self._filtered(tests, rest, unknowns)
        if not unknowns:
            return _found
        for i, term in enumerate(pending):
            others = (*pending[:i], *pending[i + 1 :])
            solved = isolated(term, keys, self.free)
            if isinstance(solved, tuple):
                variable, value = solved
                return self._assigned(variable, value, others, unknowns)
            if solved is not None:
                return self.plan((*others, *solved.conjuncts), unknowns)
        for i, term in enumerate(pending):
            others = (*pending[:i], *pending[i + 1 :])
            step = self._branches(term, others, unknowns, keys)
            if step is not None:
                return step
        return self._tried(pending, unknowns, keys)

    # --- tests and equations -------------------------------------------------------------------------------------

    def _filtered(self, tests: list[Term], rest: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...]) -> SolvingStep:
        codes = [self.evaluator.predicate(test, self.scope) for test in tests]
        then = self.plan(rest, unknowns)

        def undecided(frame: Frame) -> bool:
            """Whether what has no value matters: nothing else speaks against a solution."""
            for code in codes:
                try:
                    if not code(frame):
                        return False
                except Undefined:
                    continue
            return then(frame, _stop)

        if len(codes) == 1:
            (only,) = codes

            def test_one(frame: Frame, emit: Emit) -> bool:
                try:
                    if not only(frame):
                        return False
                except Undefined:
                    if undecided(frame):
                        raise
                    return False
                return then(frame, emit)

            return test_one

        def test_all(frame: Frame, emit: Emit) -> bool:
            try:
                for code in codes:
                    if not code(frame):
                        return False
            except Undefined:
                if undecided(frame):
                    raise
                return False
            return then(frame, emit)

        return test_all

    def _assigned(
        self, key: Name, value: Term, pending: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...]
    ) -> SolvingStep:
        unknown = next(u for u in unknowns if u.key == key)
        others = tuple([u for u in unknowns if u is not unknown])
        inside, pending = self._carrier_test(unknown, pending, others)
        code = self.evaluator.code(value, self.scope)
        slot = self.scope.slot(*key)
        then = self.plan(pending, others)
        without: list[SolvingStep] = []

        def undecided(frame: Frame) -> bool:
            """Whether the equation matters: with some value of the variable, all else could be satisfied."""
            if not without:
                without.append(_Planner(self.evaluator, self.scope).plan(pending, (*others, unknown)))
            frame.extend([None] * (len(self.scope.slots) - len(frame)))
            try:
                return without[0](frame, _stop)
            except Unbounded:
                return True

        def assign(frame: Frame, emit: Emit) -> bool:
            try:
                found = code(frame)
            except Undefined:
                if undecided(frame):
                    raise
                return False
            if inside is not None and not inside(frame, found):
                return False
            frame[slot] = found
            return then(frame, emit)

        return assign

    def _carrier_test(
        self, unknown: SoughtVariable, pending: tuple[Term, ...], others: tuple[SoughtVariable, ...]
    ) -> tuple[Member | None, tuple[Term, ...]]:
        """How a value is held against the carrier: at once, or later if the carrier depends on other unknowns."""
        carrier = unknown.carrier
        if isinstance(carrier, Apply) and carrier.operator in ("Int", "Real", "Bool"):
            return None, pending
        if not self.free(carrier).isdisjoint(u.key for u in others):
            assert isinstance(carrier.type, core.SetType)
            variable = Variable(type=carrier.type.element, name=unknown.name, role=unknown.role, span=unknown.span)
            return None, (*pending, Apply(type=core.BOOL, operator="in", operands=(variable, carrier)))
        return membership(self.evaluator, carrier, self.scope), pending

    # --- branches ------------------------------------------------------------------------------------------------

    def _branches(
        self, term: Term, others: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...], keys: frozenset[Name]
    ) -> SolvingStep | None:
        if self._branched >= MOST_BRANCHES or not _has_equation(term, keys):
            return None
        self._branched += 1
        if isinstance(term, Quantifier) and term.kind == "exists":
            more = tuple([SoughtVariable(b.name, "bound", b.carrier, term.span) for b in term.binders])
            for unknown in more:
                self.scope.slot(*unknown.key)
            return self.plan((*others, *conjuncts((term.condition, term.body))), (*unknowns, *more))
        if isinstance(term, If) and self.free(term.test).isdisjoint(keys):
            test = self.evaluator.predicate(term.test, self.scope)
            then = self._branch((*others, *conjuncts([term.then])), unknowns)
            otherwise = self._branch((*others, *conjuncts([term.otherwise])), unknowns)
            return lambda frame, emit: then(frame, emit) if test(frame) else otherwise(frame, emit)
        alternatives = _alternatives(term)
        if alternatives is None:
            return None
        steps = [self._branch((*others, *conjuncts(alternative)), unknowns) for alternative in alternatives]

        return lambda frame, emit: _first(steps, frame, emit)

    def _later(self, pending: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...]) -> SolvingStep:
        """A step that is planned when it is first taken."""
        planned: list[SolvingStep] = []

        def step(frame: Frame, emit: Emit) -> bool:
            if not planned:
                planned.append(self.plan(pending, unknowns))
            frame.extend([None] * (len(self.scope.slots) - len(frame)))
            return planned[0](frame, emit)

        return step

    # --- one value after the other -------------------------------------------------------------------------------

    def _tried(
        self, pending: tuple[Term, ...], unknowns: tuple[SoughtVariable, ...], keys: frozenset[Name]
    ) -> SolvingStep:
        ways = [self._way(unknown, pending, keys) for unknown in unknowns]

        def cost(i: int) -> tuple[int, bool, int, int]:
            key = unknowns[i].key
            helps = sum(1 for term in pending if isolated(term, keys - {key}, self.free) is not None)
            # What an equation gives once the others are known is better not tried before them.
            follows = any(
                isinstance(found := isolated(term, frozenset([key]), self.free), tuple) and found[0] == key
                for term in pending
                if not self.free(term).isdisjoint(keys - {key})
            )
            return (ways[i].rank, follows, -helps, i)

        best = min(range(len(unknowns)), key=cost)
        unknown, way = unknowns[best], ways[best]
        others = tuple([u for u in unknowns if u is not unknown])
        inside: Member | None = None
        if way.check_carrier:
            inside, pending = self._carrier_test(unknown, pending, others)
        if way.enumeration.readings:
            self.sampled[unknown.key] = (unknown, way.enumeration.readings)
        if not way.enumeration.bounded:
            self.bounded = False
        return self._each(unknown, way.enumeration, inside, self.plan(pending, others))

    def _each(self, unknown: SoughtVariable, way: Enumeration, inside: Member | None, then: SolvingStep) -> SolvingStep:
        slot = self.scope.slot(*unknown.key)
        code = way.code
        evaluator = self.evaluator

        def each(frame: Frame, emit: Emit) -> bool:
            try:
                values = code(frame)
            except Unbounded as unbounded:
                raise unbounded.of(unknown.written, unknown.span) from None
            tried = 0
            for value in values:
                tried += 1
                if not tried & 0xFFFF:
                    evaluator.spend(0x10000)
                if inside is None or inside(frame, value):
                    frame[slot] = value
                    if then(frame, emit):
                        return True
            evaluator.spend(tried & 0xFFFF)
            return False

        return each

    def _way(self, unknown: SoughtVariable, pending: tuple[Term, ...], keys: frozenset[Name]) -> _Way:
        """The best way through the values of an unknown."""
        ways: list[_Way] = []
        for term in pending:
            if not (isinstance(term, Apply) and term.operator in ("in", "subset")):
                continue
            left, right = term.operands
            if _is(left, unknown.key) and self.free(right).isdisjoint(keys):
                assert isinstance(right.type, core.SetType)
                if term.operator == "subset":
                    right = Apply(type=core.SetType(right.type), operator="power", operands=(right,), span=right.span)
                found = enumeration(self.evaluator, right, self.scope)
                ways.append(_Way(0 if found.exact else 3 if found.bounded else 5, found, True))
        ways += [_Way(0, found, True) for term in pending for found in self._ends(unknown, term, keys)]
        between = self._between(unknown, pending, keys)
        if between is not None:
            ways.append(_Way(1, between, True))
        if self.free(unknown.carrier).isdisjoint(keys):
            found = enumeration(self.evaluator, unknown.carrier, self.scope)
            ways.append(_Way(2 if found.exact else 4 if found.bounded else 5, found, False))
        else:
            ways.append(_Way(6, Enumeration(lambda frame: _nowhere(unknown), (), False), False))
        return min(ways, key=lambda way: way.rank)

    def _ends(self, unknown: SoughtVariable, term: Term, keys: frozenset[Name]) -> Iterator[Enumeration]:
        """The beginnings of a known sequence that is equal to a concatenation with the unknown first; or its ends."""
        if not (isinstance(term, Apply) and term.operator == "equal"):
            return
        for pattern, value in (term.operands, term.operands[::-1]):
            if not (isinstance(pattern, Apply) and pattern.operator == "concat" and self.free(value).isdisjoint(keys)):
                continue
            items = tuple(concatenated(pattern))
            code = self.evaluator.code(value, self.scope)
            if _is(items[0], unknown.key):
                yield Enumeration(_beginnings(code))
            elif _is(items[-1], unknown.key):
                yield Enumeration(_endings(code))

    def _between(self, unknown: SoughtVariable, pending: tuple[Term, ...], keys: frozenset[Name]) -> Enumeration | None:
        """All integers between bounds that the predicate and the carrier give, if there are both."""
        carrier = unknown.carrier
        if not (isinstance(carrier.type, core.SetType) and isinstance(carrier.type.element, core.IntType)):
            return None
        lows: list[tuple[Callable[[Frame], int], int]] = []
        highs: list[tuple[Callable[[Frame], int], int]] = []
        if isinstance(carrier, Apply) and carrier.operator in ("Nat", "Nat1"):
            lowest = int(carrier.operator == "Nat1")
            lows.append((lambda frame: lowest, 0))
        for term in pending:
            if not (isinstance(term, Apply) and term.operator in ("less", "at_most")):
                continue
            left, right = term.operands
            strict = int(term.operator == "less")
            if _is(left, unknown.key) and self.free(right).isdisjoint(keys):
                highs.append((self.evaluator.code(right, self.scope), -strict))
            elif _is(right, unknown.key) and self.free(left).isdisjoint(keys):
                lows.append((self.evaluator.code(left, self.scope), strict))
        if not lows or not highs:
            return None

        def integers(frame: Frame) -> range:
            low = max([code(frame) + by for code, by in lows])
            high = min([code(frame) + by for code, by in highs])
            return range(low, high + 1)

        return Enumeration(integers)


@dataclass(frozen=True, slots=True)
class _Way:
    """A way through the values of an unknown; the better ranks lower. Carriers need no check of themselves."""

    rank: int
    enumeration: Enumeration
    check_carrier: bool


def _beginnings(code: Code) -> Code:
    return lambda frame: [sequence[:length] for sequence in (code(frame),) for length in range(len(sequence) + 1)]


def _endings(code: Code) -> Code:
    return lambda frame: [sequence[length:] for sequence in (code(frame),) for length in range(len(sequence) + 1)]


def _nowhere(unknown: SoughtVariable) -> Iterable[Any]:
    raise Unbounded(unknown.carrier, unknown.written, unknown.span)


def _found(frame: Frame, emit: Emit) -> bool:
    return emit(frame)


def _stop(frame: Frame) -> bool:
    return True


def _first(steps: Sequence[SolvingStep], frame: Frame, emit: Emit) -> bool:
    return any(step(frame, emit) for step in steps)


def _is(term: Term, key: Name) -> bool:
    return isinstance(term, Variable) and (term.name, term.role) == key


def _alternatives(term: Term) -> list[tuple[Term, ...]] | None:
    """A predicate as the disjunction of conjunctions that it is."""
    match term:
        case Apply(operator="or"):
            return [(operand,) for operand in term.operands]
        case Apply(operator="implies", operands=(a, b)):
            return [(negated(a),), (a, b)]
        case If():
            return [(term.test, term.then), (negated(term.test), term.otherwise)]
        case Apply(operator="iff", operands=(a, b)):
            return [(a, b), (negated(a), negated(b))]
    return None


def _has_equation(term: Term, keys: frozenset[Name]) -> bool:
    """Whether a compound predicate has, somewhere inside, an equation for one of the variables."""
    match term:
        case Apply(operator="and" | "or" | "implies" | "iff" | "not"):
            return any(_has_equation(operand, keys) for operand in term.operands)
        case If(type=core.BoolType()):
            return _has_equation(term.then, keys) or _has_equation(term.otherwise, keys)
        case Quantifier(kind="exists"):
            return _has_equation(term.condition, keys) or _has_equation(term.body, keys)
        case Variable(type=core.BoolType()):
            return (term.name, term.role) in keys
        case Apply(operator="equal"):
            return any(not free_variables(operand).isdisjoint(keys) for operand in term.operands)
    return False
