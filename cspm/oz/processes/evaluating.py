"""How the evaluator treats what classes became: their processes, their sets and constants, and ``P || Q``.

Imported when a script has classes; the rules below then join those of the language.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from cspcheck.cspm.evaluator.core import DELAYED, PROCESSES, VALUES, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.alphabets import Alphabets
from cspcheck.cspm.oz.processes.meaning import DataPart
from cspcheck.cspm.oz.processes.nodes import CarrierSet, ClassExpression, ClassProcess, ConstantValue, given_name
from cspcheck.cspm.oz.values.carriers import TooLarge, Unbounded
from cspcheck.cspm.oz.values.conversion import Conversion
from cspcheck.cspm.oz.values.enumeration import enumeration, membership
from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator as TermEvaluator
from cspcheck.cspm.oz.values.terms import free_variables, show_term
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.construction import hide, prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import ChannelHead, Head
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import Range, Set, set_of
from cspcheck.cspm.values.thunks import Code, Env


def _conversion(evaluator: Evaluator, node: ClassExpression, frame: Frame) -> Conversion:
    """Conversion of the values of the types that *node* knows."""
    names = evaluator.names
    symbols = {given_name(names.symbol(name).name): names.symbol(name) for name in node.datatypes}

    def heads(datatype: str) -> list[Head]:
        declaration = symbols[datatype].declaration
        assert isinstance(declaration, syntax.DatatypeDeclaration)
        return [frame.unit.head(names.symbol(constructor)) for constructor in declaration.constructors]

    return Conversion(node.context.specification, heads)


# --- sets and constants ----------------------------------------------------------------------------------------------


class WideSet(Set):
    """A set that is infinite or too large: it can be asked what is in it, not gone through.

    *refusal* says why it cannot.
    """

    __slots__ = ("_contains", "_refusal", "_term")

    def __init__(self, term: core.Term, contains: Callable[[Any], bool], refusal: Callable[[], Failure]) -> None:
        self._term = term
        self._contains = contains
        self._refusal = refusal

    def contains(self, value: Any) -> bool:
        """Whether *value* is in the set."""
        return self._contains(value)

    def is_finite(self) -> bool:
        """No, or not in this life."""
        return False

    def finite(self) -> Any:
        """Refused, with the reading that would help."""
        raise self._refusal()

    def describe(self) -> str:
        """The set as the text notation writes it."""
        return show_term(self._term)


@VALUES(CarrierSet)
@DELAYED(CarrierSet)
def _carrier_set(evaluator: Evaluator, node: CarrierSet, frame: Frame) -> Code:
    kept: list[Set] = []

    def find(env: Env) -> Set:
        if not kept:
            kept.append(_carried(node, _conversion(evaluator, node, frame)))
        return kept[0]

    return find


def _carried(node: CarrierSet, conversion: Conversion) -> Set:
    terms = node.context.evaluator(node.owner)
    scope = FrameScope()
    ways = [enumeration(terms, carrier, scope) for carrier in node.carriers]
    for way in ways:
        terms.readings.use(way.readings)
    endless = [carrier for carrier, way in zip(node.carriers, ways, strict=True) if not way.bounded]
    if endless:
        test = _converted_member(terms, endless[0], conversion, node.element)
        return WideSet(endless[0], test, lambda: Unbounded(endless[0]))
    first = node.carriers[0]
    if len(ways) == 1 and not ways[0].readings and isinstance(first, core.Apply) and first.operator == "range":
        low, high = (terms.value(operand) for operand in first.operands)
        return Range(low, high)
    try:
        values = [value for way in ways for value in way.code(scope.frame())]
    except TooLarge as large:
        # Whoever does not go through it, such as a proof, has no reason to complain.
        diagnostic = large.diagnostic
        test = _converted_member(terms, first, conversion, node.element)
        return WideSet(first, test, lambda: Failure(diagnostic, is_limit=True))
    if isinstance(node.element, core.IntType):
        numbers = sorted(set(values))
        if numbers and numbers[-1] - numbers[0] == len(numbers) - 1:
            return Range(numbers[0], numbers[-1])
        return set_of(numbers)
    return set_of([conversion.to_cspm(value, node.element) for value in values])


def _converted_member(
    terms: TermEvaluator, carrier: core.Term, conversion: Conversion, element: core.Type
) -> Callable[[Any], bool]:
    scope = FrameScope()
    test = membership(terms, carrier, scope)
    return lambda value: test(scope.frame(), conversion.from_cspm(value, element))


@VALUES(ConstantValue)
@DELAYED(ConstantValue)
def _constant_value(evaluator: Evaluator, node: ConstantValue, frame: Frame) -> Code:
    def find(env: Env) -> Any:
        value = node.context.evaluator(node.owner).constants[node.name]
        return _conversion(evaluator, node, frame).to_cspm(value, node.type)

    return find


# --- the process of a class ------------------------------------------------------------------------------------------


class _Events:
    """The events of a class's channels as its data part sees them."""

    def __init__(self, channels: dict[str, tuple[core.Channel, ChannelHead]], conversion: Conversion) -> None:
        self._channels = channels
        self._conversion = conversion
        self._values: dict[str, Sequence[Sequence[Any]] | None] = {}

    def event(self, channel: str, values: tuple[Any, ...]) -> int | None:
        """The number of an event; None if a value is outside what the channel carries."""
        declared, head = self._channels[channel]
        to_cspm = self._conversion.to_cspm
        fields = tuple([to_cspm(v, p.type) for v, p in zip(values, declared.parameters, strict=True)])
        if not fields:
            return int(head.value.number)
        try:
            return head.complete(fields).number
        except Failure:
            return None

    def values(self, channel: str) -> Sequence[Sequence[Any]] | None:
        """What each field carries; None if that is infinite for one."""
        if channel not in self._values:
            declared, head = self._channels[channel]
            found: list[list[Any]] | None = []
            for parameter, domain in zip(declared.parameters, head.domains, strict=True):
                if not domain.is_finite():
                    found = None
                    break
                assert found is not None
                found.append([self._conversion.from_cspm(value, parameter.type) for value in domain.elements()])
            self._values[channel] = found
        return self._values[channel]

    def undeclared(
        self, channel: str, terms: TermEvaluator, narrower: Mapping[str, Sequence[core.Term]] | None = None
    ) -> EventSet:
        """The events of a channel with a value outside what the class itself declares.

        Args:
            channel: its name.
            terms: evaluates the sets.
            narrower: further sets, by parameter, that its values lie in.
        """
        scope = FrameScope()
        declared, _ = self._channels[channel]
        carried = self.values(channel)
        if carried is None:
            return EventSet()  # nobody can list what is outside
        chosen = []
        for parameter, values in zip(declared.parameters, carried, strict=True):
            carriers = [parameter.carrier, *(narrower or {}).get(parameter.name, ())]
            tests = [membership(terms, carrier, scope) for carrier in carriers]
            chosen.append([value for value in values if all(inside(scope.frame(), value) for inside in tests)])
        if all(len(some) == len(values) for some, values in zip(chosen, carried, strict=True)):
            return EventSet()
        found = [self.event(channel, fields) for fields in product(*chosen)]
        return self.all([channel]) - EventSet.of([number for number in found if number is not None])

    def all(self, channels: Sequence[str]) -> EventSet:
        """All events of some channels.

        Raises:
            Unbounded: one of them has infinitely many.
        """
        ranges = []
        for name in channels:
            declared, head = self._channels[name]
            ranges.append(_range_of(head, declared))
        return EventSet(ranges)


def _range_of(head: ChannelHead, channel: core.Channel | None = None) -> tuple[int, int]:
    if head.declared.size is None and channel is not None:
        for parameter, domain in zip(channel.parameters, head.domains, strict=True):
            if not domain.is_finite():
                raise Unbounded(parameter.carrier, parameter.name, parameter.span)
    try:
        numbers = head.channels.table.completions(head.declared, ())
    except OverflowError:
        from cspcheck.cspm.values.dots import completions

        completions(head.value)  # tells what is infinite
        raise
    return numbers.start, numbers.stop


@VALUES(ClassProcess)
@PROCESSES(ClassProcess)
def _class_process(evaluator: Evaluator, node: ClassProcess, frame: Frame) -> Callable[[Env], Process]:
    mains = [evaluator.process(main, frame) for main in node.mains]

    def build(env: Env) -> Process:
        return Composition(evaluator, node, frame).process([main(env) for main in mains])

    return build


class Composition:
    """Puts the process of a class together from its CSP parts and its data part."""

    def __init__(self, evaluator: Evaluator, node: ClassProcess, frame: Frame) -> None:
        self.node = node
        names = evaluator.names
        symbols = {name.parts[0]: names.symbol(name) for name in node.channels}
        heads: dict[str, tuple[core.Channel, ChannelHead]] = {}
        for name, symbol in symbols.items():
            head = frame.unit.head(symbol)
            assert isinstance(head, ChannelHead)
            channel = node.model.channels[name]
            fields = tuple([channel.parameters[position] for position in node.kept[name]])
            heads[name] = (replace(channel, parameters=fields), head)
        self.events = _Events(heads, _conversion(evaluator, node, frame))
        self.clocks = evaluator.channels.table.clocks
        alphabets = Alphabets(names)
        by_symbol = {symbol: name for name, symbol in symbols.items()}
        self.mentioned = [
            [by_symbol[symbol] for symbol in symbols.values() if symbol in alphabets.of(main)] for main in node.mains
        ]
        self.terminates = any(alphabets.mentions_skip(main) for main in node.mains)
        self.done = frame.unit.head(names.symbol(node.done)).value.number

    def process(self, mains: Sequence[Process]) -> Process:
        """The class with its methods visible."""
        model = self.node.model
        operations = list(model.operations)
        control = self._control(mains)
        if self.node.context.control:
            return self._control_view(control)
        if not operations:
            return control if control is not None else process.STOP
        in_main = {name for names in self.mentioned for name in names}
        shared = [name for name in operations if name in in_main]
        data = DataPart(
            self.node.context.evaluator(model.name),
            model,
            self.events,
            angelic=self.node.context.angelic,
        )
        self.node.context.parts[self.node.owner] = data
        if control is None:
            return data.initial()
        synchronised = self.events.all(shared)
        if self.terminates:
            data.done = self.done
        return self._beside(control, data.initial(), synchronised)

    def _control_view(self, control: Process | None) -> Process:
        """The CSP parts without the data; what only the data part does can happen at any time."""
        free = self.free()
        if control is None:
            return process.Run(free) if free else process.STOP
        if not free:
            return control
        anything: Process = process.Run(free)
        if self.terminates:
            anything = process.Interrupt(anything, prefix(self.done, process.SKIP))
        return self._beside(control, anything, EventSet())

    def _beside(self, control: Process, data: Process, synchronised: EventSet) -> Process:
        """The CSP part beside the data part, which terminates when that does."""
        if not self.terminates:
            return process.Fused(process.Parallel(synchronised, (control, data), self.clocks))
        done = EventSet.of([self.done])
        ending = process.Sequential(control, prefix(self.done, process.SKIP))
        return process.Fused(hide(process.Parallel(synchronised | done, (ending, data), self.clocks), done))

    def _control(self, mains: Sequence[Process]) -> Process | None:
        """The CSP parts side by side, on the events that they have in common."""
        whole: Process | None = None
        known: set[str] = set()
        for part, mentioned in zip(mains, self.mentioned, strict=True):
            if whole is None:
                whole = part
            else:
                common = [name for name in mentioned if name in known]
                whole = process.Parallel(self.events.all(common), (whole, part), self.clocks)
            known.update(mentioned)
        foreign = self.foreign()
        # A partner that has terminated already refuses them for ever, and lets the rest terminate.
        return process.Parallel(foreign, (whole, process.SKIP)) if whole is not None and foreign else whole

    def foreign(self) -> EventSet:
        """The events that the CSP parts mention and that are none of the class's own.

        A channel carries what any of its classes declares; where there is a schema, the data part sees to that. In
        the control view there is none: what the schema declares for the fields that are left is told here.
        """
        in_main = {name for names in self.mentioned for name in names}
        terms = self.node.context.evaluator(self.node.model.name)
        found = EventSet()
        for name in in_main if self.node.context.control else in_main & set(self.node.wider):
            found = found | self.events.undeclared(name, terms, self._declared_sets(name))
        return found

    def free(self) -> EventSet:
        """The events that in the control view only the data part knows, and which can happen at any time."""
        in_main = {name for names in self.mentioned for name in names}
        terms = self.node.context.evaluator(self.node.model.name)
        found = EventSet()
        for name in self.node.model.operations:
            if name not in in_main:
                outside = self.events.undeclared(name, terms, self._declared_sets(name))
                found = found | (self.events.all([name]) - outside)
        return found

    def _declared_sets(self, name: str) -> dict[str, list[core.Term]]:
        """The sets that the schemas of an operation declare for its parameters, as far as they do not depend on data.

        An effect behind a guard says nothing here: outside its sets the operation is not refused, it diverges.
        """
        operation = self.node.model.operations.get(name)
        found: dict[str, list[core.Term]] = {}
        if operation is None:
            return found
        for term in operation.effect if operation.form == "com" else operation.guard:
            if isinstance(term, core.Apply) and term.operator == "in":
                value, carrier = term.operands
                known = all(role == "constant" for _, role in free_variables(carrier))
                if isinstance(value, core.Variable) and value.role in ("input", "output", "simple") and known:
                    found.setdefault(value.name, []).append(carrier)
        return found


# --- joining classes -------------------------------------------------------------------------------------------------


@VALUES(syntax.ClassParallel)
@PROCESSES(syntax.ClassParallel)
def _class_parallel(evaluator: Evaluator, node: syntax.ClassParallel, frame: Frame) -> Callable[[Env], Process]:
    left, right = evaluator.process(node.left, frame), evaluator.process(node.right, frame)
    common = shared_channels(evaluator.names, node)

    def join(env: Env) -> Process:
        shared = EventSet([_range_of(_channel(frame, symbol)) for symbol in common])
        return process.Parallel(shared, (left(env), right(env)), evaluator.channels.table.clocks)

    return join


def shared_channels(names: Names, node: syntax.ClassParallel) -> frozenset[Symbol]:
    """The channels on which the operands of ``||`` meet."""
    alphabets = Alphabets(names)
    return alphabets.of(node.left) & alphabets.of(node.right)


def _channel(frame: Frame, symbol: Symbol) -> ChannelHead:
    head = frame.unit.head(symbol)
    assert isinstance(head, ChannelHead)
    return head
