"""The heart of the evaluator: syntax trees become Python closures, each form by the function registered for it.

A form can be compiled for four uses:

* as a *value*: code that gives an evaluated value,
* as a *process*: code that gives a process term without evaluating what is only named there,
* as a *condition*: code that gives a Python truth value,
* *delayed*: code that gives a value if that costs nothing, otherwise a thunk.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeVar

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.evaluator.builtins_data import as_sequence
from cspcheck.cspm.evaluator.builtins_processes import as_event, builtins_for
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.sorts import Sorts
from cspcheck.cspm.evaluator.strictness import Strictness
from cspcheck.cspm.naming.resolve import Names
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.recursion import FRAMES, enlarge_stack
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children
from cspcheck.cspm.syntax.dispatch import Dispatch
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Channels, Dotted
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import event_set
from cspcheck.cspm.values.thunks import Code, Env, Thunk
from cspcheck.cspm.values.values import FALSE, TRUE, Boolean

if TYPE_CHECKING:
    from cspcheck.cspm.typing.inference import Types

T = TypeVar("T")
Condition = Callable[[Env], bool]
Compile = Callable[["Evaluator", Any, Frame], Any]

VALUES: Final = Dispatch[Compile]("evaluate")
"""How each form is compiled as a value."""
PROCESSES: Final = Dispatch[Compile]("evaluate as a process")
"""How each form is compiled as a process; the others are compiled as values and must turn out to be processes."""
CONDITIONS: Final = Dispatch[Compile]("evaluate as a condition")
"""How some forms are compiled as conditions more directly than by way of a Boolean."""
DELAYED: Final = Dispatch[Compile]("evaluate later")
"""How the forms are compiled that need no thunk."""

PROCESS_TYPES = frozenset(
    kind for kind in vars(process).values() if isinstance(kind, type) and issubclass(kind, Process)
)


class Evaluator:
    """Everything that the evaluation of one script shares."""

    fuses_processes: ClassVar[bool] = True
    """Whether definitions of processes that are unfolded often become functions of their own."""

    def __init__(self, names: Names, channels: Channels, types: Types | None) -> None:
        self.names = names
        self.types = types
        self.channels = channels
        self.sorts = Sorts(names, types)
        self.builtins = builtins_for(channels)
        self.strictness = Strictness(self)
        self.unfolding: dict[Any, Callable[[], str]] = {}
        """The references whose bodies are being evaluated, outermost first, with their texts."""
        self.routines: dict[Any, Any] = {}
        """The routine of each definition that is local to some expression, by node and unit."""
        self.free_variables: dict[int, frozenset[Any]] = {}
        self.menus_open = 0
        """How many menus of processes are being worked out, one for another."""
        self._active = False

    def forget(self, root: syntax.Node, frame: Frame) -> None:
        """Drop what is known of a tree written against the script at *frame*: nobody will ask for its value again."""
        nodes: list[syntax.Node] = []
        waiting = [root]
        while waiting:
            node = waiting.pop()
            nodes.append(node)
            waiting += children(node)
        declared = self.names.forget(root, nodes)
        if self.types is not None:
            self.types.forget(root, nodes, declared)
        for node in nodes:
            self.free_variables.pop(id(node), None)
            self.routines.pop((id(node), frame.unit), None)
        for symbol in declared:
            self.routines.pop((symbol, frame.unit), None)
        self.sorts.forget(declared)
        self.strictness.forget(declared)

    # --- compiling ------------------------------------------------------------------------------------------

    def value(self, node: syntax.Expr, frame: Frame) -> Code:
        """Code for the value of *node*."""
        code: Code = VALUES[type(node)](self, node, frame)
        return code

    def process(self, node: syntax.Expr, frame: Frame) -> Callable[[Env], Process]:
        """Code for *node* as a process term."""
        compile_form = PROCESSES.get(type(node))
        if compile_form is not None:
            code: Callable[[Env], Process] = compile_form(self, node, frame)
            return code
        return checked_process(VALUES[type(node)](self, node, frame), node.span)

    def condition(self, node: syntax.Expr, frame: Frame) -> Condition:
        """Code for *node* as a truth value."""
        compile_form = CONDITIONS.get(type(node))
        if compile_form is not None:
            code: Condition = compile_form(self, node, frame)
            return code
        value = self.value(node, frame)
        span = node.span

        def test(env: Env) -> bool:
            found = value(env)
            if found is TRUE:
                return True
            if found is FALSE:
                return False
            raise Failure(messages.wrong_kind("a truth value", found, span))

        return test

    def delayed(self, node: syntax.Expr, frame: Frame) -> Code:
        """Code for the value of *node* or a thunk of it."""
        compile_form = DELAYED.get(type(node))
        if compile_form is not None:
            code: Code = compile_form(self, node, frame)
            return code
        return self.thunk(node, frame)

    def thunk(self, node: syntax.Expr, frame: Frame) -> Code:
        """Code for a thunk of *node*, which is compiled when it is first needed."""
        compiled: list[Code] = []

        def first(env: Env) -> Any:
            if not compiled:
                compiled.append(self.value(node, frame))
            return compiled[0](env)

        def delay(env: Env) -> Thunk:
            return Thunk(compiled[0] if compiled else first, env)

        return delay

    def events(self, node: syntax.Expr, frame: Frame) -> Callable[[Env], EventSet]:
        """Code for *node* as a set of events."""
        value = self.value(node, frame)
        span = node.span

        def find(env: Env) -> EventSet:
            found = value(env)
            try:
                return event_set(found)
            except Failure as failure:
                failure.at(span)
                raise

        return find

    def trace(self, node: syntax.Expr, frame: Frame) -> Callable[[Env], tuple[int, ...]]:
        """Code for *node* as a sequence of events."""
        value = self.value(node, frame)
        span = node.span

        def find(env: Env) -> tuple[int, ...]:
            try:
                return tuple([as_event(item).number for item in as_sequence(value(env)).values()])
            except Failure as failure:
                failure.at(span)
                raise

        return find

    # --- running --------------------------------------------------------------------------------------------

    def run(self, work: Callable[[], T], span: Span | None = None) -> T:
        """Do *work* with room for deep recursion; failures leave as script errors with the script's call stack.

        *span* is the place of what has none.

        Raises:
            ScriptError: the evaluation failed.
        """
        if self._active:
            return work()
        self._active = True
        before = sys.getrecursionlimit()
        enlarge_stack()
        sys.setrecursionlimit(max(before, FRAMES))
        try:
            return work()
        except Failure as failure:
            error = failure.at(span).finished()
        except RecursionError as deep:
            deep.__traceback__ = None
            error = ScriptError(messages.too_deep(span))
        finally:
            self._active = False
            sys.setrecursionlimit(before)
        raise error


def checked_process(value: Code, span: Span) -> Callable[[Env], Process]:
    """Code for a value that must be a process."""

    def check(env: Env) -> Process:
        found = value(env)
        if type(found) not in PROCESS_TYPES:
            raise Failure(messages.wrong_kind("a process", found, span))
        return found  # type: ignore[no-any-return]

    return check


def truth(value: Any, span: Span) -> Boolean:
    """*value*, which must be a Boolean.

    Raises:
        Failure: it is something else.
    """
    if isinstance(value, Boolean):
        return value
    raise Failure(messages.wrong_kind("a truth value", value, span))


def partial(value: Any) -> bool:
    """Whether *value* is an incomplete dotted value."""
    return type(value) is Dotted and not value.complete
