"""Every built-in robot has a tip, a home configuration, limits, and solids around its links."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.errors import UnknownNameError
from jtik.robot import JointType, gallery

from .conftest import pose

EXACT = 1e-12
ARMS = ("panda", "ur5e", "ur5", "iiwa14", "xarm7", "gen3", "jaco2")
ON_VEHICLES = ("vehicle_panda",)
PLANAR = ("vehicle3", "planar10")


@pytest.fixture(scope="module", params=gallery.names())
def robot(request):
    return jtik.Robot.builtin(request.param)


@pytest.fixture(scope="module", params=ARMS + ON_VEHICLES)
def machine(request):
    return jtik.Robot.builtin(request.param)


def test_the_gallery_is_listed():
    assert set(gallery.names()) == {*ARMS, *ON_VEHICLES, *PLANAR}
    for name in gallery.names():
        described = gallery.describe(name)
        assert described.name == name
        assert described.summary
        assert described.source
        assert f'"{name}"' in jtik.Robot.builtin.__doc__


def test_the_error_for_an_unknown_name_has_the_closest_one():
    with pytest.raises(UnknownNameError, match="unknown built-in robot 'pnada'; did you mean 'panda'") as caught:
        jtik.Robot.builtin("pnada")
    assert caught.value.known == gallery.names()


def test_home_is_inside_the_limits_and_not_singular(robot):
    home = robot.keyframes["home"]
    assert robot.tip == "tip"
    assert np.all((robot.lower < home) & (home < robot.upper))
    rows = [0, 1] if robot.dimension == 2 else list(range(6))
    singular_values = np.linalg.svd(robot.jacobian(home)[rows], compute_uv=False)
    assert singular_values[-1] > 0.03 * singular_values[0]


def test_machines_have_limits_and_speeds(machine):
    assert np.all(np.isfinite(machine.velocity_limit))
    bounded = np.isfinite(machine.lower)
    assert np.array_equal(bounded, np.isfinite(machine.upper))
    assert bounded.sum() >= 3
    assert np.all(np.abs(machine.keyframes["home"]) < 2 * np.pi)


def joints_between_solids(robot):
    return [j for j in robot.joints if j.type is JointType.REVOLUTE and j.parent in robot.shapes]


def spine(robot, q, frame):
    """Points along the axes of a frame's capsules in the base frame, (k, 3), and the radius at each, (k,)."""
    T = robot.pose(q, frame)
    points, radii = [], []
    for solid in robot.shapes[frame]:
        if isinstance(solid, jtik.Capsule):
            along = np.linspace(0, 1, 40)[:, None]
            points.append(solid.start + along * (solid.end - solid.start))
            radii.append(np.full(40, solid.radius))
    return np.concatenate(points) @ T[:3, :3].T + T[:3, 3], np.concatenate(radii)


def test_every_link_has_solids_of_some_size(machine):
    links = {joint.child for joint in machine.joints if joint.type is JointType.REVOLUTE}
    assert links <= set(machine.shapes)
    for solids in machine.shapes.values():
        for solid in solids:
            if isinstance(solid, jtik.Capsule):
                assert 0.02 < solid.radius < 0.2
                assert 0.001 < np.linalg.norm(solid.end - solid.start) < 0.6


def test_the_solids_of_neighbours_meet_at_their_joint_whatever_the_posture(machine):
    generator = np.random.default_rng(3)
    for _ in range(3):
        q = machine.random_configuration(generator)
        for joint in joints_between_solids(machine):
            inner, inner_radius = spine(machine, q, joint.parent)
            outer, outer_radius = spine(machine, q, joint.child)
            apart = np.linalg.norm(inner[:, None] - outer, axis=2) - inner_radius[:, None] - outer_radius
            assert apart.min() < 0, joint.name


def test_the_axis_of_every_joint_is_a_line_through_the_solids_of_its_link(machine):
    q = machine.keyframes["home"]
    for joint in joints_between_solids(machine):
        T = machine.pose(q, joint.child)
        points, radii = spine(machine, q, joint.child)
        from_axis = np.linalg.norm(np.cross(points - T[:3, 3], T[:3, 2]), axis=1)
        assert (from_axis - radii).min() < 0, joint.name


def test_the_tip_is_at_the_last_solids(machine):
    q = machine.keyframes["home"]
    last = [joint.child for joint in machine.path() if joint.child in machine.shapes][-1]
    points, radii = spine(machine, q, last)
    assert (np.linalg.norm(points - machine.position(q), axis=1) - radii).min() < 0


def test_the_solids_of_the_ur5e_are_those_of_the_ur5_within_centimetres():
    new, old = jtik.Robot.builtin("ur5e").shapes, jtik.Robot.builtin("ur5").shapes
    assert set(new) == set(old)
    for frame in set(new) - {"base_link"}:  # the new base is 7 cm higher
        for one, other in zip(new[frame], old[frame], strict=True):
            assert np.linalg.norm([one.start - other.start, one.end - other.end], axis=1).max() < 0.02


def test_the_panda_on_a_vehicle_is_the_panda_moved():
    arm, mobile = jtik.Robot.builtin("panda"), jtik.Robot.builtin("vehicle_panda")
    assert mobile.joint_names == ("x", "y", "heading", *arm.joint_names)
    q = mobile.random_configuration(1)
    carried = pose((q[0], q[1], 0.311), (0, 0, q[2])) @ arm.pose(q[3:])
    assert mobile.pose(q) == pytest.approx(carried, abs=EXACT)
    assert set(mobile.shapes) == {"vehicle", *arm.shapes}
    assert isinstance(mobile.shapes["vehicle"][0], jtik.Box)
    assert mobile.velocity_limit[3:].tolist() == arm.velocity_limit.tolist()


@pytest.mark.parametrize(
    ("name", "built"), [("planar10", jtik.Robot.planar(10)), ("vehicle3", jtik.Robot.vehicle(3, heading=True))]
)
def test_planar_robots_are_those_of_the_builders(name, built):
    robot = jtik.Robot.builtin(name)
    assert robot.dimension == 2
    assert robot.joint_names == built.joint_names
    q = robot.random_configuration(2)
    assert np.array_equal(robot.pose(q), built.pose(q))


def test_old_names_are_aliases():
    from jtik.robot import loaders

    with pytest.warns(DeprecationWarning, match=r"Description is now jtik.robot.gallery.GalleryRobot$"):
        assert gallery.Description is gallery.GalleryRobot
    with pytest.warns(DeprecationWarning, match=r"Description is now jtik.robot.loaders.RobotDescription$"):
        assert loaders.Description is loaders.RobotDescription
    for module in (gallery, loaders):
        with pytest.raises(AttributeError, match="has no attribute 'Table'"):
            module.Table  # noqa: B018


@pytest.mark.parametrize("name", gallery.names())
def test_masses_have_a_source_or_a_reason(name):
    described = gallery.describe(name)
    robot = jtik.Robot.builtin(name)
    assert described.mass_source
    assert bool(robot.masses) != described.mass_source.startswith("none: ")
    if robot.masses:
        assert robot.massless_frames == ()
        assert all(np.any(mass.inertia) for mass in robot.masses.values())


def test_the_masses_add_up_to_the_arms():
    """Weights that the makers state: UR5e 20.6 kg, UR5 18.4 kg, Gen3 8.2 kg, with the base [kg]."""
    for name, weight, uncertain in (("ur5e", 20.6, 1.2), ("ur5", 18.4, 2.7), ("gen3", 8.2, 0.1)):
        total = sum(mass.mass for mass in jtik.Robot.builtin(name).masses.values())
        assert total == pytest.approx(weight, abs=uncertain)
