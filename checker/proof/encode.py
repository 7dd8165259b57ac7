"""Core terms as formulas of the solver.

A query is put once as it is, with unbounded collections, and once for each of some small *scopes*, where each given
set has k elements and every collection at most k; there collections are written out, so that cardinalities are sums
and bounded quantifiers are expanded.

What has no exact formula (the cardinality of any set, a filtered sequence) becomes an uninterpreted function of the
solver with facts that are true of it. A proof is therefore a proof; a model may be spurious, and is believed only
after it has been replayed by :mod:`cspcheck.checker.proof.replay`.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import z3

from cspcheck.checker.proof import encode_functions, encode_numbers, encode_sequences, encode_sets, encoding_rules
from cspcheck.checker.proof.encode_values import Values
from cspcheck.checker.proof.encoding_rules import LARGEST_EXPANSION
from cspcheck.checker.proof.one_point import eliminated
from cspcheck.checker.proof.sorts import Expr, Unsupported, element_of, selected
from cspcheck.checker.proof.terms import Key, Unknown, equal, key, quantified, substitute, variables
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Binder, Comprehension, Constant, Quantifier, Term, Variable

RULES = (encode_numbers, encode_sets, encode_functions, encode_sequences)
"""The modules that say what operators mean; importing them fills the register."""


class Encoder(Values):
    """Puts the terms of one query.

    Args:
        specification: that the terms belong to.
        scope: the size of given sets and the greatest size of collections; None: unbounded.
    """

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
