"""The compilation of a solver's functions: several C files at the same time, with progress, until Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from types import FrameType

from jtik.symbolic.compilation.archives import Archive
from jtik.symbolic.compilation.c_compiler import CompilerRuns
from jtik.symbolic.compile import NOTHING, Beside, Library, library
from jtik.symbolic.operations import Function

POLL = 0.1
"""Longest time between two looks at what is compiled, while somebody waits for it [s]."""

Report = Callable[[int, int], None]
"""Called with (done, total)."""


class Compilation:
    """Compiles functions as C in threads, each once, and reports how many are done.

    One thread uses it at a time. Whatever ends a wait early, such as Ctrl-C, ends the compilers that run; what they
    have written is deleted, and a function that is asked for again is compiled again.
    """

    def __init__(self) -> None:
        self._begun: dict[int, tuple[Function, Future[Library]]] = {}
        self._executor: ThreadPoolExecutor | None = None
        self._runs = CompilerRuns()
        self._report: Report | None = None
        self._parts = self._parts_done = 0
        self._last = (0, 0)
        self._files: list[Future[Library]] = []
        self._check: Callable[[], None] = _nothing

    @contextmanager
    def shown(self, report: Report | None, parts: int) -> Iterator[None]:
        """While something is built: ``report`` is informed, and an exception ends what is still compiled.

        Args:
            report: called with the number of parts and files that are done and that there are, as far as is known;
                at the end they are equal. None for no report.
            parts: number of parts that are built beside the files; see `part_done`.
        """
        self._report, self._parts, self._parts_done, self._files, self._last = report, parts, 0, [], (0, 0)
        try:
            with _noticed_interrupt() as self._check:
                self._inform()
                yield
                self._parts_done = parts
                self._inform()
                self._wait(self._files if report else [])  # at the end all of them are done
        except BaseException:
            self.end()
            raise
        finally:
            self._report, self._files, self._check = None, [], _nothing
            self._close()

    def part_done(self) -> None:
        """Count one more part that is built."""
        self._parts_done += 1
        self._inform()

    def begin(self, functions: Iterable[Function]) -> None:
        """Begin to compile functions that `library` or `to_c` is to return.

        Args:
            functions: the functions to compile.
        """
        for each in functions:
            if id(each) not in self._begun:
                self._begun[id(each)] = each, self.begun(each)

    def begun(self, function: Function, beside: Beside = NOTHING, archive: Archive | None = None) -> Future[Library]:
        """The library of a function, which is compiled from now on.

        Args:
            function: the function to compile.
            beside: what is compiled into the same library.
            archive: a static library that the C calls; None for none.
        """
        self._executor = self._executor or ThreadPoolExecutor(thread_name_prefix="jtik-compiler")
        future = self._executor.submit(library, function, beside, archive, runs=self._runs)
        self._files.append(future)
        self._inform()
        return future

    def library(self, function: Function, beside: Beside = NOTHING, archive: Archive | None = None) -> Library:
        """The library of a function, when it is compiled.

        Args:
            function: the function to compile.
            beside: what is compiled into the same library.
            archive: a static library that the C calls; None for none.

        Raises:
            CompilerError: when it cannot be compiled.
        """
        known = id(function) in self._begun
        future = self._begun.pop(id(function))[1] if known else self.begun(function, beside, archive)
        try:
            self._wait([future])
        except BaseException:
            self.end()
            raise
        return future.result()

    def to_c(self, function: Function) -> Function:
        """A function as generated C, when it is compiled; see `library`.

        Args:
            function: the function to compile.

        Raises:
            CompilerError: when it cannot be compiled.
        """
        return self.library(function).function

    def end(self) -> None:
        """End all compilers that run, and forget what is not compiled."""
        self._runs.end()
        if self._executor:
            self._executor.shutdown(cancel_futures=True)  # waits until what they have written is deleted
        self._executor, self._runs, self._begun = None, CompilerRuns(), {}

    def _close(self) -> None:
        """Let the threads end when they have done what they were given."""
        if self._executor:
            self._executor.shutdown(wait=False)
        self._executor = None

    def _wait(self, futures: list[Future[Library]]) -> None:
        """Wait for futures; whatever is done meanwhile is reported."""
        pending = set(futures)
        self._check()
        while pending:
            _, pending = wait(pending, POLL, FIRST_COMPLETED)
            self._check()
            self._inform()

    def _inform(self) -> None:
        """Report what is done, if that has changed."""
        if self._report is None:
            return
        done = self._parts_done + sum(each.done() for each in self._files)
        now = (done, self._parts + len(self._files))
        if now != self._last:
            self._last = now
            self._report(*now)


def _nothing() -> None:
    """Check nothing."""


@contextmanager
def _noticed_interrupt() -> Iterator[Callable[[], None]]:
    """A function that raises KeyboardInterrupt once more where there was Ctrl-C.

    CasADi clears what is raised while it converts arguments.
    """
    noticed = []

    def handler(number: int, frame: FrameType | None) -> None:
        noticed.append(number)
        signal.default_int_handler(number, frame)

    def check() -> None:
        if noticed:
            raise KeyboardInterrupt

    in_main = threading.current_thread() is threading.main_thread()
    if in_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, handler)
        try:
            yield check
        finally:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    else:
        yield check
