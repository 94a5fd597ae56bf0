"""What takes part in a study: something that is prepared once for a setting, then solves problem after problem.

A strategy of jtik is one (`jtik.study.strategies`), a library beside it is another (`jtik.study.peers`). A study knows
no difference: the same targets, starts and tolerances, and one judge that believes none of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from jtik._loop.options import Until
from jtik.constraints.clearance import Clearance
from jtik.criterion.base import Criterion, CriterionSum
from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.task import Task, TaskStack
from jtik.task.reduction import reduced
from jtik.types import Array


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What every contender of a study is asked to do: all but the problems.

    Attributes:
        robot: the robot, before joints that take no part are locked.
        task: a Task or several, as `jtik.InverseKinematics` takes them.
        criteria: what to minimise with the freedom left.
        position_tolerance: norm of the position error to reach [m].
        orientation_tolerance: norm of the orientation error to reach [rad].
        optimality_tolerance: norm of the projected gradient of H to reach, relative to max(1, |dH/dv|).
        max_iterations: most steps of an attempt.
        until: "reached" stops on target, "stationary" goes on until H cannot fall further.
        restarts: how many other starts may be tried.
        seed: which other starts.
        limits: whether the joint limits hold.
        joints: names of the joints to move, "all", or None for those that move what the tasks are about.
        at: configuration (nq,) of the robot at which the others are locked; its neutral one when None.
        compiled: whether a contender that can run as generated C does.
        clearances: distances that may not fall below their safe values.
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
        """The robot with only the joints that take part, which all configurations belong to, and the tasks on it."""
        return reduced(self.robot, self.task, self.joints, self.at)


class Answer(NamedTuple):
    """What a contender says of one target.

    Attributes:
        q: configuration of the reduced robot, (nq,).
        status: why it stopped, in its own words: the name of a `jtik.Status`, or a peer's.
        claimed: whether it says that it has done what was asked.
        iterations: steps tried; None where it does not tell.
    """

    q: Array
    status: str
    claimed: bool
    iterations: int | None = None


class Ready(ABC):
    """A contender built for one setting. It belongs to one process and one thread.

    ``note`` says what of the setting it leaves out, for all of its rows.
    """

    note: str = ""

    def convert(self, target: Any) -> Any:
        """The target in the form that `solve` and `traced` take; off the clock. As it is, unless overridden."""
        return target

    def set(self, parameters: Mapping[str, Array]) -> None:  # noqa: B027  (what has no parameters need not say so)
        """Give live parameters of criteria and clearances these values; off the clock. Nothing, unless overridden."""

    @abstractmethod
    def solve(self, target: Any, q0: Array) -> Answer:
        """Solve from ``q0`` (nq,) for a converted target. On the clock: nothing here that is not the solve."""

    def traced(self, target: Any, q0: Array) -> tuple[Answer, Trace | None]:
        """The same solve off the clock, with its iterations where the contender can tell them."""
        return self.solve(target, q0), None


class Contender(ABC):
    """Something that can take part in a study. It must pickle, to travel to the processes of an executor.

    ``label`` is its name in tables, figures and files. ``optimizes`` says whether it heeds the criteria.
    """

    label: str
    optimizes: bool = True

    @abstractmethod
    def prepare(self, setting: Setting) -> Ready:
        """Build it for a setting.

        May raise: the study then has a row for each of its problems that carries the error's text, for instance how
        to install what is missing.
        """
