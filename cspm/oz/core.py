"""What classes mean, ready for proof, search and code: typed terms, flattened classes.

The elaborator (:mod:`cspcheck.cspm.oz.typing.elaboration`) makes this from the tree. Everything after it works here:
names are tied, types are known, schemas are expanded, inheritance is flattened, generics are instantiated, ``let`` and
abbreviations are gone, decorations have become roles, and where an integer stands for a real, a sequence for a
function or a function for a relation, a coercion says so.

Types are the small monomorphic system below rather than the one of ISO Z, in which a sequence is a set of pairs:
an encoding or an evaluator can then choose the right representation by the type alone. What ISO Z says of values
is kept by the coercions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final, Literal, TypeAlias

from cspcheck.cspm.oz.signatures import OPERATORS as OPERATORS
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax

# --- types -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class BoolType:
    """Truth values, and predicates."""

    def __str__(self) -> str:
        return "bool"


@dataclass(frozen=True, slots=True)
class IntType:
    """Integers, without bounds."""

    def __str__(self) -> str:
        return "int"


@dataclass(frozen=True, slots=True)
class RealType:
    """Real numbers; their literals are fractions."""

    def __str__(self) -> str:
        return "real"


@dataclass(frozen=True, slots=True)
class GivenType:
    """A given set: nothing is known of its elements but that they are equal or not."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class FreeType:
    """A free type, defined in ``Specification.frees``. CSPm datatypes are free types too."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class TupleType:
    """Tuples; at least two items."""

    items: tuple[Type, ...]

    def __str__(self) -> str:
        return "(" + " cross ".join(map(str, self.items)) + ")"


@dataclass(frozen=True, slots=True)
class SetType:
    """Sets; a relation is a set of pairs."""

    element: Type

    def __str__(self) -> str:
        return f"power {self.element}"


@dataclass(frozen=True, slots=True)
class SequenceType:
    """Finite sequences, numbered from 1."""

    element: Type

    def __str__(self) -> str:
        return f"seq {self.element}"


@dataclass(frozen=True, slots=True)
class FunctionType:
    """Partial functions. Whether one is total, injective, ... is said by the carrier that it is taken from."""

    domain: Type
    range: Type

    def __str__(self) -> str:
        return f"({self.domain} pfun {self.range})"


@dataclass(frozen=True, slots=True)
class BagType:
    """Finite bags."""

    element: Type

    def __str__(self) -> str:
        return f"bag {self.element}"


@dataclass(frozen=True, slots=True)
class RecordType:
    """The record that a schema declares, defined in ``Specification.records``; fields in the order of the text."""

    name: str
    fields: tuple[tuple[str, Type], ...]

    def __str__(self) -> str:
        return self.name


Type: TypeAlias = (
    BoolType
    | IntType
    | RealType
    | GivenType
    | FreeType
    | TupleType
    | SetType
    | SequenceType
    | FunctionType
    | BagType
    | RecordType
)

BOOL: Final = BoolType()
INT: Final = IntType()
REAL: Final = RealType()

# --- terms -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Term:
    """A typed term; predicates have the type BOOL. Spans take no part in comparison."""

    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Constant(Term):
    """An integer (INT), a Fraction (REAL) or a truth value (BOOL)."""

    value: int | Fraction | bool


Role = Literal["before", "after", "input", "output", "simple", "constant", "bound"]


@dataclass(frozen=True, kw_only=True)
class Variable(Term):
    """A variable by its undecorated name and its role.

    ``before`` and ``after`` are a state variable and its primed twin; ``input``, ``output`` and ``simple`` are
    parameters of the operation; ``constant`` is a global constant or a constant of the class; ``bound`` belongs to a
    binder around, whose name is unique in the whole specification (``x%7``). In a retrieve relation the
    state variables of both classes have the role ``before`` and qualified names (``A.items``).
    """

    name: str
    role: Role


@dataclass(frozen=True, kw_only=True)
class Construct(Term):
    """A constructor of a free type, applied if it has an argument."""

    constructor: str
    argument: Term | None = None


@dataclass(frozen=True, kw_only=True)
class Record(Term):
    """A record by the values of its fields, in the order of its type."""

    values: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class Field(Term):
    """A field of a record."""

    record: Term
    name: str


@dataclass(frozen=True, kw_only=True)
class Apply(Term):
    """An operator of :data:`OPERATORS` applied to its operands."""

    operator: str
    operands: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Binder:
    """A bound variable: its unique name, its type, the set that it ranges over, and the name that was written."""

    name: str
    type: Type
    carrier: Term
    written: str


@dataclass(frozen=True, kw_only=True)
class Quantifier(Term):
    """``forall``: condition implies body for all values; ``exists``: both for some; ``exists1``: for exactly one."""

    kind: Literal["forall", "exists", "exists1"]
    binders: tuple[Binder, ...]
    condition: Term
    body: Term


@dataclass(frozen=True, kw_only=True)
class Comprehension(Term):
    """``set``: the values of body; ``lambda``: the function from the (tuple of) binders to body; ``mu``: body for
    the only values that satisfy the condition.
    """

    kind: Literal["set", "lambda", "mu"]
    binders: tuple[Binder, ...]
    condition: Term
    body: Term


@dataclass(frozen=True, kw_only=True)
class If(Term):
    """``if test then a else b``; a and b have the type of the whole."""

    test: Term
    then: Term
    otherwise: Term


def conjunction(terms: tuple[Term, ...], span: Span | None = None) -> Term:
    """All of *terms*: true for none, the term itself for one."""
    if not terms:
        return Constant(type=BOOL, value=True, span=span)
    return terms[0] if len(terms) == 1 else Apply(type=BOOL, operator="and", operands=terms, span=span)


def parts(term: Term) -> Iterator[Term]:
    """The immediate subterms of a term, those of binders' carriers included."""
    match term:
        case Construct():
            if term.argument is not None:
                yield term.argument
        case Record():
            yield from term.values
        case Field():
            yield term.record
        case Apply():
            yield from term.operands
        case Quantifier() | Comprehension():
            for binder in term.binders:
                yield binder.carrier
            yield term.condition
            yield term.body
        case If():
            yield term.test
            yield term.then
            yield term.otherwise


# --- classes -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Declared:
    """A state variable, constant or field: its name, type, the set that its values are taken from, its place."""

    name: str
    type: Type
    carrier: Term
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class LemmaUse:
    """A lemma or law that helps a proof.

    Attributes:
        name, span: of the lemma, where it is used.
        arguments: values for the variables of its outermost ``forall``, in their order; none: for whatever fits.
    """

    name: str
    arguments: tuple[Term, ...] = ()
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Lemma:
    """A predicate that is to be proved, and may then be used in proofs.

    Attributes:
        name, span: of the lemma.
        term: the predicate over constants and ``before`` variables; with these it is claimed of every state.
        givens: the given sets that stand for its generic parameters.
        using: the lemmas and laws that its own proof may use; arguments speak of its outermost variables.
        induction: the variable that it is proved by induction on, as it is written; None for none.
    """

    name: str
    term: Term
    givens: tuple[str, ...] = ()
    using: tuple[LemmaUse, ...] = ()
    induction: str | None = None
    span: Span | None = field(default=None, compare=False, repr=False)


ParameterKind = Literal["input", "output", "simple"]


@dataclass(frozen=True, kw_only=True)
class Parameter(Declared):
    """A parameter of a channel or of an operation, without its decoration.

    ``kind`` is ``input`` for ``?``, ``output`` for ``!``, ``simple`` for none; on a channel that several classes
    share, the kind is as the class in question sees it.
    """

    kind: ParameterKind


@dataclass(frozen=True, kw_only=True)
class Channel:
    """A channel or method of a class; the fields of its events are the parameters, in this order.

    ``kind``: ``chan`` is shared by name with other classes and with the script; ``method`` is the class's own,
    hidden in its process unless an assertion's interface lists it; ``local_chan`` is hidden always; ``operation`` is
    one of plain Object-Z that is visible and the class's own, because other classes have operations of that name with
    other parameters; where they agree it is a ``chan``.
    """

    name: str
    kind: Literal["chan", "method", "local_chan", "operation"]
    parameters: tuple[Parameter, ...]
    owner: str
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Operation:
    """What an event does to the data.

    Attributes:
        name: the channel or method.
        form: ``com`` (one schema: blocked outside its precondition), ``guarded`` (enable and effect: blocked
            outside the guard, divergent where the guard holds and the effect is impossible), ``effect`` (an effect
            without enable: guard true), ``enable`` (a guard alone: nothing changes).
        parameters: those of the schema; they agree with the channel's.
        delta: the primary state variables that may change.
        guard: conjuncts over before, input and simple variables; empty for ``com`` and ``effect``.
        effect: conjuncts over all roles. That variables outside delta keep their values, and that parameters and
            after-values lie in their carriers, is *not* among them.
        spans: of the schemas that it was made from.
        using: lemmas and laws for the proofs about it; arguments are over all roles.
    """

    name: str
    form: Literal["com", "guarded", "effect", "enable"]
    parameters: tuple[Parameter, ...]
    delta: tuple[str, ...]
    guard: tuple[Term, ...]
    effect: tuple[Term, ...]
    spans: tuple[Span, ...] = field(default=(), compare=False, repr=False)
    using: tuple[LemmaUse, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ProcessPart:
    """The process equations of one class: the class itself, or a parent with the names as the child sees them."""

    owner: str
    equations: tuple[syntax.Declaration, ...]


@dataclass(frozen=True, kw_only=True)
class ClassModel:
    """A class with what it inherits.

    Attributes:
        name, span: of the class.
        parents: direct parents.
        generics: names of generic parameters; they are given types inside a class that is not instantiated.
        visibility: names, or None for all.
        channels: by name, inherited ones first.
        constants, axioms: the class's own; those of the specification hold as well.
        primary, secondary: state variables.
        invariant: conjuncts over before variables, without the carriers.
        initial: conjuncts over before variables of the initial state; None where there is no INIT schema.
        operations: by channel name.
        processes: CSP parts to be composed in parallel on their common events; a class without ``main`` has none.
        lemmas: by name, inherited ones first.
    """

    name: str
    span: Span = field(compare=False, repr=False)
    parents: tuple[str, ...] = ()
    generics: tuple[str, ...] = ()
    visibility: tuple[str, ...] | None = None
    channels: Mapping[str, Channel] = field(default_factory=dict)
    constants: tuple[Declared, ...] = ()
    axioms: tuple[Term, ...] = ()
    primary: tuple[Declared, ...] = ()
    secondary: tuple[Declared, ...] = ()
    invariant: tuple[Term, ...] = ()
    initial: tuple[Term, ...] | None = None
    operations: Mapping[str, Operation] = field(default_factory=dict)
    processes: tuple[ProcessPart, ...] = ()
    lemmas: Mapping[str, Lemma] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class FreeDefinition:
    """A free type: its constructors with the carrier of their argument (None for constants), in order."""

    name: str
    branches: tuple[tuple[str, Term | None], ...]
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class RecordDefinition:
    """A schema: fields, the predicate on them, and its INIT (None where it has none).

    Predicates speak of the fields as ``bound`` variables with the fields' plain names.
    """

    name: str
    fields: tuple[Declared, ...]
    predicates: tuple[Term, ...]
    initial: tuple[Term, ...] | None
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class RetrieveRelation:
    """Conjuncts over the variables of both classes, by qualified names with the role ``before``."""

    name: str
    abstract: str
    concrete: str
    predicates: tuple[Term, ...]
    span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class FiniteReading:
    """What a search takes instead of a wide carrier: a finite set of values of its type, or a bound.

    ``subject`` is the carrier as an elaborated term (``Real``, ``Nat``, ``All`` of a given type, ``seq ...``, or
    the body of the abbreviation that was named); ``bound`` is the number of elements of a given set or the greatest
    length of a collection; exactly one of ``values`` and ``bound`` is there. ``whole``: a given set has these elements
    and no others, as in a world that a proof looks at.
    """

    subject: Term
    text: str
    values: Term | None
    bound: int | None
    span: Span = field(compare=False, repr=False)
    whole: bool = False


@dataclass(frozen=True, kw_only=True)
class Specification:
    """The Object-Z part of a script."""

    givens: Mapping[str, Span] = field(default_factory=dict, compare=False)
    frees: Mapping[str, FreeDefinition] = field(default_factory=dict)
    records: Mapping[str, RecordDefinition] = field(default_factory=dict)
    constants: tuple[Declared, ...] = ()
    axioms: tuple[Term, ...] = ()
    classes: Mapping[str, ClassModel] = field(default_factory=dict)
    retrieves: Mapping[str, RetrieveRelation] = field(default_factory=dict)
    readings: tuple[FiniteReading, ...] = ()
    lemmas: Mapping[str, Lemma] = field(default_factory=dict)
    control: bool = False
    """Whether the script asks for the control view."""
