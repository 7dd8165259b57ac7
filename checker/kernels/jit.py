"""The kernels in both forms: interpreted at once, or as machine code, which takes a moment to load.

Both are made from the same functions. Interpreted kernels read memory views of the arrays, whose elements are
Python integers; machine code the arrays themselves.
"""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from threading import Lock
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cspcheck.checker.kernels import (
    arrays as kernels_arrays,
    company as kernels_company,
    diamonds as kernels_diamonds,
    expand as kernels_expand,
    levels as kernels_levels,
    machine_code,
    pairs as kernels_pairs,
    partition as kernels_partition,
    runs as kernels_runs,
    stubborn as kernels_stubborn,
    subsets as kernels_subsets,
    table as table_kernels,
    taus as kernels_taus,
)

T = TypeVar("T")

MODULES: tuple[ModuleType, ...] = (
    table_kernels,
    kernels_stubborn,
    kernels_expand,
    kernels_pairs,
    kernels_levels,
    kernels_partition,
    kernels_runs,
)
"""Where the kernels are, callees before callers."""

TAU_MODULES: tuple[ModuleType, ...] = (
    table_kernels,
    kernels_partition,
    kernels_subsets,
    kernels_taus,
    kernels_diamonds,
    kernels_company,
)
"""Where those are that follow taus, and what they call. Most checks do without them, and without making them."""

ONE_WORD = ({"stride": 1},)
ONE_WORD_STATES = ({"words": 1, "stride": 1},)

ENTRIES: machine_code.Entries = {
    "insert": ONE_WORD,
    "find": ONE_WORD,
    "enter_all": (),
    "sort_by_owner": ({"stride": 1, "owners": 2}, {"stride": 1}),
    "sort_by_rank": ONE_WORD,
    "move": (),
    "expand": ONE_WORD_STATES,
    "follow": (),
    "nodes_after": (),
    "note_movers": (),
    "count_deadlocks": (),
    "count_arrivals": (),
    "peel": (),
    "strong_components": (),
    "coarsest": (),
    "rows_before": (),
    "unite": (),
    "sift": (),
}
"""The kernels that are called from outside, each with the arguments for which a copy of its own pays."""

TAU_ENTRIES: machine_code.Entries = {
    "enter_slots": (),
    "extend_nodes": (),
    "node_of_states": (),
    "reach": (),
    "saturate": (),
    "diamonds": (),
    "refine_by_signatures": (),
    "least_keys": (),
    "expand_together": ONE_WORD,
    "chase_taus": (),
}
"""Those of them that are called from outside."""

Kernel = Callable[..., Any]


class Kernels:
    """The kernels as attributes, by their names.

    Attributes:
        compiled: whether they are machine code (which can run in threads).
    """

    def __init__(self, functions: Mapping[str, Kernel], *, compiled: bool) -> None:
        self._functions = functions
        self.compiled = compiled

    if TYPE_CHECKING:  # so that calls are checked like those of the functions that they are
        insert = staticmethod(table_kernels.insert)
        find = staticmethod(table_kernels.find)
        enter_all = staticmethod(table_kernels.enter_all)
        sort_by_owner = staticmethod(table_kernels.sort_by_owner)
        sort_by_rank = staticmethod(table_kernels.sort_by_rank)
        move = staticmethod(table_kernels.move)
        expand = staticmethod(kernels_expand.expand)
        follow = staticmethod(kernels_pairs.follow)
        nodes_after = staticmethod(kernels_pairs.nodes_after)
        note_movers = staticmethod(kernels_levels.note_movers)
        count_deadlocks = staticmethod(kernels_levels.count_deadlocks)
        count_arrivals = staticmethod(kernels_levels.count_arrivals)
        peel = staticmethod(kernels_levels.peel)
        strong_components = staticmethod(kernels_levels.strong_components)
        coarsest = staticmethod(kernels_partition.coarsest)
        rows_before = staticmethod(kernels_runs.rows_before)
        unite = staticmethod(kernels_runs.unite)
        sift = staticmethod(kernels_runs.sift)
        enter_slots = staticmethod(kernels_subsets.enter_slots)
        extend_nodes = staticmethod(kernels_subsets.extend_nodes)
        node_of_states = staticmethod(kernels_subsets.node_of_states)
        reach = staticmethod(kernels_taus.reach)
        saturate = staticmethod(kernels_taus.saturate)
        diamonds = staticmethod(kernels_diamonds.diamonds)
        refine_by_signatures = staticmethod(kernels_taus.refine_by_signatures)
        least_keys = staticmethod(kernels_taus.least_keys)
        expand_together = staticmethod(kernels_company.expand_together)
        chase_taus = staticmethod(kernels_company.chase_taus)

    def __getattr__(self, name: str) -> Kernel:
        if name not in self._functions:
            raise AttributeError(name)
        function = self._functions[name]
        setattr(self, name, function)
        return function


def kernels(compiled: bool, notify: Callable[[str], None] | None = None) -> Kernels:
    """The kernels.

    Args:
        compiled: in which form.
        notify: called with one line when they have to be compiled first.
    """
    return _loaded(compiled) if notify is None else _loaded(compiled, notify)


def is_loaded() -> bool:
    """Whether this process has the compiled kernels already."""
    return True in _forms


def tau_kernels(compiled: bool) -> Kernels:
    """The kernels that follow taus, in either form."""
    found = _tau_forms.get(compiled)
    if found is None:
        made = _made_apart("tau kernels", _compiled_tau_kernels) if compiled else _interpreted(TAU_MODULES)
        found = _tau_forms.setdefault(compiled, made)
    return found


def tau_kernels_are_loaded() -> bool:
    """Whether this process has the compiled ones already."""
    return True in _tau_forms


_forms: dict[bool, Kernels] = {}
_tau_forms: dict[bool, Kernels] = {}
_making = Lock()
_at_work: dict[str, machine_code.Apart[Any]] = {}


def _loaded(compiled: bool, notify: Callable[[str], None] = lambda line: None) -> Kernels:
    found = _forms.get(compiled)
    if found is None:
        made = _made_apart("kernels", lambda: _compiled(notify)) if compiled else _interpreted(MODULES)
        found = _forms.setdefault(compiled, made)
    return found


def _made_apart(name: str, make: Callable[[], T]) -> T:
    """What *make* gives in a thread of its own; who asks while it is at work waits for the same."""
    with _making:
        work = _at_work.get(name)
        if work is None or work.process != os.getpid():
            work = _at_work[name] = machine_code.Apart(make)
    try:
        made: T = work.result()
        return made
    finally:
        if work.has_ended:  # else whoever waited was stopped, and the next to ask waits on
            _at_work.pop(name, None)


def _interpreted(modules: Sequence[ModuleType]) -> Kernels:
    functions = {function.__name__: _on_views(function) for function in _source_functions(modules)}
    return Kernels(functions, compiled=False)


def _source_functions(modules: Sequence[ModuleType]) -> Iterator[FunctionType]:
    for module in modules:
        yield from module.KERNELS


def _on_views(function: FunctionType) -> Kernel:
    """The function, called with memory views instead of arrays."""

    def call(*arguments: Any) -> Any:
        # Written out, for there are so many calls with a few rows each.
        return function(
            *[a.data if type(a) is np.ndarray else _view(a) if isinstance(a, tuple) else a for a in arguments]
        )

    return call


def _view(argument: Any) -> Any:
    if type(argument) is np.ndarray:
        return argument.data
    if not isinstance(argument, tuple):
        return argument
    # The tables of a machine are handed over at every call, and there are many calls with a few rows each.
    known = _views.get(id(argument))
    if known is not None and known[0] is argument:
        return known[1]
    if len(_views) >= VIEWS:
        _views.clear()
    view = type(argument)(*map(_view, argument))
    _views[id(argument)] = argument, view
    return view


VIEWS = 64
"""So many tuples of arrays are kept with the views of them."""

_views: dict[int, tuple[Any, Any]] = {}
"""By the identity of the tuple, which is kept, so that no other can have it."""


def _compiled(notify: Callable[[str], None]) -> Kernels:
    made = _linked(MODULES, ENTRIES, notify, wide=False)
    wide: list[machine_code.Linked] = []

    def widely() -> machine_code.Linked:
        """The kernels for tables of 64-bit entries, which hardly any machine has the memory for."""
        if not wide:
            work = partial(_linked, MODULES, ENTRIES, lambda line: None, wide=True)
            wide.append(_made_apart("wide kernels", work))
        return wide[0]

    functions = {
        function.__name__: machine_code.Caller(function, made, widely)
        for function in _source_functions(MODULES)
        if function.__name__ in ENTRIES
    }
    return Kernels(functions, compiled=True)


def _compiled_tau_kernels() -> Kernels:
    made = _linked(TAU_MODULES, TAU_ENTRIES, lambda line: None, wide=False)
    functions = {
        function.__name__: machine_code.Caller(function, made)
        for function in _source_functions(TAU_MODULES)
        if function.__name__ in TAU_ENTRIES
    }
    return Kernels(functions, compiled=True)


def _linked(
    modules: Sequence[ModuleType], entries: machine_code.Entries, notify: Callable[[str], None], *, wide: bool
) -> machine_code.Linked:
    from cspcheck.checker.kernels import translated_types, translation

    sources = (*modules, kernels_arrays, translated_types, translation, machine_code, sys.modules[__name__])
    place = machine_code.place_for([*map(inspect.getsource, sources), f"wide: {wide}"])
    kept = "once" if place is not None else "there is no folder to keep them in"
    return machine_code.linked(
        place, modules, entries, lambda: notify(f"compiling the search kernels for this machine; {kept}"), wide
    )


COMPILED_ROWS = 2_000
"""For more rows than this it pays to load the compiled kernels."""


def kernels_for(rows: int) -> Kernels:
    """The kernels in the form that suits the number of rows that they are to expand."""
    return kernels(is_loaded() or rows > COMPILED_ROWS)


COMPILED_TAU_ROWS = 200
"""And for more than this those that follow taus: what they do with a row may be much."""


def tau_kernels_for(rows: int) -> Kernels:
    """The kernels that follow taus, in the form that suits the number of states that they are to look at."""
    return tau_kernels(tau_kernels_are_loaded() or rows > COMPILED_TAU_ROWS)
