"""Several tasks at once: stacked rows, targets by name."""

from __future__ import annotations

import functools
from typing import ClassVar

import numpy as np
import pytest

import jtik

from ..conftest import EXACT, report_at
from .conftest import planar, solver, two_arms


class TestSeveralTasks:
    def test_errors_and_jacobians_stack_in_the_order_given(self, rng):
        robot = planar(6)
        tip, elbow = jtik.FrameTask("tip"), jtik.FrameTask("link4", "orientation", name="elbow")
        both = solver(robot, [tip, elbow])
        q = robot.random_configuration(rng)
        found = report_at(both, q, {"tip": (1.0, 2.0), "elbow": 0.4})
        one, other = report_at(solver(robot, tip), q, (1.0, 2.0)), report_at(solver(robot, elbow), q, 0.4)
        assert found.error == pytest.approx([*one.error, *other.error], abs=EXACT)
        assert found.jacobian == pytest.approx(np.vstack([one.jacobian, other.jacobian]), abs=EXACT)
        assert found.position_error == pytest.approx(one.position_error, abs=EXACT)
        assert found.orientation_error == pytest.approx(other.orientation_error, abs=EXACT)

    def test_both_are_reached(self, rng):
        robot = planar(6)
        ik = solver(robot, [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow")])
        goal = rng.uniform(-0.5, 0.5, 6)
        solution = ik.solve({"tip": robot.position(goal), "elbow": robot.position(goal, "link4")}, q0=goal + 0.2)
        assert solution.converged
        assert robot.position(solution.q, "link4") == pytest.approx(robot.position(goal, "link4"), abs=2e-6)

    def test_stiffness_blocks_stay_apart(self, rng):
        robot = planar(6)
        tasks = [
            jtik.FrameTask("tip", stiffness=[[2.0, 0.5], [0.5, 1.0]]),
            jtik.FrameTask("link4", stiffness=3.0),
        ]
        q = robot.random_configuration(rng)
        solution = solver(robot, tasks).solve({"tip": (0, 1), "link4": (1, 1)}, q0=q, max_iterations=1, trace=True)
        Kp = np.diag([2.0, 1.0, 3.0, 3.0])
        Kp[0, 1] = Kp[1, 0] = 0.5
        e = np.concatenate([robot.position(q) - (0, 1), robot.position(q, "link4") - (1, 1)])
        assert solution.trace.V[0] == pytest.approx(e @ Kp @ e / 2, rel=EXACT)

    @pytest.mark.parametrize("target", [(1.0, 1.0), {"tip": (1.0, 1.0)}, {"tip": (1, 1), "link": (1, 1)}])
    def test_a_target_for_each_is_needed(self, target):
        ik = solver(planar(4), [jtik.FrameTask("tip"), jtik.FrameTask("link3")])
        with pytest.raises(jtik.ArgumentError, match=r"target.*\['tip', 'link3'\]"):
            ik.solve(target)

    @pytest.mark.parametrize("tasks", [[], [jtik.FrameTask(), jtik.FrameTask()], ["tip"], [None]])
    def test_no_task_a_repeated_name_or_another_object_is_refused(self, tasks):
        with pytest.raises(jtik.ArgumentError, match="^task: "):
            solver(planar(2), tasks)


@functools.cache
def named_tasks():
    hand = jtik.FrameTask("left", "pose", name="left hand")
    return solver(two_arms(), [hand, jtik.LookAtTask("eye"), jtik.CenterOfMassTask(axes="xy")])


class TestTargetsByName:
    GOOD: ClassVar = {"left hand": np.eye(4), "eye": (1.0, 0.0, 1.0), "center_of_mass": (0.0, 0.0)}

    def test_valid_targets_are_accepted(self):
        assert np.isfinite(report_at(named_tasks(), two_arms().neutral, self.GOOD).error).all()

    @pytest.mark.parametrize(
        ("name", "invalid", "accepted"),
        [
            ("left hand", np.diag([1.0, 1.0, -1.0, 1.0]), "determinant"),
            ("left hand", np.full((4, 4), np.nan), "finite"),
            ("left hand", (1.0, 2.0, 3.0), "quaternion"),
            ("eye", (1.0, 2.0), "a point"),
            ("center_of_mass", np.eye(4), r"\(x, y\)"),
        ],
    )
    def test_an_error_names_the_invalid_target(self, name, invalid, accepted):
        ik = named_tasks()
        with pytest.raises(jtik.ArgumentError, match=f"(?s)accepted: .*{accepted}") as caught:
            ik.solve({**self.GOOD, name: invalid})
        assert caught.value.argument == f"target[{name!r}]"
        assert caught.value.given is invalid

    def test_one_task_may_have_a_dict_too(self):
        ik = solver(planar(3), jtik.FrameTask("tip"))
        assert report_at(ik, np.zeros(3), {"tip": (1.0, 0.5)}).error == pytest.approx([2.0, -0.5], abs=EXACT)
        with pytest.raises(jtik.ArgumentError, match=r"^target\['tip'\]: "):
            ik.solve({"tip": (1.0, np.nan)})

    def test_a_name_that_is_no_text_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="^target: "):
            solver(planar(3), jtik.FrameTask("tip")).solve({3: (0, 0), "tip": (0, 0)})


def test_every_kind_at_once_on_a_floating_base(rng):
    """A hand in the world, the other in its axes, balance and gaze: 15 rows on 15 degrees of freedom, nq = 16."""
    robot = two_arms()
    tasks = [
        jtik.FrameTask("left", "pose"),
        jtik.RelativeFrameTask("right", "left", "position"),
        jtik.CenterOfMassTask(axes="xy"),
        jtik.AxisTask("head", name="upright", stiffness=2.0),
        jtik.LookAtTask("eye"),
    ]
    ik = solver(robot, tasks)
    for _ in range(3):
        goal = robot.integrate(robot.neutral, rng.uniform(-0.5, 0.5, robot.n))
        eye, left = robot.pose(goal, "eye"), robot.pose(goal, "left")
        target = {
            "left": left,
            "right": (np.linalg.inv(left) @ robot.pose(goal, "right"))[:3, 3],
            "center_of_mass": robot.center_of_mass(goal)[:2],
            "upright": robot.pose(goal, "head")[:3, 2],
            "eye": eye[:3, 3] + 2 * eye[:3, 2],
        }
        assert report_at(ik, goal, target).error == pytest.approx(np.zeros(15), abs=1e-9)
        solution = ik.solve(target, q0=robot.integrate(goal, rng.uniform(-0.2, 0.2, robot.n)))
        assert solution.converged
        assert robot.pose(solution.q, "left") == pytest.approx(left, abs=5e-6)
        assert robot.center_of_mass(solution.q)[:2] == pytest.approx(target["center_of_mass"], abs=5e-6)


def test_rows_are_counted_without_building_them():
    robot = two_arms()
    tasks = (
        jtik.FrameTask("left", "pose", axes=("x", "rz")),
        jtik.RelativeFrameTask("right", "left"),
        jtik.CenterOfMassTask(axes="z"),
        jtik.AxisTask("head"),
        jtik.LookAtTask("eye"),
    )
    for task in tasks:
        assert task.row_count(robot) == jtik.Task.row_count(task, robot) == len(task.weight(task.row_count(robot)))
