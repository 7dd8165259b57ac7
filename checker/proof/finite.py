"""Looking for values by the evaluator of classes, in small scopes: what is false is mostly false of few, small values.

Given sets have k elements, numbers and collections are small; all else is as the specification says, and what an
equation or a finite set determines may be as large as it likes. Values that are found satisfy every predicate, since
it is the evaluator itself that finds them; that none are found says nothing. (The small scope hypothesis: Jackson,
*Software Abstractions*, 2006.)
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, islice, product
from typing import Any, cast

from cspcheck.checker.proof.question import Constraint, Found
from cspcheck.checker.proof.replay import PredicateReplay, Replayed, constant_free, given_reading
from cspcheck.checker.proof.terms import element_name, universe, variables_of
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Term, Variable
from cspcheck.cspm.values.failure import Failure

_MOST_VALUES = 40
"""Of one type so many values are tried at most."""
_NUMBERS = (0, 1, 2, -1, 3, 4, -2, 5, 10)


def found_in_scope(
    specification: core.Specification,
    model: core.ClassModel | None,
    parts: Sequence[Constraint],
    shown: Iterable[Variable],
    scope: int,
    tried: int,
    computed: Collection[str] = (),
) -> Found | None:
    """Values that satisfy all parts, where each given set has *scope* elements.

    Args:
        specification, model: where the parts come from.
        parts: defined everywhere.
        shown: variables whose values are wanted even where no part speaks of them.
        scope: the size of given sets, and about that of numbers and collections.
        tried: so many values are tried before the search is given up.
        computed: constants that are defined by recursion, for which no values are looked for.
    """
    from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator
    from cspcheck.cspm.oz.values.solving import SoughtVariable, solver
    from cspcheck.cspm.oz.values.terms import conjuncts

    variables = {**variables_of(part.term for part in parts)}
    for variable in shown:
        variables.setdefault((variable.name, variable.role), variable)
    variables = {k: v for k, v in variables.items() if v.role != "constant" or v.name not in computed}
    types = {v.type for v in variables.values()}
    sizes = dict.fromkeys(specification.givens, scope)
    samples = _Samples(specification, scope)
    readings = [given_reading(name, size) for name, size in sizes.items()]
    wanted = [t for t in types if not isinstance(t, core.BoolType | core.GivenType)]
    try:
        readings += [_sample(type_, samples.of(type_)) for type_ in wanted]
        evaluator = TermEvaluator(replace(specification, readings=tuple(readings)), model)
        evaluator.most_tried = tried
        slots = FrameScope()
        freed = {key: cast(Variable, constant_free(v)) for key, v in variables.items()}
        unknowns = [SoughtVariable(v.name, v.role, _any(v.type)) for v in freed.values()]
        predicates = [constant_free(part.term, computed) for part in parts]
        values: dict[Variable, Any] = {}

        def take(frame: list[Any]) -> bool:
            for key, variable in variables.items():
                twin = freed[key]
                values[variable] = frame[slots.slot(twin.name, twin.role)]
            return True

        plan = solver(evaluator, slots, unknowns, conjuncts(predicates), lazily=True)
        plan.run(slots.frame(), take)
        ground = {variable: grounded(value, variable.type, specification.frees) for variable, value in values.items()}
    except (Failure, ValueError, KeyError, TypeError):
        return None
    if not ground:
        return None
    replay = PredicateReplay(specification, model, sizes, ground)
    return Found(ground) if all(replay.holds(part.term) is Replayed.HOLDS for part in parts) else None


def _any(type_: core.Type) -> Term:
    """A set that has all values of a type, in a form that no specification has: a reading of it reads nothing else."""
    whole = universe(type_)
    return Apply(type=whole.type, operator="union", operands=(whole, whole))


def _sample(type_: core.Type, values: Sequence[Any]) -> core.FiniteReading:
    from cspcheck.cspm.source import Source

    items = tuple([Constant(type=type_, value=value) for value in values])
    shown = Apply(type=core.SetType(type_), operator="set", operands=items)
    return core.FiniteReading(
        subject=_any(type_), text=str(type_), values=shown, bound=None, span=Source("", "").span(0, 0)
    )


class _Samples:
    """Small values of each type, the smallest first."""

    def __init__(self, specification: core.Specification, scope: int) -> None:
        self._specification = specification
        self._scope = scope
        self._depth = 0

    def of(self, type_: core.Type) -> list[Any]:
        """Some values of a type."""
        return list(islice(self._values(type_), _MOST_VALUES))

    def _values(self, type_: core.Type) -> Iterable[Any]:
        from cspcheck.cspm.oz.values.values import Element

        scope = self._scope
        match type_:
            case core.BoolType():
                return (False, True)
            case core.IntType():
                return _NUMBERS[: 2 * scope + 1]
            case core.RealType():
                return [*map(Fraction, _NUMBERS[: 2 * scope + 1]), Fraction(1, 2)]
            case core.GivenType(name=name):
                return [Element(name, number) for number in range(1, scope + 1)]
            case core.FreeType():
                return self._free(type_)
            case core.TupleType(items=items):
                return product(*map(self.of, items))
            case core.RecordType(fields=fields):
                return product(*[self.of(t) for _, t in fields])
            case core.SetType(element=element):
                return map(frozenset, self._chosen(element))
            case core.SequenceType(element=element):
                items_ = self.of(element)
                return (s for size in range(scope + 1) for s in product(items_, repeat=size))
            case core.FunctionType() | core.BagType():
                return self._graphs(type_)
        raise ValueError(type_)

    def _chosen(self, element: core.Type) -> Iterable[tuple[Any, ...]]:
        items = self.of(element)
        return (chosen for size in range(self._scope + 1) for chosen in combinations(items, size))

    def _graphs(self, type_: core.FunctionType | core.BagType) -> Iterable[Any]:
        from cspcheck.cspm.oz.values.values import Graph

        if isinstance(type_, core.BagType):
            return (Graph(dict.fromkeys(chosen, 1)) for chosen in self._chosen(type_.element))
        values = self.of(type_.range)
        return (
            Graph(zip(keys, images, strict=True))
            for keys in self._chosen(type_.domain)
            for images in product(values, repeat=len(keys))
        )

    def _free(self, type_: core.FreeType) -> Iterable[Any]:
        from cspcheck.cspm.oz.values.values import Construction

        branches = self._specification.frees[type_.name].branches
        for rank, (name, carrier) in enumerate(branches):
            if carrier is None:
                yield Construction(rank, name, None)
        if self._depth >= self._scope:
            return
        self._depth += 1
        try:
            for rank, (name, carrier) in enumerate(branches):
                if carrier is not None and isinstance(carrier.type, core.SetType):
                    for argument in self.of(carrier.type.element)[: _MOST_VALUES // 4]:
                        yield Construction(rank, name, argument)
        finally:
            self._depth -= 1


def grounded(value: Any, type_: core.Type, frees: Mapping[str, core.FreeDefinition]) -> Term:
    """A value of the evaluator as a term.

    Args:
        value: the value.
        type_: its type.
        frees: what the free types are made of.

    Raises:
        ValueError: it is a set that is not written out.
    """

    def inner(item: Any, of: core.Type) -> Term:
        return grounded(item, of, frees)

    def display(operator: str, items: Iterable[Term], of: core.Type = type_) -> Term:
        return Apply(type=of, operator=operator, operands=tuple(items))

    match type_:
        case core.BoolType() | core.IntType() | core.RealType():
            return Constant(type=type_, value=value)
        case core.GivenType():
            return element_name(type_, value.number)
        case core.FreeType():
            carrier = frees[type_.name].branches[value.rank][1]
            argument = None
            if carrier is not None and isinstance(carrier.type, core.SetType):
                argument = grounded(value.argument, carrier.type.element, frees)
            return core.Construct(type=type_, constructor=value.constructor, argument=argument)
        case core.TupleType(items=items):
            return display("tuple", map(inner, value, items))
        case core.RecordType(fields=fields):
            return core.Record(type=type_, values=tuple(map(inner, value, [t for _, t in fields])))
        case core.SetType(element=element) if isinstance(value, frozenset):
            return display("set", [inner(item, element) for item in _in_order(value)])
        case core.SequenceType(element=element):
            return display("sequence", [inner(item, element) for item in value])
        case core.FunctionType(domain=domain, range=range_):
            pair = core.TupleType((domain, range_))
            pairs = [(inner(a, domain), inner(value[a], range_)) for a in _in_order(value)]
            return display("function", [display("tuple", items, pair) for items in pairs])
        case core.BagType(element=element):
            return display("bag_display", [inner(a, element) for a in _in_order(value) for _ in range(value[a])])
    raise ValueError(value)


def _in_order(values: Iterable[Any] | Mapping[Any, Any]) -> list[Any]:
    from cspcheck.cspm.oz.values.values import in_order

    return in_order(values)


def is_small(types: Iterable[core.Type]) -> bool:
    """Whether values of these types are found by a solver as easily as here: numbers and truth values alone."""
    return all(isinstance(type_, core.BoolType | core.IntType | core.RealType) for type_ in types)
