"""A frame brought to a position, an orientation or a pose in the base frame: the most common task."""

from __future__ import annotations

from numpy.typing import ArrayLike

from jtik.robot import Kinematics
from jtik.symbolic import Expression
from jtik.task.placement import ErrorForm, PlacementTask
from jtik.task.targets import Kind
from jtik.task.weighted import Axes


class FrameTask(PlacementTask):
    """Bring a frame of the robot to a target position, orientation or pose in the base frame.

    Prefer `RelativeFrameTask` for a target in another frame of the robot, `AxisTask` where the rotation about one axis
    does not matter, and `LookAtTask` for a frame that points at a target.

    Error: the position in base axes, ``p(q) - p_target`` [m]; the orientation in the axes of the *target*, the
    logarithm of ``R_target' R(q)`` [rad], so that without the row "rz" the rotation about the tool's z axis is free. On
    a planar robot a position is (x, y) and an orientation is one angle, with an error in (-pi, pi].

    A target has one of these forms:

    - a position (x, y, z) [m], for kind "position";
    - a rotation, for kind "orientation": a matrix (3, 3), a quaternion (w, x, y, z), or a rotation of SciPy, mink,
      Pinocchio, spatialmath, Drake or ROS;
    - a pose, for every kind: a matrix (4, 4) or (3, 4), seven numbers (x, y, z, qw, qx, qy, qz), a pair (position,
      rotation) with a rotation in any of its forms, or a pose of one of these libraries. The frame that a ROS message
      names is not read: it has to be the base;
    - on a planar robot also (x, y), an angle [rad], or (x, y, angle).

    Quaternions whose norm is within 1e-2 of 1, and matrices within 1e-3 of a rotation, are normalised, so numbers that
    were printed with four digits are accepted. Of a pose, only the position is used by kind "position", and only the
    orientation by kind "orientation"; `unused` reports it.

    Args:
        frame: name of the frame; "tip" is `Robot.tip` where no frame has that name.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep: "x", "y", "z" (position), "rx", "ry", "rz" (orientation); None keeps all.
        stiffness: Kp, a positive scalar, one value for each row, or a symmetric positive definite matrix (m, m). A
            length of L metres counts as much as one radian where orientation rows have L^2 times the stiffness of
            position rows.
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets; the name of the frame by default.
        error: "separate" as above, or "logarithm": the logarithm of the motion from the target to the frame, as mink's
            and pink's ``FrameTask`` have it, with all rows in the axes of the target, which are also the frame's. Its
            position rows depend on the rotation, so kind "position" needs a pose as its target, too. Prefer "separate",
            whose end effector moves straight to the target, and "logarithm" for the steps of mink.

    Raises:
        ArgumentError: when the kind, the priority, the stiffness or ``error`` cannot be used.

    Example:
        >>> hand = jtik.FrameTask("tip", kind="pose")
        >>> nearly = jtik.FrameTask("tip", kind="pose", axes=["x", "y", "z", "rx", "ry"])  # free about the tool's axis
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
        error: ErrorForm = "separate",
    ) -> None:
        super().__init__(frame, kind, axes=axes, stiffness=stiffness, priority=priority, name=name, error=error)

    def __repr__(self) -> str:
        return f"FrameTask({self.frame!r}, kind={self.kind!r})"

    def geometric_jacobian(self, kinematics: Kinematics) -> Expression:
        """The geometric Jacobian of the frame."""
        return kinematics.plain_jacobian(self.frame)

    def placement(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """The rotation and the position of the frame in the base frame."""
        return kinematics.rotation(self.frame), kinematics.position(self.frame)
