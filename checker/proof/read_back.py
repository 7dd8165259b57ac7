"""From a model of the solver to values of the specification, as ground core terms."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import z3

from cspcheck.checker.proof.sorts import Expr, element_of, selected
from cspcheck.checker.proof.terms import element_name, universe
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Binder, Comprehension, Constant, Construct, Record, Term, Type

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder

LONGEST = 64
"""Sequences longer than this are not read."""


class Unreadable(Exception):
    """A value that has no term: an irrational number, a function of the solver without a table."""


class ModelReader:
    """Reads the values of one model."""

    def __init__(self, encoder: Encoder, model: Expr) -> None:
        self._encoder = encoder
        self._sorts = encoder.sorts
        self._model = model
        self._elements: dict[tuple[str, str], int] = {}

    def value(self, formula: Expr, type_: Type) -> Term:
        """The value of a formula.

        Formulas are taken apart before they are evaluated: what the solver says of a whole lambda is not always what it
        says of its values.

        Raises:
            Unreadable: it has none that can be written.
        """
        formula = self._branch(formula)
        match type_:
            case core.TupleType(items=items):
                parts = tuple(self.value(self._sorts.part(type_, formula, i), p) for i, p in enumerate(items))
                return Apply(type=type_, operator="tuple", operands=parts)
            case core.RecordType(fields=fields):
                values = tuple(
                    self.value(self._sorts.part(type_, formula, i), part) for i, (_, part) in enumerate(fields)
                )
                return Record(type=type_, values=values)
            case core.SequenceType(element=element):
                length = self._integer(self._eval(self._sorts.length(type_, formula)))
                if not 0 <= length <= LONGEST:
                    raise Unreadable("a very long sequence")
                items_ = self._branch(self._sorts.items(type_, formula))
                found = [self.value(selected(items_, self._sorts.whole(i)), element) for i in range(1, length + 1)]
                return Apply(type=type_, operator="sequence", operands=tuple(found))
            case core.SetType(element=element):
                return self._set(formula, type_, element)
            case core.FunctionType():
                return self._function(formula, type_)
            case core.BagType(element=element):
                return self._bag(formula, type_, element)
        return self._read(self._eval(formula), type_)

    def _branch(self, formula: Expr) -> Expr:
        """The branch of a conditional that the model takes."""
        while z3.is_app_of(formula, z3.Z3_OP_ITE):
            formula = formula.arg(1 if self._truth(self._eval(formula.arg(0))) else 2)
        return formula

    def sizes(self) -> dict[str, int]:
        """The number of elements that each given set has in the model."""
        found: dict[str, int] = {}
        for name in self._encoder.specification.givens:
            sort = self._sorts.sort(core.GivenType(name))
            universe_ = None if self._sorts.size is not None else self._model.get_universe(sort)
            size = self._sorts.size if self._sorts.size is not None else len(universe_ or ())
            known = sum(1 for given, _ in self._elements if given == name)
            found[name] = max(size, known, 1)
        return found

    def _read(self, value: Expr, type_: Type) -> Term:
        match type_:
            case core.BoolType():
                return Constant(type=type_, value=self._truth(value))
            case core.IntType():
                return Constant(type=type_, value=self._integer(value))
            case core.RealType():
                if z3.is_int_value(value):
                    return Constant(type=type_, value=Fraction(value.as_long()))
                if z3.is_rational_value(value):
                    fraction = Fraction(value.numerator_as_long(), value.denominator_as_long())
                    return Constant(type=type_, value=fraction)
                raise Unreadable("an irrational number")
            case core.GivenType():
                return self._element(value, type_)
            case core.FreeType():
                return self._construct(value, type_)
        raise TypeError(f"not a type: {type_!r}")

    def _eval(self, formula: Expr) -> Expr:
        return self._model.eval(formula, model_completion=True)

    def _truth(self, value: Expr) -> bool:
        if z3.is_true(value):
            return True
        if z3.is_false(value):
            return False
        raise Unreadable("a truth value that the solver leaves open")

    def _integer(self, value: Expr) -> int:
        if not z3.is_int_value(value):
            raise Unreadable("a number that the solver leaves open")
        return int(value.as_long())

    def _element(self, value: Expr, type_: core.GivenType) -> Term:
        known = self._elements
        number = known.setdefault((type_.name, str(value)), 1 + sum(name == type_.name for name, _ in known))
        return element_name(type_, number)

    def _construct(self, value: Expr, type_: core.FreeType) -> Term:
        sort = self._sorts.sort(type_)
        for index, (constructor, carrier) in enumerate(self._sorts.free(type_).branches):
            if value.decl().eq(sort.constructor(index)):
                argument = None if carrier is None else self.value(value.arg(0), element_of(carrier))
                return Construct(type=type_, constructor=constructor, argument=argument)
        raise Unreadable("a value of a free type that the solver leaves open")

    # --- arrays ------------------------------------------------------------------------------------------------------

    def _table(self, array: Expr) -> tuple[list[tuple[Expr, Expr]], Expr]:
        """The entries of an array, each argument once, and what it has elsewhere."""
        entries: list[tuple[Expr, Expr]] = []
        rest: Expr = None
        while rest is None:
            array = self._branch(array)
            if z3.is_store(array):
                entries.append((self._eval(array.arg(1)), array.arg(2)))
                array = array.arg(0)
            elif z3.is_const_array(array):
                rest = array.arg(0)
            elif z3.is_as_array(array):
                interpretation = self._model[z3.get_as_array_func(array)]
                if interpretation is None:
                    raise Unreadable("a function without a table")
                for i in range(interpretation.num_entries()):
                    entry = interpretation.entry(i)
                    entries.append((self._eval(entry.arg_value(0)), self._eval(entry.value())))
                rest = self._eval(interpretation.else_value())
            elif z3.is_quantifier(array):
                more, rest = self._tabulated(array)
                entries += more
            else:
                evaluated = self._eval(array)
                if evaluated.eq(array):
                    raise Unreadable("a function without a table")
                array = evaluated
        found: dict[int, tuple[Expr, Expr]] = {}
        for argument, result in entries:
            found.setdefault(argument.get_id(), (argument, result))
        return list(found.values()), rest

    def _tabulated(self, array: Expr) -> tuple[list[tuple[Expr, Expr]], Expr]:
        """A lambda as a table over the values that it speaks of; elsewhere as at one further point."""
        domain = array.sort().domain()
        constants: dict[int, Expr] = {}
        todo = [array.body()]
        while todo:
            node = todo.pop()
            if z3.is_quantifier(node):
                todo.append(node.body())
                continue
            if node.sort() == domain and not z3.is_var(node) and not _has_var(node):
                constants.setdefault(node.get_id(), node)
            todo.extend(node.children())
        points = {(v := self._eval(c)).get_id(): v for c in constants.values()}
        universe_ = self._model.get_universe(domain) if domain.kind() == z3.Z3_UNINTERPRETED_SORT else None
        if universe_ is not None:
            points = {v.get_id(): v for v in universe_}
        elif domain.kind() == z3.Z3_INT_SORT:
            numbers = sorted(int(p.as_long()) for p in points.values() if z3.is_int_value(p))
            if numbers and numbers[-1] - numbers[0] <= LONGEST:
                for number in range(numbers[0] - 1, numbers[-1] + 2):
                    point = self._sorts.whole(number)
                    points.setdefault(point.get_id(), point)
        entries = [(p, selected(array, p)) for p in points.values()]
        return entries, self._elsewhere(array, list(points.values()))

    def _elsewhere(self, array: Expr, points: list[Expr]) -> Expr:
        """What a lambda gives at some point that is none of *points*; if there is none, at one of them."""
        solver = z3.Solver(ctx=self._sorts.context)
        solver.set("rlimit", 500_000)
        other = z3.Const("elsewhere%", array.sort().domain())
        solver.add(*[other != point for point in points])
        if solver.check() != z3.sat:
            return selected(array, points[0]) if points else None
        return self._eval(selected(array, solver.model().eval(other, model_completion=True)))

    def _listed(self, formula: Expr, element: Type) -> list[Expr] | None:
        """All arguments of an array that matter, each once: those of a small type, or those that were written out."""
        values = self._encoder.enumeration(element)
        if values is None:
            values = self._encoder.list_of(formula)
        if values is None:
            return None
        return list({(v := self._eval(value)).get_id(): v for value in values}.values())

    def _set(self, formula: Expr, type_: core.SetType, element: Type) -> Term:
        values = self._listed(formula, element)
        if values is not None:
            inside = [v for v in values if self._truth(self._eval(selected(formula, v)))]
            return _set_of(type_, [self.value(v, element) for v in inside])
        entries, rest = self._table(formula)
        members = [self.value(a, element) for a, result in entries if self._truth(self._eval(result))]
        if not self._truth(self._eval(rest)):
            return _set_of(type_, members)
        absent = [self.value(a, element) for a, result in entries if not self._truth(self._eval(result))]
        everything = universe(element)
        if not absent:
            return everything
        return Apply(type=type_, operator="diff", operands=(everything, _set_of(type_, absent)))

    def _function(self, formula: Expr, type_: core.FunctionType) -> Term:
        sorts = self._sorts
        values = self._listed(formula, type_.domain)
        if values is not None:
            entries, rest = [(v, selected(formula, v)) for v in values], sorts.none(type_)
        else:
            entries, rest = self._table(formula)
        pairs = []
        gaps = []
        for argument, option in entries:
            result = self._result(type_, option)
            if result is not None:
                pairs.append((self.value(argument, type_.domain), result))
            else:
                gaps.append(self.value(argument, type_.domain))
        table = _function_of(type_, pairs)
        default = self._result(type_, rest)
        return table if default is None else self._everywhere(type_, default, table, gaps)

    def _result(self, type_: core.FunctionType, option: Expr) -> Term | None:
        """The value of an option, None for ``none``."""
        option = self._branch(option)
        if not self._truth(self._eval(self._sorts.is_some(type_, option))):
            return None
        written_out = option.num_args() == 1 and option.decl().name() == "some"
        inner = option.arg(0) if written_out else self._sorts.value(type_, option)
        return self.value(inner, type_.range)

    def _everywhere(self, type_: core.FunctionType, result: Term, table: Term, gaps: list[Term]) -> Term:
        """A function with the same value almost everywhere."""
        domain = universe(type_.domain)
        if gaps:
            set_type = core.SetType(type_.domain)
            domain = Apply(type=set_type, operator="diff", operands=(domain, _set_of(set_type, gaps)))
        binder = Binder("x%model", type_.domain, domain, "x")
        condition = Constant(type=core.BOOL, value=True)
        base = Comprehension(type=type_, kind="lambda", binders=(binder,), condition=condition, body=result)
        if isinstance(table, Apply) and not table.operands:
            return base
        return Apply(type=type_, operator="override", operands=(base, table))

    def _bag(self, formula: Expr, type_: core.BagType, element: Type) -> Term:
        values = self._listed(formula, element)
        if values is not None:
            entries = [(v, selected(formula, v)) for v in values]
        else:
            entries, rest = self._table(formula)
            if self._integer(self._eval(rest)) != 0:
                raise Unreadable("an infinite bag")
        found: list[Term] = []
        for argument, number in entries:
            times = self._integer(self._eval(number))
            if times > LONGEST:
                raise Unreadable("a very large bag")
            found += [self.value(argument, element)] * times
        return Apply(type=type_, operator="bag_display", operands=tuple(sorted(found, key=_order)))


def _has_var(node: Expr) -> bool:
    return z3.is_var(node) or any(map(_has_var, node.children()))


def _set_of(type_: core.SetType, members: list[Term]) -> Term:
    return Apply(type=type_, operator="set", operands=tuple(sorted(members, key=_order)))


def _function_of(type_: core.FunctionType, pairs: list[tuple[Term, Term]]) -> Term:
    pair_type = core.TupleType((type_.domain, type_.range))
    maplets = [
        Apply(type=pair_type, operator="tuple", operands=pair) for pair in sorted(pairs, key=lambda p: _order(p[0]))
    ]
    return Apply(type=type_, operator="function", operands=tuple(maplets))


def _order(value: Term) -> tuple[int, object, str]:
    """Numbers by size, all else by text."""
    if isinstance(value, Constant):
        return 0, Fraction(value.value), ""
    return 1, 0, repr(value)
