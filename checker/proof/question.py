"""What is asked of the solver, and what can come back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

from cspcheck.cspm.oz.core import LemmaUse, Term, Variable
from cspcheck.cspm.source import Span

CLAIM = "claim"
"""What the part of a question is that contradicts what is to be proved."""
CARRIER = "carrier of "
"""Before the name of a variable, in what the part of a question is that puts it into its carrier."""


@dataclass(frozen=True, slots=True)
class Constraint:
    """A predicate that the values asked for must satisfy.

    Attributes:
        term: the predicate.
        what: what it is in the specification: ``invariant``, ``guard``, ``effect``, ``frame``, ``carrier``, ...
        span: the line that it comes from; None for what no line says.
        total: it is known to be defined everywhere.
    """

    term: Term
    what: str
    span: Span | None = None
    total: bool = False


@dataclass(frozen=True, slots=True)
class Question:
    """Are there values of the variables of *parts* that satisfy all of them?

    ``shown`` are the variables whose values are told, in this order; others that occur are told behind them. With
    ``proof`` it is only to be proved that there are none, in that share of the time: values are not looked for.
    """

    parts: tuple[Constraint, ...]
    shown: tuple[Variable, ...] = ()
    proof: float = 0.0


@dataclass(frozen=True, slots=True)
class Help:
    """What a user says that a proof needs.

    Attributes:
        using: lemmas and laws.
        induction: the variable to do induction on, as it is written; None: none is to be done.
    """

    using: tuple[LemmaUse, ...] = ()
    induction: str | None = None

    def also(self, uses: tuple[LemmaUse, ...]) -> Help:
        """The same with more lemmas."""
        return Help(tuple(dict.fromkeys((*self.using, *uses))), self.induction)


@dataclass(frozen=True, slots=True)
class Found:
    """Values that satisfy all parts.

    Attributes:
        values: ground terms by variable.
        vouched: parts that the evaluator could not go through (a quantifier over an infinite set) and that the
            solver alone found to hold of the values.
    """

    values: Mapping[Variable, Term]
    vouched: tuple[Constraint, ...] = ()


@dataclass(frozen=True, slots=True)
class Impossible:
    """There are no such values: proved."""


@dataclass(frozen=True, slots=True)
class NotUpTo:
    """None were found where given sets and collections have at most *scope* elements; nothing is proved.

    *reason*: why the whole question was not answered.
    """

    scope: int
    reason: str


@dataclass(frozen=True, slots=True)
class Unanswered:
    """The solver gave up."""

    reason: str


@dataclass(frozen=True, slots=True)
class ProofClause:
    """That a predicate holds behind another, or that something is impossible.

    Attributes:
        source: the place whose predicate is assumed; None: at the beginning.
        target: the place whose predicate follows, of the state afterwards if there is a source; None: a contradiction.
        terms: what is assumed beside it, defined everywhere.
    """

    source: int | None
    target: int | None
    terms: tuple[Term, ...]


@dataclass(frozen=True, slots=True)
class Horn:
    """Clauses over one predicate for each of some places, that are to be found.

    Attributes:
        places: how many there are.
        variables: that the predicates speak of; those with the role ``before`` have a twin afterwards.
        clauses: what they have to satisfy.
    """

    places: int
    variables: tuple[Variable, ...]
    clauses: tuple[ProofClause, ...]

    def afterwards(self) -> tuple[Variable, ...]:
        """The variables as they are after a step; constants are the same."""
        return tuple(replace(v, role="after") if v.role == "before" else v for v in self.variables)


@dataclass(frozen=True, slots=True)
class Solution:
    """Predicates by place that are said to satisfy clauses."""

    places: tuple[Term, ...]


Answer: TypeAlias = Found | Impossible | NotUpTo | Unanswered


@dataclass(slots=True)
class SolverSettings:
    """How long and how the solver tries.

    Attributes:
        seconds: of the solver's work for one question, the bounded searches included. What the solver does in a second
            is a fixed number of its steps: on an ordinary machine that is a second or two, on a busy one more.
        limit: the seconds that have passed when an obligation is given up in any case; None: there is no such limit.
        scopes: the sizes that are tried when the whole question is not answered.
        seed: of the solver.
        deadline: when to stop altogether, on the solver's clock; None: never.
        smtlib: takes the name and the text of every query; None where nobody wants them.
        reasons: find out which lines each proof needed.
        glance: look for counterexamples of few and small values only, and prove nothing; "after" where that was done.
    """

    seconds: float = 10.0
    limit: float | None = None
    scopes: tuple[int, ...] = (1, 2, 3, 6)
    seed: int = 1
    deadline: float | None = None
    smtlib: list[tuple[str, str]] | None = field(default=None)
    reasons: bool = False
    glance: Literal["no", "only", "after"] = "no"


@dataclass(slots=True)
class Request:
    """What the process of the solver is asked.

    Attributes:
        verb: ``ask``, ``conflict``, ``core``, ``needed``, ``eliminate`` or ``solve``.
        what: a question, parts, a term, or clauses.
        seconds, scopes, seed: see :class:`SolverSettings`.
        name, first_query: what queries are called when they are written out, and the number of the first.
        smtlib: whether they are to be written out.
        subject: the number of what it is about; that itself where the process does not know it yet.
    """

    verb: str
    what: Any
    seconds: float
    scopes: tuple[int, ...]
    seed: int
    name: str = "query"
    smtlib: bool = False
    first_query: int = 0
    subject: int = 0
    specification: object = None
    model: object = None


@dataclass(frozen=True, slots=True)
class Failed:
    """There is no answer. *ours*: the mistake is one of this program, and the reason its traceback."""

    reason: str
    ours: bool = False
