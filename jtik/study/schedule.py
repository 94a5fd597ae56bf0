"""Execution of the units of a study: in this process, or by an executor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed

from jtik.study.serialization import SerializedPlan, run_serialized
from jtik.study.unit_runner import UnitRunner
from jtik.study.work_units import StudyPlan, UnitResult, WorkUnit


class Schedule:
    """Iterates over the results of the units of a study: first those known before, then others as they complete.

    An exception in the loop cancels the units that have not started. `leftover` then returns the results that were
    complete but had not been yielded.

    Args:
        plan: the study.
        done: results from before.
        executor: runs the other units; this process does if None.
        runner: the runner of this process.
    """

    def __init__(
        self, plan: StudyPlan, done: Sequence[UnitResult], executor: Executor | None, runner: UnitRunner
    ) -> None:
        self._done, self._executor, self._runner = list(done), executor, runner
        finished = {result.unit for result in done}
        self._units = [unit for unit in plan.units() if unit not in finished]
        self._serialized = SerializedPlan.of(plan) if executor is not None and self._units else None
        self._futures: list[Future[UnitResult]] = []
        self._yielded: set[WorkUnit] = set()

    def __len__(self) -> int:
        return len(self._done) + len(self._units)

    def __iter__(self) -> Iterator[UnitResult]:
        yield from self._done
        if self._executor is None or self._serialized is None:
            for unit in self._units:
                yield self._runner.run(unit)
            return
        try:
            self._futures = [self._executor.submit(run_serialized, self._serialized, unit) for unit in self._units]
            for future in as_completed(self._futures):
                result = future.result()
                self._yielded.add(result.unit)
                yield result
        finally:
            self.cancel()

    def cancel(self) -> None:
        """Cancel the units that have not started."""
        for future in self._futures:
            future.cancel()

    def leftover(self) -> list[UnitResult]:
        """Results that an executor has completed and that were not yielded."""
        self.cancel()
        finished = [future for future in self._futures if future.done() and not future.cancelled()]
        results = [future.result() for future in finished if future.exception() is None]
        return [result for result in results if result.unit not in self._yielded]
