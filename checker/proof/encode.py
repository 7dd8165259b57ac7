"""Core terms as formulas of the solver.

A query is put once as it is, with unbounded collections, and once for each of some small *scopes*, where each given
set has k elements and every collection at most k; there collections are written out, so that cardinalities are sums
and bounded quantifiers are expanded.

What has no exact formula (the cardinality of any set, a filtered sequence) becomes an uninterpreted function of the
solver with facts that are true of it. A proof is therefore a proof; a model may be spurious, and is believed only
after it has been replayed by :mod:`checker.proof.replay`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import product

import z3

from checker.proof import encode_functions, encode_numbers, encode_sequences, encode_sets, encoding_rules
from checker.proof.encoding_rules import LARGEST_EXPANSION
from checker.proof.one_point import eliminated, is_universe, simplified
from checker.proof.sorts import Expr, Sort, Sorts, Unsupported, all_true, any_true, element_of, selected
from checker.proof.terms import Key, Unknown, equal, key, quantified, substitute, variables
from cspm.oz import core
from cspm.oz.core import BOOL, Apply, Binder, Comprehension, Constant, Quantifier, Term, Variable

RULES = (encode_numbers, encode_sets, encode_functions, encode_sequences)
"""The modules that say what operators mean; importing them fills the register."""
_LARGEST_ENUMERATION = 32


class Encoder:
    """Puts the terms of one query.

    Args:
        specification: that the terms belong to.
        scope: the size of given sets and the greatest size of collections; None: unbounded.
    """

    def __init__(self, specification: core.Specification, scope: int | None = None) -> None:
        self.specification = specification
        self.scope = scope
        self.sorts = Sorts(specification, scope)
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
        """The array from values of a type to *body* of them."""
        variable = self.constant(stem, self.sorts.sort(type_))
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
        variable = self.constant("q", self.sorts.sort(type_))
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

    # --- terms -------------------------------------------------------------------------------------------------------

    def term(self, term: Term) -> Expr:
        """The formula of a term.

        Raises:
            Unsupported: there is none.
        """
        sorts = self.sorts
        match term:
            case Constant(type=core.BoolType(), value=value):
                return sorts.truth(bool(value))
            case Constant(type=core.RealType(), value=value):
                return z3.RealVal(str(value), sorts.context)
            case Constant(value=value):
                return sorts.whole(int(value))
            case Variable():
                return self.variable(term)
            case core.Construct(type=core.FreeType() as free):
                constructor = sorts.sort(free).constructor(sorts.constructor_index(free, term.constructor))
                return constructor() if term.argument is None else constructor(self.term(term.argument))
            case core.Record(values=values):
                return sorts.make(term.type, [self.term(value) for value in values])
            case core.Field(record=record, name=name):
                assert isinstance(record.type, core.RecordType)
                names = [field for field, _ in record.type.fields]
                return sorts.part(record.type, self.term(record), names.index(name))
            case core.If():
                return z3.If(self.term(term.test), self.term(term.then), self.term(term.otherwise))
            case Quantifier():
                return self._quantifier(term)
            case Comprehension():
                return self._comprehension(term)
            case Apply():
                return self._apply(term)
        raise TypeError(f"not a term: {term!r}")

    def _apply(self, term: Apply) -> Expr:
        rule = encoding_rules.VALUES.get(term.operator)
        if rule is not None:
            return rule(self, term)
        if term.operator in encoding_rules.MEMBERSHIPS:
            set_type = term.type
            assert isinstance(set_type, core.SetType)
            formula = self.lambda_("x", set_type.element, lambda x: self.member(x, term))
            values = self.candidates(term)
            return formula if values is None else self.listed(formula, values)
        raise Unsupported(f"`{term.operator}`")

    def member(self, value: Expr, carrier: Term) -> Expr:
        """That a value is in a set."""
        if isinstance(carrier, Apply):
            rule = encoding_rules.MEMBERSHIPS.get(carrier.operator)
            if rule is not None:
                return rule(self, value, carrier)
        if isinstance(carrier, Comprehension):
            return self._in_comprehension(value, carrier)
        if isinstance(carrier, core.If):
            test = self.term(carrier.test)
            return z3.If(test, self.member(value, carrier.then), self.member(value, carrier.otherwise))
        return selected(self.term(carrier), value)

    def candidates(self, carrier: Term) -> list[Expr] | None:
        """Values among which all elements of a set are, None where no such list is known."""
        if isinstance(carrier, Apply):
            rule = encoding_rules.CANDIDATES.get(carrier.operator)
            if rule is not None:
                found = rule(self, carrier)
                if found is not None:
                    return found
        elif isinstance(carrier, Comprehension):
            found = self._comprehension_candidates(carrier)
            if found is not None:
                return found
        elif isinstance(carrier, core.If):
            both = [self.candidates(carrier.then), self.candidates(carrier.otherwise)]
            if both[0] is not None and both[1] is not None:
                return [*both[0], *both[1]]
        elif self.scope is not None:
            found = self.list_of(self.term(carrier))
            if found is not None:
                return found
        return self.enumeration(element_of(carrier))

    # --- binders -----------------------------------------------------------------------------------------------------

    def _quantifier(self, term: Quantifier) -> Expr:
        if term.kind == "exists1":
            return self._exactly_one(term)
        if term.kind == "forall":
            negated = Apply(type=BOOL, operator="not", operands=(term.body,))
            left, parts = eliminated(_unknowns(term.binders), [term.condition, negated])
            return z3.Not(self._some(left, parts))
        left, parts = eliminated(_unknowns(term.binders), [term.condition, term.body])
        return self._some(left, parts)

    def _some(self, unknowns: tuple[Unknown, ...], parts: tuple[Term, ...]) -> Expr:
        """``exists unknowns @ parts``."""
        if not unknowns:
            return self.all(self.term(part) for part in parts)
        return self._some_values(list(unknowns), parts, 1)

    def _some_values(self, unknowns: list[Unknown], parts: tuple[Term, ...], size: int) -> Expr:
        """Expand over the unknowns whose values can be listed; leave the others to the solver."""
        used = {k for part in parts for k in variables(part)} | {k for u in unknowns for k in variables(u.carrier)}
        for position, unknown in enumerate(unknowns):
            if any(other.key in variables(unknown.carrier) for other in unknowns[:position]):
                continue
            values = self.candidates(unknown.carrier)
            if values is None or size * len(values) > LARGEST_EXPANSION:
                continue
            rest = unknowns[:position] + unknowns[position + 1 :]
            if unknown.key not in used:
                values_in = [self.member(value, unknown.carrier) for value in values]
                return self.all([self.any(values_in), self._some(tuple(rest), parts)])
            cases = []
            for value in values:
                with self.bound({unknown.key: value}, opened=False):
                    inside = self.member(value, unknown.carrier)
                    if not z3.is_false(inside):
                        cases.append(self.all([inside, self._some_values(rest, parts, size * len(values))]))
            return self.any(cases)
        if not unknowns:
            return self.all(self.term(part) for part in parts)
        taken = self._arguments(unknowns, parts)
        if taken is not None:
            recognised, values_of = taken
            rest = [unknown for unknown in unknowns if unknown.key not in values_of]
            with self.bound(values_of, opened=False):
                carriers = [self.member(values_of[u.key], u.carrier) for u in unknowns if u.key in values_of]
                return self.all([recognised, *carriers, self._some_values(rest, parts, size)])
        return self._solver_some(unknowns, parts)

    def _arguments(self, unknowns: list[Unknown], parts: tuple[Term, ...]) -> tuple[Expr, dict[Key, Expr]] | None:
        """Unknowns that an equation ``t = node(x, y)`` gives as the arguments of a known value."""
        keys = {unknown.key for unknown in unknowns}
        for part in parts:
            if not isinstance(part, Apply) or part.operator != "equal":
                continue
            for value, construct in (part.operands, part.operands[::-1]):
                if not isinstance(construct, core.Construct) or construct.argument is None:
                    continue
                free, argument = construct.type, construct.argument
                if not isinstance(free, core.FreeType) or not keys.isdisjoint(variables(value)):
                    continue
                whole = self.term(value)
                index = self.sorts.constructor_index(free, construct.constructor)
                inner = self.sorts.sort(free).accessor(index, 0)(whole)
                items = [(argument, inner)]
                if isinstance(argument, Apply) and argument.operator == "tuple":
                    items = [(o, self.sorts.part(argument.type, inner, i)) for i, o in enumerate(argument.operands)]
                found = {key(o): x for o, x in items if isinstance(o, Variable) and key(o) in keys}
                if found:
                    return self.sorts.sort(free).recognizer(index)(whole), found
        return None

    def _solver_some(self, unknowns: list[Unknown], parts: tuple[Term, ...]) -> Expr:
        table = {u.key: self.constant(u.variable.name, self.sorts.sort(u.variable.type)) for u in unknowns}
        with self.bound(table):
            formulas = []
            for unknown in unknowns:
                formulas.append(self.shaped(table[unknown.key], unknown.variable.type))
                formulas.append(self.member(table[unknown.key], unknown.carrier))
            formulas += [self.term(part) for part in parts]
            body = self.all(formulas)
        if z3.is_true(body) or z3.is_false(body):
            return body
        return z3.Exists(list(table.values()), body)

    def _exactly_one(self, term: Quantifier) -> Expr:
        """``exists1``: some values fit, and any that fit are these."""
        binders, condition, body = term.binders, term.condition, term.body
        holds = core.conjunction((condition, body))
        table: dict[Key, Term] = {}
        others: list[Binder] = []
        same: list[Term] = []
        for binder in binders:
            name = self.name(binder.name)
            old = Variable(type=binder.type, name=binder.name, role="bound")
            new = Variable(type=binder.type, name=name, role="bound")
            others.append(Binder(name, binder.type, substitute(binder.carrier, table), binder.written))
            table[binder.name, "bound"] = new
            same.append(equal(new, old))
        unique = quantified("forall", tuple(others), substitute(holds, table), core.conjunction(tuple(same)))
        return self.term(quantified("exists", binders, holds, unique))

    def _comprehension(self, term: Comprehension) -> Expr:
        match term.kind, term.type:
            case "set", core.SetType(element=element):
                formula = self.lambda_("x", element, lambda x: self.member(x, term))
                values = self.candidates(term)
                return formula if values is None else self.listed(formula, values)
            case "lambda", core.FunctionType() as function:
                return self._lambda_term(term, function)
            case _:
                raise Unsupported("`mu` in this place")

    def _in_comprehension(self, value: Expr, term: Comprehension) -> Expr:
        """That some values of the binders give this element."""
        element = Variable(type=term.body.type, name=self.name("x"), role="bound")
        with self.bound({key(element): value}, opened=False):
            parts = [term.condition, equal(term.body, element)]
            return self._some(*eliminated(_unknowns(term.binders), parts))

    def _comprehension_candidates(self, term: Comprehension) -> list[Expr] | None:
        if term.kind != "set":
            return None
        lists: list[list[Expr]] = []
        size = 1
        for binder in term.binders:
            values = self.candidates(binder.carrier)
            if values is None or variables(binder.carrier).keys() & {(b.name, "bound") for b in term.binders}:
                return None
            size *= len(values)
            lists.append(values)
        if size > LARGEST_EXPANSION:
            return None
        found = []
        for values_ in product(*lists):
            table = {(b.name, "bound"): v for b, v in zip(term.binders, values_, strict=True)}
            with self.bound(table, opened=False):
                found.append(self.term(term.body))
        return found

    def _lambda_term(self, term: Comprehension, function: core.FunctionType) -> Expr:
        sorts = self.sorts

        def entry(argument: Expr) -> Expr:
            if len(term.binders) == 1:
                table = {(term.binders[0].name, "bound"): argument}
            else:
                table = {
                    (binder.name, "bound"): sorts.part(function.domain, argument, i)
                    for i, binder in enumerate(term.binders)
                }
            with self.bound(table, opened=False):
                inside = [self.member(table[b.name, "bound"], b.carrier) for b in term.binders]
                condition = self.all([*inside, self.term(term.condition)])
                result = sorts.some(function, self.term(term.body))
            return z3.If(condition, result, sorts.none(function))

        formula = self.lambda_("x", function.domain, entry)
        if len(term.binders) == 1:
            values = self.candidates(term.binders[0].carrier)
            if values is not None:
                return self.listed(formula, values)
        return formula


def _unknowns(binders: Iterable[Binder]) -> list[Unknown]:
    return [Unknown(Variable(type=b.type, name=b.name, role="bound"), b.carrier) for b in binders]


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
