"""Menus of process definitions as Python functions of what stands for their arguments in keys.

A state of a process with data is known by its key: numbers and constants as they are, sets as ``frozenset``, sequences
and maps as tuples (:func:`.keys.native`). Where all parameters are of such types, the function that gives the menu
takes the key and makes the keys of what it leads to by Python's own operations, and the values of the arguments are
made when somebody asks for them: mostly nobody does.

What these functions give is what those of :mod:`.fused_processes` give. Expressions that are not written here are
evaluated as there, on values that are made from the keys. Whatever fails is done again without these functions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence as Items
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.fused_helpers import NATIVE_HELPERS, NoMenu, Retreat, numbering
from cspcheck.cspm.evaluator.fused_processes import MOST_OPEN, ProcessFuser
from cspcheck.cspm.evaluator.fusion import DEEPEST, FusedPlace
from cspcheck.cspm.evaluator.patterns import compile_pattern, is_variable
from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.process.terms import Menu
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import ChannelHead, Dotted
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.values import Boolean

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator
    from cspcheck.cspm.evaluator.routines import Routine

Kind: TypeAlias = Literal["flat", "set", "sequence", "map"]
"""How a value stands in a key: as itself (numbers, constants, tuples of such), or as a collection of such values."""

_CLASSES: Final[dict[Kind, frozenset[type]]] = {
    "flat": frozenset({int, str, Boolean, Dotted, tuple}),
    "set": frozenset({frozenset}),
    "sequence": frozenset({tuple}),
    "map": frozenset({tuple}),
}
_ERRORS: Final = (
    *(Failure, Retreat, ScriptError, ZeroDivisionError),
    *(KeyError, IndexError, TypeError, AttributeError, RecursionError),
)
"""What makes the work be done again without these functions."""

NativeMenu = Callable[[Any], Menu | None]


class _Place(FusedPlace):
    """A place whose first variables are parts of a key: ``natives`` tells which, and of what kind each is."""

    def __init__(self, frame: Frame, variables: tuple[str, ...], natives: dict[int, Kind]) -> None:
        super().__init__(frame, 0, variables)
        self.natives = natives

    @property
    def env(self) -> str:
        """The values of all variables, for a closure."""
        return f"({''.join(f'{self.value(slot)}, ' for slot in range(len(self.variables)))})"

    def value(self, slot: int) -> str:
        """Text for the value of a variable."""
        kind = self.natives.get(slot, "flat")
        name = self.variables[slot]
        return name if kind == "flat" else f"decode_{kind}({name})"

    def within(self, frame: Frame, variables: Items[str]) -> FusedPlace:
        """A place inside, with further variables, which have values."""
        return _Place(frame, (*self.variables, *variables), self.natives)


class _Cell:
    """The key of an expression without variables, found when it is first asked for."""

    __slots__ = ("_find", "key")

    def __init__(self, find: Callable[[], Any]) -> None:
        self.key: Any = None
        self._find = find

    def found(self) -> Any:
        """The key, which stays."""
        if self.key is None:
            self.key = self._find()
        return self.key


class _Numbers(dict[Any, int]):
    """The numbers of a channel's events by their fields: the only one, or all in a tuple."""

    def __init__(self, head: ChannelHead) -> None:
        super().__init__()
        self._number = numbering(head)
        self._alone = head.arity == 1

    def __missing__(self, fields: Any) -> int:
        number = self[fields] = self._number((fields,) if self._alone else fields)
        return number


class NativeFuser(ProcessFuser):
    """Writes the menu of a definition in terms of the keys of its arguments."""

    def __init__(self, evaluator: Evaluator, routine: Routine) -> None:
        super().__init__(evaluator, routine.frame.unit)
        self.fusion.objects |= NATIVE_HELPERS
        self.routine = routine
        self._numbers_of: dict[int, str] = {}
        self._dicts: dict[str, str] = {}
        """The names of maps as Python dictionaries, by the names of their keys."""

    # --- the whole definition -------------------------------------------------------------------------------

    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of the parameters.

        Raises:
            Retreat: some type is none of them.
        """
        patterns, _ = self.routine.clauses[0]
        kinds = [self.kind_of(pattern) for pattern in patterns]
        if not kinds or None in kinds:
            raise Retreat
        return tuple([kind for kind in kinds if kind is not None])

    def statements(self, kinds: tuple[Kind, ...]) -> str:
        """The text of the function ``fused(key)``, without its head.

        Raises:
            Failure: a declaration is amiss.
            Retreat: something is not written in this way.
        """
        # Longer than all names that are made for what is inside.
        names = tuple([f"part{slot}" for slot in range(len(kinds))])
        text = f"    {', '.join(names)}, = key\n"
        for patterns, body in self.routine.clauses:
            text += self._clause(patterns, body, names, kinds)
        return text + "    raise Retreat\n"

    def _clause(
        self, patterns: Items[syntax.Pattern], body: syntax.Expr, names: tuple[str, ...], kinds: tuple[Kind, ...]
    ) -> str:
        plain = [_bare(pattern) for pattern in patterns]
        named = [self._symbol(p) if is_variable(self.evaluator, p) else None for p in plain]
        frame = self.routine.frame.with_variables(named, evaluated=True)
        tests: list[str] = []
        lines: list[str] = []
        natives: dict[int, Kind] = dict(enumerate(kinds))
        variables = [*names]
        for slot, (pattern, symbol) in enumerate(zip(plain, named, strict=True)):
            if symbol is not None or isinstance(pattern, syntax.Wildcard):
                continue
            bound: list[tuple[Symbol, str, Kind]] = []
            self._match(pattern, names[slot], kinds[slot], tests, bound)
            # The slots are those that the closures of expressions inside expect.
            _, inner = compile_pattern(self.evaluator, pattern, frame, evaluated=True)
            if inner.size - frame.size != len(bound):
                raise Retreat
            for symbol_, text, kind in bound:
                place = inner.slots[symbol_]
                if place != len(variables):
                    raise Retreat
                name = self._fresh("m")
                lines.append(f"{name} = {text}")
                variables.append(name)
                natives[place] = kind
            frame = inner.knowing([symbol_ for symbol_, _, _ in bound])
        self._dicts = {}
        menu = self.menu(body, _Place(frame, tuple(variables), natives))
        lines += [f"{there} = dict({name}[1])" for name, there in self._dicts.items()]
        inside = "".join(f"        {line}\n" for line in [*lines, f"return {menu}"])
        return f"    if {' and '.join(tests) or '1'}:\n{inside}"

    def _match(
        self,
        pattern: syntax.Pattern,
        name: str,
        kind: Kind,
        tests: list[str],
        bound: list[tuple[Symbol, str, Kind]],
    ) -> None:
        """Add what has to hold of a part of a key to match, and what its variables are then."""
        match pattern:
            case syntax.LiteralPattern(kind="int"):
                tests.append(f"{name} == {int(pattern.value)}")
            case syntax.LiteralPattern(kind="bool"):
                tests.append(f"{name} is {'TRUE' if pattern.value else 'FALSE'}")
            case syntax.SequencePattern() | syntax.ConcatPattern() if kind == "sequence":
                self._match_sequence(pattern, name, tests, bound)
            case _:
                raise Retreat

    def _match_sequence(
        self, pattern: syntax.Pattern, name: str, tests: list[str], bound: list[tuple[Symbol, str, Kind]]
    ) -> None:
        parts: list[syntax.Pattern] = []
        waiting = [pattern]
        while waiting:
            part = _bare(waiting.pop())
            if isinstance(part, syntax.ConcatPattern):
                waiting += (part.right, part.left)
            else:
                parts.append(part)
        open_ = [i for i, part in enumerate(parts) if not isinstance(part, syntax.SequencePattern)]
        least = sum(len(part.items) for part in parts if isinstance(part, syntax.SequencePattern))
        if len(open_) > 1:
            raise Retreat
        tests.append(f"len({name}) {'>' if open_ else '=='} {least + (0 if open_ else 1)}")
        # In a key the last element comes first, behind the class.
        front = 0
        for part in parts:
            if isinstance(part, syntax.SequencePattern):
                for item in part.items:
                    front += 1
                    self._element(_bare(item), f"{name}[-{front}]", tests, bound)
            else:
                behind = least - front
                rest = f"(Sequence, *{name}[{behind + 1}:{f'-{front}' if front else ''}])"
                if is_variable(self.evaluator, part):
                    bound.append((self._symbol(part), rest, "sequence"))
                elif not isinstance(part, syntax.Wildcard):
                    raise Retreat
                break
        items = [item for part in parts[open_[0] + 1 :] for item in part.items] if open_ else []  # type: ignore[attr-defined]
        for place, item in enumerate(reversed(items), 1):
            self._element(_bare(item), f"{name}[{place}]", tests, bound)

    def _element(
        self, item: syntax.Pattern, text: str, tests: list[str], bound: list[tuple[Symbol, str, Kind]]
    ) -> None:
        if is_variable(self.evaluator, item):
            bound.append((self._symbol(item), text, "flat"))
        elif isinstance(item, syntax.LiteralPattern) and item.kind == "int":
            tests.append(f"{text} == {int(item.value)}")
        elif not isinstance(item, syntax.Wildcard):
            raise Retreat

    def _symbol(self, pattern: syntax.Pattern) -> Symbol:
        return self.evaluator.names.symbol(pattern)

    # --- kinds ----------------------------------------------------------------------------------------------

    def kind_of(self, node: syntax.Expr | syntax.Pattern) -> Kind | None:
        """How the value of *node* stands in a key; None if it is not one of these ways."""
        from cspcheck.cspm.typing import types

        while isinstance(node, syntax.ParenPattern):
            node = node.inner
        kind = self.type_of(node)  # type: ignore[arg-type]
        match kind:
            case types.SetOf() if self._is_flat(kind.element):
                return "set"
            case types.SequenceOf() if self._is_flat(kind.element):
                return "sequence"
            case types.MapOf() if self._is_flat(kind.key) and self._is_flat(kind.value):
                return "map"
        return "flat" if kind is not None and self._is_flat(kind) else None

    def _is_flat(self, kind: Any) -> bool:
        from cspcheck.cspm.typing import types

        kind = types.resolve(kind)
        if isinstance(kind, types.TupleOf):
            return all(map(self._is_flat, kind.items))
        return self._is_plain_type(kind)

    def _is_closed(self, node: syntax.Node) -> bool:
        """Whether no variable is mentioned."""
        return not mentioned(node, self.evaluator.names, self.evaluator.free_variables)

    # --- expressions as parts of keys -----------------------------------------------------------------------

    def native(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for what stands for the value of *node* in a key."""
        node = syntax.bare(node)
        kind = self.kind_of(node)
        if kind is None:
            raise Retreat
        if kind == "flat":
            if isinstance(node, syntax.TupleExpr):
                self.fusion.gain += 1
                return f"({', '.join(self.native(item, place, depth + 1) for item in node.items)},)"
            text = self.value(node, place, depth)
            return text if self._is_plain(node) or self._native_slot(node, place) is not None else f"deep({text})"
        return self._direct(node, place, depth) or f"encode_{kind}({super().value(node, place, depth)})"

    def _direct(self, node: syntax.Expr, place: FusedPlace, depth: int) -> str | None:
        """Text for what stands for a collection in a key, without its value; None if that is not written here."""
        if depth >= DEEPEST:
            return None
        slot = self._native_slot(node, place)
        if slot is not None:
            return place.variables[slot]
        if self._is_closed(node):
            return self._constant(node, place)
        match node:
            case syntax.SetExpr(statements=None):
                items = "".join(f"{self.native(item, place, depth + 1)}, " for item in node.items)
                return f"frozenset(({items}))"
            case syntax.SequenceExpr(statements=None):
                return f"(Sequence, {self._backward(node, place, depth)})"
            case syntax.Binary(operator="^"):
                left, right = syntax.bare(node.left), syntax.bare(node.right)
                if isinstance(left, syntax.SequenceExpr) and left.statements is None:
                    return f"(*{self.native(right, place, depth + 1)}, {self._backward(left, place, depth)})"
                if isinstance(right, syntax.SequenceExpr) and right.statements is None:
                    items = self._backward(right, place, depth)
                    return f"(Sequence, {items}*{self.native(left, place, depth + 1)}[1:])"
                return f"({self.native(right, place, depth + 1)} + {self.native(left, place, depth + 1)}[1:])"
            case syntax.If():
                then = self.native(node.then, place, depth + 1)
                otherwise = self.native(node.otherwise, place, depth + 1)
                return f"({then} if {self.test(node.condition, place, depth + 1)} else {otherwise})"
            case syntax.Apply():
                return self._collection(node, place, depth + 1)
        return None

    def _native_slot(self, node: syntax.Expr, place: FusedPlace) -> int | None:
        """The position of a variable that is a part of a key; None for anything else."""
        if not isinstance(node, syntax.Name) or not isinstance(place, _Place):
            return None
        slot = place.frame.slots.get(self.evaluator.names.symbol(node))
        return slot if slot in place.natives else None

    def _backward(self, node: syntax.SequenceExpr, place: FusedPlace, depth: int) -> str:
        """The elements of a sequence as they stand in a key: the last of them first."""
        self.fusion.gain += 1
        return "".join(f"{self.native(item, place, depth + 1)}, " for item in reversed(node.items))

    def _collection(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        """A built-in function that gives a collection."""
        name = self._built_in(node, place)
        given = node.arguments
        if name in ("union", "diff", "inter"):
            sign = {"union": "|", "diff": "-", "inter": "&"}[name]
            self.fusion.gain += 1
            return f"({self.native(given[0], place, depth)} {sign} {self.native(given[1], place, depth)})"
        if name == "set" and self.kind_of(given[0]) == "sequence":
            return f"frozenset({self.native(given[0], place, depth)}[1:])"
        if name == "tail":
            return f"tail_of({self.native(given[0], place, depth)})"
        if name == "mapUpdate":
            self.fusion.gain += 1
            return f"(Map, frozenset({self._updated(node, place, depth)}.items()))"
        return None

    def _updated(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str:
        there, key, value = node.arguments
        texts = self.native(key, place, depth), self.native(value, place, depth)
        return f"{{**{self._dict(there, place, depth)}, {texts[0]}: {texts[1]}}}"

    def _dict(self, node: syntax.Expr, place: FusedPlace, depth: int) -> str:
        """Text for a map as a Python dictionary, from what stands for keys to what stands for values."""
        node = syntax.bare(node)
        if isinstance(node, syntax.Apply) and self._built_in(node, place) == "mapUpdate":
            return self._updated(node, place, depth + 1)
        text = self.native(node, place, depth)
        if text.isidentifier():
            return self._dicts.setdefault(text, f"d_{text}")
        return f"dict({text}[1])"

    def _built_in(self, node: syntax.Apply, place: FusedPlace) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function

        known = known_function(self.evaluator, node, place.frame)
        if isinstance(known, Builtin) and known.name in _WRITTEN and len(known.kinds) == len(node.arguments):
            return known.name
        return None

    def _constant(self, node: syntax.Expr, place: FusedPlace) -> str:
        """Text for what stands for the value of an expression without variables, which is evaluated once."""
        kind = self.kind_of(node)
        encode = NATIVE_HELPERS[f"encode_{kind}"]
        code = self.evaluator.value(node, place.frame)
        nothing = (None,) * place.frame.size
        cell = self.fusion.object(_Cell(lambda: encode(code(nothing))))
        return f"({cell}.key or {cell}.found())"

    # --- values of expressions ------------------------------------------------------------------------------

    def value(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node*."""
        node = syntax.bare(node)
        if depth < DEEPEST:
            if isinstance(node, syntax.Apply):
                text = self._looked_up(node, place, depth + 1)
                if text is not None:
                    self.fusion.gain += 1
                    return text
            if isinstance(node, syntax.Unary) and node.operator == "#" and self.kind_of(node.operand) == "sequence":
                self.fusion.gain += 1
                return f"(len({self.native(node.operand, place, depth + 1)}) - 1)"
            kind = self.kind_of(node)
            if kind not in (None, "flat"):
                text = self._direct(node, place, depth)
                if text is not None:
                    return f"decode_{kind}({text})"
        return super().value(node, place, depth)

    def _looked_up(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        """A built-in function of a collection that gives a flat value."""
        name = self._built_in(node, place)
        if name is None:
            return None
        first = self.kind_of(node.arguments[0])
        if name in ("head", "length") and first == "sequence":
            there = self.native(node.arguments[0], place, depth)
            return f"head_of({there})" if name == "head" else f"(len({there}) - 1)"
        if name == "card" and first == "set":
            return f"len({self.native(node.arguments[0], place, depth)})"
        if name == "mapLookup" and first == "map":
            key = self.native(node.arguments[1], place, depth)
            return f"{self._dict(node.arguments[0], place, depth)}[{key}]"
        if self._question(node, place, depth) is not None:
            return f"(TRUE if {self._question(node, place, depth)} else FALSE)"
        return None

    def _question(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        """A built-in function of a collection that says whether something is so."""
        name = self._built_in(node, place)
        if name in ("member", "elem"):
            if self.kind_of(node.arguments[1]) in ("set", "sequence") and self.kind_of(node.arguments[0]) == "flat":
                part, there = (self.native(argument, place, depth) for argument in node.arguments)
                return f"({part} in {there})"
        elif name == "null" and self.kind_of(node.arguments[0]) == "sequence":
            return f"(len({self.native(node.arguments[0], place, depth)}) == 1)"
        elif name == "empty" and self.kind_of(node.arguments[0]) == "set":
            return f"(not {self.native(node.arguments[0], place, depth)})"
        elif name == "mapMember" and self.kind_of(node.arguments[0]) == "map":
            key = self.native(node.arguments[1], place, depth)
            return f"({key} in {self._dict(node.arguments[0], place, depth)})"
        return None

    def test(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the truth of *node*."""
        node = syntax.bare(node)
        if depth < DEEPEST and isinstance(node, syntax.Apply):
            text = self._question(node, place, depth + 1)
            if text is not None:
                self.fusion.gain += 1
                return text
        return super().test(node, place, depth)

    def _comparison(self, node: syntax.Binary, place: FusedPlace, depth: int) -> str:
        if node.operator in ("==", "!="):
            kinds = self.kind_of(node.left), self.kind_of(node.right)
            if kinds[0] == kinds[1] and kinds[0] not in (None, "flat"):
                self.fusion.gain += 1
                left, right = (self.native(side, place, depth + 1) for side in (node.left, node.right))
                return f"({left} {node.operator} {right})"
        return super()._comparison(node, place, depth)

    def _local(self, node: syntax.Name, slot: int, place: FusedPlace) -> str:
        if isinstance(place, _Place) and slot in place.natives:
            return place.value(slot)
        return super()._local(node, slot, place)

    def delayed(self, node: syntax.Expr, place: FusedPlace, depth: int = 0) -> str:
        """Text for the value of *node* or a thunk of it."""
        node = syntax.bare(node)
        slot = self._native_slot(node, place)
        if slot is not None and isinstance(place, _Place):
            return place.value(slot)
        return super().delayed(node, place, depth)

    def _application(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function

        known = known_function(self.evaluator, node, place.frame)
        if known is not None and not isinstance(known, Builtin) and known.frame.size:
            return None  # its environment would have to be made of values
        return super()._application(node, place, depth)

    def _listed_by(self, way: str, source: syntax.Expr, place: FusedPlace) -> str:
        if self._is_closed(source):
            code = self.evaluator.value(source, place.frame)
            nothing = (None,) * place.frame.size
            helper = self.fusion.objects[way]
            # Python allows no names to be bound in what a comprehension ranges over.
            return f"{self.fusion.object(_Cell(lambda: helper(code(nothing))).found)}()"
        if way == "members" and self.kind_of(source) == "set":
            # In any order: the branches are sorted by their events.
            text = self.native(source, place)
            if ":=" not in text:
                return text
        return super()._listed_by(way, source, place)

    # --- mentions and events --------------------------------------------------------------------------------

    def _mention(self, node: syntax.Apply, place: FusedPlace, depth: int) -> str | None:
        from cspcheck.cspm.evaluator.calls import known_function
        from cspcheck.cspm.evaluator.routines import Routine

        known = known_function(self.evaluator, node, place.frame)
        if not isinstance(known, Routine) or known.groups != (len(node.arguments),) or known.frame.size:
            return None
        kinds = [self.kind_of(argument) for argument in node.arguments]
        if None in kinds:
            return super()._mention(node, place, depth)
        keys = "".join(f"{self.native(argument, place, depth + 1)}, " for argument in node.arguments)
        decode = NATIVE_HELPERS["decoding"](tuple(kinds))
        get, refer = self.fusion.object(known.entries.get), self.fusion.object(known.refer_later)
        key, entry, found = self._fresh("q"), self._fresh("e"), self._fresh("r")
        there = f"({entry} := {get}({key} := ({keys}))) is not None and ({found} := {entry}()) is not None"
        return f"({found} if {there} else {refer}({key}, {self.fusion.object(decode)}))"

    def _event(self, head: ChannelHead, fields: Items[str]) -> str:
        if not fields:
            return super()._event(head, fields)
        name = self._numbers_of.get(id(head))
        if name is None:
            name = self._numbers_of[id(head)] = self.fusion.object(_Numbers(head))
        return f"{name}[{', '.join(fields)}]"


_WRITTEN: Final = frozenset(
    {
        *("union", "diff", "inter", "set", "member", "card", "empty"),
        *("head", "tail", "length", "null", "elem", "mapLookup", "mapMember", "mapUpdate"),
    }
)
"""Built-in functions that are written as Python's own operations."""


def _bare(pattern: syntax.Pattern) -> syntax.Pattern:
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return pattern


def native_menu(evaluator: Evaluator, routine: Routine) -> NativeMenu | None:
    """What gives the menu of a process for the key of its arguments; None where it is not worth it, or impossible.

    The function raises ``NoMenu`` where there is none.
    """
    if routine.frame.size or routine.frame.timing is not None or len(routine.groups) != 1:
        return None
    fuser = NativeFuser(evaluator, routine)
    try:
        kinds = fuser.kinds()
        text = fuser.statements(kinds)
    except (Failure, Retreat):
        return None
    menu = fuser.fusion.compiled("key", text)
    return None if menu is None else _guarded(routine, menu, kinds)


def _guarded(routine: Routine, menu: Callable[[Any], Menu], kinds: tuple[Kind, ...]) -> NativeMenu:
    """*menu*, which is given up where it fails; ``NotImplemented`` for keys that it is not for."""
    evaluator = routine.evaluator
    fitting: set[tuple[type, ...]] = set()
    given = missed = 0

    def enter(key: Any) -> Any:
        nonlocal given, missed
        classes = tuple(map(type, key))
        if classes not in fitting:
            if not all(cls in _CLASSES[kind] for cls, kind in zip(classes, kinds, strict=True)):
                return NotImplemented
            fitting.add(classes)
        if evaluator.menus_open > MOST_OPEN:
            return None
        evaluator.menus_open += 1
        try:
            found = menu(key)
            given += 1
        except NoMenu:
            missed += 1
            if missed > 100 + given:
                routine.enter_native = None
            return None
        except _ERRORS:
            routine.enter_native = None
            return NotImplemented
        finally:
            evaluator.menus_open -= 1
        return found or None

    return enter
