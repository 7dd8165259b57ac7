"""Machine code of the kernels: made by LLVM, kept in the user's cache, and called.

Making it takes about two seconds, once: the object file lies in the cache folder under a name that stands for
everything that it was made from, behind its digest, and appears there whole. So any number of programs may make it at
once, in whatever installation, and one that dies on the way leaves nothing. Without a place for it the code is made
in each run.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Generic, TypeVar

import numpy as np

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.guard import set_aside
from cspcheck.cspm.caches import cache_folder, seal, store, unsealed, usable
from cspcheck.cspm.interruption import during

T = TypeVar("T")

WAIT = 0.02
"""Seconds between two looks at whether the compiler has ended."""

Entries = Mapping[str, Sequence[Mapping[str, int]]]
"""The kernels that are called from outside; see ``cspcheck.checker.kernels.translation``."""

DTYPES: Mapping[Any, np.dtype[Any]] = {
    Int64Array: np.dtype(np.int64),
    Int32Array: np.dtype(np.int32),
    UInt8Array: np.dtype(np.uint8),
}


class Linked:
    """Machine code in this process, and the addresses of its entries."""

    def __init__(self, code: bytes, entries: Iterable[str]) -> None:
        """*entries*: the functions of the machine code that are called from outside."""
        llvm = _llvm()
        # The engine wants a module of its own before it takes object files.
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine(llvm))
        self._object = llvm.ObjectFileRef.from_data(code)
        self._engine.add_object_file(self._object)
        self._engine.finalize_object()
        self.addresses: Mapping[str, int] = {name: self._engine.get_function_address(name) for name in entries}
        """Where each entry begins."""


class Caller:
    """A kernel as machine code, called as the Python function that it was made from."""

    def __init__(
        self, function: FunctionType, linked: Linked, wide: Callable[[], Linked] | None = None, *, is_wide: bool = False
    ) -> None:
        """*wide* gives the machine code of the wide kernels, for when that is needed."""
        from cspcheck.checker.kernels.translated_types import WIDE, entry_name, parameters, results

        self.__name__ = function.__name__
        self._function = function
        self._parameters = parameters(function, is_wide)
        # Found once: a type of an array takes longer to look up than its address to find.
        self._dtypes = [DTYPES.get(kind, kind) for _, kind in self._parameters]
        names = [name for name, _ in self._parameters]
        self._table = names.index(WIDE) if wide is not None and WIDE in names else -1
        self._wide = wide
        self._widely: Caller | None = None
        self._results = results(function)
        self._room = [0] * len(self._results)
        self._call = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(linked.addresses[entry_name(function.__name__)])
        self._linked = linked  # the code goes when this goes

    def __call__(self, *arguments: Any) -> Any:
        """Call it.

        Raises:
            TypeError: if the arguments are not of the types that the kernel was made for.
        """
        if 0 <= self._table < len(arguments) and arguments[self._table].dtype == np.int64 and self._wide is not None:
            if self._widely is None:
                self._widely = Caller(self._function, self._wide(), is_wide=True)
            return self._widely(*arguments)
        if len(arguments) != len(self._dtypes):
            raise TypeError(f"{self.__name__} takes {len(self._dtypes)} arguments, not {len(arguments)}")
        collected = self._room.copy()
        try:
            for dtype, argument in zip(self._dtypes, arguments, strict=True):
                if dtype is int or dtype is bool:  # so frequent that it is not left to the call
                    collected.append(argument)
                else:
                    collected += _words(dtype, argument)
            words = array("q", collected)
        except TypeError:
            raise self._wrong(arguments) from None
        self._call(words.buffer_info()[0])
        if len(self._results) == 1:
            return bool(words[0]) if self._results[0] is bool else words[0]
        return tuple(words[: len(self._results)]) if self._results else None

    def _wrong(self, arguments: Sequence[Any]) -> TypeError:
        """What is wrong with the arguments of a call, told of the first that is."""
        for (name, _), dtype, argument in zip(self._parameters, self._dtypes, arguments, strict=True):
            try:
                array("q", _words(dtype, argument))
            except TypeError as error:
                return TypeError(f"{self.__name__}, argument {name}: {error}")
        raise AssertionError(f"{self.__name__} could be called after all")


_view = (ctypes.c_char * 0).from_buffer
"""A view of any buffer: its address is had in a tenth of the time that an array's own takes to tell it."""

_address = ctypes.addressof


def _words(dtype: Any, argument: Any) -> Sequence[int]:
    """The words of an argument: a number, an array of *dtype*, or a named tuple if that is no type of arrays."""
    if dtype is int or dtype is bool:
        return (argument,)
    if not isinstance(dtype, np.dtype):
        if argument.words is None:
            argument.words = _words_of_members(dtype, argument)
        known: Sequence[int] = argument.words
        return known
    if not isinstance(argument, np.ndarray) or (argument.dtype is not dtype and argument.dtype != dtype):
        raise TypeError(f"a contiguous array of {dtype} is expected")
    try:
        return _address(_view(argument.data)), argument.size  # refuses what is not contiguous
    except (TypeError, ValueError):
        if not argument.flags.c_contiguous:
            raise TypeError(f"a contiguous array of {dtype} is expected") from None
        return argument.ctypes.data, argument.size  # an array that cannot be written to


def _words_of_members(kind: Any, argument: Any) -> Sequence[int]:
    """The words of all members of a named tuple."""
    from cspcheck.checker.kernels.translated_types import members

    words = array("q")
    for (_, member), value in zip(members(kind), argument, strict=True):
        words.extend(_words(DTYPES.get(member, member), value))
    return words


def place_for(sources: Sequence[str]) -> Path | None:
    """Where the machine code of such sources is kept; None if nothing can be."""
    base = cache_folder()
    if base is None or not usable(base):
        return None
    llvm = _llvm()
    from llvmlite import __version__

    digest = sha256(repr((__version__, llvm.llvm_version_info, sys.platform, *_processor(llvm))).encode())
    for source in sources:
        digest.update(source.encode())
    return base / f"kernels-{digest.hexdigest()[:16]}.o"


def linked(
    place: Path | None, modules: Sequence[ModuleType], entries: Entries, notify: Callable[[], None], wide: bool = False
) -> Linked:
    """The machine code of all kernels of some modules, read from its place or made and put there.

    Args:
        notify: called before it is made.
        wide: whether it is the wide kernels.
    """
    from cspcheck.checker.kernels.translated_types import entry_name

    names = [entry_name(name) for name in entries]
    code = None if place is None else unsealed(place)
    if code is not None:
        return Linked(code, names)
    notify()
    with set_aside():
        code = compiled(modules, entries, wide)
    if place is not None:
        store(place, seal(code))
    return Linked(code, names)


def compiled(modules: Sequence[ModuleType], entries: Entries, wide: bool = False) -> bytes:
    """An object file with the machine code of all kernels of some modules."""
    from cspcheck.checker.kernels.translation import translated

    llvm = _llvm()
    machine = _machine(llvm)
    module = llvm.parse_assembly(str(translated(modules, entries, wide)))
    module.triple = llvm.get_default_triple()
    module.data_layout = str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = False  # loops over a few words: it would only make them long
    options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def _llvm() -> Any:
    """LLVM, ready for this machine's processor."""
    from llvmlite import binding

    if binding.llvm_version_info < (20,):
        binding.initialize()
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


def _processor(llvm: Any) -> tuple[str, str]:
    """This machine's processor, by name and by what it can do."""
    try:
        features: str = llvm.get_host_cpu_features().flatten()
    except RuntimeError:  # LLVM does not know it for all processors
        features = ""
    return llvm.get_host_cpu_name(), features


def _machine(llvm: Any) -> Any:
    name, features = _processor(llvm)
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=name, features=features, opt=3, codemodel="jitdefault", jit=True)


class Apart(Generic[T]):
    """Work in a thread of its own: what stops or interrupts who waits for it does not arrive there.

    All that LLVM is asked for is asked in such a thread. Its library takes a lock for each call, and an exception that
    comes from outside at the wrong moment would leave that lock taken for ever.

    The end of the program waits for the thread: nothing else may take LLVM away from it.
    """

    def __init__(self, work: Callable[[], T]) -> None:
        self.process = os.getpid()
        """The process that the thread is in; there is none in those that are forked from it."""
        self._made: list[T] = []
        self._ended: list[BaseException | None] = []

        def run() -> None:
            try:
                self._made.append(work())
                self._ended.append(None)
            except BaseException as error:
                self._ended.append(error)

        threading.Thread(target=run, name="compiler").start()

    @property
    def has_ended(self) -> bool:
        """Whether it is over."""
        return bool(self._ended)

    def result(self) -> T:
        """What the work gave, once it has ended; whoever is stopped meanwhile may ask again.

        Raises:
            BaseException: the one that the work ended in.
        """
        with during("compiling the search kernels for this machine, which happens once"):
            # Not by joining the thread: CPython 3.11 counts one as ended whose joining was interrupted. The first
            # looks are close together, for mostly nothing has to be compiled.
            wait = WAIT / 64
            while not self._ended:
                time.sleep(wait)
                wait = min(2 * wait, WAIT)
        if self._ended[0] is not None:
            raise self._ended[0]
        return self._made[0]
