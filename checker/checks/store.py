"""The machines of processes, built once and shared between the assertions of a script.

Everything is keyed by the process term, which is one object however often the script writes it. What a machine is
does not depend on which assertion asked for it first; an exploration that ended early because one assertion had its
answer is kept for the same question only.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any, Literal

from cspcheck.checker.budget import Budget, Incomplete, coverage
from cspcheck.checker.checks.machine_terms import MachineTerms
from cspcheck.checker.checks.reducing import as_they_are, model_for, reduced
from cspcheck.checker.lts import Lts
from cspcheck.checker.network.compiler import MOST_TERMS, Compiler, LimitReached
from cspcheck.checker.network.lazily import LazyComposition, is_chased
from cspcheck.checker.network.network import Network
from cspcheck.checker.network.skeleton import compile_single
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.packing.stubborn import Kept, narrowed
from cspcheck.checker.search.beyond import Beyond
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.company import TooLarge, together
from cspcheck.checker.search.exploration import Exploration, Progress, explore
from cspcheck.checker.search.pair_search import PairExploration, explore_pairs
from cspcheck.checker.semantics.beginning import along, beginning, one_run
from cspcheck.checker.semantics.growth import beyond
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Explored, Poll
from cspcheck.checker.specification.lazy import LazySpecification
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.specification.normalisation import is_deterministic, normalise
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.interruption import doing, during, told
from cspcheck.cspm.process.terms import Process

Aim = Literal["everything", "deadlock", "deadlock or divergence", "divergence"]
"""What an exploration looks for; it may end at the first level that has it."""

Specification = NormalForm | Normaliser | LazySpecification
"""What an implementation is compared with: a whole normal form, or one that grows."""

KEPT_BYTES = 1 << 30
"""Machines are kept for later assertions as long as all together take no more than this (the last is always kept)."""

BEGINNING = 20_000
"""So many states of a process without end are looked at for something that is wrong early on."""

LISTED_FIRST = 8_000
"""A specification with a component of more states is first followed term by term, as far as the implementation goes."""

FOLLOWED_FIRST = 20_000
"""So many states of it are looked at before it is explored by itself."""

FOLLOWED_EFFORT = 50 * FOLLOWED_FIRST
"""So many transitions of it are looked at by then: enough where nodes are small, and gone in a second where not."""

MANY_COMPONENTS = 256
"""A process of more components is reduced at once where the question allows it: to lay out its states takes longer."""

FIRST_LOOK = 2_000
"""So many states are looked at before a process is reduced: what is found among them is told by the shortest run."""

SECOND_LOOK = 500_000
"""So many states are looked at for the shortest run to what was found in a reduced process."""

WHOLE_NORMAL_FORM = 50_000
"""Normal forms of more nodes than this are extended node by node as the search reaches them."""


MOST_IN_COMPANY = 1 << 30
"""Where no limit is given, a composition is explored for what is chased in it until its states take so many bytes."""


class Machines:
    """Networks, explorations, explicit machines and normal forms of the processes of one script.

    Args:
        workers: threads for large searches.
        full: explore everything, end nothing early, merge nothing.
        reduces: whether processes may be reduced although the script does not ask for it.
        kept_bytes: how much to keep for later.
        progress, notify, checkpoints, beyond: handed to the searches.
    """

    def __init__(
        self,
        *,
        workers: int = 1,
        full: bool = False,
        reduces: bool = True,
        kept_bytes: int = KEPT_BYTES,
        progress: Callable[[Progress], None] | None = None,
        notify: Callable[[str], None] | None = None,
        checkpoints: Checkpoints | None = None,
        beyond: Beyond | None = None,
    ) -> None:
        self.workers = workers
        self.beyond = beyond
        self.full = full
        self.reduces = reduces and not full
        self._kept_bytes = kept_bytes
        self._progress = progress
        self._notify = notify
        self._terms = MachineTerms(self._listed, self._in_company)
        self._checkpoints = checkpoints
        self._beginnings: dict[Process, PackedNetwork] = {}
        self._kept: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()

    def packed(self, process: Process, budget: Budget, *, original: bool = False) -> PackedNetwork:
        """The network of a process, ready to be searched.

        Args:
            process: the process.
            budget: what may be used.
            original: whether compressed components are to have all their states.

        Raises:
            Incomplete: a component is too large for a limit, or took too long.
            ScriptError: a definition cannot be evaluated.
        """
        if process in self._beginnings:
            return self._beginnings[process]
        original = original or self.full
        key = ("packed", process, original)
        found: PackedNetwork | None = self._find(key)
        if found is None:
            with during("building the machine of the process", vague=True):
                found = pack(self.network(process, budget, original=original))
            if not original and not found.network.is_compressed:
                self._keep(("packed", process, True), found, 0)
            self._keep(key, found, 0)
        return found

    def network(self, process: Process, budget: Budget, *, original: bool = False, terms: int | None = None) -> Network:
        """The network of a process; see :meth:`packed`.

        Args:
            process, budget, original: as there.
            terms: how many states of a component are looked at, if not as many as may be.
        """
        original = original or self.full
        packed: PackedNetwork | None = self._find(("packed", process, original))
        if packed is not None:
            return packed.network
        key = ("network", process, original)
        found: Network | None = self._find(key)
        if found is None:
            compiler = self._terms.original if original else self._terms.compiler
            self._terms.begin(process, budget)
            limits = budget.limits
            # What is chased is explored in company from the start.
            if terms is not None and not is_chased(process) and (limits.states is None or terms < limits.states):
                limits = replace(limits, states=terms)
            try:
                with during("building the machine of the process", vague=True):
                    found = compiler.network(process, limits, lambda _: budget.check_time())
            except LimitReached as reached:
                raise Incomplete(budget.too_many_terms(reached), reached.states, endless=True) from None
            self._keep(key, found, 0)
        return found

    def grows(self, process: Process, budget: Budget) -> bool:
        """Whether a component of a process has more than ``LISTED_FIRST`` states by itself, perhaps without end.

        Raises:
            Incomplete: there was no time to find out.
        """
        most = budget.limits.states
        if self.full or (most is not None and most <= LISTED_FIRST) or is_chased(process):
            return False
        key = ("grows", process)
        found: bool | None = self._find(key)
        if found is None:
            limits = replace(budget.limits, states=LISTED_FIRST)
            self._terms.begin(process, budget)
            try:
                # Not what may be known by now: the answer must not depend on which assertions came before.
                self._terms.compiler.network(process, limits, lambda _: budget.check_time())
                found = False
            except LimitReached:
                found = True
            self._keep(key, found, 0)
        return found

    def at_the_beginning(self, process: Process, budget: Budget, states: int | None = None) -> tuple[Machines, int]:
        """Machines for which *process* is what it can do within its first levels, and how many these are.

        So many *states* are looked at, by default ``BEGINNING``.

        They share nothing with these, so that nothing of the rest is taken for what it is not.
        """
        most = BEGINNING if states is None else states
        most = most if budget.limits.states is None else min(most, budget.limits.states)
        with during("looking at the beginning of the process"):
            found = beginning(process, most, lambda _: budget.check_time())
        return self._of_part(process, found.machine), found.levels

    def along(
        self, process: Process, trace: Sequence[int], most: int, budget: Budget, goal: Callable[[Row], bool] | None
    ) -> Machines | None:
        """Machines for which *process* is what its terms can do along a trace; None if that is more than *most* states.

        They share nothing with these.

        Args:
            process, trace, most, budget: what is followed, and how far.
            goal: if given, one run is enough that ends in a state with such transitions.
        """

        def poll(_: int) -> None:
            budget.check_time("following a trace")

        found = along(process, trace, most, poll) if goal is None else one_run(process, trace, goal, most, poll)
        return None if found is None else self._of_part(process, found)

    def _of_part(self, process: Process, part: Explored) -> Machines:
        """Machines for which *process* is a part of what it is."""
        others = Machines(
            workers=self.workers, full=self.full, reduces=False, progress=self._progress, notify=self._notify
        )
        others._beginnings[process] = pack(compile_single(process, part))
        return others

    def _listed(self, compiler: Compiler, process: Process, budget: Budget) -> Lts:
        """The explicit machine of a part of a process, which is not kept.

        Raises:
            Incomplete: a limit was reached.
            LimitReached: a component has more states than the limit.
        """
        exploration = explore(
            pack(compiler.network(process, budget.limits, lambda _: budget.check_time())),
            limits=budget.remaining(),
            workers=self.workers,
            look_for_divergence=False,
            notify=self._notify,
        )
        if not exploration.complete:
            what = f" while {told(doing()[-1])}" if doing() else ""
            raise Incomplete(
                f"{budget.reached(exploration)}{what}: {coverage(exploration)}",
                exploration.levels[-1],
                exploration.transitions,
            )
        return exploration.to_lts()

    def _in_company(self, composition: LazyComposition, limits: Limits, poll: Poll | None) -> Network:
        """The network of a composition with what the whole gets to see of what is chased in it.

        Raises:
            LimitReached: the whole has more states than the limit, or than there is memory for.
        """
        free = limits.memory_bytes if limits.memory_bytes is not None else MOST_IN_COMPANY

        def has_room(states: int, size: int) -> bool:
            return size <= free and (limits.states is None or states <= limits.states)

        try:
            return together(composition, has_room, poll)
        except TooLarge as large:
            raise beyond(composition.process, large.states) from None

    def first_look(self, process: Process, aim: Aim, budget: Budget) -> Exploration | None:
        """The exploration of a process that needs few states; None if it is better reduced before it is searched on."""
        if not self.reduces:
            return None
        whole: Exploration | None = self._find(("exploration", process, "everything", False))
        if whole is not None and whole.complete:
            return whole
        if aim == "deadlock" and len(self.network(process, budget).slots) > MANY_COMPONENTS:
            return None
        return self._look(("first look", process, aim), process, aim, budget, FIRST_LOOK)

    def second_look(self, process: Process, aim: Aim, budget: Budget) -> Exploration | None:
        """The exploration of a process in which something was found when it was reduced; None if it is too large.

        So what is told of it does not depend on its having been reduced.
        """
        if len(self.network(process, budget).slots) > MANY_COMPONENTS:
            return None
        return self._look(("second look", process, aim), process, aim, budget, SECOND_LOOK)

    def _look(
        self, key: tuple[object, ...], process: Process, aim: Aim, budget: Budget, states: int
    ) -> Exploration | None:
        found: Exploration | None = self._find(key)
        if found is None:
            # What it consists of is laid out under the limits of the assertion; only the states are few.
            found = self._explored(self.packed(process, budget), aim, budget.narrowed(states))
            if found.complete:
                key = ("exploration", process, "everything", False)
            if found.stop in (None, "found", "states"):
                self._keep(key, found, found.peak_memory_bytes)
        budget.used(found.peak_memory_bytes)
        return found if found.complete or found.stop == "found" else None

    def looked_at(self, process: Process, aim: Aim) -> Exploration | None:
        """What a first look without an answer has seen of a process."""
        found: Exploration | None = self._find(("first look", process, aim))
        return found

    def narrowed(self, packed: PackedNetwork, kept: Kept) -> PackedNetwork | None:
        """A network to be searched by partial order; None if it cannot be."""
        key = ("narrowed", packed, kept)
        if key not in self._kept:
            self._keep(key, narrowed(packed, kept), 0)
        found: PackedNetwork | None = self._find(key)
        return found

    def exploration(
        self, process: Process, aim: Aim, budget: Budget, *, original: bool = False, kept: Kept | None = None
    ) -> Exploration:
        """The reachable states of a process; all of them unless what is aimed at, or a limit, ended the search.

        A whole exploration that is there already answers every aim. With *kept* the states are those that a search by
        partial order looks at, if the process can be searched so.
        """
        original = self._differs(process) if original else False
        whole: Exploration | None = self._find(("exploration", process, "everything", original))
        if whole is not None and whole.complete:
            budget.used(whole.peak_memory_bytes)
            return whole
        if self.full:
            aim = "everything"
        packed = self.packed(process, budget, original=original)
        fewer = None if kept is None else self.narrowed(packed, kept)
        key = ("exploration", process, aim, original) if fewer is None else ("by partial order", process, aim, kept)
        found: Exploration | None = self._find(key)
        if found is None:
            found = explore(
                fewer or packed,
                limits=budget.remaining(),
                workers=self.workers,
                stop_at_deadlock="deadlock" in aim,
                stop_at_divergence="divergence" in aim,
                look_for_divergence=fewer is None or kept != "deadlocks",
                progress=self._progress,
                notify=self._notify,
                checkpoints=self._checkpoints,
                beyond=self.beyond,
            )
            if found.complete and fewer is None:
                key = ("exploration", process, "everything", original)
            # How far a search gets in a time is no property of the machine: the next assertion may get further.
            if found.complete or found.stop in ("found", "states"):
                self._keep(key, found, found.peak_memory_bytes)
        budget.used(found.peak_memory_bytes)
        return found

    def _explored(self, packed: PackedNetwork, aim: Aim, budget: Budget) -> Exploration:
        return explore(
            packed,
            limits=budget.remaining(),
            workers=self.workers,
            stop_at_deadlock="deadlock" in aim,
            stop_at_divergence="divergence" in aim,
            progress=self._progress,
            notify=self._notify,
        )

    def _differs(self, process: Process) -> bool:
        """Whether a process may have more states than it has with its components compressed."""
        packed: PackedNetwork | None = self._find(("packed", process, False))
        return not self.full and (packed is None or packed.network.is_compressed)

    def lts(self, process: Process, budget: Budget, part: str = "", *, original: bool = False) -> Lts:
        """The explicit machine of a process.

        Args:
            process: the process.
            budget: what may be used.
            part: what the process is to the assertion, for the message: `` of the specification``.
            original: whether compressed components are to have all their states.

        Raises:
            Incomplete: a limit was reached.
        """
        original = self._differs(process) if original else False
        key = ("lts", process, original)
        found: Lts | None = self._find(key)
        if found is None:
            exploration = self.exploration(process, "everything", budget, original=original)
            if not exploration.complete:
                raise Incomplete(
                    f"{budget.reached(exploration)}{part}: {coverage(exploration)}",
                    exploration.levels[-1],
                    exploration.transitions,
                )
            needed = 8 * (exploration.levels[-1] + 1) + 16 * exploration.transitions
            memory = budget.limits.memory_bytes
            if exploration.is_partial or (memory is not None and needed > memory):
                raise Incomplete(
                    f"{budget.memory_reached()}{part}: its {exploration.levels[-1]:,} states take {needed:,} bytes",
                    exploration.levels[-1],
                    exploration.transitions,
                )
            with during(f"listing the {exploration.levels[-1]:,} states of a machine"):
                found = exploration.to_lts()
            self._keep(key, found, needed)
        budget.used(found.offsets.nbytes + found.labels.nbytes + found.targets.nbytes)
        return found

    def followed(
        self, process: Process, model: NormalModel, implementation: Process, budget: Budget
    ) -> LazySpecification:
        """The normal form of a process that grows as a search reaches it, for the first states of the process only.

        A search that needs more of them ends in :class:`Incomplete`.
        """
        why = Incomplete("", FOLLOWED_FIRST)
        return self._lazy(process, model, implementation, budget, FOLLOWED_FIRST, why, FOLLOWED_EFFORT)

    def _lazy(
        self,
        process: Process,
        model: NormalModel,
        implementation: Process,
        budget: Budget,
        most: int,
        why: Incomplete,
        effort: int | None = None,
    ) -> LazySpecification:
        alphabet = self.packed(implementation, budget).events[1:]
        return LazySpecification(
            process, model, alphabet, most, why, lambda: budget.check_time("exploring the specification"), effort
        )

    def specification(
        self, process: Process, model: NormalModel, implementation: Process, budget: Budget
    ) -> Specification:
        """The normal form of a process: whole where that is cheap, else one that grows as a search reaches it.

        Args:
            process: the specification.
            model: what it is to be compared in.
            implementation: what it is to be compared with, which matters where the specification is too large to be
                explored by itself.
            budget: what may be used.

        Raises:
            Incomplete: there was no time to explore the specification.
        """
        key = ("normal form", process, model)
        found: NormalForm | Normaliser | None = self._find(key)
        if found is None:
            try:
                lts = self._specified(process, model, budget)
            except Incomplete as incomplete:
                if budget.is_over():
                    raise
                most = MOST_TERMS if budget.limits.states is None else budget.limits.states
                return self._lazy(process, model, implementation, budget, most, incomplete)
            with during("normalising the specification"):
                if is_deterministic(lts):
                    found = normalise(lts, model, minimise=not self.full)
                elif self.full:
                    found = Normaliser(lts, model)
                else:
                    found = _whole_or_lazy(lts, model, budget)
            self._keep(key, found, _size(found))
        budget.used(_size(found))
        return found

    def _specified(self, process: Process, model: NormalModel, budget: Budget) -> Lts:
        """The machine of a specification, or a smaller one that says the same.

        Raises:
            Incomplete: a limit was reached.
        """
        if self.reduces and self.first_look(process, "everything", budget) is None:
            packed = self.packed(process, budget)
            small = reduced(packed.network, model_for(packed, model), as_they_are, budget)
            if small is not None:
                exploration = self._explored(small.packed, "everything", budget)
                if exploration.complete:
                    return exploration.to_lts()
        return self.lts(process, budget, " in the specification")

    def pairs(
        self,
        specification: Specification,
        process: Process,
        model: NormalModel,
        budget: Budget,
        *,
        full: bool,
        original: bool = False,
        at_hand: bool = False,
    ) -> PairExploration:
        """The reachable pairs of a specification's node and a state of *process*. Not kept.

        Args:
            specification, process, model: what is compared.
            budget: what may be used.
            full: whether to go on after a violation.
            original: whether compressed components are to have all their states.
            at_hand: whether all pairs must be in memory afterwards, also those that lead to nothing.

        Raises:
            Incomplete: a lazy specification ran into a limit.
        """
        packed = self.packed(process, budget, original=original)
        return self.pairs_of(packed, specification, model, budget, full=full, at_hand=at_hand)

    def pairs_of(
        self,
        packed: PackedNetwork,
        specification: Specification,
        model: NormalModel,
        budget: Budget,
        *,
        full: bool,
        at_hand: bool = False,
        deepest: int | None = None,
    ) -> PairExploration:
        """The reachable pairs of a specification's node and a state of a network; see :meth:`pairs`.

        After traces of more events than the *deepest* has they are not looked at.
        """
        found = explore_pairs(
            packed,
            specification,
            model,
            full=full,
            deepest=deepest,
            limits=budget.remaining(),
            workers=self.workers,
            progress=self._progress,
            notify=self._notify,
            checkpoints=self._checkpoints,
            beyond=None if at_hand else self.beyond,
        )
        budget.used(found.peak_memory_bytes + _size(specification))
        return found

    def _find(self, key: Hashable) -> Any:
        entry = self._kept.get(key)
        if entry is None:
            return None
        self._kept.move_to_end(key)
        return entry[0]

    def _keep(self, key: Hashable, value: Any, size: int) -> None:
        self._kept[key] = (value, size)
        total = sum(size for _, size in self._kept.values())
        for old in list(self._kept)[:-1]:
            if total <= self._kept_bytes:
                break
            _, size = self._kept[old]
            if size:
                total -= size
                del self._kept[old]


class _TooManyNodes(Exception):
    """A normal form is not worth having as a whole."""


def _whole_or_lazy(lts: Lts, model: NormalModel, budget: Budget) -> NormalForm | Normaliser:
    def poll(nodes: int) -> None:
        budget.check_time()
        if nodes > WHOLE_NORMAL_FORM:
            raise _TooManyNodes

    try:
        return normalise(lts, model, poll=poll)
    except _TooManyNodes:
        return Normaliser(lts, model)


def _size(specification: Specification) -> int:
    """About how many bytes a normal form takes; of one that grows in terms nobody knows."""
    if isinstance(specification, NormalForm):
        arrays = (specification.offsets, specification.columns, specification.targets, specification.acceptance_set)
        return sum(array.nbytes for array in arrays)
    return specification.nbytes if isinstance(specification, Normaliser) else 0
