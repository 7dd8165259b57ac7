"""External choice: the alternatives of a process, what is offered for each, and what comes after it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cspcheck.codegen import messages
from cspcheck.codegen.design.expressions import OR, TERNARY, ExpressionTranslator, bracketed, constant, flattened
from cspcheck.codegen.design.naming import snake, unique
from cspcheck.codegen.design.pieces import (
    DEEPEST,
    RESERVED,
    WIDTH,
    ChannelUse,
    ChoiceBranch,
    InternalChoice,
    Method,
    OfferedEvent,
    Plain,
    StateMethod,
    TextLines,
    alternative,
    both,
    is_simple,
    mentioned,
    unwrapped,
)
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax


class Choices:
    """Translates the choices of one task.

    Args:
        expressions: for the values.
        uses: how the task uses a channel, by the channel's name.
        internal_choice: what becomes of ``|~|``.
    """

    def __init__(
        self,
        expressions: ExpressionTranslator,
        uses: Callable[[str], ChannelUse],
        internal_choice: InternalChoice,
        plain: set[str],
    ) -> None:
        self.expressions = expressions
        self.names = expressions.names
        self.reserved: set[str] = set(RESERVED)
        """Names that states cannot have."""
        self.timed: frozenset[syntax.Declaration] = frozenset()
        """Definitions in Timed sections: time passes between their events, which only their machines show."""
        self.owner: Symbol | None = None
        """The module in which the definitions stand: None for the script itself."""
        self.states: dict[Symbol, StateMethod] = {}
        self.methods: dict[str, Method] = {}
        self.ports: dict[str, str] = {}
        """The attribute of the task for each channel that it uses."""
        self.bare_means_any = False
        """Whether a channel alone stands for all of its events."""
        self.perform, self.select = "perform", "select"
        """The methods of the task that wait for one event, and for one of several."""
        self._uses = uses
        self._internal_choice = internal_choice
        self._plain = plain
        self._loop: Symbol | None = None
        self._parameters: list[str] = []
        self._todo: list[Symbol] = []
        self._state_names: dict[Symbol, str] = {}
        self._out = TextLines()

    def _process(self, node: syntax.Expr, *, tail: bool) -> None:
        """The statements of a process: what comes behind a choice."""
        raise NotImplementedError

    def _branches(
        self, node: syntax.Expr, guard: str | None, depth: int, restrictions: dict[Symbol, syntax.Expr] | None = None
    ) -> Iterator[ChoiceBranch]:
        """The alternatives of an external choice; variables that they need before it are assigned."""
        node = syntax.bare(node)
        if depth > DEEPEST:
            raise self.expressions.refused(node, "a choice that names itself before any event")
        match node:
            case syntax.Prefix():
                yield ChoiceBranch(guard, node, dict(self.expressions.scope.names), restrictions or {})
            case syntax.ProcessBinary(operator="[]"):
                yield from self._branches(node.left, guard, depth, restrictions)
                yield from self._branches(node.right, guard, depth, restrictions)
            case syntax.Guard():
                condition = both(guard, self.expressions.text(node.condition, OR))
                yield from self._branches(node.body, condition, depth, restrictions)
            case syntax.If():
                condition = self.expressions.text(node.condition, OR)
                yield from self._branches(node.then, both(guard, condition), depth, restrictions)
                otherwise = bracketed(self.expressions.negated(node.condition), OR)
                yield from self._branches(node.otherwise, both(guard, otherwise), depth, restrictions)
            case syntax.Replicated(operator="[]"):
                yield from self._replicated(node, guard, depth, restrictions)
            case syntax.Name() | syntax.Apply():
                yield from self._named_branches(node, guard, depth)
            case syntax.ProcessBinary(operator=";"):
                for branch in self._branches(node.left, guard, depth, restrictions):
                    branch.rest = (*branch.rest, node.right)
                    yield branch
            case syntax.ProcessBinary(operator="|~|"):
                raise self.expressions.refused(node, "an internal choice inside an external one")
            case _:
                raise self._refused(node)

    def _named_branches(
        self, node: syntax.Name | syntax.Apply, guard: str | None, depth: int
    ) -> Iterator[ChoiceBranch]:
        """The alternatives of a process that is called in a choice."""
        symbol, arguments = self._called(node)
        if symbol.kind is SymbolKind.BUILTIN:
            if symbol.name == "STOP":
                return
            raise self.expressions.refused(node, f"`{symbol.name}` as an alternative of a choice")
        declaration = symbol.declaration
        if isinstance(declaration, syntax.PatternDefinition):
            yield from self._branches(declaration.body, guard, depth + 1)
            return
        assert isinstance(declaration, syntax.FunctionDefinition)
        clause = declaration.clauses[0]
        if len(declaration.clauses) > 1 or len(clause.groups) > 1 or not all(map(is_simple, clause.groups[0])):
            raise self.expressions.refused(node, f"`{symbol.name}`, which has clauses, as an alternative of a choice")
        for pattern, argument in zip(clause.groups[0], arguments, strict=True):
            value = self.expressions.text(argument)
            name = self._parameter(pattern, self.expressions.scope.bind)
            if name not in ("_", value):
                self._out.add(f"{name} = {value}")
        yield from self._branches(clause.body, guard, depth + 1)

    def _replicated(
        self, node: syntax.Replicated, guard: str | None, depth: int, outer: dict[Symbol, syntax.Expr] | None
    ) -> Iterator[ChoiceBranch]:
        """``[] i:S @ c.i -> P(i)`` is ``c?i:S -> P(i)``: each variable must be a field of the event."""
        restrictions = dict(outer or {})
        for statement in node.statements:
            pattern = unwrapped(statement.pattern) if isinstance(statement, syntax.Generator) else None
            if not isinstance(statement, syntax.Generator) or not isinstance(pattern, syntax.NamePattern):
                raise self.expressions.refused(statement, "a replicated choice with conditions or patterns")
            restrictions[self.names.symbol(pattern)] = statement.source
        body = syntax.bare(node.body)
        if not isinstance(body, syntax.Prefix):
            raise self.expressions.refused(node, "a replicated choice whose body is no prefix")
        fields = [syntax.bare(part) for part in flattened(syntax.bare(body.channel))[1:]]
        fields += [syntax.bare(f.expression) for f in body.fields if f.expression is not None]
        mentioned = [self.names.symbol(f) for f in fields if isinstance(f, syntax.Name)]
        for symbol in restrictions:
            if mentioned.count(symbol) != 1:
                why = f"a replicated choice whose `{symbol.name}` is not a field of its events, once"
                raise self.expressions.refused(node, why)
        yield from self._branches(body, guard, depth, restrictions)

    def _choice(self, branches: list[ChoiceBranch], tail: bool) -> None:
        out = self._out
        if not branches:
            out.add("await self.stop()")
            if tail and self._loop is None:
                out.add("return None")
            return
        events = [self._event(branch) for branch in branches]
        if len(events) == 1 and branches[0].guard is None:
            event = events[0]
            out.add(f"{event.assignment()}await self.{self.perform}({event.offer})")
            self._after(branches[0], event, tail)
            return
        guarded = [
            event.offer if branch.guard is None else f"{event.offer} if {branch.guard} else None"
            for branch, event in zip(branches, events, strict=True)
        ]
        name = unique("choice", set(self.expressions.scope.names.values()))
        bodies = [
            self._apart(lambda branch=branch, event=event: self._taken(branch, event, name, tail))  # type: ignore[misc]
            for branch, event in zip(branches, events, strict=True)
        ]
        needed = any(body != bodies[0] for body in bodies) or any(f"{name}.values" in line for line in bodies[0])
        head = f"{name} = await self.{self.select}(" if needed else f"await self.{self.select}("
        line = f"{head}{', '.join(guarded)})"
        if len(line) + 4 * self._out.depth <= WIDTH:
            out.add(line)
        else:
            out.add(head, *[f"    {text}," for text in guarded], ")")
        self._alternatives(bodies, f"{name}.taken")

    def _taken(self, branch: ChoiceBranch, event: OfferedEvent, choice: str, tail: bool) -> None:
        self._out.add(*event.unpacked(choice))
        self._after(branch, event, tail)

    def _apart(self, write: Callable[[], None]) -> list[str]:
        """What is written by *write*, not added yet."""
        outer, self._out = self._out, TextLines()
        self._out.depth = 0
        try:
            write()
            return self._out.lines
        finally:
            self._out = outer

    def _alternatives(self, bodies: list[list[str]], number: str) -> None:
        """What to do for each number, from 0; neighbours that do the same stand together."""
        groups: list[tuple[list[int], list[str]]] = []
        for i, body in enumerate(bodies):
            if groups and groups[-1][1] == body:
                groups[-1][0].append(i)
            else:
                groups.append(([i], body))
        for position, (numbers, body) in enumerate(groups):
            if len(groups) == 1:
                self._out.add(*body)
                continue
            if position == len(groups) - 1 and not body:
                continue
            one = f"{number} == {numbers[0]}" if len(numbers) == 1 else f"{number} in {tuple(numbers)}"
            with self._out.block(alternative(one, position, len(groups))):
                self._out.add(*body)

    def _after(self, branch: ChoiceBranch, event: OfferedEvent, tail: bool) -> None:
        """What follows a prefix, with the variables that its event has brought."""
        if event.timed:
            self._out.add("self.released()")
        with self.expressions.inside() as scope:
            scope.names.clear()
            scope.names.update(event.names)
            self._process(branch.prefix.body, tail=tail and not branch.rest)
        for i, process in enumerate(branch.rest):
            with self.expressions.inside() as scope:
                scope.names.clear()
                scope.names.update(branch.names)
                self._process(process, tail=tail and i == len(branch.rest) - 1)

    def _event(self, branch: ChoiceBranch) -> OfferedEvent:
        """The offer of a prefix, and what becomes of the values that come with it."""
        prefix = branch.prefix
        head, *outputs = flattened(syntax.bare(prefix.channel))
        head = syntax.bare(head)
        if not isinstance(head, syntax.Name) or self.names.symbol(head).kind is not SymbolKind.CHANNEL:
            raise self.expressions.refused(head, f"`{head.span.text}`, which is no channel by its name")
        channel = self.channel_name(self.names.symbol(head))
        use = self._uses(channel)
        fields: list[str] = []
        targets: list[str] = []
        with self.expressions.inside() as scope:
            scope.names.clear()
            scope.names.update(branch.names)
            inner = scope.copy()
            wanted = mentioned(prefix.body, self.names)

            def bind(symbol: Symbol) -> str:
                return inner.bind(symbol) if symbol in wanted else "_"

            for part in outputs:
                self._output(part, branch, fields, targets, bind)
            for one in prefix.fields:
                if one.kind == "$":
                    raise self.expressions.refused(one, "a `$` field, an internal choice of the value")
                if one.expression is not None:
                    for part in flattened(syntax.bare(one.expression)):
                        self._output(part, branch, fields, targets, bind)
                else:
                    assert one.pattern is not None
                    self._input(one.pattern, one.restriction, fields, targets, bind)
        if not fields and self.bare_means_any:
            fields, targets = ["ANY"] * use.arity, ["_"] * use.arity
        if fields and prefix.fields and isinstance(prefix.fields[-1].pattern, syntax.Wildcard):
            # The last input takes all that is left.
            left = 0 if prefix.fields[-1].restriction is not None else use.arity - len(fields)
            fields += ["ANY"] * left
            targets += ["_"] * left
        if len(fields) != use.arity:
            what = " ".join(prefix.channel.span.text.split())
            why = f"`{what}...`, whose channel has {use.arity} fields and is given {len(fields)}"
            raise self.expressions.refused(prefix.channel, why)
        return OfferedEvent(self._offer(channel, use, fields), targets, inner.names, use.timed)

    def channel_name(self, symbol: Symbol) -> str:
        """How the events of a channel are called."""
        return symbol.name

    def _output(
        self,
        part: syntax.Expr,
        branch: ChoiceBranch,
        fields: list[str],
        targets: list[str],
        bind: Callable[[Symbol], str],
    ) -> None:
        name = syntax.bare(part)
        if isinstance(name, syntax.Name):
            symbol = self.names.symbol(name)
            if symbol in branch.restrictions:
                fields.append(f"one_of({self.expressions.text(branch.restrictions[symbol])})")
                targets.append(bind(symbol))
                return
        fields.append(self.expressions.text(part, TERNARY))
        targets.append("_")

    def _input(
        self,
        pattern: syntax.Pattern,
        restriction: syntax.Expr | None,
        fields: list[str],
        targets: list[str],
        bind: Callable[[Symbol], str],
    ) -> None:
        pattern = unwrapped(pattern)
        if restriction is None:
            field_text = "ANY"
        else:
            field_text = f"one_of({self.expressions.text(restriction)})"
        match pattern:
            case syntax.Wildcard():
                targets.append("_")
            case syntax.NamePattern():
                symbol = self.names.symbol(pattern)
                if symbol.kind is SymbolKind.VARIABLE:
                    targets.append(bind(symbol))
                elif symbol.kind is SymbolKind.CONSTRUCTOR and restriction is None:
                    name = syntax.Name(span=pattern.span, parts=pattern.parts)
                    self.names._record(name, symbol)
                    field_text = self.expressions.text(name)
                    targets.append("_")
                else:
                    raise self.expressions.refused(pattern, f"the pattern `{pattern.text}` in an input")
            case syntax.LiteralPattern() if restriction is None:
                field_text = constant(pattern)
                targets.append("_")
            case syntax.DotPattern() if restriction is None:
                self._input(pattern.left, None, fields, targets, bind)
                self._input(pattern.right, None, fields, targets, bind)
                return
            case _:
                raise self.expressions.refused(pattern, f"the pattern `{pattern.span.text}` in an input")
        fields.append(field_text)

    def _offer(self, channel: str, use: ChannelUse, fields: list[str]) -> str:
        """An offer as an expression."""
        port = self.ports.get(channel)
        if port is None:
            taken = {*RESERVED, *self.ports.values(), *self._state_names.values()}
            port = self.ports[channel] = unique(snake(channel), taken)
        open_fields = [f == "ANY" or f.startswith("one_of(") for f in fields]
        after = ["after=self.release"] if use.timed else []
        if use.own and channel not in self._plain:
            given = tuple(i for i, is_open in enumerate(open_fields) if not is_open)
            returned = tuple(i for i, is_open in enumerate(open_fields) if is_open)
            method = Method(channel, snake(channel), given, returned)
            if self.methods.setdefault(channel, method) != method:
                raise Plain(channel)
            return f"self.{port}.own({', '.join([f'self.methods.{method.name}', *fields, *after])})"
        if not fields and not after:
            return f"self.{port}.meet()"
        if not any(open_fields) and not after:
            return f"self.{port}.put({', '.join(fields)})"
        if all(f == "ANY" for f in fields) and not after:
            return f"self.{port}.get()"
        return f"self.{port}.offer({', '.join([*fields, *after])})"

    def _called(self, node: syntax.Name | syntax.Apply) -> tuple[Symbol, tuple[syntax.Expr, ...]]:
        """The definition that a process names, with its arguments."""
        function = syntax.bare(node.function) if isinstance(node, syntax.Apply) else node
        if isinstance(function, syntax.Name):
            symbol = self.names.symbol(function)
            known = symbol.kind in (SymbolKind.VALUE, SymbolKind.FUNCTION) and not symbol.is_local
            if symbol.declaration in self.timed:
                raise self.expressions.refused(node, f"`{symbol.name}`, a process in time,")
            if (known and symbol.owner is self.owner) or symbol.kind is SymbolKind.BUILTIN:
                return symbol, node.arguments if isinstance(node, syntax.Apply) else ()
        why = f"`{' '.join(node.span.text.split())}`, which is no process defined at the top of the script"
        raise self.expressions.refused(node, why)

    def _refused(self, node: syntax.Expr) -> ScriptError:
        operators = {
            syntax.Synchronised: "a parallel operator",
            syntax.AlphabetisedParallel: "an alphabetised parallel",
            syntax.LinkedParallel: "a linked parallel",
            syntax.Hide: "hiding",
            syntax.Rename: "renaming",
        }
        kind = operators.get(type(node))
        if kind is not None:
            return ScriptError(messages.dynamic("a task", kind, node.span))
        return self.expressions.refused(node)

    def _parameter(self, pattern: syntax.Pattern, bind: Callable[[Symbol], str]) -> str:
        pattern = unwrapped(pattern)
        if isinstance(pattern, syntax.NamePattern):
            symbol = self.names.symbol(pattern)
            if symbol.kind is SymbolKind.VARIABLE:
                return bind(symbol)
        return "_"
