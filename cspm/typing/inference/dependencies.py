"""Which declaration uses which: the order in which types are inferred.

The declarations of a script, those in its modules included, form one graph. Its strongly connected components are
inferred one after the other, each when all that it uses is known, so that what is not recursive is as general as
it can be (Hindley-Milner with the dependency analysis of the Haskell report, section 4.5).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children


@dataclass(eq=False, slots=True)
class DependencyUnit:
    """One declaration with what it declares; ``uses`` are the units that must be known before it.

    ``module`` is the innermost module that it stands in, ``depth`` the number of modules with parameters around it.
    """

    declaration: syntax.Declaration
    symbols: tuple[Symbol, ...]
    module: Symbol | None
    depth: int
    uses: tuple[DependencyUnit, ...] = ()
    inside: list[DependencyUnit] = field(default_factory=list)
    """Of a module: the units of everything declared in it, itself and modules in it included."""


def units_of(declarations: Iterable[syntax.Declaration], names: Names) -> list[DependencyUnit]:
    """The units of *declarations* in the order of the script, with what they use among themselves."""
    units = list(_collect(declarations, names, None, 0, ()))
    owners: dict[Symbol, DependencyUnit] = {symbol: unit for unit in units for symbol in unit.symbols}
    headers = {
        names.symbol(unit.declaration): unit for unit in units if isinstance(unit.declaration, syntax.ModuleDeclaration)
    }
    for unit in units:
        found: dict[DependencyUnit, None] = {}
        for symbol in _used(unit.declaration, names):
            defined = symbol.kind in (SymbolKind.FUNCTION, SymbolKind.VALUE) and symbol.instance is None
            if defined and names.annotation(symbol) is not None:
                continue
            owner = owners.get(outermost(symbol, names))
            if owner is not None:
                found[owner] = None
        if isinstance(unit.declaration, syntax.InstanceDeclaration):
            module = names.symbol(unit.declaration.module)
            if module.instance is not None:
                outer = owners.get(outermost(module, names))
                if outer is not None:
                    found[outer] = None
            header = headers.get(module.base)
            if header is not None:
                found.update(dict.fromkeys(header.inside))
        elif unit.module is not None and unit.module in headers:
            found[headers[unit.module]] = None
        unit.uses = tuple(found)
    return units


def outermost(symbol: Symbol, names: Names) -> Symbol:
    """The declared symbol whose unit makes *symbol* known: of ``I::x``, the instance ``I``."""
    while symbol.instance is not None:
        symbol = symbol.instance
    return symbol


def _collect(
    declarations: Iterable[syntax.Declaration],
    names: Names,
    module: Symbol | None,
    depth: int,
    headers: tuple[DependencyUnit, ...],
) -> Iterator[DependencyUnit]:
    for declaration in declarations:
        match declaration:
            case syntax.IncludeDeclaration():
                yield from _collect(declaration.declarations, names, module, depth, headers)
                continue
            case syntax.ImportDeclaration() | syntax.AnnotationDeclaration():
                continue
        unit = DependencyUnit(declaration, tuple(declared(declaration, names)), module, depth)
        for header in headers:
            header.inside.append(unit)
        yield unit
        match declaration:
            case syntax.TimedDeclaration():
                yield from _collect(declaration.declarations, names, module, depth, headers)
            case syntax.ModuleDeclaration():
                unit.inside.append(unit)
                inner_depth = depth + bool(declaration.parameters)
                inner = (*declaration.private, *declaration.exported)
                yield from _collect(inner, names, names.symbol(declaration), inner_depth, (*headers, unit))


def declared(declaration: syntax.Declaration, names: Names) -> list[Symbol]:
    """The symbols whose types a declaration gives: of a module, its parameters."""
    match declaration:
        case syntax.FunctionDefinition() | syntax.NametypeDeclaration() | syntax.InstanceDeclaration():
            return [names.symbol(declaration)]
        case syntax.PatternDefinition():
            bound = [names.find(node) for node in variables(declaration.pattern)]
            return [symbol for symbol in bound if symbol is not None and symbol.kind is SymbolKind.VALUE]
        case syntax.ChannelDeclaration():
            return [names.symbol(name) for name in declaration.names]
        case syntax.DatatypeDeclaration():
            whole = names.symbol(declaration)
            if declaration.subtype:
                return [whole]
            return [whole, *[names.symbol(constructor) for constructor in declaration.constructors]]
        case syntax.ModuleDeclaration():
            return list(names.symbol(declaration).parameters)
    return []


def _used(declaration: syntax.Declaration, names: Names) -> Iterator[Symbol]:
    """What a declaration mentions; for a module and a Timed section only what stands in its head."""
    waiting: list[syntax.Node]
    match declaration:
        case syntax.ModuleDeclaration():
            waiting = list(declaration.parameters)
        case syntax.TimedDeclaration():
            waiting = [] if declaration.duration is None else [declaration.duration]
        case syntax.InstanceDeclaration():
            waiting = list(declaration.arguments)
        case _:
            waiting = [declaration]
    while waiting:
        node = waiting.pop()
        if isinstance(node, syntax.Name | syntax.NamePattern | syntax.Constructor):
            symbol = names.find(node)
            if symbol is not None:
                yield symbol
        if not isinstance(node, syntax.AnnotationDeclaration | syntax.ImportDeclaration):
            waiting.extend(children(node))


def components(units: Sequence[DependencyUnit]) -> list[list[DependencyUnit]]:
    """The strongly connected components, each in the order of the script, users behind what they use.

    Tarjan's algorithm, without recursion.
    """
    position = {unit: i for i, unit in enumerate(units)}
    number: dict[DependencyUnit, int] = {}
    lowest: dict[DependencyUnit, int] = {}
    stack: list[DependencyUnit] = []
    on_stack: set[DependencyUnit] = set()
    found: list[list[DependencyUnit]] = []
    for root in units:
        if root in number:
            continue
        work: list[tuple[DependencyUnit, Iterator[DependencyUnit]]] = []

        def open_(unit: DependencyUnit, work: list[tuple[DependencyUnit, Iterator[DependencyUnit]]] = work) -> None:
            number[unit] = lowest[unit] = len(number)
            stack.append(unit)
            on_stack.add(unit)
            work.append(
                (unit, iter(sorted([used for used in unit.uses if used in position], key=position.__getitem__)))
            )

        open_(root)
        while work:
            unit, successors = work[-1]
            for used in successors:
                if used not in number:
                    open_(used)
                    break
                if used in on_stack:
                    lowest[unit] = min(lowest[unit], number[used])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    lowest[above] = min(lowest[above], lowest[unit])
                if lowest[unit] == number[unit]:
                    component: list[DependencyUnit] = []
                    while True:
                        member = stack.pop()
                        on_stack.discard(member)
                        component.append(member)
                        if member is unit:
                            break
                    component.sort(key=position.__getitem__)
                    found.append(component)
    return found


def path(start: Sequence[DependencyUnit], goal: DependencyUnit) -> list[DependencyUnit]:
    """A shortest way from one of *start* to *goal* along uses, both ends included; empty if there is none."""
    before: dict[DependencyUnit, DependencyUnit | None] = dict.fromkeys(start)
    queue = list(start)
    for unit in queue:
        if unit is goal:
            way = [unit]
            while (previous := before[way[-1]]) is not None:
                way.append(previous)
            return way[::-1]
        for used in unit.uses:
            if used not in before:
                before[used] = unit
                queue.append(used)
    return []
