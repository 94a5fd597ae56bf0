"""Files as people have them: encodings, incomplete inertias, other dialects, XACRO."""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest

import jtik
from jtik import JointType, Robot

JOINT = '<joint name="Gürtel" type="revolute"><parent link="a"/><child link="b"/><limit lower="-1" upper="1"/></joint>'
MOMENTS = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


def urdf(link="", joint=JOINT):
    return f'<robot name="r"><link name="a"/><link name="b">{link}</link>{joint}</robot>'


MJCF = '<mujoco><worldbody><body name="b"><joint name="Gürtel"/><geom size="1"/></body></worldbody></mujoco>'
CASES = [(Robot.from_urdf, urdf()), (Robot.from_mjcf, MJCF)]


@pytest.mark.parametrize(("load", "text"), CASES)
@pytest.mark.parametrize("encoding", ["ISO-8859-1", "utf-8", "windows-1252", "utf-16"])
def test_a_declared_encoding_is_read(load, text, encoding, tmp_path):
    path = tmp_path / "arm.xml"
    path.write_bytes(f'<?xml version="1.0" encoding="{encoding}"?>\n{text}'.encode(encoding))
    assert load(path).joint_names == ("Gürtel",)


@pytest.mark.parametrize(("load", "text"), CASES)
@pytest.mark.parametrize("head", ["\n\n", "<!-- made by hand -->\n", "\ufeff", "\n<!-- a -- b -->\n\n"])
def test_blank_lines_and_comments_before_the_declaration_are_read(load, text, head, tmp_path):
    content = f'{head}<?xml version="1.0" encoding="UTF-8"?>\n{text}'
    path = tmp_path / "arm.xml"
    path.write_text(content, encoding="utf-8")
    assert load(path).joint_names == load(content).joint_names == ("Gürtel",)


@pytest.mark.parametrize(("load", "text"), CASES)
def test_text_in_another_encoding_than_declared_is_refused(load, text, tmp_path):
    path = tmp_path / "arm.xml"
    path.write_bytes(text.encode("ISO-8859-1"))
    with pytest.raises(jtik.RobotFileError, match="arm.xml: line 1: not XML: not well-formed"):
        load(path)
    path.write_bytes(b'<?xml version="1.0" encoding="klingon"?>' + text.encode())
    with pytest.raises(jtik.RobotFileError, match="its encoding 'klingon' is not known"):
        load(path)


def test_an_mjcf_in_another_encoding_includes_its_files(tmp_path):
    path = tmp_path / "scene.xml"
    (tmp_path / "body.xml").write_text(
        '<mujoco><worldbody><body name="b"><joint name="j"/></body></worldbody></mujoco>'
    )
    text = '<?xml version="1.0" encoding="ISO-8859-1"?><mujoco model="Gürtel"><include file="body.xml"/></mujoco>'
    path.write_bytes(text.encode("ISO-8859-1"))
    robot = Robot.from_mjcf(path)
    assert (robot.name, robot.joint_names) == ("Gürtel", ("j",))


@pytest.mark.parametrize(
    ("link", "masses", "told"),
    [
        ('<inertial><mass value="2"/></inertial>', {"b": 2.0}, "link 'b' has a mass without an inertia"),
        ('<inertial><mass value="2"/><inertia ixx="1"/></inertial>', {"b": 2.0}, "link 'b' has a mass without an iner"),
        (f"<inertial>{MOMENTS}</inertial>", {}, "link 'b' has an <inertial> without a mass"),
        (f"<inertial><mass/>{MOMENTS}</inertial>", {}, "link 'b' has an <inertial> without a mass"),
        (
            f'<inertial><mass value="-2"/>{MOMENTS}</inertial>',
            {},
            "link 'b' has a negative mass: it counts as massless",
        ),
    ],
)
def test_masses_without_inertia_and_inertias_without_mass_load_with_a_warning(link, masses, told):
    with pytest.warns(UserWarning, match=told) as caught:
        robot = Robot.from_urdf(urdf(link))
    assert {frame: mass.mass for frame, mass in robot.masses.items()} == masses
    assert len(caught) == 1


@pytest.mark.parametrize(
    ("shape", "told"),
    [
        ('<mesh filename="m.stl" scale="1 2 3 4"/>', "link 'b': a <collision> has a mesh of scale '1 2 3 4'"),
        ('<mesh filename="m.stl" scale="2"/>', "link 'b': a <collision> has a mesh of scale '2'"),
        ('<box size="1 1"/>', "link 'b': a <collision> is not used: the size of its <box>"),
        ("<torus/>", "link 'b': a <collision> with the geometry <torus> is not used"),
    ],
)
def test_scales_and_sizes_of_other_dialects_load_with_a_warning(shape, told):
    with pytest.warns(UserWarning, match=told):
        assert Robot.from_urdf(urdf(f"<collision><geometry>{shape}</geometry></collision>")).n == 1


def test_the_scale_of_four_numbers_is_that_of_the_first_three(tmp_path):
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    path = tmp_path / "arm.urdf"
    found = []
    for scale in ("2 2 2", "2 2 2 1"):
        shape = f'<collision><geometry><mesh filename="m.obj" scale="{scale}"/></geometry></collision>'
        path.write_text(urdf(shape), encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found.append(Robot.from_urdf(path).shapes["b"][0])
    assert found[0].radius == found[1].radius


def test_a_lower_limit_above_the_upper_one_means_none_with_a_warning():
    joint = JOINT.replace('lower="-1" upper="1"', 'lower="1" upper="-1"')
    with pytest.warns(UserWarning, match="joint 'Gürtel' has no limits: its lower limit 1 is above its upper limit -1"):
        robot = Robot.from_urdf(urdf(joint=joint))
    assert (robot.lower[0], robot.upper[0]) == (-np.inf, np.inf)


def test_a_spherical_joint_is_a_ball_joint():
    robot = Robot.from_urdf(urdf(joint=JOINT.replace("revolute", "spherical")))
    assert (robot.joints[0].name, robot.joints[0].type, robot.n) == ("Gürtel", JointType.BALL, 3)


def test_mujocos_own_warnings_are_not_seen(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = MJCF.replace("<mujoco>", '<mujoco><compiler settotalmass="3"/>')
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Robot.from_mjcf(text).n == 1
    assert capfd.readouterr() == ("", "")


XACRO = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="length" default="0.5"/>
  <xacro:macro name="arm" params="name">
    <link name="${name}"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="${name}"/><origin xyz="$(arg length) 0 0"/></joint>
  </xacro:macro>
  <xacro:arm name="b"/>
  LINK
</robot>"""


class TestXacro:
    def test_it_is_expanded_by_the_package_with_its_arguments(self, tmp_path):
        pytest.importorskip("xacro")
        path = tmp_path / "arm.urdf.xacro"
        path.write_text(XACRO.replace("LINK", '<link name="a"/>'))
        assert Robot.from_urdf(path).pose([0.0])[0, 3] == 0.5
        assert Robot.from_urdf(path, xacro_arguments={"length": 0.8}).pose([0.0])[0, 3] == 0.8
        text = XACRO.replace("LINK", '<xacro:macro name="l"><link name="a"/></xacro:macro><xacro:l/>')
        text = text.replace('<link name="${name}"/>', '<xacro:if value="1"><link name="${name}"/></xacro:if>')
        assert Robot.from_urdf(text).pose([0.0])[0, 3] == 0.5

    @pytest.mark.parametrize("inside", ["${1/0}", "$(find nowhere)", "${nothing}"])
    def test_what_cannot_be_expanded_is_refused(self, inside, tmp_path, capfd):
        pytest.importorskip("xacro")
        path = tmp_path / "arm.xacro"
        path.write_text(XACRO.replace("LINK", f'<link name="{inside}"/>'))
        with pytest.raises(jtik.RobotFileError, match=r"arm.xacro: xacro cannot expand it: "):
            Robot.from_urdf(path)
        assert capfd.readouterr() == ("", "")

    def test_without_the_package_the_error_says_how(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "xacro", None)
        path = tmp_path / "arm.xacro"
        path.write_text(XACRO.replace("LINK", '<link name="a"/>'))
        with pytest.raises(jtik.RobotFileError, match=r"arm.xacro: its xacro elements .*: pip install 'jtik\[xacro\]'"):
            Robot.from_urdf(path)

    def test_arguments_of_a_file_that_is_none_are_refused(self):
        with pytest.raises(jtik.ArgumentError, match="xacro_arguments"):
            Robot.from_urdf(urdf(), xacro_arguments={"a": "1"})
