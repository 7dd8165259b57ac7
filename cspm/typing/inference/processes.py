"""The types of operators on processes."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing.inference.context import INFERS
from cspcheck.cspm.typing.inference.expressions import Collection, ExpressionRules
from cspcheck.cspm.typing.types import BOOL, COMPLETE, EVENT, PROC, Extendable, SequenceOf, SetOf, Type, dotted
from cspcheck.cspm.typing.unification import TypeClash

EVENTS = SetOf(EVENT)

_SPELLING = {"[|": "[| |]", "[+": "[+ +]", "/+": "/+ +\\", "[|>": "[| |>", "||": "[ || ]", "<->": "[ <-> ]"}


class ProcessRules(ExpressionRules):
    """One rule for each form of process."""

    def _process(self, node: syntax.Expr, role: str) -> None:
        self.check(node, PROC, role)

    def _operands(self, left: syntax.Expr, right: syntax.Expr, operator: str) -> None:
        self._process(left, f"the left operand of `{operator}`")
        self._process(right, f"the right operand of `{operator}`")

    # --- prefixes --------------------------------------------------------------------------------------------

    @INFERS(syntax.Prefix)
    def _prefix(self, node: syntax.Prefix) -> Type:
        if not node.fields:
            self.check(node.channel, EVENT, "the event of the prefix")
        else:
            items = [self.infer(node.channel)]
            items.extend([self._field(field) for field in node.fields])
            event = dotted(items)
            try:
                self.unifier.unify(EVENT, event)
            except TypeClash as clash:
                # The channel and its fields are one event; the place of the message is all of them.
                span = node.channel.span.to(node.fields[-1].span)
                head = syntax.Prefix(span=span, channel=node.channel, fields=node.fields, body=node.body)
                raise self.rejected(clash, EVENT, event, head, "the event of the prefix", None) from None
        self._process(node.body, "what follows the prefix")
        return PROC

    @INFERS(syntax.Field)
    def _field(self, field: syntax.Field) -> Type:
        """The type of what a field contributes to the event."""
        if field.expression is not None:
            return self.infer(field.expression)
        assert field.pattern is not None
        restriction = None if field.restriction is None else self.infer(field.restriction)
        pattern = self.infer(field.pattern)
        if restriction is not None:
            assert field.restriction is not None
            self.accept(SetOf(pattern), restriction, field.restriction, "the set of the field")
        self.require(COMPLETE, pattern, field.pattern, "an input" if field.kind == "?" else "a choice of fields")
        return pattern

    # --- operators -------------------------------------------------------------------------------------------

    @INFERS(syntax.Guard)
    def _guard(self, node: syntax.Guard) -> Type:
        self.check(node.condition, BOOL, "the guard")
        self._process(node.body, "the guarded process")
        return PROC

    @INFERS(syntax.ProcessBinary)
    def _processbinary(self, node: syntax.ProcessBinary) -> Type:
        self._operands(node.left, node.right, node.operator)
        return PROC

    @INFERS(syntax.Synchronised)
    def _synchronised(self, node: syntax.Synchronised) -> Type:
        operator = _SPELLING[node.operator]
        self._operands(node.left, node.right, operator)
        self.check(node.events, EVENTS, f"the set of `{operator}`")
        return PROC

    @INFERS(syntax.AlphabetisedParallel)
    def _alphabetisedparallel(self, node: syntax.AlphabetisedParallel) -> Type:
        self._operands(node.left, node.right, "[ || ]")
        self.check(node.left_alphabet, EVENTS, "the left alphabet of `[ || ]`")
        self.check(node.right_alphabet, EVENTS, "the right alphabet of `[ || ]`")
        return PROC

    @INFERS(syntax.ClassParallel)
    def _classparallel(self, node: syntax.ClassParallel) -> Type:
        self._operands(node.left, node.right, "||")
        return PROC

    @INFERS(syntax.Hide)
    def _hide(self, node: syntax.Hide) -> Type:
        operator = "|\\" if node.keep else "\\"
        self._process(node.process, f"the left operand of `{operator}`")
        self.check(node.events, EVENTS, f"the set of `{operator}`")
        return PROC

    @INFERS(syntax.Rename)
    def _rename(self, node: syntax.Rename) -> Type:
        self._process(node.process, "the renamed process")
        self.statements(node.statements, SetOf, "a renaming")
        self._pairs(node.pairs, "<-")
        return PROC

    @INFERS(syntax.LinkedParallel)
    def _linkedparallel(self, node: syntax.LinkedParallel) -> Type:
        self._operands(node.left, node.right, "[ <-> ]")
        self.statements(node.statements, SetOf, "a linked parallel")
        self._pairs(node.links, "<->")
        return PROC

    def _pairs(self, pairs: Sequence[tuple[syntax.Expr, syntax.Expr]], arrow: str) -> None:
        """Both sides of a pair are events, or want the same fields to become events."""
        for left, right in pairs:
            side = Extendable(self.fresh(), EVENT)
            self.check(left, side, f"the left side of `{arrow}`")
            self.check(right, side, f"the right side of `{arrow}`", self._elsewhere(left, side, "the left side"))

    @INFERS(syntax.Replicated)
    def _replicated(self, node: syntax.Replicated) -> Type:
        operator = _SPELLING.get(node.operator, node.operator)
        kind: Collection = SequenceOf if node.operator in (";", "<->") else SetOf
        inside = node.operator == "||"
        if node.events is not None and not inside:
            self.check(node.events, EVENTS, f"the set of the replicated `{operator}`")
        self.statements(node.statements, kind, f"the replicated `{operator}`")
        if node.events is not None and inside:
            self.check(node.events, EVENTS, f"the alphabet of the replicated `{operator}`")
        if node.links:
            self.statements(node.link_statements, SetOf, "a linked parallel")
            self._pairs(node.links, "<->")
        self._process(node.body, f"the body of the replicated `{operator}`")
        return PROC
