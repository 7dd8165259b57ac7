"""The declarations of scripts and modules as a whole: what is declared where, and modules that contain themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.naming import messages as messages
from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax


def flatten(declarations: Iterable[syntax.Declaration]) -> Iterator[syntax.Declaration]:
    """The declarations of one scope: those of includes and Timed sections are of the scope around them."""
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration | syntax.TimedDeclaration):
            yield from flatten(declaration.declarations)
        else:
            yield declaration


def declared_names(declaration: syntax.Declaration, names: Names) -> list[str]:
    """What one declaration adds to its scope, its patterns tied already."""
    match declaration:
        case (
            syntax.FunctionDefinition()
            | syntax.NametypeDeclaration()
            | syntax.ModuleDeclaration()
            | syntax.InstanceDeclaration()
            | syntax.DatatypeDeclaration(subtype=True)
        ):
            return [declaration.name]
        case syntax.ChannelDeclaration() | syntax.ImportDeclaration():
            return [name.name for name in declaration.names]
        case syntax.DatatypeDeclaration():
            return [declaration.name, *(c.name for c in declaration.constructors)]
        case syntax.PatternDefinition():
            bound = ((node, names.find(node)) for node in variables(declaration.pattern))
            return [node.text for node, symbol in bound if symbol is not None and symbol.kind is SymbolKind.VALUE]
    return []


def module_cycles(symbols: Iterable[Symbol]) -> Iterator[Diagnostic]:
    """Modules whose instances would contain instances of themselves without end.

    The instances in a module without parameters exist as soon as the module around it does; those in one with
    parameters exist only in its instances.
    """
    instances: dict[Symbol, list[tuple[Symbol, Symbol]]] = {}

    def collect(module: Symbol) -> list[tuple[Symbol, Symbol]]:
        found: list[tuple[Symbol, Symbol]] = []
        for member in module.members.values():
            if member.kind is SymbolKind.INSTANCE and member.module is not None:
                found.append((member.module.base, member))
            elif member.kind is SymbolKind.MODULE:
                inner = collect(member)
                if not member.parameters_declared:
                    found.extend(inner)
        instances[module] = found
        return found

    for symbol in symbols:
        if symbol.kind is SymbolKind.MODULE:
            collect(symbol)
    done: set[Symbol] = set()

    def follow(module: Symbol, path: list[Symbol]) -> Iterator[Diagnostic]:
        if module in path:
            cycle = path[path.index(module) :]
            span = next(i.span for m, i in instances[cycle[-1]] if m is module)
            assert span is not None
            yield messages.module_cycle([m.name for m in [*cycle, module]], span)
            return
        if module in done:
            return
        for target, _ in instances.get(module, ()):
            yield from follow(target, [*path, module])
        done.add(module)

    for module in list(instances):
        yield from follow(module, [])
