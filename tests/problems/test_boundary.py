"""Boundary and unreachable targets against closed forms and SciPy's constrained optimiser."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import jtik
from jtik import problems

from ..conftest import planar, planar_points
from .conftest import gallery, model_of, mujoco_pose

SHARE = 0.9999
FOUND = 2e-5
"""Accuracy of the boundary, relative to the total link length."""


def test_the_boundary_of_an_unlimited_planar_arm_is_its_length():
    lengths = [0.5, 0.3, 0.2]
    for case in problems.boundary(jtik.Robot.planar(lengths), jtik.FrameTask(), 5):
        assert np.linalg.norm(case.target) == pytest.approx(SHARE * 1.0, abs=1e-12)
        assert case.known["reach"] == pytest.approx(1.0, abs=1e-12)


def test_the_boundary_of_a_planar_pose_has_a_closed_form():
    # a pose fixes the last link, so that two unit links carry its base: |p - (cos, sin)| = 2 at the edge
    robot = planar(3)
    for case in problems.boundary(robot, jtik.FrameTask(kind="pose"), 5):
        x, y, angle = case.target
        direction, last = np.array([x, y]) / np.hypot(x, y), np.array([np.cos(angle), np.sin(angle)])
        along = direction @ last
        edge = along + np.sqrt(along**2 - 1 + 4)
        assert case.known["reach"] == pytest.approx(edge, abs=3 * FOUND)
        assert np.hypot(x, y) == pytest.approx(SHARE * case.known["reach"], abs=1e-12)


def test_the_boundary_within_limits_agrees_with_slsqp():
    robot = jtik.Robot.planar(3, lower=[-1.0, 0.3, 0.2], upper=[1.0, 1.5, 1.2])
    for case in problems.boundary(robot, jtik.FrameTask(), 4):
        distance = np.linalg.norm(case.target)
        direction = case.target / distance
        across = np.array([-direction[1], direction[0]])
        ends = [
            minimize(
                lambda q, d=direction: -planar_points(q)[-1] @ d,
                start,
                method="SLSQP",
                bounds=list(zip(robot.lower, robot.upper, strict=True)),
                constraints={"type": "eq", "fun": lambda q, a=across: planar_points(q)[-1] @ a},
                options={"maxiter": 200, "ftol": 1e-12},
            )
            for start in np.random.default_rng(0).uniform(robot.lower, robot.upper, (8, 3))
        ]
        farthest = max(-end.fun for end in ends if end.success)
        assert case.known["reach"] == pytest.approx(farthest, abs=3 * 3 * FOUND)
        assert distance == pytest.approx(SHARE * case.known["reach"], abs=1e-12)


def test_a_boundary_target_moves_only_in_the_coordinates_that_the_task_keeps():
    robot, task = gallery("panda"), jtik.FrameTask(axes="xy")
    for case in problems.boundary(robot, task, 2):
        assert np.hypot(*case.target[:2]) == pytest.approx(SHARE * case.known["reach"], rel=1e-9)
        assert case.known["reach"] > 0.5


def test_the_smallest_error_of_an_unreachable_target_is_that_of_a_straight_arm():
    robot = jtik.Robot.planar([0.5, 0.3, 0.2])
    for case in problems.unreachable(robot, jtik.FrameTask(), 10):
        distance = np.linalg.norm(case.target)
        assert 1.01 <= distance <= 1.2
        heading = np.arctan2(case.target[1], case.target[0])
        straight = planar_points([heading, 0, 0], [0.5, 0.3, 0.2])[-1]
        assert case.known["error"] == pytest.approx(np.linalg.norm(straight - case.target), abs=1e-12)


@pytest.mark.parametrize("kind", ["position", "pose"])
def test_an_unreachable_target_is_beyond_the_link_lengths_of_mujoco(kind):
    robot = gallery("panda")
    model, _, _ = model_of(robot)
    shoulder = model.body("panda_link1").pos
    beyond_it = [joint.child for joint in robot.path(robot.tip)][1:]
    length = sum(np.linalg.norm(model.body(name).pos) for name in beyond_it)
    made = problems.unreachable(robot, jtik.FrameTask(kind=kind), 10)
    for case in made:
        place = case.target if kind == "position" else case.target[:3, 3]
        assert 1.01 * length - 1e-9 <= np.linalg.norm(place - shoulder) <= 1.2 * length + 1e-9
        assert "error" not in case.known
    farthest = max(
        np.linalg.norm(mujoco_pose(robot, robot.random_configuration(seed))[:3, 3] - shoulder) for seed in range(300)
    )
    nearest = min(np.linalg.norm((c.target if kind == "position" else c.target[:3, 3]) - shoulder) for c in made)
    assert farthest < nearest


def test_a_prismatic_joint_adds_its_stroke_to_the_reach():
    robot = jtik.Robot(
        [
            jtik.Joint("turn", jtik.JointType.REVOLUTE, "base", "arm"),
            jtik.Joint(
                "reach", jtik.JointType.PRISMATIC, "arm", "tip", axis=np.array([1.0, 0, 0]), lower=-0.2, upper=0.7
            ),
        ],
        planar=True,
    )
    for case in problems.boundary(robot, jtik.FrameTask(), 3):
        assert case.known["reach"] == pytest.approx(0.7, abs=FOUND)
    for case in problems.unreachable(robot, jtik.FrameTask(), 3):
        assert np.linalg.norm(case.target) >= 1.01 * 0.7
        assert case.known == {}
