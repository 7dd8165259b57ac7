"""The values of core terms: each term becomes a Python closure over a frame of variables.

>>> evaluator = Evaluator(specification)
>>> evaluator.value(term, {("n", "before"): 3})          # one value
>>> evaluator.holds(predicate, {("n", "before"): 3})     # one truth value
>>> evaluator.enumerate(carrier)                         # all values of a set, by the finite readings if it is wide
>>> evaluator.contains(carrier, value)                   # whether the set, not its reading, has a value

Whoever evaluates often makes a :class:`FrameScope`, compiles once (:meth:`TermEvaluator.code`,
:meth:`TermEvaluator.predicate`) and fills frames. Logic is that of Kleene: a predicate that has a truth value whatever
an undefined part of it might be has that truth value, whichever way round it is written; otherwise
:class:`~cspcheck.cspm.oz.values.carriers.Undefined` is raised, and never is a wrong value given.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, Final, TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    Apply,
    Comprehension,
    Constant,
    Construct,
    Field,
    If,
    Quantifier,
    Record,
    Term,
    Variable,
)
from cspcheck.cspm.oz.processes import messages as messages
from cspcheck.cspm.oz.values.carriers import Frame, TooLarge, Unbounded, Undefined
from cspcheck.cspm.oz.values.readings import Readings
from cspcheck.cspm.oz.values.recursion import Recursion, Recursive, recursions
from cspcheck.cspm.oz.values.terms import Name, free_variables, show_term
from cspcheck.cspm.oz.values.values import Construction, Graph, show
from cspcheck.cspm.values.failure import Failure

Code: TypeAlias = Callable[[Frame], Any]
Test: TypeAlias = Callable[[Frame], bool]


MOST_TRIED: Final = 10_000_000
"""So many values are tried one by one for one question: one operation in one state, one predicate."""


class FrameScope:
    """The variables that some terms share, each with its slot in a frame."""

    def __init__(self, names: Iterable[Name] = ()) -> None:
        self.slots: dict[Name, int] = {}
        for name in names:
            self.slot(*name)

    def slot(self, name: str, role: core.Role) -> int:
        """The slot of a variable, which is new if it has none yet."""
        return self.slots.setdefault((name, role), len(self.slots))

    def frame(self, values: Mapping[Name, Any] | None = None) -> Frame:
        """A frame with room for all variables compiled so far, and *values* in it."""
        frame: Frame = [None] * len(self.slots)
        for name, value in (values or {}).items():
            frame[self.slots[name]] = value
        return frame


class _Constants(Mapping[str, Any]):
    """The constants of an evaluator as a mapping that finds each value when it is asked for."""

    def __init__(self, evaluator: TermEvaluator) -> None:
        self._evaluator = evaluator
        self._names = evaluator._declared()

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        return self._evaluator._constant(name)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class TermEvaluator:
    """Evaluates the terms of one specification, or of one of its classes.

    Args:
        specification: what types and readings the terms have.
        model: a class whose constants are in scope as well.
        constants: values of constants that are not to be found by solving the axioms; asked for when needed.

    Attributes:
        used: the finite readings that what has been compiled follows, as the script writes them.
        has_left: whether something was met that is outside the finite readings.
        most_tried: for one question so many values are tried at most.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel | None = None,
        constants: Mapping[str, Any] | None = None,
    ) -> None:
        self.specification = specification
        self.model = model
        self.most_tried = MOST_TRIED
        self.readings = Readings(specification, self)
        self.used: dict[str, None] = {}
        self.has_left = False
        self._tried = 0
        self._constants: dict[str, Any] = {}
        self._given: Mapping[str, Any] = constants if constants is not None else {}
        self._solving = False
        self._closed: dict[int, tuple[Term, Code]] = {}

    # --- one term, once ------------------------------------------------------------------------------------------

    def value(self, term: Term, assignment: Mapping[Name, Any] | None = None) -> Any:
        """The value of a term.

        Raises:
            Undefined: it has none.
            Unbounded: an infinite set would have to be gone through for it.
        """
        self.begin()
        scope = FrameScope(assignment or ())
        code = self.code(term, scope)
        return code(scope.frame(assignment))

    def holds(self, predicate: Term, assignment: Mapping[Name, Any] | None = None) -> bool:
        """Whether a predicate holds. Raises as :meth:`value` does."""
        return bool(self.value(predicate, assignment))

    def enumerate(self, carrier: Term, assignment: Mapping[Name, Any] | None = None) -> list[Any]:
        """The elements of a set in order: all of it where it is finite, else as its finite reading says.

        Raises:
            Unbounded: it is infinite and has no finite reading.
            TooLarge: it has too many elements.
        """
        from cspcheck.cspm.oz.values.enumeration import enumeration

        scope = FrameScope(assignment or ())
        found = enumeration(self, carrier, scope)
        self.readings.use(found.readings)
        return list(found.code(scope.frame(assignment)))

    def contains(self, carrier: Term, value: Any, assignment: Mapping[Name, Any] | None = None) -> bool:
        """Whether a value of the right type is in a set, whatever its finite reading says."""
        from cspcheck.cspm.oz.values.enumeration import membership

        scope = FrameScope(assignment or ())
        test = membership(self, carrier, scope)
        return test(scope.frame(assignment), value)

    def begin(self) -> None:
        """Another question, for which values may be tried anew."""
        self._tried = 0

    def spend(self, tried: int) -> None:
        """Values have been tried.

        Raises:
            Failure: too many for one question.
        """
        self._tried += tried
        if self._tried > self.most_tried:
            raise Failure(messages.too_many_tried(self.most_tried), is_limit=True)

    # --- constants -----------------------------------------------------------------------------------------------

    @property
    def constants(self) -> Mapping[str, Any]:
        """The values of the global constants and of those of the class, found when they are asked for.

        Where the axioms leave a choice, the first values that satisfy them are taken, and that is a reading like
        any other: ``used`` says so. Asking for a value raises ``Failure`` if no values satisfy the axioms, or there are
        infinitely many to choose from.
        """
        return _Constants(self)

    def _declared(self) -> dict[str, core.Declared]:
        declared = (*self.specification.constants, *(self.model.constants if self.model else ()))
        return {d.name: d for d in declared}

    def _constant(self, name: str) -> Any:
        """The value of one constant, found together with those that the same axioms speak of."""
        if name not in self._constants:
            if name in self._given:
                self._constants[name] = self._given[name]
            elif name in self.recursions:
                self._constants[name] = Recursive(self, self.recursions[name])
            else:
                was, self._solving = self._solving, True
                try:
                    self._constants |= self._solve(*self._together(name))
                finally:
                    self._solving = was
        return self._constants[name]

    @cached_property
    def recursions(self) -> Mapping[str, Recursion]:
        """The constants that are defined by recursion."""
        axioms = (*self.specification.axioms, *(self.model.axioms if self.model else ()))
        return recursions(self._declared().values(), axioms)

    def _together(self, name: str) -> tuple[list[core.Declared], list[Term]]:
        """The constants that must be chosen together with one, and the axioms about them."""
        known = self.recursions
        declared = {n: d for n, d in self._declared().items() if n not in known}
        said = {axiom for recursion in known.values() for axiom in recursion.axioms}
        axioms = [*self.specification.axioms, *(self.model.axioms if self.model else ())]
        axioms = [axiom for axiom in axioms if axiom not in said]
        mentioned = [{n for n, role in free_variables(a) if role == "constant"} - known.keys() for a in axioms]
        carriers = {
            d.name: {n for n, role in free_variables(d.carrier) if role == "constant"} for d in declared.values()
        }
        group = {name}
        while True:
            more = {n for names in mentioned if names & group for n in names}
            more |= {n for d, names in carriers.items() if d in group or names & group for n in (d, *names)}
            if more <= group:
                break
            group |= more
        found = [axiom for axiom, names in zip(axioms, mentioned, strict=True) if names & group]
        return [d for n, d in declared.items() if n in group], found

    def _solve(self, declared: Sequence[core.Declared], axioms: Sequence[Term]) -> dict[str, Any]:
        from cspcheck.cspm.oz.values.solving import SoughtVariable, solver

        given = {d.name: self._given[d.name] for d in declared if d.name in self._given}
        scope = FrameScope((d.name, "constant") for d in declared)
        unknowns = [SoughtVariable(d.name, "constant", d.carrier, d.span) for d in declared if d.name not in given]
        solve = solver(self, scope, unknowns, axioms)
        solve.use_readings(self)
        frame = scope.frame({(name, "constant"): value for name, value in given.items()})
        slots = [scope.slot(d.name, "constant") for d in declared]
        found: list[tuple[Any, ...]] = []

        def take(frame: Frame) -> bool:
            values = tuple([frame[slot] for slot in slots])
            if values not in found:
                found.append(values)
            return len(found) > 1

        solve.run(frame, take)
        if not found:
            raise Failure(messages.no_constants([d.name for d in declared], declared[0].span))
        if len(found) > 1:
            for d, first, second in zip(declared, *found, strict=True):
                if first != second:
                    self.used[f"{d.name} = {show(first, d.type)} (one of several values)"] = None
        return {d.name: value for d, value in zip(declared, found[0], strict=True)}

    # --- compiling -----------------------------------------------------------------------------------------------

    def code(self, term: Term, scope: FrameScope) -> Code:
        """Code for the value of a term. Its variables are those of *scope*, and constants."""
        if isinstance(term, Constant):
            return _constantly(term.value)
        if isinstance(term, Variable):
            return self._variable(term, scope)
        if not self._solving and not any(role != "constant" for _, role in free_variables(term)):
            return self._once(term)
        return self._compile(term, scope)

    def predicate(self, term: Term, scope: FrameScope) -> Test:
        """Code for the truth of a predicate."""
        return self.code(term, scope)

    def _once(self, term: Term) -> Code:
        """Code for a term without variables: evaluated when first needed, then known."""
        known = self._closed.get(id(term))
        if known is not None:
            return known[1]
        kept: list[Any] = []

        def closed(frame: Frame) -> Any:
            if not kept:
                scope = FrameScope()
                code = self._compile(term, scope)
                kept.append(code(scope.frame()))
            return kept[0]

        self._closed[id(term)] = (term, closed)  # the term is kept so that its id stays its own
        return closed

    def _variable(self, term: Variable, scope: FrameScope) -> Code:
        slot = scope.slots.get((term.name, term.role))
        if slot is not None:
            return lambda frame: frame[slot]
        if term.role != "constant":
            raise KeyError(f"{show_term(term)} is not in scope")
        name = term.name
        return lambda frame: self._constant(name)

    def _compile(self, term: Term, scope: FrameScope) -> Code:
        match term:
            case Construct():
                return self._construct(term, scope)
            case Record():
                return _tuple([self.code(value, scope) for value in term.values])
            case Field():
                kind = term.record.type
                assert isinstance(kind, core.RecordType)
                position = [name for name, _ in kind.fields].index(term.name)
                record = self.code(term.record, scope)
                return lambda frame: record(frame)[position]
            case If():
                test, then, otherwise = (self.code(t, scope) for t in (term.test, term.then, term.otherwise))
                return lambda frame: then(frame) if test(frame) else otherwise(frame)
            case Quantifier():
                from cspcheck.cspm.oz.values.binding import quantifier

                return quantifier(self, term, scope)
            case Comprehension():
                from cspcheck.cspm.oz.values.binding import comprehension

                return comprehension(self, term, scope)
            case Apply():
                return self._apply(term, scope)
        raise TypeError(f"not a core term: {term!r}")

    def rank(self, type_: str, constructor: str) -> int:
        """The number of a constructor in its free type."""
        definition = self.specification.frees[type_]
        return [name for name, _ in definition.branches].index(constructor)

    def _construct(self, term: Construct, scope: FrameScope) -> Code:
        assert isinstance(term.type, core.FreeType)
        rank = self.rank(term.type.name, term.constructor)
        constructor = term.constructor
        if term.argument is None:
            return _constantly(Construction(rank, constructor))
        argument = self.code(term.argument, scope)
        return lambda frame: Construction(rank, constructor, argument(frame))

    def _apply(self, term: Apply, scope: FrameScope) -> Code:
        from cspcheck.cspm.oz.values.enumeration import CARRIERS, carrier_value, membership
        from cspcheck.cspm.oz.values.evaluation_operators import OPERATIONS

        operator, operands = term.operator, term.operands
        match operator:
            case "and" | "or":
                return _all_or_any([self.code(o, scope) for o in operands], operator == "or")
            case "implies":
                first, second = (self.code(o, scope) for o in operands)
                return _all_or_any([lambda frame: not first(frame), second], True)
            case "in":
                value, test = self.code(operands[0], scope), membership(self, operands[1], scope)
                return lambda frame: test(frame, value(frame))
            case "item":
                assert isinstance(operands[1], Constant)
                items, position = self.code(operands[0], scope), int(operands[1].value)
                return lambda frame: items(frame)[position]
            case "init":
                return self._record_init(term, scope)
            case "apply" if isinstance(operands[0], Comprehension):
                from cspcheck.cspm.oz.values.binding import applied

                return applied(self, operands[0], operands[1], scope)
        if operator in CARRIERS:
            return carrier_value(self, term, scope)
        return OPERATIONS[operator](term, [self.code(o, scope) for o in operands])

    def _record_init(self, term: Apply, scope: FrameScope) -> Code:
        kind = term.operands[0].type
        assert isinstance(kind, core.RecordType)
        test = self.record_test(kind.name, initial=True)
        record = self.code(term.operands[0], scope)
        return lambda frame: test(record(frame))

    def record_test(self, name: str, *, initial: bool = False) -> Callable[[tuple[Any, ...]], bool]:
        """Whether the fields' values satisfy the predicate of a schema, or with *initial* its INIT."""
        definition = self.specification.records[name]
        predicates = (definition.initial or ()) if initial else definition.predicates
        fields = FrameScope((f.name, "bound") for f in definition.fields)
        tests = _all_or_any([self.code(p, fields) for p in predicates], False)

        def test(values: tuple[Any, ...]) -> bool:
            frame = fields.frame()
            frame[: len(values)] = values
            return bool(tests(frame))

        return test


def _constantly(value: Any) -> Code:
    return lambda frame: value


def _tuple(items: Sequence[Code]) -> Code:
    if len(items) == 2:
        a, b = items
        return lambda frame: (a(frame), b(frame))
    return lambda frame: tuple([item(frame) for item in items])


def _all_or_any(tests: Sequence[Test], deciding: bool) -> Test:
    """Whether any test (deciding: True) or none but true ones (deciding: False), in the logic of Kleene."""

    def decide(frame: Frame) -> bool:
        try:
            for test in tests:
                if test(frame) is deciding:
                    return deciding
        except Undefined:
            for other in tests:
                try:
                    if other(frame) is deciding:
                        return deciding
                except Undefined:
                    continue
            raise
        return not deciding

    return decide


__all__ = ["Code", "Fraction", "FrameScope", "Graph", "TermEvaluator", "Test", "TooLarge", "Unbounded", "Undefined"]
