"""Lemmas as hypotheses: which there are, and what they say where a question is asked.

A lemma helps a proof only when it has been proved itself, with the help of others at most that were proved without it.
What it says is then added to the question for all values, and for the terms of the question that it could be about;
these must be defined everywhere, because what a lemma says it says of values.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.induction import INDUCTION, opened
from cspcheck.checker.proof.instances import Match, ground_terms, matches, retyped
from cspcheck.checker.proof.normal import normal
from cspcheck.checker.proof.one_point import simplified
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.situation import Situation
from cspcheck.checker.proof.terms import (
    TRUE,
    Unknown,
    all_of,
    bound_by,
    equal,
    implication,
    is_true,
    key,
    member,
    negation,
    primed,
    quantified,
    substitute,
    universe,
    variables,
)
from cspcheck.cspm.oz import core, laws
from cspcheck.cspm.oz.core import Term, Variable
from cspcheck.cspm.oz.typing.uses import fitted
from cspcheck.cspm.source import Span

_ROUNDS = 2
_DESCRIBED = frozenset(
    ["card", "closure", "reflexive_closure", "squash", "filter", "extract", "flatten", "items", "override"]
)
"""Operators of which the solver does not know everything."""
_BEYOND = frozenset(["closure", "reflexive_closure", "squash", "filter"])
PREFIX = "lemma "
"""Before the name, in what a part of a question is."""


@dataclass(frozen=True, slots=True)
class Claim:
    """A lemma of a class or of the script, or a law.

    Attributes:
        lemma: as it is declared.
        premises: of a lemma about states, that a state is one of the class.
        law: whether it is one of the toolkit, which is known to hold.
    """

    lemma: core.Lemma
    premises: tuple[Constraint, ...] = ()
    law: bool = False

    @property
    def name(self) -> str:
        """The name."""
        return self.lemma.name

    def opened(self, definedness: Definedness) -> tuple[list[Variable], list[Term], Term]:
        """The variables that it is about, what it assumes of them, and what it says.

        What is assumed is defined everywhere; what is said is defined where that holds, since it has been proved so.
        """
        assumed, said, named = opened(self.lemma.term)
        premises = definedness.holding(part.term for part in (*self.premises, *assumed))
        return list(named.values()), [term for term in premises if not is_true(term)], said


def claims_of(situation: Situation) -> dict[str, Claim]:
    """The lemmas of a class and of its specification, by name."""
    found = {name: Claim(lemma) for name, lemma in situation.specification.lemmas.items()}
    for name, lemma in situation.model.lemmas.items():
        about_states = any(role == "before" for _, role in variables(lemma.term))
        found[name] = Claim(lemma, situation.state() if about_states else ())
    return found


def law(name: str) -> Claim | None:
    """A law of the toolkit by its name."""
    if name not in laws.names():
        return None
    return Claim(laws.laws()[name], law=True)


def fitting_laws(parts: Sequence[Constraint]) -> list[Claim]:
    """The laws whose operators a question has."""
    spoken = _operators(part.term for part in parts)
    fitting = []
    for name, needed in _laws_by_operator().items():
        if needed <= spoken:
            claim = law(name)
            assert claim is not None
            fitting.append(claim)
    return fitting


def is_beyond(parts: Sequence[Constraint]) -> bool:
    """Whether a question has operators that the solver knows next to nothing of without laws."""
    return not _operators(part.term for part in parts).isdisjoint(_BEYOND)


@cache
def _laws_by_operator() -> Mapping[str, frozenset[str]]:
    """For each law the operators without which it says nothing of a question."""
    return {name: _operators([lemma.term]) & _DESCRIBED for name, lemma in laws.laws().items()}


def _operators(terms: Iterable[Term]) -> frozenset[str]:
    found: set[str] = set()
    todo = list(terms)
    while todo:
        term = todo.pop()
        if isinstance(term, core.Apply):
            found.add(term.operator)
        todo.extend(core.parts(term))
    return frozenset(found)


@dataclass(frozen=True, slots=True)
class Rule:
    """What holds of all values: of a lemma, an axiom, an invariant, or an induction.

    Attributes:
        what, span: of the part of a question that it is.
        unknowns: the variables.
        premises: assumed of them, defined everywhere.
        said: what holds then.
        givens: the given sets that stand for generic parameters.
        primes: whether it holds of the state afterwards as well.
    """

    what: str
    span: Span | None
    unknowns: tuple[Variable, ...]
    premises: tuple[Term, ...]
    said: Term
    givens: tuple[str, ...] = ()
    primes: bool = False

    @property
    def body(self) -> Term:
        """What holds of values of the variables."""
        return implication(all_of(self.premises), self.said)

    def part(self, term: Term) -> Constraint:
        """A part of a question that says something of this."""
        return Constraint(term, self.what, self.span, total=True)


def rules(claims: Iterable[Claim], definedness: Definedness) -> list[Rule]:
    """What proved lemmas say."""
    found = []
    for claim in claims:
        unknowns, premises, said = claim.opened(definedness)
        found.append(
            Rule(
                PREFIX + claim.name,
                claim.lemma.span,
                tuple(unknowns),
                tuple(map(normal, premises)),
                normal(said),
                claim.lemma.givens,
                bool(claim.premises),
            )
        )
    return found


_FUNCTIONS = ("fun", "pfun", "ffun")


def rules_of(part: Constraint) -> list[Rule]:
    """What a part that is defined everywhere says of all values, where that is all it says; none otherwise.

    Such a part is a predicate for all values, or that a function goes from one set to another.
    """
    match part.term:
        case core.Quantifier(kind="forall"):
            assumed, said, named_ = opened(part.term)
            premises = tuple(p.term for p in assumed if not is_true(simplified(p.term)))
            return [Rule(part.what, part.span, tuple(named_.values()), premises, said)]
        case core.Apply(operator="not", operands=(core.Quantifier(kind="exists") as inner,)):
            never = replace(inner, kind="forall", body=negation(inner.body))
            return rules_of(replace(part, term=never))
        case core.Apply(operator="in", operands=(function, core.Apply(operator=kind, operands=(domain, range_)))):
            if kind not in _FUNCTIONS or not isinstance(function, core.Variable):
                return []
            type_ = function.type
            assert isinstance(type_, core.FunctionType)
            x = core.Variable(type=type_.domain, name="argument%", role="simple")
            inside = member(x, core.Apply(type=core.SetType(type_.domain), operator="dom", operands=(function,)))
            image = core.Apply(type=type_.range, operator="apply", operands=(function, x))
            said = all_of(simplified(member(a, b)) for a, b in ((x, domain), (image, range_)))
            found = [Rule(part.what, part.span, (x,), (inside,), said)]
            if kind == "fun":
                argument = simplified(member(x, domain))
                found.append(Rule(part.what, part.span, (x,), (argument, equal(image, image)), inside))
            return found
    return []


def whole(rule: Rule) -> Iterator[Constraint]:
    """What a rule says of all values, as parts of a question; nothing for one with generic parameters."""
    if rule.givens:
        return
    for term in (rule.body, *(primed([rule.body]) if rule.primes else ())):
        binders, table = bound_by([Unknown(v, universe(v.type)) for v in rule.unknowns])
        yield rule.part(quantified("forall", binders, TRUE, substitute(term, table)))


def instances(rules_: Sequence[Rule], parts: Sequence[Constraint], definedness: Definedness) -> tuple[Constraint, ...]:
    """What rules say of the terms of a question, and of the terms in that."""
    found: dict[Constraint, None] = {}
    terms = ground_terms(parts)
    for round_ in range(_ROUNDS):
        before = len(found)
        for rule in rules_:
            # What is known by induction holds of smaller values alone: there is no end to what it could be about.
            if round_ and rule.what == INDUCTION:
                continue
            for part in _of_terms(rule, terms, definedness, guess=not round_):
                found.setdefault(part)
        if len(found) == before:
            break
        terms = ground_terms([*parts, *[part for part in found if part.what != INDUCTION]])
    return tuple(found)


def _of_terms(rule: Rule, terms: Sequence[Term], definedness: Definedness, *, guess: bool) -> Iterator[Constraint]:
    if not rule.unknowns:
        yield rule.part(rule.body)
        return
    for match in matches(rule.unknowns, [rule.said, *rule.premises], rule.givens, terms, guess=guess):
        yield from _said(rule, match, definedness)


def _said(rule: Rule, match: Match, definedness: Definedness) -> Iterator[Constraint]:
    """What a rule says of values, where these are defined."""
    defined = all_of(definedness.condition(term) for term in match.terms.values())
    body = retyped(rule.body, match.types)
    for term in (body, *(primed([body]) if rule.primes else ())):
        yield rule.part(implication(defined, normal(substitute(term, match.terms))))


def used_for(claim: Claim, arguments: Sequence[Term], definedness: Definedness) -> tuple[Constraint, ...]:
    """What a proved lemma says of given values, where these are defined."""
    types, values = fitted(claim.lemma, arguments)
    (rule,) = rules([claim], definedness)
    table = {key(variable): value for variable, value in zip(rule.unknowns, values, strict=True)}
    return tuple(_said(rule, Match(table, types), definedness))


def named(parts: Iterable[Constraint]) -> tuple[str, ...]:
    """The names of the lemmas among parts of a question, each once."""
    return tuple(dict.fromkeys(part.what.removeprefix(PREFIX) for part in parts if part.what.startswith(PREFIX)))
