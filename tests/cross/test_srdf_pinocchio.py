"""SRDF files of ``example-robot-data`` against Pinocchio's reading of them: disabled pairs, and states."""

from __future__ import annotations

import warnings
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik

pin = pytest.importorskip("pinocchio")

pytestmark = pytest.mark.robots

EXACT = 1e-12

PAIRS = {
    "panda": ("panda_description/urdf/panda.urdf", "panda_description/srdf/panda.srdf"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "xarm_description/srdf/xarm7.srdf"),
    "talos": ("talos_data/robots/talos_full_v2.urdf", "talos_data/srdf/talos.srdf"),
}


def located(name):
    """The paths of a URDF and its SRDF, and the folder in which their packages are."""
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("needs the package example-robot-data")
    found = []
    for end in PAIRS[name]:
        file = next((file for file in package.files if str(file).endswith(f"robots/{end}")), None)
        if file is None:
            pytest.skip(f"example-robot-data has no {end}")
        found.append(Path(package.locate_file(file)).resolve())
    root = [parent for parent in found[0].parents if parent.name == "robots"][-1]
    return *map(str, found), [str(root.parents[1]), str(root)]


def loaded(name):
    urdf, srdf, _ = located(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # what one of them does not have is reported
        return jtik.Robot.from_urdf(urdf, srdf=srdf)


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", PAIRS)
def test_the_same_pairs_are_disabled(name):
    urdf, srdf, packages = located(name)
    model = pin.buildModelFromUrdf(urdf)
    geometry = pin.buildGeomFromUrdf(model, urdf, pin.GeometryType.COLLISION, package_dirs=packages)
    geometry.addAllCollisionPairs()

    def links():
        shapes = geometry.geometryObjects
        return {
            frozenset(model.frames[shapes[each].parentFrame].name for each in (pair.first, pair.second))
            for pair in geometry.collisionPairs
        }

    before = links()
    pin.removeCollisionPairs(model, geometry, srdf, False)
    removed = before - links()
    own = {frozenset(pair) for pair in loaded(name).disabled_collisions}
    assert own & before == removed
    assert len(removed) > 10
    kept = {frozenset(pair.name.split(" and ")) for pair in loaded(name).collision_pairs()}
    assert not kept & removed


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["panda", "xarm7", "talos"])
def test_the_same_states_are_keyframes(name):
    urdf, srdf, _ = located(name)
    robot, model = loaded(name), pin.buildModelFromUrdf(urdf)
    pin.loadReferenceConfigurations(model, srdf)
    states = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    assert set(states) == set(robot.keyframes)
    for state, q in states.items():
        for joint in robot.joint_names:
            index = model.joints[model.getJointId(joint)].idx_q
            assert robot.keyframes[state][robot.q_slice(joint)] == pytest.approx(np.atleast_1d(q[index]), abs=EXACT)
