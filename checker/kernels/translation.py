"""From the kernels' text to LLVM's language.

Kernels are written in a small part of Python, which is all that is understood here: integers of 64 bits, flat arrays
of integers, named tuples of these as arguments; assignments, ``if``, ``while``, ``for`` over a ``range``, calls of
other kernels. Anything else is refused when it is translated. A general compiler for numeric Python would do (numba
did), but takes most of a minute for what this does in a moment, because it has to find out the types of things and to
count references to arrays.

What differs from Python: an integer is the machine's, so nothing may overflow; an index is neither checked nor counted
from the end; a tuple is returned by entries to their callers, and taken apart where it arrives.
"""

from __future__ import annotations

import ast
import builtins
import inspect
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType, ModuleType
from typing import Any

from llvmlite import ir

from cspcheck.checker.kernels.translated_types import (
    BIT,
    BYTE,
    WORD,
    ArraySpan,
    KernelRecord,
    Place,
    Thing,
    Untranslatable,
    entry_name,
    parameters,
    results,
    thing_of,
    words_in,
    words_of,
)


def translated(
    modules: Sequence[ModuleType], entries: Mapping[str, Sequence[Mapping[str, int]]], wide: bool = False
) -> ir.Module:
    """A module of LLVM with all kernels of some modules.

    Args:
        modules: each with its kernels as ``KERNELS``.
        entries: the kernels that are called from outside. Each has a function :func:`entry_name` that takes the
            address of its words: first room for the results, then the words of the arguments. Beside it are the sets
            of arguments that are worth a copy of the kernel in which these are constants.
        wide: whether it is the wide kernels.
    """
    module = ir.Module(name="kernels")
    made: dict[FunctionType, Any] = {}
    for source in modules:
        trees = {
            node.name: node for node in ast.parse(inspect.getsource(source)).body if isinstance(node, ast.FunctionDef)
        }
        for function in source.KERNELS:
            made[function] = declared(module, function, inlined=function.__name__ not in entries, wide=wide)
        for function in source.KERNELS:
            _Function(module, made, function, trees[function.__name__], wide).translate()
    for function, internal in made.items():
        if function.__name__ in entries:
            _export(module, function, internal, entries[function.__name__], wide)
    return module


def declared(module: ir.Module, function: FunctionType, *, inlined: bool, wide: bool) -> Any:
    """A kernel as a function of LLVM, without its body."""
    given = results(function)
    kind = ir.VoidType() if not given else WORD if len(given) == 1 else ir.LiteralStructType([WORD] * len(given))
    words = [word for _, parameter in parameters(function, wide) for word in words_of(parameter)]
    internal = ir.Function(module, ir.FunctionType(kind, words), name=function.__name__)
    internal.linkage = "internal"
    internal.attributes.add("nounwind")
    if inlined:
        internal.attributes.add("alwaysinline")
    return internal


def _export(
    module: ir.Module, function: FunctionType, internal: Any, constants: Sequence[Mapping[str, int]], wide: bool
) -> None:
    """The function by which a kernel is called from outside."""
    outer = ir.Function(module, ir.FunctionType(ir.VoidType(), [WORD.as_pointer()]), name=entry_name(function.__name__))
    outer.attributes.add("nounwind")
    builder = ir.IRBuilder(outer.append_basic_block("entry"))
    room = len(results(function))
    words: list[Any] = []
    numbers: dict[str, int] = {}
    for name, kind in parameters(function, wide):
        numbers[name] = len(words)
        for word in words_of(kind):
            place = builder.gep(outer.args[0], [WORD(room + len(words))], source_etype=WORD)
            value = builder.load(place, typ=WORD)
            words.append(value if word == WORD else builder.inttoptr(value, word))

    def call(words: Sequence[Any], inline: bool) -> None:
        result = builder.call(internal, words)
        if inline:
            result.attributes.add("alwaysinline")
        for i in range(room):
            value = result if room == 1 else builder.extract_value(result, i)
            builder.store(value, builder.gep(outer.args[0], [WORD(i)], source_etype=WORD))
        builder.ret_void()

    for fixed in constants:
        agrees = BIT(1)
        special = list(words)
        for name, value in fixed.items():
            agrees = builder.and_(agrees, builder.icmp_signed("==", words[numbers[name]], WORD(value)))
            special[numbers[name]] = WORD(value)
        then, otherwise = outer.append_basic_block("special"), outer.append_basic_block("general")
        builder.cbranch(agrees, then, otherwise)
        builder.position_at_end(then)
        call(special, True)
        builder.position_at_end(otherwise)
    call(words, False)


_OPERATIONS: Mapping[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "sub",
    ast.Mult: "mul",
    ast.LShift: "shl",
    ast.RShift: "ashr",
    ast.BitAnd: "and_",
    ast.BitOr: "or_",
    ast.BitXor: "xor",
}

_COMPARISONS: Mapping[type[ast.cmpop], str] = {
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
}


class _Function:
    """The translation of one kernel."""

    def __init__(
        self,
        module: ir.Module,
        made: Mapping[FunctionType, Any],
        function: FunctionType,
        tree: ast.FunctionDef,
        wide: bool,
    ) -> None:
        self.module, self.made, self.function, self.tree, self.wide = module, made, function, tree, wide
        self.internal = made[function]
        self.frame = self.internal.append_basic_block("variables")
        self.builder = ir.IRBuilder(self.internal.append_basic_block("body"))
        self.begin = self.builder.block
        self.variables: dict[str, Place] = {}
        """The numbers among the names, each with its place."""
        self.aliases: dict[str, Thing] = {}
        """The other names: arrays and named tuples, which nothing assigns to twice."""
        self.loops: list[tuple[Any, Any]] = []
        """Where ``continue`` and ``break`` lead to, outermost first."""

    def translate(self) -> None:
        """Fill in the body."""
        words = list(self.internal.args)
        for name, kind in parameters(self.function, self.wide):
            thing = thing_of(kind, words)
            if isinstance(thing, ArraySpan | KernelRecord):
                self.aliases[name] = thing
            else:
                self.builder.store(thing, self.place(name))
        self.block(self.tree.body)
        if not self.builder.block.is_terminated:
            if results(self.function):
                self.builder.unreachable()
            else:
                self.builder.ret_void()
        ir.IRBuilder(self.frame).branch(self.begin)

    def place(self, name: str) -> Place:
        """Where the number of a name is kept. LLVM makes registers of these places."""
        if name not in self.variables:
            self.variables[name] = self.room(name)
        return self.variables[name]

    def room(self, name: str) -> Place:
        """Room for a number."""
        return ir.IRBuilder(self.frame).alloca(WORD, name=name)

    # Statements

    def block(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            if self.builder.block.is_terminated:
                return
            translate = getattr(self, f"do_{type(statement).__name__}", None)
            if translate is None:
                raise Untranslatable(statement, type(statement).__name__)
            translate(statement)

    def do_Expr(self, node: ast.Expr) -> None:  # noqa: N802
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def do_Assign(self, node: ast.Assign) -> None:  # noqa: N802
        if len(node.targets) != 1:
            raise Untranslatable(node, "an assignment to several targets")
        target = node.targets[0]
        if not isinstance(target, ast.Tuple):
            self.assign(target, self.value(node.value))
        elif isinstance(node.value, ast.Tuple):
            # All are evaluated before any is assigned.
            for part, thing in zip(target.elts, [self.number(part) for part in node.value.elts], strict=True):
                self.assign(part, thing)
        else:
            several = self.value(node.value)
            for i, part in enumerate(target.elts):
                self.assign(part, self.builder.extract_value(several, i))

    def do_AnnAssign(self, node: ast.AnnAssign) -> None:  # noqa: N802
        if node.value is not None:
            self.assign(node.target, self.value(node.value))

    def do_AugAssign(self, node: ast.AugAssign) -> None:  # noqa: N802
        if isinstance(node.target, ast.Name):
            place = self.place(node.target.id)
            self.builder.store(self.operation(node, node.op, self.builder.load(place), self.number(node.value)), place)
        elif isinstance(node.target, ast.Subscript):
            span, place = self.element(node.target)
            before = self.loaded(span, place)
            self.stored(span, place, self.operation(node, node.op, before, self.number(node.value)))
        else:
            raise Untranslatable(node, "this target")

    def assign(self, target: ast.expr, thing: Thing) -> None:
        if isinstance(target, ast.Subscript):
            span, place = self.element(target)
            self.stored(span, place, self.as_number(target, thing))
        elif not isinstance(target, ast.Name):
            raise Untranslatable(target, "this target")
        elif isinstance(thing, ArraySpan | KernelRecord):
            if target.id in self.variables or target.id in self.aliases:
                raise Untranslatable(target, "a second value of an array's name")
            self.aliases[target.id] = thing
        elif target.id in self.aliases:
            raise Untranslatable(target, "a second value of an array's name")
        else:
            self.builder.store(self.as_number(target, thing), self.place(target.id))

    def do_Return(self, node: ast.Return) -> None:  # noqa: N802
        if node.value is None:
            self.builder.ret_void()
        elif isinstance(node.value, ast.Tuple):
            several = ir.Constant(self.internal.function_type.return_type, ir.Undefined)
            for i, part in enumerate(node.value.elts):
                several = self.builder.insert_value(several, self.number(part), i)
            self.builder.ret(several)
        else:
            self.builder.ret(self.number(node.value))

    def do_If(self, node: ast.If) -> None:  # noqa: N802
        then, after = self.new("then"), self.new("after")
        otherwise = self.new("else") if node.orelse else after
        self.builder.cbranch(self.truth(node.test), then, otherwise)
        self.section(then, node.body, after)
        if node.orelse:
            self.section(otherwise, node.orelse, after)
        self.builder.position_at_end(after)

    def section(self, block: Any, statements: Sequence[ast.stmt], after: Any) -> None:
        """Statements that begin in a block, and what comes after them."""
        self.builder.position_at_end(block)
        self.block(statements)
        if not self.builder.block.is_terminated:
            self.builder.branch(after)

    def do_While(self, node: ast.While) -> None:  # noqa: N802
        if node.orelse:
            raise Untranslatable(node, "the else of a loop")
        head, body, after = self.new("while"), self.new("do"), self.new("done")
        self.builder.branch(head)
        self.builder.position_at_end(head)
        if isinstance(node.test, ast.Constant) and node.test.value is True:
            self.builder.branch(body)
        else:
            self.builder.cbranch(self.truth(node.test), body, after)
        self.loop(body, node.body, head, after)

    def do_For(self, node: ast.For) -> None:  # noqa: N802
        call = node.iter
        if node.orelse or not isinstance(node.target, ast.Name) or not isinstance(call, ast.Call):
            raise Untranslatable(node, "this loop")
        if self.named(call.func) is not range:
            raise Untranslatable(node, "a loop over this")
        bounds = [self.number(argument) for argument in call.args]
        start, end = (WORD(0), bounds[0]) if len(bounds) == 1 else (bounds[0], bounds[1])
        step = bounds[2] if len(bounds) == 3 else WORD(1)
        counter = self.room(f"next_{node.target.id}")
        self.builder.store(start, counter)
        head, body, turn, after = self.new("for"), self.new("do"), self.new("turn"), self.new("done")
        self.builder.branch(head)
        self.builder.position_at_end(head)
        self.builder.cbranch(self.builder.icmp_signed("<", self.builder.load(counter), end), body, after)
        self.builder.position_at_end(turn)
        self.builder.store(self.builder.add(self.builder.load(counter), step, flags=("nsw",)), counter)
        self.builder.branch(head)
        self.builder.position_at_end(body)
        self.assign(node.target, self.builder.load(counter))
        self.loop(body, node.body, turn, after)

    def loop(self, body: Any, statements: Sequence[ast.stmt], again: Any, after: Any) -> None:
        """The body of a loop."""
        self.loops.append((again, after))
        self.section(body, statements, again)
        self.loops.pop()
        self.builder.position_at_end(after)

    def do_Continue(self, node: ast.Continue) -> None:  # noqa: N802
        self.builder.branch(self.loops[-1][0])

    def do_Break(self, node: ast.Break) -> None:  # noqa: N802
        self.builder.branch(self.loops[-1][1])

    def new(self, name: str) -> Any:
        return self.builder.append_basic_block(name)

    # Expressions

    def value(self, node: ast.expr) -> Thing:
        """The value of an expression."""
        translate = getattr(self, f"of_{type(node).__name__}", None)
        if translate is None:
            raise Untranslatable(node, type(node).__name__)
        return translate(node)

    def number(self, node: ast.expr) -> Any:
        """The value of an expression as a number."""
        return self.as_number(node, self.value(node))

    def as_number(self, node: ast.AST, thing: Thing) -> Any:
        if isinstance(thing, ArraySpan | KernelRecord) or thing.type not in (WORD, BIT):
            raise Untranslatable(node, "this as a number")
        return self.builder.zext(thing, WORD) if thing.type == BIT else thing

    def truth(self, node: ast.expr) -> Any:
        """Whether an expression's value counts as true."""
        value = self.value(node)
        return value if value.type == BIT else self.builder.icmp_signed("!=", value, WORD(0))

    def of_Constant(self, node: ast.Constant) -> Thing:  # noqa: N802
        return self.constant(node, node.value)

    def constant(self, node: ast.AST, value: object) -> Thing:
        if isinstance(value, bool):
            return BIT(int(value))
        if isinstance(value, int) and -(1 << 63) <= value < 1 << 63:
            return WORD(value)
        raise Untranslatable(node, f"the constant {value!r}")

    def named(self, node: ast.expr) -> object:
        """What a name of the module, or of Python, means."""
        if not isinstance(node, ast.Name):
            raise Untranslatable(node, "this callee")
        known = self.function.__globals__
        return known[node.id] if node.id in known else getattr(builtins, node.id)

    def of_Name(self, node: ast.Name) -> Thing:  # noqa: N802
        if node.id in self.aliases:
            return self.aliases[node.id]
        if node.id in self.variables:
            return self.builder.load(self.variables[node.id])
        return self.constant(node, self.named(node))

    def of_Attribute(self, node: ast.Attribute) -> Thing:  # noqa: N802
        record = self.value(node.value)
        if not isinstance(record, KernelRecord):
            raise Untranslatable(node, "an attribute")
        return record.members[node.attr]

    def of_Subscript(self, node: ast.Subscript) -> Thing:  # noqa: N802
        return self.loaded(*self.element(node))

    def element(self, node: ast.Subscript) -> tuple[ArraySpan, Place]:
        """An array and the place of its element."""
        span = self.value(node.value)
        if not isinstance(span, ArraySpan):
            raise Untranslatable(node, "an index into this")
        return span, self.at(span, self.number(node.slice), inside=True)

    def at(self, span: ArraySpan, index: Any, *, inside: bool) -> Place:
        return self.builder.gep(span.begin, [index], inbounds=inside, source_etype=ir.IntType(span.bits))

    def loaded(self, span: ArraySpan, place: Place) -> Any:
        value = self.builder.load(place, typ=ir.IntType(span.bits))
        if span.bits == 64:
            return value
        return self.builder.zext(value, WORD) if span.bits == 8 else self.builder.sext(value, WORD)

    def stored(self, span: ArraySpan, place: Place, value: Any) -> None:
        kind = ir.IntType(span.bits)
        self.builder.store(value if span.bits == 64 else self.builder.trunc(value, kind), place)

    def of_BinOp(self, node: ast.BinOp) -> Thing:  # noqa: N802
        left = self.number(node.left)
        return self.operation(node, node.op, left, self.number(node.right))

    def operation(self, node: ast.AST, operator: ast.operator, left: Any, right: Any) -> Any:
        if isinstance(operator, ast.FloorDiv):
            return self.floor_quotient(left, right)
        if type(operator) not in _OPERATIONS:
            raise Untranslatable(node, type(operator).__name__)
        return getattr(self.builder, _OPERATIONS[type(operator)])(left, right)

    def floor_quotient(self, left: Any, right: Any) -> Any:
        """Python rounds down, the machine towards zero."""
        quotient, rest = self.builder.sdiv(left, right), self.builder.srem(left, right)
        inexact = self.builder.icmp_signed("!=", rest, WORD(0))
        apart = self.builder.icmp_signed("<", self.builder.xor(rest, right), WORD(0))
        return self.builder.sub(quotient, self.builder.zext(self.builder.and_(inexact, apart), WORD))

    def of_UnaryOp(self, node: ast.UnaryOp) -> Thing:  # noqa: N802
        if isinstance(node.op, ast.Not):
            return self.builder.xor(self.truth(node.operand), BIT(1))
        value = self.number(node.operand)
        if isinstance(node.op, ast.Invert):
            return self.builder.xor(value, WORD(-1))
        if isinstance(node.op, ast.USub):
            return self.builder.sub(WORD(0), value)
        raise Untranslatable(node, type(node.op).__name__)

    def of_Compare(self, node: ast.Compare) -> Thing:  # noqa: N802
        if any(type(operator) not in _COMPARISONS for operator in node.ops):
            raise Untranslatable(node, "this comparison")
        last = [self.number(node.left)]

        def link(i: int) -> Callable[[], Any]:
            def compare() -> Any:
                left, right = last[0], self.number(node.comparators[i])
                last[0] = right
                return self.builder.icmp_signed(_COMPARISONS[type(node.ops[i])], left, right)

            return compare

        return self.lazily([link(i) for i in range(len(node.ops))], True)

    def of_BoolOp(self, node: ast.BoolOp) -> Thing:  # noqa: N802
        def part(operand: ast.expr) -> Callable[[], Any]:
            return lambda: self.truth(operand)

        return self.lazily([part(operand) for operand in node.values], isinstance(node.op, ast.And))

    def lazily(self, parts: Sequence[Callable[[], Any]], conjunction: bool) -> Any:
        """All of the truths (or any of them), evaluated as far as it takes."""
        if len(parts) == 1:
            return parts[0]()
        after = self.new("known")
        arriving: list[tuple[Any, Any]] = []
        for part in parts[:-1]:
            truth = part()
            arriving.append((BIT(0 if conjunction else 1), self.builder.block))
            more = self.new("more")
            if conjunction:
                self.builder.cbranch(truth, more, after)
            else:
                self.builder.cbranch(truth, after, more)
            self.builder.position_at_end(more)
        truth = parts[-1]()
        arriving.append((truth, self.builder.block))
        self.builder.branch(after)
        return self.joined(after, arriving, BIT)

    def joined(self, after: Any, arriving: Sequence[tuple[Any, Any]], kind: Any) -> Any:
        """Go on in a block with the value that the way there has brought."""
        self.builder.position_at_end(after)
        meeting = self.builder.phi(kind)
        for value, block in arriving:
            meeting.add_incoming(value, block)
        return meeting

    def of_IfExp(self, node: ast.IfExp) -> Thing:  # noqa: N802
        then, otherwise, after = self.new("then"), self.new("else"), self.new("after")
        self.builder.cbranch(self.truth(node.test), then, otherwise)
        arriving = []
        for block, expression in ((then, node.body), (otherwise, node.orelse)):
            self.builder.position_at_end(block)
            arriving.append((self.number(expression), self.builder.block))
            self.builder.branch(after)
        return self.joined(after, arriving, WORD)

    def of_Call(self, node: ast.Call) -> Thing:  # noqa: N802
        if node.keywords:
            raise Untranslatable(node, "an argument by name")
        callee = self.named(node.func)
        if isinstance(callee, FunctionType) and callee in self.made:
            return self.call(node, callee)
        name = getattr(callee, "__name__", "")
        translate = getattr(self, f"call_{name}", None)
        if translate is None:
            raise Untranslatable(node, f"a call of {name}")
        return translate(node)

    def call(self, node: ast.Call, callee: FunctionType) -> Thing:
        """Call another kernel."""
        words: list[Any] = []
        for argument, (_, kind) in zip(node.args, parameters(callee, self.wide), strict=True):
            words += [self.number(argument)] if kind in (int, bool) else words_in(self.value(argument))
        return self.builder.call(self.made[callee], words)

    def call_len(self, node: ast.Call) -> Thing:
        span = self.value(node.args[0])
        if not isinstance(span, ArraySpan):
            raise Untranslatable(node, "the length of this")
        return span.length

    def call_int(self, node: ast.Call) -> Thing:
        return self.number(node.args[0])

    def call_max(self, node: ast.Call) -> Thing:
        return self.extreme(node, ">")

    def call_min(self, node: ast.Call) -> Thing:
        return self.extreme(node, "<")

    def extreme(self, node: ast.Call, better: str) -> Any:
        found, *others = [self.number(argument) for argument in node.args]
        for other in others:
            found = self.builder.select(self.builder.icmp_signed(better, other, found), other, found)
        return found

    def call_wrapping_product(self, node: ast.Call) -> Thing:
        left, right = (self.number(argument) for argument in node.args)
        return self.builder.and_(self.builder.mul(left, right), WORD((1 << 63) - 1))

    def call_prefetch(self, node: ast.Call) -> Thing:
        span, index = self.value(node.args[0]), self.number(node.args[1])
        if not isinstance(span, ArraySpan):
            raise Untranslatable(node, "asking for this")
        number = ir.IntType(32)
        fetch = self.module.globals.get("llvm.prefetch.p0") or ir.Function(
            self.module,
            ir.FunctionType(ir.VoidType(), [BYTE.as_pointer(), number, number, number]),
            name="llvm.prefetch.p0",
        )
        place = self.builder.bitcast(self.at(span, index, inside=False), BYTE.as_pointer())
        return self.builder.call(fetch, [place, number(0), number(3), number(1)])
