"""The definitions of a script, and of each instance of its modules, as things that exist once.

A unit holds what its declarations stand for. Those of modules without parameters live in the unit around the
module; each instance of a module is a unit of its own, with channels and datatypes of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.frames import Frame, Timing
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.patterns import compile_pattern
from cspcheck.cspm.evaluator.routines import Routine
from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import ChannelHead, Constructor, Head
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import Set, field_sets, type_set
from cspcheck.cspm.values.symbolic_sets import DatatypeSet
from cspcheck.cspm.values.thunks import Env, Thunk
from cspcheck.cspm.values.values import Function

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator

MOST_INSTANCES = 100_000
"""A script makes at most so many module instances."""


class Unit:
    """What the declarations of a script or of one module instance stand for, by symbol.

    Named values are a ``Routine`` with a thunk, functions a ``Function``, channels and constructors their ``Head``,
    types a ``Set`` (or a thunk of one), instances a ``Unit``, variables of patterns a ``Thunk``.
    """

    def __init__(self, evaluator: Evaluator, parent: Unit | None) -> None:
        self.evaluator = evaluator
        self.parent = parent
        self.things: dict[Symbol, Any] = {}

    def thing(self, symbol: Symbol) -> Any:
        """What *symbol* stands for in this unit, or in the units around it."""
        if symbol.member is not None:
            assert symbol.instance is not None
            instance: Unit = self.thing(symbol.instance)
            return instance.thing(symbol.member)
        unit: Unit | None = self
        while unit is not None:
            found = unit.things.get(symbol)
            if found is not None:
                return found
            unit = unit.parent
        raise AssertionError(f"{symbol!r} has not been declared")

    def head(self, symbol: Symbol) -> Head:
        """The channel or constructor that *symbol* stands for."""
        head: Head = self.thing(symbol)
        return head

    def home(self, module: Symbol) -> Unit:
        """The unit whose definitions a module can see."""
        if module.instance is not None:
            found: Unit = self.thing(module.instance)
            return found
        unit: Unit = self
        while module not in unit.things and unit.parent is not None:
            unit = unit.parent
        return unit


class UnitDeclarations:
    """Declares a script's units, in the order of the text, those of module instances last."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.evaluator = evaluator
        self.channels: list[ChannelHead] = []
        """All channels, in the order in which they are numbered."""
        self.prints: list[tuple[syntax.PrintDeclaration, Frame]] = []
        self.assertions: list[tuple[syntax.AssertDeclaration, Frame]] = []
        self._clocks: list[ChannelHead] = []
        self._clock_symbols = evaluator.names.clocks
        self._types: list[DatatypeSet] = []
        self._instances: deque[tuple[Unit, Unit, syntax.InstanceDeclaration, str]] = deque()
        self._made = 0

    def script(self, script: syntax.Script) -> Unit:
        """Declare everything; nothing is evaluated yet, channels and types included."""
        top = Unit(self.evaluator, None)
        self._declare(script.declarations, Frame.outermost(top), "")
        while self._instances:
            self._instantiate(*self._instances.popleft())
        return top

    def settle(self) -> list[Failure]:
        """Evaluate the fields of all channels and datatypes; the channels' events get their numbers.

        What is wrong with one stops only those who need it: the failures are returned. ``Events`` needs all channels.
        """
        broken = self.evaluator.channels.broken
        for head in self.channels:
            broken += _attempt(partial(getattr, head, "declared"), head.span)
        found = list(broken)
        self.evaluator.channels.table.clocks = EventSet.of(clock.value.number for clock in self._clocks)
        for datatype in self._types:
            found += _attempt(partial(getattr, datatype, "branches"), None)
        return found

    def _declare(self, declarations: Sequence[syntax.Declaration], frame: Frame, prefix: str) -> None:
        names = self.evaluator.names
        things = frame.unit.things
        for declaration in declarations:
            match declaration:
                case syntax.FunctionDefinition():
                    routine = function_routine(self.evaluator, declaration, frame, prefix)
                    things[names.symbol(declaration)] = Function(routine, ())
                case syntax.PatternDefinition():
                    declare_pattern(self.evaluator, declaration, frame, things, prefix)
                case syntax.ChannelDeclaration():
                    for name in declaration.names:
                        head = self._channel(name, declaration.fields, frame, prefix)
                        self.channels.append(head)
                        things[names.symbol(name)] = head
                        if self._is_clock(name, declaration, prefix):
                            self._clocks.append(head)
                case syntax.DatatypeDeclaration():
                    self._datatype(declaration, frame, prefix)
                case syntax.NametypeDeclaration():
                    things[names.symbol(declaration)] = self._nametype(declaration, frame)
                case syntax.ModuleDeclaration():
                    symbol = names.symbol(declaration)
                    things[symbol] = symbol
                    if not declaration.parameters:
                        inside = f"{prefix}{declaration.name.partition('%')[0]}::"
                        self._declare(declaration.private, frame, inside)
                        self._declare(declaration.exported, frame, inside)
                case syntax.InstanceDeclaration():
                    symbol = names.symbol(declaration)
                    assert symbol.module is not None
                    unit = Unit(self.evaluator, None)
                    things[symbol] = unit
                    self._instances.append((unit, frame.unit, declaration, f"{prefix}{declaration.name}::"))
                case syntax.IncludeDeclaration():
                    self._declare(declaration.declarations, frame, prefix)
                case syntax.TimedDeclaration():
                    inner = frame.with_timing(timing(self.evaluator, declaration, frame))
                    self._declare(declaration.declarations, inner, prefix)
                case syntax.PrintDeclaration():
                    self.prints.append((declaration, frame))
                case syntax.AssertDeclaration():
                    self.assertions.append((declaration, frame))

    def _instantiate(self, unit: Unit, around: Unit, declaration: syntax.InstanceDeclaration, prefix: str) -> None:
        self._made += 1
        if self._made > MOST_INSTANCES:
            raise Failure(messages.too_many_instances(MOST_INSTANCES, declaration.span), is_limit=True)
        symbol = self.evaluator.names.symbol(declaration)
        assert symbol.module is not None
        module = symbol.module.base.declaration
        assert isinstance(module, syntax.ModuleDeclaration)
        unit.parent = around.home(symbol.module)
        outside = Frame.outermost(around)
        for pattern, argument in zip(module.parameters, declaration.arguments, strict=True):
            value = self.evaluator.thunk(argument, outside)(())
            bind(self.evaluator, pattern, value, Frame.outermost(unit), unit.things)
        frame = Frame.outermost(unit)
        self._declare(module.private, frame, prefix)
        self._declare(module.exported, frame, prefix)

    def _is_clock(self, name: syntax.NameDeclaration, declaration: syntax.ChannelDeclaration, prefix: str) -> bool:
        """Whether a channel is the clock of a Timed section, or would be that of one at the top of the script."""
        at_the_top = name.name == "tock" and declaration.fields is None and not prefix
        return at_the_top or self.evaluator.names.symbol(name) in self._clock_symbols

    def _channel(
        self, name: syntax.NameDeclaration, fields: syntax.Expr | None, frame: Frame, prefix: str
    ) -> ChannelHead:
        evaluate = None if fields is None else self._fields(fields, frame, name.name)
        return ChannelHead(prefix + name.name, name.span, evaluate, self.evaluator.channels)

    def _fields(self, fields: syntax.Expr, frame: Frame, name: str) -> Callable[[], tuple[Set, ...]]:
        def evaluate() -> tuple[Set, ...]:
            value = self.evaluator.value(fields, frame)(())
            try:
                return field_sets(value, name)
            except Failure as failure:
                failure.at(fields.span)
                raise

        return evaluate

    def _datatype(self, declaration: syntax.DatatypeDeclaration, frame: Frame, prefix: str) -> None:
        names = self.evaluator.names
        things = frame.unit.things
        rank = len(self._types)
        constructors = declaration.constructors
        if declaration.subtype:

            def branches() -> tuple[tuple[Constructor, tuple[Set, ...]], ...]:
                return tuple([self._restricted(c, frame) for c in constructors])

        else:
            for i, c in enumerate(constructors):
                evaluate = None if c.fields is None else self._fields(c.fields, frame, c.name)
                things[names.symbol(c)] = Constructor(prefix + c.name, c.span, evaluate, (rank, i))

            def branches() -> tuple[tuple[Constructor, tuple[Set, ...]], ...]:
                return tuple([(head, head.domains) for head in heads()])

        def heads() -> tuple[Constructor, ...]:
            found: list[Constructor] = [frame.unit.thing(names.symbol(c)) for c in constructors]
            return tuple(found)

        name = prefix + declaration.name
        found = DatatypeSet(name, heads, branches, is_subtype=declaration.subtype)
        self._types.append(found)
        things[names.symbol(declaration)] = found

    def _restricted(self, c: syntax.Constructor, frame: Frame) -> tuple[Constructor, tuple[Set, ...]]:
        """The fields of a constructor in a subtype; those that are not mentioned are as in the datatype."""
        head: Constructor = frame.unit.thing(self.evaluator.names.symbol(c))
        if c.fields is None:
            return head, head.domains
        given = self._fields(c.fields, frame, c.name)()
        if len(given) > head.arity:
            raise Failure(messages.subtype_fields(c.name, head.arity, len(given), c.span))
        return head, (*given, *head.domains[len(given) :])

    def _nametype(self, declaration: syntax.NametypeDeclaration, frame: Frame) -> Thunk:
        def evaluate(env: Env) -> Set:
            value = self.evaluator.value(declaration.body, frame)(env)
            try:
                return type_set(value, declaration.name)
            except Failure as failure:
                failure.at(declaration.body.span)
                raise

        return Thunk(evaluate, ())


def _attempt(work: Callable[[], Any], span: Span | None) -> list[Failure]:
    """The failure of *work*, if it fails."""
    try:
        work()
    except Failure as failure:
        return [failure.at(span)]
    except RecursionError as deep:
        deep.__traceback__ = None
        return [Failure(messages.too_deep(span), is_limit=True)]
    return []


def timing(evaluator: Evaluator, section: syntax.TimedDeclaration, frame: Frame) -> Timing:
    """The clock of a Timed section."""
    tock = evaluator.names.tock(section)
    duration = section.duration
    if duration is None:
        return Timing(frame.unit, tock, None, 0, frozenset())
    mentions = mentioned(duration, evaluator.names, evaluator.free_variables)
    return Timing(frame.unit, tock, lambda env: evaluator.value(duration, frame)(env), frame.size, mentions)


def function_routine(
    evaluator: Evaluator, definition: syntax.FunctionDefinition, frame: Frame, prefix: str = ""
) -> Routine:
    """The routine of a function."""
    symbol = evaluator.names.symbol(definition)
    groups = tuple([len(group) for group in definition.clauses[0].groups])
    clauses = [(tuple([p for group in c.groups for p in group]), c.body) for c in definition.clauses]
    sort = evaluator.sorts.of_result(symbol, len(groups))
    strict = evaluator.strictness.of(symbol)
    return Routine(evaluator, prefix + definition.name, definition.span, frame, groups, clauses, sort, strict)


def declare_pattern(
    evaluator: Evaluator,
    definition: syntax.PatternDefinition,
    frame: Frame,
    things: dict[Symbol, Any],
    prefix: str = "",
) -> None:
    """Declare a named value, or the variables of a larger pattern, at the top of a unit."""
    pattern = definition.pattern
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    symbol = evaluator.names.find(pattern) if isinstance(pattern, syntax.NamePattern) else None
    if symbol is not None and symbol.kind is SymbolKind.VALUE:
        routine = named_routine(evaluator, symbol, definition, frame, prefix)
        routine.thunk = routine.delay(())
        things[symbol] = routine
        return
    value = Thunk(lambda env: evaluator.value(definition.body, frame)(env), ())
    bind(evaluator, pattern, value, frame, things)


def named_routine(
    evaluator: Evaluator,
    symbol: Symbol,
    definition: syntax.PatternDefinition,
    frame: Frame,
    prefix: str = "",
) -> Routine:
    """The routine of a plain name."""
    sort = evaluator.sorts.of_name(symbol)
    name = prefix + symbol.name if definition.called is None else definition.called
    return Routine(evaluator, name, definition.span, frame, (), [((), definition.body)], sort)


def bind(evaluator: Evaluator, pattern: syntax.Pattern, value: Any, frame: Frame, things: dict[Symbol, Any]) -> None:
    """Declare the variables of *pattern* as thunks that match *value* when one of them is first needed."""
    start = frame.size
    matched: list[Env] = []

    def match() -> Env:
        if not matched:
            matcher, _ = compile_pattern(evaluator, pattern, frame, evaluated=False)
            found = matcher((), value)
            if found is None:
                from cspcheck.cspm.values.thunks import force

                raise Failure(messages.no_match(force(value), pattern.span.text, pattern.span))
            matched.append(found)
        return matched[0]

    def part(i: int) -> Thunk:
        def take(env: Env) -> Any:
            item = match()[i]
            return item.force() if type(item) is Thunk else item

        return Thunk(take, ())

    _, inner = compile_pattern(evaluator, pattern, frame, evaluated=False)
    for node in variables(pattern):
        symbol = evaluator.names.find(node)
        if symbol is not None and symbol in inner.slots and inner.slots[symbol] >= start:
            things[symbol] = part(inner.slots[symbol] - start)
