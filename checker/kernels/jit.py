"""The kernels in both forms: interpreted at once, or compiled by numba, which takes a moment to load.

Both are made from the same functions. Interpreted kernels read memory views of the arrays, whose elements are
Python integers; compiled ones the arrays themselves. Machine code is kept in the user's cache folder, below a name
that stands for the text of the kernels: numba by itself does not notice a change in a function that another file's
function calls.
"""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, get_type_hints

import numpy as np

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.kernels import (
    expand as kernels_expand,
    levels as kernels_levels,
    machine_code,
    pairs as kernels_pairs,
    partition as kernels_partition,
    runs as kernels_runs,
    table as table_kernels,
)
from cspcheck.checker.kernels.arrays import Rules
from cspcheck.cspm.caches import tell

MODULES: tuple[ModuleType, ...] = (
    table_kernels,
    kernels_expand,
    kernels_pairs,
    kernels_levels,
    kernels_partition,
    kernels_runs,
)
"""Where the kernels are, callees before callers."""

ENTRIES = (
    "insert",
    "find",
    "enter_all",
    "sort_by_owner",
    "sort_by_rank",
    "claim",
    "settle",
    "expand",
    "follow",
    "nodes_after",
    "note_movers",
    "count_deadlocks",
    "count_arrivals",
    "peel",
    "strong_components",
    "coarsest",
    "rows_before",
    "unite",
    "sift",
)
"""The kernels that are called from outside."""

COMPILATION_SECONDS = 20
"""How long the first compilation takes, about."""

Kernel = Callable[..., Any]


class Kernels:
    """The kernels as attributes, by their names.

    Attributes:
        compiled: whether they are machine code (which can run in threads).
    """

    def __init__(
        self, functions: Mapping[str, Kernel], *, compiled: bool, load: Callable[[str], None] = lambda name: None
    ) -> None:
        """*load* is called with the name of a kernel before it is used for the first time."""
        self._functions = functions
        self._load = load
        self.compiled = compiled

    if TYPE_CHECKING:  # so that calls are checked like those of the functions that they are
        insert = staticmethod(table_kernels.insert)
        find = staticmethod(table_kernels.find)
        enter_all = staticmethod(table_kernels.enter_all)
        sort_by_owner = staticmethod(table_kernels.sort_by_owner)
        sort_by_rank = staticmethod(table_kernels.sort_by_rank)
        claim = staticmethod(table_kernels.claim)
        settle = staticmethod(table_kernels.settle)
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

    def __getattr__(self, name: str) -> Kernel:
        if name not in self._functions:
            raise AttributeError(name)
        self._load(name)
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


_forms: dict[bool, Kernels] = {}


def _loaded(compiled: bool, notify: Callable[[str], None] = lambda line: None) -> Kernels:
    if compiled not in _forms:
        _forms[compiled] = _compiled(notify) if compiled else _interpreted()
    return _forms[compiled]


def _interpreted() -> Kernels:
    functions = {function.__name__: _on_views(function) for function in _source_functions()}
    return Kernels(functions, compiled=False)


def _source_functions() -> Iterator[FunctionType]:
    for module in MODULES:
        yield from module.KERNELS


def _on_views(function: FunctionType) -> Kernel:
    """The function, called with memory views instead of arrays."""

    def call(*arguments: Any) -> Any:
        return function(*map(_view, arguments))

    return call


def _view(argument: Any) -> Any:
    if isinstance(argument, np.ndarray):
        return argument.data
    if isinstance(argument, tuple):
        return type(argument)(*map(_view, argument))
    return argument


def _compiled(notify: Callable[[str], None]) -> Kernels:
    import numba

    folder = machine_code.folder_for(_fingerprint(numba.__version__))
    if folder is not None and not machine_code.is_ready(folder):
        notify(f"{_COMPILING}, once, about {COMPILATION_SECONDS} s")
        if not machine_code.compile_elsewhere(folder, ENTRIES):
            folder = None
    if folder is None:
        notify(f"{_COMPILING}; there is no folder to keep them in")
        return _read_or_made(numba, _dispatchers(numba, caching=False), None)
    with _numba_caching_in(numba.config, folder):
        functions = _dispatchers(numba, caching=True)
    return _read_or_made(numba, functions, folder)


_COMPILING = "compiling the search kernels for this machine"


def _read_or_made(numba: Any, functions: dict[str, Any], folder: Path | None) -> Kernels:
    """The kernels, each with its machine code read (or made) when it is first used."""

    def load(name: str) -> None:
        if name not in ENTRIES:
            return
        signature = _signature(numba, _source(name))
        try:
            machine_code.uninterrupted(lambda: functions[name].compile(signature))
        except Exception as error:
            if folder is None:
                raise
            # As it was made, and yet nothing that these libraries can read: they have changed under the same version.
            tell(f"the compiled kernels in `{folder}` cannot be read ({type(error).__name__}) and are made anew")
            machine_code.remove(folder)
            functions.update(_dispatchers(numba, caching=False))
            machine_code.uninterrupted(lambda: functions[name].compile(signature))

    return Kernels(functions, compiled=True, load=load)


def _source(name: str) -> FunctionType:
    """The function that a kernel is made from; a dispatcher's own is a copy without the module's names."""
    return next(function for function in _source_functions() if function.__name__ == name)


def compile_into(folder: Path, names: Iterable[str] = ENTRIES) -> None:
    """Compile kernels and keep the machine code in a folder."""
    import numba

    with _numba_caching_in(numba.config, folder):
        functions = _dispatchers(numba, caching=True)
        for name in names:
            functions[name].compile(_signature(numba, _source(name)))


def _fingerprint(version: str) -> str:
    from llvmlite.binding import get_host_cpu_name

    digest = hashlib.sha256(f"{version} {sys.version_info[:2]} {sys.platform} {get_host_cpu_name()}".encode())
    for module in (*MODULES, sys.modules[__name__], sys.modules[Rules.__module__]):
        digest.update(inspect.getsource(module).encode())
    return digest.hexdigest()[:16]


@contextmanager
def _numba_caching_in(config: Any, folder: Path) -> Iterator[None]:
    """Have numba keep what is decorated meanwhile in a folder."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before


def _machine_product(a: Any, b: Any) -> Any:
    """What ``wrapping_product`` is for the machine."""
    return np.int64(np.uint64(a) * np.uint64(b) & np.uint64(0x7FFFFFFFFFFFFFFF))


def _machine_prefetch(numba: Any) -> Any:
    """What ``prefetch`` is for the machine."""
    from llvmlite import ir

    def prefetch(context: Any, array: Any, index: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            view = context.make_array(signature.args[0])(context, builder, arguments[0])
            byte = ir.IntType(8).as_pointer()
            number = ir.IntType(32)
            kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
            function = numba.core.cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
            place = builder.bitcast(builder.gep(view.data, [arguments[1]]), byte)
            builder.call(function, [place, number(0), number(3), number(1)])
            return context.get_dummy_value()

        return numba.types.void(array, index), generate

    return numba.extending.intrinsic(prefetch)


def _dispatchers(numba: Any, caching: bool) -> dict[str, Any]:
    """Each kernel as a numba function that sees the others as numba functions."""
    jit = numba.njit(nogil=True, cache=caching, error_model="numpy")
    inlined = numba.njit(nogil=True, cache=caching, error_model="numpy", forceinline=True)
    compiled: dict[str, Any] = {"wrapping_product": inlined(_machine_product), "prefetch": _machine_prefetch(numba)}
    for function in _source_functions():
        surroundings = {**function.__globals__, **compiled}
        copy = FunctionType(function.__code__, surroundings, function.__name__, function.__defaults__)
        copy.__module__ = function.__module__
        copy.__qualname__ = function.__qualname__
        compiled[function.__name__] = jit(copy) if function.__name__ in ENTRIES else inlined(copy)
    return compiled


def _signature(numba: Any, function: FunctionType) -> tuple[Any, ...]:
    """The types that a kernel is always called with: those of its annotations."""
    hints = get_type_hints(function)
    return tuple([numba.typeof(_example(hints[name])) for name in inspect.signature(function).parameters])


def _example(kind: Any) -> Any:
    """A value of the type that an annotation names: an integer, an array, or a tuple of them."""
    dtypes: dict[Any, type[np.generic]] = {Int64Array: np.int64, Int32Array: np.int32, UInt8Array: np.uint8}
    if kind in dtypes:
        return np.zeros(1, dtype=dtypes[kind])
    if kind in (int, bool):
        return 0
    return kind(*map(_example, get_type_hints(kind).values()))


COMPILED_ROWS = 2_000
"""For more rows than this it pays to load the compiled kernels."""


def kernels_for(rows: int) -> Kernels:
    """The kernels in the form that suits the number of rows that they are to expand."""
    return kernels(is_loaded() or rows > COMPILED_ROWS)
