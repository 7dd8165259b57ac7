"""The types of expressions on values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from cspcheck.cspm.diagnostics import Label
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.inference.context import INFERS, Rejected, first_line
from cspcheck.cspm.typing.inference.fields import head_name
from cspcheck.cspm.typing.inference.patterns import LITERALS, PatternRules
from cspcheck.cspm.typing.types import (
    BOOL,
    EQ,
    INT,
    ORD,
    SET,
    YIELDABLE,
    Dotable,
    Extendable,
    Function,
    MapOf,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
    dotted,
    resolve,
    show,
)

Collection = type[SetOf] | type[SequenceOf]

ARITHMETIC = frozenset({"+", "-", "*", "/", "%"})
EQUALITY = frozenset({"==", "!="})
CONNECTIVES = frozenset({"and", "or"})


class ExpressionRules(PatternRules):
    """One rule for each form of expression that is not an operator on processes."""

    # --- plain values ----------------------------------------------------------------------------------------

    @INFERS(syntax.Name)
    def _name(self, node: syntax.Name) -> Type:
        return self.symbol_type(self.names.symbol(node), node.span)

    @INFERS(syntax.LiteralExpr)
    def _literalexpr(self, node: syntax.LiteralExpr) -> Type:
        return LITERALS[node.kind]

    @INFERS(syntax.Paren)
    def _paren(self, node: syntax.Paren) -> Type:
        return self.infer(node.inner)

    @INFERS(syntax.TupleExpr)
    def _tupleexpr(self, node: syntax.TupleExpr) -> Type:
        return TupleOf([self.infer(item) for item in node.items])

    @INFERS(syntax.Dot)
    def _dot(self, node: syntax.Dot) -> Type:
        items = [self.infer(node.left)]
        right = node.right
        while type(right) is syntax.Dot:
            items.append(self.infer(right.left))
            right = right.right
        items.append(self.infer(right))
        whole = dotted(items)
        self.dots.append((node, whole))
        return whole

    @INFERS(syntax.If)
    def _if(self, node: syntax.If) -> Type:
        self.check(node.condition, BOOL, "the condition of `if`")
        then = self.infer(node.then)
        self.check(node.otherwise, then, "the `else` branch", self._elsewhere(node.then, then, "the `then` branch"))
        return then

    def _elsewhere(self, node: syntax.Node, type_: Type, what: str) -> Callable[[], Label]:
        """Points to the place whose type another one must share."""
        return lambda: Label(node.span, f"{what} has type `{show(type_)[0]}`")

    # --- collections -----------------------------------------------------------------------------------------

    def _equal(self, items: Sequence[syntax.Expr], role: str) -> Type:
        """The one type of all *items*."""
        if not items:
            return self.fresh()
        first = self.infer(items[0])
        origin = self._elsewhere(items[0], first, "the first one")
        for item in items[1:]:
            self.check(item, first, role, origin)
        return first

    @INFERS(syntax.SetExpr)
    def _setexpr(self, node: syntax.SetExpr) -> Type:
        self.statements(node.statements, SetOf, "a set comprehension")
        element = self._equal(node.items, "this element of the set")
        self.require(SET, element, node.items[0] if node.items else node, "an element of a set")
        return SetOf(element)

    @INFERS(syntax.SetRange)
    def _setrange(self, node: syntax.SetRange) -> Type:
        self.statements(node.statements, SetOf, "a set comprehension")
        self._range(node)
        return SetOf(INT)

    @INFERS(syntax.SequenceExpr)
    def _sequenceexpr(self, node: syntax.SequenceExpr) -> Type:
        self.statements(node.statements, SequenceOf, "a sequence comprehension")
        return SequenceOf(self._equal(node.items, "this element of the sequence"))

    @INFERS(syntax.SequenceRange)
    def _sequencerange(self, node: syntax.SequenceRange) -> Type:
        self.statements(node.statements, SequenceOf, "a sequence comprehension")
        self._range(node)
        return SequenceOf(INT)

    def _range(self, node: syntax.SetRange | syntax.SequenceRange) -> None:
        self.check(node.low, INT, "the lower bound")
        if node.high is not None:
            self.check(node.high, INT, "the upper bound")

    @INFERS(syntax.Productions)
    def _productions(self, node: syntax.Productions) -> Type:
        self.statements(node.statements, SetOf, "a set comprehension")
        whole = self.fresh(YIELDABLE)
        for item in node.items:
            self.check(item, Extendable(self.fresh(), whole), "an item of `{| |}`")
        return SetOf(whole)

    @INFERS(syntax.MapExpr)
    def _mapexpr(self, node: syntax.MapExpr) -> Type:
        key = self._equal([key for key, _ in node.items], "this key of the map")
        value = self._equal([value for _, value in node.items], "this value of the map")
        return MapOf(key, value)

    # --- operators -------------------------------------------------------------------------------------------

    @INFERS(syntax.Binary)
    def _binary(self, node: syntax.Binary) -> Type:
        operator = node.operator
        if operator in ARITHMETIC or operator in CONNECTIVES:
            type_: Type = INT if operator in ARITHMETIC else BOOL
            self.check(node.left, type_, f"the left operand of `{operator}`")
            self.check(node.right, type_, f"the right operand of `{operator}`")
            return type_
        if operator == "^":
            whole = SequenceOf(self.fresh())
            self.check(node.left, whole, "the left operand of `^`")
            origin = self._elsewhere(node.left, whole, "the left operand")
            self.check(node.right, whole, "the right operand of `^`", origin)
            return whole
        left = self.infer(node.left)
        origin = self._elsewhere(node.left, left, "the left operand")
        self.check(node.right, left, f"the right operand of `{operator}`", origin)
        self.require(EQ if operator in EQUALITY else ORD, left, node, f"`{operator}`")
        return BOOL

    @INFERS(syntax.Unary)
    def _unary(self, node: syntax.Unary) -> Type:
        if node.operator == "#":
            self.check(node.operand, SequenceOf(self.fresh()), "the operand of `#`")
            return INT
        type_ = INT if node.operator == "-" else BOOL
        self.check(node.operand, type_, f"the operand of `{node.operator}`")
        return type_

    # --- functions -------------------------------------------------------------------------------------------

    @INFERS(syntax.Apply)
    def _apply(self, node: syntax.Apply) -> Type:
        function = resolve(self.infer(node.function))
        if type(function) is not Function:
            function = self._as_function(node, function)
        if len(function.parameters) != len(node.arguments):
            raise Rejected(
                messages.argument_count(
                    head_name(node.function) or "this function",
                    node.span,
                    show(function)[0],
                    len(function.parameters),
                    len(node.arguments),
                    (place,) if (place := self._definition(node.function)) else (),
                )
            )
        # All arguments first: what one says of a variable can decide how the dots of another are read.
        given = [self.infer(argument) for argument in node.arguments]
        for i, (argument, expected, actual) in enumerate(zip(node.arguments, function.parameters, given, strict=True)):
            role = _argument_role(i, len(given), head_name(node.function))
            try:
                self.accept(expected, actual, argument, role, lambda: self._definition(node.function))
            except Rejected as rejected:
                raise self._shared(rejected, node.function) from None
        return function.result

    def _shared(self, rejected: Rejected, function: syntax.Expr) -> Rejected:
        """The rejection of an argument, with what to do if the function has been used at another type before."""
        if isinstance(function, syntax.Name) and self.names.symbol(function) in self.shared:
            help_line = f"without an annotation the local `{function.text}` has one type in all its uses"
            return Rejected(replace(rejected.diagnostic, help=help_line))
        return rejected

    def _as_function(self, node: syntax.Apply, type_: Type) -> Function:
        if type(type_) is Variable:
            function = Function([self.fresh() for _ in node.arguments], self.fresh())
            self.agree(type_, function, node.function, "the function")
            return function
        help_line = None
        if type(type_) is Dotable:
            help_line = "write the fields of a channel or constructor behind dots, as in `c.x`"
        elif isinstance(node.function, syntax.Apply):
            help_line = "the arguments in the brackets before may be all that it takes"
        raise Rejected(
            messages.not_a_function(head_name(node.function) or "this", node.function.span, show(type_)[0], help_line)
        )

    def _definition(self, function: syntax.Expr) -> Label | None:
        """Where the function that *function* names is defined."""
        if isinstance(function, syntax.Name):
            symbol = self.names.symbol(function)
            if symbol.span is not None:
                return Label(first_line(symbol.span), f"`{function.text}` is defined here")
        return None

    @INFERS(syntax.Lambda)
    def _lambda(self, node: syntax.Lambda) -> Type:
        parameters = [self.infer(parameter) for parameter in node.parameters]
        result = self.infer(node.body)
        settled = [
            self.settle(type_, parameter, "a parameter")
            for type_, parameter in zip(parameters, node.parameters, strict=True)
        ]
        return Function(settled, result)

    @INFERS(syntax.Let)
    def _let(self, node: syntax.Let) -> Type:
        self.local_declarations(node.declarations)
        return self.infer(node.body)

    def local_declarations(self, declarations: Iterable[syntax.Declaration]) -> None:
        """Infer the declarations of a ``let``."""
        raise NotImplementedError

    # --- statements ------------------------------------------------------------------------------------------

    def statements(self, statements: Sequence[syntax.Statement] | None, kind: Collection, place: str) -> None:
        """Infer generators, which range over collections of one *kind*, and qualifiers, in order."""
        for statement in statements or ():
            if isinstance(statement, syntax.Qualifier):
                self.check(statement.condition, BOOL, "the condition")
            elif isinstance(statement, syntax.Generator):
                source = self.infer(statement.source)
                pattern = self.infer(statement.pattern)
                found = resolve(source)
                if type(found) in (SetOf, SequenceOf) and type(found) is not kind:
                    raise Rejected(
                        messages.wrong_collection(
                            statement.source.span,
                            "set" if kind is SetOf else "sequence",
                            "set" if type(found) is SetOf else "sequence",
                            show(found)[0],
                            place,
                        )
                    )
                self.accept(
                    kind(pattern),
                    source,
                    statement.source,
                    "the source of the generator",
                    self._elsewhere(statement.pattern, pattern, "the pattern"),
                )


def _argument_role(index: int, count: int, name: str | None) -> str:
    called = f"of `{name}`" if name else "of the call"
    if count == 1:
        return f"the argument {called}"
    ordinal = ("first", "second", "third", "fourth", "fifth")[index] if index < 5 else f"{index + 1}th"
    return f"the {ordinal} argument {called}"
