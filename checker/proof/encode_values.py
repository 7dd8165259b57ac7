"""Variables of a query: what the solver must know of the values of each type, and which values there are.

In a small scope collections are written out element by element; without one they are arrays, of which it must be said
that what lies outside a sequence or a domain plays no part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import product

import z3

from cspcheck.checker.proof.encoding_rules import LARGEST_EXPANSION
from cspcheck.checker.proof.one_point import is_universe, simplified
from cspcheck.checker.proof.sorts import Expr, QuerySorts, Sort, Unsupported, all_true, any_true, element_of, selected
from cspcheck.checker.proof.terms import Key, key
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Constant, Term, Variable

_LARGEST_ENUMERATION = 32


class Values:
    """The variables of one query, with all that the solver must know of values of their types.

    The terms that their carriers are made of are put by :class:`cspcheck.checker.proof.encode.Encoder`, which is one
    of these.

    Args:
        specification: that the terms belong to.
        scope: the size of given sets and the greatest size of collections; None: unbounded.
    """

    def __init__(self, specification: core.Specification, scope: int | None = None) -> None:
        self.specification = specification
        self.scope = scope
        self.sorts = QuerySorts(specification, scope)
        self.values: dict[Key, Expr] = {}
        """Formulas for variables, free and bound."""
        self.facts: list[Expr] = []
        """What is true of the free variables by their types, and of functions without exact formula."""
        self.approximated: set[str] = set()
        """Operators that have no exact formula in this query."""
        self._candidates: dict[int, list[Expr]] = {}
        self._bounds: dict[int, int] = {}
        self._kept: list[Expr] = []
        self._open: list[Expr] = []
        self._names = 0
        self._functions: dict[tuple[str, core.Type], Expr] = {}
        self._needs_shape: dict[core.Type, bool] = {}
        self.measured: list[tuple[core.Type, Expr, Expr]] = []
        """Sets with an approximated cardinality, and that."""

    # --- small tools -------------------------------------------------------------------------------------------------

    def all(self, parts: Iterable[Expr]) -> Expr:
        """The conjunction of formulas."""
        return all_true(self.sorts.context, list(parts))

    def any(self, parts: Iterable[Expr]) -> Expr:
        """The disjunction of formulas."""
        return any_true(self.sorts.context, list(parts))

    def name(self, stem: str) -> str:
        """A name that neither the query nor the specification has: bound variables there are called ``x%7``."""
        self._names += 1
        return f"{stem}%{self._names}e"

    def constant(self, stem: str, sort: Sort) -> Expr:
        """A new constant."""
        return z3.Const(self.name(stem), sort)

    def function(self, name: str, type_: core.Type, *sorts: Sort) -> Expr:
        """The uninterpreted function that stands for an operator on values of a type."""
        found = self._functions.get((name, type_))
        if found is None:
            found = self._functions[name, type_] = z3.Function(self.name(name), *sorts)
        return found

    def fact(self, formula: Expr) -> None:
        """Keep a fact, unless it speaks of a bound variable."""
        if not self._open or not _occurs(formula, self._open):
            self.facts.append(formula)

    @contextmanager
    def bound(self, table: dict[Key, Expr], *, opened: bool = True) -> Iterator[None]:
        """Formulas for bound variables; *opened* where they are variables of the solver."""
        saved = {k: self.values.get(k) for k in table}
        self.values.update(table)
        if opened:
            self._open.extend(table.values())
        try:
            yield
        finally:
            if opened:
                del self._open[len(self._open) - len(table) :]
            for k, old in saved.items():
                if old is None:
                    del self.values[k]
                else:
                    self.values[k] = old

    def lambda_(self, stem: str, type_: core.Type, body: Callable[[Expr], Expr]) -> Expr:
        """The array from values of a type to *body* of them.

        Its variable is called after how deep it stands, so that two terms that are the same are one formula.
        """
        variable = z3.Const(f"{stem}%{len(self._open)}l", self.sorts.sort(type_))
        self._open.append(variable)
        try:
            return z3.Lambda([variable], body(variable))
        finally:
            self._open.pop()

    def exists(self, type_: core.Type, body: Callable[[Expr], Expr], candidates: list[Expr] | None = None) -> Expr:
        """That *body* holds of a value of a type; *candidates* are all values that it can hold of."""
        candidates = candidates if candidates is not None else self.enumeration(type_)
        if candidates is not None and len(candidates) <= LARGEST_EXPANSION:
            return self.any(body(c) for c in candidates)
        return self._solver_quantifier(z3.Exists, type_, body)

    def forall(self, type_: core.Type, body: Callable[[Expr], Expr], candidates: list[Expr] | None = None) -> Expr:
        """That *body* holds of all values of a type; *candidates* are all values that it can fail for."""
        candidates = candidates if candidates is not None else self.enumeration(type_)
        if candidates is not None and len(candidates) <= LARGEST_EXPANSION:
            return self.all(body(c) for c in candidates)
        return self._solver_quantifier(z3.ForAll, type_, body)

    def _solver_quantifier(
        self, quantifier: Callable[[list[Expr], Expr], Expr], type_: core.Type, body: Callable[[Expr], Expr]
    ) -> Expr:
        variable = z3.Const(f"q%{len(self._open)}q", self.sorts.sort(type_))
        self._open.append(variable)
        try:
            formula = body(variable)
            if self.needs_shape(type_):
                shape = self.shaped(variable, type_)
                formula = z3.And(shape, formula) if quantifier is z3.Exists else z3.Implies(shape, formula)
        finally:
            self._open.pop()
        if z3.is_true(formula) or z3.is_false(formula):
            return formula
        return quantifier([variable], formula)

    # --- variables ---------------------------------------------------------------------------------------------------

    def variable(self, variable: Variable) -> Expr:
        """The formula of a variable; a new constant for a free one that is met first."""
        found = self.values.get(key(variable))
        if found is None:
            found = self.unknown(variable.type, f"{variable.name}:{variable.role}")
            self.values[key(variable)] = found
        return found

    def unknown(self, type_: core.Type, name: str) -> Expr:
        """A new value of a type that the solver may choose; in a scope, collections are written out."""
        if self.scope is not None:
            written = self._written_out(type_, name, self.scope)
            if written is not None:
                return written
        constant = z3.Const(self.name(name), self.sorts.sort(type_))
        if self.needs_shape(type_):
            self.facts.append(self.shaped(constant, type_))
        return constant

    def _written_out(self, type_: core.Type, name: str, scope: int) -> Expr | None:
        sorts = self.sorts
        match type_:
            case core.SequenceType(element=element):
                length = self.unknown(core.INT, f"#{name}")
                self.facts += [length >= 0, length <= scope]
                array = z3.K(z3.IntSort(sorts.context), sorts.junk(element))
                for i in range(1, scope + 1):
                    item = self.unknown(element, f"{name}.{i}")
                    array = z3.Store(array, sorts.whole(i), z3.If(length >= i, item, sorts.junk(element)))
                return self.bounded(sorts.sequence(type_, length, array), scope)
            case core.SetType(element=element):
                if self.enumeration(element) is not None:
                    return None
                array = z3.K(sorts.sort(element), sorts.truth(False))
                items = [self.unknown(element, f"{name}.{i}") for i in range(1, scope + 1)]
                for i, item in enumerate(items):
                    there = self.unknown(BOOL, f"{name}?{i}")
                    array = z3.If(there, z3.Store(array, item, sorts.truth(True)), array)
                return self.listed(array, items)
            case core.FunctionType(domain=domain, range=range_):
                if self.enumeration(domain) is not None:
                    return None
                array = z3.K(sorts.sort(domain), sorts.none(type_))
                keys = [self.unknown(domain, f"{name}.{i}") for i in range(1, scope + 1)]
                for i, argument in enumerate(keys):
                    there = self.unknown(BOOL, f"{name}?{i}")
                    result = self.unknown(range_, f"{name}={i}")
                    array = z3.If(there, z3.Store(array, argument, sorts.some(type_, result)), array)
                return self.listed(array, keys)
            case core.BagType(element=element):
                array = z3.K(sorts.sort(element), sorts.whole(0))
                items = [self.unknown(element, f"{name}.{i}") for i in range(1, scope + 1)]
                for i, item in enumerate(items):
                    number = self.unknown(core.INT, f"{name}#{i}")
                    self.facts += [number >= 0, number <= scope]
                    array = z3.Store(array, item, number)
                return self.listed(array, items)
            case core.FreeType() if sorts.recursive(type_):
                return self._grown(type_, name, scope)
            case core.TupleType(items=parts):
                return sorts.make(type_, [self.unknown(part, f"{name}.{i}") for i, part in enumerate(parts)])
            case core.RecordType(fields=fields):
                return sorts.make(type_, [self.unknown(part, f"{name}.{field}") for field, part in fields])
        return None

    def _grown(self, type_: core.FreeType, name: str, depth: int) -> Expr:
        """A value of a recursive free type in which constructors are at most so deep in one another."""
        sort = self.sorts.sort(type_)
        choices: list[Expr] = []
        for index, (_, carrier) in enumerate(self.sorts.free(type_).branches):
            if carrier is None:
                choices.append(sort.constructor(index)())
            elif depth > 0:
                argument = self._argument(element_of(carrier), type_, f"{name}.{index}", depth - 1)
                if argument is not None:
                    self.facts.append(self.member(argument, carrier))
                    choices.append(sort.constructor(index)(argument))
            elif not self.sorts.contains(element_of(carrier), type_):
                argument = self.unknown(element_of(carrier), f"{name}.{index}")
                self.facts.append(self.member(argument, carrier))
                choices.append(sort.constructor(index)(argument))
        if not choices:
            raise Unsupported(f"the free type `{type_}`, which has no values without others of it")
        result = choices[-1]
        for choice in reversed(choices[:-1]):
            result = z3.If(self.unknown(BOOL, f"{name}?"), choice, result)
        return result

    def _argument(self, type_: core.Type, whole: core.FreeType, name: str, depth: int) -> Expr | None:
        """An argument of a constructor of *whole*; None for one that this does not build."""
        if type_ == whole:
            return self._grown(whole, name, depth)
        if isinstance(type_, core.TupleType):
            parts = [self._argument(part, whole, f"{name}.{i}", depth) for i, part in enumerate(type_.items)]
            if any(part is None for part in parts):
                return None
            return self.sorts.make(type_, [part for part in parts if part is not None])
        return None if self.sorts.contains(type_, whole) else self.unknown(type_, name)

    def listed(self, formula: Expr, values: list[Expr]) -> Expr:
        """Remember values among which the elements of a set, or the arguments of a function, are."""
        self._kept.append(formula)
        self._candidates[formula.get_id()] = values
        return formula

    def bounded(self, formula: Expr, length: int) -> Expr:
        """Remember the greatest length of a sequence."""
        self._kept.append(formula)
        self._bounds[formula.get_id()] = length
        return formula

    def list_of(self, formula: Expr) -> list[Expr] | None:
        """What :meth:`listed` remembers."""
        return self._candidates.get(formula.get_id())

    def bound_of(self, formula: Expr) -> int | None:
        """What :meth:`bounded` remembers."""
        return self._bounds.get(formula.get_id())

    # --- shapes ------------------------------------------------------------------------------------------------------

    def needs_shape(self, type_: core.Type) -> bool:
        """Whether a sort has elements that no value of the type has."""
        found = self._needs_shape.get(type_)
        if found is None:
            self._needs_shape[type_] = False  # while it is worked out, for recursive types
            found = self._needs_shape[type_] = self._has_shape(type_)
        return found

    def _has_shape(self, type_: core.Type) -> bool:
        match type_:
            case core.SequenceType() | core.BagType():
                return True
            case core.SetType(element=element):
                return self.needs_shape(element)
            case core.FunctionType(domain=domain, range=range_):
                return self.needs_shape(domain) or self.needs_shape(range_)
            case core.TupleType(items=items):
                return any(map(self.needs_shape, items))
            case core.RecordType(fields=fields):
                return any(self.needs_shape(part) for _, part in fields)
            case core.FreeType():
                arguments = [argument for _, argument in self.sorts.free(type_).branches if argument is not None]
                return any(not is_universe(a) or self.needs_shape(element_of(a)) for a in arguments)
        return False

    def shaped(self, formula: Expr, type_: core.Type) -> Expr:
        """That an element of a sort is a value of the type."""
        if not self.needs_shape(type_):
            return self.sorts.truth(True)
        sorts = self.sorts
        match type_:
            case core.SequenceType(element=element):
                length, items = sorts.length(type_, formula), sorts.items(type_, formula)
                index = self.constant("i", z3.IntSort(sorts.context))
                outside = z3.Or(index < 1, index > length)
                item = selected(items, index)
                inside = self.shaped(item, element)
                rule = z3.And(z3.Implies(outside, item == sorts.junk(element)), z3.Or(outside, inside))
                return z3.And(length >= 0, z3.ForAll([index], rule))
            case core.BagType(element=element):
                return self.forall(element, lambda e: selected(formula, e) >= 0)
            case core.SetType(element=element):
                return self._each(element, lambda e: z3.Implies(selected(formula, e), self.shaped(e, element)))
            case core.FunctionType(domain=domain, range=range_):
                function = type_

                def entry(argument: Expr) -> Expr:
                    option = selected(formula, argument)
                    shapes = [self.shaped(argument, domain), self.shaped(sorts.value(function, option), range_)]
                    return z3.Implies(sorts.is_some(function, option), self.all(shapes))

                return self._each(domain, entry)
            case core.TupleType(items=parts):
                return self.all(self.shaped(sorts.part(type_, formula, i), p) for i, p in enumerate(parts))
            case core.RecordType(fields=fields):
                return self.all(self.shaped(sorts.part(type_, formula, i), p) for i, (_, p) in enumerate(fields))
            case core.FreeType():
                return self._shaped_free(formula, type_)
        return sorts.truth(True)

    def _each(self, type_: core.Type, body: Callable[[Expr], Expr]) -> Expr:
        """A quantifier over the whole sort of a type, values or not."""
        variable = self.constant("e", self.sorts.sort(type_))
        return z3.ForAll([variable], body(variable))

    def _shaped_free(self, formula: Expr, type_: core.FreeType) -> Expr:
        if not self.sorts.recursive(type_):
            return self._shaped_branches(formula, type_)
        known = ("shaped", type_) in self._functions
        sort = self.sorts.sort(type_)
        if not known:
            rule = z3.RecFunction(self.name("shaped"), sort, z3.BoolSort(self.sorts.context))
            self._functions["shaped", type_] = rule
            argument = self.constant("t", sort)
            z3.RecAddDefinition(rule, [argument], self._shaped_branches(argument, type_))
        return self._functions["shaped", type_](formula)

    def _shaped_branches(self, formula: Expr, type_: core.FreeType) -> Expr:
        sort = self.sorts.sort(type_)
        parts = []
        for index, (_, carrier) in enumerate(self.sorts.free(type_).branches):
            if carrier is not None:
                argument = sort.accessor(index, 0)(formula)
                right = self.all([self.shaped(argument, element_of(carrier)), self.member(argument, carrier)])
                if not z3.is_true(right):
                    parts.append(z3.Implies(sort.recognizer(index)(formula), right))
        return self.all(parts)

    def enumeration(self, type_: core.Type) -> list[Expr] | None:
        """All values of a small finite type."""
        sorts = self.sorts
        match type_:
            case core.BoolType():
                return [sorts.truth(False), sorts.truth(True)]
            case core.GivenType():
                if sorts.size is None:
                    return None
                sort = sorts.sort(type_)
                return [sort.constructor(i)() for i in range(sorts.size)]
            case core.FreeType():
                if sorts.recursive(type_):
                    return None
                sort = sorts.sort(type_)
                found: list[Expr] = []
                for index, (_, carrier) in enumerate(sorts.free(type_).branches):
                    if carrier is None:
                        found.append(sort.constructor(index)())
                        continue
                    arguments = self.candidates(carrier)
                    if arguments is None or not is_plain(carrier) or len(found) + len(arguments) > _LARGEST_ENUMERATION:
                        return None
                    found += [sort.constructor(index)(argument) for argument in arguments]
                return found
            case core.TupleType(items=items):
                lists = [self.enumeration(item) for item in items]
                return self._products(type_, lists)
        return None

    def _products(self, type_: core.Type, lists: list[list[Expr] | None]) -> list[Expr] | None:
        size = 1
        for values in lists:
            if values is None:
                return None
            size *= len(values)
        if size > LARGEST_EXPANSION:
            return None
        return [self.sorts.make(type_, list(parts)) for parts in product(*[v for v in lists if v is not None])]

    # --- what terms are ----------------------------------------------------------------------------------------------

    def member(self, value: Expr, carrier: Term) -> Expr:
        """That a value lies in a carrier."""
        raise NotImplementedError

    def candidates(self, carrier: Term) -> list[Expr] | None:
        """The values of a set, more perhaps than are in it; None where nobody can say."""
        raise NotImplementedError


def is_plain(carrier: Term) -> bool:
    """Whether a carrier is a set whose candidates are its elements: a display of literals, an interval, a type."""
    carrier = simplified(carrier)
    if not isinstance(carrier, Apply):
        return False
    if carrier.operator in ("set", "range"):
        return all(isinstance(operand, Constant | core.Construct) for operand in carrier.operands)
    return carrier.operator in ("All", "Bool")


def _occurs(formula: Expr, constants: list[Expr]) -> bool:
    """Whether one of some constants occurs in a formula."""
    wanted = {constant.get_id() for constant in constants}
    seen: set[int] = set()
    todo = [formula]
    while todo:
        node = todo.pop()
        if node.get_id() in seen:
            continue
        seen.add(node.get_id())
        if node.get_id() in wanted:
            return True
        if z3.is_quantifier(node):
            todo.append(node.body())
        else:
            todo.extend(node.children())
    return False
