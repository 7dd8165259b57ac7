"""What the assertions of a script use, through all definitions: the rest need not be written for them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from cspcheck.cspm.naming.symbols import Names
from cspcheck.cspm.oz.processes.nodes import ClassExpression, ClassModule
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children
from cspcheck.cspm.syntax.tree import Declaration, Node


def flat(declarations: Iterable[Declaration]) -> Iterator[Declaration]:
    """The declarations with those of included files in their places."""
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration):
            yield from flat(declaration.declarations)
        else:
            yield declaration


class Reach:
    """Which declarations at the top of a script are used by which parts of it."""

    def __init__(self, declarations: Sequence[Declaration], names: Names) -> None:
        self._names = names
        self._top: dict[int, Declaration] = {}
        for declaration in declarations:
            for inner in _declared_inside(declaration):
                self._top[id(inner)] = declaration

    def of(self, nodes: Iterable[Node]) -> frozenset[int]:
        """The identities of the declarations that *nodes* use, directly or by way of others.

        Of a class that is used everything counts, since it is written as a whole.
        """
        found: set[int] = set()
        stack: list[Node] = list(nodes)
        while stack:
            current = stack.pop()
            if isinstance(current, ClassExpression):
                stack.extend(current.names)
            symbol = self._names.find(current) if isinstance(current, syntax.Name | syntax.NamePattern) else None
            if symbol is not None and symbol.declaration is not None:
                top = self._top.get(id(symbol.declaration))
                if top is not None and id(top) not in found:
                    found.add(id(top))
                    stack.append(top)
            stack.extend(children(current))
        return frozenset(found)

    def of_classes(self, declaration: Declaration) -> bool:
        """Whether a declaration is one of the Object-Z part, or uses one."""
        tops = {id(top): top for top in self._top.values()}
        used = [declaration, *[tops[i] for i in self.of([declaration])]]
        return any(isinstance(d, ClassModule) or _has_foreign(d) for d in used)


def _declared_inside(declaration: Declaration) -> Iterator[Node]:
    stack: list[Node] = [declaration]
    while stack:
        current = stack.pop()
        yield current
        stack.extend(children(current))


def _has_foreign(declaration: Declaration) -> bool:
    return any(isinstance(node, ClassExpression) for node in _declared_inside(declaration))
