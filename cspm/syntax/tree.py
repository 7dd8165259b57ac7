"""The syntax tree of CSPm: one class for each form, with the concrete syntax that it stands for.

Nodes are immutable and compare by structure; spans take no part in comparison, so that two parses of the same
text in two places are equal. Phases after the parser keep what they find in tables keyed by ``id(node)`` (the
tree outlives them) and never change the tree.

``Paren`` is kept so that a printed script looks as it was written; every other phase looks through it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.syntax.nodes import (
    BothPattern as BothPattern,
    ConcatPattern as ConcatPattern,
    Declaration as Declaration,
    DotableType as DotableType,
    DotPattern as DotPattern,
    DotType as DotType,
    Expr as Expr,
    FunctionType as FunctionType,
    LiteralPattern as LiteralPattern,
    MapType as MapType,
    NamePattern as NamePattern,
    Node as Node,
    ParenPattern as ParenPattern,
    Pattern as Pattern,
    SequencePattern as SequencePattern,
    SequenceType as SequenceType,
    SetPattern as SetPattern,
    SetType as SetType,
    Statement as Statement,
    TuplePattern as TuplePattern,
    TupleType as TupleType,
    TypeConstraint as TypeConstraint,
    TypeExpr as TypeExpr,
    TypeName as TypeName,
    TypeScheme as TypeScheme,
    Wildcard as Wildcard,
)

# --- expressions: values -------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Name(Expr):
    """``x``, ``M::x``, ``A::B::x``: the parts between the ``::``."""

    parts: tuple[str, ...]

    @property
    def text(self) -> str:
        """The name as written."""
        return "::".join(self.parts)


@dataclass(frozen=True, kw_only=True)
class LiteralExpr(Expr):
    """``7``, ``true``, ``'c'``, ``"text"``; ``kind`` tells characters from strings and Booleans from integers."""

    kind: Literal["int", "bool", "char", "string"]
    value: int | bool | str


@dataclass(frozen=True, kw_only=True)
class Paren(Expr):
    """``(e)``."""

    inner: Expr


def bare(node: Expr) -> Expr:
    """An expression without brackets around it."""
    while isinstance(node, Paren):
        node = node.inner
    return node


@dataclass(frozen=True, kw_only=True)
class TupleExpr(Expr):
    """``(a, b)``: at least two items."""

    items: tuple[Expr, ...]


@dataclass(frozen=True, kw_only=True)
class SetExpr(Expr):
    """``{a, b}`` or, with statements, ``{a, b | x <- s, p}``. ``statements`` is None for the plain form."""

    items: tuple[Expr, ...]
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class SetRange(Expr):
    """``{low..high}``, ``{low..}`` (``high`` is None), each also with ``| statements``."""

    low: Expr
    high: Expr | None
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class Productions(Expr):
    """``{| c, d.0 |}`` or ``{| c.x | x <- s |}``: all completions of the items."""

    items: tuple[Expr, ...]
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class SequenceExpr(Expr):
    """``<a, b>`` or ``<a, b | x <- s, p>``."""

    items: tuple[Expr, ...]
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class SequenceRange(Expr):
    """``<low..high>``, ``<low..>``, each also with ``| statements``."""

    low: Expr
    high: Expr | None
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class MapExpr(Expr):
    """``(| k => v, ... |)``."""

    items: tuple[tuple[Expr, Expr], ...]


BinaryOperator = Literal["+", "-", "*", "/", "%", "==", "!=", "<", "<=", ">", ">=", "and", "or", "^"]
UnaryOperator = Literal["-", "not", "#"]


@dataclass(frozen=True, kw_only=True)
class Binary(Expr):
    """``left op right`` on values."""

    operator: BinaryOperator
    left: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class Unary(Expr):
    """``-e``, ``not e``, ``#e``."""

    operator: UnaryOperator
    operand: Expr


@dataclass(frozen=True, kw_only=True)
class Dot(Expr):
    """``left.right``, right associative."""

    left: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class Apply(Expr):
    """``f(a, b)``; ``f(a)(b)`` is an ``Apply`` of an ``Apply``; ``arguments`` may be empty."""

    function: Expr
    arguments: tuple[Expr, ...]


@dataclass(frozen=True, kw_only=True)
class Lambda(Expr):
    r"""``\ p, q @ e``."""

    parameters: tuple[Pattern, ...]
    body: Expr


@dataclass(frozen=True, kw_only=True)
class If(Expr):
    """``if c then e else f``."""

    condition: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True, kw_only=True)
class Let(Expr):
    """``let declarations within e``."""

    declarations: tuple[Declaration, ...]
    body: Expr


class Foreign(Expr):
    """An expression that no text of CSPm stands for: the Object-Z part brings it
    (:mod:`cspcheck.cspm.oz.processes.nodes`).
    """

    @property
    def names(self) -> tuple[Name, ...]:
        """The names of the script that its value depends on."""
        return ()


# --- expressions: processes ----------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Field(Node):
    """A prefix's field: ``!e`` (``expression``); ``?p``, ``?p:S``, ``$p``, ``$p:S`` (``pattern``, ``restriction``)."""

    kind: Literal["!", "?", "$"]
    expression: Expr | None = None
    pattern: Pattern | None = None
    restriction: Expr | None = None


@dataclass(frozen=True, kw_only=True)
class Prefix(Expr):
    """``c.a!b?x$y -> body``; ``.`` parts before the first field belong to ``channel``."""

    channel: Expr
    fields: tuple[Field, ...]
    body: Expr


@dataclass(frozen=True, kw_only=True)
class Guard(Expr):
    """``condition & body``."""

    condition: Expr
    body: Expr


ProcessOperator = Literal[";", "[]", "|~|", "[>", "/\\", "|||"]


@dataclass(frozen=True, kw_only=True)
class ProcessBinary(Expr):
    r"""``P ; Q``, ``P [] Q``, ``P |~| Q``, ``P [> Q``, ``P /\ Q``, ``P ||| Q``."""

    operator: ProcessOperator
    left: Expr
    right: Expr


SynchronisedOperator = Literal["[|", "[+", "/+", "[|>"]


@dataclass(frozen=True, kw_only=True)
class Synchronised(Expr):
    r"""``P [| A |] Q``, ``P [+ A +] Q``, ``P /+ A +\ Q``; ``[|>`` stands for the exception ``P [| A |> Q``."""

    operator: SynchronisedOperator
    left: Expr
    events: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class AlphabetisedParallel(Expr):
    """``P [ A || B ] Q``."""

    left: Expr
    left_alphabet: Expr
    right_alphabet: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class LinkedParallel(Expr):
    """``P [ a <-> b, c <-> d | statements ] Q``."""

    left: Expr
    links: tuple[tuple[Expr, Expr], ...]
    right: Expr
    statements: tuple[Statement, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class ClassParallel(Expr):
    """``P || Q``: classes, or compositions of them, joined on the channels that both declare; left associative."""

    left: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class Hide(Expr):
    r"""``P \ A``, or with ``keep`` the projection ``P |\ A``."""

    process: Expr
    events: Expr
    keep: bool = False


@dataclass(frozen=True, kw_only=True)
class Rename(Expr):
    """``P [[ a <- b, c <- d | statements ]]``; pairs are (old, new)."""

    process: Expr
    pairs: tuple[tuple[Expr, Expr], ...]
    statements: tuple[Statement, ...] | None = None


ReplicatedOperator = Literal["[]", "|~|", "|||", ";", "||", "[|", "[+", "<->"]


@dataclass(frozen=True, kw_only=True)
class Replicated(Expr):
    """``op statements @ body``.

    ``events`` is the set of ``[| A |]`` and ``[+ A +]`` (evaluated outside the statements) and the alphabet of
    ``|| x : S @ [A(x)] P`` (evaluated inside them). ``links`` and ``link_statements`` belong to ``<->``,
    written ``[ a <-> b | stmts ] x : s @ P``, and are evaluated inside the statements too: those of one process link
    it to the chain of those behind it.
    """

    operator: ReplicatedOperator
    statements: tuple[Statement, ...]
    body: Expr
    events: Expr | None = None
    links: tuple[tuple[Expr, Expr], ...] = ()
    link_statements: tuple[Statement, ...] | None = None


# --- statements ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Generator(Statement):
    """``p <- s``, or ``p : s`` (the same meaning; ``colon`` remembers the writing)."""

    pattern: Pattern
    source: Expr
    colon: bool = False


@dataclass(frozen=True, kw_only=True)
class Qualifier(Statement):
    """A Boolean condition among the generators."""

    condition: Expr


# --- declarations --------------------------------------------------------------------------------------------


class Paragraph(Declaration):
    """A paragraph of Object-Z, at the top of a script or inside a class; the forms are in
    :mod:`cspcheck.cspm.oz.syntax`.
    """

    is_block: ClassVar[bool] = False
    """Whether it stands on lines of its own and ends with ``end``."""


@dataclass(frozen=True, kw_only=True)
class Clause(Node):
    """One clause ``f(p, q)(r) = body`` of a function; ``groups`` are the curried parameter lists."""

    groups: tuple[tuple[Pattern, ...], ...]
    body: Expr


@dataclass(frozen=True, kw_only=True)
class FunctionDefinition(Declaration):
    """Adjacent clauses of one function, in order."""

    name: str
    clauses: tuple[Clause, ...]


@dataclass(frozen=True, kw_only=True)
class PatternDefinition(Declaration):
    """``p = e``; ``P = e`` is this with a ``NamePattern``.

    ``called`` is what the value is called where people see it, if that is not the name: a definition that a construct
    stands for has a name that nobody wrote.
    """

    pattern: Pattern
    body: Expr
    called: str | None = None


@dataclass(frozen=True, kw_only=True)
class NameDeclaration(Node):
    """A declared name with its place (channels, imports)."""

    name: str


@dataclass(frozen=True, kw_only=True)
class ChannelDeclaration(Declaration):
    """``channel a, b`` (``fields`` is None) or ``channel c : T``."""

    names: tuple[NameDeclaration, ...]
    fields: Expr | None = None


@dataclass(frozen=True, kw_only=True)
class Constructor(Node):
    """``A`` or ``B.S.T`` in a datatype; ``fields`` is the expression behind the first dot."""

    name: str
    fields: Expr | None = None


@dataclass(frozen=True, kw_only=True)
class DatatypeDeclaration(Declaration):
    """``datatype T = A | B.S``; with ``subtype`` the declaration ``subtype T = ...``."""

    name: str
    constructors: tuple[Constructor, ...]
    subtype: bool = False


@dataclass(frozen=True, kw_only=True)
class NametypeDeclaration(Declaration):
    """``nametype T = e``."""

    name: str
    body: Expr


@dataclass(frozen=True, kw_only=True)
class ImportDeclaration(Declaration):
    """``transparent f, g`` or ``external f``."""

    kind: Literal["transparent", "external"]
    names: tuple[NameDeclaration, ...]


@dataclass(frozen=True, kw_only=True)
class IncludeDeclaration(Declaration):
    """``include "path"`` with what the file holds."""

    path: str
    declarations: tuple[Declaration, ...]


@dataclass(frozen=True, kw_only=True)
class PrintDeclaration(Declaration):
    """``print e``."""

    expression: Expr


@dataclass(frozen=True, kw_only=True)
class ModuleDeclaration(Declaration):
    """``module M(p) private exports public endmodule``; ``parameters`` is empty without a list."""

    name: str
    parameters: tuple[Pattern, ...]
    private: tuple[Declaration, ...]
    exported: tuple[Declaration, ...]

    @property
    def key(self) -> str:
        """What it is called in the scope around it."""
        return self.name


@dataclass(frozen=True, kw_only=True)
class InstanceDeclaration(Declaration):
    """``instance I = M(e)``; ``module`` is the (possibly qualified) name."""

    name: str
    module: Name
    arguments: tuple[Expr, ...]


@dataclass(frozen=True, kw_only=True)
class TimedDeclaration(Declaration):
    """``Timed { ... }`` or ``Timed(f) { ... }``."""

    duration: Expr | None
    declarations: tuple[Declaration, ...]


@dataclass(frozen=True, kw_only=True)
class AnnotationDeclaration(Declaration):
    """``x, y :: constraints => type``."""

    names: tuple[NameDeclaration, ...]
    scheme: TypeScheme


# --- assertions ----------------------------------------------------------------------------------------------

Model = Literal["T", "F", "FD", "V", "VD", "R", "RD"]
PropertyKind = Literal["deadlock free", "divergence free", "deterministic", "has trace"]


class Assertion(Node):
    """What an ``assert`` claims."""


@dataclass(frozen=True, kw_only=True)
class AssertOption(Node):
    """``:[tau priority]: A``, ``:[partial order reduce [mode]]`` or ``:[symmetry reduce]: types``."""

    kind: Literal["tau priority", "partial order reduce", "symmetry reduce"]
    events: Expr | None = None
    mode: str | None = None
    types: tuple[Expr, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Refinement(Assertion):
    """``specification [model= implementation``."""

    specification: Expr
    model: Model
    implementation: Expr
    options: tuple[AssertOption, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Property(Assertion):
    """``process :[kind [model]]`` and, for ``has trace``, the ``trace`` expression behind it."""

    process: Expr
    kind: PropertyKind
    model: Model | None = None
    trace: Expr | None = None
    options: tuple[AssertOption, ...] = ()


@dataclass(frozen=True, kw_only=True)
class BooleanAssertion(Assertion):
    """``assert e``: the Boolean form of FDR2."""

    condition: Expr


@dataclass(frozen=True, kw_only=True)
class NotAssertion(Assertion):
    """``not assertion``."""

    inner: Assertion


@dataclass(frozen=True, kw_only=True)
class AssertDeclaration(Declaration):
    """``assert assertion``."""

    assertion: Assertion


# --- scripts -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Comment(Node):
    """``-- ...`` or ``{- ... -}``, as written."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Script(Node):
    """A parsed file with everything it includes; ``comments`` are those of the root file, in order.

    ``remarks`` are warnings about its form.
    """

    declarations: tuple[Declaration, ...]
    comments: tuple[Comment, ...] = field(default=(), compare=False)
    remarks: tuple[Diagnostic, ...] = field(default=(), compare=False, repr=False)
