"""Doing the units of a study: one after the other here, or wherever an executor takes them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed

from jtik.study.travel import Packed, run_packed
from jtik.study.units import Bench, Block, Plan, Unit


class Schedule:
    """The units of a study in the order they get done, those that were done before first.

    Leaving the loop over it early, by whatever exception, cancels what has not begun; `leftover` has what was done by
    then and has not been handed out.

    Args:
        plan: the study.
        done: what was done before.
        executor: who does the rest; this process when None.
        bench: what this process has built of it already.
    """

    def __init__(self, plan: Plan, done: Sequence[Block], executor: Executor | None, bench: Bench) -> None:
        self._done, self._executor, self._bench = list(done), executor, bench
        had = {block.unit for block in done}
        self._units = [unit for unit in plan.units() if unit not in had]
        self._packed = Packed.of(plan) if executor is not None and self._units else None
        self._futures: list[Future[Block]] = []
        self._given: set[Unit] = set()

    def __len__(self) -> int:
        return len(self._done) + len(self._units)

    def __iter__(self) -> Iterator[Block]:
        yield from self._done
        if self._executor is None or self._packed is None:
            for unit in self._units:
                yield self._bench.run(unit)
            return
        try:
            self._futures = [self._executor.submit(run_packed, self._packed, unit) for unit in self._units]
            for future in as_completed(self._futures):
                block = future.result()
                self._given.add(block.unit)
                yield block
        finally:
            self.cancel()

    def cancel(self) -> None:
        """Do not begin what has not begun."""
        for future in self._futures:
            future.cancel()

    def leftover(self) -> list[Block]:
        """What was done by an executor and not handed out."""
        self.cancel()
        over = [future for future in self._futures if future.done() and not future.cancelled()]
        blocks = [future.result() for future in over if future.exception() is None]
        return [block for block in blocks if block.unit not in self._given]
