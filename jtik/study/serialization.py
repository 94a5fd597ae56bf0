"""Serialization of a study plan for other processes, each of which deserializes it once and keeps its solvers."""

from __future__ import annotations

import hashlib
import pickle
import threading
from dataclasses import dataclass
from typing import Any

from jtik._loop.pickling import PICKLABLE, pickler
from jtik.errors import ArgumentError, JtikError
from jtik.study.case_run import reason
from jtik.study.unit_runner import UnitRunner
from jtik.study.work_units import StudyPlan, UnitResult, WorkUnit


@dataclass(frozen=True)
class SerializedPlan:
    """A pickled plan.

    Attributes:
        name: hash of the data, by which a process finds the runner that it keeps.
        data: the pickle.
    """

    name: str
    data: bytes

    @classmethod
    def of(cls, plan: StudyPlan) -> SerializedPlan:
        """Pickle a plan, with cloudpickle if it is installed.

        Raises:
            ArgumentError: naming the robot, task, criterion or strategy that cannot be pickled.
        """
        module = pickler()
        try:
            data = module.dumps(plan, protocol=pickle.HIGHEST_PROTOCOL)
        except Exception as error:
            argument, given = _unpicklable_part(plan, module)
            raise ArgumentError(argument, f"{given}, which cannot be pickled: {reason(error)}", PICKLABLE) from error
        return cls(hashlib.sha256(data).hexdigest(), data)


class PlanDeserializationError(JtikError):
    """A process cannot rebuild a study.

    Attributes:
        reason: the message of the original error.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason

    def __str__(self) -> str:
        return f"executor: a process cannot rebuild the study ({self.reason}); accepted: {PICKLABLE}"


_runners: dict[str, UnitRunner] = {}
"""The runner of the last study of this process, by the name of its plan."""

_busy = threading.Lock()
"""Allows one unit at a time: solvers belong to one thread, and parallel units would disturb each other's times."""


def run_serialized(serialized: SerializedPlan, unit: WorkUnit) -> UnitResult:
    """Run a unit in the process that calls this.

    Raises:
        PlanDeserializationError: if the plan cannot be rebuilt in this process.
    """
    with _busy:
        if serialized.name not in _runners:
            try:
                plan = pickle.loads(serialized.data)
            except Exception as error:
                raise PlanDeserializationError(reason(error)) from error
            _runners.clear()
            _runners[serialized.name] = UnitRunner(plan)
        return _runners[serialized.name].run(unit)


def _unpicklable_part(plan: StudyPlan, module: Any) -> tuple[str, str]:
    """The first part of a plan that cannot be pickled: its argument and its text."""
    parts: list[tuple[str, Any]] = [("robot", plan.setting.robot), ("task", plan.setting.task)]
    parts += [(f"criteria[{label!r}]", criteria) for label, criteria in plan.criteria.items()]
    parts += [(f"strategies[{label!r}]", contender) for label, contender in plan.contenders.items()]
    parts += [("clearances", clearance) for clearance in plan.setting.clearances]
    for argument, part in parts:
        try:
            module.dumps(part)
        except Exception:
            return argument, repr(part)
    return "executor", "a study"
