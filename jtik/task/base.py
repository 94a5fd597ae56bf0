"""The contract of a task: an error e(q, target) whose rows are in [m] or [rad], and the numbers of a target."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from jtik.constructors import Constructed
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, Function, symbol
from jtik.types import Array


@dataclass(frozen=True)
class TaskRows:
    """The rows of a task on one robot.

    Attributes:
        error: the error (m, 1) [m] and [rad].
        linear: for each row, True for a length [m] and False for an angle [rad].
        jacobian: derivative of the error with respect to the velocity, (m, n), where there is a simpler expression
            than CasADi derives; None otherwise.
        near_jacobian: a cheaper matrix (m, n) that approaches ``jacobian`` where the error approaches zero; None for
            none.
    """

    error: Expression
    linear: tuple[bool, ...]
    jacobian: Expression | None = None
    near_jacobian: Expression | None = None


class Task(metaclass=Constructed):
    """A task: an error that the solver reduces to zero. Subclass it with an error and the numbers of a target.

    Attributes:
        name: identifies the task in a dict of targets.
        priority: level for strategies with levels of priority; 0 is the highest.
    """

    name: str
    priority: int

    _renamed: ClassVar[Mapping[str, str]] = MappingProxyType({"plain": "target_is_vector"})
    """Deprecated names of methods that subclasses define, to the present ones."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        renamed = {old: new for base in cls.__mro__ for old, new in vars(base).get("_renamed", {}).items()}
        for old, new in renamed.items():
            if old in vars(cls):
                text = f"{cls.__name__}.{old} is now {cls.__name__}.{new}"
                warnings.warn(text, DeprecationWarning, stacklevel=2)
                setattr(cls, new, vars(cls)[old])
        if "read_target" in vars(cls):
            for faster in ("target_is_vector", "matrix_reader", "read_matrices"):
                if faster not in vars(cls):  # that of a base reads targets in another way
                    setattr(cls, faster, vars(Task)[faster])

    @abstractmethod
    def target_size(self, robot: Robot) -> int:
        """How many numbers a target of this task has on this robot.

        Args:
            robot: the robot.
        """

    @abstractmethod
    def read_target(self, robot: Robot, target: Any) -> Array:
        """The numbers of ``target``, shape (target_size,).

        The faster ways `target_is_vector`, `matrix_reader` and `read_matrices` are used where they are defined in the
        same class or below it.

        Args:
            robot: the robot.
            target: what the caller gives, in any form that the task accepts.

        Raises:
            ArgumentError: for anything that is not a target of this task.
        """

    def unused(self, robot: Robot, target: Any) -> str | None:
        """The part of a target that this task accepts but does not use, such as "orientation of the target".

        Args:
            robot: the robot.
            target: a target that `read_target` accepts.

        Returns:
            A text for the report; None where all of the target is used.
        """
        return None

    def held_target(self, kinematics: Kinematics) -> Expression | None:
        """The numbers of the target that ``kinematics.q`` meets exactly, (target_size, 1).

        None, the default, where the task does not say. `InverseKinematics.jog` then keeps the error as it is.

        Args:
            kinematics: the robot at a symbolic configuration.
        """
        return None

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """The frames on which the error depends; empty where the joints are read from the error itself.

        Args:
            robot: the robot.
        """
        return ()

    def matrix_reader(self, robot: Robot) -> Function | None:
        """The function that reads a target (4, 4): its memory, row by row -> numbers, whether valid; None without.

        It is a faster way than `read_target`, which reads what is not valid.

        Args:
            robot: the robot.
        """
        return None

    def read_matrices(self, robot: Robot, targets: Array) -> Array | None:
        """The numbers of many matrices (k, 4, 4), (k, target size), by `read_target`; None where that is needed.

        Args:
            robot: the robot.
            targets: the targets.
        """
        return None

    def target_is_vector(self, robot: Robot) -> bool:
        """Whether a vector of ``target_size`` finite numbers is a target without any conversion.

        Args:
            robot: the robot.
        """
        return False

    def plain(self, robot: Robot) -> bool:
        """Deprecated: use `target_is_vector`.

        Args:
            robot: the robot.
        """
        warnings.warn("Task.plain is now Task.target_is_vector", DeprecationWarning, stacklevel=2)
        return self.target_is_vector(robot)

    @abstractmethod
    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """The error at ``kinematics.q`` for the symbolic ``target`` (target_size, 1).

        Args:
            kinematics: the robot at a symbolic configuration.
            target: the numbers of a target as symbols (target_size, 1).

        Returns:
            The rows of the error, [m] or [rad] each.

        Raises:
            ArgumentError: when the task does not fit the robot.
            UnknownNameError: when the robot has no frame of that name.
        """

    def row_count(self, robot: Robot) -> int:
        """How many rows the task has on this robot. Override it where that is known without building the rows.

        Args:
            robot: the robot.
        """
        kinematics = robot.at(symbol("q", robot.nq))
        return len(self.rows(kinematics, symbol("target", self.target_size(robot))).linear)

    @abstractmethod
    def weight(self, rows: int) -> Array:
        """The stiffness Kp (rows, rows) of a task with that many rows: symmetric positive definite.

        Args:
            rows: number of rows m of the task.
        """
