"""The terms that a lemma could be about: found by matching what it speaks of with what a question speaks of.

A solver has to guess for which values it needs what is known for all. Where a question has a term that looks like one
of the lemma, such as ``#(a union b)``, the values are plain (E-matching: Detlefs, Nelson and Saxe, *Simplify*, 2005).
What equations say of after-values and outputs is put in their place first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

from cspcheck.checker.proof.normal import items_of, joined
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.terms import Key, conjuncts, key, substitute, universe, variables
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Term, Variable
from cspcheck.cspm.oz.typing.uses import with_types
from cspcheck.cspm.oz.values.substitution import rebuilt

MOST_INSTANCES = 24
"""Of one lemma so many are taken at most."""
_ROUNDS = 2
_COMMUTATIVE = ("union", "inter", "plus", "times", "equal")
_INTERPRETED = (
    *(
        "not",
        "and",
        "or",
        "implies",
        "iff",
        "equal",
        "in",
        "less",
        "at_most",
        "plus",
        "minus",
        "times",
        "negate",
        "abs",
    ),
    *("tuple", "range", "int_to_real"),
)
"""Operators that a term is not told by: the solver rewrites them at will."""


@dataclass(frozen=True, slots=True)
class Match:
    """What stands for the variables of a lemma, and for the given sets that are its generic parameters."""

    terms: Mapping[Key, Term] = field(default_factory=dict)
    types: Mapping[str, core.Type] = field(default_factory=dict)


def matches(
    unknowns: Sequence[Variable],
    said: Sequence[Term],
    givens: Sequence[str],
    terms: Sequence[Term],
    *,
    guess: bool = True,
) -> Iterator[Match]:
    """Values for the variables of a lemma among ground terms, as far as what it says looks like these.

    Args:
        unknowns: the variables.
        said: what the lemma says, what it speaks of first.
        givens: the given sets that stand for its generic parameters.
        terms: of the question.
        guess: take any term of the right type for a variable that is in nothing that the lemma speaks of.
    """
    wanted = frozenset(map(key, unknowns))
    matcher = _Matcher(wanted, frozenset(givens))
    patterns = _patterns(said[:1], wanted) or _patterns(said[1:], wanted)
    found: dict[tuple[tuple[Term, ...], tuple[core.Type, ...]], Match] = {}
    for group in _groups(patterns, wanted):
        for match in islice(_joined(matcher, group, terms, Match()), MOST_INSTANCES * 4):
            for whole in islice(_completed(matcher, unknowns, terms if guess else (), match), MOST_INSTANCES):
                values = (tuple(whole.terms[key(v)] for v in unknowns), tuple(whole.types.get(g, BOOL) for g in givens))
                if len(whole.types) == len(givens) and values not in found:
                    found[values] = whole
                    yield whole
                    if len(found) >= MOST_INSTANCES:
                        return
    if guess and not givens and len(unknowns) == 1:
        likely = [term for term in terms if isinstance(term, Variable)] if found else terms
        yield from islice(_completed(matcher, unknowns, likely, Match()), MOST_INSTANCES)


def _joined(matcher: _Matcher, group: Sequence[Term], terms: Sequence[Term], match: Match) -> Iterator[Match]:
    if not group:
        yield match
        return
    for term in terms:
        for more in matcher.match(group[0], term, match):
            yield from _joined(matcher, group[1:], terms, more)


def _completed(matcher: _Matcher, unknowns: Sequence[Variable], terms: Sequence[Term], match: Match) -> Iterator[Match]:
    """Values by their type alone for the variables that no pattern has."""
    for variable in unknowns:
        if key(variable) not in match.terms:
            for term in terms:
                for more in matcher.match(variable, term, match):
                    yield from _completed(matcher, unknowns, terms, more)
            return
    yield match


def _patterns(said: Sequence[Term], wanted: frozenset[Key]) -> list[Term]:
    """The subterms of a lemma that other terms may look like."""
    found: dict[Term, None] = {}
    for term in said:
        for part in _subterms(term):
            plain = isinstance(part, Apply) and part.type != BOOL and part.operator not in _INTERPRETED
            names = variables(part).keys()
            if plain and names & wanted and not any(role == "bound" for _, role in names):
                found.setdefault(part)
    return list(found)


def _groups(patterns: Sequence[Term], wanted: frozenset[Key]) -> Iterator[tuple[Term, ...]]:
    """Patterns that have all variables between them: single ones first, the largest."""
    whole = [p for p in patterns if wanted <= variables(p).keys()]
    largest = [p for p in whole if not any(q is not p and p in _subterms(q) for q in whole)]
    yield from ((p,) for p in largest)
    if whole:
        return
    left, group = set(wanted), []
    for pattern in sorted(patterns, key=lambda p: -len(variables(p).keys() & wanted)):
        if variables(pattern).keys() & left:
            group.append(pattern)
            left -= variables(pattern).keys()
    yield tuple(group)


class _Matcher:
    def __init__(self, wanted: frozenset[Key], givens: frozenset[str]) -> None:
        self._wanted = wanted
        self._givens = givens

    def match(self, pattern: Term, term: Term, match: Match) -> Iterator[Match]:
        """Ways in which a term looks like a pattern."""
        types = self._typed(pattern.type, term.type, match.types)
        if types is None:
            return
        if isinstance(pattern, Variable) and key(pattern) in self._wanted:
            known = match.terms.get(key(pattern))
            if known is None:
                yield Match({**match.terms, key(pattern): term}, types)
            elif known == term:
                yield Match(match.terms, types)
            return
        if isinstance(pattern, Apply) and pattern.operator == "sequence" and isinstance(term, Apply):
            ours, theirs = tuple(items_of(pattern)), tuple(items_of(term))
            if len(ours) > 1 and len(ours) == len(theirs):
                yield from self._all(ours, theirs, Match(match.terms, types))
                return
        if isinstance(pattern, Apply):
            if not isinstance(term, Apply) or pattern.operator != term.operator:
                return
            if pattern.operator in ("All",) or len(pattern.operands) != len(term.operands):
                if pattern.operator == "All":
                    yield Match(match.terms, types)
                return
            if pattern.operator == "concat":
                yield from self._concatenated(pattern, tuple(items_of(term)), Match(match.terms, types))
                return
            orders = [term.operands]
            if pattern.operator in _COMMUTATIVE and len(term.operands) == 2:
                orders.append(term.operands[::-1])
            for operands in orders:
                yield from self._all(pattern.operands, operands, Match(match.terms, types))
            return
        if isinstance(pattern, core.Construct) and pattern.argument is not None and isinstance(term, core.Construct):
            if pattern.constructor == term.constructor and term.argument is not None:
                yield from self.match(pattern.argument, term.argument, Match(match.terms, types))
            return
        if isinstance(pattern, core.Field) and isinstance(term, core.Field) and pattern.name == term.name:
            yield from self.match(pattern.record, term.record, Match(match.terms, types))
            return
        if pattern == term:
            yield Match(match.terms, types)

    def _concatenated(self, pattern: Apply, items: tuple[Term, ...], match: Match) -> Iterator[Match]:
        """Ways in which ``p ^ q`` stands for a concatenation, wherever that is cut in two."""
        first, second = pattern.operands
        for cut in range(1, len(items)):
            for more in self.match(first, joined(items[:cut], pattern), match):
                yield from self.match(second, joined(items[cut:], pattern), more)

    def _all(self, patterns: Sequence[Term], terms: Sequence[Term], match: Match) -> Iterator[Match]:
        if not patterns:
            yield match
            return
        for more in self.match(patterns[0], terms[0], match):
            yield from self._all(patterns[1:], terms[1:], more)

    def _typed(
        self, pattern: core.Type, type_: core.Type, known: Mapping[str, core.Type]
    ) -> Mapping[str, core.Type] | None:
        """What given sets stand for where two types are the same; None where they are not."""
        if isinstance(pattern, core.GivenType) and pattern.name in self._givens:
            first = known.get(pattern.name)
            if first is None:
                return {**known, pattern.name: type_}
            return known if first == type_ else None
        if type(pattern) is not type(type_):
            return None
        inner, others = _parts(pattern), _parts(type_)
        if not inner:
            return known if pattern == type_ else None
        if len(inner) != len(others):
            return None
        for one, other in zip(inner, others, strict=True):
            more = self._typed(one, other, known)
            if more is None:
                return None
            known = more
        return known


def _parts(type_: core.Type) -> tuple[core.Type, ...]:
    match type_:
        case core.TupleType(items=items):
            return items
        case core.SetType(element=element) | core.SequenceType(element=element) | core.BagType(element=element):
            return (element,)
        case core.FunctionType(domain=domain, range=range_):
            return (domain, range_)
    return ()


def retyped(term: Term, types: Mapping[str, core.Type]) -> Term:
    """A term with types in the place of given sets."""
    if not types:
        return term

    def change(part: Term) -> Term:
        if isinstance(part, Apply) and part.operator == "All":
            element = part.type.element if isinstance(part.type, core.SetType) else part.type
            if isinstance(element, core.GivenType) and element.name in types:
                return universe(types[element.name])
        part = rebuilt(part, change)
        if isinstance(part, core.Quantifier | core.Comprehension):
            part = replace(part, binders=tuple(replace(b, type=with_types(b.type, types)) for b in part.binders))
        new = with_types(part.type, types)
        return part if new == part.type else replace(part, type=new)

    return change(term)


def ground_terms(parts: Iterable[Constraint]) -> list[Term]:
    """The subterms of a question that stand outside all binders, with after-values in the words of equations too."""
    terms = [part.term for part in parts]
    table: dict[Key, Term] = {}
    for term in terms:
        for conjunct in conjuncts(term):
            if isinstance(conjunct, Apply) and conjunct.operator == "equal":
                for one, other in (conjunct.operands, conjunct.operands[::-1]):
                    result = isinstance(one, Variable) and one.role in ("after", "output")
                    if isinstance(one, Variable) and result and key(one) not in variables(other):
                        table.setdefault(key(one), other)
    found: dict[Term, None] = {}
    for term in terms:
        for _ in range(_ROUNDS):
            for part in _subterms(term):
                outside = part.type != BOOL and not any(role == "bound" for _, role in variables(part))
                if outside and not isinstance(part, core.Constant):
                    found.setdefault(part)
            term = substitute(term, table)
    return list(found)


def _subterms(term: Term) -> Iterator[Term]:
    yield term
    for part in core.parts(term):
        yield from _subterms(part)
