"""Head normal form: a term whose running parts are unfolded, so that equal states are one object.

The *active* operands of an operator are those that are running: both sides of ``|||``, the left of ``;``, but not
its right, which has not started, nor what follows a prefix. A term is in head normal form when no reference is
reached from its root through active operands. ``P ||| Q`` and ``body(P) ||| body(Q)`` thus are one state, and
what has not started stays a name.
"""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import Any

from cspcheck.checker.messages import endless_unfolding, unguarded_recursion
from cspcheck.checker.semantics.machine_states import Compile
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.terms import (
    Compressed,
    External,
    ExternalChoice,
    Fused,
    Hide,
    Menu,
    Operands,
    Prefix,
    Prioritised,
    Process,
    Project,
    Reference,
    Rename,
)

MAXIMAL_UNFOLDING = 50_000
"""So many references nested without an event are taken for a recursion that never ends."""


DEEPEST = 20
"""Choices nested deeper than this have no menus."""


def unfolded(process: Process) -> Operands:
    """The operands that must be in head normal form for a term to be: the running ones, and what functions follow."""
    return (process.process,) if isinstance(process, External) else process.active()


def menu_of(state: Process, depth: int = 0) -> Menu | None:
    """The menu of a term in head normal form, if it has one."""
    if type(state) is Prefix:
        return (state.branches,)
    if type(state) is not ExternalChoice or depth == DEEPEST:
        return None
    found: list[Any] = []
    for operand in state.operands:
        if type(operand) is Prefix:
            found.append(operand.branches)
        else:
            inner = menu_of(operand, depth + 1)
            if inner is None:
                return None
            found.append(inner)
    return tuple(found)


def all_begun(operands: Operands) -> bool:
    """Whether nothing runs inside any of some operands: prefixes and their like."""
    return not any(map(_has_active, operands))


_has_active = attrgetter("has_active")


class HeadNormalForms:
    """Brings terms to head normal form and remembers them.

    Works through a list of what is left to do, not by recursion, so the depth of a term does not matter.

    Args:
        compile: asked for the state that a compressed or prioritised process is as a machine.
    """

    def __init__(self, compile: Compile | None = None) -> None:
        self._compile = compile
        self._known: dict[Process, Process] = {}
        self._names: dict[Process, Reference] = {}
        self._others: dict[Process, list[Reference]] = {}
        self.by_menu: dict[Menu, Process] = {}
        """What the states explored by their menus were met as: names that come before those of their terms."""

    def of(self, process: Process) -> Process:
        """The head normal form of *process*.

        Raises:
            ScriptError: a definition calls itself before any event (CSP501, CSP502), or cannot be evaluated.
        """
        found = self._known.get(process)
        if found is not None:
            return found
        if not process.has_active:
            return process
        if isinstance(process, Reference):
            # By far the most frequent case: a name for something that begins with an event.
            body = process.body()
            if not body.has_active or (type(body) is ExternalChoice and all_begun(body.operands)):
                self._call(body, process)
                self._known[process] = body
                if body.has_active:
                    self._known[body] = body
                return body
        return self._find(process)

    def name(self, state: Process) -> Reference | None:
        """The first reference met that stands for *state*, if there was one."""
        return self._names.get(state)

    def variables(self, state: Process) -> Mapping[str, str]:
        """The variables of the state of a class that *state* is; none where it is none, or could be one of several.

        Two states of a class are one term where nothing that the class does tells them apart.
        """
        first = self._names.get(state)
        if first is None:
            return {}
        named = (first, *self._others.get(state, ()))
        found = [variables for reference in named if (variables := reference.variables)]
        return found[0] if found and all(variables == found[0] for variables in found) else {}

    def _call(self, state: Process, reference: Reference) -> None:
        """Remember that the reference stands for *state*."""
        if self.by_menu and state not in self._names:
            menu = menu_of(state)
            met = reference if menu is None else self.by_menu.get(menu)
            if type(met) is Reference:
                self._names[state] = met
        if self._names.setdefault(state, reference) is not reference:
            self._others.setdefault(state, []).append(reference)

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
            operands = unfolded(term)
            if term not in entered:
                entered[term] = None
                if isinstance(term, Reference):
                    unfolding += 1
                    if unfolding > MAXIMAL_UNFOLDING:
                        raise ScriptError(_endless(entered))
                missing = [q for q in operands if q not in known and q.has_active]
                for operand in missing:
                    if operand in entered:
                        raise ScriptError(_cycle(entered, operand))
                if missing:
                    todo.extend(reversed(missing))
                    continue
            normal = tuple([known.get(q, q) for q in operands])
            result = self._compile(term) if self._compile is not None and isinstance(term, COMPILED) else None
            if result is None:
                plain = normal == operands and not isinstance(term, _TRANSPARENT)
                result = term if plain else term.with_active(normal)
            known[term] = result
            known[result] = result
            del entered[term]
            todo.pop()
            if isinstance(term, Reference):
                unfolding -= 1
                self._call(result, term)
        return known[process]


COMPILED = (Compressed, Prioritised, External)
"""What may run as a machine of its own."""
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
