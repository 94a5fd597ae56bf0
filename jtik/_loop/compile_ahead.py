"""Generated C that is made while the step runs on the virtual machine, and takes over between two calls.

Both give the same numbers, so that it does not matter when that is. A step is compiled once it has run for as long as a
compilation takes: at worst the work is done twice, and a solver that is used for a moment compiles nothing.
"""

from __future__ import annotations

import atexit
import logging
import os
import queue
import threading
import weakref
from collections import defaultdict
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache
from typing import Any, Protocol

from jtik._step.fused_step import Compiled, FusedStep
from jtik.symbolic import Function
from jtik.symbolic.archives import Archive
from jtik.symbolic.c_compiler import CompilerRuns
from jtik.symbolic.compile import CompilerError, Library, compiler, library

PAYS = 1.0
"""Time that a step has run on the virtual machine when it is compiled [s]."""

_logger = logging.getLogger(__name__)


class Steps(Protocol):
    """The fused steps of a solver, each with a name."""

    @property
    def built(self) -> list[str]:
        """Names of the steps that are built and can be compiled."""

    def in_c(self, name: str, compiled: Compiled, using_casadi: AbstractContextManager[Any]) -> FusedStep:
        """The step with this name in generated C. It may be called in any thread.

        Raises:
            CompilerError: without a compiler.
        """

    def adopt(self, name: str, fused: FusedStep) -> None:
        """Run the step with this name as this function from now on."""


class CompileAhead:
    """The steps of one solver.

    Args:
        steps: the steps; None to compile none.
        adopted: is called with the name of a step that has been adopted.

    Attributes:
        compiles: whether it compiles any.
        waiting: number of steps that are being compiled, or have been and are not yet adopted.
    """

    def __init__(self, steps: Steps | None, adopted: Callable[[str], None]) -> None:
        self._steps, self._adopted = steps, adopted
        self.compiles = steps is not None
        self._spent: defaultdict[str, float] = defaultdict(float)
        self._begun: set[str] = set()
        self._ready: queue.SimpleQueue[tuple[str, FusedStep | None]] = queue.SimpleQueue()
        self.waiting = 0

    def spend(self, name: str, seconds: float) -> None:
        """Note that a step has run for so long; it is compiled where that pays."""
        if self._steps is not None and name not in self._begun:
            self._spent[name] += seconds
            if self._spent[name] > PAYS:
                self.begin()
                self._begun.add(name)  # also where it cannot be compiled

    def begin(self) -> None:
        """Compile all steps that are built."""
        if self._steps is None:
            return
        for name in self._steps.built:
            if name not in self._begun:
                self._begun.add(name)
                self.waiting += 1
                _begin(weakref.ref(self._steps), name, self._ready)

    def adopt(self) -> bool:
        """Let the steps that are ready take over, and return whether one has. Nothing may be running on them."""
        waited = self.waiting
        while not self._ready.empty():
            name, fused = self._ready.get()
            self.waiting -= 1
            if fused is not None and self._steps is not None:
                self._steps.adopt(name, fused)
                self._adopted(name)
        return self.waiting < waited

    def settled(self, name: str) -> bool:
        """Whether nothing will change for the step with this name any more."""
        return name in self._begun and not self.waiting


_jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
_using_casadi = threading.Lock()
_worker: list[tuple[int, threading.Thread]] = []
_runs = CompilerRuns()
_closing = threading.Event()


def _library(function: Function, beside: str, archive: Archive | None) -> Library:
    """A library, by a compiler that ends with the interpreter."""
    return library(function, beside, archive, runs=_runs, using_casadi=_using_casadi)


def _begin(steps: weakref.ref[Steps], name: str, ready: queue.SimpleQueue[tuple[str, FusedStep | None]]) -> None:
    """Compile in the one thread that does so, unless the solver is gone by then."""

    def compile_step() -> None:
        held = steps()
        if held is None:
            return
        fused = None
        try:
            if _has_compiler():
                fused = held.in_c(name, _library, _using_casadi)
        except CompilerError as error:
            if not _closing.is_set():
                _logger.warning("the step goes on without generated C: %s", error)
        ready.put((name, fused))

    _jobs.put(compile_step)
    if not _worker or _worker[-1][0] != os.getpid():  # a fork has no threads
        thread = threading.Thread(target=_work, name="jtik compiler", daemon=True)
        _worker.append((os.getpid(), thread))
        thread.start()


@cache
def _has_compiler() -> bool:
    """Whether there is a C compiler; the first time that there is none it is told."""
    try:
        compiler()
    except CompilerError as error:
        _logger.info("steps go on without generated C: %s", error)
        return False
    return True


def _work() -> None:
    while True:
        _jobs.get()()


def _stop() -> None:
    """End the compiler, and the interpreter only when the thread is not in CasADi, which is about to be unloaded."""
    _closing.set()
    _runs.end()
    _using_casadi.acquire(timeout=5.0)


atexit.register(_stop)
