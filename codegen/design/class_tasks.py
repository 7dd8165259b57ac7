"""What the task of a class does: its ``main``, in which an event is an operation on the data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from cspcheck.codegen import messages
from cspcheck.codegen.design.classes import OperationDesign
from cspcheck.codegen.design.expressions import ExpressionTranslator
from cspcheck.codegen.design.pieces import ChannelUse, InternalChoice, StateMethod
from cspcheck.codegen.design.tasks import TaskTranslator
from cspcheck.codegen.quoting import literal, literals
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.oz import core
from cspcheck.cspm.script import Script


class ClassProcesses(TaskTranslator):
    """Translates the equations of a class.

    Args:
        expressions, uses, internal_choice: as for any task.
        operations: the attribute of the operation for each channel.
        owner: the name of the class.
    """

    def __init__(
        self,
        expressions: ExpressionTranslator,
        uses: Callable[[str], ChannelUse],
        internal_choice: InternalChoice,
        operations: Mapping[str, str],
        owner: str,
    ) -> None:
        super().__init__(expressions, uses, internal_choice, set())
        self.perform, self.select = "do", "act"
        self.bare_means_any = True
        self.reserved |= {*operations.values(), "act", "begin_data", "change", "data", "do"}
        self.used: set[str] = set()
        self._operations = operations
        self._class = owner

    def channel_name(self, symbol: Symbol) -> str:
        """How the events of a channel are called: those of the class's own with its name in front."""
        return symbol.name if symbol.owner is None else f"{self._class}::{symbol.name}"

    def _offer(self, channel: str, use: ChannelUse, fields: list[str]) -> str:
        self.used.add(channel)
        attribute = self._operations[channel]
        if use.timed:
            return f"self.{attribute}.on({', '.join([*fields, 'after=self.release'])})"
        if all(f == "ANY" for f in fields):
            return f"self.{attribute}"
        return f"self.{attribute}.on({', '.join(fields)})"

    def any_operation(self, attributes: Sequence[str]) -> StateMethod:
        """A loop that always offers all operations: what a class without ``main`` does."""
        if not attributes:
            lines = ["await self.stop()"]
        elif len(attributes) == 1:
            lines = [f"await self.do(self.{attributes[0]})"]
        else:
            lines = [f"await self.act({', '.join(f'self.{attribute}' for attribute in attributes)})"]
        return StateMethod("main", [], "", lines)


def main_of(script: Script, model: core.ClassModel) -> Symbol | None:
    """The definition of ``main`` of a class; None if it has none.

    Raises:
        ScriptError: it has several, of its own and of its parents.
    """
    parts = [part for part in model.processes if part.equations]
    if not parts:
        return None
    if len(parts) > 1 or parts[0].owner != model.name:
        what = f"the class `{model.name}`, whose process is composed of those of its parents"
        raise ScriptError(messages.not_generated(what, model.span, "write its `main` out"))
    return script.names.top_level[f"{model.name}%"].members.get("main")


def operation_arguments(operation: OperationDesign, method: str | None, reads: str | None) -> str:
    """The arguments of an ``Operation``, without its channel."""
    parts: list[str] = []
    if operation.kinds or operation.method is not None:
        parts.append(literal(operation.kinds))
    if operation.method is not None:
        parts.append(f"data.{operation.method}")
    if operation.guard is not None:
        parts.append(f"guard=data.{operation.guard}")
    if reads is not None:
        parts.append(f"reads=methods.{reads}")
    if method is not None:
        parts.append(f"body=methods.{method}")
    if operation.gives:
        parts.append(f"gives=({literals([name for name, _ in operation.gives])})")
    if operation.post is not None:
        parts.append(f"post=data.{operation.post}")
    return "".join(f", {part}" for part in parts)
