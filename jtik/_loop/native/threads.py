"""Several native searches at the same time, each in a thread of its own: the rows of a batch in blocks."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterator

from jtik._loop.native.search import MOST_ROWS, NativeBatch

WAIT = 0.05
"""Longest time for which Ctrl-C is not looked for where waiting cannot be interrupted [s]."""

BLOCKS = 8
"""Number of blocks a thread: the last ones end at about the same time, however long their searches take."""

SMALLEST = 16
"""Smallest number of targets of a block."""

AFTERWARDS = 0.1
"""How long Python may go on with what is solved when Ctrl-C is pressed [s]."""

MOST_THREADS = 256
"""Most threads of a batch."""

Solve = Callable[[int, int], NativeBatch]
"""(number of the first row, number after the last) -> the first ones of these rows; at least one."""


def in_threads(
    solves: list[Solve], count: int, *, blocks: int = BLOCKS, most: int = MOST_ROWS
) -> Iterator[tuple[int, NativeBatch, float]]:
    """The rows of a batch in blocks, as they are done: the number of the first row, the rows, and until when to go on.

    Where the iterator is closed or Ctrl-C is pressed, the threads end after their calls of C, which take a tenth of a
    second; what they have solved until then is yielded before KeyboardInterrupt is raised again. Until then the third
    number is math.inf, and after it the time (`time.perf_counter`) when the caller should have done.

    Args:
        solves: what solves in each thread.
        count: number of rows.
        blocks: number of blocks a thread.
        most: most rows of a block.
    """
    if len(solves) == 1:
        begin = 0
        while begin < count:
            batch = solves[0](begin, count)
            yield begin, batch, math.inf
            begin += len(batch.q)
        return
    done: queue.SimpleQueue[tuple[int, NativeBatch] | BaseException] = queue.SimpleQueue()
    size = min(max(count // (blocks * len(solves)), SMALLEST), most)
    begins, taking, stop = iter(range(0, count, size)), threading.Lock(), threading.Event()

    def work(solve: Solve) -> None:
        try:
            while not stop.is_set():
                with taking:
                    at = next(begins, count)
                if at == count:
                    return
                end = min(at + size, count)
                while at < end and not stop.is_set():
                    batch = solve(at, end)
                    done.put((at, batch))
                    at += len(batch.q)
        except BaseException as error:  # it is raised where the rows are awaited
            done.put(error)

    threads = [threading.Thread(target=work, args=(solve,), name="jtik batch", daemon=True) for solve in solves]
    try:
        for thread in threads:
            thread.start()
        rows = 0
        while rows < count:
            try:
                item = done.get(timeout=WAIT)
            except queue.Empty:
                continue
            if isinstance(item, BaseException):
                raise item
            yield *item, math.inf
            rows += len(item[1].q)
    except KeyboardInterrupt:
        _ended(threads, stop)
        until = time.perf_counter() + AFTERWARDS
        while not done.empty():
            item = done.get()
            if not isinstance(item, BaseException):
                yield *item, until
        raise
    finally:
        _ended(threads, stop)


def _ended(threads: list[threading.Thread], stop: threading.Event) -> None:
    """End the threads, and wait for it."""
    stop.set()
    for thread in threads:
        if thread.ident is not None:
            thread.join()
