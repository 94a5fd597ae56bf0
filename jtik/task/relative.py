"""A frame brought to a place in another frame of the same robot: two arms on one object, a hand over a foot."""

from __future__ import annotations

from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.task.placement import PlacementTask
from jtik.task.targets import Kind
from jtik.task.weighted import Axes


class RelativeFrameTask(PlacementTask):
    """Bring a frame to a target in a reference frame, wherever the robot carries the two.

    Error: position in the *reference's* axes, ``p(q) - p_target`` [m], with p the frame's origin in the reference;
    orientation in the *target's* axes, the logarithm of ``R_target' R(q)`` [rad], with R the frame in the reference.
    Joints that carry both frames do not appear in it. Targets and the plane are as for `FrameTask`.

    Args:
        frame: name of the frame to bring to the target.
        reference: name of the frame in which the target is given.
        kind: "position", "orientation" or "pose".
        axes: which rows to keep, of "x", "y", "z" (position) and "rx", "ry", "rz" (orientation); None keeps all.
        stiffness: a positive scalar, one value a row, or an SPD matrix (m, m).
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task; the name of ``frame`` by default.

    Raises:
        ArgumentError: when both frames are the same, or for a kind, priority or stiffness that cannot be used.
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
    ) -> None:
        if reference == frame:
            raise ArgumentError("reference", reference, "a frame other than the one to bring to the target")
        super().__init__(frame, kind, axes=axes, stiffness=stiffness, priority=priority, name=name)
        self.reference = reference

    def __repr__(self) -> str:
        return f"RelativeFrameTask({self.frame!r}, {self.reference!r}, kind={self.kind!r})"

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """Both would name the joints that carry the two: the error knows which move one against the other."""
        return ()

    def placed(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """In the reference."""
        R, p = kinematics.relative(self.frame, self.reference)
        return R, p[: kinematics.robot.dimension]
