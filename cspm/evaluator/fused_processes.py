"""Hot process definitions as single Python functions.

What :mod:`cspcheck.cspm.evaluator.fusion` does for expressions, for the terms of processes: guards, prefixes whose
fields are plain, choices between them and mentions of other processes become one Python function of the arguments. A
process with data is unfolded once for each value of its arguments, so its text is worth being compiled once.

The functions give the terms that the closures give. Whatever is out of the ordinary, they leave to these: where
anything fails, and where a value is not what the types let expect, they evaluate the whole once more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence as Items
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.builtins_data import append
from cspcheck.cspm.evaluator.dotting import dot_parts
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.fusion import DEEPEST, FusedPlace, Fuser
from cspcheck.cspm.evaluator.keys import native
from cspcheck.cspm.evaluator.patterns import is_irrefutable, is_variable
from cspcheck.cspm.evaluator.prefixes import MOST_BRANCHES
from cspcheck.cspm.evaluator.processes import chain
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.process.construction import external_choice
from cspcheck.cspm.process.terms import STOP, Prefix, Process
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import ChannelHead, Dotted, Event, Head, dot
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import FiniteSet, Set
from cspcheck.cspm.values.thunks import Code, Env, Thunk
from cspcheck.cspm.values.values import Boolean, Sequence, deep

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator

MOST_INPUTS = 1 << 12
"""A field that takes more values than this is left to the closures, which need not list them."""

ProcessCode = Callable[[Env], Process]


class Retreat(Exception):
    """A value is none that a fused function can go on with."""


class ProcessFuser(Fuser):
    """Writes process terms, and the expressions in them, as Python text.

    Failures need no places here: the closures find them again.
    """

    def process(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for *node* as a process term."""
        while isinstance(node, syntax.Paren):
            node = node.inner
        if depth < DEEPEST:
            text: str | None = None
            match node:
                case syntax.Guard():
                    body = self.process(node.body, place, depth + 1)
                    text = f"({body} if {self.test(node.condition, place, depth + 1)} else STOP)"
                case syntax.If():
                    then = self.process(node.then, place, depth + 1)
                    otherwise = self.process(node.otherwise, place, depth + 1)
                    text = f"({then} if {self.test(node.condition, place, depth + 1)} else {otherwise})"
                case syntax.ProcessBinary(operator="[]"):
                    operands = [self.process(operand, place, depth + 1) for operand in chain(node)]
                    text = f"choice(({', '.join(operands)}))"
                case syntax.Replicated(operator="[]"):
                    text = self._replicated(node, place, depth)
                case syntax.Prefix():
                    text = self._prefix(node, place, depth)
                case syntax.Apply():
                    text = self._mention(node, place, depth)
            if text is not None:
                self.fusion.gain += 1
                return text
        return f"{self.fusion.object(self.evaluator.process(node, place.frame))}({place.env})"

    def _replicated(self, node: syntax.Replicated, place: FusedPlace, depth: int) -> str | None:
        first = node.statements[0]
        if not isinstance(first, syntax.Generator):
            return None
        from cspcheck.cspm.typing import types

        items = self._items(first.source, place)
        evaluated = isinstance(self.type_of(first.source), types.SetOf)
        found = self.loops(node.statements, place, items, evaluated=evaluated)
        if found is None:
            return None
        text, inside = found
        return f"choice([{self.process(node.body, inside, depth + 1)}{text}])"

    def _items(self, source: syntax.Expr, place: FusedPlace) -> str:
        """Text for the list of what a generator ranges over, by a closure: it must bind no names."""
        value = self.evaluator.value(source, place.frame)
        return f"{self.fusion.object(_listing(value))}({place.env})"

    # --- mentions of processes ------------------------------------------------------------------------------

    def _mention(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function
        from cspcheck.cspm.evaluator.routines import Routine

        known = known_function(self.evaluator, node, place.frame)
        if not isinstance(known, Routine) or known.groups != (len(node.arguments),):
            return None
        keys: list[str] = []
        values: list[str] = []
        all_atoms = all(self._is_atom(argument) for argument in node.arguments)
        for argument in node.arguments:
            key, value = self._argument(argument, place, depth + 1)
            keys.append(key)
            values.append(value)
        refer = self.fusion.object(known.refer)
        key = self._fresh("q")
        key_text = f"({key} := ({''.join(f'{text}, ' for text in keys)}))"
        value_text = key if all_atoms else f"({''.join(f'{text}, ' for text in values)})"
        if known.frame.size:
            base = "env" if known.frame.size == place.base else f"env[:{known.frame.size}]"
            if known.frame.size > place.base:
                return None
            return f"{refer}({key_text}, {base}, {value_text})"
        get = self.fusion.object(known.entries.get)
        entry, found = self._fresh("e"), self._fresh("r")
        there = f"({entry} := {get}({key_text})) is not None and ({found} := {entry}()) is not None"
        return f"({found} if {there} else {refer}({key}, (), {value_text}))"

    def _argument(self, node: syntax.Expr, place: FusedPlace, depth: int) -> tuple[str, str]:
        """Text for what stands for an argument in a key, and then for the argument itself, evaluated."""
        from cspcheck.cspm.typing import types

        text = self.value(node, place, depth)
        a = self._fresh("a")
        kind = self.type_of(node)
        if self._is_atom(node):
            return f"({a} := {text})", a
        if isinstance(kind, types.SetOf):
            v = self._fresh("v")
            plain = f"{a}.items if type({a} := {v} if type({v} := {text}) is FiniteSet else deep({v})) is FiniteSet"
            return f"({plain} else {a})", a
        return f"native({a} := deep({text}))", a

    def _is_atom(self, node: syntax.Expr) -> bool:
        """Whether the value is certainly one that is evaluated through and through and its own key."""
        from cspcheck.cspm.typing import types

        return self.type_of(node) in (types.INT, types.BOOL, types.CHAR)

    # --- prefixes -------------------------------------------------------------------------------------------

    def _prefix(self, node: syntax.Prefix, place: FusedPlace, depth: int) -> str | None:
        """Text for a prefix whose fields are outputs of plain values and inputs of plain variables."""
        parts = dot_parts(node.channel)
        name = parts[0]
        if not isinstance(name, syntax.Name) or self.evaluator.names.symbol(name).kind is not SymbolKind.CHANNEL:
            return None
        head = place.frame.unit.head(self.evaluator.names.symbol(name))
        if not isinstance(head, ChannelHead) or len(parts) - 1 + len(node.fields) != head.arity:
            return None
        outputs = [*parts[1:], *[field.expression for field in node.fields if field.expression is not None]]
        if not all(self._is_plain(output) for output in outputs):
            return None
        if len(outputs) == head.arity:
            body = self.process(node.body, place, depth + 1)
            return f"one({self._event(head, [self.value(output, place, depth + 1) for output in outputs])}, {body})"
        return self._inputs(node, head, parts[1:], place, depth)

    def _inputs(
        self, node: syntax.Prefix, head: ChannelHead, outputs: Items[syntax.Expr], place: FusedPlace, depth: int
    ) -> str | None:
        used = mentioned(node.body, self.evaluator.names, self.evaluator.free_variables)
        # In comprehensions nested text may not be evaluated before the loops: outputs in front are, by need, repeated.
        fields = [self.value(output, place, depth + 1) for output in outputs]
        loops = ""
        inside = place
        shared = True
        for field in node.fields:
            if field.expression is not None:
                fields.append(self.value(field.expression, inside, depth + 1))
                continue
            if field.kind != "?" or field.pattern is None or not is_irrefutable(self.evaluator, field.pattern):
                return None
            variable = self._fresh("x")
            source = self._input_values(field, head, len(fields), inside)
            if source is None:
                return None
            loops += f" for {variable} in {source}"
            fields.append(variable)
            pattern = field.pattern
            while isinstance(pattern, syntax.ParenPattern):
                pattern = pattern.inner
            symbol: Symbol | None = None
            if is_variable(self.evaluator, pattern):
                symbol = self.evaluator.names.symbol(pattern)
                shared = shared and symbol not in used
                inside = inside.within(inside.frame.with_variables([symbol], evaluated=True), [variable])
        event = self._event(head, fields)
        if shared:
            # Evaluated once for all events, and for none if there is none.
            numbers = self._fresh("n")
            body = self.process(node.body, place, depth + 1)
            return f"(same({numbers}, {body}) if ({numbers} := [{event}{loops}]) else STOP)"
        return f"several([({event}, {self.process(node.body, inside, depth + 1)}){loops}])"

    def _input_values(self, field: syntax.Field, head: ChannelHead, position: int, place: FusedPlace) -> str | None:
        """Text for the list of the values of an input, without names bound."""
        from cspcheck.cspm.typing import types

        if field.restriction is None:
            domain = head.domains[position]
            if domain.exceeds(MOST_INPUTS) or not all(map(_is_one_field, domain.elements())):
                return None
            return f"{self.fusion.object(domain.elements)}()"
        kind = self.type_of(field.restriction)
        if not isinstance(kind, types.SetOf) or not self._is_plain_type(types.resolve(kind.element)):
            return None
        value = self.evaluator.value(field.restriction, place.frame)
        return f"{self.fusion.object(_members(value))}({place.env})"

    def _event(self, head: ChannelHead, fields: Items[str]) -> str:
        """Text for the number of an event."""
        if not fields:
            event = head.value
            if type(event) is not Event:
                raise Retreat
            return str(event.number)
        numbers = self.fusion.object(head.numbers.get)
        number, key = self._fresh("i"), self._fresh("f")
        there = f"({number} := {numbers}({key} := ({''.join(f'{field}, ' for field in fields)}))) is not None"
        return f"({number} if {there} else {self.fusion.object(_numbering(head))}({key}))"

    # --- expressions ----------------------------------------------------------------------------------------

    def _is_plain(self, node: syntax.Expr) -> bool:
        """Whether the value is one field whatever stands around it, and equal values are one key to look up."""
        return self._is_plain_type(self.type_of(node))

    def _is_plain_type(self, kind: Any) -> bool:
        from cspcheck.cspm.typing import types

        return kind in (types.INT, types.BOOL, types.CHAR) or isinstance(kind, types.Datatype)

    def value(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node*: some forms more than in expressions."""
        from cspcheck.cspm.typing import types

        while isinstance(node, syntax.Paren):
            node = node.inner
        if depth < DEEPEST:
            match node:
                case syntax.Unary(operator="#") if isinstance(self.type_of(node.operand), types.SequenceOf):
                    self.fusion.gain += 1
                    return f"len({self.value(node.operand, place, depth + 1)})"
                case syntax.SetExpr(statements=None) if node.items and self._is_plain(node.items[0]):
                    self.fusion.gain += 1
                    items = [self.value(item, place, depth + 1) for item in node.items]
                    return f"FiniteSet(frozenset(({', '.join(items)},)))"
                case syntax.Dot():
                    text = self._dotted(node, place, depth)
                    if text is not None:
                        return text
                case syntax.LiteralExpr(kind="bool"):
                    return "TRUE" if node.value else "FALSE"
                case syntax.Name():
                    symbol = self.evaluator.names.symbol(node)
                    if symbol.kind is SymbolKind.CONSTRUCTOR and isinstance(self.type_of(node), types.Datatype):
                        value = place.frame.unit.head(symbol).value
                        if type(value) is Dotted and value.complete:
                            return self.fusion.object(value)
        return super().value(node, place, depth)

    def _dotted(self, node: syntax.Dot, place: FusedPlace, depth: int) -> str | None:
        """Text for a constructor with plain fields."""
        from cspcheck.cspm.typing import types

        parts = dot_parts(node)
        name = parts[0]
        if not isinstance(name, syntax.Name) or not isinstance(self.type_of(node), types.Datatype):
            return None
        symbol = self.evaluator.names.symbol(name)
        if symbol.kind is not SymbolKind.CONSTRUCTOR or not all(self._is_plain(part) for part in parts[1:]):
            return None
        head = place.frame.unit.head(symbol)
        if len(parts) - 1 != head.arity:
            return None
        self.fusion.gain += 1
        found, key = self._fresh("d"), self._fresh("f")
        fields = [self.value(part, place, depth + 1) for part in parts[1:]]
        there = f"({found} := {self.fusion.object(head.known.get)}({key} := ({', '.join(fields)},))) is not None"
        return f"({found} if {there} else {self.fusion.object(_building(head))}({key}))"

    def _comparison(self, node: syntax.Binary, place: FusedPlace, depth: int) -> str:
        from cspcheck.cspm.typing import types

        kind = self.type_of(node.left)
        if node.operator in ("==", "!=") and (kind is types.BOOL or isinstance(kind, types.Datatype)):
            # There is one object for each complete value.
            self.fusion.gain += 1
            sign = "is" if node.operator == "==" else "is not"
            return f"({self.value(node.left, place, depth + 1)} {sign} {self.value(node.right, place, depth + 1)})"
        return super()._comparison(node, place, depth)

    def _concatenation(self, node: syntax.Binary, place: FusedPlace, depth: int) -> str:
        self.fusion.gain += 1
        left = self.value(node.left, place, depth + 1)
        return f"append({left}, {self.value(node.right, place, depth + 1)})"

    def _application(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function

        known = known_function(self.evaluator, node, place.frame)
        if not isinstance(known, Builtin):
            return super()._application(node, place, depth)
        if len(known.kinds) != len(node.arguments) or not set(known.kinds) <= {"v", "l"}:
            return None
        self.fusion.gain += 1
        ways = {"v": self.value, "l": self.delayed}
        given = [
            ways[kind](argument, place, depth + 1) for kind, argument in zip(known.kinds, node.arguments, strict=True)
        ]
        return f"{self.fusion.object(known.call)}({', '.join(given)})"


# --- what fused functions call -------------------------------------------------------------------------------


def _one(number: int, then: Process) -> Process:
    return Prefix(((number, then),))


def _several(branches: list[tuple[int, Process]]) -> Process:
    if not branches:
        return STOP
    if len(branches) > 1:
        if len(branches) > MOST_BRANCHES:
            raise Retreat
        branches.sort(key=_number)
    return Prefix(tuple(branches))


def _number(branch: tuple[int, Process]) -> int:
    return branch[0]


def _same(numbers: list[int], then: Process) -> Process:
    if len(numbers) > MOST_BRANCHES:
        raise Retreat
    return Prefix(tuple([(number, then) for number in sorted(numbers)]))


def _is_one_field(value: Any) -> bool:
    """Whether a value is one field whatever stands around it."""
    return type(value) in (int, str, Boolean) or (type(value) is Dotted and value.complete)


def _listing(code: Code) -> Callable[[Env], list[Any]]:
    def listing(env: Env) -> list[Any]:
        found = code(env)
        if isinstance(found, Set):
            return found.elements()
        if type(found) is Sequence:
            return found.items()
        raise Retreat

    return listing


def _members(code: Code) -> Callable[[Env], list[Any]]:
    def members(env: Env) -> list[Any]:
        found = code(env)
        if type(found) is FiniteSet or (isinstance(found, Set) and found.is_finite()):
            return found.elements()
        raise Retreat

    return members


def _building(head: Head) -> Callable[[Env], Any]:
    """What makes the complete value of a constructor with these fields."""

    def build(fields: Env) -> Any:
        value = head.value
        for field in fields:
            value = dot(value, field)
        if type(value) is not Dotted or not value.complete:
            raise Retreat
        return value

    return build


def _numbering(head: ChannelHead) -> Callable[[Env], int]:
    """What finds the number of the event with these fields, and keeps it."""

    def number(fields: Env) -> int:
        event = head.value
        for field in fields:
            event = dot(event, field)
        if type(event) is not Event:
            raise Retreat
        found: int = head.numbers.setdefault(fields, event.number)
        return found

    return number


def fused_process(
    evaluator: Evaluator, body: syntax.Expr, frame: Frame, parameters: tuple[int, int], closure: ProcessCode
) -> ProcessCode:
    """*closure*, the code of a process's body, as one function if that saves calls.

    Args:
        evaluator: that of the script.
        body: what follows the equals sign.
        frame: the variables in scope.
        parameters: where the parameters begin among these, and how many there are: plain variables among them are
            taken for evaluated.
        closure: what is asked where the function cannot go on, and from then on.
    """
    start, width = parameters
    fuser = ProcessFuser(evaluator)
    fusion = fuser.fusion
    fusion.objects |= {
        "FiniteSet": FiniteSet,
        "STOP": STOP,
        "append": append,
        "choice": external_choice,
        "deep": deep,
        "frozenset": frozenset,
        "len": len,
        "native": native,
        "one": _one,
        "same": _same,
        "several": _several,
    }
    try:
        text = fuser.process(body, FusedPlace(frame, frame.size))
    except (Failure, Retreat):  # a declaration is amiss
        return closure
    if fusion.gain < 1:
        return closure
    fused = fusion.compiled("env", f"    return {text}\n")
    if fused is None:
        return closure
    run: ProcessCode = fused
    end = start + width

    def guarded(env: Env) -> Process:
        nonlocal run
        if Thunk not in map(type, env[start:end]):
            try:
                return run(env)
            except (Failure, Retreat, ZeroDivisionError):
                run = closure
        return closure(env)

    return guarded
