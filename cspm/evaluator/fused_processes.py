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
from cspcheck.cspm.evaluator.dotting import dot_parts
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.fused_helpers import (
    HELPERS,
    OF_SETS,
    NoMenu,
    Retreat,
    building,
    is_one_field,
    numbering,
)
from cspcheck.cspm.evaluator.fusion import DEEPEST, FusedPlace, Fuser
from cspcheck.cspm.evaluator.patterns import is_irrefutable, is_variable
from cspcheck.cspm.evaluator.processes import chain
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.process.terms import Menu, Process
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import ChannelHead, Dotted, Event, Head
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Env, Thunk

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator
    from cspcheck.cspm.evaluator.routines import Routine
    from cspcheck.cspm.evaluator.units import Unit

MOST_INPUTS = 1 << 12
"""A field that takes more values than this is left to the closures, which need not list them."""

MOST_OPEN = 15
"""A menu that needs that of another process that needs a third, so many of them, is left to their terms."""

ProcessCode = Callable[[Env], Process]


class ProcessFuser(Fuser):
    """Writes process terms, and the expressions in them, as Python text.

    Failures need no places here: the closures find them again.
    """

    def __init__(self, evaluator: Evaluator, unit: Unit) -> None:
        super().__init__(evaluator)
        self.unit = unit
        self.fusion.objects |= HELPERS

    def process(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for *node* as a process term."""
        node = syntax.bare(node)
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

    def _replicated(self, node: syntax.Replicated, place: FusedPlace, depth: int, *, menu: bool = False) -> str | None:
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
        if menu:
            return f"joined([{self.menu(node.body, inside, depth + 1, operand=True)}{text}])"
        return f"choice([{self.process(node.body, inside, depth + 1)}{text}])"

    def _items(self, source: syntax.Expr, place: FusedPlace) -> str:
        """Text for the list of what a generator ranges over, by a closure: it must bind no names."""
        return self._listed_by("listing", source, place)

    def _listed_by(self, way: str, source: syntax.Expr, place: FusedPlace) -> str:
        """Text for the list that a helper makes of the value of *source*.

        Python allows no names to be bound in what a comprehension ranges over: text that does is a closure instead.
        """
        text = self.value(source, place)
        if ":=" in text:
            text = f"{self.fusion.object(self.evaluator.value(source, place.frame))}({place.env})"
        return f"{way}({text})"

    # --- menus ----------------------------------------------------------------------------------------------

    def menu(self, node: syntax.Expr, place: FusedPlace, depth: int = 0, *, operand: bool = False) -> str:
        """Text for the menu of *node*; *operand*: for the groups of an operand of a choice, none for STOP."""
        node = syntax.bare(node)
        if depth < DEEPEST:
            match node:
                case syntax.Guard():
                    body = self.menu(node.body, place, depth + 1, operand=operand)
                    return f"({body} if {self.test(node.condition, place, depth + 1)} else ())"
                case syntax.If():
                    then = self.menu(node.then, place, depth + 1, operand=operand)
                    otherwise = self.menu(node.otherwise, place, depth + 1, operand=operand)
                    return f"({then} if {self.test(node.condition, place, depth + 1)} else {otherwise})"
                case syntax.ProcessBinary(operator="[]"):
                    self.fusion.gain += 1
                    groups = [self.menu(part, place, depth + 1, operand=True) for part in chain(node)]
                    return f"({' + '.join(groups)})"
                case syntax.Replicated(operator="[]"):
                    text = self._replicated(node, place, depth, menu=True)
                    if text is not None:
                        return text
                case syntax.Prefix():
                    text = self._prefix(node, place, depth, menu=True)
                    if text is not None:
                        self.fusion.gain += 1
                        return text
        return f"{'groups' if operand else 'whole'}({self.process(node, place, depth)})"

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
        if isinstance(kind, types.SequenceOf | types.MapOf):
            return f"(({a} := {text})._native or {a}.native)", a
        return f"native({a} := deep({text}))", a

    def _is_atom(self, node: syntax.Expr) -> bool:
        """Whether the value is certainly one that is evaluated through and through and its own key."""
        return self._is_plain(node)

    # --- prefixes -------------------------------------------------------------------------------------------

    def _prefix(self, node: syntax.Prefix, place: FusedPlace, depth: int, *, menu: bool = False) -> str | None:
        """Text for a prefix whose fields are outputs of plain values and inputs of plain variables."""
        parts = dot_parts(node.channel)
        name = parts[0]
        if not isinstance(name, syntax.Name) or self.evaluator.names.symbol(name).kind is not SymbolKind.CHANNEL:
            return None
        head = self.unit.head(self.evaluator.names.symbol(name))
        if not isinstance(head, ChannelHead) or len(parts) - 1 + len(node.fields) != head.arity:
            return None
        outputs = [*parts[1:], *[field.expression for field in node.fields if field.expression is not None]]
        if not all(self._is_plain(output) for output in outputs):
            return None
        if len(outputs) == head.arity:
            body = self.process(node.body, place, depth + 1)
            event = self._event(head, [self.value(output, place, depth + 1) for output in outputs])
            return f"((({event}, {body}),),)" if menu else f"one({event}, {body})"
        return self._inputs(node, head, parts[1:], place, depth, menu=menu)

    def _inputs(
        self,
        node: syntax.Prefix,
        head: ChannelHead,
        outputs: Items[syntax.Expr],
        place: FusedPlace,
        depth: int,
        *,
        menu: bool,
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
            alike = f"same_group({numbers}, {body})" if menu else f"same({numbers}, {body})"
            return f"({alike} if ({numbers} := [{event}{loops}]) else {'()' if menu else 'STOP'})"
        several = "several_group" if menu else "several"
        return f"{several}([({event}, {self.process(node.body, inside, depth + 1)}){loops}])"

    def _input_values(self, field: syntax.Field, head: ChannelHead, position: int, place: FusedPlace) -> str | None:
        """Text for the list of the values of an input, without names bound."""
        from cspcheck.cspm.typing import types

        if field.restriction is None:
            domain = head.domains[position]
            if domain.exceeds(MOST_INPUTS) or not all(map(is_one_field, domain.elements())):
                return None
            return f"{self.fusion.object(domain.elements)}()"
        kind = self.type_of(field.restriction)
        if not isinstance(kind, types.SetOf) or not self._is_plain_type(types.resolve(kind.element)):
            return None
        only = field.restriction
        only = syntax.bare(only)
        if isinstance(only, syntax.SetExpr) and only.statements is None and len(only.items) == 1:
            text = self.value(only.items[0], place)
            if ":=" not in text:
                return f"({text},)"
        return self._listed_by("members", field.restriction, place)

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
        return f"({number} if {there} else {self.fusion.object(numbering(head))}({key}))"

    # --- expressions ----------------------------------------------------------------------------------------

    def _is_plain(self, node: syntax.Expr) -> bool:
        """Whether the value is one field whatever stands around it, and equal values are one key to look up."""
        return self._is_plain_type(self.type_of(node)) or self._whole(node) is not None

    def _is_plain_type(self, kind: Any) -> bool:
        from cspcheck.cspm.typing import types

        return kind in (types.INT, types.BOOL, types.CHAR) or isinstance(kind, types.Datatype)

    def value(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node*: some forms more than in expressions."""
        from cspcheck.cspm.typing import types

        node = syntax.bare(node)
        if depth < DEEPEST:
            match node:
                case syntax.Unary(operator="#") if isinstance(self.type_of(node.operand), types.SequenceOf):
                    self.fusion.gain += 1
                    q = self._fresh("s")
                    operand = self.value(node.operand, place, depth + 1)
                    return f"({q}._end if ({q} := {operand})._rest is None else len({q}))"
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
                        value = self.unit.head(symbol).value
                        if type(value) is Dotted and value.complete:
                            return self.fusion.object(value)
        return super().value(node, place, depth)

    def delayed(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node* or a thunk of it."""
        node = syntax.bare(node)
        if isinstance(node, syntax.Name) and self.evaluator.names.symbol(node) in place.frame.evaluated:
            return place.variable(place.frame.slots[self.evaluator.names.symbol(node)])
        return super().delayed(node, place, depth)

    def _dotted(self, node: syntax.Dot, place: FusedPlace, depth: int) -> str | None:
        """Text for a constructor with all its fields, each of which is plain."""
        head = self._whole(node)
        if head is None:
            return None
        self.fusion.gain += 1
        found, key = self._fresh("d"), self._fresh("f")
        fields = [self.value(part, place, depth + 1) for part in dot_parts(node)[1:]]
        there = f"({found} := {self.fusion.object(head.known.get)}({key} := ({', '.join(fields)},))) is not None"
        return f"({found} if {there} else {self.fusion.object(building(head))}({key}))"

    def _whole(self, node: syntax.Expr) -> Head | None:
        """The constructor whose complete value *node* certainly is, with dots between it and its plain fields."""
        node = syntax.bare(node)
        if not isinstance(node, syntax.Dot):
            return None
        parts = dot_parts(node)
        name = parts[0]
        if not isinstance(name, syntax.Name):
            return None
        symbol = self.evaluator.names.symbol(name)
        if symbol.kind is not SymbolKind.CONSTRUCTOR or not all(self._is_plain(part) for part in parts[1:]):
            return None
        head = self.unit.head(symbol)
        return head if len(parts) - 1 == head.arity else None

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
        # The types are known, so what makes sure of them can be left out.
        function = self.fusion.object(OF_SETS.get(known.name, known.call))
        return f"{function}({', '.join(given)})"


def fused_process(evaluator: Evaluator, body: syntax.Expr, frame: Frame) -> ProcessCode:
    """What gives the term of a process's body; its plain parameters must be given without thunks."""
    fuser = ProcessFuser(evaluator, frame.unit)
    try:
        text = fuser.process(body, FusedPlace(frame, frame.size))
    except (Failure, Retreat):  # a declaration is amiss
        text = ""
    fused = fuser.fusion.compiled("env", f"    return {text}\n") if text and fuser.fusion.gain else None
    return fused or evaluator.process(body, frame)


def with_terms(routine: Routine, fused: ProcessCode, closures: ProcessCode) -> ProcessCode:
    """*fused* where the arguments have no thunks, and *closures* elsewhere, and from then on where it fails."""
    start = routine.frame.size
    end = start + routine.width

    def enter(env: Env) -> Process:
        if Thunk not in map(type, env[start:end]):
            try:
                return fused(env)
            except (Failure, Retreat, ZeroDivisionError):
                routine.enter_process = closures
        return closures(env)

    return enter


def fused_menu(evaluator: Evaluator, body: syntax.Expr, frame: Frame) -> Callable[[Env], Menu]:
    """What gives the menu of a process's body; it raises ``NoMenu`` where that has none."""
    fuser = ProcessFuser(evaluator, frame.unit)
    try:
        text = fuser.menu(body, FusedPlace(frame, frame.size))
    except (Failure, Retreat):
        return _no_menu
    return fuser.fusion.compiled("env", f"    return {text}\n") or _no_menu


def _no_menu(env: Env) -> Menu:
    raise NoMenu


def with_menus(routine: Routine, menu: Callable[[Env], Menu]) -> Callable[[Env], Menu | None]:
    """*menu* with None for what has none; given up where the definition turns out to have none as a rule."""
    start = routine.frame.size
    end = start + routine.width
    evaluator = routine.evaluator
    given = missed = 0

    def enter(env: Env) -> Menu | None:
        nonlocal given, missed
        if Thunk in map(type, env[start:end]) or evaluator.menus_open > MOST_OPEN:
            return None
        evaluator.menus_open += 1
        try:
            found = menu(env)
            given += 1
        except NoMenu:
            missed += 1
            if missed > 100 + given:
                routine.enter_menu = None
            return None
        except (Failure, Retreat, ZeroDivisionError):
            routine.enter_menu = None
            return None
        finally:
            evaluator.menus_open -= 1
        return found or None

    return enter
