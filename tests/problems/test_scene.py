"""Scenes: clearances against sampled links and MuJoCo, and live obstacles of a criterion."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

import jtik
from jtik import problems
from jtik.interop.mink import MujocoCorrespondence, to_mujoco

from ..conftest import planar, planar_points
from .conftest import gallery


def nearest(q, centers, radii):
    """Smallest distance of the links of a planar arm to the circles, from a thousand points on each link."""
    joints = np.vstack([[0, 0], planar_points(q)])
    share = np.linspace(0, 1, 1001)[:, None]
    links = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(joints)])
    return (np.linalg.norm(links[:, None] - centers, axis=2) - radii).min()


def test_the_clearance_of_a_planar_scene_is_correct():
    for case in problems.scene(planar(6), jtik.FrameTask(), 5, obstacles=4, radius=(0.02, 0.08), clearance=0.02):
        centers = case.parameters["obstacle_avoidance.centers"]
        radii = case.parameters["obstacle_avoidance.radii"]
        assert centers.shape == (4, 2)
        assert (radii >= 0.02 * 6).all()
        assert (radii <= 0.08 * 6).all()
        assert case.known["clearance_start"] == pytest.approx(nearest(case.q0, centers, radii), abs=1e-5)
        assert case.known["clearance_start"] >= 0.02 * 6
        assert case.known["clearance_goal"] >= 0.02 * 6


def test_the_goal_of_a_scene_is_collision_free_and_meets_the_target():
    # two links have at most two solutions, one of which is the goal
    robot = planar(2)
    for case in problems.scene(robot, jtik.FrameTask(), 5, obstacles=3):
        x, y = case.target
        elbow = np.arccos(np.clip((x * x + y * y - 2) / 2, -1, 1))
        circles = (case.parameters["obstacle_avoidance.centers"], case.parameters["obstacle_avoidance.radii"])
        postures = [(np.arctan2(y, x) - np.arctan2(np.sin(e), 1 + np.cos(e)), e) for e in (elbow, -elbow)]
        clearances = [nearest(np.array(q), *circles) for q in postures]
        assert min(abs(c - case.known["clearance_goal"]) for c in clearances) < 1e-5


def test_clearance_of_solids_agrees_with_mujoco():
    robot = gallery("panda")
    for case in problems.scene(robot, jtik.FrameTask(), 2, obstacles=3, shapes=True):
        balls = problems.obstacles_of(case)
        model = to_mujoco(robot, obstacles=balls)
        data = mujoco.MjData(model)
        data.qpos[:] = MujocoCorrespondence(robot, model).qpos(case.q0)
        mujoco.mj_forward(model, data)
        base = {i for i in range(model.ngeom) if model.geom(i).name.startswith("panda_link0")}
        obstacles = [model.geom(f"obstacle{i}").id for i in range(3)]
        links = [i for i in range(model.ngeom) if i not in base and i not in obstacles]
        distances = [mujoco.mj_geomDistance(model, data, i, j, 5.0, None) for i in links for j in obstacles]
        assert min(distances) == pytest.approx(case.known["clearance_start"], abs=1e-6)


def test_obstacles_are_live_parameters_of_criterion_and_clearance():
    robot, task = planar(4), jtik.FrameTask()
    made = problems.scene(robot, task, 3, obstacles=2, criteria=("obstacle_avoidance", "clearance"))
    avoidance = jtik.criteria["obstacle_avoidance"](problems.obstacles_of(made[0]), bodies="links")
    clearance = jtik.Clearance(avoidance)
    ik = jtik.InverseKinematics(robot, task, criteria=avoidance, clearances=clearance, strategy="hybrid+qp")
    made.check(robot, task, parameters=ik.parameters)
    for name, value in made[2].parameters.items():
        ik.parameters[name] = value
        assert (ik.parameters[name] == value).all()


def test_obstacles_of_a_case_are_circles_or_spheres_and_a_case_without_is_refused():
    case = problems.scene(planar(3), jtik.FrameTask(), 1, obstacles=2)[0]
    circles = problems.obstacles_of(case)
    assert [type(circle) for circle in circles] == [jtik.Circle] * 2
    assert circles[1].center.tolist() == case.parameters["obstacle_avoidance.centers"][1].tolist()
    spheres = problems.obstacles_of(problems.scene(gallery("panda"), jtik.FrameTask(), 1, obstacles=1)[0])
    assert isinstance(spheres[0], jtik.Sphere)
    with pytest.raises(jtik.ArgumentError, match=r"clearance\.centers"):
        problems.obstacles_of(case, "clearance")
