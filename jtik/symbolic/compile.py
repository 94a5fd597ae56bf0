"""Compilation of CasADi functions: calls through their buffers, and shared libraries of generated C.

An ordinary CasADi call converts its arguments and allocates its results, which takes 20 to 40 microseconds. Through the
*buffer* interface memory is bound once and a call only evaluates the function. With a C compiler the function can be
evaluated as generated C instead of on CasADi's virtual machine.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from jtik.errors import JtikError
from jtik.symbolic.operations import Function, c_source, external
from jtik.types import Array


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


class CompilerError(JtikError):
    """No C compiler was found, or it could not compile the generated code.

    Attributes:
        command: the command that was run, or the option that needs a compiler.
        output: what the compiler printed, or what to install.
    """

    def __init__(self, command: str, output: str) -> None:
        super().__init__(command, output)
        self.command = command
        self.output = output

    def __str__(self) -> str:
        return f"{self.command}: {self.output}"


class Library(NamedTuple):
    """A function in generated C.

    Attributes:
        function: the function as CasADi calls it.
        name: its name in the library.
        path: path of the shared library.
    """

    function: Function
    name: str
    path: str


def to_c(function: Function) -> Function:
    """The same function as a shared library of generated C, three to five times faster than the virtual machine.

    See `library`, which also returns the path.
    """
    return library(function).function


def library(function: Function, beside: str = "") -> Library:
    """The function as a shared library of generated C.

    Compiling takes about a second. Libraries are kept in the user's cache folder (``$XDG_CACHE_HOME/jtik``) under
    the hash of their code, so that an unchanged function is compiled once. The compiler is ``$CC``, ``cc``, ``gcc``,
    ``clang`` or the package ``ziglang``.

    Args:
        function: the function.
        beside: more C source for the same library; it calls the function JTIK_NAME.

    Raises:
        CompilerError: when there is no compiler, or it fails.
    """
    command = [*_compiler(), "-O2"]
    source = c_source(function) + beside
    name = "jtik_" + hashlib.sha256(" ".join([*command, source]).encode()).hexdigest()[:16]
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "jtik"
    path = folder / f"{name}.so"
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            code, built = Path(scratch) / f"{name}.c", Path(scratch) / path.name
            # the prefix keeps the symbols of several libraries, and libc's own "step", apart
            code.write_text(source.replace(function.name(), name).replace("JTIK_NAME", name))
            call = [*command, "-shared", "-fPIC", str(code), "-o", str(built), "-lm"]
            try:
                run = subprocess.run(call, capture_output=True, text=True, check=False)
            except OSError as error:
                raise CompilerError(" ".join(command), str(error)) from error
            if run.returncode:
                raise CompilerError(" ".join(command), run.stderr.strip())
            built.replace(path)
    return Library(external(name, str(path)), name, str(path))


def _compiler() -> list[str]:
    if os.environ.get("CC"):
        return os.environ["CC"].split()
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    raise CompilerError("compiled=True", "no C compiler found; install one, or: pip install ziglang")
