"""Claims about one class, answered: the ground that all obligations stand on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import ParamSpec, TypeVar

from cspcheck.checker.proof.cases import cases
from cspcheck.checker.proof.client import SolverClient
from cspcheck.checker.proof.defined import defined, with_domains, without_definitions
from cspcheck.checker.proof.finding import Finding, Hypothesis, Severity, Status
from cspcheck.checker.proof.finite import found_in_scope, is_small
from cspcheck.checker.proof.functional import functional
from cspcheck.checker.proof.induction import INDUCTION, Scheme, opened, schemes
from cspcheck.checker.proof.lemmas import (
    Claim,
    Rule,
    claims_of,
    fitting_laws,
    instances,
    is_beyond,
    law,
    named,
    rules,
    rules_of,
    used_for,
    whole,
)
from cspcheck.checker.proof.normal import normal
from cspcheck.checker.proof.prepared import lifted, prepared
from cspcheck.checker.proof.question import (
    CARRIER,
    CLAIM,
    Answer,
    Constraint,
    Found,
    Help,
    Impossible,
    NotUpTo,
    Question,
    SolverSettings,
    Unanswered,
)
from cspcheck.checker.proof.situation import Situation
from cspcheck.checker.proof.terms import all_of, negation, substitute, variables, variables_of
from cspcheck.checker.proof.witnesses import with_witnesses
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term, Variable
from cspcheck.cspm.oz.typing.uses import outermost
from cspcheck.cspm.oz.values.recursion import Recursion, recursions
from cspcheck.cspm.oz.writing.core_text import text, written
from cspcheck.cspm.source import Span

_P = ParamSpec("_P")
_T = TypeVar("_T")
_GLANCE = {1: 1_000, 2: 4_000}
_SEARCH = {1: 20_000, 2: 100_000, 3: 200_000}
"""For each scope, how many values are tried before the solver is asked, and where it has no answer."""


class Prover:
    """Answers claims about one class of a specification.

    Args:
        specification, model: what the claims are about.
        settings: how hard to try.
        clock: tells the seconds.
        thorough: look in small scopes and case by case where the solver has no answer for the whole.
        claims: the lemmas that there are; by default those of the class and the specification.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel,
        settings: SolverSettings | None = None,
        clock: Callable[[], float] = time.monotonic,
        *,
        thorough: bool = True,
        claims: Mapping[str, Claim] | None = None,
    ) -> None:
        self.situation = Situation(specification, model)
        self.solver = SolverClient(specification, model, settings, clock)
        self.clock = clock
        self._thorough = thorough
        self._possible: dict[tuple[str, str], Answer] = {}
        self.claims = claims_of(self.situation) if claims is None else claims
        self.help = Help()
        """What the user says that the proof of the next claims needs."""
        self._lemmas: dict[str, Answer] = {}
        self._computing = False
        self._proving: list[str] = []
        self._used: dict[str, None] = {}
        self._missing: dict[str, None] = {}
        self._proofs: list[Question] = []
        """The questions that the proofs since the last finding are, where their reasons are wanted."""

    @property
    def model(self) -> core.ClassModel:
        """The class."""
        return self.situation.model

    @property
    def specification(self) -> core.Specification:
        """The specification."""
        return self.situation.specification

    # --- asking ------------------------------------------------------------------------------------------------------

    def find(self, parts: Iterable[Constraint], shown: Iterable[Variable] = ()) -> Answer:
        """Values that satisfy *parts*, and the constants' axioms with them."""
        return self._asked(parts, shown, first=False)

    def refutes(self, premises: Iterable[Constraint], goal: Term, shown: Iterable[Variable] = ()) -> Answer:
        """Values that satisfy *premises*, but not *goal*."""
        return self._asked([*premises, self.fails(goal)], shown, first=True)

    def _solved(self, question: Question) -> Answer:
        """The solver's answer to a question, remembered where it is a proof."""
        answer = self.solver.ask(question)
        if isinstance(answer, Impossible):
            self._proofs.append(question)
        return answer

    def _tried(self, way: Callable[_P, _T], *args: _P.args, **named: _P.kwargs) -> _T:
        """What comes of a way to prove something; what it proved on the way is forgotten where it gets nowhere."""
        before = len(self._proofs)
        found = way(*args, **named)
        if not (found is True or isinstance(found, Impossible)):
            del self._proofs[before:]
        return found

    def _asked(self, parts: Iterable[Constraint], shown: Iterable[Variable], *, first: bool) -> Answer:
        """Values that satisfy *parts*: found in small scopes, or by the solver for the whole or case by case.

        *first*: look in small scopes before the solver is asked, where what is claimed is that there are none.
        """
        parts = tuple(parts)
        whole = self.situation.with_constants(parts)
        variables = (*self.situation.constant_variables(whole), *shown)
        if not self._thorough:
            return self._solved(Question(whole, variables))
        small = is_small(v.type for v in variables_of(part.term for part in whole).values())
        glance = self.solver.settings.glance
        if (first and not small and glance != "after") or self._speaks_of_recursion(whole):
            found = self._in_scopes(whole, variables, _GLANCE)
            if found is not None:
                return found
        if glance == "only":
            return Unanswered("looked at few and small values only")
        if first and (self.help.using or self.help.induction) and self._tried(self._with_help, parts):
            return Impossible()
        if first and (self.claims or is_beyond(whole)) and self._tried(self._with_what_there_is, parts, 1):
            return Impossible()
        if first and self._tried(self._with_witnesses, whole):
            return Impossible()
        answer = self._solved(Question(whole, variables))
        if isinstance(answer, NotUpTo | Unanswered):
            found = self._in_scopes(whole, variables, _SEARCH)
            if found is not None:
                return found
            by_cases = self._tried(self._by_cases, whole, variables)
            answer = by_cases or (self._tried(self._in_plain_words, whole) if first else None) or answer
        if first and isinstance(answer, NotUpTo | Unanswered) and self._tried(self._with_what_there_is, parts, 2):
            return Impossible()
        return answer

    # --- lemmas ------------------------------------------------------------------------------------------------------

    def lemma(self, claim: Claim) -> Answer:
        """Values for which a lemma does not hold; asked once."""
        known = self._lemmas.get(claim.name)
        if known is None:
            assumed, said, named = opened(claim.lemma.term)
            table = {(b.name, "bound"): v for b, v in zip(outermost(claim.lemma.term), named.values(), strict=True)}
            using = [
                replace(use, arguments=tuple(substitute(term, table) for term in use.arguments))
                for use in claim.lemma.using
            ]
            before, self.help = self.help, Help(tuple(using), claim.lemma.induction)
            self._proving.append(claim.name)
            try:
                known = self.refutes([*claim.premises, *assumed], said, named.values())
            finally:
                self._proving.pop()
                self.help = before
            self._lemmas[claim.name] = known
        return known

    def claim(self, name: str) -> Claim | None:
        """A lemma of the classes or the script, or a law, by its name; None where there is none."""
        for known, claim in self.claims.items():
            if known == name or known.endswith(f".{name}"):
                return claim
        return law(name)

    def take_help(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What the proofs since the last time needed of lemmas, and what was not there for them."""
        used, missing = tuple(self._used), tuple(self._missing)
        self._used, self._missing = {}, {}
        return used, missing

    def reasons(self) -> tuple[Hypothesis, ...] | None:
        """The lines that the proofs since the last time needed; None where that is not wanted or not to be told."""
        proofs, self._proofs = self._proofs, []
        if not self.solver.settings.reasons:
            return None
        found: dict[Hypothesis, None] = {}
        for question in proofs:
            needed = self.solver.needed(question)
            if needed is None:
                return None
            found |= dict.fromkeys(one for part in needed if (one := self._hypothesis(part)) is not None)
        return tuple(sorted(found, key=_by_place))

    def _hypothesis(self, part: Constraint) -> Hypothesis | None:
        """What a part of a question is to a reader; None for the claim and for what a proof brings itself."""
        if part.what in (CLAIM, INDUCTION):
            return None
        (name,) = named([part]) or ("",)
        claim = self.claim(name) if name else None
        if claim is not None:
            kind = "law" if claim.law else "lemma"
            return Hypothesis(kind, f"{kind} `{name}`", None if claim.law else part.span)
        if part.what.startswith(CARRIER):
            return Hypothesis("carrier", self._membership(part), part.span)
        said = part.what if part.span is None else " ".join(part.span.text.split())
        return Hypothesis(part.what, said, part.span)

    def _membership(self, part: Constraint) -> str:
        """That a variable is in its carrier, as it is declared where a part says it of other terms."""
        name = part.what.removeprefix(CARRIER).removesuffix(" afterwards").strip("`")
        declared = {d.name: d for d in (*self.situation.variables, *self.situation.constants)}.get(name)
        plain = isinstance(part.term, core.Apply) and isinstance(part.term.operands[0], Variable)
        return text(part.term) if plain or declared is None else f"{name} in {text(declared.carrier)}"

    def _aside(self, way: Callable[[], _T]) -> _T:
        """What comes of a question that is no part of the proof at hand."""
        kept = self._used, self._missing, self._proofs
        self._used, self._missing, self._proofs = {}, {}, []
        try:
            return way()
        finally:
            self._used, self._missing, self._proofs = kept

    def _holds(self, claim: Claim) -> bool:
        """Whether a lemma is proved without the help of one that is being proved."""
        if claim.law:
            return True
        if claim.name in self._proving:
            return False
        return isinstance(self._aside(lambda: self.lemma(claim)), Impossible)

    def _with_help(self, whole: tuple[Constraint, ...]) -> bool:
        """Whether what the user names proves that nothing satisfies *whole*."""
        claims: list[Claim] = []
        told: list[Constraint] = []
        for use in self.help.using:
            claim = self.claim(use.name)
            if claim is None or not self._holds(claim):
                self._missing[use.name] = None
            elif use.arguments:
                told += used_for(claim, use.arguments, self.solver.definedness)
            else:
                claims.append(claim)
        whole = (*whole, *told)
        on = [v for v in variables_of(part.term for part in whole).values() if written(v) == self.help.induction]
        if on and on[0].role != "constant":
            total = tuple(self._total(whole))
            ways = schemes(total, on[0], self.specification.frees.values(), self.situation.axioms)
            return any(self._tried(self._in_all, scheme, claims, depth) for depth in (1, 2) for scheme in ways)
        return bool(claims or told) and self._is_impossible(whole, claims)

    def _in_all(self, scheme: Scheme, claims: Sequence[Claim], depth: int) -> bool:
        return all(self._is_impossible(case, claims, depth) for case in scheme.cases)

    def _with_what_there_is(self, whole: tuple[Constraint, ...], depth: int) -> bool:
        """Whether the lemmas that there are, and the laws of the toolkit, prove that nothing satisfies *whole*."""
        laws_proved = any(claim is not None and claim.law for claim in map(self.claims.get, self._proving))
        if self._late() or laws_proved or self._computing:
            return False
        names = [] if self._proving else list(self.claims)
        claims = [claim for claim in map(self.claims.get, names) if claim is not None and self._holds(claim)]
        return self._is_impossible(whole, [*claims, *fitting_laws(whole)], depth, needed=True)

    def _is_impossible(
        self, parts: tuple[Constraint, ...], claims: Sequence[Claim], depth: int = 2, *, needed: bool = False
    ) -> bool:
        """Whether lemmas prove that nothing satisfies *parts*.

        With *needed* nothing is tried where no lemma says anything. *depth* 1: by what they, and all else that holds of
        all values, say of the terms in the parts; 2: by all of it.
        """
        helping = rules(claims, self.solver.definedness)
        spoken = [rule.part(rule.body) for rule in helping]
        known = self.situation.with_constants((*parts, *spoken))[: -len(spoken) or None]
        total = [replace(part, term=normal(part.term), total=True) for part in self._total(known)]
        plain: list[Constraint] = []
        quantified: list[Rule] = []
        for part in total:
            found = rules_of(part)
            quantified += found
            plain += [] if found else [part]
        told = instances([*helping, *quantified], plain, self.solver.definedness)
        # What holds of all values is mostly needed for a few alone, and a solver is quick without quantifiers.
        all_values = [part for rule in helping for part in whole(rule)]
        if needed and not named(told) and not all_values:
            return False
        for question, share in (((*plain, *told), 0.1), ((*total, *told, *all_values), 0.4))[:depth]:
            if self._late():
                return False
            asked = tuple(dict.fromkeys(question))
            if isinstance(self._solved(Question(asked, proof=share)), Impossible):
                if named(asked):
                    self._used |= dict.fromkeys(named(self.solver.core(asked)))
                return True
        return False

    def _in_scopes(
        self, parts: tuple[Constraint, ...], shown: tuple[Variable, ...], scopes: dict[int, int]
    ) -> Found | None:
        known = self.defined if self._speaks_of_recursion(parts) else {}
        total = self._total(without_definitions(parts, known))
        total = [replace(part, term=with_domains(part.term, known)) for part in total] if known else total
        for scope, tried in scopes.items():
            if self._late():
                return None
            found = found_in_scope(self.specification, self.model, total, shown, scope, tried, known)
            if found is not None:
                return found
        return None

    @cached_property
    def defined(self) -> dict[str, Recursion]:
        """The constants that are defined by recursion, and proved to be in their carriers."""
        self._computing = True
        before, self.help = self.help, Help()
        try:
            return self._aside(lambda: defined(self.situation, lambda premises, goal: self.refutes(premises, goal)))
        finally:
            self._computing, self.help = False, before

    def _speaks_of_recursion(self, parts: Iterable[Constraint]) -> bool:
        candidates = recursions(self.situation.constants, self.situation.axioms)
        spoken = {name for part in parts for name, role in variables(part.term) if role == "constant"}
        return not self._computing and not spoken.isdisjoint(candidates)

    def _total(self, parts: Iterable[Constraint]) -> list[Constraint]:
        """The parts as conjuncts that are defined everywhere."""
        holding = self.solver.definedness.holding
        return [replace(p, term=functional(t)) for p in parts for t in ((p.term,) if p.total else holding([p.term]))]

    def _by_cases(self, parts: tuple[Constraint, ...], shown: tuple[Variable, ...]) -> Answer | None:
        """The question for each case of a disjunction or conditional by itself; None where that does not decide it."""
        split = cases(parts, self.solver.definedness.total)
        for case in split:
            if self._late():
                return None
            answer = self._solved(Question(case, shown))
            if isinstance(answer, Found):
                return answer
            if not isinstance(answer, Impossible):
                return None
        return Impossible() if split else None

    def _in_plain_words(self, parts: tuple[Constraint, ...]) -> Impossible | None:
        """Whether nothing satisfies the parts: each case with its quantifiers opened and its equations worked out."""
        total = tuple(replace(part, term=lifted(part.term)) for part in self._total(parts))
        for case in cases(total, lambda term: True) or [total]:
            # A part of a case is defined everywhere, as the whole is.
            plain = prepared(replace(part, total=True) for part in case)
            known = [rule for part in plain for rule in rules_of(part)]
            plain = (*plain, *instances(known, plain, self.solver.definedness))
            if self._late() or not isinstance(self._solved(Question(plain, proof=0.3)), Impossible):
                return None
        return Impossible()

    def _with_witnesses(self, parts: tuple[Constraint, ...]) -> bool:
        """Whether nothing satisfies the parts because something exists that is said item by item."""
        total = tuple(replace(part, total=True) for part in self._total(parts))
        made = with_witnesses(total, self.solver.definedness)
        return made is not None and isinstance(self._solved(Question(made, proof=0.2)), Impossible)

    def _late(self) -> bool:
        return self.solver.is_late

    def fails(self, goal: Term) -> Constraint:
        """That a predicate is false or undefined."""
        return Constraint(negation(all_of(self.solver.definedness.holding([goal]))), CLAIM, goal.span, total=True)

    def performed(self, operation: core.Operation) -> Answer:
        """Whether the operation can ever be performed; asked once."""
        known = self._possible.get(("step", operation.name))
        if known is None:
            step = self.situation.step(operation)
            known = self._aside(lambda: self.find(step, self.situation.shown(operation)))
            self._possible["step", operation.name] = known
        return known

    def inhabited(self) -> Answer:
        """Whether there is a state; asked once."""
        known = self._possible.get(("state", ""))
        if known is None:
            known = self._aside(lambda: self.find(self.situation.state(), self.situation.shown()))
            self._possible["state", ""] = known
        return known

    # --- telling -----------------------------------------------------------------------------------------------------

    def lines(self, parts: Iterable[Constraint]) -> tuple[Span, ...]:
        """The lines that cannot hold together, of parts that cannot."""
        conflict = self.solver.conflict(self.situation.with_constants(parts))
        spans = {(s.start, s.end): s for s in (part.span for part in conflict) if s is not None}
        return tuple(spans[k] for k in sorted(spans))


class ObligationReport:
    """Makes the findings of one obligation.

    Args:
        prover: for the class and its clock.
        obligation: the name.
        severity: of a refutation.
    """

    def __init__(self, prover: Prover, obligation: str, severity: Severity) -> None:
        self._prover = prover
        self._obligation = obligation
        self._severity = severity
        self._start = prover.clock()

    def finding(self, status: Status, operation: core.Operation | None = None, **more: object) -> Finding:
        """A finding; the time since the last one is its time."""
        now = self._prover.clock()
        seconds = now - self._start
        hypotheses, missing = self._prover.take_help()
        # How long it takes to tell the reasons is no part of the proof's time.
        used = self._prover.reasons()
        self._start = self._prover.clock()
        name = operation.name if operation is not None else None
        return Finding(
            obligation=self._obligation,
            subject=self._prover.model.name,
            operation=name,
            severity=self._severity,
            status=status,
            seconds=seconds,
            hypotheses=hypotheses,
            missing=missing,
            used=used if status == "proved" and "values" not in more else None,
            **more,  # type: ignore[arg-type]
        )

    def universal(
        self,
        answer: Answer,
        operation: core.Operation | None = None,
        *,
        message: str,
        goal: Term | None = None,
        **more: object,
    ) -> Finding:
        """The finding for an answer that would be a counterexample."""
        match answer:
            case Impossible():
                return self.finding("proved", operation, **more)
            case Found():
                failing = text(goal) if goal is not None else None
                return self.finding("refuted", operation, message=message, failing=failing, **_told(answer), **more)
            case NotUpTo(scope=scope, reason=reason):
                said = f"not proved ({reason}); no counterexample with at most {scope} elements"
                return self.finding("bounded", operation, message=said, scope=scope, **more)
            case Unanswered(reason=reason):
                return self.finding("unknown", operation, message=reason, **more)

    def existential(
        self, answer: Answer, operation: core.Operation | None = None, *, message: str, **more: object
    ) -> Finding:
        """The finding for an answer that would be a witness."""
        match answer:
            case Found():
                more.pop("lines", None)
                return self.finding("proved", operation, **_told(answer), **more)
            case Impossible():
                return self.finding("refuted", operation, message=message, **more)
            case NotUpTo(scope=scope, reason=reason):
                said = f"{reason}; no values found with at most {scope} elements"
                return self.finding("unknown", operation, message=said, **more)
            case Unanswered(reason=reason):
                return self.finding("unknown", operation, message=reason, **more)


def _by_place(hypothesis: Hypothesis) -> tuple[bool, str, int, str]:
    """A key that puts lines in the order of the text, and what no line says behind them."""
    span = hypothesis.span
    return (span is None, "" if span is None else span.source.name, 0 if span is None else span.start, hypothesis.what)


def _told(found: Found) -> dict[str, object]:
    return {
        "values": values_of(found),
        "vouched": tuple(text(part.term) for part in found.vouched),
    }


def values_of(found: Found) -> dict[str, str]:
    """The values as texts by the names that the specification uses; internal variables left out."""
    return {written(variable): text(value) for variable, value in found.values.items() if variable.role != "bound"}
