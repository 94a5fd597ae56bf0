"""What a MuJoCo model has and a robot cannot keep is told: one warning a file, and `Robot.ignored`."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import jtik
from jtik import Robot

mujoco = pytest.importorskip("mujoco")


def model(tendon="", equality="", extra="", ball=""):
    return f"""<mujoco><compiler angle="radian"/><worldbody>
      <body name="a"><joint name="a" axis="0 1 0" ref="0.2"/><geom size="0.1"/>
        <body name="b" pos="0.4 0 0"><joint name="b" axis="0 1 0" ref="-0.1"/><geom size="0.1"/>
          <body name="c" pos="0.4 0 0"><joint name="c" type="slide"/><geom size="0.1"/>
            <body name="d" pos="0.1 0 0"><joint name="d" type="ball" {ball}/><geom size="0.1"/></body>
          </body></body></body>
      <body name="post" pos="1 0 0"/>
    </worldbody><tendon>{tendon}</tendon><equality>{equality}</equality>{extra}</mujoco>"""


def fixed(name, options="", **coefficients):
    terms = "".join(f'<joint joint="{joint}" coef="{factor}"/>' for joint, factor in coefficients.items())
    return f'<fixed name="{name}" {options}>{terms}</fixed>'


@pytest.mark.parametrize(
    ("tendon", "equality", "follower"),
    [
        (fixed("t", a=1, b=-2), '<tendon tendon1="t"/>', "b"),
        (fixed("t", b=3, c=1.5), '<tendon tendon1="t" polycoef="0.3 0 0 0 0"/>', "c"),
        (fixed("t", a=1) + fixed("s", c=2), '<tendon tendon1="t" tendon2="s" polycoef="0.1 0.5 0 0 0"/>', "c"),
    ],
)
def test_a_linear_coupling_by_tendons_becomes_a_mimic_joint(tendon, equality, follower):
    text = model(tendon, equality)
    robot = Robot.from_mjcf(text)
    assert robot.ignored == ()
    assert [joint.name for joint in robot.joints if joint.mimic is not None] == [follower]
    compiled = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(compiled)
    for seed in range(3):
        q = robot.random_configuration(seed)
        for joint in robot.joints:
            if joint.is_moving:
                value = q[robot.q_slice(joint.name)]
                ratio, offset = (joint.mimic.multiplier, joint.mimic.offset) if joint.mimic else (1, 0)
                data.joint(joint.name).qpos[:] = ratio * value + offset
        mujoco.mj_forward(compiled, data)
        assert data.efc_pos[0] == pytest.approx(0, abs=1e-9)  # MuJoCo's own residual of the equality


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ({"tendon": fixed("t", a=1, b=1, c=1), "equality": '<tendon name="e" tendon1="t"/>'},
         "the equality 'e' of the tendon 't' is not kept: it couples more than two joints, 'a', 'b', 'c'"),
        ({"tendon": fixed("t", 'limited="true" range="-1 2"', a=1, b=1)},
         "the range of the tendon 't', -1 to 2, is not kept; it limits the joints 'a', 'b'"),
        ({"tendon": fixed("t", a=1, b=1), "extra": '<actuator><position tendon="t"/></actuator>'},
         "the tendon 't' is not kept: one actuator moves the joints 'a', 'b', which stay independent"),
        ({"equality": '<connect name="loop" body1="d" body2="post" anchor="0 0 0"/>'},
         "the equality 'loop' (connect) of 'd' and 'post' is not kept: the loop stays open"),
        ({"equality": '<weld body1="d"/>'},
         "the equality number 0 (weld) of 'd' and 'world' is not kept: the loop stays open"),
        ({"ball": 'range="0 0.5"'}, "the range of the ball joint 'd', 0.5 rad, is not kept"),
    ],
)  # fmt: skip
def test_what_is_not_kept_is_in_one_warning_and_listed(parts, told):
    for load in (Robot.from_mjcf, lambda text: Robot.from_mujoco(mujoco.MjModel.from_xml_string(text))):
        with pytest.warns(UserWarning, match="is not kept") as caught:
            robot = load(model(**parts))
        assert robot.n == 6
        assert robot.ignored == (told,)
        assert len(caught) == 1
        assert told in str(caught[0].message)
        for other in (pickle.loads(pickle.dumps(robot)), robot.subset(["a"]), robot.with_tool(np.eye(4))):
            assert other.ignored == (told,)


def test_tendons_that_mujoco_refuses_are_told_and_the_rest_is_kept():
    text = model(fixed("t", a=1, d=1), '<tendon tendon1="t"/><joint joint1="b" joint2="a"/>')
    with pytest.raises(ValueError, match="must be slide or hinge"):
        mujoco.MjModel.from_xml_string(text)
    with pytest.warns(UserWarning, match="its tendons are not kept") as caught:
        robot = Robot.from_mjcf(text)
    assert len(caught) == 1
    (note,) = robot.ignored
    assert note.startswith("its tendons are not kept: MuJoCo refuses them: Error: joint 'd' in tendon")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        expected = Robot.from_mjcf(model(equality='<joint joint1="b" joint2="a"/>'))
    q = robot.random_configuration(0)
    assert np.array_equal(robot.pose(q, "d"), expected.pose(q, "d"))
    assert {frame: mass.mass for frame, mass in robot.masses.items()} == {
        frame: mass.mass for frame, mass in expected.masses.items()
    }


@pytest.mark.parametrize(
    ("extra", "complaint"),
    [
        ('<actuator><muscle joint="a"/></actuator>', "Lengthrange computation did not converge"),
        ('<size memory="100"/>', "out of memory|memory"),
    ],
)
def test_what_only_a_simulation_needs_refuses_no_robot(extra, complaint):
    text = model(extra=extra)
    with pytest.raises(ValueError, match=complaint):
        mujoco.MjModel.from_xml_string(text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Robot.from_mjcf(text).joint_names == Robot.from_mjcf(model()).joint_names


def test_everything_that_is_dropped_is_in_one_warning():
    loops = "".join(f'<connect name="loop{k}" body1="d" body2="post" anchor="0 0 {k}"/>' for k in range(15))
    with pytest.warns(UserWarning, match="and 6 more: see Robot.ignored") as caught:
        robot = Robot.from_mjcf(model(equality=loops, ball='range="0 1"'))
    assert len(caught) == 1
    assert len(robot.ignored) == 16


def test_a_coupled_joint_is_not_said_to_be_independent_and_what_is_inactive_is_not_said():
    text = model(
        fixed("t", a=1, b=1),
        '<joint joint1="b" joint2="a"/><weld body1="d" active="false"/>',
        '<actuator><position tendon="t"/></actuator>',
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Robot.from_mjcf(text).ignored == ()


def test_a_loop_of_a_urdf_is_listed():
    loop = '<loop_joint name="close"><link1 link="a"/><link2 link="b"/></loop_joint>'
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    text = f'<robot name="r"><link name="a"/><link name="b"/>{loop}{joint}</robot>'
    with pytest.warns(UserWarning, match="the <loop_joint> 'close' is not kept: the loop stays open"):
        assert Robot.from_urdf(text).ignored == ("the <loop_joint> 'close' is not kept: the loop stays open",)


def test_a_robot_without_a_file_ignores_nothing():
    assert jtik.Robot.planar(3).ignored == ()
