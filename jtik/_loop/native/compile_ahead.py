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
from jtik.symbolic.compilation.archives import Archive
from jtik.symbolic.compilation.c_compiler import CompilerRuns
from jtik.symbolic.compile import Beside, CompilerError, Library, compiler, library

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
        self._awaited: set[str] = set()
        self._ready: queue.SimpleQueue[tuple[str, FusedStep | None]] = queue.SimpleQueue()
        self.waiting = 0
        if self.compiles:
            _living.add(self)

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
                self._awaited.add(name)
                self.waiting += 1
                _begin(weakref.ref(self._steps), name, self._ready)

    def adopt(self) -> bool:
        """Let the steps that are ready take over, and return whether one has. Nothing may be running on them."""
        waited = self.waiting
        while not self._ready.empty():
            name, fused = self._ready.get()
            self.waiting -= 1
            self._awaited.discard(name)
            if fused is not None and self._steps is not None:
                self._steps.adopt(name, fused)
                self._adopted(name)
        return self.waiting < waited

    def settled(self, name: str) -> bool:
        """Whether nothing will change for the step with this name any more."""
        return name in self._begun and not self.waiting

    def forked(self) -> None:
        """Forget, in a fork of the process, what the process compiles: it is compiled once more where that pays."""
        self._begun -= self._awaited
        self._awaited.clear()
        self._ready, self.waiting = queue.SimpleQueue(), 0


_jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
_using_casadi = threading.Lock()
_worker: list[threading.Thread] = []
_runs = CompilerRuns()
_closing = threading.Event()
_living: weakref.WeakSet[CompileAhead] = weakref.WeakSet()
_reported: set[str] = set()
_forking: list[bool] = []

LONGEST = 5.0
"""How long a fork, or the end of the interpreter, waits for the thread to leave CasADi [s]."""


def _library(function: Function, beside: Beside, archive: Archive | None) -> Library:
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
        except Exception as error:  # whatever it is, the step goes on, and so does the thread
            _report(error)
        ready.put((name, fused))

    _jobs.put(compile_step)
    if not _worker:
        thread = threading.Thread(target=_work, name="jtik compiler", daemon=True)
        _worker.append(thread)
        thread.start()


def _report(error: Exception) -> None:
    """Warn that there is no generated C; once of a command, not for each step of each solver."""
    if _closing.is_set():
        return
    what = error.command if isinstance(error, CompilerError) else repr(error)
    level = logging.INFO if what in _reported else logging.WARNING
    _reported.add(what)
    _logger.log(level, "the step goes on without generated C: %s", error if isinstance(error, CompilerError) else what)


@cache
def _has_compiler() -> bool:
    """Whether there is a C compiler; the first time that there is none it is logged, as a warning where CC is wrong."""
    try:
        compiler()
    except CompilerError as error:
        level = logging.WARNING if os.environ.get("CC") else logging.INFO
        _logger.log(level, "steps go on without generated C: %s", error)
        return False
    return True


def _work() -> None:
    jobs = _jobs
    while True:
        jobs.get()()


def _stop() -> None:
    """End the compiler, and the interpreter only when the thread is not in CasADi, which is about to be unloaded."""
    _closing.set()
    _runs.end()
    _using_casadi.acquire(timeout=LONGEST)


def _before_fork() -> None:
    """Fork only when the thread is not in CasADi, whose locks a fork would keep for ever."""
    _forking.append(not _closing.is_set() and _using_casadi.acquire(timeout=LONGEST))


def _after_fork_in_parent() -> None:
    if _forking.pop():
        _using_casadi.release()


def _after_fork_in_child() -> None:
    """A fork has no thread and no compiler of its own, and leaves those of its parent alone."""
    global _jobs, _using_casadi, _runs, _closing
    _jobs, _using_casadi, _runs, _closing = queue.SimpleQueue(), threading.Lock(), CompilerRuns(), threading.Event()
    _worker.clear()
    _forking.clear()
    for ahead in list(_living):
        ahead.forked()


atexit.register(_stop)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before_fork, after_in_parent=_after_fork_in_parent, after_in_child=_after_fork_in_child)
