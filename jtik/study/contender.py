"""Contenders of a study: solvers that are prepared once for a setting and then solve the problems one by one.

Strategies of jtik (`jtik.study.strategies`) and other libraries (`jtik.study.peers`) are contenders. All of them get
the same targets, starts and tolerances, and one independent check decides about success.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from jtik._loop.options import Until
from jtik.constraints.clearance import Clearance
from jtik.constructors import Constructed
from jtik.criterion.base import Criterion, CriterionSum
from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.task import Task, TaskStack
from jtik.task.reduction import reduced
from jtik.types import Array


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The setting of a study: everything that a contender must know except the problems.

    Attributes:
        robot: the full robot.
        task: a Task or several, as in `jtik.InverseKinematics`.
        criteria: criteria to minimise in the null space of the task.
        position_tolerance: norm of the position error to reach [m].
        orientation_tolerance: norm of the orientation error to reach [rad].
        optimality_tolerance: norm of the projected gradient of H to reach, relative to max(1, |dH/dv|).
        max_iterations: maximum number of iterations of an attempt.
        until: "reached" stops on target; "stationary" continues until H is stationary.
        restarts: maximum number of restarts.
        seed: seed of the restarts.
        limits: whether the joint limits apply.
        joints: names of the joints that move, "all", or None for those that move the frames of the tasks.
        at: configuration (nq,) of the full robot at which the other joints are locked; None for the neutral one.
        compiled: whether contenders that can run as generated C do so.
        clearances: distances that must not fall below their safe values.
    """

    robot: Robot
    task: Task | Iterable[Task]
    criteria: Criterion | CriterionSum | None = None
    position_tolerance: float = 1e-6
    orientation_tolerance: float = 1e-6
    optimality_tolerance: float = 1e-6
    max_iterations: int = 1000
    until: Until = "reached"
    restarts: int = 0
    seed: int = 0
    limits: bool = True
    joints: str | tuple[str, ...] | None = None
    at: Array | None = None
    compiled: bool = False
    clearances: tuple[Clearance, ...] = ()

    def reduced(self) -> tuple[Robot, TaskStack]:
        """The reduced robot, to which all configurations belong, and the tasks on it."""
        return reduced(self.robot, self.task, self.joints, self.at)


class Answer(NamedTuple):
    """A contender's answer for one target.

    Attributes:
        q: configuration of the reduced robot, (nq,).
        status: why the solve stopped: the name of a `jtik.Status`, or a status of a peer.
        claimed: whether the contender reports success.
        iterations: number of iterations; None if unknown.
    """

    q: Array
    status: str
    claimed: bool
    iterations: int | None = None


class PreparedContender(ABC):
    """A contender built for one setting. It belongs to one process and one thread.

    Attributes:
        note: parts of the setting that the contender ignores, as the note of all its rows.
    """

    note: str = ""

    def convert(self, target: Any) -> Any:
        """The target in the form that `solve` and `traced` take; not timed. Unchanged unless overridden.

        Args:
            target: a target of the task.
        """
        return target

    def set(self, parameters: Mapping[str, Array]) -> None:  # noqa: B027  (a contender without parameters need not override it)
        """Set live parameters of criteria and clearances; not timed. Does nothing unless overridden.

        Args:
            parameters: values by name, as in ``ik.parameters``.
        """

    @abstractmethod
    def solve(self, target: Any, q0: Array) -> Answer:
        """Solve from ``q0`` (nq,) for a converted target. This call is timed, so it contains only the solve.

        Args:
            target: what `convert` returned.
            q0: configuration to start from (nq,) [rad] or [m].
        """

    def traced(self, target: Any, q0: Array) -> tuple[Answer, Trace | None]:
        """Solve without timing, with the iterations if the contender can record them.

        Args:
            target: what `convert` returned.
            q0: configuration to start from (nq,) [rad] or [m].
        """
        return self.solve(target, q0), None


class Contender(metaclass=Constructed):
    """A solver that can take part in a study. It must be picklable, for the processes of an executor.

    Attributes:
        label: its name in tables, figures and files.
        optimizes: whether it minimises the criteria.
    """

    label: str
    optimizes: bool = True

    @abstractmethod
    def prepare(self, setting: Setting) -> PreparedContender:
        """Build the contender for a setting.

        It may raise. The study then has a row for each problem with the text of the error, for instance how to install
        a missing package.

        Args:
            setting: robot, task, criteria and options of the study.
        """
