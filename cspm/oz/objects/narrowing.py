"""What memberships tell of the classes of references."""

from __future__ import annotations

from collections.abc import Iterator

from cspcheck.cspm.oz import syntax as s

Fact = tuple[s.Term, s.Term]
"""A reference and the set that it is said to be in."""


def is_logical(node: s.Term) -> bool:
    """Whether an operator joins predicates (or schemas)."""
    return isinstance(node, s.Operator) and node.name in ("and", "or", "implies", "iff", "not")


def key(node: s.Term) -> str | None:
    """What a reference is called in a scope that knows more of it: ``a``, ``a'``, ``a.b``; None for other terms."""
    path: list[str] = []
    while True:
        match node:
            case s.Grouped():
                node = node.inner
            case s.Selection():
                path.append(node.field + node.decoration)
                node = node.record
            case s.Reference(arguments=()):
                return ".".join([node.name + node.decoration, *reversed(path)])
            case _:
                return None


def facts(node: s.Term) -> Iterator[Fact]:
    """The memberships of references that hold where a predicate does."""
    stack = [node]
    while stack:
        part = stack.pop()
        match part:
            case s.Grouped():
                stack.append(part.inner)
            case s.Operator(name="and", operands=operands):
                stack.extend(reversed(operands))
            case s.Chain(relations=relations, operands=operands):
                for place, relation in enumerate(relations):
                    if relation == "in" and key(operands[place]) is not None:
                        yield operands[place], operands[place + 1]


def operation_facts(node: s.Term) -> Iterator[Fact]:
    """The memberships that hold where an operation happens."""
    stack = [node]
    while stack:
        part = stack.pop()
        match part:
            case s.Grouped():
                stack.append(part.inner)
            case s.Operator(name="and" | "enrich", operands=operands):
                stack.extend(reversed(operands))
            case s.OperationText(predicates=predicates):
                for predicate in predicates:
                    yield from facts(predicate)
