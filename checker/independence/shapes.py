"""How many values the states of a process hold, and whether its states are determined by what has happened."""

from __future__ import annotations

from typing import Final

from cspcheck.checker.independence.reading import COMPRESSIONS, ProcessReader, bodies
from cspcheck.checker.independence.uses import total
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.oz.processes.alphabets import Alphabets
from cspcheck.cspm.oz.processes.nodes import ClassProcess
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.syntax.children import children

_BOTH: Final = (s.Synchronised, s.AlphabetisedParallel, s.LinkedParallel, s.ClassParallel, s.ProcessBinary)


class StateSize:
    """The most values of the type that states of a process hold, by the variables in scope.

    A process whose definitions use each other one after the other holds what the largest of them holds; parallel
    processes, and choices that move on before they are made, hold the sum.
    """

    def __init__(self, reader: ProcessReader) -> None:
        self.reader = reader
        self.script = reader.script
        self.names = reader.names
        self._known: dict[int, int | None] = {}
        self._waiting: set[int] = set()
        self._free: dict[int, frozenset[Symbol]] = {}

    def of(self, node: s.Expr) -> int | None:
        """The most values at one time; None: no bound is known."""
        if id(node) in self._known:
            return self._known[id(node)]
        if id(node) in self._waiting:
            return None  # it grows with each round
        self._waiting.add(id(node))
        most: int | None = 0
        seen: set[Symbol] = set()
        work = [node]
        while work and most is not None:
            held = self._local(work.pop(), work, seen)
            most = None if held is None else max(most, held)
        self._waiting.discard(id(node))
        if not self._waiting:
            self._known[id(node)] = most
        return most

    def _local(self, node: s.Expr, work: list[s.Expr], seen: set[Symbol]) -> int | None:
        """What the states of one form hold; what it becomes is added to *work*."""
        held = self.free(node)
        is_menu = self.reader.is_menu
        match node:
            case s.Paren():
                work.append(node.inner)
            case s.Prefix() | s.Guard() | s.Let():
                work.append(node.body)
            case s.If():
                work += [node.then, node.otherwise]
            case s.Replicated(operator="[]" | "|~|"):
                work.append(node.body)
                if node.operator == "[]" and not is_menu(node.body, ()) and self.of(node.body) != 0:
                    return None
            case s.Replicated():
                return 0 if held == 0 and self.of(node.body) == 0 else None
            case s.ProcessBinary(operator="|~|"):
                work += [node.left, node.right]
            case s.ProcessBinary(operator="[]" | "[>") if is_menu(node.left, ()) and is_menu(node.right, ()):
                work += [node.left, node.right]
            case s.ProcessBinary(operator=";") | s.Synchronised(operator="[|>"):
                work.append(node.right)
                return total([self.of(node.left), *map(self.free, _others(node, node.left))])
            case _ if isinstance(node, _BOTH):
                parts = [self.of(node.left), self.of(node.right)]
                return total([*parts, *map(self.free, _others(node, node.left, node.right))])
            case s.Hide() | s.Rename():
                return total([self.of(node.process), *map(self.free, _others(node, node.process))])
            case ClassProcess():
                return total([self.script.data(node).held, *map(self.of, node.mains)])
            case s.Name() | s.Apply():
                return self._call(node, held, work, seen)
            case _:
                return None
        return held

    def _call(self, node: s.Name | s.Apply, held: int | None, work: list[s.Expr], seen: set[Symbol]) -> int | None:
        symbol = self.reader.called(node)
        if symbol is None:
            return None
        if symbol.kind is SymbolKind.BUILTIN:
            if isinstance(node, s.Apply) and symbol.name in COMPRESSIONS:
                work += node.arguments
            elif symbol.name not in ("STOP", "SKIP", "DIV", "RUN", "CHAOS"):
                return None
        elif symbol not in seen:
            seen.add(symbol)
            work += bodies(symbol)
        return held

    def free(self, node: s.Node) -> int | None:
        """The most values in the variables that an expression uses and does not bind."""
        counts: list[int | None] = []
        for symbol in self._variables(node):
            assert isinstance(symbol.declaration, s.Pattern)
            counts.append(self.script.touched.slots(self.script.types.type_of(symbol.declaration)))
        return total(counts)

    def _variables(self, node: s.Node) -> frozenset[Symbol]:
        known = self._free.get(id(node))
        if known is None:
            self._free[id(node)] = frozenset()  # of a function that uses itself the rest of it tells
            known = self._free[id(node)] = self._variables_of(node)
        return known

    def _variables_of(self, node: s.Node) -> frozenset[Symbol]:
        used: set[Symbol] = set()
        bound: set[Symbol] = set()
        stack: list[s.Node] = [node]
        followed: set[Symbol] = set()
        while stack:
            current = stack.pop()
            symbol = self.names.find(current)
            if symbol is not None and symbol.is_local:
                if isinstance(current, s.Pattern):
                    bound.add(symbol)
                elif symbol.kind is SymbolKind.VARIABLE:
                    used.add(symbol)
                elif symbol not in followed and symbol.declaration is not None:
                    followed.add(symbol)  # a local definition, with the variables around it
                    stack.append(symbol.declaration)
            stack.extend(children(current))
        return frozenset(used - bound)


class Determined:
    """Whether what has happened determines, values apart, where a process is (condition *Norm* of the theorems).

    So it is where processes are sequential and of the branches of each choice, external or internal, no two begin
    with the same channel.
    """

    def __init__(self, reader: ProcessReader) -> None:
        self.reader = reader
        self._assumed: set[Symbol] = set()

    def of(self, node: s.Expr) -> bool:
        """Whether a process is determined; of a definition that uses itself it is assumed meanwhile."""
        match node:
            case s.Paren():
                return self.of(node.inner)
            case s.Prefix():
                return self.of(node.body)
            case s.Guard() | s.Let():
                return self.of(node.body)
            case s.If():
                return self.of(node.then) and self.of(node.otherwise)
            case s.ProcessBinary(operator="[]" | "|~|" | "[>"):
                first, second = self.first(node.left, ()), self.first(node.right, ())
                if first is None or second is None or first & second:
                    return False
                return self.of(node.left) and self.of(node.right)
            case s.Replicated(operator="[]" | "|~|"):
                return self._is_told(node) and self.of(node.body)
            case ClassProcess():
                alphabets = Alphabets(self.reader.names)
                if any(alphabets.mentions_skip(main) for main in node.mains):
                    return False
                return self.reader.script.data(node).normal and all(map(self.of, node.mains))
        symbol = self.reader.called(node)
        if symbol is None:
            return False
        if symbol.kind is SymbolKind.BUILTIN:
            return symbol.name in ("STOP", "SKIP", "RUN", "CHAOS", "DIV")
        if symbol not in self._assumed:
            self._assumed.add(symbol)
            return all(map(self.of, bodies(symbol)))
        return True

    def first(self, node: s.Expr, waiting: tuple[Symbol, ...]) -> frozenset[Symbol] | None:
        """The channels that a process may begin with; None where that is not known."""
        match node:
            case s.Paren():
                return self.first(node.inner, waiting)
            case s.Prefix():
                return self.reader.heads(node.channel) or None
            case s.Guard() | s.Let():
                return self.first(node.body, waiting)
            case s.If():
                return _union(self.first(node.then, waiting), self.first(node.otherwise, waiting))
            case s.ProcessBinary(operator="[]" | "|~|" | "[>"):
                return _union(self.first(node.left, waiting), self.first(node.right, waiting))
            case s.Replicated(operator="[]" | "|~|"):
                return self.first(node.body, waiting)
        symbol = self.reader.called(node)
        if symbol is None or symbol in waiting:
            return None
        if symbol.kind is SymbolKind.BUILTIN:
            return frozenset() if symbol.name == "STOP" else None
        found: frozenset[Symbol] | None = frozenset()
        for body in bodies(symbol):
            found = _union(found, self.first(body, (*waiting, symbol)))
        return found

    def _is_told(self, node: s.Replicated) -> bool:
        """Whether the first event of a choice over values tells which one was made."""
        variables = set()
        for statement in node.statements:
            if not isinstance(statement, s.Generator):
                continue
            if not isinstance(statement.pattern, s.NamePattern):
                return False
            variables.add(self.reader.names.symbol(statement.pattern))
        body = node.body
        while isinstance(body, s.Paren | s.Guard):
            body = body.inner if isinstance(body, s.Paren) else body.body
        if not isinstance(body, s.Prefix):
            return False
        waiting: list[s.Expr] = [body.channel, *[f.expression for f in body.fields if f.expression is not None]]
        while waiting:
            part = waiting.pop()
            if isinstance(part, s.Dot):
                waiting += [part.left, part.right]
            elif isinstance(part, s.Paren):
                waiting.append(part.inner)
            elif isinstance(part, s.Name):
                symbol = self.reader.names.find(part)
                if symbol is not None:
                    variables.discard(symbol)
        return not variables


def _others(node: s.Node, *known: s.Node) -> list[s.Node]:
    """What is directly inside a node beside some parts."""
    return [child for child in children(node) if not any(child is part for part in known)]


def _union(left: frozenset[Symbol] | None, right: frozenset[Symbol] | None) -> frozenset[Symbol] | None:
    return None if left is None or right is None else left | right
