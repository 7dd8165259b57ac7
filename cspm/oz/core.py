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


OPERATORS: Final[Mapping[str, str]] = {
    # logic
    "not": "bool -> bool",
    "and": "bool, ... -> bool (two or more)",
    "or": "bool, ... -> bool (two or more)",
    "implies": "bool, bool -> bool",
    "iff": "bool, bool -> bool",
    # relations on any type; operands have one type
    "equal": "t, t -> bool",
    "in": "t, set t -> bool (the set may be any of the carriers below)",
    # numbers: both operands int or both real
    "less": "n, n -> bool",
    "at_most": "n, n -> bool",
    "plus": "n, n -> n",
    "minus": "n, n -> n",
    "times": "n, n -> n",
    "negate": "n -> n",
    "abs": "n -> n",
    "divide": "real, real -> real (undefined for zero)",
    "div": "int, int -> int (rounds down; undefined for zero)",
    "mod": "int, int -> int (sign of the divisor; undefined for zero)",
    "min": "set n -> n (undefined for the empty set)",
    "max": "set n -> n (undefined for the empty set)",
    # coercions
    "int_to_real": "int -> real",
    "floor": "real -> int",
    "sequence_to_function": "seq t -> int pfun t",
    "function_to_relation": "(a pfun b) -> set (a, b)",
    "bag_to_function": "bag t -> t pfun int",
    # tuples
    "tuple": "a, b, ... -> (a, b, ...)",
    "item": "tuple, int literal (from 0) -> component",
    # sets
    "set": "t, ... -> set t (a display; no operands is the empty set of the term's type)",
    "range": "int, int -> set int (m..n)",
    "union": "set t, set t -> set t",
    "inter": "set t, set t -> set t",
    "diff": "set t, set t -> set t",
    "symdiff": "set t, set t -> set t",
    "Union": "set set t -> set t",
    "Inter": "set set t -> set t",
    "subset": "set t, set t -> bool (subset or equal)",
    "proper_subset": "set t, set t -> bool",
    "disjoint": "set t, ... -> bool (pairwise)",
    "partition": "set t, set t, ... -> bool (the first is partitioned by the others)",
    "card": "set t -> int (undefined for infinite sets)",
    # carriers: sets that may be infinite
    "Bool": "-> set bool",
    "Int": "-> set int",
    "Nat": "-> set int",
    "Nat1": "-> set int",
    "Real": "-> set real",
    "All": "-> set t (all of a given or free type, as the term's type says)",
    "Records": "-> set record (all values that the schema's declaration and predicate allow)",
    "power": "set t -> set set t",
    "power1": "set t -> set set t (not the empty one)",
    "finset": "set t -> set set t",
    "finset1": "set t -> set set t",
    "cross": "set a, set b, ... -> set (a, b, ...)",
    "seq": "set t -> set seq t",
    "seq1": "set t -> set seq t",
    "iseq": "set t -> set seq t",
    "bag": "set t -> set bag t",
    "rel": "set a, set b -> set set (a, b)",
    "pfun": "set a, set b -> set (a pfun b)",
    "fun": "set a, set b -> set (a pfun b)",
    "pinj": "set a, set b -> set (a pfun b)",
    "inj": "set a, set b -> set (a pfun b)",
    "psurj": "set a, set b -> set (a pfun b)",
    "surj": "set a, set b -> set (a pfun b)",
    "bij": "set a, set b -> set (a pfun b)",
    "ffun": "set a, set b -> set (a pfun b)",
    "finj": "set a, set b -> set (a pfun b)",
    # relations (set of pairs) and functions; those marked * take and give functions as well
    "dom": "* r -> set a",
    "ran": "* r -> set b",
    "id": "set a -> set (a, a)",
    "compose": "* r, s -> relation (r then s)",
    "dom_restrict": "* set a, r -> r",
    "ran_restrict": "* r, set b -> r",
    "dom_subtract": "* set a, r -> r",
    "ran_subtract": "* r, set b -> r",
    "inverse": "relation -> relation",
    "image": "* r, set a -> set b",
    "override": "* r, r -> r",
    "closure": "relation -> relation (transitive)",
    "reflexive_closure": "relation -> relation (reflexive and transitive, on its own field)",
    "apply": "function, a -> b; sequence, int -> t; bag, t -> int (functions and sequences: undefined elsewhere)",
    "function": "(a, b), ... -> a pfun b (a display of maplets with distinct first components)",
    # sequences
    "sequence": "t, ... -> seq t (a display)",
    "length": "seq t -> int",
    "concat": "seq t, seq t -> seq t",
    "head": "seq t -> t (undefined for the empty sequence; so are the next three)",
    "tail": "seq t -> seq t",
    "last": "seq t -> t",
    "front": "seq t -> seq t",
    "rev": "seq t -> seq t",
    "filter": "seq t, set t -> seq t",
    "extract": "set int, seq t -> seq t",
    "squash": "int pfun t -> seq t",
    "prefix": "seq t, seq t -> bool",
    "suffix": "seq t, seq t -> bool",
    "infix": "seq t, seq t -> bool",
    "flatten": "seq seq t -> seq t",
    # bags
    "bag_display": "t, ... -> bag t",
    "count": "bag t, t -> int",
    "bag_union": "bag t, bag t -> bag t",
    "in_bag": "t, bag t -> bool",
    "items": "seq t -> bag t",
    # records
    "init": "record -> bool (the record satisfies the INIT of its schema)",
}
"""Every operator of core terms with its signature. Where an operand is outside what is said, a term is undefined:
that its operands are inside is a proof obligation, and evaluating it fails.
"""


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
    """

    name: str
    form: Literal["com", "guarded", "effect", "enable"]
    parameters: tuple[Parameter, ...]
    delta: tuple[str, ...]
    guard: tuple[Term, ...]
    effect: tuple[Term, ...]
    spans: tuple[Span, ...] = field(default=(), compare=False, repr=False)


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
    control: bool = False
    """Whether the script asks for the control view."""
