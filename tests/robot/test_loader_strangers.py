"""Robot files that somebody else has made: errors that name the file, at once."""

from __future__ import annotations

import os

import pytest

import jtik
from jtik.robot.loaders import reading

LOADERS = {"urdf": jtik.Robot.from_urdf, "mjcf": jtik.Robot.from_mjcf}

MESH = """<robot name="r"><link name="a"><collision><geometry><mesh filename="{}"/></geometry></collision>
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@pytest.mark.parametrize("load", LOADERS.values(), ids=LOADERS)
class TestFilesThatAreNone:
    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
    def test_a_pipe_is_not_waited_for(self, load, tmp_path):
        os.mkfifo(tmp_path / "pipe.xml")
        with pytest.raises(jtik.RobotFileError, match=r"pipe.xml: a pipe, a device or a socket; accepted: the path"):
            load(tmp_path / "pipe.xml")

    @pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="no such device")
    def test_a_device_is_not_read(self, load):
        with pytest.raises(jtik.RobotFileError, match="^/dev/zero: a pipe, a device"):
            load("/dev/zero")

    def test_a_folder(self, load, tmp_path):
        with pytest.raises(jtik.RobotFileError, match="Is a directory|Permission denied"):
            load(tmp_path)

    def test_a_path_with_a_nul_character(self, load):
        with pytest.raises(jtik.RobotFileError, match=r"a\\x00b.xml: no path"):
            load("a\0b.xml")

    def test_a_name_that_is_too_long(self, load, tmp_path):
        with pytest.raises(jtik.RobotFileError, match="File name too long|No such file"):
            load(tmp_path / ("a" * 5000))

    def test_a_file_that_is_too_large(self, load, tmp_path, monkeypatch):
        monkeypatch.setattr(reading, "LARGEST", 2**20)
        (tmp_path / "large.xml").write_bytes(b"<robot>" + b" " * 2**20)
        with pytest.raises(jtik.RobotFileError, match=r"large.xml: larger than 1 MiB"):
            load(tmp_path / "large.xml")


@pytest.mark.parametrize(
    "name",
    ["package://", "package:///", "file://", "package://../../..", "a" * 5000 + ".stl", "package://" + "b" * 5000],
)
def test_the_name_of_a_mesh_that_names_no_file(name, tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(MESH.format(name))
    robot = jtik.Robot.from_urdf(path)
    assert robot.joint_names == ("j",)
    assert len(robot.shapes) == 0


@pytest.mark.parametrize("load", LOADERS.values(), ids=LOADERS)
@pytest.mark.parametrize("part", ["<!-- ", "<!--", "<!-- - ", "<!-- a -- b "])
def test_comments_that_do_not_end_are_read_once(load, part):
    """In a time that grows with the square of its length a text of this size would take hours."""
    for text in (part * (2_000_000 // len(part)), f"<robot name='r'>{part * (2_000_000 // len(part))}</robot>"):
        with pytest.raises(jtik.RobotFileError, match="not XML"):
            load(text)
