"""The local variables that an expression uses and does not bind itself."""

from __future__ import annotations

from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children


def mentioned(node: syntax.Node, names: Names, known: dict[int, frozenset[Symbol]]) -> frozenset[Symbol]:
    """The symbols of local things that *node* mentions, those bound inside it among them.

    Symbols are unique, so what is bound inside is never confused with what is outside: who asks knows his own.
    Shared sets keep this linear for long chains; *known* remembers the results.
    """
    result = known.get(id(node))
    if result is not None:
        return result
    stack: list[tuple[syntax.Node, bool]] = [(node, False)]
    while stack:
        current, expanded = stack.pop()
        if id(current) in known:
            continue
        inside = children(current)
        if not expanded:
            stack.append((current, True))
            stack.extend((child, False) for child in inside)
            continue
        found: frozenset[Symbol] = frozenset()
        for child in inside:
            more = known[id(child)]
            if not found <= more:
                found = found if more <= found else found | more
            else:
                found = more
        if isinstance(current, syntax.Name):
            symbol = names.find(current)
            if symbol is not None and symbol.is_local:
                found = found | {symbol}
        elif isinstance(current, syntax.Prefix):
            # what a prefix binds is used nowhere else; long chains of inputs would drag it all along
            patterns = [field.pattern for field in current.fields if field.pattern is not None]
            found = found.difference(names.find(node) for pattern in patterns for node in variables(pattern))
        known[id(current)] = found
    return known[id(node)]
