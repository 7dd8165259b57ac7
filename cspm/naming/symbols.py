"""What names stand for: symbols, and the table that says which symbol each node of a tree means."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax


class SymbolKind(Enum):
    """What sort of thing a name stands for."""

    VARIABLE = auto()
    """Bound by a pattern: a parameter, a generator, an input, a module's parameter."""
    VALUE = auto()
    """Defined by ``x = e``, or by a larger pattern such as ``(x, y) = e``."""
    FUNCTION = auto()
    CHANNEL = auto()
    CONSTRUCTOR = auto()
    DATATYPE = auto()
    SUBTYPE = auto()
    NAMETYPE = auto()
    MODULE = auto()
    INSTANCE = auto()
    BUILTIN = auto()
    """Of the language itself, whether always in scope or imported with ``transparent`` or ``external``."""


@dataclass(eq=False, slots=True)
class Symbol:
    """One declared thing. Two uses mean the same thing exactly if their symbols are the same object.

    ``declaration`` is the node that declares it: a ``FunctionDefinition``, ``PatternDefinition``,
    ``ChannelDeclaration``, ``DatatypeDeclaration`` (of a datatype and of its constructors, whose own node is
    ``constructor``), ``NametypeDeclaration``, ``ModuleDeclaration``, ``InstanceDeclaration``, for variables the
    ``NamePattern``, for built-ins None.

    ``owner`` is the module that the declaration stands in (None: the script itself, or a built-in). ``is_local``
    tells what lives inside an expression (variables, ``let``) from what exists once for each module instance.

    A member seen through an instance (``I::x``) is a symbol of its own: ``instance`` is the symbol of ``I`` and
    ``member`` the symbol of ``x`` in the module; the other attributes are the member's. The member ``x`` of a
    module without parameters seen as ``M::x`` is simply ``x``.
    """

    name: str
    kind: SymbolKind
    span: Span | None
    declaration: syntax.Node | None = None
    owner: Symbol | None = None
    is_local: bool = False
    constructor: syntax.Constructor | None = None
    instance: Symbol | None = None
    member: Symbol | None = None
    module: Symbol | None = None
    """Of an instance: the module that it instantiates (which may itself be seen through an instance)."""
    members: dict[str, Symbol] = field(default_factory=dict)
    """Of a module: everything that it declares, by name, parameters apart."""
    exported: frozenset[str] = frozenset()
    """Of a module: the names that can be used from outside."""
    parameters: tuple[Symbol, ...] = ()
    """Of a module: the variables that its parameters bind."""

    @property
    def parameters_declared(self) -> bool:
        """Of a module: whether it has parameters, so that only its instances can be used."""
        return isinstance(self.declaration, syntax.ModuleDeclaration) and bool(self.declaration.parameters)

    @property
    def base(self) -> Symbol:
        """The symbol of the declaration itself, whatever instances it is seen through."""
        return self if self.member is None else self.member

    def __repr__(self) -> str:
        return f"<{self.kind.name.lower()} {self.name}>"


class Names:
    """Which symbol each node means. Nodes are known by identity, and the table keeps their trees alive."""

    def __init__(self, script: syntax.Script) -> None:
        self.script = script
        self._symbols: dict[int, Symbol] = {}
        self._kept: list[syntax.Node] = [script]
        self._annotations: dict[Symbol, syntax.AnnotationDeclaration] = {}
        self._projections: dict[tuple[Symbol, Symbol], Symbol] = {}
        self._tocks: dict[int, Symbol] = {}
        self.warnings: list[Diagnostic] = []
        self.unprintable: set[Span] = set()
        """Where the ``print`` declarations stand that are wrong; they are left out."""
        self._resolver: Any = None  # keeps the scopes, for what is written against the script later
        self.top_level: dict[str, Symbol] = {}
        """What the script itself declares, by name (modules' members are in their module)."""

    def symbol(self, node: syntax.Node) -> Symbol:
        """What *node* means or declares.

        Known for every ``Name``, ``NamePattern``, ``NameDeclaration``, ``FunctionDefinition``, ``Constructor``,
        ``DatatypeDeclaration``, ``NametypeDeclaration``, ``ModuleDeclaration``, ``InstanceDeclaration`` and every
        ``TypeName`` that names a declared type.

        Raises:
            KeyError: the node names nothing.
        """
        return self._symbols[id(node)]

    def find(self, node: syntax.Node) -> Symbol | None:
        """Like :meth:`symbol`, with None for a node that names nothing (a type variable)."""
        return self._symbols.get(id(node))

    def annotation(self, symbol: Symbol) -> syntax.AnnotationDeclaration | None:
        """The type annotation of what *symbol* stands for."""
        return self._annotations.get(symbol.base)

    @property
    def annotations(self) -> Mapping[Symbol, syntax.AnnotationDeclaration]:
        """All annotations, by the symbol that they annotate."""
        return self._annotations

    def tock(self, section: syntax.TimedDeclaration) -> Symbol:
        """The channel ``tock`` of a Timed section."""
        return self._tocks[id(section)]

    @property
    def clocks(self) -> frozenset[Symbol]:
        """The channels that Timed sections use as their ``tock``."""
        return frozenset(self._tocks.values())

    def project(self, instance: Symbol, member: Symbol) -> Symbol:
        """*member*, declared in the module of *instance* or in a module inside it, as seen through *instance*.

        The same symbol each time. Works for private members too: types may mention them.
        """
        if member.kind is SymbolKind.BUILTIN:
            return member
        key = (instance, member)
        projected = self._projections.get(key)
        if projected is None:
            projected = Symbol(
                f"{instance.name}::{member.name}",
                member.kind,
                member.span,
                member.declaration,
                owner=member.owner,
                constructor=member.constructor,
                instance=instance,
                member=member,
                module=member.module,
                members=member.members,
                exported=member.exported,
                parameters=member.parameters,
            )
            self._projections[key] = projected
        return projected

    def __iter__(self) -> Iterator[Symbol]:
        """Every symbol that some node means, each once."""
        return iter(dict.fromkeys(self._symbols.values()))

    def forget(self, root: syntax.Node, nodes: Iterable[syntax.Node]) -> set[Symbol]:
        """Drop what is known of *nodes*, all those of a tree written against the script; the symbols declared in it.

        Nobody may ask for them again.
        """
        self._kept = [kept for kept in self._kept if kept is not root]
        declared: set[Symbol] = set()
        for node in nodes:
            self._tocks.pop(id(node), None)
            symbol = self._symbols.pop(id(node), None)
            if symbol is not None and symbol.span is not None and symbol.span.source is root.span.source:
                declared.add(symbol)
                self._annotations.pop(symbol, None)
        return declared

    def _record(self, node: syntax.Node, symbol: Symbol) -> None:
        self._symbols[id(node)] = symbol
