"""MJCF descriptions and compiled models, against MuJoCo's own kinematics."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik
from jtik import JointType, Robot

mujoco = pytest.importorskip("mujoco")

pytestmark = pytest.mark.filterwarnings("ignore:[^;]*the range of the ball joint 'wrist', 1.0472 rad, is not kept$")
"""EVERYTHING has one; every other warning is an error."""

EXACT = 1e-12
"""Rounding of some dozens of operations on numbers of order one."""

EVERYTHING = """
<mujoco model="everything">
  <compiler angle="degree" eulerseq="zyx"/>
  <default>
    <joint axis="0 1 0"/>
    <default class="slide"><joint type="slide" axis="1 1 0" range="-0.2 0.3"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <site name="mark" pos="1 2 3" euler="10 20 30"/>
    <body name="hull" pos="0.5 0.1 1" quat="1 2 3 4">
      <freejoint name="float"/>
      <inertial mass="2" pos="0.1 0 0" diaginertia="1 1 1"/>
      <frame pos="0.2 0 0" euler="0 45 0">
        <body name="arm" pos="0.1 0.2 0.3" euler="30 0 0">
          <joint name="pan" axis="0 0 2" pos="0.1 0.2 0" ref="25" range="-90 120"/>
          <joint name="rail" class="slide" pos="9 9 9" ref="0.1"/>
          <joint name="tilt" pos="0 0 -0.3" ref="-15"/>
          <geom size="0.1" mass="3" pos="0 0 0.2"/>
          <site name="arm" pos="0.3 0 0" euler="0 0 90"/>
          <body name="hand" pos="0.4 0 0.1">
            <joint name="wrist" type="ball" pos="0.05 0 0.02" range="0 60"/>
            <geom size="0.1" mass="1"/>
            <site name="tool" pos="0 0 0.2"/>
            <body name="finger" pos="0.1 0 0" euler="0 0 10">
              <joint name="finger" type="slide" ref="0.05"/>
              <geom size="0.01" mass="0.1"/>
            </body>
            <body name="thumb" pos="-0.1 0 0">
              <joint name="thumb" ref="20" pos="0.02 0 0"/>
              <geom size="0.01" mass="0.1"/>
              <body name="nail" pos="0 0 0.03"><joint name="nail"/><geom size="0.01" mass="0.1"/></body>
            </body>
            <body name="camera" pos="0 0.1 0" euler="0 90 0"/>
          </body>
        </body>
      </frame>
    </body>
  </worldbody>
  <equality>
    <joint joint1="thumb" joint2="finger" polycoef="0.1 -3 0 0 0"/>
    <joint joint1="nail" joint2="thumb" polycoef="0.2 0.5 0 0 0"/>
  </equality>
  <keyframe>
    <key name="home" qpos="1 2 3 1 0 0 0  0.1 0.2 0.3  1 0 0 0  0.01 0 0"/>
    <key qpos="0 0 0 0 0 1 0  0 0 0  0 1 0 0  0 0 0"/>
  </keyframe>
</mujoco>
"""


@pytest.fixture(scope="module")
def everything():
    return Robot.from_mjcf(EVERYTHING), mujoco.MjModel.from_xml_string(EVERYTHING)


FOLLOWED = np.array([0.0] * 15 + [0.1, 0.2 + 0.5 * 0.1])
"""How far the equalities move the followers, thumb and nail, from qpos0."""


def full_position(robot, model, q):
    """MuJoCo's qpos for q, and the matrix (model.nv, n) from the robot's velocity to MuJoCo's."""
    qpos, columns = np.array(model.qpos0), np.zeros((model.nv, robot.n))
    for joint in robot.joints:
        if not joint.is_moving:
            continue
        own = model.joint(joint.name)
        ratio, offset = (joint.mimic.multiplier, joint.mimic.offset) if joint.mimic else (1.0, 0.0)
        first_q, first_v = own.qposadr[0], own.dofadr[0]
        qpos[first_q : first_q + joint.type.nq] = ratio * q[robot.q_slice(joint.name)] + offset
        columns[first_v : first_v + joint.type.nv, robot.v_slice(joint.name)] = ratio * np.eye(joint.type.nv)
    return qpos, columns


def assert_like_mujoco(robot, model, q, frames=None):
    data = mujoco.MjData(model)
    data.qpos, columns = full_position(robot, model, q)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    poses = {model.body(k).name: (data.xpos[k], data.xmat[k], model.body(k).id) for k in range(model.nbody)}
    for k in range(model.nsite):
        name = model.site(k).name
        name = f"{name} (site)" if name in poses else name
        poses[name] = data.site_xpos[k], data.site_xmat[k], model.site_bodyid[k]
    for frame in frames or poses:
        position, rotation, body = poses[frame]
        T = robot.pose(q, frame)
        assert T[:3, 3] == pytest.approx(position, abs=EXACT)
        assert T[:3, :3] == pytest.approx(rotation.reshape(3, 3), abs=EXACT)
        J = np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, J[:3], J[3:], position, body)
        assert robot.jacobian(q, frame) == pytest.approx(J @ columns, abs=EXACT)


def test_every_frame_has_the_pose_that_mujoco_gives(everything):
    robot, model = everything
    generator = np.random.default_rng(5)
    for q in (robot.neutral, *(robot.random_configuration(generator) for _ in range(5))):
        assert_like_mujoco(robot, model, q)


def test_frames_are_bodies_sites_and_those_between_joints(everything):
    robot, _ = everything
    assert robot.name == "everything"
    assert robot.base == "world"
    assert set(robot.frame_names) == {
        *("world", "mark", "hull", "arm", "arm (site)", "hand", "tool", "finger", "thumb", "nail", "camera"),
        *("pan", "rail", "tilt", "wrist", "thumb (joint)"),
    }
    assert robot.tip == "tool"


def test_q_is_qpos_without_the_followers(everything):
    robot, model = everything
    assert robot.joint_names == ("float", "pan", "rail", "tilt", "wrist", "finger")
    assert (robot.nq, robot.n) == (model.nq - 2, model.nv - 2)


def test_followers_become_mimic_joints_of_the_first_leader(everything):
    robot, _ = everything
    mimics = {joint.name: joint.mimic for joint in robot.joints if joint.mimic is not None}
    # thumb = ref + 0.1 - 3 (finger - 0.05), nail = 0.2 + 0.5 (thumb - ref)
    assert mimics["thumb"].joint == mimics["nail"].joint == "finger"
    assert (mimics["thumb"].multiplier, mimics["nail"].multiplier) == (-3.0, -1.5)
    assert mimics["thumb"].offset == pytest.approx(np.radians(20) + 0.1 + 0.15, abs=EXACT)
    assert mimics["nail"].offset == pytest.approx(0.2 + 0.5 * 0.25, abs=EXACT)


def test_limits_are_those_of_revolute_and_prismatic_joints(everything):
    robot, _ = everything
    bounds = {name: (robot.lower[index], robot.upper[index]) for name in ("pan", "rail", "tilt", "wrist")
              for index in [robot.q_slice(name).start]}  # fmt: skip
    assert bounds["pan"] == pytest.approx((-np.pi / 2, np.radians(120)))
    assert bounds["rail"] == (-0.2, 0.3)
    assert bounds["tilt"] == bounds["wrist"] == (-np.inf, np.inf)


def test_keyframes_become_configurations(everything):
    robot, _ = everything
    assert set(robot.keyframes) == {"home", "key1"}
    assert robot.keyframes["home"] == pytest.approx([1, 2, 3, 1, 0, 0, 0, 0.1, 0.2, 0.3, 1, 0, 0, 0, 0.01])


def test_the_neutral_configuration_is_qpos0(everything):
    described, model = everything
    for robot in (described, Robot.from_mujoco(model), pickle.loads(pickle.dumps(described))):
        assert full_position(robot, model, robot.neutral)[0] == pytest.approx(model.qpos0 + FOLLOWED, abs=EXACT)
        assert_like_mujoco(robot, model, robot.neutral)


def test_the_neutral_configuration_is_within_the_limits():
    text = '<mujoco><worldbody><body><joint ref="3" range="-1 1"/><geom size="1"/></body></worldbody></mujoco>'
    robot = Robot.from_mjcf(text.replace("<worldbody>", '<compiler angle="radian"/><worldbody>'))
    assert robot.neutral.tolist() == [1.0]


class TestAScene:
    """An arm on a column beside two free objects, which are not the robot; only the arm moves."""

    XML = """
    <mujoco model="scene">
      <worldbody>
        <body name="cup" pos="0.5 0.2 0.7" quat="1 2 -1 0"><freejoint/><geom size="0.02"/></body>
        <body name="column" pos="0 0 0.5">
          <joint name="lift" type="slide" axis="0 0 1" ref="0.2" range="0.15 0.75"/>
          <geom size="0.1"/>
          <body name="upper" pos="0 0 0.1">
            <joint name="shoulder" axis="0 1 0" ref="30" range="-10 90"/>
            <geom size="0.1"/>
            <body name="fore" pos="0.4 0 0" euler="0 20 0">
              <joint name="elbow" axis="0 1 0" ref="-40"/>
              <geom size="0.1"/>
              <body name="hand" pos="0.4 0 0"><joint name="wrist" type="ball"/><geom size="0.05"/></body>
            </body>
          </body>
        </body>
        <body name="box" pos="-1 0 0.3"><freejoint name="box"/><geom size="0.1"/></body>
      </worldbody>
    </mujoco>"""

    @pytest.mark.parametrize("copy", [lambda ik: ik, lambda ik: pickle.loads(pickle.dumps(ik))])
    def test_objects_and_locked_joints_stay_where_the_scene_has_them(self, copy):
        model = mujoco.MjModel.from_xml_string(self.XML)
        robot = Robot.from_mujoco(model)
        ik = copy(jtik.InverseKinematics(robot, jtik.FrameTask("hand", "position"), joints=["shoulder", "elbow"]))
        target = [0.3, 0.0, 0.9]
        solution = ik.solve(target)
        assert solution.converged
        full = robot.full_configuration(ik.full_configuration(solution.q))
        expected = model.qpos0.copy()
        for name, angle in zip(("shoulder", "elbow"), solution.q, strict=True):
            expected[model.joint(name).qposadr[0]] = angle
        assert full == pytest.approx(expected, abs=EXACT)
        data = mujoco.MjData(model)
        data.qpos[:] = full
        mujoco.mj_kinematics(model, data)
        assert data.body("hand").xpos == pytest.approx(target, abs=2e-6)
        for name in ("cup", "box", "column"):
            assert data.body(name).xpos == pytest.approx(model.body(name).pos, abs=EXACT)

    def test_objects_are_frames_but_neither_joints_nor_masses_nor_the_tip(self):
        model = mujoco.MjModel.from_xml_string(self.XML)
        robot = Robot.from_mjcf(self.XML)
        assert robot.joint_names == ("lift", "shoulder", "elbow", "wrist")
        assert robot.tip == "hand"
        assert robot.ignored == ()
        assert set(robot.masses) == {"column", "upper", "fore", "hand"}
        for seed in range(3):
            q = robot.random_configuration(seed)
            for name in ("cup", "box"):
                assert robot.pose(q, name)[:3, 3] == pytest.approx(model.body(name).pos, abs=EXACT)
        assert robot.full.nq == model.nq
        assert np.array_equal(robot.configuration(model.qpos0), model.qpos0[7 : 7 + robot.nq])

    def test_a_free_body_alone_is_the_robot_and_so_is_one_with_joints(self):
        free = '<body name="cup"><freejoint/><geom size="1"/></body>'
        walker = '<body name="w"><freejoint name="w"/><geom size="1"/><body><joint name="leg"/></body></body>'
        assert Robot.from_mjcf(f"<mujoco><worldbody>{free}</worldbody></mujoco>").n == 6
        robot = Robot.from_mjcf(f"<mujoco><worldbody>{free}{walker}</worldbody></mujoco>")
        assert robot.joint_names == ("w", "leg")

    def test_a_solve_starts_at_qpos0_off_the_limits(self):
        model = mujoco.MjModel.from_xml_string(self.XML)
        ik = jtik.InverseKinematics(Robot.from_mjcf(self.XML), jtik.FrameTask("hand", "position"))
        assert ik.robot.joint_names == ("lift", "shoulder", "elbow", "wrist")
        start = ik.solve([0.3, 0.0, 0.9], max_iterations=0).q
        shoulder, elbow = (model.qpos0[model.joint(name).qposadr[0]] for name in ("shoulder", "elbow"))
        assert start == pytest.approx([0.45, shoulder, elbow, 1, 0, 0, 0], abs=EXACT)  # the lift was near its limit


def test_the_center_of_mass_is_mujocos(everything):
    robot, model = everything
    q = robot.random_configuration(2)
    data = mujoco.MjData(model)
    data.qpos = full_position(robot, model, q)[0]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    assert robot.center_of_mass(q) == pytest.approx(data.subtree_com[0], abs=EXACT)


def test_a_compiled_model_gives_the_robot_of_its_file(everything, tmp_path):
    described, model = everything
    path = tmp_path / "everything.xml"
    path.write_text(EVERYTHING)
    q = described.random_configuration(4)
    for robot in (Robot.from_mujoco(model), Robot.from_mjcf(path), Robot.from_mjcf(str(path))):
        assert (robot.frame_names, robot.joint_names) == (described.frame_names, described.joint_names)
        assert (robot.name, robot.tip) == (described.name, described.tip)
        assert np.array_equal(robot.lower, described.lower)
        assert np.array_equal(robot.upper, described.upper)
        assert {k: m.mass for k, m in robot.masses.items()} == {k: m.mass for k, m in described.masses.items()}
        assert {frame: len(found) for frame, found in robot.shapes.items()} == {
            frame: len(found) for frame, found in described.shapes.items()
        }
        for frame in robot.frame_names:
            assert np.array_equal(robot.pose(q, frame), described.pose(q, frame))


def body(inside, after=""):
    return f'<mujoco><worldbody><body name="a">{inside}</body></worldbody>{after}</mujoco>'


def test_elements_without_a_name_get_that_of_their_body():
    robot = Robot.from_mjcf(body('<joint/><joint axis="1 0 0"/><body><joint name="x"/><site/></body>'))
    assert robot.joint_names == ("a", "a (joint)", "x")
    assert robot.frame_names == ("world", "a (joint)", "a", "body2", "site0")


def test_an_equality_of_one_joint_makes_it_fixed():
    equality = '<equality><joint joint1="b" polycoef="0.3 0 0 0 0"/></equality>'
    text = body(
        '<joint name="a"/><body name="b"><joint name="b" axis="1 0 0" ref="0.5" pos="0 0.1 0"/></body>', equality
    ).replace("<mujoco>", '<mujoco><compiler angle="radian"/>')
    robot = Robot.from_mjcf(text)
    assert robot.joint_names == ("a",)
    free = Robot.from_mjcf(text.replace(equality, ""))
    assert robot.pose([0.2], "b") == pytest.approx(free.pose([0.2, 0.8], "b"), abs=EXACT)


def test_an_inactive_equality_is_ignored():
    text = body(
        '<joint name="a"/><body name="b"><joint name="b"/></body>',
        '<equality><joint joint1="b" joint2="a" active="false"/></equality>',
    )
    assert Robot.from_mjcf(text).n == 2


def test_a_nonlinear_equality_is_left_out_with_a_warning():
    text = body(
        '<joint name="a"/><body name="b"><joint name="b"/></body>',
        '<equality><joint joint1="b" joint2="a" polycoef="0 1 0.5 0 0"/></equality>',
    )
    with pytest.warns(UserWarning, match="joint 'b' stays independent: it follows 'a' by a polynomial"):
        assert Robot.from_mjcf(text).n == 2


def test_a_cycle_of_followers_keeps_the_first_equalities():
    text = body(
        '<joint name="a"/><body name="b"><joint name="b"/></body>',
        '<equality><joint joint1="b" joint2="a" polycoef="0 2 0 0 0"/><joint joint1="a" joint2="b"/></equality>',
    )
    with pytest.warns(UserWarning, match="joint 'a' does not follow 'b'"):
        robot = Robot.from_mjcf(text)
    assert robot.joint_names == ("a",)
    assert robot.joints[1].mimic.multiplier == 2.0


@pytest.mark.filterwarnings("ignore:.*its masses count as point masses")
def test_bodies_without_mass_textures_without_files_and_invalid_inertias_are_accepted():
    robot = Robot.from_mjcf(
        """<mujoco><asset><texture name="t" type="2d" file="no.png"/><material name="m" texture="t"/>
        <mesh name="gone" file="no.stl"/><hfield name="hills" file="no.png" size="1 1 1 1"/></asset><worldbody>
        <geom type="hfield" hfield="hills"/>
        <body name="a"><joint/><geom type="mesh" mesh="gone" material="m"/>
          <body name="b"><joint axis="1 0 0"/><inertial mass="2" pos="0 0 1" diaginertia="1 1 9"/></body>
        </body></worldbody></mujoco>"""
    )
    assert robot.n == 2
    assert {frame: mass.mass for frame, mass in robot.masses.items()} == {"b": 2.0}
    assert robot.masses["b"].center.tolist() == [0.0, 0.0, 1.0]
    assert not robot.shapes


@pytest.mark.parametrize("mass", ["-1", "nan"])
def test_masses_that_are_none_are_told(mass):
    text = f"""<mujoco><worldbody><body name="arm"><inertial mass="{mass}" pos="0 0 0" diaginertia="1 1 1"/>
        <joint/><body name="hand"><inertial mass="2" pos="0 0 0" diaginertia="1 2 2"/><joint/></body></body>
        </worldbody></mujoco>"""
    with pytest.warns(UserWarning, match="body 'arm' has no mass of a non-negative number"):
        robot = Robot.from_mjcf(text)
    assert list(robot.masses) == ["hand"]
    assert np.diag(robot.masses["hand"].inertia) == pytest.approx([1, 2, 2])  # those of the others are kept


def test_name_and_tip_may_be_given(everything):
    robot = Robot.from_mjcf(EVERYTHING, tip="nail", name="mine")
    assert (robot.tip, robot.name) == ("nail", "mine")
    with pytest.raises(jtik.UnknownNameError, match="unknown tip frame 'nial'; did you mean 'nail'"):
        Robot.from_mjcf(EVERYTHING, tip="nial")
    with pytest.raises(jtik.UnknownNameError, match="unknown tip frame 'nial'"):
        Robot.from_mujoco(everything[1], tip="nial")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (body('<joint type="universal"/>'), "the MJCF text given: MuJoCo refuses it: .*'universal'.*'joint'"),
        (body('<joint name="j" limited="true" range="2 1"/>'), "range.0. should be smaller.*'j'"),
        (body('<joint name="j" range="nan 1"/>'), "joint 'j': its limits are nan and"),
        ("<mujoco/>", "not a robot: it has no body"),
        ("<robot name='r'><link name='a'/></robot>", "not MJCF: .* a URDF is read by Robot.from_urdf"),
        ("<mujoco><worldbody>", "line 1: not XML: no element found"),
        ("no_such_file.xml", r"no_such_file\.xml: No such file or directory; accepted: the path of a file"),
        (body("<joint/>", '<keyframe><key qpos="nan"/></keyframe>'), r"keyframes\['key0'\]\['a'\]: given nan"),
    ],
)
def test_a_file_that_is_not_a_robot_is_refused(text, complaint):
    with pytest.raises(jtik.RobotFileError, match=complaint):
        Robot.from_mjcf(text)


@pytest.mark.parametrize("loader", [Robot.from_mjcf, Robot.from_urdf, Robot.from_mujoco])
def test_a_number_is_not_a_description(loader):
    with pytest.raises(jtik.ArgumentError, match="given 3; accepted"):
        loader(3)


def test_nothing_is_printed_and_no_log_is_written(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(jtik.RobotFileError):
        Robot.from_mjcf(body('<joint name="j" range="nan 1"/>'))
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_all_types_of_joints_are_read(everything):
    kinds = {joint.name: joint.type for joint in everything[0].independent_joints}
    assert kinds["float"] is JointType.FREE
    assert kinds["wrist"] is JointType.BALL
    assert kinds["rail"] is JointType.PRISMATIC
    assert kinds["pan"] is JointType.REVOLUTE
