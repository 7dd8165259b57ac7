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
    for part in _joined(node, ("and",)):
        if isinstance(part, s.Chain):
            for place, relation in enumerate(part.relations):
                if relation == "in" and key(part.operands[place]) is not None:
                    yield part.operands[place], part.operands[place + 1]


def operation_facts(node: s.Term) -> Iterator[Fact]:
    """The memberships that hold where an operation happens."""
    for part in _joined(node, ("and", "enrich")):
        if isinstance(part, s.OperationText):
            for predicate in part.predicates:
                yield from facts(predicate)


def _joined(node: s.Term, operators: tuple[str, ...]) -> Iterator[s.Term]:
    """What operators join, from left to right, whatever the brackets."""
    stack = [node]
    while stack:
        part = stack.pop()
        if isinstance(part, s.Grouped):
            stack.append(part.inner)
        elif isinstance(part, s.Operator) and part.name in operators:
            stack.extend(reversed(part.operands))
        else:
            yield part
