"""Compilation of CasADi functions: calls through their buffers, and shared libraries of generated C.

An ordinary CasADi call converts its arguments and allocates its results, which takes 20 to 40 microseconds. Through the
*buffer* interface memory is bound once and a call only evaluates the function. With a C compiler the function can be
evaluated as generated C instead of on CasADi's virtual machine.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from jtik.symbolic.compilation import library_cache
from jtik.symbolic.compilation.archives import Archive
from jtik.symbolic.compilation.c_compiler import (
    CompilerError,
    CompilerRuns,
    compile_library,
    compiler,
    instructions,
    options,
    version,
)
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.operations import Function, external
from jtik.types import Array

__all__ = [
    "Beside",
    "CompiledFunction",
    "CompilerError",
    "Library",
    "bind",
    "compiler",
    "library",
    "plain_libraries",
    "plain_library",
    "to_c",
]

T = TypeVar("T")


def bind(function: Function, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
    """A call without arguments that evaluates a function on memory that is bound once.

    Every array is one-dimensional, contiguous float64, with the elements of a matrix in column-major order. The call
    keeps the arrays alive.

    Args:
        function: the function.
        arguments: memory of each input; empty arrays for empty inputs.
        results: memory of each output, which the call overwrites.
    """
    buffer, evaluate = function.buffer()
    for set_memory, arrays in ((buffer.set_arg, arguments), (buffer.set_res, results)):
        for position, array in enumerate(arrays):
            if array.size:
                set_memory(position, array.data)
    evaluate.memory = (buffer, *arguments, *results)
    return cast(Callable[[], None], evaluate)


class CompiledFunction:
    """A function with memory of its own, called through its buffer: about a microsecond more than the arithmetic.

    It is called with one array for each input and returns one new array (rows, columns) for each output.

    Args:
        function: the function to call.
    """

    def __init__(self, function: Function) -> None:
        self._function = function
        self._arguments = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self._results = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        self._shapes = [function.size_out(i) for i in range(function.n_out())]
        self._evaluate = bind(function, self._arguments, self._results)

    def __call__(self, *arguments: Any) -> tuple[Array, ...]:
        """One new array (rows, columns) for each output."""
        for memory, argument in zip(self._arguments, arguments, strict=True):
            memory[:] = np.asarray(argument, dtype=float).ravel(order="F")
        self._evaluate()
        return tuple(
            result.reshape(shape, order="F").copy() for result, shape in zip(self._results, self._shapes, strict=True)
        )


class Beside(NamedTuple):
    """What is compiled with a function, into the same library.

    Attributes:
        source: more C; it calls the function JTIK_NAME.
        functions: functions that it calls. The name of each begins with that of the function, which is replaced by
            JTIK_NAME: ``jtik_step_box`` is JTIK_NAME_box.
    """

    source: str = ""
    functions: tuple[Function, ...] = ()


NOTHING = Beside()
"""Nothing beside a function."""


class Library(NamedTuple):
    """A function in generated C.

    Attributes:
        function: the function as CasADi calls it.
        name: its name in the library.
        loaded: the shared library, whose other functions are called through ctypes.
        path: path of the shared library.
    """

    function: Function
    name: str
    loaded: ctypes.CDLL
    path: str


def to_c(function: Function) -> Function:
    """The same function as a shared library of generated C, three to five times faster than the virtual machine.

    See `library`, which also returns the path.

    Args:
        function: the function to compile.

    Raises:
        CompilerError: when there is no compiler, it fails, or the library cannot be stored or loaded.
    """
    return library(function).function


def library(
    function: Function,
    beside: Beside = NOTHING,
    archive: Archive | None = None,
    *,
    runs: CompilerRuns | None = None,
    using_casadi: AbstractContextManager[Any] | None = None,
) -> Library:
    """The function as a shared library of generated C.

    Compiling takes about a second. Libraries are kept in the user's cache folder (``$XDG_CACHE_HOME/jtik``, see
    `jtik.symbolic.compilation.library_cache`) under the hash of their code, the compiler and its version, the machine,
    the instructions that it has and the version of jtik, so that an unchanged function is compiled once. The compiler
    is ``$CC``, ``clang``, that of the package ``ziglang`` (extra ``native``), ``gcc`` or ``cc``.

    Args:
        function: the function.
        beside: what is compiled with it.
        archive: a static library that the C calls; None for none.
        runs: runs the compiler, and can end it.
        using_casadi: is entered while CasADi is used, not while the compiler runs.

    Raises:
        CompilerError: when there is no compiler, it fails, or the library cannot be stored or loaded.
    """
    using = using_casadi or nullcontext()
    with using:
        source = c_source(function, *beside.functions) + beside.source
    return _library(source, function.name(), archive, runs, using, _loaded, instructions())


def plain_libraries(sources: Sequence[str], more: tuple[str, ...] = ()) -> list[tuple[ctypes.CDLL, str]]:
    """Several of `plain_library`, compiled at the same time; Ctrl-C ends all compilers.

    Args:
        sources: the sources.
        more: more options for the compiler.

    Raises:
        CompilerError: when there is no compiler, it fails, or a library cannot be stored or loaded.
    """
    runs = CompilerRuns()
    with ThreadPoolExecutor(len(sources)) as pool:
        try:
            return list(pool.map(lambda source: plain_library(source, more, runs), sources))
        except BaseException:
            runs.end()
            raise


def plain_library(source: str, more: tuple[str, ...] = (), runs: CompilerRuns | None = None) -> tuple[ctypes.CDLL, str]:
    """C source as a shared library, kept as those of `library` are, and what JTIK_NAME stands for in it.

    Args:
        source: the source; its own names begin with JTIK_NAME.
        more: more options for the compiler.
        runs: runs the compiler, and can end it.

    Raises:
        CompilerError: when there is no compiler, it fails, or the library cannot be stored or loaded.
    """

    def load(name: str, path: Path) -> tuple[ctypes.CDLL, str]:
        return ctypes.CDLL(str(path)), name

    return _library(source, "JTIK_NAME", None, runs, nullcontext(), load, more)


def _library(
    source: str,
    replaced: str,
    archive: Archive | None,
    runs: CompilerRuns | None,
    using: AbstractContextManager[Any],
    load: Callable[[str, Path], T],
    more: tuple[str, ...] = (),
) -> T:
    """What ``load`` makes of the library of a source, in which the name of the library replaces another."""
    import hashlib

    command = compiler()
    machine = (sys.platform, platform.machine(), sys.maxsize, sys.modules["jtik"].__version__)
    linked = archive and hashlib.sha256(archive.file.read_bytes()).hexdigest()
    depends = repr((command, (*options(command), *more), version(command, runs), machine, source, linked))
    name = "jtik_" + hashlib.sha256(depends.encode()).hexdigest()[:32]

    def build(scratch: Path) -> Path:
        code, built = scratch / f"{name}.c", scratch / f"{name}.so"
        # the prefix keeps the symbols of several libraries, and libc's own "step", apart
        code.write_text(source.replace(replaced, name).replace("JTIK_NAME", name), encoding="utf-8")
        compile_library(command, code, built, archive, runs, more)
        return built

    path = library_cache.find_or_build(name, build)
    try:
        with using:
            return load(name, path)
    except (OSError, RuntimeError) as error:
        if not path.exists():  # another process has just deleted it
            path = library_cache.find_or_build(name, build)
            with using:
                return load(name, path)
        library_cache.forget(path)
        reason = f"{' '.join(str(error).split())}; the folder is another one with XDG_CACHE_HOME"
        raise CompilerError(f"{path}, made by {' '.join(command)}, cannot be loaded", reason) from error


def _loaded(name: str, path: Path) -> Library:
    return Library(external(name, str(path)), name, ctypes.CDLL(str(path)), str(path))
