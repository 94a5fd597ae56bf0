"""How a plan travels to other processes: packed once, unpacked once a process, and kept there with what is built."""

from __future__ import annotations

import hashlib
import importlib
import pickle
import threading
from dataclasses import dataclass
from typing import Any

from jtik.errors import ArgumentError, JtikError
from jtik.study.units import Bench, Block, Plan, Unit, reason

TOP_LEVEL = (
    "what another process can find: classes and functions at the top level of a module; "
    "or install cloudpickle, with which those of a notebook and lambdas travel, too"
)


@dataclass(frozen=True)
class Packed:
    """A plan as bytes, and the name under which a process keeps what it has built from it."""

    name: str
    data: bytes

    @classmethod
    def of(cls, plan: Plan) -> Packed:
        """Pack a plan: with cloudpickle where it is installed, since that takes lambdas and notebooks' functions.

        Raises:
            ArgumentError: naming the robot, task, criterion or strategy that cannot travel.
        """
        pickler = _pickler()
        try:
            data = pickler.dumps(plan, protocol=pickle.HIGHEST_PROTOCOL)
        except Exception as error:
            argument, given = _culprit(plan, pickler)
            raise ArgumentError(argument, f"{given}, which does not pickle: {reason(error)}", TOP_LEVEL) from error
        return cls(hashlib.sha256(data).hexdigest(), data)


class UnpackError(JtikError):
    """A study that arrived in a process which cannot find a part of it. Attributes: reason."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason

    def __str__(self) -> str:
        return f"executor: a process cannot rebuild the study ({self.reason}); accepted: {TOP_LEVEL}"


_kept: dict[str, Bench] = {}
"""What this process has built for the last study it worked for."""

_busy = threading.Lock()
"""One unit at a time: solvers belong to one thread, and two at once would be timed with each other's work."""


def run_packed(packed: Packed, unit: Unit) -> Block:
    """Do a unit, wherever this is called.

    Raises:
        UnpackError: when the plan cannot be rebuilt here.
    """
    with _busy:
        if packed.name not in _kept:
            try:
                plan = pickle.loads(packed.data)
            except Exception as error:
                raise UnpackError(reason(error)) from error
            _kept.clear()
            _kept[packed.name] = Bench(plan)
        return _kept[packed.name].run(unit)


def _pickler() -> Any:
    try:
        return importlib.import_module("cloudpickle")
    except ImportError:
        return pickle


def _culprit(plan: Plan, pickler: Any) -> tuple[str, str]:
    """The first part of a plan that does not pickle: which argument it came from, and what it is."""
    parts: list[tuple[str, Any]] = [("robot", plan.setting.robot), ("task", plan.setting.task)]
    parts += [(f"criteria[{label!r}]", criteria) for label, criteria in plan.criteria.items()]
    parts += [(f"strategies[{label!r}]", contender) for label, contender in plan.contenders.items()]
    parts += [("clearances", clearance) for clearance in plan.setting.clearances]
    for argument, part in parts:
        try:
            pickler.dumps(part)
        except Exception:
            return argument, repr(part)
    return "executor", "a study"
