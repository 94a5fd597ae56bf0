"""A frame brought to a pose in another frame of the same robot: two hands on one object, a hand over a foot."""

from __future__ import annotations

from numpy.typing import ArrayLike

from jtik.arguments import name as read_name
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.task.placement import ErrorForm, PlacementTask
from jtik.task.targets import Kind
from jtik.task.weighted import Axes


class RelativeFrameTask(PlacementTask):
    """Bring a frame to a target in a reference frame that the robot moves, too.

    Prefer `FrameTask` for a target in the base frame.

    Error: the position in the axes of the *reference*, ``p(q) - p_target`` [m], with p the frame's origin in the
    reference; the orientation in the axes of the *target*, the logarithm of ``R_target' R(q)`` [rad], with R the frame
    in the reference. The error does not depend on joints that carry both frames. Targets and planar robots: see
    `FrameTask`.

    Args:
        frame: name of the frame to bring to the target.
        reference: name of the frame in which the target is given.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep: "x", "y", "z" (position), "rx", "ry", "rz" (orientation); None keeps all.
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (m, m).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets; the name of ``frame`` by default.
        error: "separate" as above, or "logarithm", as in `FrameTask`.

    Raises:
        ArgumentError: when both frames are the same, or the kind, the priority, the stiffness or ``error`` cannot be
            used.

    Example:
        >>> fore = jtik.RelativeFrameTask("tip", "link2", kind="position", name="fore")
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(4), [jtik.FrameTask("tip"), fore])
        >>> solution = ik.solve({"tip": [2.0, 1.5], "fore": [1.0, 1.8]}, restarts=5)
    """

    def __init__(
        self,
        frame: str,
        reference: str,
        kind: Kind = "pose",
        *,
        axes: Axes = None,
        stiffness: ArrayLike = 1.0,
        priority: int = 0,
        name: str | None = None,
        error: ErrorForm = "separate",
    ) -> None:
        super().__init__(frame, kind, axes=axes, stiffness=stiffness, priority=priority, name=name, error=error)
        self.reference = read_name("reference", reference)
        if reference == frame:
            raise ArgumentError("reference", reference, "a frame other than the one to bring to the target")

    def __repr__(self) -> str:
        return f"RelativeFrameTask({self.frame!r}, {self.reference!r}, kind={self.kind!r})"

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """Empty: joints that carry both frames do not count, so the joints are read from the error itself."""
        return ()

    def placement(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """The rotation and the position of the frame in the reference."""
        R, p = kinematics.relative(self.frame, self.reference)
        return R, p[: kinematics.robot.dimension]
