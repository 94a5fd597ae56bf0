"""CenterOfMassTask: against MuJoCo, mink and differences."""

from __future__ import annotations

import mink
import numpy as np
import pytest

import jtik

from ..conftest import DIFFERENCES, EXACT, differences, report_at
from .conftest import built, dh_arm, solver, two_arms, two_arms_model, weighed


def test_error_and_jacobian_agree_with_mink(rng):
    """Of a body that floats: mink reads MuJoCo's subtree_com and mj_jacSubtreeCom."""
    robot = two_arms()
    ik = built(robot, jtik.CenterOfMassTask)
    theirs, configuration = mink.ComTask(cost=1.0), mink.Configuration(two_arms_model())
    for _ in range(10):
        q, target = robot.random_configuration(rng), rng.uniform(-1, 1, 3)
        configuration.update(q)
        theirs.set_target(target)
        found = report_at(ik, q, target)
        assert found.error == pytest.approx(theirs.compute_error(configuration), abs=EXACT)
        assert found.jacobian == pytest.approx(theirs.compute_jacobian(configuration), abs=EXACT)
        assert found.position_error == pytest.approx(np.linalg.norm(found.error), abs=EXACT)


@pytest.mark.parametrize("make", [two_arms, weighed])
def test_jacobian_is_the_derivative_of_the_error(make, rng):
    robot = make()
    ik = built(robot, jtik.CenterOfMassTask)
    target = np.zeros(robot.dimension)
    for q in (robot.neutral, robot.random_configuration(rng)):  # the planar arm's neutral is straight
        numeric = differences(lambda at: report_at(ik, at, target).error, robot, q)
        assert report_at(ik, q, target).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


def test_in_the_plane_it_is_the_weighted_mean_of_points():
    found = report_at(built(weighed(), jtik.CenterOfMassTask), np.zeros(3), (0.0, 0.0))
    points = np.array([[0.1, 0.02], [0.5 + 0.2, 0.02], [0.9 + 0.3, 0.02]])
    assert found.error == pytest.approx(np.array([3, 2, 1]) @ points / 6, abs=EXACT)


@pytest.mark.parametrize(("axes", "rows"), [("xy", [0, 1]), ("z", [2]), (("y", "x"), [1, 0]), ("zyx", [2, 1, 0])])
def test_axes_keep_their_rows_of_a_point(axes, rows, rng):
    robot = two_arms()
    q, target = robot.random_configuration(rng), rng.uniform(-1, 1, 3)
    full = report_at(built(robot, jtik.CenterOfMassTask), q, target)
    part = report_at(built(robot, jtik.CenterOfMassTask, axes=axes), q, target)
    assert part.error == pytest.approx(full.error[rows], abs=EXACT)
    assert part.jacobian == pytest.approx(full.jacobian[rows], abs=EXACT)


@pytest.mark.parametrize(("axes", "target"), [("xy", (0.1, 0.2)), ("yx", (0.2, 0.1)), ("y", [0.2])])
def test_a_target_may_be_the_chosen_coordinates_alone(axes, target):
    robot = two_arms()
    ik = built(robot, jtik.CenterOfMassTask, axes=axes)
    full = report_at(ik, robot.neutral, (0.1, 0.2, 7.0))
    assert report_at(ik, robot.neutral, target).error.tolist() == full.error.tolist()


def test_balance_is_reached(rng):
    robot = two_arms()
    tasks = [jtik.CenterOfMassTask(axes="xy"), jtik.FrameTask("trunk", "pose")]
    goal = robot.random_configuration(rng)
    target = {"center_of_mass": robot.center_of_mass(goal)[:2], "trunk": robot.pose(goal, "trunk")}
    solution = solver(robot, tasks).solve(target, q0=robot.integrate(goal, rng.uniform(-0.3, 0.3, robot.n)))
    assert solution.converged
    assert robot.center_of_mass(solution.q)[:2] == pytest.approx(target["center_of_mass"], abs=2e-6)


def test_a_robot_without_masses_is_refused():
    with pytest.raises(jtik.ArgumentError, match="robot.*a robot with masses"):
        built(dh_arm(), jtik.CenterOfMassTask)


@pytest.mark.parametrize("axes", ["rx", "", "xx", 3])
def test_unknown_repeated_or_no_axes_are_refused(axes):
    with pytest.raises(jtik.ArgumentError, match="axes") as caught:
        built(two_arms(), jtik.CenterOfMassTask, axes=axes)
    assert caught.value.argument == "axes"


@pytest.mark.parametrize("target", [(1.0,), 1.0, (0, 0, 0, 0), np.eye(4), "here", None, (np.nan, 0.0), (0, 0, np.inf)])
def test_an_invalid_target_is_refused(target):
    ik = built(two_arms(), jtik.CenterOfMassTask, axes="xy")
    with pytest.raises(jtik.ArgumentError, match=r"(?s)^target: .*\(x, y, z\) \[m\], or \(x, y\)"):
        ik.solve(target)
