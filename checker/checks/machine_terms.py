"""Compressed and prioritised processes as machines, at whatever depth of a term they run.

Where the semantics meets one, its operand is compiled to a network, explored with the packed kernels, and the
function is applied to the machine that comes out; the process goes on as a state of it. Machines are built from the
inside, once for each term. What is met again while it is being built (recursion through a compression), or has too
many states by itself, is followed as a term: it means the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.lts import Lts, reachable
from cspcheck.checker.network.compiler import Company, Compiler, LimitReached
from cspcheck.checker.network.priority import at_the_top
from cspcheck.checker.reduction.bisimulation import strong_bisimulation
from cspcheck.checker.reduction.compression import COMPRESSIONS
from cspcheck.checker.reduction.priority import prioritised, prioritised_by_order
from cspcheck.checker.semantics.external import FOLLOWING
from cspcheck.checker.semantics.machine_states import ExplicitMachine, MachineParts
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.interruption import during
from cspcheck.cspm.process.terms import Compressed, External, MachineState, Prioritised, Process
from cspcheck.cspm.recursion import deep_recursion

UNDER_PRIORITY = frozenset({"sbisim", "dbisim", "wbisim", "tau_loop_factor", "explicate", "lazyenumerate"})
"""Compressions whose result is the same for priority. Where a state with a tau takes over what comes after the tau
(``diamond``, ``normal``) priority would see events together that never are."""

MOST_STATES = 200_000
"""A machine is given up where its operand has more states than this by itself."""
TURNS = (2_000, 20_000, MOST_STATES)
"""A priority and its operand are looked at in turns, with ever more states: a priority may leave next to nothing of an
operand that has nearly no end, and may itself have none although its operand is small."""
MOST_NESTED = 40
"""Machines being built inside one another; a recursion through compressions may never end."""

Explore = Callable[[Compiler, Process, Budget], Lts]
"""The explicit machine of a process, compiled by a compiler; see :class:`MachineTerms`."""
Surroundings = Literal["any", "priority"]
_Applied = Compressed | Prioritised | External


class MachineTerms:
    """The machines of the compressed and prioritised processes of one script.

    Args:
        explore: gives the explicit machine of a process, or raises ``Incomplete`` or ``LimitReached``.
        company: gives the network of a large composition in which something is chased.

    Attributes:
        original: compiles processes without machines: what all this must be held against.
        compiler: compiles them with machines.
        budget: what may be used at the moment.
        whole: the priority that is searched as a whole, and so becomes a machine only for machines inside it.
    """

    def __init__(self, explore: Explore, company: Company) -> None:
        self._explore = explore
        self._known: dict[tuple[Surroundings, Process], Process | None] = {}
        self._building: set[tuple[Surroundings, Process]] = set()
        self.budget: Budget | None = None
        self.whole: Process | None = None
        self._large: set[Process] = set()
        self.original = Compiler(company=company)
        followed = self.original.semantics
        self._strict = Compiler(semantics=Semantics(self._under_priority, followed=followed), company=company)
        self.compiler = Compiler(
            semantics=Semantics(self._anywhere, prioritised=self._strict.semantics, followed=followed), company=company
        )

    def begin(self, process: Process, budget: Budget) -> None:
        """Get ready to compile *process* as a whole, with what may be used.

        Raises:
            ScriptError: it calls itself before any event, or cannot be evaluated.
        """
        self.budget = budget
        # Only what comes to an event can be looked through.
        self.original.semantics.state(process)
        priority = at_the_top(process)
        self.whole = None if priority is None else priority.term

    def _anywhere(self, term: Process) -> Process | None:
        if isinstance(term, Compressed):
            return self._machine("any", term)
        if isinstance(term, External) and term.function in FOLLOWING:
            return self.original.semantics.state(term)
        return self._strict.semantics.state(term)

    def _under_priority(self, term: Process) -> Process | None:
        if isinstance(term, Compressed):
            return self._machine("priority", term) if term.function in UNDER_PRIORITY else None
        if isinstance(term, External) and term.function in FOLLOWING:
            return self.original.semantics.state(term)
        return self._machine("priority", term)

    def _machine(self, surroundings: Surroundings, term: Process) -> Process | None:
        """The state that a term is as a machine; None where it is to be followed."""
        key = (surroundings, term)
        if key in self._known:
            return self._known[key]
        if key in self._building or len(self._building) >= MOST_NESTED or (term == self.whole and term in self._large):
            return None
        self._building.add(key)
        try:
            with deep_recursion():
                found = self._built(surroundings, term)
        finally:
            self._building.discard(key)
        if found is None and term == self.whole:
            self._large.add(term)
        else:
            self._known[key] = found
        return found

    def _built(self, surroundings: Surroundings, term: Process) -> Process | None:
        assert isinstance(term, (Compressed, Prioritised, External))
        compiler = self.compiler if surroundings == "any" else self._strict
        budget = self.budget or Budget(Limits())
        try:
            state = compiler.semantics.state(term.process)
        except ScriptError:  # where nothing in its company ever gets, perhaps
            return None
        if isinstance(term, Compressed):
            turns: tuple[int, ...] = (MOST_STATES,)
        else:
            # A whole without machines inside is searched as a network.
            turns = TURNS if term != self.whole or MachineParts()(state) else ()
        for most in turns:
            # A component of the operand, which is explored first, has words of its own.
            with during(f"exploring what `{_name(term)}` is applied to", vague=True):
                lts = self._operand(compiler, state, term.process, budget.narrowed(most))
            if lts is not None:
                return _machine_of(term, lts, budget)
            if not isinstance(term, Compressed):
                lts = self._tried(self.original, term, budget.narrowed(most))
                if lts is not None:
                    machine = ExplicitMachine(strong_bisimulation(lts), term)
                    return machine.term(machine.lts.root)
        return None

    def _operand(self, compiler: Compiler, state: Process, process: Process, budget: Budget) -> Lts | None:
        """The machine of what a function is applied to, which is in *state*; None if it has too many states."""
        if isinstance(state, MachineState):
            assert isinstance(state.machine, ExplicitMachine)
            return reachable(replace(state.machine.lts, root=state.state))
        return self._tried(compiler, process, budget)

    def _tried(self, compiler: Compiler, process: Process, budget: Budget) -> Lts | None:
        """The machine of a process; None if it has too many states."""
        try:
            return self._explore(compiler, process, budget)
        except (Incomplete, LimitReached, ScriptError):
            # It may be without end, or wrong, where nothing in its company ever gets.
            if budget.is_over():
                raise
            return None


def _machine_of(term: _Applied, operand: Lts, budget: Budget) -> Process:
    """The state of the machine that a function makes of its operand's."""
    with during(f"applying `{_name(term)}` to a component of {operand.states:,} states"):
        budget.check_time()
        machine = ExplicitMachine(_reduced(term, operand), term)
    return machine.term(machine.lts.root)


def _name(term: _Applied) -> str:
    return "prioritise" if isinstance(term, Prioritised) else term.function


def _reduced(term: _Applied, lts: Lts) -> Lts:
    if isinstance(term, Compressed):
        return COMPRESSIONS[term.function](lts)
    if isinstance(term, Prioritised):
        return strong_bisimulation(prioritised(lts, term.levels))
    return strong_bisimulation(prioritised_by_order(lts, *term.arguments))  # type: ignore[arg-type]
