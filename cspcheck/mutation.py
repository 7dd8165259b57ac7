"""Mutants of a script: what it would be with one small mistake in it.

Mutation analysis (DeMillo, Lipton, Sayward 1978) turned on specifications: a change that no assertion notices is a
promise that nobody has written down. Each mutant changes one place: a synchronisation, a guard, an event, a constant,
an operator, a hidden event, a renaming, or a predicate of a class. Assertions, declarations of channels and types, and
what is only printed stay as they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypeVar, get_args

from cspcheck.cspm.oz import syntax as oz
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax

Kind = Literal["synchronisation", "guard", "event", "constant", "operator", "hiding", "renaming", "predicate"]
KINDS: tuple[Kind, ...] = get_args(Kind)

N = TypeVar("N", bound=syntax.Node)


@dataclass(frozen=True, slots=True)
class Change:
    """What is different in a mutant.

    Attributes:
        kind: what sort of thing is changed.
        span: the place.
        text: what is done, as in "`n < 2` becomes `n <= 2`".
    """

    kind: Kind
    span: Span
    text: str


_UNTOUCHED = (
    syntax.AssertDeclaration,
    syntax.PrintDeclaration,
    syntax.ChannelDeclaration,
    syntax.DatatypeDeclaration,
    syntax.NametypeDeclaration,
    syntax.ImportDeclaration,
    syntax.AnnotationDeclaration,
    oz.GivenTypes,
    oz.FreeType,
    oz.Reading,
    oz.View,
    oz.Retrieve,
    oz.Interface,
    oz.Declare,
)


def mutants(tree: syntax.Script) -> Iterator[tuple[Change, syntax.Script]]:
    """Every mutant of a script, in the order of the text."""
    yield from _within(tree)


def _within(node: N) -> Iterator[tuple[Change, N]]:
    """The mutants of a node: its own, then those of what it consists of."""
    if isinstance(node, _UNTOUCHED):
        return
    for change, other in _own(node):
        yield change, other
    for field in fields(node):
        if field.compare:
            for change, value in _values(getattr(node, field.name)):
                yield change, replace(node, **{field.name: value})


def _values(value: Any) -> Iterator[tuple[Change, Any]]:
    if isinstance(value, syntax.Node):
        yield from _within(value)
    elif isinstance(value, tuple):
        for i, item in enumerate(value):
            for change, other in _values(item):
                yield change, (*value[:i], other, *value[i + 1 :])


def _own(node: syntax.Node) -> Iterator[tuple[Change, Any]]:
    match node:
        case syntax.LiteralExpr():
            yield from _literal(node)
        case syntax.Binary():
            yield from _binary(node)
        case syntax.Guard():
            text = f"the guard `{_short(node.condition)}` is"
            yield Change("guard", node.condition.span, f"{text} left out"), node.body
            yield Change("guard", node.condition.span, f"{text} never true"), _stop(node)
        case syntax.If():
            text = f"the condition `{_short(node.condition)}` is always"
            yield Change("guard", node.condition.span, f"{text} true"), node.then
            yield Change("guard", node.condition.span, f"{text} false"), node.otherwise
        case syntax.Prefix():
            span = node.channel.span.to(node.fields[-1].span) if node.fields else node.channel.span
            if all(field.pattern is None for field in node.fields):
                yield Change("event", span, f"the event `{_line(span.text)}` is left out"), node.body
            yield Change("event", span, f"nothing happens instead of `{_line(span.text)}`"), _stop(node)
        case syntax.ProcessBinary():
            yield from _composed(node)
        case syntax.Synchronised(operator="[|"):
            yield from _fewer(node, "events", "synchronisation", "is not synchronised")
        case syntax.AlphabetisedParallel():
            yield from _fewer(node, "left_alphabet", "synchronisation", "is not in the left alphabet")
            yield from _fewer(node, "right_alphabet", "synchronisation", "is not in the right alphabet")
        case syntax.Replicated(operator="[|"):
            yield from _fewer(node, "events", "synchronisation", "is not synchronised")
        case syntax.Hide(keep=False):
            yield from _fewer(node, "events", "hiding", "is not hidden")
        case syntax.Rename() if node.statements is None:
            yield from _pairs(node)
        case oz.Number():
            yield (
                Change("constant", node.span, f"`{node.span.text}` becomes `{node.value + 1}`"),
                replace(node, value=node.value + 1),
            )
        case oz.Chain() if len(node.relations) == 1 and node.relations[0] in _OTHER:
            other = _OTHER[node.relations[0]]
            text = f"`{_WRITTEN[node.relations[0]]}` becomes `{_WRITTEN[other]}` in `{_short(node)}`"
            yield Change("predicate", node.span, text), replace(node, relations=(other,))
        case oz.Operator(name="and" | "or"):
            other = "or" if node.name == "and" else "and"
            yield (
                Change("predicate", node.span, f"`{node.name}` becomes `{other}` in `{_short(node)}`"),
                replace(node, name=other),
            )
        case oz.Conditional():
            text = f"the condition `{_short(node.test)}` is always"
            yield Change("predicate", node.test.span, f"{text} true"), node.then
            yield Change("predicate", node.test.span, f"{text} false"), node.otherwise
        case oz.OperationSchema() | oz.State() | oz.Initial():
            for i, predicate in enumerate(node.predicates):
                yield (
                    Change("predicate", predicate.span, f"`{_short(predicate)}` is left out"),
                    replace(node, predicates=(*node.predicates[:i], *node.predicates[i + 1 :])),
                )


def leaves(declarations: Iterable[syntax.Declaration]) -> Iterator[syntax.Declaration]:
    """Declarations without those that only hold others: what is included, timed sections, modules."""
    for declaration in declarations:
        match declaration:
            case syntax.IncludeDeclaration() | syntax.TimedDeclaration():
                yield from leaves(declaration.declarations)
            case syntax.ModuleDeclaration():
                yield from leaves((*declaration.private, *declaration.exported))
            case _:
                yield declaration


class Reach:
    """Which declarations of a script stand behind which of its assertions, by the names that they mention.

    Names are taken as they are written: what is found is what could be meant, and never less than what is.
    """

    def __init__(self, tree: syntax.Script) -> None:
        self._declarations = list(leaves(tree.declarations))
        self._mentioned = [_words(declaration) for declaration in self._declarations]
        self._defining: dict[str, list[int]] = {}
        for i, declaration in enumerate(self._declarations):
            for name in _defined(declaration):
                self._defining.setdefault(name, []).append(i)

    def reached(self, *nodes: syntax.Node) -> frozenset[int]:
        """The declarations behind some expressions or assertions, by their numbers."""
        found: set[int] = set()
        waiting = [i for node in nodes for word in _words(node) for i in self._defining.get(word, ())]
        while waiting:
            i = waiting.pop()
            if i not in found:
                found.add(i)
                waiting += [j for word in self._mentioned[i] for j in self._defining.get(word, ())]
        return frozenset(found)

    def checked(self) -> frozenset[int]:
        """The declarations behind what is checked. What only the left sides of refinements speak of is no part of it:
        it says what is required."""
        nodes: list[syntax.Node] = []
        for declaration in self._declarations:
            if isinstance(declaration, syntax.AssertDeclaration):
                assertion = declaration.assertion
                while isinstance(assertion, syntax.NotAssertion):
                    assertion = assertion.inner
                nodes.append(assertion.implementation if isinstance(assertion, syntax.Refinement) else assertion)
        return self.reached(*nodes)

    def is_axiom(self, change: Change) -> bool:
        """Whether a change is in what is said of constants: of a class, or of the script."""
        return any(
            _holds(axiom, change)
            for declaration in self._declarations
            for axiom in (declaration, *getattr(declaration, "paragraphs", ()))
            if isinstance(axiom, oz.Axiom)
        )

    def is_in_class(self, change: Change) -> bool:
        """Whether a change is in a class."""
        return any(
            _holds(declaration, change) for declaration in self._declarations if isinstance(declaration, oz.Class)
        )

    def is_control(self, change: Change) -> bool:
        """Whether a change is in the process equations of a class, and so in nothing that its data depends on."""
        return any(
            _holds(equation, change)
            for declaration in self._declarations
            if isinstance(declaration, oz.Class)
            for equation in declaration.equations
        )

    def holding(self, change: Change) -> int | None:
        """The declaration that a change is in."""
        for i, declaration in enumerate(self._declarations):
            if _holds(declaration, change):
                return i
        return None


def _holds(node: syntax.Node, change: Change) -> bool:
    around, span = node.span, change.span
    return around.source is span.source and around.start <= span.start and span.end <= around.end


def _defined(declaration: syntax.Declaration) -> Iterator[str]:
    match declaration:
        case syntax.PatternDefinition():
            yield from _words(declaration.pattern)
        case syntax.ChannelDeclaration() | syntax.ImportDeclaration():
            yield from (name.name for name in declaration.names)
        case oz.Axiom():
            yield from _words(declaration)
        case _ if isinstance(name := getattr(declaration, "name", None), str):
            yield name


def _words(node: syntax.Node) -> frozenset[str]:
    return frozenset(_WORD.findall(node.span.text))


_WORD = re.compile(r"[A-Za-z_]\w*'*")
_OTHER = {
    "less": "at_most",
    "at_most": "less",
    "greater": "at_least",
    "at_least": "greater",
    "equal": "not_equal",
    "not_equal": "equal",
    "in": "notin",
    "notin": "in",
}
"""What a relation of a class becomes, and how these are written."""
_WRITTEN = {
    "less": "<",
    "at_most": "<=",
    "greater": ">",
    "at_least": ">=",
    "equal": "=",
    "not_equal": "/=",
    "in": "in",
    "notin": "notin",
}
_CSPM_OTHER: dict[str, syntax.BinaryOperator] = {
    "<": "<=",
    "<=": "<",
    ">": ">=",
    ">=": ">",
    "==": "!=",
    "!=": "==",
    "and": "or",
    "or": "and",
    "+": "-",
    "-": "+",
}


def _literal(node: syntax.LiteralExpr) -> Iterator[tuple[Change, Any]]:
    if node.kind == "int":
        for value in (int(node.value) + 1, int(node.value) - 1):
            if value >= 0:
                yield Change("constant", node.span, f"`{node.value}` becomes `{value}`"), replace(node, value=value)
    elif node.kind == "bool":
        was, now = ("true", "false") if node.value else ("false", "true")
        yield Change("constant", node.span, f"`{was}` becomes `{now}`"), replace(node, value=not node.value)


def _binary(node: syntax.Binary) -> Iterator[tuple[Change, Any]]:
    other = _CSPM_OTHER.get(node.operator)
    if other is not None:
        kind: Kind = "operator" if other in ("+", "-") else "guard"
        yield (
            Change(kind, node.span, f"`{node.operator}` becomes `{other}` in `{_short(node)}`"),
            replace(node, operator=other),
        )


def _composed(node: syntax.ProcessBinary) -> Iterator[tuple[Change, Any]]:
    if node.operator in ("[]", "|~|"):
        other: syntax.ProcessOperator = "|~|" if node.operator == "[]" else "[]"
        yield (
            Change("operator", node.span, f"`{node.operator}` becomes `{other}` in `{_short(node)}`"),
            replace(node, operator=other),
        )
        yield Change("operator", node.right.span, f"the alternative `{_short(node.right)}` is left out"), node.left
        yield Change("operator", node.left.span, f"the alternative `{_short(node.left)}` is left out"), node.right
    elif node.operator in ("/\\", "[>"):
        yield Change("operator", node.right.span, f"`{node.operator} {_short(node.right)}` is left out"), node.left


def _fewer(node: Any, field: str, kind: Kind, what: str) -> Iterator[tuple[Change, Any]]:
    """The mutants with a smaller set of events: an item less where they are listed, none at all otherwise."""
    written = getattr(node, field)
    if written is None:
        return
    events = written
    events = syntax.bare(events)
    if isinstance(events, syntax.SetExpr | syntax.Productions) and events.statements is None and events.items:
        for i, item in enumerate(events.items):
            smaller = replace(events, items=(*events.items[:i], *events.items[i + 1 :]))
            yield Change(kind, item.span, f"`{_short(item)}` {what}"), replace(node, **{field: smaller})
    elif not isinstance(events, syntax.SetExpr):
        none = syntax.SetExpr(span=written.span, items=())
        yield (
            Change(kind, written.span, f"nothing of `{_short(written)}` {what.replace('not ', '')}"),
            replace(node, **{field: none}),
        )


def _pairs(node: syntax.Rename) -> Iterator[tuple[Change, Any]]:
    for i, (old, new) in enumerate(node.pairs):
        rest = (*node.pairs[:i], *node.pairs[i + 1 :])
        changed = replace(node, pairs=rest) if rest else node.process
        yield Change("renaming", old.span, f"`{_short(old)}` is not renamed to `{_short(new)}`"), changed


def _stop(node: syntax.Node) -> syntax.Expr:
    return syntax.Name(span=node.span, parts=("STOP",))


def _short(node: syntax.Node) -> str:
    return _line(node.span.text)


def _line(text: str, most: int = 50) -> str:
    line = " ".join(text.split())
    return line if len(line) <= most else line[: most - 1] + "…"
