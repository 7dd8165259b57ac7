"""Processes as tasks: prefixes become events to wait for, choices selections, recursion loops or states.

A process that only ever goes on as itself becomes a loop, its parameters local variables. Otherwise each definition
that it can go on as becomes a method, a *state*, which says which state comes next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

from codegen import messages
from codegen.design.expressions import OR, TERNARY, Expressions, flattened
from codegen.design.naming import snake, unique
from cspm import syntax
from cspm.diagnostics import ScriptError
from cspm.names_symbols import Names, Symbol, SymbolKind

InternalChoice = Literal["refuse", "in-turn", "random"]
WIDTH = 112
"""Lines are so long at most, inside their method."""
DEEPEST = 40
"""Names nested deeper than this in a choice are taken for an unguarded recursion."""
RESERVED = frozenset(
    {"carrier", "begin", "choice", "decide", "follow", "methods", "missed", "name", "offset", "perform", "period"}
    | {"priority", "release", "released", "releases", "run", "select", "stop", "channels", "go", "state"}
)
"""Names that generated tasks use for themselves."""


class Lines:
    """Text in the making, line by line."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.depth = 0

    def add(self, *lines: str) -> None:
        """Add lines at the present depth."""
        self.lines.extend(f"{'    ' * self.depth}{line}" if line else "" for line in lines)

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Add a line and what stands below it, a step deeper."""
        self.add(head)
        self.depth += 1
        before = len(self.lines)
        yield
        if len(self.lines) == before:
            self.add("pass")
        self.depth -= 1


@dataclass
class Method:
    """What a task does when it performs an event alone: a method to be written by hand.

    ``given`` are the positions of the fields whose values it gets, ``returned`` those whose values it gives.
    """

    channel: str
    name: str
    given: tuple[int, ...]
    returned: tuple[int, ...]


@dataclass
class Branch:
    """An alternative of a choice: its guard (a text), its prefix, and the variables that are seen there.

    ``restrictions`` are the sets of replicated variables, ``rest`` what comes after the prefix has come to its end.
    """

    guard: str | None
    prefix: syntax.Prefix
    names: dict[Symbol, str]
    restrictions: dict[Symbol, syntax.Expr] = field(default_factory=dict)
    rest: tuple[syntax.Expr, ...] = ()


@dataclass
class State:
    """A definition as a method: its lines below the head."""

    name: str
    parameters: list[tuple[str, str]]
    text: str
    lines: list[str]


@dataclass(frozen=True)
class Use:
    """How a task uses a channel.

    ``own``: it performs the events alone. ``timed``: it waits for its next release first.
    """

    arity: int
    own: bool
    timed: bool


class NeedsStates(Exception):
    """A process goes on as another one, so it is no loop."""


class Plain(Exception):
    """A channel is used in several ways, so there is no one method for it."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel)
        self.channel = channel


class Processes:
    """Translates what one task does.

    Args:
        expressions: for the values.
        uses: how the task uses a channel, by the channel's name.
        internal_choice: what becomes of ``|~|``.
    """

    def __init__(
        self, expressions: Expressions, uses: Callable[[str], Use], internal_choice: InternalChoice, plain: set[str]
    ) -> None:
        self.expressions = expressions
        self.names = expressions.names
        self.reserved: set[str] = set(RESERVED)
        """Names that states cannot have."""
        self.owner: Symbol | None = None
        """The module in which the definitions stand: None for the script itself."""
        self.states: dict[Symbol, State] = {}
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
        self._out = Lines()

    # --- definitions -----------------------------------------------------------------------------------------

    def loop(self, symbol: Symbol) -> State:
        """The definition as a loop.

        Raises:
            NeedsStates: it goes on as something else.
            ScriptError: something has no translation.
        """
        self._loop = symbol
        state = self._define(symbol)
        self._loop = None
        return state

    def as_states(self, symbol: Symbol) -> None:
        """The definition, and all that it can go on as, as states."""
        self._refer(symbol)
        while self._todo:
            next_one = self._todo.pop(0)
            self.states[next_one] = self._define(next_one)

    def state_name(self, symbol: Symbol) -> str:
        """The method of a definition."""
        return self._state_names[symbol]

    def _refer(self, symbol: Symbol) -> str:
        if symbol not in self._state_names:
            taken = {*self._state_names.values(), *self.reserved, *self.ports.values()}
            self._state_names[symbol] = unique(snake(symbol.name), taken)
            self._todo.append(symbol)
        return self._state_names[symbol]

    def _define(self, symbol: Symbol) -> State:
        self._out = Lines()
        declaration = symbol.declaration
        name = symbol.name if self._loop is not None else self.state_name(symbol)
        match declaration:
            case syntax.PatternDefinition(pattern=syntax.NamePattern()):
                with self.expressions.inside():
                    self._process(declaration.body, tail=True)
                return State(name, [], declaration.span.text, self._out.lines)
            case syntax.FunctionDefinition():
                return self._define_function(symbol, declaration, name)
        raise self.expressions.refused(declaration or syntax.Node(span=symbol.span), f"`{symbol.name}`")  # type: ignore[arg-type]

    def _define_function(self, symbol: Symbol, declaration: syntax.FunctionDefinition, name: str) -> State:
        first = declaration.clauses[0]
        if len(first.groups) != 1:
            raise self.expressions.refused(declaration, f"the curried definition `{declaration.name}`")
        annotations = self._annotations(first.groups[0])
        if len(declaration.clauses) == 1 and all(_simple(p) for p in first.groups[0]):
            with self.expressions.inside() as scope:
                written = [self._parameter(p, scope.bind) for p in first.groups[0]]
                self._parameters = written
                self._process(first.body, tail=True)
            return State(name, list(zip(written, annotations, strict=True)), declaration.span.text, self._out.lines)
        written = [f"value_{i + 1}" for i in range(len(first.groups[0]))]
        self._parameters = written
        for i, clause in enumerate(declaration.clauses):
            with self.expressions.inside():
                conditions: list[str] = []
                bindings: list[str] = []
                for pattern, value in zip(clause.groups[0], written, strict=True):
                    self._match(pattern, value, conditions, bindings)
                last = not conditions
                head = "else:" if last and i else f"{'el' if i else ''}if {' and '.join(conditions) or 'True'}:"
                with self._out.block(head):
                    self._out.add(*bindings)
                    self._process(clause.body, tail=True)
                if last:
                    break
        else:
            with self._out.block("else:"):
                values = ", ".join(written)
                self._out.add(f'raise ValueError(f"no clause of {declaration.name} matches {{({values},)}}")')
        return State(name, list(zip(written, annotations, strict=True)), declaration.span.text, self._out.lines)

    def _annotations(self, patterns: Sequence[syntax.Pattern]) -> list[str]:
        types = self.expressions.script.types
        if types is None:
            return ["Any"] * len(patterns)
        found = []
        for pattern in patterns:
            text = self.expressions.data.annotation(types.type_of(pattern))
            for word in self.expressions.data.enums:
                if word in text:
                    self.expressions.from_data.add(word)
            if "Tagged" in text:
                self.expressions.from_runtime.add("Tagged")
            found.append(text)
        return found

    def _parameter(self, pattern: syntax.Pattern, bind: Callable[[Symbol], str]) -> str:
        pattern = _unwrapped(pattern)
        if isinstance(pattern, syntax.NamePattern):
            symbol = self.names.symbol(pattern)
            if symbol.kind is SymbolKind.VARIABLE:
                return bind(symbol)
        return "_"

    def _match(self, pattern: syntax.Pattern, value: str, conditions: list[str], bindings: list[str]) -> None:
        """The conditions under which a pattern matches a value, and the assignments that follow."""
        pattern = _unwrapped(pattern)
        expressions = self.expressions
        match pattern:
            case syntax.Wildcard():
                return
            case syntax.LiteralPattern():
                conditions.append(f"{value} == {pattern.value!r}")
                return
            case syntax.NamePattern():
                symbol = self.names.symbol(pattern)
                if symbol.kind is SymbolKind.VARIABLE:
                    bindings.append(f"{expressions.scope.bind(symbol)} = {value}")
                    return
                if symbol.kind is SymbolKind.CONSTRUCTOR:
                    name = syntax.Name(span=pattern.span, parts=pattern.parts)
                    self.names._record(name, symbol)
                    conditions.append(f"{value} == {expressions.text(name)}")
                    return
            case syntax.SequencePattern():
                conditions.append(f"len({value}) == {len(pattern.items)}" if pattern.items else f"not {value}")
                for i, item in enumerate(pattern.items):
                    self._match(item, f"{value}[{i}]", conditions, bindings)
                return
            case syntax.ConcatPattern(left=syntax.SequencePattern() as front):
                conditions.append(f"len({value}) >= {len(front.items)}")
                for i, item in enumerate(front.items):
                    self._match(item, f"{value}[{i}]", conditions, bindings)
                self._match(pattern.right, f"{value}[{len(front.items)}:]", conditions, bindings)
                return
            case syntax.TuplePattern():
                for i, item in enumerate(pattern.items):
                    self._match(item, f"{value}[{i}]", conditions, bindings)
                return
        raise expressions.refused(pattern, f"the pattern `{' '.join(pattern.span.text.split())}`")

    # --- processes -------------------------------------------------------------------------------------------

    def _process(self, node: syntax.Expr, *, tail: bool) -> None:
        """The statements of a process. With *tail*, nothing comes after it; otherwise it ends where it would SKIP."""
        out = self._out
        node = _bare(node)
        match node:
            case syntax.Name() | syntax.Apply():
                self._go_on(node, tail)
            case syntax.If():
                with out.block(f"if {self.expressions.text(node.condition)}:"), self.expressions.inside():
                    self._process(node.then, tail=tail)
                otherwise = self._apart(lambda: self._scoped(node.otherwise, tail))
                if otherwise:
                    with out.block("else:"):
                        out.add(*otherwise)
            case syntax.Let():
                self._let(node)
                self._process(node.body, tail=tail)
            case syntax.ProcessBinary(operator=";"):
                self._process(node.left, tail=False)
                self._process(node.right, tail=tail)
            case syntax.ProcessBinary(operator="|~|"):
                self._internal(node, tail)
            case syntax.Prefix() | syntax.Guard() | syntax.ProcessBinary(operator="[]") | syntax.Replicated():
                self._choice(list(self._branches(node, None, 0)), tail)
            case _:
                raise self._refused(node)

    def _scoped(self, node: syntax.Expr, tail: bool) -> None:
        with self.expressions.inside():
            self._process(node, tail=tail)

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

    def _go_on(self, node: syntax.Name | syntax.Apply, tail: bool) -> None:
        """``P``, ``P(x)``, ``STOP``, ``SKIP``."""
        symbol, arguments = self._called(node)
        out = self._out
        if symbol.kind is SymbolKind.BUILTIN:
            if symbol.name == "STOP":
                out.add("await self.stop()")
                if tail and self._loop is None:
                    out.add("return None")
            elif symbol.name == "SKIP":
                if tail:
                    out.add("return" if self._loop is not None else "return None")
            else:
                raise self.expressions.refused(node)
            return
        values = list(map(self.expressions.text, arguments))
        if self._loop is not None:
            if symbol is not self._loop or not tail:
                raise NeedsStates
            changed = [(p, v) for p, v in zip(self._parameters, values, strict=True) if p != v]
            if len(changed) == 1:
                out.add(f"{changed[0][0]} = {changed[0][1]}")
            elif changed:
                out.add(f"{', '.join(p for p, _ in changed)} = {', '.join(v for _, v in changed)}")
            return
        text = ", ".join([f"self.{self._refer(symbol)}", *values])
        if tail:
            out.add(f"return go({text})")
        else:
            out.add(f"await self.follow({text})")

    def _called(self, node: syntax.Name | syntax.Apply) -> tuple[Symbol, tuple[syntax.Expr, ...]]:
        """The definition that a process names, with its arguments."""
        function = _bare(node.function) if isinstance(node, syntax.Apply) else node
        if isinstance(function, syntax.Name):
            symbol = self.names.symbol(function)
            known = symbol.kind in (SymbolKind.VALUE, SymbolKind.FUNCTION) and not symbol.is_local
            if (known and symbol.owner is self.owner) or symbol.kind is SymbolKind.BUILTIN:
                return symbol, node.arguments if isinstance(node, syntax.Apply) else ()
        why = f"`{' '.join(node.span.text.split())}`, which is no process defined at the top of the script"
        raise self.expressions.refused(node, why)

    def _let(self, node: syntax.Let) -> None:
        for declaration in node.declarations:
            if not isinstance(declaration, syntax.PatternDefinition):
                raise self.expressions.refused(declaration, "a definition of a function or process inside a `let`")
            value = self.expressions.text(declaration.body)
            target = self.expressions.target(declaration.pattern)
            self._out.add(f"{target.strip('()')} = {value}")

    def _internal(self, node: syntax.Expr, tail: bool) -> None:
        if self._internal_choice == "refuse":
            raise ScriptError(messages.internal_choice(node.span))
        ways: list[syntax.Expr] = []
        todo = [node]
        while todo:
            one = _bare(todo.pop(0))
            if isinstance(one, syntax.ProcessBinary) and one.operator == "|~|":
                todo[:0] = [one.left, one.right]
            else:
                ways.append(one)
        name = unique("way", set(self.expressions.scope.names.values()))
        self._out.add(f"{name} = self.decide({len(ways)})")

        def write(way: syntax.Expr) -> None:
            with self.expressions.inside():
                self._process(way, tail=tail)

        self._alternatives([self._apart(lambda way=way: write(way)) for way in ways], name)  # type: ignore[misc]

    # --- choices ---------------------------------------------------------------------------------------------

    def _branches(
        self, node: syntax.Expr, guard: str | None, depth: int, restrictions: dict[Symbol, syntax.Expr] | None = None
    ) -> Iterator[Branch]:
        """The alternatives of an external choice; variables that they need before it are assigned."""
        node = _bare(node)
        if depth > DEEPEST:
            raise self.expressions.refused(node, "a choice that names itself before any event")
        match node:
            case syntax.Prefix():
                yield Branch(guard, node, dict(self.expressions.scope.names), restrictions or {})
            case syntax.ProcessBinary(operator="[]"):
                yield from self._branches(node.left, guard, depth, restrictions)
                yield from self._branches(node.right, guard, depth, restrictions)
            case syntax.Guard():
                condition = _both(guard, self.expressions.text(node.condition, OR))
                yield from self._branches(node.body, condition, depth, restrictions)
            case syntax.If():
                condition = self.expressions.text(node.condition, OR)
                yield from self._branches(node.then, _both(guard, condition), depth, restrictions)
                otherwise = f"not ({condition})" if " " in condition else f"not {condition}"
                yield from self._branches(node.otherwise, _both(guard, otherwise), depth, restrictions)
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

    def _named_branches(self, node: syntax.Name | syntax.Apply, guard: str | None, depth: int) -> Iterator[Branch]:
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
        if len(declaration.clauses) > 1 or len(clause.groups) > 1 or not all(map(_simple, clause.groups[0])):
            raise self.expressions.refused(node, f"`{symbol.name}`, which has clauses, as an alternative of a choice")
        for pattern, argument in zip(clause.groups[0], arguments, strict=True):
            value = self.expressions.text(argument)
            name = self._parameter(pattern, self.expressions.scope.bind)
            if name not in ("_", value):
                self._out.add(f"{name} = {value}")
        yield from self._branches(clause.body, guard, depth + 1)

    def _replicated(
        self, node: syntax.Replicated, guard: str | None, depth: int, outer: dict[Symbol, syntax.Expr] | None
    ) -> Iterator[Branch]:
        """``[] i:S @ c.i -> P(i)`` is ``c?i:S -> P(i)``: each variable must be a field of the event."""
        restrictions = dict(outer or {})
        for statement in node.statements:
            pattern = _unwrapped(statement.pattern) if isinstance(statement, syntax.Generator) else None
            if not isinstance(statement, syntax.Generator) or not isinstance(pattern, syntax.NamePattern):
                raise self.expressions.refused(statement, "a replicated choice with conditions or patterns")
            restrictions[self.names.symbol(pattern)] = statement.source
        body = _bare(node.body)
        if not isinstance(body, syntax.Prefix):
            raise self.expressions.refused(node, "a replicated choice whose body is no prefix")
        fields = [_bare(part) for part in flattened(_bare(body.channel))[1:]]
        fields += [_bare(f.expression) for f in body.fields if f.expression is not None]
        mentioned = [self.names.symbol(f) for f in fields if isinstance(f, syntax.Name)]
        for symbol in restrictions:
            if mentioned.count(symbol) != 1:
                why = f"a replicated choice whose `{symbol.name}` is not a field of its events, once"
                raise self.expressions.refused(node, why)
        yield from self._branches(body, guard, depth, restrictions)

    def _choice(self, branches: list[Branch], tail: bool) -> None:
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

    def _taken(self, branch: Branch, event: Event, choice: str, tail: bool) -> None:
        self._out.add(*event.unpacked(choice))
        self._after(branch, event, tail)

    def _apart(self, write: Callable[[], None]) -> list[str]:
        """What is written by *write*, not added yet."""
        outer, self._out = self._out, Lines()
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
            with self._out.block(_alternative(one, position, len(groups))):
                self._out.add(*body)

    def _after(self, branch: Branch, event: Event, tail: bool) -> None:
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

    def _event(self, branch: Branch) -> Event:
        """The offer of a prefix, and what becomes of the values that come with it."""
        prefix = branch.prefix
        head, *outputs = flattened(_bare(prefix.channel))
        head = _bare(head)
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
                    for part in flattened(_bare(one.expression)):
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
        return Event(self._offer(channel, use, fields), targets, inner.names, use.timed)

    def channel_name(self, symbol: Symbol) -> str:
        """How the events of a channel are called."""
        return symbol.name

    def _output(
        self,
        part: syntax.Expr,
        branch: Branch,
        fields: list[str],
        targets: list[str],
        bind: Callable[[Symbol], str],
    ) -> None:
        bare = _bare(part)
        if isinstance(bare, syntax.Name):
            symbol = self.names.symbol(bare)
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
        pattern = _unwrapped(pattern)
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
                field_text = repr(pattern.value)
                targets.append("_")
            case syntax.DotPattern() if restriction is None:
                self._input(pattern.left, None, fields, targets, bind)
                self._input(pattern.right, None, fields, targets, bind)
                return
            case _:
                raise self.expressions.refused(pattern, f"the pattern `{pattern.span.text}` in an input")
        fields.append(field_text)

    def _offer(self, channel: str, use: Use, fields: list[str]) -> str:
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


@dataclass
class Event:
    """The offer of a branch, the variables that take its values, and all that can be seen behind it."""

    offer: str
    targets: list[str]
    names: dict[Symbol, str]
    timed: bool

    def assignment(self) -> str:
        """The left of an assignment of all values, if any is wanted."""
        if all(target == "_" for target in self.targets):
            return ""
        return f"({self.targets[0]},) = " if len(self.targets) == 1 else f"{', '.join(self.targets)} = "

    def unpacked(self, choice: str) -> list[str]:
        """The assignment of the values of a choice."""
        assignment = self.assignment()
        return [f"{assignment}{choice}.values"] if assignment else []


def mentioned(node: object, names: Names) -> set[Symbol]:
    """The symbols of all names in a tree."""
    found: set[Symbol] = set()
    todo = [node]
    while todo:
        one = todo.pop()
        if isinstance(one, syntax.Name):
            symbol = names.find(one)
            if symbol is not None:
                found.add(symbol)
        elif isinstance(one, syntax.Node):
            todo.extend(getattr(one, name) for name in one.__dataclass_fields__ if name != "span")
        elif isinstance(one, tuple):
            todo.extend(one)
    return found


def _alternative(condition: str, position: int, count: int) -> str:
    if position == 0:
        return f"if {condition}:"
    return "else:" if position == count - 1 else f"elif {condition}:"


def _both(left: str | None, right: str) -> str:
    if left is None:
        return right
    return f"({left}) and ({right})"


def _bare(node: syntax.Expr) -> syntax.Expr:
    while isinstance(node, syntax.Paren):
        node = node.inner
    return node


def _unwrapped(pattern: syntax.Pattern) -> syntax.Pattern:
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return pattern


def _simple(pattern: syntax.Pattern) -> bool:
    return isinstance(_unwrapped(pattern), (syntax.NamePattern, syntax.Wildcard))
