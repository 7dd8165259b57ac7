"""Head normal form: a term whose running parts are unfolded, so that equal states are one object.

The *active* operands of an operator are those that are running: both sides of ``|||``, the left of ``;``, but not
its right, which has not started, nor what follows a prefix. A term is in head normal form when no reference is
reached from its root through active operands. ``P ||| Q`` and ``body(P) ||| body(Q)`` thus are one state, and
what has not started stays a name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.checker.messages import endless_unfolding, unguarded_recursion
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.terms import (
    SKIP,
    AlphabetisedParallel,
    Compressed,
    External,
    ExternalChoice,
    Fused,
    Hide,
    Interrupt,
    LinkedParallel,
    Parallel,
    Prioritised,
    Process,
    Project,
    Reference,
    Rename,
    Sequential,
    SlidingChoice,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)

MAXIMAL_UNFOLDING = 50_000
"""So many references nested without an event are taken for a recursion that never ends."""

Operands = tuple[Process, ...]

_ACTIVE: dict[type[Process], Callable[[Any], Operands]] = {
    Reference: lambda p: (p.body(),),
    ExternalChoice: lambda p: p.operands,
    SlidingChoice: lambda p: (p.left,),
    SynchronisingChoice: lambda p: p.operands,
    Interrupt: lambda p: (p.left, p.right),
    SynchronisingInterrupt: lambda p: (p.left, p.right),
    Throw: lambda p: (p.left,),
    Sequential: lambda p: (p.left,),
    Parallel: lambda p: p.operands,
    AlphabetisedParallel: lambda p: p.operands,
    LinkedParallel: lambda p: (p.left, p.right),
    Hide: lambda p: (p.process,),
    Project: lambda p: (p.process,),
    Rename: lambda p: (p.process,),
    Compressed: lambda p: (p.process,),
    Fused: lambda p: (p.process,),
    Prioritised: lambda p: (p.process,),
    # The other functions do not let their operands run: they follow them.
    External: lambda p: (p.process,) if p.function == "prioritisepo" else (),
}
_UNFOLDED: dict[type[Process], Callable[[Any], Operands]] = {**_ACTIVE, External: lambda p: (p.process,)}
"""The operands that must be in head normal form for a term to be."""


def active(process: Process) -> Operands:
    """The running operands of a term, in order; a reference's only one is its body.

    Raises:
        ScriptError: the body of a reference cannot be evaluated.
    """
    operands = _ACTIVE.get(type(process))
    return operands(process) if operands is not None else ()


def _unary(rebuild: Callable[[Any, Process], Process]) -> Callable[[Any, Operands], Process]:
    """The rebuilding of a unary operator that leaves SKIP as it is, since it cannot change a tick."""
    return lambda p, operands: SKIP if operands[0] is SKIP else rebuild(p, operands[0])


_REBUILD: dict[type[Process], Callable[[Any, Operands], Process]] = {
    Reference: lambda p, q: q[0],
    ExternalChoice: lambda p, q: ExternalChoice(q),
    SlidingChoice: lambda p, q: SlidingChoice(q[0], p.right),
    SynchronisingChoice: lambda p, q: SynchronisingChoice(p.events, q),
    Interrupt: lambda p, q: Interrupt(q[0], q[1]),
    SynchronisingInterrupt: lambda p, q: SynchronisingInterrupt(q[0], p.events, q[1]),
    Throw: lambda p, q: Throw(q[0], p.events, p.right),
    Sequential: lambda p, q: Sequential(q[0], p.right),
    Parallel: lambda p, q: Parallel(p.events, q, p.clocks),
    AlphabetisedParallel: lambda p, q: AlphabetisedParallel(p.alphabets, q, p.clocks),
    LinkedParallel: lambda p, q: LinkedParallel(q[0], p.links, q[1], p.clocks),
    Hide: _unary(lambda p, q: Hide(q, p.events)),
    Project: _unary(lambda p, q: Project(q, p.events)),
    Rename: _unary(lambda p, q: Rename(q, p.pairs)),
    Compressed: lambda p, q: q[0],
    Fused: lambda p, q: q[0],
    Prioritised: _unary(lambda p, q: Prioritised(q, p.levels)),
    External: lambda p, q: applied(p, q[0]),
}
IDEMPOTENT = ("chase", "chase_nocache", "deter")
"""Functions that change nothing where they have been applied already, nor SKIP."""


def applied(p: External, operand: Process) -> Process:
    """The function of *p* applied to another operand, in head normal form if the operand is."""
    if p.function in IDEMPOTENT and isinstance(operand, External) and operand.function == p.function:
        return operand
    if operand is SKIP and p.function in (*IDEMPOTENT, "prioritisepo"):
        return SKIP
    return External(p.function, operand, p.arguments)


def with_active(process: Process, operands: Operands) -> Process:
    """The term with other active operands.

    A compression is its operand; hiding, renaming and priority leave SKIP as it is.
    """
    rebuild = _REBUILD.get(type(process))
    return rebuild(process, operands) if rebuild is not None else process


class HeadNormalForms:
    """Brings terms to head normal form and remembers them.

    Works through a list of what is left to do, not by recursion, so the depth of a term does not matter.
    """

    def __init__(self) -> None:
        self._known: dict[Process, Process] = {}
        self._names: dict[Process, Reference] = {}

    def of(self, process: Process) -> Process:
        """The head normal form of *process*.

        Raises:
            ScriptError: a definition calls itself before any event (CSP501, CSP502), or cannot be evaluated.
        """
        found = self._known.get(process)
        if found is not None:
            return found
        if type(process) not in _UNFOLDED:
            return process
        if isinstance(process, Reference):
            # By far the most frequent case: a name for something that begins with an event.
            body = process.body()
            if type(body) not in _UNFOLDED:
                self._names.setdefault(body, process)
                self._known[process] = body
                return body
        return self._find(process)

    def name(self, state: Process) -> Reference | None:
        """The first reference met that stands for *state*, if there was one."""
        return self._names.get(state)

    def _find(self, process: Process) -> Process:
        # Terms without running operands are their own head normal forms and are not kept here.
        known = self._known
        # Terms between the root and the one at hand, outermost first: entered and not yet finished.
        entered: dict[Process, None] = {}
        unfolding = 0
        todo = [process]
        while todo:
            term = todo[-1]
            if term in known:
                todo.pop()
                continue
            operands = _UNFOLDED[type(term)](term)
            if term not in entered:
                entered[term] = None
                if isinstance(term, Reference):
                    unfolding += 1
                    if unfolding > MAXIMAL_UNFOLDING:
                        raise ScriptError(_endless(entered))
                missing = [q for q in operands if q not in known and type(q) in _UNFOLDED]
                for operand in missing:
                    if operand in entered:
                        raise ScriptError(_cycle(entered, operand))
                if missing:
                    todo.extend(reversed(missing))
                    continue
            normal = tuple([known.get(q, q) for q in operands])
            result = term if normal == operands and not isinstance(term, _TRANSPARENT) else with_active(term, normal)
            known[term] = result
            known[result] = result
            del entered[term]
            todo.pop()
            if isinstance(term, Reference):
                unfolding -= 1
                self._names.setdefault(result, term)
        return known[process]


_TRANSPARENT = (Reference, Compressed, Fused, Hide, Project, Rename, Prioritised, External)


def definition_name(reference: Reference) -> str:
    """The name in a call: ``P`` of ``P(0)``."""
    return reference.text.partition("(")[0]


def _cycle(entered: dict[Process, None], repeated: Process) -> Any:
    path = list(entered)
    calls = [term for term in path[path.index(repeated) :] if isinstance(term, Reference)]
    return unguarded_recursion([(call.text, call.span) for call in calls])


def _endless(entered: dict[Process, None]) -> Any:
    calls = [term for term in entered if isinstance(term, Reference)]
    # The first calls may only lead to the recursion; the last are in it.
    last = calls[-1]
    same = [call for call in calls if call.span == last.span and definition_name(call) == definition_name(last)]
    return endless_unfolding([call.text for call in same[:3]], last.span, len(calls))
