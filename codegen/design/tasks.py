"""Processes as tasks: prefixes become events to wait for, choices selections, recursion loops or states.

A process that only ever goes on as itself becomes a loop, its parameters local variables. Otherwise each definition
that it can go on as becomes a method, a *state*, which says which state comes next.
"""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.codegen import messages
from cspcheck.codegen.design.choices import Choices
from cspcheck.codegen.design.expressions import constant
from cspcheck.codegen.design.naming import snake, unique
from cspcheck.codegen.design.pieces import NeedsStates, StateMethod, TextLines, is_simple, unwrapped
from cspcheck.codegen.quoting import literal
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax


class TaskTranslator(Choices):
    """Translates what one task does."""

    # --- definitions -----------------------------------------------------------------------------------------

    def loop(self, symbol: Symbol) -> StateMethod:
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

    def _define(self, symbol: Symbol) -> StateMethod:
        self._out = TextLines()
        declaration = symbol.declaration
        if declaration in self.timed:
            raise self.expressions.refused(declaration, f"`{symbol.name}`, a process in time,")
        name = symbol.name if self._loop is not None else self.state_name(symbol)
        match declaration:
            case syntax.PatternDefinition(pattern=syntax.NamePattern()):
                with self.expressions.inside():
                    self._process(declaration.body, tail=True)
                return StateMethod(name, [], declaration.span.text, self._out.lines)
            case syntax.FunctionDefinition():
                return self._define_function(symbol, declaration, name)
        raise self.expressions.refused(declaration or syntax.Node(span=symbol.span), f"`{symbol.name}`")  # type: ignore[arg-type]

    def _define_function(self, symbol: Symbol, declaration: syntax.FunctionDefinition, name: str) -> StateMethod:
        first = declaration.clauses[0]
        if len(first.groups) != 1:
            raise self.expressions.refused(declaration, f"the curried definition `{declaration.name}`")
        annotations = self._annotations(first.groups[0])
        if len(declaration.clauses) == 1 and all(is_simple(p) for p in first.groups[0]):
            with self.expressions.inside() as scope:
                written = [self._parameter(p, scope.bind) for p in first.groups[0]]
                self._parameters = written
                self._process(first.body, tail=True)
            return StateMethod(
                name, list(zip(written, annotations, strict=True)), declaration.span.text, self._out.lines
            )
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
                self._out.add(
                    f'raise ValueError({literal(f"no clause of {declaration.name} matches")} f" {{({values},)}}")'
                )
        return StateMethod(name, list(zip(written, annotations, strict=True)), declaration.span.text, self._out.lines)

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

    def _match(self, pattern: syntax.Pattern, value: str, conditions: list[str], bindings: list[str]) -> None:
        """The conditions under which a pattern matches a value, and the assignments that follow."""
        pattern = unwrapped(pattern)
        expressions = self.expressions
        match pattern:
            case syntax.Wildcard():
                return
            case syntax.LiteralPattern():
                conditions.append(f"{value} == {constant(pattern)}")
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
        node = syntax.bare(node)
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
            one = syntax.bare(todo.pop(0))
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
