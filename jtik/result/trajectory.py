"""Joint motion along a path of targets."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.result.deprecated import RenamedAttribute
from jtik.result.status import Status
from jtik.types import Array


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Joint motion along a path of k targets, as `InverseKinematics.track` returns it.

    Attributes:
        times: time of each row, (k,) [s]; the start is at time 0 and not a row.
        start: configuration at time 0, (nq,); NaN from a file that does not have it.
        q: configurations, (k, nq) [rad] and [m].
        dq: mean velocity on the way to each row, (k, n) [rad/s] and [m/s].
        error_norm: norm of the task error at each target, [m] and [rad] together, (k,).
        position_error: norm of the position error at each target, (k,) [m]; NaN from a file that does not have it.
        orientation_error: norm of the orientation error at each target, (k,) [rad]; NaN as well.
        status: why the solve for each target stopped, k of them.
        iterations: steps tried for each target, (k,).
        seconds: wall time of each solve, (k,) [s].
        joint_names: the joints of q, in its order.
        joint_sizes: how many numbers of q each joint has: 1, of a ball joint 4, of a free joint 7. Empty from a file
            that does not have it, of a robot with such joints.
        complete: whether the path was followed to its end. False when Ctrl-C ended `InverseKinematics.track`. A
            ``.csv`` does not have it.

    Example:
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"))
        >>> motion = ik.track([[2.5, 0.01 * k] for k in range(50)], q0=[0.5, -0.5, -0.5], dt=0.02)
        >>> motion.save("motion.csv")
    """

    times: Array
    start: Array
    q: Array
    dq: Array
    error_norm: Array
    position_error: Array
    orientation_error: Array
    status: tuple[Status, ...]
    iterations: NDArray[np.int64]
    seconds: Array
    joint_names: tuple[str, ...]
    joint_sizes: tuple[int, ...]
    complete: bool = True

    errors = RenamedAttribute("error_norm")
    statuses = RenamedAttribute("status")

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Whether each target was reached, (k,)."""
        return np.array([status.on_target for status in self.status], dtype=bool)

    @property
    def converged(self) -> bool:
        """Whether the path was followed to its end and every target was reached."""
        return self.complete and bool(self.reached.all())

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        reached, worst = int(self.reached.sum()), float(self.error_norm.max(initial=0.0))
        duration = float(self.times[-1]) if len(self) else 0.0
        ended = "" if self.complete else ", ended by Ctrl-C"
        return (
            f"Trajectory: {reached} of {len(self)} targets reached, {duration:.3g} s, largest error {worst:.3g}{ended}"
        )

    def save(self, path: str | Path) -> None:
        """Write it to a ``.csv``, a ``.json`` or a ``.npz`` file; `load` reads each back to the last bit.

        A ``.csv`` is a table with one line of titles, as ``pandas.read_csv`` reads it. Its first row is the start, with
        the status START. The columns are "time" [s], the position of each joint under the joint's name, its velocity
        under "velocity.NAME", and then error_norm, position_error, orientation_error, status, iterations and seconds.
        A ball or free joint has the columns "NAME[0]", "NAME[1]" and so on. The name of a joint that looks like one of
        the other titles is followed by " (joint)".

        A ``.json`` is an object with the attributes as keys, null for NaN.

        Args:
            path: file to write; its suffix determines the format.

        Raises:
            ArgumentError: for another suffix, or for a ``.csv`` without `joint_sizes`.
            OSError: when the file cannot be written.
        """
        from jtik.result.trajectory_file import save

        save(self, path)

    def plot(self, robot: Any = None, **options: Any) -> Any:
        """A figure of the joints by time; or, with a robot, of its postures and the path of its end effector.

        Example::

            trajectory = ik.track(targets, dt=0.02)
            trajectory.plot().savefig("joints.pdf")
            trajectory.plot(ik.robot, obstacles=field).savefig("postures.pdf")

        Args:
            robot: the robot whose configurations these are, ``ik.robot``; None for positions [rad, m], velocities
                [rad/s, m/s] and the task error by time [s].
            options: those of `jtik.plotting.trajectory_figure`, or with a robot of `jtik.plotting.posture_figure`.

        Returns:
            A matplotlib Figure, which a notebook shows.

        Raises:
            ArgumentError: when an argument cannot be used.
            MissingExtraError: when matplotlib is not installed.
        """
        plotting = import_module("jtik.plotting")
        if robot is None:
            return plotting.trajectory_figure(self, **options)
        return plotting.posture_figure(robot, self, **options)

    def animate(self, path: str | Path, robot: Any, **options: Any) -> None:
        """Write a GIF of the robot on this trajectory, at its speed: `jtik.plotting.write_motion`.

        Example::

            trajectory = ik.track(targets, dt=0.02)
            trajectory.animate("arm.gif", ik.robot, obstacles=field)

        Args:
            path: the file to write, which ends in ".gif".
            robot: the robot whose configurations these are, ``ik.robot``.
            options: obstacles, speed, rate [1/s], width [inch], view [degrees], show: those of `write_motion`.

        Raises:
            ArgumentError: when an argument cannot be used.
            MissingExtraError: when matplotlib or pillow is not installed.
            OSError: when the file cannot be written.
        """
        import_module("jtik.plotting").write_motion(path, robot, self, **options)

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file that `save` wrote, in this version or an earlier one.

        Args:
            path: a ``.csv``, a ``.json`` or a ``.npz`` file.

        Raises:
            ArgumentError: for another suffix, or a file that is not a trajectory.
            OSError: when the file cannot be read.
        """
        from jtik.result.trajectory_file import load

        return load(path)
