"""InverseKinematics as its users meet it: documented, printed, used from the outside only."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from .conftest import planar

METHODS = ["solve", "solve_batch", "step", "track", "build", "full_configuration", "reduced"]
TOLERANCES = ["position_tolerance", "orientation_tolerance", "optimality_tolerance", "until"]


@pytest.mark.parametrize("name", METHODS)
def test_every_argument_of_a_method_is_documented(name):
    method = getattr(jtik.InverseKinematics, name)
    text = inspect.getdoc(method)
    section = text.split("Args:\n")[1].split("\n\n")[0]
    named = {one for line in re.findall(r"^ {4}([a-z_0-9, ]+):", section, re.M) for one in line.split(", ")}
    assert named == {one for one in inspect.signature(method).parameters if one != "self"}
    assert "Raises:\n    ArgumentError: " in text


def test_tolerances_are_documented_once():
    text = inspect.getdoc(jtik.InverseKinematics)
    for name in TOLERANCES:
        assert f"- ``{name}``: " in text
    for name in ("solve", "solve_batch", "track"):
        method = getattr(jtik.InverseKinematics, name)
        assert f"{', '.join(TOLERANCES)}: see the class." in inspect.getdoc(method)
        assert set(TOLERANCES) <= set(inspect.signature(method).parameters)


def test_it_shows_the_weights_as_they_are():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), criteria=JointCentering() - 0.5 * JointCentering(name="b"))
    assert ", joint_centering + -0.5 * b, " in repr(ik)
    ik.parameters["b.weight"] = 1.0
    assert ", joint_centering + b, " in repr(ik)


def test_attributes_are_what_it_was_built_from():
    limits = jtik.Limits()
    task = jtik.FrameTask()
    ik = jtik.InverseKinematics(planar(3), task, strategy="newton", limits=limits)
    assert ik.robot is planar(3)
    assert ik.tasks.tasks == (task,)
    assert ik.limits is limits
    assert ik.strategy == jtik.strategies["newton"]()
    assert dict(ik.parameters) == {}


def test_repr_names_its_parts():
    criteria = JointCentering() + ObstacleAvoidance(jtik.Point((1, 1)))
    text = repr(jtik.InverseKinematics(planar(3), jtik.FrameTask("tip", "position"), criteria=criteria))
    for part in ("planar3", "FrameTask('tip'", "joint_centering + obstacle_avoidance", "Hybrid("):
        assert part in text


def test_live_parameters_are_those_of_the_next_solve():
    preferred = np.array([0.9, 0.2, -0.3, 0.4])
    ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(), criteria=JointCentering())
    before = ik.solve((2.0, 2.0), q0=[0.3] * 4)
    ik.parameters["joint_centering.preferred"] = preferred
    fresh = jtik.InverseKinematics(planar(4), jtik.FrameTask(), criteria=JointCentering(preferred=preferred))
    after = ik.solve((2.0, 2.0), q0=[0.3] * 4)
    assert after.q.tolist() == fresh.solve((2.0, 2.0), q0=[0.3] * 4).q.tolist()
    assert after.q.tolist() != before.q.tolist()


@pytest.mark.parametrize("given", ["x", None, float("nan"), 1, -1])
def test_compiled_is_a_bool(given):
    with pytest.raises(jtik.ArgumentError, match="^compiled: given .*; accepted: True or False"):
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), compiled=given)


@pytest.mark.parametrize("given", [float("nan"), True, 3.5, [None], [[]]])
def test_joints_are_names(given):
    with pytest.raises(jtik.ArgumentError, match='^joints: given .*; accepted: names of joints, "all", or None'):
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), joints=given)


@pytest.mark.parametrize("given", [float("nan"), True, False, 3.5, "x", [None]])
def test_clearances_are_clearances(given):
    with pytest.raises(
        jtik.ArgumentError, match=r"^clearances: given .*; accepted: a jtik\.Clearance, several, or None"
    ):
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), clearances=given)
