"""Scripts with classes as plain CSPm, for FDR and for whoever wants to see what a class means.

The data part of a class becomes a process whose parameters are the state variables (Fischer and Wehrheim 1999): outputs
are chosen before an event, after-states behind it. Where CSPm has no short form for a predicate, it becomes a process
for each of its states, which are found by exploring the class. The process equations stay as they are written, beside
the data on the events of both; types, channels and constants become what their finite readings say. Names of members
are written with an underscore: ``Producer::make`` becomes ``Producer_make``.

Where there are assertions of CSPm, what they use is written, and whatever else CSPm has; a class that none of them uses
is left out. Assertions that only classes have are left out with a warning.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from itertools import count
from typing import Any, TypeVar

from cspcheck.cspm import prelude
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.evaluator.core import Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.oz import core, syntax as oz
from cspcheck.cspm.oz.processes import messages as messages
from cspcheck.cspm.oz.processes.classes import context_of
from cspcheck.cspm.oz.processes.context import ClassContext
from cspcheck.cspm.oz.processes.evaluating import Composition, shared_channels
from cspcheck.cspm.oz.processes.meaning import DataPart
from cspcheck.cspm.oz.processes.nodes import OBJECTS, CarrierSet, ClassModule, ClassProcess, ConstantValue, given_name
from cspcheck.cspm.oz.values.conversion import Conversion
from cspcheck.cspm.oz.writing.expressions import ExpressionWriter, Unwritable
from cspcheck.cspm.oz.writing.parametric import data_process
from cspcheck.cspm.oz.writing.reached import Reach, flat
from cspcheck.cspm.parsing.lexer import KEYWORDS
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.layout import names_kept
from cspcheck.cspm.printing.printer import print_assertion, print_expression, print_script
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.script import Assertion as ScriptAssertion, Script
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.tree import Declaration, Expr, Name, Node
from cspcheck.cspm.values.dots import Dotted
from cspcheck.cspm.values.order import in_order
from cspcheck.cspm.values.sets import Set
from cspcheck.cspm.values.values import Boolean, Map, Real, Sequence as Items

N = TypeVar("N", bound=Node)
_PRIME = "'"
_OF_CLASSES = (oz.Obligations, oz.DataRefinement, oz.Subtype)
"""Assertions about the data of classes, of which CSPm knows nothing."""


@dataclass(frozen=True, slots=True)
class Exported:
    """A script as plain CSPm, and what it lacks."""

    text: str
    warnings: tuple[Diagnostic, ...] = ()


def plain(script: Script, explore: Callable[[Process], str | None], *, title: str) -> Exported:
    """The script without classes.

    Args:
        script: a freshly loaded script.
        explore: visits all states of a process, and gives what it demands outside its finite readings, if anything.
        title: what the script is called, for the comment at the top.

    Raises:
        ScriptError: a class cannot be explored, or leaves its finite readings.
    """
    return _Export(script, explore).whole(title)


class _Export:
    def __init__(self, script: Script, explore: Callable[[Process], str | None]) -> None:
        self.script = script
        self.names = script.names
        self.explore = explore
        self.evaluator: Evaluator = script.evaluator
        self.frame: Frame = script.outermost
        self.reals: dict[Real, str] = {}
        self.top = {name for name, symbol in self.names.top_level.items() if symbol.kind is not SymbolKind.BUILTIN}
        self.made: dict[str, str] = {}
        self.taken = {*self.top, *prelude.BUILTINS, *prelude.TIMED_BUILTINS, *KEYWORDS}

    def whole(self, title: str) -> Exported:
        """The script, with a comment at the top."""
        kept: list[ScriptAssertion] = []
        dropped: list[ScriptAssertion] = []
        declarations = list(flat(self.script.tree.declarations))
        own = {id(d.assertion) for d in declarations if isinstance(d, syntax.AssertDeclaration)}
        for assertion in self.script.assertions:
            if id(assertion.node) not in own:
                continue  # stays in its Timed section
            (dropped if isinstance(_claim(assertion.node), _OF_CLASSES) else kept).append(assertion)
        reach = Reach(declarations, self.names)
        wanted = reach.of(assertion.node for assertion in kept)
        chunks: list[str] = []
        owners: list[str] = []
        left: list[str] = []
        for declaration in declarations:
            if kept and id(declaration) not in wanted and reach.of_classes(declaration):
                left += [declaration.name] if isinstance(declaration, ClassModule) else []
                continue
            owners += [declaration.name] if isinstance(declaration, ClassModule) else []
            chunks.extend(self._declaration(declaration))
        assertions = [self._assertion(assertion) for assertion in kept]
        assertions += [f"-- only classes have this: assert {assertion.text}" for assertion in dropped]
        head = [f"-- {title} as plain CSPm, written by `cspcheck cspm`."]
        context = None if self.script.classes is None else self._context()
        used = () if context is None else context.used([None, *owners])
        head += [f"-- Finite readings: {'; '.join(used)}."] if used else []
        if context is not None and context.control:
            head.append("-- The control view: data dropped.")
        if left:
            head.append(f"-- Left out, since no assertion uses it: {', '.join(left)}.")
        if self.reals:
            values = " | ".join(self.reals.values())
            chunks.insert(0, f"datatype {self._flat('Real_')} = {values}")
        text = names_kept("\n\n".join(["\n".join(head), *chunks, *assertions])) + "\n"
        return Exported(text, tuple([messages.assertion_left_out(a.text, a.node.span) for a in dropped]))

    def _context(self) -> ClassContext:
        found = context_of(self.script)
        assert found is not None
        return found

    # --- declarations --------------------------------------------------------------------------------------------

    def _declaration(self, declaration: Declaration) -> Iterator[str]:
        match declaration:
            case ClassModule():
                yield from self._class(declaration)
            case syntax.AssertDeclaration():
                return  # at the end, with what is expected of them
            case syntax.DatatypeDeclaration(constructors=()):
                return  # of a given set without a reading
            case syntax.DatatypeDeclaration(name=name) if name.endswith(OBJECTS):
                yield self._printed(replace(declaration, name=self._flat(name)))
            case syntax.PatternDefinition(body=CarrierSet() as body, pattern=syntax.NamePattern() as pattern):
                found = self._value(body)
                if isinstance(found, Set) and found.is_finite():
                    yield f"{pattern.text} = {self._literal(found)}"
            case _:
                yield self._printed(declaration)

    def _printed(self, node: Declaration | Expr) -> str:
        return print_expression(self._plain(node))

    def _assertion(self, assertion: Any) -> str:
        expected = "" if assertion.expected is None else f"-- expect: {assertion.expected}\n"
        return f"{expected}assert {print_assertion(self._plain(assertion.node))}"

    # --- trees ---------------------------------------------------------------------------------------------------

    def _plain(self, node: N) -> N:
        """The tree without what only classes bring, members called by their plain names."""
        found: Any = node
        match node:
            case Name():
                symbol = self.names.find(node)
                found = replace(node, parts=(self._called(symbol, node.text),))
            case syntax.NamePattern():
                symbol = self.names.find(node)
                found = replace(node, parts=(self._called(symbol, node.text),))
            case syntax.NameDeclaration():
                symbol = self.names.find(node)
                found = replace(node, name=self._called(symbol, node.name))
            case syntax.FunctionDefinition():
                symbol = self.names.find(node)
                clauses = tuple([self._plain(clause) for clause in node.clauses])
                found = replace(node, name=self._called(symbol, node.name), clauses=clauses)
            case syntax.BooleanAssertion():
                found = self._plain(_of_process(node))
            case CarrierSet() | ConstantValue():
                found = _parsed(self._literal(self._value(node)))
            case syntax.ImportDeclaration():
                current = [prelude.DEPRECATED_IMPORTS.get(name.name, name.name) for name in node.names]
                names = [replace(name, name=new) for name, new in zip(node.names, current, strict=True)]
                distinct = tuple([name for i, name in enumerate(names) if name.name not in current[:i]])
                found = replace(node, names=distinct)
            case syntax.ClassParallel():
                shared = [self._channel_name(symbol) for symbol in shared_channels(self.names, node)]
                events = syntax.Productions(
                    span=node.span, items=tuple([Name(span=node.span, parts=(name,)) for name in sorted(shared)])
                )
                left, right = self._plain(node.left), self._plain(node.right)
                joined = syntax.Synchronised(span=node.span, operator="[|", left=left, events=events, right=right)
                found = syntax.Paren(span=node.span, inner=joined)
            case _:
                changes: dict[str, Any] = {}
                for f in fields(node):
                    if f.name != "span":
                        value = getattr(node, f.name)
                        new = self._plain_value(value)
                        if new is not value:
                            changes[f.name] = new
                found = replace(node, **changes) if changes else node
        result: N = found
        return result

    def _plain_value(self, value: Any) -> Any:
        if isinstance(value, Node):
            return self._plain(value)
        if isinstance(value, tuple):
            # FDR knows no reduction by symmetry; the verdict does not depend on it.
            kept = [v for v in value if not (isinstance(v, syntax.AssertOption) and v.kind == "symmetry reduce")]
            items = tuple([self._plain_value(item) for item in kept])
            same = len(items) == len(value) and all(a is b for a, b in zip(items, value, strict=True))
            return value if same else items
        return value

    def _called(self, symbol: Symbol | None, text: str) -> str:
        """What a name is called outside of classes."""
        if symbol is None or symbol.is_local:
            return text
        if symbol.kind is SymbolKind.BUILTIN:
            return prelude.DEPRECATED_IMPORTS.get(text, text)
        path: list[str] = []
        owner = symbol.owner
        while owner is not None:
            declaration = owner.declaration
            if not isinstance(declaration, syntax.ModuleDeclaration):
                break
            if not isinstance(declaration, ClassModule) and "%" not in declaration.name:
                return text
            path.insert(0, declaration.name.partition("%")[0])
            owner = owner.owner
        return self._flat("::".join([*path, symbol.name])) if path or OBJECTS in text else text

    def _flat(self, path: str) -> str:
        """What a member is called at the top of a script: with underscores, and unlike all that is there already."""
        found = self.made.get(path)
        if found is None:
            found = re.sub(r"::|[%.]", "_", path).replace("(", "").replace(")", "")
            while found in self.top or found in self.made.values():
                found = f"{found.rstrip(_PRIME)}_{_PRIME * found.count(_PRIME)}"
            self.made[path] = found
        return found

    def _channel_name(self, symbol: Symbol) -> str:
        return self._called(symbol, symbol.name)

    # --- values --------------------------------------------------------------------------------------------------

    def _value(self, node: CarrierSet | ConstantValue) -> Any:
        return self.evaluator.run(lambda: self.evaluator.value(node, self.frame)(()), node.span)

    def _literal(self, value: Any) -> str:
        """A value as every tool reads it."""
        match value:
            case Boolean():
                return "true" if value.truth else "false"
            case int():
                return str(value) if value >= 0 else f"({value})"
            case Real():
                return self.reals.setdefault(value, self._flat(_real_name(value)))
            case tuple():
                return f"({', '.join(map(self._literal, value))})"
            case Items():
                return f"<{', '.join(map(self._literal, value.values()))}>"
            case Map():
                pairs = [f"{self._literal(k)} => {self._literal(value.entries[k])}" for k in in_order(value.entries)]
                return f"(| {', '.join(pairs)} |)"
            case Dotted():
                return ".".join([value.head.name, *map(self._literal, value.fields)])
            case Set():
                if not value.is_finite():
                    value.finite()  # tells what is infinite
                items = value.elements()
                if len(items) > 2 and all(type(i) is int for i in items) and items[-1] - items[0] == len(items) - 1:
                    return f"{{{self._literal(items[0])}..{self._literal(items[-1])}}}"
                return "{" + ", ".join(map(self._literal, items)) + "}"
        return str(value)

    def _event(self, number: int) -> str:
        head, values = self.evaluator.channels.event(number).parts
        return ".".join([self._channel(head.name), *map(self._literal, values)])

    def _channel(self, name: str) -> str:
        return self._flat(name) if "::" in name else name

    def _events(self, events: EventSet, *more: str) -> str:
        """A set of events, and more that have names: whole channels by their names where that is possible."""
        found: list[str] = []
        rest = events
        for channel in self.script.events.channels:
            if channel.size:
                whole = EventSet(((channel.base, channel.base + channel.size),))
                if whole <= rest:
                    found.append(self._channel(channel.name))
                    rest = rest - whole
        found += [*[self._event(number) for number in rest], *more]
        return "{| " + ", ".join(found) + " |}" if found else "{}"

    # --- classes -------------------------------------------------------------------------------------------------

    def _class(self, module: ClassModule) -> Iterator[str]:
        name = module.name
        visible = Name(span=module.span, parts=(name, self._context().visible[name]))
        node = _process_of(module)
        composition = Composition(self.evaluator, node, self.frame)
        for declaration in (*module.private, *module.exported):
            match declaration:
                case syntax.ChannelDeclaration() if declaration.names[0].name == node.done.text:
                    if composition.terminates:
                        yield self._printed(declaration)
                case syntax.ModuleDeclaration():
                    for equation in declaration.exported:
                        yield self._printed(equation)
                case syntax.PatternDefinition(pattern=syntax.NamePattern(parts=parts)) if parts == visible.parts[1:]:
                    body = self._composed(name, visible, node, composition)
                    if isinstance(declaration.body, syntax.Hide):
                        hidden = self._plain(declaration.body.events)
                        body = [*body[:-1], f"({body[-1]}) \\ {print_expression(hidden)}"]
                    yield from body[:-1]
                    yield f"{self._flat(visible.text)} = {body[-1]}"
                case _:
                    yield self._printed(declaration)

    def _composed(self, name: str, visible: Name, node: ClassProcess, composition: Composition) -> list[str]:
        """The processes that a class is made of; the last is the expression for the whole."""
        context = node.context
        mains = [print_expression(self._plain(main)) for main in node.mains]
        control = ""
        known: set[str] = set()
        for main, mentioned in zip(mains, composition.mentioned, strict=True):
            if control:
                common = self._events(composition.events.all([c for c in mentioned if c in known]))
                control = f"({control} [| {common} |] {main})"
            else:
                control = main
            known.update(mentioned)
        foreign = composition.foreign()
        if control and foreign:
            control = f"({control} [| {self._events(foreign)} |] SKIP)"
        operations = list(node.model.operations)
        chunks: list[str] = []
        done = self._flat(f"{name}::{node.done.text}")
        if context.control:
            free = composition.free()
            if not control:
                return [f"RUN({self._events(free)})" if free else "STOP"]
            if not free:
                return [control]
            data, shared = f"RUN({self._events(free)})", EventSet()
            if composition.terminates:
                data = f"({data} /\\ {done} -> SKIP)"
        elif not operations:
            return [control or "STOP"]
        else:
            term = self.script.process(visible.text)
            left = self.explore(term)
            if left is not None:
                raise ScriptError(messages.export_leaves(name, left, node.model.span))
            part = context.parts[name]
            try:
                before, data = self._with_parameters(name, part, node)
            except Unwritable:
                before, data = self._data(name, part), self._flat(f"{name}::data")
            chunks += before
            if not control:
                return [*chunks, data]
            shared = composition.events.all([o for o in operations if o in known])
        if not composition.terminates:
            return [*chunks, f"{control} [| {self._events(shared)} |] {data}"]
        both = self._events(shared, done)
        return [*chunks, f"(({control} ; {done} -> SKIP) [| {both} |] {data}) \\ {{{done}}}"]

    def _with_parameters(self, name: str, part: DataPart, node: ClassProcess) -> tuple[list[str], str]:
        """The data part as a process with parameters, and its start.

        Raises:
            Untranslatable: CSPm has no short form for it.
        """
        if self.top & prelude.BUILTINS:
            raise Unwritable("functions that the script calls otherwise")
        context = self._context()
        symbols = sorted(self.names.top_level, key=lambda symbol: symbol.endswith(OBJECTS))
        datatypes = {given_name(symbol): symbol for symbol in symbols}

        def heads(datatype: str) -> list[Any]:
            symbol = self.names.top_level.get(datatypes.get(datatype, ""))
            if symbol is None or not isinstance(symbol.declaration, syntax.DatatypeDeclaration):
                raise Unwritable(datatype)
            constructors = symbol.declaration.constructors
            return [self.frame.unit.head(self.names.symbol(constructor)) for constructor in constructors]

        conversion = Conversion(context.specification, heads)

        def literal(value: Any, type_: core.Type) -> str:
            return self._literal(conversion.to_cspm(value, type_))

        def channel(operation: str) -> str:
            of = node.model.channels[operation]
            symbol = self.names.symbol(next(c for c in node.channels if c.text == of.name))
            return self._called(symbol, symbol.name)

        def fresh(kind: str) -> str:
            paths = (f"{name}::{kind}{number or ''}" for number in count())
            return self._flat(next(path for path in paths if path not in self.made))

        expressions = ExpressionWriter(context.evaluator(name), literal, self.taken, fresh)
        done = self._flat(f"{name}::{node.done.text}") if part.done is not None else None
        variables = part.variables

        def values(state: Any) -> list[str]:
            return [expressions.value(value, v.type) for value, v in zip(state, variables, strict=True)]

        title = f"the data of {name}"
        lines, start = data_process(self._flat(f"{name}::data"), part, channel, done, expressions, values)
        return [print_script(parse(Source(title, line))).rstrip() for line in lines], start

    def _data(self, name: str, part: DataPart) -> list[str]:
        """A process for each state of the data that the class gets into, and the choice of the first."""
        numbers = {state: number for number, state in enumerate(part.visited)}
        lines: list[str] = []
        for state, number in numbers.items():
            lines.append(f"-- {part.text(state)}")
            called = self._flat(f"{name}::{number}")
            lines.append(f"{called} = {self._term(name, part.term(state), numbers)}")
        first = self._choice(name, part.initial(), numbers)
        return [f"{self._flat(f'{name}::data')} = {first}", "\n".join(lines)]

    def _term(self, name: str, term: Process, numbers: dict[Any, int]) -> str:
        match term:
            case process.ExternalChoice():
                return " [] ".join(f"({self._term(name, operand, numbers)})" for operand in term.operands)
            case process.InternalChoice():
                return " |~| ".join(f"({self._term(name, operand, numbers)})" for operand in term.operands)
            case process.Prefix():
                found = [f"{self._event(e)} -> {self._choice(name, after, numbers)}" for e, after in term.branches]
                return " [] ".join(found) if len(found) == 1 else " [] ".join(f"({branch})" for branch in found)
            case process.Diverge():
                return "DIV"
            case process.Skip():
                return "SKIP"
        return "STOP"

    def _choice(self, name: str, term: Process, numbers: dict[Any, int]) -> str:
        if isinstance(term, Reference):
            key: Any = term.key
            # What the class never gets into, or what lies beyond its readings, is reached by no event that it performs.
            return self._flat(f"{name}::{numbers[key[1]]}") if key[1] in numbers else "STOP"
        if isinstance(term, process.InternalChoice):
            return "(" + " |~| ".join(self._choice(name, operand, numbers) for operand in term.operands) + ")"
        return self._term(name, term, numbers)


def _claim(node: syntax.Assertion) -> syntax.Assertion:
    while isinstance(node, syntax.NotAssertion):
        node = node.inner
    return node


def _of_process(node: syntax.BooleanAssertion) -> syntax.Property:
    """A Boolean assertion, which FDR does not read, as one about a process that diverges where it is false."""
    span = node.span
    then, otherwise = Name(span=span, parts=("STOP",)), Name(span=span, parts=("DIV",))
    chosen = syntax.If(span=span, condition=node.condition, then=then, otherwise=otherwise)
    return syntax.Property(span=span, process=syntax.Paren(span=span, inner=chosen), kind="divergence free")


def _process_of(module: ClassModule) -> ClassProcess:
    for declaration in module.exported:
        if isinstance(declaration, syntax.PatternDefinition):
            body = declaration.body
            while isinstance(body, syntax.Hide):
                body = body.process
            if isinstance(body, ClassProcess):
                return body
    raise AssertionError(module.name)


def _parsed(text: str) -> Expr:
    from cspcheck.cspm.parsing.reading import parse_expression

    return parse_expression(text)


def _real_name(value: Real) -> str:
    text = str(value)
    for sign, word in (("-", "minus_"), (".", "_point_"), ("/", "_over_")):
        text = text.replace(sign, word)
    return f"real_{text}"
