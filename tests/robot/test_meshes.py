"""Meshes of robots: their files are found and kept, and read when they are drawn."""

from __future__ import annotations

import pickle
import struct
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik._loop.fingerprint import fingerprint
from jtik.robot import Mesh

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

SINGLE = 1e-6
"""Rounding of single precision, in which STL files are written."""


def write_stl(path: Path) -> None:
    """A tetrahedron."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *CORNERS[face].ravel(), 0) for face in FACES)
    path.write_bytes(bytes(80) + struct.pack("<I", len(FACES)) + rows)


def collada(geometry: str, node: str, unit: str = "1") -> str:
    numbers = " ".join(map(str, CORNERS.ravel()))
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit meter="{unit}"/><up_axis>Y_UP</up_axis></asset>
 <library_geometries><geometry id="g"><mesh>
  <source id="p"><float_array id="n" count="12">{numbers}</float_array><technique_common>
   <accessor source="#n" count="4" stride="3"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  {geometry}
 </mesh></geometry></library_geometries>
 <library_visual_scenes><visual_scene id="s">{node}</visual_scene></library_visual_scenes>
</COLLADA>"""


def with_normals(faces: np.ndarray) -> str:
    return " ".join(f"{corner} 0" for corner in faces.ravel())


TRIANGLES = (
    f'<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>'
    f'<input semantic="NORMAL" source="#p" offset="1"/><p>{with_normals(FACES)}</p></triangles>'
)
PLAIN = '<node><instance_geometry url="#g"/></node>'


def spanned(vertices: np.ndarray, faces: np.ndarray) -> set[tuple[float, ...]]:
    """The triangles as sets of corners, without their order."""
    return {tuple(np.sort(vertices[face].round(5), axis=0).ravel()) for face in faces}


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@pytest.fixture
def stl(tmp_path: Path) -> Path:
    (tmp_path / "meshes").mkdir()
    path = tmp_path / "meshes" / "part.stl"
    write_stl(path)
    return path


URDF = """<robot name="r">
 <link name="base"><visual><geometry><mesh filename="{}"/></geometry></visual></link>
 <link name="arm">
  <visual><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.5 0.7"/><geometry><mesh filename="{}" scale="2 1 0.5"/></geometry>
  </visual>
  <visual><geometry><box size="1 1 1"/></geometry></visual>
  <collision><geometry><sphere radius="0.1"/></geometry></collision>
 </link>
 <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


def test_a_urdf_keeps_the_files_poses_and_scales_of_its_visual_meshes(tmp_path: Path, stl: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(
        URDF.format("no/such.stl", "package://somewhere/meshes/part.stl".replace("somewhere", tmp_path.name))
    )
    robot = jtik.Robot.from_urdf(file)
    assert list(robot.meshes) == ["arm"]
    (mesh,) = robot.meshes["arm"]
    assert mesh.file == stl.resolve()
    np.testing.assert_array_equal(mesh.scale, [2, 1, 0.5])
    np.testing.assert_allclose(mesh.pose[:3, :3], Rotation.from_euler("xyz", [0.3, -0.5, 0.7]).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(mesh.pose[:3, 3], [0.1, 0.2, 0.3])
    vertices, faces = mesh.triangles()
    expected = (CORNERS * [2, 1, 0.5]) @ mesh.pose[:3, :3].T + mesh.pose[:3, 3]
    np.testing.assert_allclose(np.sort(vertices, axis=0), np.sort(expected, axis=0), atol=SINGLE)
    assert volume(vertices, faces) == pytest.approx(1.0, rel=1e-5)


def test_an_mjcf_keeps_the_meshes_that_do_not_collide(tmp_path: Path, stl: Path) -> None:
    file = tmp_path / "robot.xml"
    file.write_text("""<mujoco><compiler meshdir="meshes"/><asset><mesh name="a" file="part.stl" scale="1 1 2"/>
 <mesh name="b" file="part.stl"/></asset><worldbody><body name="arm"><joint name="j"/>
 <geom type="mesh" mesh="a" pos="1 2 3" quat="0.5 0.5 0.5 0.5" contype="0" conaffinity="0"/>
 <geom type="mesh" mesh="b"/><geom size="0.1"/></body></worldbody></mujoco>""")
    (mesh,) = jtik.Robot.from_mjcf(file).meshes["arm"]
    np.testing.assert_array_equal(mesh.scale, [1, 1, 2])
    np.testing.assert_allclose(mesh.pose[:3, 3], [1, 2, 3])
    quaternion = Rotation.from_quat([0.5, 0.5, 0.5, 0.5], scalar_first=True)
    np.testing.assert_allclose(mesh.pose[:3, :3], quaternion.as_matrix(), atol=1e-12)


def test_robots_made_from_a_robot_keep_its_meshes(tmp_path: Path, stl: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(URDF.format("meshes/part.stl", "meshes/part.stl"))
    robot = jtik.Robot.from_urdf(file)
    assert list(robot.meshes) == ["base", "arm"]
    others = [
        robot.subset(["j"]),
        robot.with_base(np.eye(4)),
        robot.with_tool(np.eye(4)),
        pickle.loads(pickle.dumps(robot)),
    ]
    for other in others:
        assert {frame: [mesh.file for mesh in own] for frame, own in other.meshes.items()} == {
            "base": [stl.resolve()],
            "arm": [stl.resolve()],
        }


def test_a_fingerprint_does_not_depend_on_meshes(tmp_path: Path, stl: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(URDF.format("meshes/part.stl", "meshes/part.stl"))
    with_meshes = fingerprint(jtik.Robot.from_urdf(file))
    stl.unlink()
    without = jtik.Robot.from_urdf(file)
    assert not without.meshes
    assert fingerprint(without) == with_meshes


@pytest.mark.parametrize(
    "geometry",
    [
        TRIANGLES,
        f'<polylist count="4"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3 3 3</vcount>'
        f"<p>{' '.join(map(str, FACES.ravel()))}</p></polylist>",
        '<polygons count="4"><input semantic="VERTEX" source="#v" offset="0"/>'
        + "".join(f"<p>{' '.join(map(str, face))}</p>" for face in FACES)
        + "</polygons>",
    ],
    ids=["triangles", "polylist", "polygons"],
)
def test_every_form_of_a_collada_geometry_is_read(tmp_path: Path, geometry: str) -> None:
    file = tmp_path / "part.dae"
    file.write_text(collada(geometry, PLAIN))
    vertices, faces = Mesh(file).triangles()
    assert spanned(vertices, faces) == spanned(CORNERS, FACES)
    assert volume(vertices, faces) == pytest.approx(1.0)


def test_polygons_become_triangles(tmp_path: Path) -> None:
    file = tmp_path / "part.dae"
    square = '<input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p>'
    file.write_text(collada(f'<polylist count="1">{square}</polylist>', PLAIN))
    np.testing.assert_array_equal(Mesh(file).triangles()[1], [[0, 1, 2], [0, 2, 3]])


def test_nodes_units_and_scales_of_a_collada_file_are_applied(tmp_path: Path) -> None:
    file = tmp_path / "part.dae"
    inner = '<node><scale>1 2 -1</scale><instance_geometry url="#g"/></node>'
    middle = f"<node><matrix>1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{inner}</node>"
    node = f"<node><translate>1 2 3</translate><rotate>0 0 1 90</rotate>{middle}</node>"
    file.write_text(collada(TRIANGLES, node, "0.01"))
    vertices, faces = Mesh(file, scale=[10.0, 10.0, 10.0]).triangles()
    turn = Rotation.from_euler("z", 90, degrees=True)
    expected = 0.1 * (turn.apply(CORNERS * [1, 2, -1] + [5, 0, 0]) + np.array([1, 2, 3]))
    np.testing.assert_allclose(vertices, expected, atol=1e-12)
    assert volume(vertices, faces) == pytest.approx(2e-3)  # positive: a mirror turns the faces round


def test_the_same_part_is_the_same_as_stl_and_as_collada(tmp_path: Path, stl: Path) -> None:
    file = tmp_path / "part.dae"
    file.write_text(collada(TRIANGLES, PLAIN))
    assert spanned(*Mesh(stl).triangles()) == spanned(*Mesh(file).triangles())


@pytest.mark.parametrize(
    "text",
    [
        "no XML",
        "<COLLADA/>",
        collada('<triangles count="1"><input semantic="VERTEX" source="#v"/><p>0 1 9</p></triangles>', PLAIN),
        collada('<triangles count="1"><input semantic="VERTEX" source="#none"/><p>0 1 2</p></triangles>', PLAIN),
        collada('<triangles count="1"><input semantic="VERTEX" source="#v"/><p>0 1</p></triangles>', PLAIN),
        collada(TRIANGLES, '<node id="a"><instance_node url="#a"/><instance_geometry url="#g"/></node>'),
        collada(TRIANGLES, '<node><matrix>1 2</matrix><instance_geometry url="#g"/></node>'),
    ],
)
def test_a_file_that_is_no_mesh_is_refused(tmp_path: Path, text: str) -> None:
    for suffix in ("dae", "stl", "obj"):
        file = tmp_path / f"part.{suffix}"
        file.write_text(text)
        with pytest.raises(jtik.RobotFileError, match="part"):
            Mesh(file).triangles()


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    for name in ("part.dae", "part.stl", "part.xyz"):
        with pytest.raises(jtik.RobotFileError, match=name):
            Mesh(tmp_path / name).triangles()


def test_meshes_are_checked() -> None:
    joints = jtik.Robot.planar(1).joints
    with pytest.raises(jtik.UnknownNameError, match="mesh"):
        jtik.Robot(joints, meshes={"nowhere": [Mesh("a.stl")]})
    with pytest.raises(jtik.ArgumentError, match=r"meshes\['link1'\]"):
        jtik.Robot(joints, meshes={"link1": ["a.stl"]})
    with pytest.raises(jtik.ArgumentError, match=r"Mesh\.pose"):
        Mesh("a.stl", pose=np.eye(3))
    with pytest.raises(jtik.ArgumentError, match=r"Mesh\.file"):
        Mesh(3)
