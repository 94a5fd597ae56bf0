"""``jtik.view``: robots, solutions, trajectories and comparisons in a browser."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeGuard

from jtik.arguments import choice, positive_integer
from jtik.constructors import lists_arguments
from jtik.errors import ArgumentError
from jtik.geometry import Scene, Solid
from jtik.plotting.obstacles_in import shown_obstacles
from jtik.robot import Robot
from jtik.viewer.arm import SHOWS
from jtik.viewer.subjects import read_subjects
from jtik.viewer.viewer import Viewer

if TYPE_CHECKING:
    from jtik.result import Solution, Trajectory
    from jtik.solver import InverseKinematics
    from jtik.study.comparison import Comparison


@lists_arguments
def view(
    *subjects: Robot | InverseKinematics | Solution | Trajectory | Comparison | Any,
    robot: Robot | None = None,
    obstacles: Iterable[Solid] | Scene = (),
    labels: Iterable[str] | None = None,
    show: str = "meshes",
    port: int | None = None,
    height: int = 500,
) -> Viewer:
    """Show robots, solutions and trajectories in 3-D in a browser, at an address of this machine only.

    Several are overlaid in different colours. Each has a slider for each joint [rad] or [m]. An arm that does not move
    by itself has a target to drag, which its solver follows. Trajectories have one slider over time [s]. A robot is
    drawn by the meshes of its files where they are found, else by its solids, else by links between its joints.

    Example::

        ik = jtik.InverseKinematics(jtik.Robot.builtin("panda"), jtik.FrameTask(kind="pose"))
        viewer = jtik.view(ik)  # in a notebook the last line of a cell; in a script viewer.wait()
        viewer.close()

    Args:
        subjects: a Robot or an InverseKinematics, each followed by what it is to show, if not its home configuration:
            Solutions, Trajectories, or configurations (nq,). Or one Comparison alone, with its contenders overlaid.
        robot: the robot of the Solutions, Trajectories and configurations that no robot or solver precedes.
        obstacles: the obstacles, or a `Scene`, in place of those of the solvers' criteria and clearances.
        labels: names of the arms in the panel; those of the robots by default.
        show: "meshes", "shapes" or "links".
        port: the port; any free one by default.
        height: height of the frame in a notebook [pixel].

    Returns:
        The viewer, which has `Viewer.url`, `Viewer.wait` and `Viewer.close`.

    Raises:
        ArgumentError: when an argument cannot be used, or the port is in use.
        MissingExtraError: when viser is not installed.
    """
    choice("show", show, SHOWS)
    height = positive_integer("height", height)
    solids = shown_obstacles(obstacles)
    if len(subjects) == 1 and _is_comparison(subjects[0]):
        for name, value in (("robot", robot), ("labels", labels)):
            if value is not None:
                raise ArgumentError(name, value, "None for a Comparison, which has its own")
        from jtik.viewer.comparison import view_comparison

        return view_comparison(subjects[0], solids, show=show, port=port, height=height)
    found = read_subjects(subjects, robot, labels)
    return Viewer(found, solids, show=show, port=port, height=height)


def _is_comparison(given: Any) -> TypeGuard[Comparison]:
    from jtik.study.comparison import Comparison

    return isinstance(given, Comparison)
