"""Which process of a script is meant when nobody says."""

from __future__ import annotations

from typing import Any

from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.script import Script
from cspcheck.cspm.syntax import tree as syntax


def candidates(script: Script) -> list[str]:
    """The top-level processes without parameters that are compositions and that no other definition mentions.

    One among them that is called ``SYSTEM`` or ``MAIN`` is the only candidate.
    """
    composed: list[str] = []
    mentioned: set[str] = set()
    for name, symbol in script.names.top_level.items():
        declaration = symbol.declaration
        if isinstance(declaration, syntax.FunctionDefinition):
            for clause in declaration.clauses:
                mentioned |= _names(clause.body) - {name}
        if symbol.kind is not SymbolKind.VALUE or not isinstance(declaration, syntax.PatternDefinition):
            continue
        mentioned |= _names(declaration.body) - {name}
        body = declaration.body
        while isinstance(body, (syntax.Paren, syntax.Hide, syntax.Rename)):
            body = body.inner if isinstance(body, syntax.Paren) else body.process
        parallel = (syntax.Synchronised, syntax.AlphabetisedParallel, syntax.LinkedParallel, syntax.ClassParallel)
        if (
            isinstance(body, parallel)
            or (isinstance(body, syntax.ProcessBinary) and body.operator == "|||")
            or (isinstance(body, syntax.Replicated) and body.operator in ("|||", "||", "[|", "<->"))
        ):
            composed.append(name)
    free = [name for name in composed if name not in mentioned]
    usual = [name for name in free if name.lower() in ("system", "main")]
    return usual if len(usual) == 1 else free or composed


def _names(node: Any) -> set[str]:
    """All names in a tree."""
    found: set[str] = set()
    todo = [node]
    while todo:
        one = todo.pop()
        if isinstance(one, syntax.Name):
            found.add(one.text)
        elif isinstance(one, syntax.Node):
            todo.extend(getattr(one, name) for name in one.__dataclass_fields__ if name != "span")
        elif isinstance(one, tuple):
            todo.extend(one)
    return found
