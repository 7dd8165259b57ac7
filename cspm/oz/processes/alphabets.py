"""The channels that a process may use, found by looking at what its definitions mention.

``P || Q`` joins classes on the channels that both have, and the CSP part of a class meets its data part on the events
that occur in both: both questions are about channels, and are answered without running anything.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.oz.processes.nodes import ClassExpression, ClassProcess
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children

_FOLLOWED = frozenset({SymbolKind.VALUE, SymbolKind.FUNCTION, SymbolKind.VARIABLE})


class Alphabets:
    """The channels of expressions of one script."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._known: dict[Symbol, frozenset[Symbol]] = {}

    def of(self, node: syntax.Node) -> frozenset[Symbol]:
        """The channels that the process *node* may use; of a class all that it declares.

        What is hidden by its channel's name does not count. A definition that uses itself counts for what else
        it uses.
        """
        return self._of(node, set())

    def mentions_skip(self, node: syntax.Node) -> bool:
        """Whether a process could terminate: some definition that it uses mentions ``SKIP`` or may be a product of
        none.
        """
        seen: set[Symbol] = set()
        stack: list[syntax.Node] = [node]
        while stack:
            current = stack.pop()
            if isinstance(current, syntax.Replicated) and current.operator in (";", "|||", "||", "[|"):
                return True
            if isinstance(current, syntax.Name):
                symbol = self._names.find(current)
                if symbol is None:
                    continue
                if symbol.kind is SymbolKind.BUILTIN and symbol.name in ("SKIP", "WAIT"):
                    return True
                if symbol.kind in _FOLLOWED and symbol not in seen and symbol.declaration is not None:
                    seen.add(symbol)
                    stack.append(symbol.declaration)
                continue
            stack.extend(children(current))
        return False

    def foreign(self, nodes: Iterable[syntax.Node]) -> Iterator[ClassExpression]:
        """What the Object-Z part brings into some expressions, through all definitions that they use."""
        seen: set[Symbol] = set()
        stack = list(nodes)
        while stack:
            current = stack.pop()
            if isinstance(current, ClassExpression):
                yield current
            symbol = self._names.find(current) if isinstance(current, syntax.Name) else None
            if symbol is not None and symbol.declaration is not None and symbol not in seen:
                seen.add(symbol)
                stack.append(symbol.declaration)
            stack.extend(children(current))

    def _of(self, node: syntax.Node, waiting: set[Symbol]) -> frozenset[Symbol]:
        match node:
            case syntax.Name():
                symbol = self._names.find(node)
                return frozenset() if symbol is None else self._of_symbol(symbol, waiting)
            case ClassProcess():
                return frozenset([self._names.symbol(channel) for channel in node.channels])
            case syntax.Hide(keep=False):
                return self._of(node.process, waiting) - self._whole_channels(node.events)
        found: frozenset[Symbol] = frozenset()
        for child in children(node):
            found |= self._of(child, waiting)
        return found

    def _of_symbol(self, symbol: Symbol, waiting: set[Symbol]) -> frozenset[Symbol]:
        if symbol.kind is SymbolKind.CHANNEL:
            return frozenset([symbol])
        if symbol.kind not in _FOLLOWED or symbol.declaration is None or symbol in waiting:
            return frozenset()
        known = self._known.get(symbol)
        if known is None:
            waiting.add(symbol)
            known = self._of(symbol.declaration, waiting)
            waiting.discard(symbol)
            if not waiting:
                self._known[symbol] = known
        return known

    def _whole_channels(self, node: syntax.Expr) -> frozenset[Symbol]:
        """The channels of which a set of events certainly has all events: ``{| c, d |}``."""
        node = syntax.bare(node)
        if not isinstance(node, syntax.Productions) or node.statements is not None:
            return frozenset()
        symbols = [self._names.find(item) for item in node.items if isinstance(item, syntax.Name)]
        return frozenset([s for s in symbols if s is not None and s.kind is SymbolKind.CHANNEL])
