"""The syntax tree of the Object-Z part of a script, as written: in the text notation or in LaTeX markup.

Both notations give the same nodes. Operators carry one canonical name whatever their spelling (``in`` for ``in``
and ``∈``), so that trees compare equal when texts mean the same. Paragraphs are declarations of the script and
stand among those of CSPm; the process equations of a class are ordinary CSPm declarations.

What a tree means, with types and flattened inheritance, is said in :mod:`cspcheck.cspm.oz.core`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, Literal

from cspcheck.cspm.syntax.tree import Assertion, Declaration, NameDeclaration, Node, Paragraph as Paragraph


class Term(Node):
    """An expression or a predicate; which of the two a term is, is found with its type."""


# --- terms -----------------------------------------------------------------------------------------------------

Decoration = Literal["", "'", "?", "!"]


@dataclass(frozen=True, kw_only=True)
class Reference(Term):
    """``x``, ``x'``, ``x?``, ``x!``: a name with its decoration; also ``nat`` and other names of the toolkit.

    ``arguments`` are the generic actual parameters of ``Stack[Int]``.
    """

    name: str
    decoration: Decoration = ""
    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Number(Term):
    """``10`` (an int) or ``10.0`` (a Fraction, also where it is whole: the point makes it a real)."""

    value: int | Fraction


@dataclass(frozen=True, kw_only=True)
class Truth(Term):
    """``true``, ``false``."""

    value: bool


@dataclass(frozen=True, kw_only=True)
class Grouped(Term):
    """``(e)``: kept so that what is printed looks as it was written; every other phase looks through it."""

    inner: Term


def bare(term: Term) -> Term:
    """What brackets stand around, however many; a term without brackets itself."""
    while isinstance(term, Grouped):
        term = term.inner
    return term


@dataclass(frozen=True, kw_only=True)
class Operator(Term):
    """An operator of the toolkit applied to its operands: ``a + b``, ``dom f``, ``s ^ t``, ``p and q``, ``r~``.

    ``name`` is canonical, see :mod:`cspcheck.cspm.oz.reading.operators`.
    """

    name: str
    operands: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class Chain(Term):
    """``0 <= x < 10``: relations between neighbours, all of which hold. One relation is a chain of two operands."""

    relations: tuple[str, ...]
    operands: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class Application(Term):
    """``f(x)`` or ``f x``; ``f(x, y)`` is the application to a tuple. ``bracketed`` remembers the writing."""

    function: Term
    argument: Term
    bracketed: bool = True


@dataclass(frozen=True, kw_only=True)
class Selection(Term):
    """``ctrlData.vx``: a component of a record; ``ctrlData.INIT``: the record is in its initial state."""

    record: Term
    field: str
    decoration: Decoration = ""


@dataclass(frozen=True, kw_only=True)
class Display(Term):
    """``(a, b)``, ``{a, b}``, ``<a, b>`` and the bag ``[[a, b]]``."""

    kind: Literal["tuple", "set", "sequence", "bag"]
    items: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class BindingDisplay(Term):
    """``(| vx == 0, vy == 1 |)``: a record by its components."""

    fields: tuple[tuple[NameDeclaration, Term], ...]


@dataclass(frozen=True, kw_only=True)
class Declared(Node):
    """A name in a declaration, with its decoration."""

    name: str
    decoration: Decoration = ""


@dataclass(frozen=True, kw_only=True)
class Declare(Node):
    """``x, y : T``; ``carrier`` is the set that the values are taken from.

    Without names it includes the schema that ``carrier`` is: ``S``, ``S'``, ``Delta S``.
    """

    names: tuple[Declared, ...]
    carrier: Term


@dataclass(frozen=True, kw_only=True)
class Binding(Term):
    """``{ d | p @ e }``, ``lambda d | p @ e``, ``mu d | p @ e``; ``condition`` and ``body`` may be absent."""

    kind: Literal["set", "lambda", "mu"]
    declarations: tuple[Declare, ...]
    condition: Term | None = None
    body: Term | None = None


@dataclass(frozen=True, kw_only=True)
class Quantified(Term):
    """``forall d | p @ q``, ``exists d | p @ q``, ``exists1 d | p @ q``; ``condition`` may be absent."""

    kind: Literal["forall", "exists", "exists1"]
    declarations: tuple[Declare, ...]
    condition: Term | None
    body: Term


@dataclass(frozen=True, kw_only=True)
class Conditional(Term):
    """``if p then a else b``, between expressions or between predicates."""

    test: Term
    then: Term
    otherwise: Term


@dataclass(frozen=True, kw_only=True)
class Local(Term):
    """``let x == e; y == f @ t``."""

    definitions: tuple[tuple[NameDeclaration, Term], ...]
    body: Term


@dataclass(frozen=True, kw_only=True)
class SchemaText(Term):
    """``[x : T; S | p]``: a schema without a name."""

    declarations: tuple[Declare, ...]
    predicates: tuple[Term, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Renamed(Term):
    """``S[new/old]``, ``Op[new!/old!]``: pairs of ``renamings`` are (new, old)."""

    term: Term
    renamings: tuple[tuple[Declared, Declared], ...]


# --- paragraphs --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class GivenTypes(Paragraph):
    """``given MESSAGE, GID``."""

    names: tuple[NameDeclaration, ...]


@dataclass(frozen=True, kw_only=True)
class Branch(Node):
    """``normal`` or ``leaf<<nat>>`` in a free type."""

    name: str
    argument: Term | None = None


@dataclass(frozen=True, kw_only=True)
class FreeType(Paragraph):
    """``STATUS ::= normal | alert``."""

    name: str
    branches: tuple[Branch, ...]


@dataclass(frozen=True, kw_only=True)
class Abbreviation(Paragraph):
    """``DATA == {x : nat | 0 <= x <= 10}``; ``generics`` are the names of ``Pair[X, Y] == X cross Y``."""

    name: str
    body: Term
    generics: tuple[NameDeclaration, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Axiom(Paragraph):
    """``const x, y : T where p``: constants, each predicate on its own line an axiom about them.

    ``generics`` are the names of ``const [X] ...``, which declares a constant for every choice of sets.
    """

    declarations: tuple[Declare, ...]
    predicates: tuple[Term, ...] = ()
    generics: tuple[NameDeclaration, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Schema(Paragraph):
    """``schema ControlData ... end``: a record type, with the predicate that its values satisfy.

    ``initial`` is the INIT schema that the record has, None where it has none. ``generics`` are the names of
    ``schema Pair[X]``.
    """

    is_block: ClassVar[bool] = True

    name: str
    declarations: tuple[Declare, ...]
    predicates: tuple[Term, ...] = ()
    initial: tuple[Term, ...] | None = None
    generics: tuple[NameDeclaration, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Reading(Paragraph):
    """``reading SPEED_TYPE = {-1, 0, 1}``: the finite set that a search takes instead of a wide type.

    ``subject`` names a given set, a free type, an abbreviation, a schema, ``nat``, ``int`` or ``real``, or is an
    expression such as ``seq MESSAGE``. For a given set, ``carrier`` may be the number of its elements; for
    sequences and other collections, the greatest length or size.
    """

    subject: Term
    carrier: Term


@dataclass(frozen=True, kw_only=True)
class View(Paragraph):
    """``view control``: classes of this script are read without their data; ``view data`` is what holds otherwise."""

    kind: Literal["control", "data"]


@dataclass(frozen=True, kw_only=True)
class Retrieve(Paragraph):
    """``retrieve R between A and C where p end``: relates the states of an abstract and a concrete class.

    State variables of both are in scope; a name that both have is written ``A.items`` and ``C.items``.
    """

    is_block: ClassVar[bool] = True

    name: str
    abstract: NameDeclaration
    concrete: NameDeclaration
    predicates: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class LemmaUse(NameDeclaration):
    """``a`` or ``a(e1, e2)``: a lemma or law that helps a proof, with *arguments* for what its ``forall`` binds."""

    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Hints(Node):
    """``using a, b(e) by induction on x``: what helps a proof. Either part may be absent."""

    using: tuple[LemmaUse, ...] = ()
    induction: NameDeclaration | None = None


@dataclass(frozen=True, kw_only=True)
class Lemma(Paragraph):
    """``lemma name : p using a, b by induction on x``: a predicate that is to be proved, and then helps to prove.

    ``generics`` are the names of ``lemma name[X] : p``.
    """

    name: str
    predicate: Term
    generics: tuple[NameDeclaration, ...] = ()
    hints: Hints | None = None


# --- classes -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Interface(Node):
    """``chan c : [a : S; x? : T; y! : U]``, ``method m``, ``local_chan l``: names with the parameters of each."""

    kind: Literal["chan", "method", "local_chan"]
    names: tuple[NameDeclaration, ...]
    parameters: tuple[Declare, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Inherit(Node):
    """``inherit Periodic``, ``inherit Stack[nat][push/put]``: pairs of ``renamings`` are (new, old)."""

    name: str
    arguments: tuple[Term, ...] = ()
    renamings: tuple[tuple[NameDeclaration, NameDeclaration], ...] = ()


@dataclass(frozen=True, kw_only=True)
class State(Node):
    """``state d; Delta d' where p``: primary variables, secondary ones (behind ``Delta``), the invariant."""

    primary: tuple[Declare, ...]
    secondary: tuple[Declare, ...] = ()
    predicates: tuple[Term, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Initial(Node):
    """``init p``: a predicate on each line."""

    predicates: tuple[Term, ...]


@dataclass(frozen=True, kw_only=True)
class OperationSchema(Node):
    """``op com_c Delta(x) y? : T where p``: an operation by its box.

    ``delta`` is None where there is no Delta-list, which means the same as an empty one. ``using`` are lemmas for the
    proofs about it.
    """

    name: str
    delta: tuple[NameDeclaration, ...] | None
    declarations: tuple[Declare, ...] = ()
    predicates: tuple[Term, ...] = ()
    using: tuple[LemmaUse, ...] = ()


@dataclass(frozen=True, kw_only=True)
class OperationDefinition(Node):
    """``op Swap = Pop ; Push``: an operation by an expression over others.

    In ``body`` the operators are ``compose`` (``;``), ``and``, ``or``, ``choice`` (``[]``), ``parallel`` (``||``),
    ``parallel_open`` (``||!``), ``hide`` and ``enrich`` (``@``); its references name operations.
    """

    name: str
    body: Term
    using: tuple[LemmaUse, ...] = ()


@dataclass(frozen=True, kw_only=True)
class OperationText(Term):
    """``[Delta(x); k? : T | p]`` in an expression over operations; predicates alone are a guard."""

    delta: tuple[NameDeclaration, ...] | None
    declarations: tuple[Declare, ...] = ()
    predicates: tuple[Term, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Distributed(Term):
    """``[] x : S | p @ Op`` and the same with ``and``, ``;`` and ``||``: one operation for each value."""

    kind: Literal["choice", "and", "compose", "parallel"]
    declarations: tuple[Declare, ...]
    condition: Term | None
    body: Term


@dataclass(frozen=True, kw_only=True)
class Class(Paragraph):
    """``class Name[T] ... end``.

    ``visibility`` is None where there is no list (everything is visible). ``equations`` are the CSP part: ordinary
    declarations of CSPm, ``main`` among them. ``paragraphs`` are the local types and constants.
    """

    is_block: ClassVar[bool] = True

    name: str
    generics: tuple[NameDeclaration, ...] = ()
    visibility: tuple[NameDeclaration, ...] | None = None
    inherits: tuple[Inherit, ...] = ()
    interface: tuple[Interface, ...] = ()
    equations: tuple[Declaration, ...] = ()
    paragraphs: tuple[Paragraph, ...] = ()
    state: State | None = None
    initial: Initial | None = None
    operations: tuple[OperationSchema | OperationDefinition, ...] = ()


# --- assertions --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Obligations(Assertion):
    """``assert C :[obligations]``, ``assert C :[invariant preserved]``: proof obligations of a class.

    ``obligation`` is the words between the brackets, None for all; ``operation`` narrows it to one:
    ``assert C :[deterministic operation]: push``.
    """

    subject: NameDeclaration
    obligation: str | None = None
    operation: NameDeclaration | None = None
    hints: Hints | None = None


@dataclass(frozen=True, kw_only=True)
class DataRefinement(Assertion):
    """``assert A [OZ= C via R``: C simulates A under the retrieve relation R.

    ``upward`` for the form ``assert A [OZ= C via R :[upward]``.
    """

    abstract: NameDeclaration
    concrete: NameDeclaration
    retrieve: NameDeclaration
    upward: bool = False
    hints: Hints | None = None


@dataclass(frozen=True, kw_only=True)
class Subtype(Assertion):
    """``assert Parent [OZ= Child``: a subclass refines its parent, by the projection of its state."""

    parent: NameDeclaration
    child: NameDeclaration
    hints: Hints | None = None
