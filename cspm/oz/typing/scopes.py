"""What names mean in the Object-Z part: scopes, and the things that a name can stand for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.reading.operators import INREL
from cspcheck.cspm.oz.values.terms import shape
from cspcheck.cspm.source import Span

PredicatePlace = Literal["effect", "guard", "invariant", "initial", "axiom", "retrieve", "record"]
"""The kind of predicate that a name stands in; it decides which decorations make sense."""


@dataclass(frozen=True, slots=True)
class StateEntry:
    """A state variable; ``secondary`` ones follow from the primary ones."""

    name: str
    type: core.Type
    secondary: bool
    span: Span


@dataclass(frozen=True, slots=True)
class ParameterEntry:
    """A parameter of an operation."""

    name: str
    kind: core.ParameterKind
    type: core.Type
    span: Span


@dataclass(frozen=True, slots=True)
class VariableEntry:
    """A constant, a bound variable or a field of a record, as the core term that it is."""

    term: core.Term
    span: Span | None


@dataclass(frozen=True, slots=True)
class SetEntry:
    """A name for a set: a given or free type, a schema, an abbreviation. ``term`` is the set itself."""

    term: core.Term
    span: Span | None
    schema: str | None = None


@dataclass(frozen=True, slots=True)
class GenericEntry:
    """An abbreviation with generic parameters, to be instantiated where it is used."""

    abbreviation: s.Abbreviation
    scope: TypingScope


@dataclass(frozen=True, slots=True)
class ConstructorEntry:
    """A constructor of a free type; ``carrier`` is the set of its argument, None for a constant."""

    name: str
    type: core.FreeType
    carrier: core.Term | None
    span: Span | None


@dataclass(frozen=True, slots=True)
class ClassEntry:
    """A class: a process; the set of its objects too, where ``identities`` are given."""

    name: str
    span: Span
    identities: core.Term | None = None


@dataclass(frozen=True, slots=True)
class ObjectEntry:
    """An attribute of a class type, whose variables are those of its class under its name.

    Attributes:
        name: with those of the objects that it belongs to, ``bank.card``.
        owner: its class.
        binder: of a family of objects, the variable that stands for the identity in ``initial``.
        initial: what its INIT says.
        made: what is known of the class (:class:`~cspcheck.cspm.oz.typing.objects.ObjectClass`).
        span: where it is declared.
        shared: the constants that its class gives a value, which all objects have in common.
        pool: whether these are all the objects of the class, which values of its type are the identities of.
        said: of a pool, the axioms and invariants that hold of its objects.
    """

    name: str
    owner: str
    binder: core.Binder | None
    initial: tuple[core.Term, ...]
    made: object
    span: Span
    shared: frozenset[str] = frozenset()
    pool: bool = False
    said: tuple[core.Term, ...] = ()


@dataclass(frozen=True, slots=True)
class AmbiguousEntry:
    """A state variable that both classes of a retrieve relation have; it needs the class's name before it."""

    choices: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FailedEntry:
    """A name whose declaration is wrong: what is wrong has been told, and is all that there is to say of its uses."""

    diagnostic: Diagnostic


Entry: TypeAlias = (
    StateEntry
    | ParameterEntry
    | VariableEntry
    | SetEntry
    | GenericEntry
    | ConstructorEntry
    | ClassEntry
    | ObjectEntry
    | AmbiguousEntry
    | FailedEntry
)


Definition: TypeAlias = SetEntry | GenericEntry | ConstructorEntry
"""What types, abbreviations and schemas are."""


class TypingScope:
    """Names and what they mean, with the scope around. ``x``, ``x?`` and ``x!`` are different variables."""

    def __init__(self, outer: TypingScope | None = None) -> None:
        self.outer = outer
        self._entries: dict[str, Entry] = {}
        self._parameters: dict[tuple[str, core.ParameterKind], ParameterEntry] = {}

    def add(self, name: str, entry: Entry) -> None:
        """Give *name* a meaning here; one from further out is hidden."""
        if isinstance(entry, ParameterEntry) and entry.kind != "simple":
            self._parameters[name, entry.kind] = entry
        else:
            self._entries[name] = entry

    def find(self, name: str) -> Entry | None:
        """What the undecorated *name* means."""
        scope: TypingScope | None = self
        while scope is not None:
            entry = scope._entries.get(name)
            if entry is not None:
                return entry
            scope = scope.outer
        return None

    def parameter(self, name: str, kind: core.ParameterKind | None = None) -> ParameterEntry | None:
        """The input or output called *name*; where there are both, the one of *kind*."""
        wanted: tuple[core.ParameterKind, ...] = ("input", "output") if kind is None else (kind,)
        scope: TypingScope | None = self
        while scope is not None:
            for each in wanted:
                entry = scope._parameters.get((name, each))
                if entry is not None:
                    return entry
            scope = scope.outer
        return None

    def own(self, name: str) -> Entry | None:
        """What *name* means in this scope itself."""
        return self._entries.get(name)

    def names(self) -> Iterator[str]:
        """All undecorated names that mean something."""
        scope: TypingScope | None = self
        while scope is not None:
            yield from scope._entries
            scope = scope.outer

    def parameters(self) -> Iterator[str]:
        """The inputs and outputs in scope, with their decorations."""
        scope: TypingScope | None = self
        while scope is not None:
            for name, kind in scope._parameters:
                yield name + ("?" if kind == "input" else "!")
            scope = scope.outer


NUMBER_SETS: Final[Mapping[str, core.Term]] = {
    "nat": core.Apply(type=core.SetType(core.INT), operator="Nat"),
    "nat1": core.Apply(type=core.SetType(core.INT), operator="Nat1"),
    "int": core.Apply(type=core.SetType(core.INT), operator="Int"),
    "num": core.Apply(type=core.SetType(core.INT), operator="Int"),
    "real": core.Apply(type=core.SetType(core.REAL), operator="Real"),
    "bool": core.Apply(type=core.SetType(core.BOOL), operator="Bool"),
}


def toolkit() -> TypingScope:
    """The outermost scope: the sets of numbers and truth values."""
    scope = TypingScope()
    for name, term in NUMBER_SETS.items():
        scope.add(name, SetEntry(term, None))
    return scope


def whole(type_: core.GivenType | core.FreeType) -> core.Term:
    """The set of all elements of a given or free type."""
    return core.Apply(type=core.SetType(type_), operator="All")


def mentioned(terms: Iterable[s.Term | None]) -> Iterator[s.Reference]:
    """All references in trees, those in declarations of bound variables included; in the order of the text."""
    stack = [term for term in terms if term is not None][::-1]
    while stack:
        term = stack.pop()
        if isinstance(term, s.Reference):
            yield term
        stack.extend(reversed(list(subterms(term))))


def named(relation: str, span: Span) -> s.Reference:
    """What the name in ``inrel R`` stands for."""
    written = relation.removeprefix(INREL)
    name = written.rstrip("'?!")
    decoration: s.Decoration = written[len(name) :]  # type: ignore[assignment]
    return s.Reference(span=span, name=name, decoration=decoration)


def subterms(term: s.Term) -> Iterator[s.Term]:
    """The immediate subterms of a tree."""
    match term:
        case s.Reference():
            yield from term.arguments
        case s.Grouped():
            yield term.inner
        case s.Operator():
            yield from term.operands
        case s.Chain():
            yield from term.operands
            yield from (named(relation, term.span) for relation in term.relations if relation.startswith(INREL))
        case s.Application():
            yield term.function
            yield term.argument
        case s.Selection():
            yield term.record
        case s.Display():
            yield from term.items
        case s.BindingDisplay():
            yield from (value for _, value in term.fields)
        case s.Binding() | s.Quantified():
            yield from (declaration.carrier for declaration in term.declarations)
            if term.condition is not None:
                yield term.condition
            if term.body is not None:
                yield term.body
        case s.Conditional():
            yield term.test
            yield term.then
            yield term.otherwise
        case s.Local():
            yield from (value for _, value in term.definitions)
            yield term.body
        case s.SchemaText():
            yield from (declaration.carrier for declaration in term.declarations)
            yield from term.predicates
        case s.OperationText():
            yield from (declaration.carrier for declaration in term.declarations)
            yield from term.predicates
        case s.Renamed():
            yield term.term
        case s.Distributed():
            yield from (declaration.carrier for declaration in term.declarations)
            if term.condition is not None:
                yield term.condition
            yield term.body


def same_definition(first: Definition, other: Definition) -> bool:
    """Whether two classes mean the same by a name."""
    match first, other:
        case SetEntry(), SetEntry():
            return shape(first.term) == shape(other.term)
        case GenericEntry(), GenericEntry():
            return first.abbreviation == other.abbreviation
        case ConstructorEntry(), ConstructorEntry():
            return first.type == other.type
    return False


def place_of(entry: Definition) -> Span | None:
    """Where a name was given its meaning."""
    return entry.abbreviation.span if isinstance(entry, GenericEntry) else entry.span
