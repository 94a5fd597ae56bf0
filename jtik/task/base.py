"""What a task is: an error e(q, target) whose every row is in [m] or [rad], and the numbers that make up a target."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, symbol
from jtik.types import Array


@dataclass(frozen=True)
class TaskRows:
    """The rows of a task on one robot.

    Attributes: error (m, 1); for each row whether it is a length [m] or an angle [rad]; the error's derivative with
    respect to the velocity (m, n), where the task has one that is cheaper than CasADi's own.
    """

    error: Expression
    linear: tuple[bool, ...]
    jacobian: Expression | None = None


class Task(ABC):
    """Something the robot must do. Subclass it by an error and the numbers that make up a target.

    ``name`` identifies the task in a dict of targets; ``priority`` orders tasks for the strategies that know levels
    (0 is the highest).
    """

    name: str
    priority: int

    @abstractmethod
    def target_size(self, robot: Robot) -> int:
        """How many numbers a target of this task is, on this robot."""

    @abstractmethod
    def read_target(self, robot: Robot, target: Any) -> Array:
        """The numbers of ``target``, shape (target_size,). Raises ArgumentError for what is not a target."""

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """The frames it is about, or none where only its error can tell."""
        return ()

    def plain(self, robot: Robot) -> bool:
        """Whether a vector of ``target_size`` numbers is a target as it stands."""
        return False

    @abstractmethod
    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """The error at ``kinematics.q`` for the symbolic ``target`` (target_size, 1)."""

    def row_count(self, robot: Robot) -> int:
        """How many rows the task has on this robot. Override it where that is known without building them."""
        kinematics = robot.at(symbol("q", robot.nq))
        return len(self.rows(kinematics, symbol("target", self.target_size(robot))).linear)

    @abstractmethod
    def weight(self, rows: int) -> Array:
        """Stiffness Kp (rows, rows), symmetric positive definite, of a task with that many rows."""
