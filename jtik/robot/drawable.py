"""The method of `Robot` that draws it."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Drawable:
    """Base of a robot that can be drawn."""

    def plot(self, q: Any = None, **options: Any) -> Any:
        """A figure of one posture or several: `jtik.plotting.posture_figure`.

        Example::

            arm = jtik.Robot.builtin("panda")
            figure = arm.plot(arm.home, obstacles=[jtik.Sphere((0.5, 0.2, 0.4), 0.1)])
            figure.savefig("panda.pdf")

        Args:
            q: a configuration (nq,), several (k, nq), a Solution or a Trajectory; `Robot.home` when None.
            options: obstacles, path, window, width, view, show: those of `posture_figure`.

        Returns:
            A matplotlib Figure, which a notebook shows.

        Raises:
            ArgumentError: when an argument cannot be used.
            MissingExtraError: when matplotlib is not installed.
        """
        robot: Any = self
        plotting, given = import_module("jtik.plotting"), robot.home if q is None else q
        trajectory = import_module("jtik.result").Trajectory
        shown = given if isinstance(given, trajectory) else plotting.configurations_of(robot, given, "q")
        return plotting.posture_figure(robot, shown, **options)
