"""Data refinement: that one class simulates another under a retrieve relation, in the blocking reading.

Downward: the rules of semantics for classes with guards: applicability in both directions, because outside its
precondition an operation is refused, and a refusal is observable. Upward: one abstract state must answer for all
operations and inputs at once; asked for each operation by itself, as for relations, the rule accepts what failures
refinement rejects (Bolton and Davies, *Refinement in Object-Z and CSP*, IFM 2002).

The rules are about the data. The CSP parts of the classes are compared by an assertion of their own; the two together
give the refinement of the classes, because parallel composition and hiding are monotonic.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.lemmas import claims_of
from cspcheck.checker.proof.prover import Prover, values_of
from cspcheck.checker.proof.question import (
    Answer,
    Constraint,
    Found,
    Help,
    Impossible,
    NotUpTo,
    SolverSettings,
    Unanswered,
)
from cspcheck.checker.proof.situation import Situation, parameter_variable, state_variable
from cspcheck.checker.proof.terms import (
    TRUE,
    Key,
    Unknown,
    all_of,
    bound_by,
    equal,
    implication,
    is_true,
    primed,
    quantified,
    renamed,
    substitute,
    variables,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import ClassModel, Declared, Operation, Parameter, Term, Variable
from cspcheck.cspm.oz.writing.core_text import text
from cspcheck.cspm.source import Span

RULES = (
    "retrieve relation consistent",
    "retrieve relation total",
    "channels",
    "initial states",
    "applicability",
    "definedness",
    "correctness",
    "totality",
)
"""The rules by their names; the last is one of upward simulation alone."""


@dataclass(frozen=True, slots=True)
class Relation:
    """What relates the states of an abstract and a concrete class.

    Attributes:
        abstract, concrete: names of the classes.
        predicates: over both states, by qualified names with the role ``before``.
        inherits: the concrete class is a subclass: constants are the same, and operations of its own may be there.
    """

    abstract: str
    concrete: str
    predicates: tuple[Term, ...]
    inherits: bool = False
    span: Span | None = None


def retrieve(relation: core.RetrieveRelation) -> Relation:
    """The relation that a script gives."""
    return Relation(relation.abstract, relation.concrete, relation.predicates, span=relation.span)


def projection(specification: core.Specification, parent: str, child: str) -> Relation:
    """The relation of a subclass to its parent: the variables that the parent has are equal.

    Raises:
        LookupError: a variable of the parent is not there under its name.
    """
    old, new = specification.classes[parent], specification.classes[child]
    mine = {d.name: d for d in (*new.primary, *new.secondary)}
    equations: list[Term] = []
    for declared in (*old.primary, *old.secondary):
        own = mine.get(declared.name)
        if own is None or own.type != declared.type:
            raise LookupError(declared.name)
        left = Variable(type=declared.type, name=f"{parent}.{declared.name}", role="before")
        equations.append(equal(left, replace(left, name=f"{child}.{declared.name}")))
    return Relation(parent, child, tuple(equations), inherits=True)


class Simulation:
    """The rules for one pair of classes."""

    def __init__(
        self, specification: core.Specification, relation: Relation, settings: SolverSettings | None = None
    ) -> None:
        # What the relation says of constants alone is taken for granted: it says which systems are compared.
        fixed = tuple(term for term in relation.predicates if all(role == "constant" for _, role in variables(term)))
        predicates = tuple(term for term in relation.predicates if term not in fixed)
        self.relation = relation = replace(relation, predicates=predicates)
        old, new = specification.classes[relation.abstract], specification.classes[relation.concrete]
        abstract = qualified(old, not relation.inherits)
        concrete = qualified(with_parameters_of(new, old), not relation.inherits)
        self.abstract = Situation(specification, abstract)
        self.concrete = Situation(specification, concrete)
        both = replace(
            concrete,
            constants=_once((*abstract.constants, *concrete.constants)),
            axioms=tuple(dict.fromkeys((*abstract.axioms, *concrete.axioms, *fixed))),
        )
        lemmas = {**claims_of(self.abstract), **claims_of(self.concrete)}
        self.prover = Prover(specification, both, settings, claims=lemmas)
        self.help = Help()
        """What the user says that the proofs need, beside what operations say themselves."""
        self._old, self._new = old, new
        self._start = self.prover.clock()
        self.subject = f"{relation.abstract} [OZ= {relation.concrete}"

    # --- the relation -------------------------------------------------------------------------------------------------

    def related(self) -> tuple[Constraint, ...]:
        """That the states before are related."""
        return tuple(Constraint(term, "retrieve relation", term.span) for term in self.relation.predicates)

    def related_after(self) -> tuple[Constraint, ...]:
        """That the states afterwards are related."""
        terms = primed(self.relation.predicates)
        return tuple(
            Constraint(term, "retrieve relation afterwards", old.span)
            for term, old in zip(terms, self.relation.predicates, strict=True)
        )

    def sane(self) -> Iterator[Finding]:
        """That the relation relates some states, and every concrete one."""
        parts = [*self.abstract.state(), *self.concrete.state(), *self.related()]
        answer = self.prover.find(parts, self._states())
        if isinstance(answer, Impossible):
            lines = self.prover.lines(parts)
            yield self._finding(
                "retrieve relation consistent", "refuted", message="the relation relates no states", lines=lines
            )
            return
        status = "proved" if isinstance(answer, Found) else "unknown"
        yield self._finding("retrieve relation consistent", status, message=_reason(answer))
        goal = self._some_abstract((*self.abstract.state(), *self.related()))
        yield self._universal(
            "retrieve relation total",
            self.prover.refutes(self.concrete.state(), goal, self.concrete.state_variables()),
            "a concrete state is related to no abstract one",
            severity="warning",
        )

    # --- downward -----------------------------------------------------------------------------------------------------

    def downward(self) -> Iterator[Finding]:
        """The rules of downward simulation."""
        self.prover.help = self.help
        yield from self.sane()
        yield from self.matching()
        premises = [*self.concrete.state(), *self.concrete.initial()]
        goal = self._some_abstract((*self.abstract.state(), *self.abstract.initial(), *self.related()))
        yield self._universal(
            "initial states",
            self.prover.refutes(premises, goal, self.concrete.state_variables()),
            "a concrete initial state is related to no abstract initial state",
        )
        for old, new in self.pairs():
            self.prover.help = self.help.also((*old.using, *new.using))
            yield from self._downward(old, new)
        yield from self._own_operations()

    def _downward(self, old: Operation, new: Operation) -> Iterator[Finding]:
        known = [*self.abstract.state(), *self.concrete.state(), *self.related(), *self.concrete.inputs(new)]
        shown = (*self._states(), *self._parameters(new, outputs=False))
        enabled_old, enabled_new = self.abstract.enabled(old), self.concrete.enabled(new)
        yield self._universal(
            "applicability",
            self.prover.refutes([*known, Constraint(enabled_old, "abstract")], enabled_new, shown),
            f"`{self.relation.abstract}` offers the operation here, and `{self.relation.concrete}` refuses it",
            old,
        )
        yield self._universal(
            "applicability",
            self.prover.refutes([*known, Constraint(enabled_new, "concrete")], enabled_old, shown),
            f"`{self.relation.concrete}` offers the operation here, and `{self.relation.abstract}` refuses it",
            old,
            detail="back",
        )
        premises = [*known]
        if old.form in ("guarded", "effect"):
            defined = Constraint(self.abstract.possible(old), "abstract effect possible")
            premises += [Constraint(enabled_old, "abstract guard"), defined]
            yield self._universal(
                "definedness",
                self.prover.refutes(premises, self.concrete.possible(new), shown),
                f"the effect is possible for `{self.relation.abstract}`, and `{self.relation.concrete}` diverges",
                old,
            )
        elif new.form in ("guarded", "effect"):
            yield self._universal(
                "definedness",
                self.prover.refutes(
                    [*known, Constraint(enabled_new, "concrete guard")], self.concrete.possible(new), shown
                ),
                f"`{self.relation.concrete}` diverges",
                old,
            )
        step = [part for part in self.concrete.step(new) if part not in premises]
        goal = self._some_step(old)
        yield self._universal(
            "correctness",
            self.prover.refutes([*premises, *step], goal, self._step_variables(new)),
            f"`{self.relation.abstract}` has no step that matches this one of `{self.relation.concrete}`",
            old,
        )

    def _some_step(self, old: Operation) -> Term:
        """That the abstract class has a step to a state related to the concrete after-state."""
        unknowns, parts = self.abstract.existential(old, outputs=False)
        same = self.abstract.unchanged(old)
        related = [substitute(part.term, same) for part in self.related_after()]
        outputs = [part.term for part in self.abstract.outputs(old)]
        guard = [part.term for part in self.abstract.guard(old)]
        binders, table = bound_by(unknowns)
        body = all_of([*guard, *[substitute(p.term, table) for p in parts], *[substitute(t, table) for t in related]])
        return quantified("exists", binders, TRUE, all_of([*outputs, body]))

    def _own_operations(self) -> Iterator[Finding]:
        """Operations that only a subclass has: steps that its parent does not see."""
        if not self.relation.inherits:
            return
        for name, new in self.concrete.model.operations.items():
            if name in self.abstract.model.channels:
                continue
            known = [*self.abstract.state(), *self.related(), *self.concrete.step(new)]
            same: dict[Key, Term] = {(d.name, "after"): state_variable(d, "before") for d in self.abstract.variables}
            goal = all_of(substitute(part.term, same) for part in self.related_after())
            yield self._universal(
                "correctness",
                self.prover.refutes(known, goal, self._step_variables(new)),
                f"a new operation changes the state that `{self.relation.abstract}` has",
                new,
            )

    # --- upward -------------------------------------------------------------------------------------------------------

    def upward(self) -> Iterator[Finding]:
        """The rules of upward simulation, with one abstract state for all operations and inputs."""
        self.prover.help = self.help
        yield from self.sane()
        yield from self.matching()
        pairs = list(self.pairs())
        for situation, operation in [s for a, c in pairs for s in ((self.abstract, a), (self.concrete, c))]:
            if operation.form in ("guarded", "effect"):
                known = [*situation.state(), *situation.inputs(operation), *situation.guard(operation)]
                answer = self.prover.refutes(known, situation.possible(operation))
                if not isinstance(answer, Impossible):
                    yield self._finding(
                        "definedness",
                        "unknown",
                        operation,
                        message="upward simulation is for classes whose guards cover their effects",
                    )
                    return
        premises = [*self.abstract.state(), *self.concrete.state(), *self.concrete.initial(), *self.related()]
        yield self._universal(
            "initial states",
            self.prover.refutes(premises, all_of(p.term for p in self.abstract.initial()), self._states()),
            "an abstract state that is related to a concrete initial state is not initial",
        )
        goal = self._some_abstract((*self.abstract.state(), *self.related()))
        yield self._universal(
            "totality",
            self.prover.refutes(self.concrete.state(), goal, self.concrete.state_variables()),
            "a concrete state is related to no abstract one",
        )
        yield self._universal(
            "applicability",
            self.prover.refutes(self.concrete.state(), self._witness(pairs), self.concrete.state_variables()),
            "no related abstract state refuses everything that this concrete state refuses",
            detail="all operations",
        )
        for old, new in pairs:
            self.prover.help = self.help.also((*old.using, *new.using))
            step = [*self.concrete.step(new), *self.abstract.state("after"), *self.related_after()]
            yield self._universal(
                "correctness",
                self.prover.refutes(step, self._some_source(old), self._step_variables(new, abstract="after")),
                f"`{self.relation.abstract}` has no step to the state after this one of `{self.relation.concrete}`",
                old,
            )

    def _witness(self, pairs: list[tuple[Operation, Operation]]) -> Term:
        """That some related abstract state enables no more than the concrete state, for all operations and inputs."""
        rules: list[Term] = []
        for old, new in pairs:
            enabled_old, enabled_new = self.abstract.enabled(old), self.concrete.enabled(new)
            inputs = [Unknown(parameter_variable(p), p.carrier) for p in new.parameters if p.kind != "output"]
            binders, table = bound_by(inputs)
            claim = implication(substitute(enabled_old, table), substitute(enabled_new, table))
            if not is_true(claim):
                rules.append(quantified("forall", binders, TRUE, claim))
        parts = (*self.abstract.state(), *self.related(), *[Constraint(rule, "applicability") for rule in rules])
        return self._some_abstract(parts)

    def _some_source(self, old: Operation) -> Term:
        """That the abstract class has a step from a state related to the concrete one before."""
        step = [
            *self.abstract.state(),
            *self.related(),
            *self.abstract.guard(old),
            *self.abstract.effect(old),
            *self.abstract.frame(old),
        ]
        outputs = [part.term for part in self.abstract.outputs(old)]
        return all_of([*outputs, self._some_abstract(step)])

    # --- tools --------------------------------------------------------------------------------------------------------

    def pairs(self) -> Iterator[tuple[Operation, Operation]]:
        """The operations of both classes by channel; a channel without schema does nothing to the data."""
        for name in self.abstract.model.channels:
            if name in self.concrete.model.channels:
                old, new = (_operation(s.model, name) for s in (self.abstract, self.concrete))
                if name in self.abstract.model.operations or name in self.concrete.model.operations:
                    yield old, new

    def matching(self) -> Iterator[Finding]:
        """That both classes have the same channels."""
        old, new = self._old.channels, self._new.channels
        for name, channel in old.items():
            if name not in new:
                yield self._channels(channel, f"`{self.relation.concrete}` does not have the channel `{name}`")
            elif [p.type for p in channel.parameters] != [p.type for p in new[name].parameters]:
                yield self._channels(channel, f"the parameters of `{name}` differ in their types")
        for name, channel in new.items():
            if name not in old and not self.relation.inherits:
                yield self._channels(channel, f"`{self.relation.abstract}` does not have the channel `{name}`")

    def _channels(self, channel: core.Channel, message: str) -> Finding:
        return self._finding("channels", "refuted", message=message, span=channel.span)

    def _some_abstract(self, parts: Iterable[Constraint]) -> Term:
        """That some values of the abstract state satisfy parts."""
        unknowns = [Unknown(state_variable(d, "before"), d.carrier) for d in self.abstract.variables]
        binders, table = bound_by(unknowns)
        return quantified("exists", binders, TRUE, all_of(substitute(p.term, table) for p in parts))

    def _states(self) -> tuple[Variable, ...]:
        return (*self.abstract.state_variables(), *self.concrete.state_variables())

    def _parameters(self, operation: Operation, *, outputs: bool = True) -> tuple[Variable, ...]:
        return tuple(parameter_variable(p) for p in operation.parameters if outputs or p.kind != "output")

    def _step_variables(self, operation: Operation, *, abstract: str = "before") -> tuple[Variable, ...]:
        states = [
            *(self.abstract.state_variables() if abstract == "before" else ()),
            *self.concrete.state_variables(),
            *self._parameters(operation),
            *self.concrete.state_variables("after"),
            *(self.abstract.state_variables("after") if abstract == "after" else ()),
        ]
        return tuple(states)

    def _universal(
        self,
        rule: str,
        answer: Answer,
        message: str,
        operation: Operation | None = None,
        **more: object,
    ) -> Finding:
        match answer:
            case Impossible():
                return self._finding(rule, "proved", operation, **more)
            case Found():
                vouched = tuple(text(part.term) for part in answer.vouched)
                return self._finding(
                    rule, "refuted", operation, message=message, values=values_of(answer), vouched=vouched, **more
                )
            case NotUpTo(scope=scope, reason=reason):
                said = f"not proved ({reason}); no counterexample with at most {scope} elements"
                return self._finding(rule, "bounded", operation, message=said, scope=scope, **more)
            case Unanswered(reason=reason):
                return self._finding(rule, "unknown", operation, message=reason, **more)

    def _finding(self, rule: str, status: str, operation: Operation | None = None, **more: object) -> Finding:
        now = self.prover.clock()
        seconds = now - self._start
        hypotheses, missing = self.prover.take_help()
        used = self.prover.reasons()
        self._start = self.prover.clock()
        more.setdefault("span", self.relation.span)
        name = operation.name if operation is not None else None
        return Finding(
            obligation=rule,
            subject=self.subject,
            operation=name,
            status=status,  # type: ignore[arg-type]
            seconds=seconds,
            hypotheses=hypotheses,
            missing=missing,
            used=used if status == "proved" and "values" not in more else None,
            **more,  # type: ignore[arg-type]
        )


def _reason(answer: Answer) -> str:
    match answer:
        case NotUpTo(reason=reason) | Unanswered(reason=reason):
            return reason
    return ""


def _operation(model: ClassModel, name: str) -> Operation:
    """The operation of a channel; where the class has no schema for it, the data do not restrict it."""
    found = model.operations.get(name)
    if found is not None:
        return found
    channel = model.channels[name]
    return Operation(name=name, form="enable", parameters=channel.parameters, delta=(), guard=(), effect=())


def _once(declared: tuple[Declared, ...]) -> tuple[Declared, ...]:
    return tuple({d.name: d for d in declared}.values())


# --- two classes in one scope -----------------------------------------------------------------------------------------


def qualified(model: ClassModel, constants: bool) -> ClassModel:
    """The class with its variables (and with *constants* its own constants) called ``Class.variable``."""
    states = {d.name for d in (*model.primary, *model.secondary)}
    own = {d.name for d in model.constants} if constants else set()

    def name(plain: str) -> str:
        return f"{model.name}.{plain}"

    def change(variable: Variable) -> Variable | None:
        if variable.role in ("before", "after") and variable.name in states:
            return replace(variable, name=name(variable.name))
        if variable.role == "constant" and variable.name in own:
            return replace(variable, name=name(variable.name))
        return None

    def terms(old: tuple[Term, ...]) -> tuple[Term, ...]:
        return renamed(old, change)

    def declared(old: tuple[Declared, ...], *, rename: bool) -> tuple[Declared, ...]:
        return tuple(replace(d, name=name(d.name) if rename else d.name, carrier=terms((d.carrier,))[0]) for d in old)

    operations = {
        key: replace(
            operation,
            parameters=_parameters_with(operation.parameters, terms),
            delta=tuple(map(name, operation.delta)),
            guard=terms(operation.guard),
            effect=terms(operation.effect),
            using=tuple(replace(use, arguments=terms(use.arguments)) for use in operation.using),
        )
        for key, operation in model.operations.items()
    }
    channels = {
        key: replace(channel, parameters=_parameters_with(channel.parameters, terms))
        for key, channel in model.channels.items()
    }
    return replace(
        model,
        channels=channels,
        constants=declared(model.constants, rename=constants),
        axioms=terms(model.axioms),
        primary=declared(model.primary, rename=True),
        secondary=declared(model.secondary, rename=True),
        invariant=terms(model.invariant),
        initial=None if model.initial is None else terms(model.initial),
        operations=operations,
        lemmas={
            name(n): replace(lemma, name=name(n), term=terms((lemma.term,))[0]) for n, lemma in model.lemmas.items()
        },
    )


def _parameters_with(parameters: tuple[Parameter, ...], terms: object) -> tuple[Parameter, ...]:
    return tuple(replace(p, carrier=terms((p.carrier,))[0]) for p in parameters)  # type: ignore[operator]


def with_parameters_of(model: ClassModel, other: ClassModel) -> ClassModel:
    """The class with the parameters of its operations called as those of another class, by position in the channel."""
    operations = {}
    channels = dict(model.channels)
    for name, operation in model.operations.items():
        mine, theirs = model.channels.get(name), other.channels.get(name)
        if mine is None or theirs is None or len(mine.parameters) != len(theirs.parameters):
            operations[name] = operation
            continue
        table: dict[tuple[str, str], Parameter] = {
            (p.name, p.kind): q for p, q in zip(mine.parameters, theirs.parameters, strict=True)
        }

        def change(variable: Variable, table: dict[tuple[str, str], Parameter] = table) -> Variable | None:
            twin = table.get((variable.name, variable.role))
            return None if twin is None else replace(variable, name=twin.name)

        operations[name] = replace(
            operation,
            parameters=tuple(
                replace(p, name=table[p.name, p.kind].name if (p.name, p.kind) in table else p.name)
                for p in operation.parameters
            ),
            guard=renamed(operation.guard, change),
            effect=renamed(operation.effect, change),
            using=tuple(replace(use, arguments=renamed(use.arguments, change)) for use in operation.using),
        )
        channels[name] = replace(
            mine,
            parameters=tuple(replace(p, name=q.name) for p, q in zip(mine.parameters, theirs.parameters, strict=True)),
        )
    return replace(model, operations=operations, channels=channels)


def refinement(
    specification: core.Specification,
    relation: Relation,
    *,
    upward: bool = False,
    settings: SolverSettings | None = None,
) -> Iterator[Finding]:
    """The findings for ``A [OZ= C via R``."""
    simulation = Simulation(specification, relation, settings)
    return simulation.upward() if upward else simulation.downward()
