"""Hot expressions as single Python functions.

A closure for each node of an expression is quick to make and slow to run: most of the time goes into calls. Where an
expression runs often enough to pay for it (the body of a function that has been called some dozens of times, a
comprehension over many elements), the parts that the types show to be harmless become one Python expression, compiled
once: arithmetic and comparisons of integers, conditions, calls, tuples, comprehensions. Everything else stays the
closure that it is and is called from there.

The text that is compiled consists of names made here, operators and integers; nothing of the script's text gets into
it. The functions behave as the closures do. Where Python itself raises (division by zero), the closures are asked
again, for the diagnostic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence as Items
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.builtins_data import append
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.operators import SMALL, bounded
from cspcheck.cspm.evaluator.patterns import is_variable
from cspcheck.cspm.evaluator.sorts import Sort
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.comparison import equal, less
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, Thunk
from cspcheck.cspm.values.values import FALSE, TRUE, Sequence, deep

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator
    from cspcheck.cspm.evaluator.routines import Routine

DEEPEST = 30
"""Expressions nested deeper than this are closures again: Python's own parser has limits."""
_LARGEST_LITERAL = 10**15

_SAME = {"+": "+", "-": "-", "*": "*", "/": "//", "%": "%", "<": "<", "<=": "<=", ">": ">", ">=": ">="}


class Fusion:
    """The text of one function, with the objects that it mentions."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.evaluator = evaluator
        self.objects: dict[str, Any] = {
            "Thunk": Thunk,
            "TRUE": TRUE,
            "FALSE": FALSE,
            "Sequence": Sequence,
            "deep": deep,
            "type": type,
            "int": int,
            "SMALL": SMALL,
            "bounded": bounded,
        }
        self.gain = 0
        """How many calls of closures are saved."""

    def object(self, value: Any, prefix: str = "k") -> str:
        """A name for an object."""
        name = f"{prefix}{len(self.objects)}"
        self.objects[name] = value
        return name

    def function(self, parameters: str, body: str, otherwise: Callable[..., Any]) -> Callable[..., Any]:
        """The compiled function; where Python raises by itself, *otherwise* does the work."""
        slow = self.object(otherwise)
        self.objects["ZeroDivisionError"] = ZeroDivisionError
        text = f"    try:\n        return {body}\n    except ZeroDivisionError:\n        return {slow}({parameters})\n"
        return self.compiled(parameters, text) or otherwise

    def compiled(self, parameters: str, statements: str) -> Callable[..., Any] | None:
        """The function of these indented statements; None if they are too much for Python."""
        self.objects["__builtins__"] = {}
        try:
            exec(compile(f"def fused({parameters}):\n{statements}", "<fused>", "exec"), self.objects)
        except (SyntaxError, MemoryError, RecursionError):
            return None
        result: Callable[..., Any] = self.objects["fused"]
        return result


class FusedPlace:
    """Where an expression stands in a fused function: its frame, and the Python variables behind its environment."""

    def __init__(self, frame: Frame, base: int, variables: tuple[str, ...] = ()) -> None:
        self.frame = frame
        self.base = base
        self.variables = variables

    @property
    def env(self) -> str:
        """The environment of a closure at this place."""
        return f"(*env, {', '.join(self.variables)})" if self.variables else "env"

    def variable(self, slot: int) -> str:
        """A variable by its position."""
        return f"env[{slot}]" if slot < self.base else self.variables[slot - self.base]

    def within(self, frame: Frame, variables: Items[str]) -> FusedPlace:
        """A place inside, with further variables."""
        return FusedPlace(frame, self.base, (*self.variables, *variables))


class Fuser:
    """Writes expressions as Python text."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.evaluator = evaluator
        self.fusion = Fusion(evaluator)
        self._names = 0

    # --- types ----------------------------------------------------------------------------------------------

    def type_of(self, node: syntax.Expr) -> Any:
        """The type of an expression, None if it is not known."""
        from cspcheck.cspm.typing import types

        node = syntax.bare(node)
        assert self.evaluator.sorts.types is not None
        try:
            return types.resolve(self.evaluator.sorts.types.type_of(node))
        except KeyError:
            return None

    def is_int(self, node: syntax.Expr) -> bool:
        """Whether the value is certainly an integer."""
        from cspcheck.cspm.typing import types

        return self.type_of(node) is types.INT

    # --- expressions ----------------------------------------------------------------------------------------

    def value(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node*."""
        node = syntax.bare(node)
        if depth < DEEPEST:
            match node:
                case syntax.LiteralExpr(kind="int") if abs(int(node.value)) < _LARGEST_LITERAL:
                    return f"({int(node.value)})"
                case syntax.Name():
                    slot = place.frame.slots.get(self.evaluator.names.symbol(node))
                    if slot is not None:
                        return self._local(node, slot, place)
                case syntax.Binary() if node.operator in ("+", "-", "*", "/", "%") and self.is_int(node):
                    self.fusion.gain += 1
                    left = self.value(node.left, place, depth + 1)
                    right = self.value(node.right, place, depth + 1)
                    if node.operator == "*":
                        p = self._fresh("p")
                        return f"({p} if -SMALL < ({p} := {left} * {right}) < SMALL else bounded({p}))"
                    return f"({left} {_SAME[node.operator]} {right})"
                case syntax.Binary() if node.operator != "^" and node.operator not in _SAME:
                    return f"(TRUE if {self.test(node, place, depth)} else FALSE)"
                case syntax.Binary() if node.operator in ("<", "<=", ">", ">="):
                    return f"(TRUE if {self.test(node, place, depth)} else FALSE)"
                case syntax.Unary(operator="not"):
                    return f"(TRUE if {self.test(node, place, depth)} else FALSE)"
                case syntax.Unary(operator="-") if self.is_int(node):
                    self.fusion.gain += 1
                    return f"(-{self.value(node.operand, place, depth + 1)})"
                case syntax.If():
                    self.fusion.gain += 1
                    then = self.value(node.then, place, depth + 1)
                    otherwise = self.value(node.otherwise, place, depth + 1)
                    return f"({then} if {self.test(node.condition, place, depth + 1)} else {otherwise})"
                case syntax.TupleExpr():
                    self.fusion.gain += 1
                    return f"({', '.join(self.delayed(item, place, depth + 1) for item in node.items)})"
                case syntax.SequenceExpr(statements=None) if node.items:
                    return self._listed(node, place, depth)
                case syntax.Binary(operator="^"):
                    return self._concatenation(node, place, depth)
                case syntax.Apply():
                    called = self._application(node, place, depth)
                    if called is not None:
                        return called
        return f"{self.fusion.object(self.evaluator.value(node, place.frame))}({place.env})"

    def _listed(self, node: syntax.SequenceExpr, place: FusedPlace, depth: int) -> str:
        self.fusion.gain += 1
        items = [self.delayed(item, place, depth + 1) for item in reversed(node.items)]
        return f"Sequence([{', '.join(items)}], {len(items)})"

    def _concatenation(self, node: syntax.Binary, place: FusedPlace, depth: int) -> str:
        self.fusion.gain += 1
        join = self.fusion.object(_located_append(node))
        left = self.value(node.left, place, depth + 1)
        return f"{join}({left}, {self.delayed(node.right, place, depth + 1)})"

    def _local(self, node: syntax.Name, slot: int, place: FusedPlace) -> str:
        variable = place.variable(slot)
        if self.evaluator.names.symbol(node) in place.frame.evaluated:
            return variable
        t = self._fresh("t")
        return f"({t} if type({t} := {variable}) is not Thunk else {t}.value if {t}.code is None else {t}.force())"

    def _fresh(self, prefix: str) -> str:
        self._names += 1
        return f"{prefix}{self._names}"

    def test(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the truth of *node*."""
        node = syntax.bare(node)
        if depth < DEEPEST:
            match node:
                case syntax.LiteralExpr(kind="bool"):
                    return "(1 == 1)" if node.value else "(1 == 0)"
                case syntax.Unary(operator="not"):
                    self.fusion.gain += 1
                    return f"(not {self.test(node.operand, place, depth + 1)})"
                case syntax.Binary(operator="and" | "or"):
                    self.fusion.gain += 1
                    left = self.test(node.left, place, depth + 1)
                    return f"({left} {node.operator} {self.test(node.right, place, depth + 1)})"
                case syntax.Binary() if node.operator in ("==", "!=", "<", "<=", ">", ">="):
                    return self._comparison(node, place, depth)
                case syntax.If():
                    self.fusion.gain += 1
                    then = self.test(node.then, place, depth + 1)
                    otherwise = self.test(node.otherwise, place, depth + 1)
                    return f"({then} if {self.test(node.condition, place, depth + 1)} else {otherwise})"
                case syntax.Apply() | syntax.Name():
                    return f"({self.value(node, place, depth)} is TRUE)"
        return f"{self.fusion.object(self.evaluator.condition(node, place.frame))}({place.env})"

    def _comparison(self, node: syntax.Binary, place: FusedPlace, depth: int) -> str:
        self.fusion.gain += 1
        left = self.value(node.left, place, depth + 1)
        right = self.value(node.right, place, depth + 1)
        if self.is_int(node.left):
            return f"({left} {_SAME.get(node.operator, node.operator)} {right})"
        compare = self.fusion.object(_located_comparison(node))
        a, b = self._fresh("a"), self._fresh("b")
        both = f"(type({a} := {left}) is int) & (type({b} := {right}) is int)"
        return f"(({a} {_SAME.get(node.operator, node.operator)} {b}) if {both} else {compare}({a}, {b}))"

    def delayed(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node* or a thunk of it."""
        node = syntax.bare(node)
        if isinstance(node, syntax.LiteralExpr) and node.kind == "int":
            return self.value(node, place, depth)
        if isinstance(node, syntax.Name):
            slot = place.frame.slots.get(self.evaluator.names.symbol(node))
            if slot is not None:
                variable = place.variable(slot)
                if slot < place.base:
                    return variable
                # Elements of a sequence have often been evaluated by a condition: their thunks need not stay.
                return f"({variable}.value if type({variable}) is Thunk and {variable}.code is None else {variable})"
        if self._is_ready(node, place):
            return self.value(node, place, depth)
        if isinstance(node, syntax.SequenceExpr) and node.statements is None and node.items:
            return self._listed(node, place, depth)
        return f"{self.fusion.object(self.evaluator.delayed(node, place.frame))}({place.env})"

    def _is_ready(self, node: syntax.Expr, place: FusedPlace) -> bool:
        """Whether working *node* out costs no more than a thunk and cannot fail: sums of evaluated variables."""
        stack = [node]
        while stack:
            current = stack.pop()
            current = syntax.bare(current)
            match current:
                case syntax.Binary() if current.operator in ("+", "-", "*") and self.is_int(current):
                    stack += (current.left, current.right)
                case syntax.LiteralExpr(kind="int"):
                    pass
                case syntax.Name() if self.evaluator.names.symbol(current) in place.frame.evaluated:
                    pass
                case _:
                    return False
        return True

    def _application(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function

        known = known_function(self.evaluator, node, place.frame)
        if isinstance(known, Builtin):
            if len(known.kinds) != len(node.arguments) or set(known.kinds) != {"v"}:
                return None
            self.fusion.gain += 1
            function = self.fusion.object(_located_builtin(known, node))
            given = [self.value(argument, place, depth + 1) for argument in node.arguments]
            return f"{function}({', '.join(given)})"
        if known is None or known.sort is not Sort.DATA or known.groups != (len(node.arguments),):
            return None
        self.fusion.gain += 1
        function = self.fusion.object(call_of(known, node))
        strict = known.strict or (False,) * known.width
        given = [
            self.value(argument, place, depth + 1) if needed else self.delayed(argument, place, depth + 1)
            for argument, needed in zip(node.arguments, strict, strict=True)
        ]
        size = known.frame.size
        if not size:
            return f"{function}(({''.join(f'{text}, ' for text in given)}))"
        base = "env" if size == place.base else f"env[:{size}]" if size < place.base else f"{place.env}[:{size}]"
        return f"{function}((*{base}, {', '.join(given)}))"

    # --- comprehensions -------------------------------------------------------------------------------------

    def loops(
        self, statements: Items[syntax.Statement], place: FusedPlace, first: str, *, evaluated: bool
    ) -> tuple[str, FusedPlace] | None:
        """Text for the ``for`` and ``if`` of *statements*, the first generator over the Python list *first*.

        None if a pattern is none that Python can bind. *evaluated*: the elements of the first source have no thunks.
        """
        from cspcheck.cspm.typing import types

        text = ""
        source: str | None = first
        for statement in statements:
            if isinstance(statement, syntax.Qualifier):
                text += f" if {self.test(statement.condition, place)}"
                continue
            assert isinstance(statement, syntax.Generator)
            if source is None:
                evaluated = isinstance(self.type_of(statement.source), types.SetOf)
                # A closure: Python allows no assignments in what a comprehension ranges over.
                items = self.fusion.object(_source_of(statement, self.evaluator.value(statement.source, place.frame)))
                source = f"{items}({place.env})"
            bound = self._bound(statement.pattern, evaluated=evaluated)
            if bound is None:
                return None
            self.fusion.gain += 1
            target, symbols, names = bound
            place = place.within(place.frame.with_variables(symbols, evaluated=evaluated), names)
            text += f" for {target} in {source}"
            source = None
        return text, place

    def _bound(self, pattern: syntax.Pattern, *, evaluated: bool) -> tuple[str, list[Symbol | None], list[str]] | None:
        """A loop target for a variable, or for a tuple of variables where tuples are certain."""
        while isinstance(pattern, syntax.ParenPattern):
            pattern = pattern.inner
        if is_variable(self.evaluator, pattern):
            name = self._fresh("x")
            return name, [self.evaluator.names.symbol(pattern)], [name]
        if not isinstance(pattern, syntax.TuplePattern) or not evaluated:
            return None
        symbols: list[Symbol | None] = []
        names: list[str] = []
        for item in pattern.items:
            if not is_variable(self.evaluator, item):
                return None
            while isinstance(item, syntax.ParenPattern):
                item = item.inner
            symbols.append(self.evaluator.names.symbol(item))
            names.append(self._fresh("x"))
        return f"({', '.join(names)},)", symbols, names

    def element(self, node: syntax.Expr, place: FusedPlace) -> str:
        """Text for the value of *node* evaluated through and through, as an element of a set."""
        node = syntax.bare(node)
        if self.is_int(node):
            return self.value(node, place)
        if isinstance(node, syntax.TupleExpr) and all(self.is_int(item) for item in node.items):
            return f"({', '.join(self.value(item, place) for item in node.items)})"
        return f"deep({self.value(node, place)})"


def _located_comparison(node: syntax.Binary) -> Callable[[Any, Any], bool]:
    span = node.span
    operator = node.operator

    def compare(a: Any, b: Any) -> bool:
        try:
            if operator in ("==", "!="):
                return equal(a, b) is (operator == "==")
            if operator in ("<", "<="):
                return less(a, b, strict=operator == "<")
            return less(b, a, strict=operator == ">")
        except Failure as failure:
            failure.at(span)
            raise

    return compare


def _located_append(node: syntax.Binary) -> Callable[[Any, Any], Any]:
    span = node.span

    def join(left: Any, right: Any) -> Any:
        try:
            return append(left, right)
        except Failure as failure:
            failure.at(span)
            raise

    return join


def _located_builtin(builtin: Builtin, node: syntax.Apply) -> Callable[..., Any]:
    span = node.span
    call = builtin.call

    def one(value: Any) -> Any:
        try:
            return call(value)
        except Failure as failure:
            failure.at(span)
            raise

    def several(*values: Any) -> Any:
        try:
            return call(*values)
        except Failure as failure:
            failure.at(span)
            raise

    return one if len(builtin.kinds) == 1 else several


def call_of(routine: Routine, node: syntax.Apply) -> Code:
    """A call of *routine* in a complete environment, the surroundings of a local one in front."""
    from cspcheck.cspm.evaluator.routines import passed

    span = node.span
    size = routine.frame.size

    def call(env: Env) -> Any:
        try:
            return routine.enter(env)
        except (Failure, RecursionError, Stopped) as error:
            raise passed(error, routine, env[size:], span) from None

    return call


def _source_of(statement: syntax.Generator, source: Code) -> Callable[[Env], list[Any]]:
    from cspcheck.cspm.evaluator.comprehensions import source_items

    span = statement.source.span
    return lambda env: source_items(source(env), span)


def fused_body(evaluator: Evaluator, body: syntax.Expr, frame: Frame, closure: Code) -> Code:
    """*closure*, the code of a function's body, as one function if that saves calls."""
    fuser = Fuser(evaluator)
    text = fuser.value(body, FusedPlace(frame, frame.size))
    if fuser.fusion.gain < 1:
        return closure
    return fuser.fusion.function("env", text, closure)


def fused_elements(
    evaluator: Evaluator,
    items: Items[syntax.Expr],
    statements: Items[syntax.Statement],
    frame: Frame,
    otherwise: Callable[[Env, list[Any]], list[Any]],
    *,
    of_set: bool,
) -> Callable[[Env, list[Any]], list[Any]]:
    """The elements of a comprehension of one item, given what its first generator ranges over.

    *of_set*: the items are evaluated through and through, as elements of a set are; otherwise delayed.
    """
    from cspcheck.cspm.typing import types

    fuser = Fuser(evaluator)
    assert isinstance(statements[0], syntax.Generator)
    evaluated = isinstance(fuser.type_of(statements[0].source), types.SetOf)
    found = fuser.loops(statements, FusedPlace(frame, frame.size), "items", evaluated=evaluated)
    if found is None or len(items) != 1:
        return otherwise
    text, place = found
    item = fuser.element(items[0], place) if of_set else fuser.delayed(items[0], place)
    function: Callable[[Env, list[Any]], list[Any]] = fuser.fusion.function("env, items", f"[{item}{text}]", otherwise)
    return function
