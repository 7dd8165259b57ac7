"""Inputs that can match no event of their channel, whatever the parameters: allowed, but never meant.

``c?5 -> P`` over ``channel c : {0..3}`` is STOP, silently. Each input of a script is held against the sets that its
channel declares. What depends on a parameter (the channel itself, a constructor in front, the set of ``?x:S``) is left
alone, and so is what is too large to be gone through.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.evaluator.core import Evaluator
from cspcheck.cspm.evaluator.dotting import dot_parts
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.patterns import compile_pattern, flat_dots, is_irrefutable, named_head
from cspcheck.cspm.naming.messages import input_matches_nothing
from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children
from cspcheck.cspm.typing.inference import Types
from cspcheck.cspm.typing.types import Atom, Datatype, MapOf, SequenceOf, SetOf, TupleOf, resolve
from cspcheck.cspm.values.dots import Head
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import Set

MOST_VALUES = 4096
"""So many values of a field are held against a pattern."""

ONE_FIELD = (Atom, Datatype, SetOf, SequenceOf, TupleOf, MapOf)
"""The types whose values are one field each."""


def unmatched_inputs(
    evaluator: Evaluator, types: Types, declarations: Sequence[syntax.Declaration], top: Frame
) -> Iterator[Diagnostic]:
    """A warning for each input that matches nothing, in the order of the text."""
    waiting: list[syntax.Node] = [*reversed(declarations)]
    while waiting:
        node = waiting.pop()
        if isinstance(node, syntax.ModuleDeclaration) and node.parameters:
            continue  # the sets of its channels are those of its instances
        if isinstance(node, syntax.Prefix) and any(field.pattern is not None for field in node.fields):
            try:
                found = _Walk(evaluator, types, top).prefix(node)
            except Failure:
                found = None  # what is wrong with the channel is told where it is used
            if found is not None:
                yield found
        waiting.extend(reversed(children(node)))


class _Walk:
    """One prefix, part by part, with the sets of the fields that are still to come."""

    def __init__(self, evaluator: Evaluator, types: Types, top: Frame) -> None:
        self.evaluator = evaluator
        self.types = types
        self.top = top
        self.name = ""
        self.missing: list[Set] = []

    def prefix(self, node: syntax.Prefix) -> Diagnostic | None:
        channel, *given = dot_parts(node.channel)
        if not isinstance(channel, syntax.Name):
            return None
        symbol = self.evaluator.names.find(channel)
        if symbol is None or symbol.kind is not SymbolKind.CHANNEL or symbol.instance is not None:
            return None
        head = self.top.unit.things.get(symbol)
        if not isinstance(head, Head):
            return None
        self.name, self.missing = head.name, [*head.domains]
        for expression in given:
            if not self._take(expression):
                return None
        for i, field in enumerate(node.fields):
            if field.expression is not None:
                for expression in dot_parts(field.expression):
                    if not self._take(expression):
                        return None
                continue
            assert field.pattern is not None
            if field.restriction is not None:
                if not self._take(field.pattern):
                    return None
                continue
            parts = flat_dots(field.pattern)
            for j, pattern in enumerate(parts):
                last = i == len(node.fields) - 1 and j == len(parts) - 1
                if not self.missing or (last and len(self.missing) > 1):
                    return None
                if not self._matches(pattern):
                    return input_matches_nothing(pattern.span, pattern.span.text, self.name, self.missing[0])
                if named_head(self.evaluator, pattern, self.top) is None:
                    del self.missing[0]
        return None

    def _take(self, node: syntax.Expr | syntax.Pattern) -> bool:
        """Leave the field that *node* stands for behind; False if it may stand for more than one."""
        if not self.missing or type(resolve(self.types.type_of(node))) not in ONE_FIELD:
            return False
        del self.missing[0]
        return True

    def _matches(self, pattern: syntax.Pattern) -> bool:
        """Whether *pattern* can be the next field; a constructor puts its own fields in its place."""
        expected = self.missing[0]
        find = named_head(self.evaluator, pattern, self.top)
        if find is not None:
            head = find()
            if not expected.may_contain_head(head):
                return False
            self.missing[0:1] = head.domains
            return bool(head.domains) or not expected.is_finite() or expected.contains(head.value)
        if is_irrefutable(self.evaluator, pattern) or not expected.is_finite() or expected.exceeds(MOST_VALUES):
            return True
        matcher, _ = compile_pattern(self.evaluator, pattern, Frame.outermost(self.top.unit), evaluated=True)
        return any(matcher((), value) is not None for value in expected.elements())
