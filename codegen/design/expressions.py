"""Expressions of CSPm as expressions of Python.

Sequences are tuples, sets are frozensets; ``/`` and ``%`` round down in both languages. What has no counterpart is
refused with its place. Texts come with the strength of their outermost operator, so that brackets stand only where
they are needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from cspcheck.codegen import messages
from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.naming import safe, unique
from cspcheck.codegen.quoting import literal, literals
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.printing.printer import print_expression
from cspcheck.cspm.script import Script
from cspcheck.cspm.syntax import tree as syntax

Code = tuple[str, int]
"""A text and the strength of its outermost operator: the greater, the tighter."""

TERNARY, OR, AND, NOT, COMPARE, SET_OR, ADD, MULTIPLY, UNARY, ATOM = range(10)

_BINARY: dict[str, tuple[str, int]] = {
    "+": ("+", ADD),
    "-": ("-", ADD),
    "*": ("*", MULTIPLY),
    "/": ("//", MULTIPLY),
    "%": ("%", MULTIPLY),
    "==": ("==", COMPARE),
    "!=": ("!=", COMPARE),
    "<": ("<", COMPARE),
    "<=": ("<=", COMPARE),
    ">": (">", COMPARE),
    ">=": (">=", COMPARE),
    "and": ("and", AND),
    "or": ("or", OR),
}


def bracketed(code: Code, strength: int) -> str:
    """The text, in brackets if it binds looser than what stands around it."""
    return code[0] if code[1] >= strength else f"({code[0]})"


@dataclass
class VisibleVariables:
    """The variables that can be seen, by symbol."""

    names: dict[Symbol, str] = field(default_factory=dict)

    def bind(self, symbol: Symbol) -> str:
        """A Python name for a variable, different from all that can be seen."""
        name = unique(safe(symbol.name), set(self.names.values()))
        self.names[symbol] = name
        return name

    def copy(self) -> VisibleVariables:
        """The same variables; what is bound in the copy stays there."""
        return VisibleVariables(dict(self.names))


class ExpressionTranslator:
    """Translates the expressions of one module; collects what the module needs from elsewhere."""

    def __init__(
        self,
        script: Script,
        data: DataDesigner,
        function: Callable[[Symbol, syntax.Node], str],
        functions: str = "functions.",
    ) -> None:
        self.script = script
        self.functions = functions
        """What stands before the name of a function of the script."""
        self.data = data
        self.names = script.names
        self.from_data: set[str] = set()
        """Names that the module uses of ``data_types``."""
        self.from_runtime: set[str] = set()
        self.scope = VisibleVariables()
        self._function = function

    @contextmanager
    def inside(self) -> Iterator[VisibleVariables]:
        """A scope for what is bound locally."""
        outer = self.scope
        self.scope = outer.copy()
        try:
            yield self.scope
        finally:
            self.scope = outer

    def text(self, node: syntax.Expr, strength: int = TERNARY) -> str:
        """An expression, in brackets where it binds looser than *strength*.

        Raises:
            ScriptError: it has no counterpart.
        """
        return bracketed(self.code(node), strength)

    def code(self, node: syntax.Expr) -> Code:
        """An expression with its strength."""
        match node:
            case syntax.Paren():
                return self.code(node.inner)
            case syntax.LiteralExpr():
                return (constant(node), ATOM)
            case syntax.Name():
                return self._name(node)
            case syntax.Binary():
                return self._binary(node)
            case syntax.Unary():
                return self._unary(node)
            case syntax.TupleExpr():
                return (f"({', '.join(map(self.text, node.items))})", ATOM)
            case syntax.SequenceExpr():
                return self._display(node.items, node.statements, "tuple", node)
            case syntax.SetExpr():
                return self._display(node.items, node.statements, "frozenset", node)
            case syntax.SetRange() | syntax.SequenceRange() if node.high is not None and node.statements is None:
                kind = "frozenset" if isinstance(node, syntax.SetRange) else "tuple"
                low = self.text(node.low)
                start = "" if low == "0" else f"{low}, "
                return (f"{kind}(range({start}{self._successor(node.high)}))", ATOM)
            case syntax.If():
                then, otherwise = self.text(node.then, OR), self.text(node.otherwise, TERNARY)
                return (f"{then} if {self.text(node.condition, OR)} else {otherwise}", TERNARY)
            case syntax.Apply():
                return self._apply(node)
            case syntax.Dot():
                return self._dot(node)
        raise self.refused(node)

    def refused(self, node: syntax.Node, why: str | None = None) -> ScriptError:
        """The refusal of something that has no counterpart."""
        text = why or f"`{' '.join(node.span.text.split())}`"
        return ScriptError(messages.not_generated(text, node.span))

    def _successor(self, node: syntax.Expr) -> str:
        if isinstance(node, syntax.LiteralExpr) and isinstance(node.value, int):
            return str(node.value + 1)
        if (
            isinstance(node, syntax.Binary)
            and node.operator == "-"
            and isinstance(node.right, syntax.LiteralExpr)
            and node.right.value == 1
        ):
            return self.text(node.left)
        return f"{self.text(node, ADD)} + 1"

    def _name(self, node: syntax.Name) -> Code:
        symbol = self.names.symbol(node)
        match symbol.kind:
            case SymbolKind.VARIABLE:
                known = self.scope.names.get(symbol)
                if known is None:
                    raise self.refused(node, f"`{node.text}`, a value that this very event brings")
                return (known, ATOM)
            case SymbolKind.VALUE if not symbol.is_local:
                constant, is_type = self.data.constant(symbol, node.span)
                self.from_data.add(constant)
                return (f"{constant}.all()" if is_type else constant, ATOM)
            case SymbolKind.VALUE:
                known = self.scope.names.get(symbol)
                if known is not None:
                    return (known, ATOM)
            case SymbolKind.CONSTRUCTOR:
                if symbol.constructor is not None and symbol.constructor.fields is not None:
                    raise self.refused(node, f"`{node.text}` without its fields")
                return (self._note(self.data.constructor(symbol, (), node.span)), ATOM)
            case SymbolKind.DATATYPE | SymbolKind.NAMETYPE | SymbolKind.SUBTYPE:
                constant, _ = self.data.constant(symbol, node.span)
                self.from_data.add(constant)
                return (f"{constant}.all()", ATOM)
            case SymbolKind.BUILTIN if node.text in ("true", "false"):
                return (node.text.capitalize(), ATOM)
            case SymbolKind.BUILTIN if node.text == "Bool":
                return ("frozenset({False, True})", ATOM)
        raise self.refused(node)

    def _note(self, text: str) -> str:
        """Note what a text of :class:`DataDesigner` uses."""
        head = text.partition("(")[0].partition(".")[0]
        if head == "Tagged":
            self.from_runtime.add("Tagged")
        elif head in self.data.enums:
            self.from_data.add(head)
        return text

    def literal(self, value: object, where: str, span: object = None) -> str:
        """A value, noting what its text uses."""
        text = self.data.literal(value, where)
        for enum in self.data.enums:
            if f"{enum}." in text:
                self.from_data.add(enum)
        if "Tagged(" in text:
            self.from_runtime.add("Tagged")
        return text

    def _binary(self, node: syntax.Binary) -> Code:
        if node.operator == "^":
            return (f"({', '.join(self._concatenated(node))})", ATOM)
        operator, strength = _BINARY[node.operator]
        if node.operator in ("<", "<=", ">", ">="):
            self._only_numbers(node)
        right = strength + 1 if operator not in ("and", "or") else strength
        left = strength + 1 if strength == COMPARE else strength
        return (f"{self.text(node.left, left)} {operator} {self.text(node.right, right)}", strength)

    def _concatenated(self, node: syntax.Expr) -> list[str]:
        """The items of a concatenation: those of displays, and other sequences spread."""
        node = syntax.bare(node)
        if isinstance(node, syntax.Binary) and node.operator == "^":
            return [*self._concatenated(node.left), *self._concatenated(node.right)]
        if isinstance(node, syntax.SequenceExpr) and node.statements is None:
            return list(map(self.text, node.items))
        return [f"*{self.text(node, SET_OR)}"]

    def _only_numbers(self, node: syntax.Binary) -> None:
        """Orders other than that of numbers (prefix, subset) are refused: Python's on tuples is another one."""
        if self.script.types is None:
            return
        annotation = self.data.annotation(self.script.types.type_of(node.left))
        if annotation.startswith("frozenset"):
            return
        if annotation not in ("int", "str"):
            raise self.refused(node, f"the order `{node.operator}` on {annotation}")

    def _unary(self, node: syntax.Unary) -> Code:
        match node.operator:
            case "-":
                return (f"-{self.text(node.operand, UNARY)}", UNARY)
            case "not":
                return self.negated(node.operand)
        return (f"len({self.text(node.operand)})", ATOM)

    def negated(self, node: syntax.Expr) -> Code:
        """That something does not hold, as a person writes it."""
        node = syntax.bare(node)
        match node:
            case syntax.Unary(operator="not"):
                return self.code(node.operand)
            case syntax.Binary(operator="==" | "!=" as operator):
                left, right = self.text(node.left, COMPARE + 1), self.text(node.right, COMPARE + 1)
                return (f"{left} {'!=' if operator == '==' else '=='} {right}", COMPARE)
            case syntax.Apply(function=syntax.Name() as function) if self.names.symbol(
                function
            ).kind is SymbolKind.BUILTIN and len(node.arguments) in (1, 2):
                if function.text in ("null", "empty"):
                    return (f"len({self.text(node.arguments[0])}) > 0", COMPARE)
                if function.text in ("member", "elem"):
                    value, collection = (self.text(argument, COMPARE + 1) for argument in node.arguments)
                    return (f"{value} not in {collection}", COMPARE)
        return (f"not {self.text(node, NOT)}", NOT)

    def _display(
        self,
        items: tuple[syntax.Expr, ...],
        statements: tuple[syntax.Statement, ...] | None,
        kind: str,
        node: syntax.Expr,
    ) -> Code:
        if statements is None:
            texts = list(map(self.text, items))
            if kind == "tuple":
                return (f"({', '.join(texts)}{',' if len(texts) == 1 else ''})", ATOM)
            return (f"frozenset({{{', '.join(texts)}}})" if texts else "frozenset()", ATOM)
        if len(items) != 1:
            raise self.refused(node)
        with self.inside():
            clauses: list[str] = []
            for statement in statements:
                if isinstance(statement, syntax.Qualifier):
                    clauses.append(f"if {self.text(statement.condition, OR)}")
                elif isinstance(statement, syntax.Generator):
                    source = self.text(statement.source, OR)
                    clauses.append(f"for {self.target(statement.pattern)} in {source}")
            return (f"{kind}({self.text(items[0])} {' '.join(clauses)})", ATOM)

    def target(self, pattern: syntax.Pattern) -> str:
        """A pattern that always matches, as the target of an assignment; its variables are bound."""
        match pattern:
            case syntax.ParenPattern():
                return self.target(pattern.inner)
            case syntax.Wildcard():
                return "_"
            case syntax.NamePattern():
                symbol = self.names.symbol(pattern)
                if symbol.kind is SymbolKind.VARIABLE or (symbol.kind is SymbolKind.VALUE and symbol.is_local):
                    return self.scope.bind(symbol)
            case syntax.TuplePattern():
                return f"({', '.join(map(self.target, pattern.items))})"
        raise self.refused(pattern, f"the pattern `{print_expression(pattern)}` here")

    def _dot(self, node: syntax.Dot) -> Code:
        parts = flattened(node)
        head = parts[0]
        if isinstance(head, syntax.Name):
            symbol = self.names.symbol(head)
            if symbol.kind is SymbolKind.CONSTRUCTOR:
                return (self._note(self.data.constructor(symbol, list(map(self.text, parts[1:])), node.span)), ATOM)
        raise self.refused(node)

    def _apply(self, node: syntax.Apply) -> Code:
        function = node.function
        function = syntax.bare(function)
        if not isinstance(function, syntax.Name):
            raise self.refused(node)
        symbol = self.names.symbol(function)
        if symbol.kind is SymbolKind.BUILTIN:
            return self._builtin(symbol.name, node)
        if symbol.kind is SymbolKind.FUNCTION and not symbol.is_local:
            name = f"{self.functions}{self._function(symbol, node)}"
            return (f"{name}({', '.join(map(self.text, node.arguments))})", ATOM)
        raise self.refused(node)

    def _builtin(self, name: str, node: syntax.Apply) -> Code:
        arguments = node.arguments
        if name in ("head", "tail", "length", "card", "null", "empty", "set", "seq"):
            only = arguments[0]
            match name:
                case "head":
                    return (f"{self.text(only, ATOM)}[0]", ATOM)
                case "tail":
                    return (f"{self.text(only, ATOM)}[1:]", ATOM)
                case "length" | "card":
                    return (f"len({self.text(only)})", ATOM)
                case "null" | "empty":
                    return (f"not {self.text(only, NOT)}", NOT)
                case "set":
                    return (f"frozenset({self.text(only)})", ATOM)
        if name in ("member", "elem"):
            return (f"{self.text(arguments[0], COMPARE + 1)} in {self.text(arguments[1], COMPARE + 1)}", COMPARE)
        if name in ("union", "inter", "diff"):
            operator = {"union": "|", "inter": "&", "diff": "-"}[name]
            return (f"{self.text(arguments[0], ATOM)} {operator} {self.text(arguments[1], ATOM)}", SET_OR)
        raise self.refused(node, f"the function `{name}`")


def constant(node: syntax.LiteralExpr | syntax.LiteralPattern) -> str:
    """A literal of the script as one of Python; a text is the sequence of its characters."""
    if not isinstance(node.value, str):
        return repr(node.value)
    return literal(node.value) if node.kind == "char" else f"({literals(list(node.value))})"


def flattened(node: syntax.Expr) -> list[syntax.Expr]:
    """The parts between the dots."""
    parts: list[syntax.Expr] = []
    while isinstance(node, syntax.Dot):
        parts.append(node.left)
        node = node.right
    return [*parts, node]
