"""Solids on the frames of a loaded robot: at the poses of the file, and enclosing all of a mesh."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik import Box, Capsule, Cylinder, Robot, Sphere

mujoco = pytest.importorskip("mujoco")

from jtik.robot.loaders.meshes import solid_around  # noqa: E402

EXACT = 1e-12
SINGLE = 1e-6
"""MuJoCo keeps vertices in single precision."""

TETRAHEDRON = "0 0 0  0.3 0 0  0 0.1 0  0 0 0.2"


def mjcf(geoms, assets=""):
    return f"""<mujoco><compiler angle="radian"/><asset>{assets}</asset><worldbody><geom type="plane" size="1 1 1"/>
    <body name="a"><joint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>{geoms}</body></worldbody></mujoco>"""


def only(robot, frame="a"):
    assert set(robot.shapes) == {frame}
    (solid,) = robot.shapes[frame]
    return solid


def test_primitives_keep_their_pose_and_size():
    pose = 'pos="0.1 0.2 0.3" axisangle="1 0 0 0.5"'
    R = Rotation.from_rotvec([0.5, 0, 0]).as_matrix()
    center = np.array([0.1, 0.2, 0.3])
    sphere = only(Robot.from_mjcf(mjcf(f'<geom type="sphere" size="0.4" {pose}/>')))
    assert isinstance(sphere, Sphere)
    assert (sphere.center.tolist(), sphere.radius) == (center.tolist(), 0.4)
    for name, kind in (("capsule", Capsule), ("cylinder", Cylinder)):
        rod = only(Robot.from_mjcf(mjcf(f'<geom type="{name}" size="0.1 0.5" {pose}/>')))
        assert type(rod) is kind
        assert rod.radius == 0.1
        assert rod.start == pytest.approx(center - 0.5 * R[:, 2], abs=EXACT)
        assert rod.end == pytest.approx(center + 0.5 * R[:, 2], abs=EXACT)
    box = only(Robot.from_mjcf(mjcf(f'<geom type="box" size="0.1 0.2 0.3" {pose}/>')))
    assert isinstance(box, Box)
    assert box.half.tolist() == [0.1, 0.2, 0.3]
    assert box.pose[:3, :3] == pytest.approx(R, abs=EXACT)
    assert box.pose[:3, 3] == pytest.approx(center, abs=EXACT)


@pytest.mark.parametrize("size", [(0.3, 0.1, 0.2), (0.1, 0.3, 0.2), (0.2, 0.2, 0.2), (0.1, 0.1, 0.4)])
def test_an_ellipsoid_is_inside_its_capsule_and_touches_it(size):
    capsule = only(Robot.from_mjcf(mjcf(f'<geom type="ellipsoid" size="{" ".join(map(str, size))}"/>')))
    directions = np.random.default_rng(0).standard_normal((2000, 3))
    surface = directions / np.linalg.norm(directions, axis=1, keepdims=True) * size
    assert outside(capsule, surface).max() <= EXACT
    assert np.linalg.norm(capsule.end) + capsule.radius == pytest.approx(max(size), abs=EXACT)


def outside(solid, points):
    """Signed distance of points from a capsule or a ball."""
    if isinstance(solid, Sphere):
        return np.linalg.norm(points - solid.center, axis=1) - solid.radius
    along = solid.end - solid.start
    where = np.clip((points - solid.start) @ along / max(along @ along, 1e-300), 0, 1)
    return np.linalg.norm(points - solid.start - where[:, None] * along, axis=1) - solid.radius


def test_visual_geoms_are_used_where_none_collides():
    show = '<geom type="sphere" size="1" contype="0" conaffinity="0"/>'
    touch = '<geom type="sphere" size="2"/>'
    assert only(Robot.from_mjcf(mjcf(show + touch))).radius == 2
    text = mjcf(show).replace('<geom type="plane"', '<geom contype="0" conaffinity="0" type="plane"')
    assert only(Robot.from_mjcf(text)).radius == 1


def test_urdf_collisions_are_used_and_visuals_are_not():
    robot = Robot.from_urdf(
        """<robot name="r"><link name="base"><collision><origin xyz="0 0 1"/><geometry><box size="1 2 4"/></geometry>
        </collision></link><link name="a"><visual><geometry><sphere radius="1"/></geometry></visual></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint></robot>"""
    )
    box = only(robot, "base")
    assert box.half.tolist() == [0.5, 1.0, 2.0]
    assert box.pose[:3, 3].tolist() == [0.0, 0.0, 1.0]


def test_a_solid_of_no_size_is_dropped_but_not_the_robot():
    robot = Robot.from_urdf(
        """<robot name="r"><link name="base"/><link name="a"><collision><geometry><box size="0 2 4"/></geometry>
        </collision></link><joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint></robot>"""
    )
    assert robot.n == 1
    assert not robot.shapes


def vertices(scale=1.0):
    return np.array(TETRAHEDRON.split(), dtype=float).reshape(-1, 3) * scale


def test_a_mesh_becomes_a_solid_around_it_from_a_file_and_from_a_model():
    text = mjcf(
        '<geom type="mesh" mesh="m" pos="0.1 0.2 0.3" axisangle="1 0 0 0.5"/>',
        f'<mesh name="m" vertex="{TETRAHEDRON}" scale="2 2 2"/>',
    )
    points = vertices(2) @ Rotation.from_rotvec([0.5, 0, 0]).as_matrix().T + [0.1, 0.2, 0.3]
    for robot in (Robot.from_mjcf(text), Robot.from_mujoco(mujoco.MjModel.from_xml_string(text))):
        distance = outside(only(robot), points)
        assert distance.max() <= SINGLE
        assert distance.max() >= -1e-4


def stl(path, points):
    """A binary STL of a tetrahedron."""
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    rows = np.zeros(4, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = points[faces]
    path.write_bytes(b"\0" * 80 + np.uint32(4).tobytes() + rows.tobytes())


@pytest.mark.parametrize(
    "address", ["package://fancy_arm/meshes/a.stl", "../meshes/a.stl", "package:///fancy_arm/meshes/a.stl"]
)
@pytest.mark.parametrize("folder", ["fancy_arm", "checkout"])
def test_mesh_files_are_found_beside_the_urdf(tmp_path, address, folder):
    (tmp_path / folder / "meshes").mkdir(parents=True)
    (tmp_path / folder / "urdf").mkdir()
    stl(tmp_path / folder / "meshes" / "a.stl", vertices())
    path = tmp_path / folder / "urdf" / "arm.urdf"
    path.write_text(
        f"""<robot name="r"><link name="base"/><link name="a"><collision><origin xyz="0 0 1"/><geometry>
        <mesh filename="{address}" scale="1 -1 1"/></geometry></collision></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint></robot>"""
    )
    robot = Robot.from_urdf(path)
    if folder == "checkout" and address.startswith("package"):
        assert not robot.shapes
    else:
        assert outside(only(robot), vertices() * [1, -1, 1] + [0, 0, 1]).max() <= SINGLE


@pytest.mark.parametrize("name", ["a.stl", "a.dae", "a.obj"])
def test_a_mesh_that_cannot_be_read_gives_no_shape(tmp_path, name):
    (tmp_path / name).write_text("this is no mesh")
    path = tmp_path / "arm.xml"
    path.write_text(mjcf('<geom type="mesh" mesh="m"/>', f'<mesh name="m" file="{name}"/>'))
    assert not Robot.from_mjcf(path).shapes


@pytest.mark.parametrize("stretch", [(1, 1, 1), (5, 1, 1), (0.1, 1, 3), (1, 1, 0), (1, 0, 0), (0, 0, 0)])
def test_the_solid_around_points_holds_all_and_is_not_larger_than_their_ball(stretch):
    generator = np.random.default_rng(3)
    rotation = Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix()
    points = generator.uniform(-1, 1, (200, 3)) * stretch @ rotation.T + [1, 2, 3]
    solid = solid_around(points)
    assert outside(solid, points).max() <= EXACT
    middle = (points.max(axis=0) + points.min(axis=0)) / 2
    ball = np.linalg.norm(points - middle, axis=1).max()
    assert solid.radius <= ball * (1 + SINGLE)


def test_a_long_mesh_gets_a_capsule_and_a_round_one_a_round_solid():
    rod = solid_around(np.random.default_rng(1).uniform(-1, 1, (500, 3)) * [1, 0.05, 0.05])
    assert isinstance(rod, Capsule)
    assert rod.radius < 0.08
    directions = np.random.default_rng(2).standard_normal((500, 3))
    ball = solid_around(directions / np.linalg.norm(directions, axis=1, keepdims=True))
    assert ball.radius == pytest.approx(1.0, abs=0.02)
