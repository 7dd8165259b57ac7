"""The types of patterns."""

from __future__ import annotations

from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing.inference.context import INFERS, InferenceContext
from cspcheck.cspm.typing.types import BOOL, CHAR, EQ, INT, Scheme, SequenceOf, SetOf, TupleOf, Type, dotted

LITERALS: dict[str, Type] = {"int": INT, "bool": BOOL, "char": CHAR, "string": SequenceOf(CHAR)}


class PatternRules(InferenceContext):
    """One rule for each form of pattern. A variable gets its type where its pattern is met."""

    @INFERS(syntax.NamePattern)
    def _namepattern(self, node: syntax.NamePattern) -> Type:
        symbol = self.names.symbol(node)
        if symbol.kind is SymbolKind.VARIABLE:
            variable = self.fresh()
            self.views.schemes[symbol] = Scheme((), variable)
            return variable
        if symbol.kind is SymbolKind.VALUE:
            return self.defining[symbol]
        return self.symbol_type(symbol, node.span)

    @INFERS(syntax.Wildcard)
    def _wildcard(self, node: syntax.Wildcard) -> Type:
        return self.fresh()

    @INFERS(syntax.LiteralPattern)
    def _literalpattern(self, node: syntax.LiteralPattern) -> Type:
        return LITERALS[node.kind]

    @INFERS(syntax.ParenPattern)
    def _parenpattern(self, node: syntax.ParenPattern) -> Type:
        return self.infer(node.inner)

    @INFERS(syntax.TuplePattern)
    def _tuplepattern(self, node: syntax.TuplePattern) -> Type:
        return TupleOf([self.infer(item) for item in node.items])

    @INFERS(syntax.SequencePattern)
    def _sequencepattern(self, node: syntax.SequencePattern) -> Type:
        element: Type = self.fresh()
        for item in node.items:
            self.check(item, element, "this element of the sequence pattern")
        return SequenceOf(element)

    @INFERS(syntax.SetPattern)
    def _setpattern(self, node: syntax.SetPattern) -> Type:
        # A pattern compares, so the elements need equality although processes may be elements of sets.
        element: Type = self.fresh(EQ)
        for item in node.items:
            self.check(item, element, "the element of the set pattern")
        return SetOf(element)

    @INFERS(syntax.ConcatPattern)
    def _concatpattern(self, node: syntax.ConcatPattern) -> Type:
        whole = SequenceOf(self.fresh())
        self.check(node.left, whole, "the left part of the pattern")
        self.check(node.right, whole, "the right part of the pattern")
        return whole

    @INFERS(syntax.DotPattern)
    def _dotpattern(self, node: syntax.DotPattern) -> Type:
        items = [self.infer(node.left)]
        right = node.right
        while type(right) is syntax.DotPattern:
            items.append(self.infer(right.left))
            right = right.right
        items.append(self.infer(right))
        return dotted(items)

    @INFERS(syntax.BothPattern)
    def _bothpattern(self, node: syntax.BothPattern) -> Type:
        whole = self.infer(node.left)
        self.check(node.right, whole, "the pattern behind `@@`")
        return whole
