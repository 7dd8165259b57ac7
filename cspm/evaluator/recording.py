"""An evaluator that remembers which process expressions of a script were evaluated, and what prefixes became.

Coverage needs to lead from what happens in a machine back to the text. Terms know nothing of the text, so the way is
recorded where terms are made. Values, terms and their sharing are those of the plain evaluator.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from cspcheck.cspm.evaluator.core import PROCESSES, VALUES, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.thunks import Code, Env

_AS_VALUES = frozenset(kind for kind in PROCESSES if VALUES.get(kind) is PROCESSES[kind])
"""Forms that are processes however they are compiled."""


class RecordingEvaluator(Evaluator):
    """The evaluator with a memory.

    Attributes:
        compiled: the identities of all expressions that were compiled.
        processes: the identities of those whose evaluation is noted.
        evaluated: the identities of the ones among these that were evaluated.
        made: by the identity of a prefix's node, the terms that it became.
        conditions: by the identity of the node of a condition, the truth values that it had.
    """

    fuses_processes: ClassVar[bool] = False

    def __init__(self, *arguments: Any) -> None:
        self.compiled: set[int] = set()
        self.processes: set[int] = set()
        self.evaluated: set[int] = set()
        self.made: dict[int, set[Process]] = {}
        self.conditions: dict[int, set[bool]] = {}
        super().__init__(*arguments)

    def process(self, node: syntax.Expr, frame: Frame) -> Callable[[Env], Process]:
        """Code for *node* as a process term."""
        return self._recorded(node, super().process(node, frame))

    def value(self, node: syntax.Expr, frame: Frame) -> Code:
        """Code for the value of *node*."""
        code = super().value(node, frame)
        self.compiled.add(id(node))
        return self._recorded(node, code) if type(node) in _AS_VALUES else code

    def condition(self, node: syntax.Expr, frame: Frame) -> Callable[[Env], bool]:
        """Code for *node* as a truth value."""
        code = super().condition(node, frame)
        values = self.conditions.setdefault(id(node), set())

        def test(env: Env) -> bool:
            truth = code(env)
            values.add(truth)
            return truth

        return test

    def _recorded(self, node: syntax.Expr, code: Callable[[Env], Any]) -> Callable[[Env], Any]:
        key, evaluated = id(node), self.evaluated
        self.compiled.add(key)
        self.processes.add(key)
        if isinstance(node, syntax.Prefix):
            made = self.made.setdefault(key, set())

            def prefix(env: Env) -> Any:
                term = code(env)
                evaluated.add(key)
                made.add(term)
                return term

            return prefix

        def run(env: Env) -> Any:
            evaluated.add(key)
            return code(env)

        return run
