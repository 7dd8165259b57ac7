"""Patterns as documents, and what all rules of printing share."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from typing import Any, Final

from cspcheck.cspm.parsing.precedence import VALUE_LEVELS
from cspcheck.cspm.printing.brackets import (
    ANYWHERE,
    BOTH,
    DOT,
    NodePlace,
    bracketed,
    captures,
    enclosed,
    literal,
    part_of,
)
from cspcheck.cspm.printing.layout import Doc, cat
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.syntax.dispatch import Dispatch

Printing = Generator[tuple[s.Node, NodePlace], Doc, Doc]

PRINTS: Final = Dispatch[Callable[[Any, Any, NodePlace], Any]]("print")
"""The rules by the form of the node."""


class Patterns:
    """Prints patterns; expressions are added by a subclass."""

    def _items(self, nodes: Sequence[s.Node], place: NodePlace) -> Generator[tuple[s.Node, NodePlace], Doc, list[Doc]]:
        docs = []
        for node in nodes:
            docs.append((yield node, place))
        return docs

    @PRINTS(s.NamePattern)
    def _print_name_pattern(self, node: s.NamePattern, place: NodePlace) -> Doc:
        return node.text

    @PRINTS(s.Wildcard)
    def _print_wildcard(self, node: s.Wildcard, place: NodePlace) -> Doc:
        return "_"

    @PRINTS(s.LiteralPattern)
    def _print_literal_pattern(self, node: s.LiteralPattern, place: NodePlace) -> Doc:
        text = literal(node.kind, node.value)
        return bracketed(text) if text.startswith("-") and captures("-", place) else text

    @PRINTS(s.ParenPattern)
    def _print_paren_pattern(self, node: s.ParenPattern, place: NodePlace) -> Printing:
        return bracketed((yield node.inner, ANYWHERE))

    @PRINTS(s.TuplePattern)
    def _print_tuple_pattern(self, node: s.TuplePattern, place: NodePlace) -> Printing:
        return enclosed("(", (yield from self._items(node.items, ANYWHERE)), ")", node.items)

    @PRINTS(s.SequencePattern)
    def _print_sequence_pattern(self, node: s.SequencePattern, place: NodePlace) -> Printing:
        return enclosed("<", (yield from self._items(node.items, ANYWHERE)), ">", node.items)

    @PRINTS(s.SetPattern)
    def _print_set_pattern(self, node: s.SetPattern, place: NodePlace) -> Printing:
        return enclosed("{", (yield from self._items(node.items, ANYWHERE)), "}", node.items)

    @PRINTS(s.ConcatPattern)
    def _print_concat_pattern(self, node: s.ConcatPattern, place: NodePlace) -> Printing:
        level = VALUE_LEVELS["^"]
        spine = [node]
        while isinstance(spine[-1].left, s.ConcatPattern):
            spine.append(spine[-1].left)
        spine.reverse()
        brackets = place.level < level
        inside = part_of(place, brackets)
        parts = [(yield spine[0].left, replace(inside, level=level, follow=level))]
        for concat in spine:
            follow = inside.follow if concat is node else level
            parts += ["^", (yield concat.right, replace(inside, level=level - 1, follow=follow))]
        doc = cat(*parts)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.DotPattern)
    def _print_dot_pattern(self, node: s.DotPattern, place: NodePlace) -> Printing:
        brackets = place.level < DOT
        return (yield from self._dotted(node, part_of(place, brackets, level=DOT - 1), brackets))

    def _dotted(self, node: s.Dot | s.DotPattern, inside: NodePlace, brackets: bool) -> Printing:
        """Fields with dots between them, each printed in the place *inside*."""
        parts: list[Doc] = []
        rest: s.Node = node
        while isinstance(rest, s.Dot | s.DotPattern):
            parts += [(yield rest.left, replace(inside, follow=DOT)), "."]
            rest = rest.right
        parts.append((yield rest, inside))
        doc = cat(*parts)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.BothPattern)
    def _print_both_pattern(self, node: s.BothPattern, place: NodePlace) -> Printing:
        brackets = place.level < BOTH
        inside = part_of(place, brackets, level=BOTH - 1)
        left = yield node.left, replace(inside, follow=BOTH)
        right = yield node.right, inside
        doc = cat(left, " @@ ", right)
        return bracketed(doc) if brackets else doc
