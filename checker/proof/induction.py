"""Proofs by induction over numbers, sequences, finite sets and functions, and free types.

What is to be shown is that no values satisfy some predicates. With a variable of theirs chosen, it is shown for its
least value, and for a greater one where it is known for the next smaller ones, whatever the values of the other
variables: constants alone stay what they are. Where there are two ways to build a value, from the front and from
the back, either will do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from cspcheck.checker.proof.question import CARRIER, Constraint
from cspcheck.checker.proof.terms import (
    TRUE,
    Key,
    Unknown,
    all_of,
    bound_by,
    integer,
    key,
    member,
    negation,
    quantified,
    substitute,
    universe,
    variables,
    variables_of,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term, Variable

INDUCTION = "induction"
"""What a part of a question is that is known of smaller values."""

Case = tuple[Constraint, ...]
"""Predicates that no values may satisfy."""


@dataclass(frozen=True, slots=True)
class Scheme:
    """A way to do an induction. *name*: from what to what its step goes; *cases*: what must be shown impossible."""

    name: str
    cases: tuple[Case, ...]


def schemes(
    parts: tuple[Constraint, ...], on: Variable, frees: Iterable[core.FreeDefinition], axioms: Iterable[Term] = ()
) -> list[Scheme]:
    """The ways to show by induction that no values satisfy *parts*; none where there is no induction on the variable.

    Args:
        parts: defined everywhere.
        on: the variable.
        frees: the free types of the specification.
        axioms: that tell which way of building a sequence to try first.
    """
    found = list(_Induction(parts, on).schemes({free.name: free for free in frees}))
    return found[::-1] if any(map(_from_the_back, axioms)) else found


def _from_the_back(term: Term) -> bool:
    """Whether something is said of a sequence with one item behind it."""
    match term:
        case Apply(operator="concat", operands=(Variable(), Apply(operator="sequence"))):
            return True
    return any(map(_from_the_back, core.parts(term)))


class _Induction:
    def __init__(self, parts: tuple[Constraint, ...], on: Variable) -> None:
        self._parts = parts
        self._on = on
        self._carriers = [
            part.term.operands[1]
            for part in parts
            if isinstance(part.term, Apply) and part.term.operator == "in" and part.term.operands[0] == on
        ]

    def schemes(self, frees: dict[str, core.FreeDefinition]) -> Iterator[Scheme]:
        on, name = self._on, self._on.name
        match on.type:
            case core.IntType():
                least = self._least()
                if least is not None:
                    following = Apply(type=core.INT, operator="plus", operands=(on, integer(1)))
                    from_least = Apply(type=core.BOOL, operator="at_most", operands=(least, on))
                    step = (Constraint(from_least, "number", total=True), *self._case(following, [on]))
                    yield Scheme(f"from `{name}` to `{name} + 1`", (self._case(least, []), step))
            case core.SequenceType(element=element):
                item = self._fresh("x", element)
                one = Apply(type=on.type, operator="sequence", operands=(item,))
                base = self._case(Apply(type=on.type, operator="sequence"), [])
                for operands, shown in (((one, on), f"<x> ^ {name}"), ((on, one), f"{name} ^ <x>")):
                    longer = Apply(type=on.type, operator="concat", operands=operands)
                    yield Scheme(f"from `{name}` to `{shown}`", (base, self._case(longer, [on])))
            case core.SetType(element=element) if self._is_finite("finset", "finset1"):
                item = self._fresh("x", element)
                one = Apply(type=on.type, operator="set", operands=(item,))
                larger = Apply(type=on.type, operator="union", operands=(on, one))
                all_finite = Apply(type=core.SetType(on.type), operator="finset", operands=(universe(element),))
                new = [member(on, all_finite), negation(member(item, on))]
                step = (*[Constraint(term, "set", total=True) for term in new], *self._case(larger, [on]))
                base = self._case(Apply(type=on.type, operator="set"), [])
                yield Scheme(f"from `{name}` to `{name} union {{x}}`", (base, step))
            case core.FunctionType(domain=domain, range=range_) if self._is_finite("ffun", "finj"):
                item, image = self._fresh("x", domain), self._fresh("y", range_)
                pair = Apply(type=core.TupleType((domain, range_)), operator="tuple", operands=(item, image))
                one = Apply(type=on.type, operator="function", operands=(pair,))
                larger = Apply(type=on.type, operator="override", operands=(on, one))
                sides = (universe(domain), universe(range_))
                all_finite = Apply(type=core.SetType(on.type), operator="ffun", operands=sides)
                inside = Apply(type=core.SetType(domain), operator="dom", operands=(on,))
                new = [member(on, all_finite), negation(member(item, inside))]
                step = (*[Constraint(term, "function", total=True) for term in new], *self._case(larger, [on]))
                base = self._case(Apply(type=on.type, operator="function"), [])
                yield Scheme(f"from `{name}` to `{name} (+) {{x |-> y}}`", (base, step))
            case core.FreeType(name=type_name) if type_name in frees:
                yield Scheme(f"over the constructors of `{type_name}`", tuple(self._branches(frees[type_name])))

    # --- cases -------------------------------------------------------------------------------------------------------

    def _case(self, value: Term, smaller: list[Variable]) -> Case:
        """The predicates at a value, where they are known to be impossible at smaller ones."""
        at = tuple(replace(part, term=self._at(part.term, value)) for part in self._parts)
        known = [Constraint(term, INDUCTION, total=True) for one in smaller for term in self._hypotheses(one)]
        return (*known, *at)

    def _at(self, term: Term, value: Term) -> Term:
        return substitute(term, {key(self._on): value})

    def _hypotheses(self, value: Variable) -> Iterator[Term]:
        """That the predicates are impossible at a value: for the others as they are, and for all others."""
        claim = negation(all_of(self._at(part.term, value) for part in self._parts))
        yield claim
        others = [
            v for k, v in variables_of(part.term for part in self._parts).items() if k != key(self._on) and free(v)
        ]
        if others:
            binders, table = bound_by([Unknown(v, universe(v.type)) for v in others])
            yield quantified("forall", binders, TRUE, substitute(claim, table))

    def _branches(self, free_type: core.FreeDefinition) -> Iterator[Case]:
        on = self._on
        for constructor, carrier in free_type.branches:
            if carrier is None:
                yield self._case(core.Construct(type=on.type, constructor=constructor), [])
                continue
            assert isinstance(carrier.type, core.SetType)
            element = carrier.type.element
            if isinstance(element, core.TupleType):
                items = tuple(self._fresh(f"x{i}", item) for i, item in enumerate(element.items, 1))
                argument: Term = Apply(type=element, operator="tuple", operands=items)
            else:
                items = (self._fresh("x", element),)
                argument = items[0]
            built = core.Construct(type=on.type, constructor=constructor, argument=argument)
            smaller = [item for item in items if item.type == on.type]
            yield (Constraint(member(argument, carrier), "argument", total=True), *self._case(built, smaller))

    # --- what is known of the variable -------------------------------------------------------------------------------

    def _least(self) -> Term | None:
        """A number that the variable is never below, which depends on constants alone."""
        for carrier in self._carriers:
            match carrier:
                case Apply(operator="Nat"):
                    return integer(0)
                case Apply(operator="Nat1"):
                    return integer(1)
                case Apply(operator="range", operands=(low, _)) if not any(map(free, variables(low).values())):
                    return low
        return None

    def _is_finite(self, *operators: str) -> bool:
        return any(isinstance(c, Apply) and c.operator in operators for c in self._carriers)

    def _fresh(self, name: str, type_: core.Type) -> Variable:
        return Variable(type=type_, name=f"{self._on.name}%{name}", role="simple")


def free(variable: Variable) -> bool:
    """Whether the others of an induction range over a variable: all but constants do."""
    return variable.role != "constant"


def opened(term: Term) -> tuple[list[Constraint], Term, dict[str, Variable]]:
    """What ``forall d | p @ q`` assumes, what it says, and the variables that it speaks of, by written names."""
    assumed: list[Constraint] = []
    named: dict[str, Variable] = {}
    table: dict[Key, Term] = {}
    while isinstance(term, core.Quantifier) and term.kind == "forall":
        for binder in term.binders:
            name = binder.written if binder.written not in named else binder.name
            variable = Variable(type=binder.type, name=name, role="simple")
            assumed.append(
                Constraint(member(variable, substitute(binder.carrier, table)), f"{CARRIER}`{name}`", term.span)
            )
            named[name] = variable
            table[binder.name, "bound"] = variable
        assumed.append(Constraint(substitute(term.condition, table), "condition", term.condition.span))
        term = term.body
    return assumed, substitute(term, table), named
