"""The functions of a script that tasks call, as functions in Python."""

from __future__ import annotations

from cspcheck.codegen import messages
from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.expressions import ExpressionTranslator
from cspcheck.codegen.design.naming import snake, unique
from cspcheck.codegen.design.pieces import ChannelUse, TextLines
from cspcheck.codegen.design.tasks import TaskTranslator
from cspcheck.codegen.quoting import literal, phrase
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.script import Script
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import types


class Functions:
    """The functions that the tasks of a program mention; each is defined once, after the task that wants it first."""

    def __init__(self, script: Script, data: DataDesigner) -> None:
        self.script = script
        self.data = data
        self.texts: list[str] = []
        """The definitions in Python, in the order of their making."""
        self._names: dict[Symbol, str] = {}
        self.expressions = ExpressionTranslator(script, data, self.name, "")
        """How expressions in the bodies of functions are written."""
        self._pending: list[Symbol] = []
        self._untranslated: dict[Symbol, ScriptError] = {}
        """Functions that have no counterpart, with the reason."""

    def forget_pending(self) -> None:
        """Drop what has been mentioned and is not defined, because who mentioned it is written otherwise."""
        for one in self._pending:
            del self._names[one]
        self._pending.clear()

    def name(self, symbol: Symbol, node: syntax.Node) -> str:
        """The name of a function of the script in Python; its definition is made when all tasks are."""
        known = self._names.get(symbol)
        if symbol in self._untranslated:
            raise self._untranslated[symbol]
        if known is None:
            known = self._names[symbol] = unique(snake(symbol.name), set(self._names.values()))
            self._pending.append(symbol)
        return known

    def define(self) -> None:
        """Define the functions that a task has mentioned, and those that these mention.

        Raises:
            ScriptError: one has no counterpart; none of the new ones is kept.
        """
        made, new = len(self.texts), []
        while self._pending:
            symbol = self._pending.pop(0)
            new.append(symbol)
            try:
                self._define(symbol)
            except ScriptError as error:
                self._untranslated[symbol] = error
                del self.texts[made:]
                for one in (*new, *self._pending):
                    del self._names[one]
                self._pending.clear()
                raise

    def _define(self, symbol: Symbol) -> None:
        declaration = symbol.declaration
        expressions = self.expressions
        if not isinstance(declaration, syntax.FunctionDefinition):
            raise ScriptError(messages.not_generated(f"`{symbol.name}`", symbol.span))
        first = declaration.clauses[0]
        if len(first.groups) != 1:
            raise expressions.refused(declaration, f"the curried definition `{declaration.name}`")
        processes = TaskTranslator(expressions, lambda channel: ChannelUse(0, False, False), "refuse", set())
        notes = processes._annotations(first.groups[0])
        returns = "Any"
        if self.script.types is not None:
            result = types.resolve(self.script.types.scheme(symbol).type)
            if isinstance(result, types.Function):
                returns = self.data.annotation(result.result)
        parameters = [f"value_{i + 1}" for i in range(len(notes))]
        out = TextLines()
        simple = len(declaration.clauses) == 1
        if simple:
            with expressions.inside() as scope:
                conditions: list[str] = []
                bindings: list[str] = []
                named = []
                for pattern, parameter in zip(first.groups[0], parameters, strict=True):
                    name = processes._parameter(pattern, scope.bind)
                    named.append(parameter if name == "_" else name)
                    if name == "_":
                        processes._match(pattern, parameter, conditions, bindings)
                if conditions:
                    raise expressions.refused(declaration, f"the pattern of `{declaration.name}`")
                head = ", ".join(f"{n}: {note}" for n, note in zip(named, notes, strict=True))
                with out.block(f"def {self._names[symbol]}({head}) -> {returns}:"):
                    out.add(f'"""`{phrase(declaration.span.text)}`."""', *bindings)
                    out.add(f"return {expressions.text(first.body)}")
        else:
            head = ", ".join(f"{n}: {note}" for n, note in zip(parameters, notes, strict=True))
            with out.block(f"def {self._names[symbol]}({head}) -> {returns}:"):
                out.add(f'"""`{phrase(declaration.name)}`, clause by clause."""')
                for clause in declaration.clauses:
                    with expressions.inside():
                        conditions, bindings = [], []
                        for pattern, parameter in zip(clause.groups[0], parameters, strict=True):
                            processes._match(pattern, parameter, conditions, bindings)
                        with out.block(f"if {' and '.join(conditions) or 'True'}:"):
                            out.add(*bindings, f"return {expressions.text(clause.body)}")
                out.add(f"raise ValueError({literal(f'no clause of {declaration.name} matches')})")
        self.texts.append("\n".join(out.lines))
