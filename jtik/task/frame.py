"""A frame brought to a place in the world: the task most programs need."""

from __future__ import annotations

from numpy.typing import ArrayLike

from jtik.robot import Kinematics
from jtik.symbolic import Expression
from jtik.task.placement import PlacementTask
from jtik.task.targets import Kind
from jtik.task.weighted import Axes


class FrameTask(PlacementTask):
    """Bring a frame of the robot to a target: its position, its orientation, or both.

    Error: position in world axes, ``p(q) - p_target`` [m]; orientation in the *target's* axes, the logarithm of
    ``R_target' R(q)`` [rad], so that dropping its z row frees the spin about the tool's z axis. On a planar robot a
    position is (x, y) and an orientation is one angle, with an error in (-pi, pi].

    A target is a position (3,), a rotation (3, 3) or quaternion (w, x, y, z), or a pose: (4, 4), or a pair
    (position, quaternion), or an object with ``as_matrix()``. A pose will also do where only its position or its
    orientation is wanted. Planar: (x, y), an angle, (x, y, angle), or a pose.

    Args:
        frame: name of the frame.
        kind: "position", "orientation" or "pose".
        axes: which rows to keep, of "x", "y", "z" (position) and "rx", "ry", "rz" (orientation); None keeps all.
        stiffness: Kp of the paper: a scalar, one value a row, or an SPD matrix (m, m). A length of L metres counts as
            much as one radian where orientation rows have stiffness L^2 times that of position rows.
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task; the frame's name by default.

    Raises:
        ArgumentError: for a kind, priority or stiffness that cannot be used.
    """

    def __init__(
        self,
        frame: str = "tip",
        kind: Kind = "position",
        *,
        axes: Axes = None,
        stiffness: ArrayLike = 1.0,
        priority: int = 0,
        name: str | None = None,
    ) -> None:
        super().__init__(frame, kind, axes=axes, stiffness=stiffness, priority=priority, name=name)

    def __repr__(self) -> str:
        return f"FrameTask({self.frame!r}, kind={self.kind!r})"

    def geometric_jacobian(self, kinematics: Kinematics) -> Expression:
        """The frame's own."""
        return kinematics.plain_jacobian(self.frame)

    def placed(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """In the base frame."""
        return kinematics.rotation(self.frame), kinematics.position(self.frame)
