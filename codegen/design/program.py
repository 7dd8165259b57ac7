"""The design of a program: everything that its text is made of, and nothing that is not in it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

from cspcheck.codegen import messages, runtime
from cspcheck.codegen.design.class_tasks import ClassProcesses, main_of, operation_arguments
from cspcheck.codegen.design.classes import ClassDesigner, OperationDesign
from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.expressions import ExpressionTranslator
from cspcheck.codegen.design.functions import Functions
from cspcheck.codegen.design.machine import OperationalSemantics, machine
from cspcheck.codegen.design.model import ChannelDesign, ClassPart, Design, Instance, MethodDesign, TaskDesign
from cspcheck.codegen.design.naming import camel, snake, unique
from cspcheck.codegen.design.network import Group, Leaf, Network, TaskAlphabets, Wire, network
from cspcheck.codegen.design.pieces import RESERVED, ChannelUse, InternalChoice, Method, NeedsStates, Plain, StateMethod
from cspcheck.codegen.design.tables import TableWriter
from cspcheck.codegen.design.tasks import TaskTranslator
from cspcheck.codegen.design.timing import TaskTiming, timings, tock
from cspcheck.codegen.quoting import literals
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.nodes import CarrierSet
from cspcheck.cspm.process.events import Channel
from cspcheck.cspm.process.terms import Reference
from cspcheck.cspm.script import Script
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import types

TOCK = "tock"
"""The channel that counts time."""
RESERVED_MODULES = sys.stdlib_module_names | {"channels", "data_types", "functions", "main", "runtime", "tests"}
"""Names of other modules: a module of the program that is called like one of them would hide it, or be it."""


def design(
    script: Script,
    process: str,
    internal_choice: InternalChoice = "refuse",
    semantics: OperationalSemantics | None = None,
) -> Design:
    """The program for a process of a script.

    Args:
        script: the script.
        process: the text of the process.
        internal_choice: what becomes of ``|~|``.
        semantics: what processes do. With it, a task whose process cannot be translated as it is written becomes the
            table of its states; without it, such a process is refused.

    Raises:
        ScriptError: something in it is not generated; the diagnostic says what and why.
    """
    return _Designer(script, process, internal_choice, semantics).design()


class _Designer:
    def __init__(
        self, script: Script, process: str, internal_choice: InternalChoice, semantics: OperationalSemantics | None
    ) -> None:
        self.semantics = semantics
        self.script = script
        self.process = process
        self.internal_choice = internal_choice
        self.data = DataDesigner(script)
        self.constants: dict[object, str] = {}
        self._functions = Functions(script, self.data)
        self._alphabets = TaskAlphabets(script.events)
        self.rows_of: dict[int, int] = {}
        """The row in which each leaf begins whose task is a table."""
        self.classes = None if script.classes is None else ClassDesigner(script, self.data)
        self.timed = frozenset(_timed(script.tree.declarations))
        if script.classes is not None and script.classes.control:
            what = "classes in the control view, which drops their data"
            raise ScriptError(messages.not_generated(what, None, "leave out `view control`"))

    def design(self) -> Design:
        term = self.script.process(self.process)
        found = network(
            term, self.script.events, self._class_channels, None if self.semantics is None else self._alphabet
        )
        names = [leaf.name for leaf in found.leaves]
        channels = [self._channel(wire, names) for wire in found.wires]
        groups: dict[Symbol, list[int]] = {}
        starts = [self._definition(leaf) for leaf in found.leaves]
        for number, (symbol, _) in enumerate(starts):
            groups.setdefault(symbol, []).append(number)
        settings = timings(self.script.tree)
        tasks: list[TaskDesign] = []
        variables: set[str] = set()
        dead: dict[str, ChannelDesign] = {}
        for symbol, numbers in groups.items():
            timing, modules = settings.get(symbol.name, TaskTiming()), {t.module for t in tasks}
            task = self._made(symbol, numbers, found, timing, modules, [starts[number][1] for number in numbers])
            for number in numbers:
                leaf = found.leaves[number]
                variable = unique(snake(leaf.name.replace("#", "_").strip(")").replace("(", "_")), variables)
                variables.add(variable)
                if task.table is None:
                    where = f"the arguments of `{leaf.name}`"
                    arguments = [self.data.literal(value, where) for value in starts[number][1]]
                else:
                    arguments = [str(self.rows_of[number])]
                plugged = {
                    attribute: (self._plugged(leaf, channel, dead), usual)
                    for channel, (attribute, usual) in task.ports.items()
                }
                ports = {attribute: constant for attribute, (constant, usual) in plugged.items() if constant != usual}
                task.instances.append(Instance(leaf.name, variable, arguments, ports))
            tasks.append(task)
        channels += dead.values()
        return Design(
            self.script.source.name,
            self.process,
            self.data,
            channels,
            tasks,
            self._functions.texts,
            self._functions.expressions.from_data,
            tock(self.script.tree) if any(task.clocked for task in tasks) else None,
        )

    def _made(
        self,
        symbol: Symbol,
        numbers: list[int],
        found: Network,
        timing: TaskTiming,
        modules: set[str],
        arguments: list[tuple[Any, ...]],
    ) -> TaskDesign:
        """The task of a definition: as it is written if that can be, else as the table of its states."""
        try:
            for number in numbers:
                if number in found.tables:
                    self._alphabets.of(found.leaves[number].reference, found.leaves[number].name)
            model = self.classes.find(symbol.name) if self.classes is not None else None
            if model is not None:
                made = self._class_task(symbol, model, numbers, found, timing, modules)
            else:
                made = self._task(symbol, numbers, found, timing, modules)
            for values in arguments:
                for value in values:
                    self.data.literal(value, f"the arguments of `{symbol.name}`")
            self._functions.define()
            return made
        except ScriptError as refused:
            if self.semantics is None:
                raise
            self._functions.forget_pending()
            return self._table(symbol, numbers, found, timing, modules, refused)

    def _alphabet(self, reference: Reference) -> tuple[int, ...]:
        """The events of the machine of a process."""
        assert self.semantics is not None
        return machine([reference], self.semantics, self.script.events).events()

    def _table(
        self,
        symbol: Symbol,
        numbers: list[int],
        found: Network,
        timing: TaskTiming,
        modules: set[str],
        refused: ScriptError,
    ) -> TaskDesign:
        """The task of a definition as the table of its states.

        Raises:
            ScriptError: *refused*, where that was for a decision that nobody makes; or the table is too large.
        """
        assert self.semantics is not None
        leaves = [found.leaves[number] for number in numbers]
        made = machine([leaf.reference for leaf in leaves], self.semantics, self.script.events)
        of_class = self.classes is not None and self.classes.find(symbol.name) is not None
        if made.chooses() and self.internal_choice == "refuse" and not of_class:
            (first, *_) = refused.diagnostics
            span = symbol.span or leaves[0].reference.span
            raise refused if first.code == "CSP804" or span is None else ScriptError(messages.internal_choice(span))
        self.rows_of.update(zip(numbers, made.starts, strict=True))
        ports: dict[str, str] = {}

        def port(channel: str) -> str:
            if channel not in ports:
                taken = {*RESERVED, *ports.values(), "clocked", "start", "state", "timed", "unit"}
                ports[channel] = unique(snake(channel.rpartition("::")[2]), taken)
            return ports[channel]

        def own(channel: str) -> bool:
            if channel == TOCK:
                return False
            wires = [(number, found.leaves[number].ports.get(channel)) for number in numbers]
            return all(wire is not None and _alone(wire, number) for number, wire in wires)

        writer = TableWriter(
            self.data, self.script.events, port, own, lambda channel: snake(channel.replace("::", "_"))
        )
        rows = writer.rows(made)
        module = snake(symbol.name)
        (first, *_) = refused.diagnostics
        declaration = symbol.declaration
        return TaskDesign(
            symbol.name,
            unique(f"{module}_process" if module in RESERVED_MODULES else module, modules),
            unique(f"{camel(symbol.name)}Task", set(runtime.__all__)),
            declaration.span.text if declaration is not None else symbol.name,
            [],
            None,
            [],
            "",
            [self._method(method, leaves[0]) for method in writer.methods.values()],
            {channel: (attribute, self._usual(channel)) for channel, attribute in ports.items()},
            timing,
            table=rows,
            why=first.message,
            clocked=tuple(attribute for channel, attribute in ports.items() if channel == TOCK),
        )

    def _plugged(self, leaf: Leaf, channel: str, dead: dict[str, ChannelDesign]) -> str:
        """The constant that a task has for a channel; one of its own if the task never comes to use it."""
        wire = leaf.ports.get(channel)
        if wire is not None:
            return self.constants[id(wire)]
        found = dead.get(channel)
        if found is None:
            constant = unique(snake(channel.rpartition("::")[2]), {*self.constants.values(), "channels"})
            self.constants[id(dead), len(dead)] = constant
            declared = self._declared(channel)
            where = f"the fields of `{channel}`"
            types = [self.data.field_type(domain, None, where) for domain in declared.domains]
            found = dead[channel] = ChannelDesign(channel, constant, types, "[]", [], False)
        found.never.append(leaf.name)
        return found.constant

    # --- channels --------------------------------------------------------------------------------------------

    def _channel(self, wire: Wire, names: list[str]) -> ChannelDesign:
        channel = wire.channel
        written = self._field_names(channel.name)
        if len(written) != channel.arity:
            written = [None] * channel.arity
        constant_name = wire.name.rpartition("::")[2]
        constant = unique(snake(constant_name), set(self.constants.values()))
        self.constants[id(wire)] = constant
        field_types = [
            self.data.field_type(domain, name, f"the fields of `{channel.name}`")
            for domain, name in zip(channel.domains, written, strict=True)
        ]
        joined = {leaf for group in wire.all_groups() for leaf in group}
        never = [names[leaf] for leaf in wire.tasks if leaf not in joined]
        if wire.by_event is None:
            texts = self._groups(wire.groups, names)
            parties = f"[{', '.join(texts)}]"
            if len(parties) > 100:
                parties = "\n        ".join(["[", *[f"{text}," for text in texts]]) + "\n    ]"
        else:
            rows = []
            for event, groups in sorted(wire.by_event.items()):
                values = self.script.events.parts(event)[1]
                key = ", ".join(self.data.literal(v, f"the events of `{channel.name}`") for v in values)
                # Lists, which are of one type whatever their length.
                lists = [f"[{text.strip('(),')}]" for text in self._groups(groups, names)]
                rows.append(f"({key},): [{', '.join(lists)}],")
            inside = "\n        ".join(rows)
            parties = f"{{\n        {inside}\n    }}"
        members = tuple(names[leaf] for leaf in sorted(joined))
        return ChannelDesign(
            channel.name, constant, field_types, parties, never, wire.hidden, wire.inner, members, wire.rank
        )

    def _groups(self, groups: frozenset[Group], names: list[str]) -> list[str]:
        texts = []
        for group in sorted(groups, key=sorted):
            texts.append(f"({literals([names[leaf] for leaf in sorted(group)])})")
        return texts

    def _field_names(self, channel: str) -> list[str | None]:
        """How the declaration of a channel calls the types of its fields."""
        owner, _, own = channel.rpartition("::")
        module = self.script.names.top_level.get(f"{owner}%")
        scope = self.script.names.top_level if not owner else {} if module is None else module.members
        symbol = scope.get(own)
        declaration = symbol.declaration if symbol is not None else None
        node = declaration.fields if isinstance(declaration, syntax.ChannelDeclaration) else None
        found: list[str | None] = []
        while node is not None:
            left = node.left if isinstance(node, syntax.Dot) else node
            node = node.right if isinstance(node, syntax.Dot) else None
            left = syntax.bare(left)
            if self.classes is not None and isinstance(left, CarrierSet):
                found.append(self.classes.name_of(left.carriers[0]))
                continue
            is_name = isinstance(left, syntax.Name) and left.text not in ("Int", "Bool", "Char")
            found.append(left.text if isinstance(left, syntax.Name) and is_name else None)
        return found

    def _declared(self, name: str) -> Channel:
        """The channel of this name.

        Raises:
            ScriptError: there is none at the top of the script: it belongs to a module.
        """
        for channel in self.script.events.channels:
            if channel.name == name:
                return channel
        raise ScriptError(messages.not_generated(f"the channel `{name}` of a module", None))

    def _usual(self, channel: str) -> str | None:
        """The constant that a task takes for a channel unless it is given another."""
        own = snake(channel)
        return own if own in self.constants.values() else None

    # --- tasks -----------------------------------------------------------------------------------------------

    def _definition(self, leaf: Leaf) -> tuple[Symbol, tuple[Any, ...]]:
        """The definition that a leaf runs, with its arguments."""
        reference: Reference = leaf.reference
        key: Any = reference.key
        name = reference.text.partition("(")[0]
        owner = None if self.classes is None else self.classes.find(name)
        name = name if owner is None else owner.name
        symbol = self.script.names.top_level.get(name)
        if (
            symbol is None
            or symbol.kind not in (SymbolKind.VALUE, SymbolKind.FUNCTION)
            or not isinstance(key, tuple)
            or len(key) != 3
        ):
            raise ScriptError(messages.unnamed_task(reference.text, reference.span))
        return symbol, tuple(key[2])

    def _task(
        self, symbol: Symbol, numbers: list[int], found: Network, timing: TaskTiming, modules: set[str]
    ) -> TaskDesign:
        leaves = [found.leaves[number] for number in numbers]
        module = snake(symbol.name)
        module = unique(f"{module}_process" if module in RESERVED_MODULES else module, modules)
        if timing.at is not None and timing.at not in leaves[0].ports:
            raise ScriptError(
                messages.not_generated(
                    f"a period of `{symbol.name}` at `{timing.at}`, which is no event of it", symbol.span
                )
            )

        def uses(channel: str) -> ChannelUse:
            wires = [(number, found.leaves[number].ports.get(channel)) for number in numbers]
            own = all(wire is not None and _alone(wire, number) for number, wire in wires)
            declared = self._declared(channel)
            return ChannelUse(declared.arity, own, timing.at == channel)

        plain: set[str] = set()
        while True:
            expressions = ExpressionTranslator(self.script, self.data, self._functions.name)
            processes = TaskTranslator(expressions, uses, self.internal_choice, plain)
            processes.timed = self.timed
            try:
                loop, start = self._translate(processes, symbol)
                break
            except Plain as several:
                plain.add(several.channel)
        declaration = symbol.declaration
        methods = [self._method(method, leaves[0]) for method in processes.methods.values()]
        parameters = loop.parameters if loop is not None else self._parameters(processes, symbol)
        return TaskDesign(
            symbol.name,
            module,
            unique(f"{camel(symbol.name)}Task", set(runtime.__all__)),
            declaration.span.text if declaration is not None else symbol.name,
            parameters,
            loop,
            list(processes.states.values()),
            start,
            methods,
            {channel: (attribute, self._usual(channel)) for channel, attribute in processes.ports.items()},
            timing,
            from_data=expressions.from_data,
        )

    def _class_channels(self, text: str) -> list[str] | None:
        """The channels of the class whose process is called so."""
        model = None if self.classes is None else self.classes.find(text)
        if model is None:
            return None
        return [c.name if c.kind == "chan" else f"{model.name}::{c.name}" for c in model.channels.values()]

    def _class_task(
        self,
        symbol: Symbol,
        model: core.ClassModel,
        numbers: list[int],
        found: Network,
        timing: TaskTiming,
        modules: set[str],
    ) -> TaskDesign:
        assert self.classes is not None
        made = self.classes.design(model)
        declared = {channel.name: channel for channel in self.script.events.channels}
        expressions = ExpressionTranslator(self.script, self.data, self._functions.name)
        at = timing.at
        if at is not None and at in model.channels and model.channels[at].kind != "chan":
            at = f"{model.name}::{at}"

        def uses(channel: str) -> ChannelUse:
            return ChannelUse(declared[channel].arity, False, at == channel)

        processes = ClassProcesses(
            expressions, uses, self.internal_choice, {o.channel: o.attribute for o in made.operations}, model.name
        )
        main = main_of(self.script, model)
        unused = [o for o in made.operations if o.method is not None]
        if main is None:
            loop: StateMethod | None = processes.any_operation([o.attribute for o in unused])
            start = ""
        else:
            processes.owner = main.owner
            loop, start = self._translate(processes, main)
            unused = [o for o in unused if o.channel not in processes.used]
        if main is not None and unused:
            what = f"the operation `{unused[0].channel}`, which `main` does not mention: it can happen at any time"
            raise ScriptError(messages.not_generated(what, model.span, "let `main` say when it can happen"))
        methods: list[MethodDesign] = []
        rows: list[tuple[str, str]] = []
        for operation in made.operations:
            reads, method = self._reading_method(model, operation), self._class_method(model, operation)
            methods += [one for one in (reads, method) if one is not None]
            names = [None if one is None else one.name for one in (method, reads)]
            rows.append((operation.attribute, operation_arguments(operation, *names)))
        leaf = found.leaves[numbers[0]]
        ports = {o.channel: (o.attribute, self._usual_of(leaf, o.channel)) for o in made.operations}
        module = snake(symbol.name)
        module = unique(f"{module}_process" if module in RESERVED_MODULES else module, modules)
        text = model.span.text
        return TaskDesign(
            symbol.name,
            module,
            unique(f"{camel(symbol.name)}Task", set(runtime.__all__)),
            text,
            [],
            loop,
            list(processes.states.values()),
            start,
            methods,
            ports,
            timing,
            from_data=expressions.from_data,
            of_class=ClassPart(f"{camel(symbol.name)}Data", made, tuple(rows)),
        )

    def _usual_of(self, leaf: Leaf, channel: str) -> str | None:
        wire = leaf.ports.get(channel)
        return None if wire is None else self.constants[id(wire)]

    def _reading_method(self, model: core.ClassModel, operation: OperationDesign) -> MethodDesign | None:
        """The method that gives the inputs of an operation that the class performs by itself."""
        if not operation.own or not operation.kinds or "!" in operation.kinds or operation.method is None:
            return None
        name = f"read_{operation.attribute}"
        data = (("data", f"{camel(model.name)}Data"),)
        return MethodDesign(name, operation.channel, data, operation.parameters, "what comes in from outside")

    def _class_method(self, model: core.ClassModel, operation: OperationDesign) -> MethodDesign | None:
        """What is to be written for an operation: for a method of the class, and for what a predicate leaves open."""
        if not operation.own and not operation.gives:
            return None
        data = (("data", f"{camel(model.name)}Data"),)
        about = f"`{operation.text}`" if operation.text else None
        return MethodDesign(
            operation.attribute, operation.channel, (*data, *operation.parameters), operation.gives, about, True
        )

    def _parameters(self, processes: TaskTranslator, symbol: Symbol) -> list[tuple[str, str]]:
        state = processes.states[symbol]
        return [(name if name != "_" else f"value_{i}", note) for i, (name, note) in enumerate(state.parameters)]

    def _translate(self, processes: TaskTranslator, symbol: Symbol) -> tuple[StateMethod | None, str]:
        try:
            return processes.loop(symbol), ""
        except NeedsStates:
            processes._loop = None
            processes.methods.clear()
            processes.ports.clear()
            processes.as_states(symbol)
            return None, processes.state_name(symbol)

    def _method(self, method: Method, leaf: Leaf) -> MethodDesign:
        channel = leaf.ports[method.channel].channel
        written = self._field_names(method.channel)
        if len(written) != channel.arity:
            written = [None] * channel.arity
        where = f"the fields of `{method.channel}`"
        texts = [self.data.field_type(d, n, where) for d, n in zip(channel.domains, written, strict=True)]
        notes = self._field_annotations(method.channel, channel.arity)
        parameters = tuple((f"value_{i + 1}" if channel.arity > 1 else "value", notes[i]) for i in method.given)
        return MethodDesign(
            method.name, method.channel, parameters, tuple((texts[i], notes[i]) for i in method.returned)
        )

    def _field_annotations(self, channel: str, arity: int) -> list[str]:
        symbol = self.script.names.top_level.get(channel)
        if symbol is None or self.script.types is None:
            return ["Any"] * arity
        found: list[str] = []
        type_ = types.resolve(self.script.types.scheme(symbol).type)
        while isinstance(type_, types.Dotable):
            argument = types.resolve(type_.argument)
            while isinstance(argument, types.Dot):
                found.append(self.data.annotation(argument.left))
                argument = types.resolve(argument.right)
            found.append(self.data.annotation(argument))
            type_ = types.resolve(type_.result)
        return found if len(found) == arity else ["Any"] * arity


def _timed(declarations: tuple[syntax.Declaration, ...], inside: bool = False) -> Iterator[syntax.Declaration]:
    """The definitions in Timed sections, those of includes and modules with them."""
    for one in declarations:
        if isinstance(one, syntax.TimedDeclaration):
            yield from _timed(one.declarations, True)
        elif isinstance(one, syntax.IncludeDeclaration):
            yield from _timed(one.declarations, inside)
        elif isinstance(one, syntax.ModuleDeclaration):
            yield from _timed((*one.private, *one.exported), inside)
        elif inside:
            yield one


def _alone(wire: Wire, leaf: int) -> bool:
    """Whether a leaf performs the events of a channel alone."""
    groups = [group for group in wire.all_groups() if leaf in group]
    return bool(groups) and all(len(group) == 1 for group in groups)
