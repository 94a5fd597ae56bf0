"""What a user gets wrong, and what the error says of it: the file, the element or the argument, and what is accepted.

What each part of the library refuses is tested with it, such as in tests/robot/test_loader_*.py and tests/task; here
are the mistakes that go through several of them, on robots as users have them.
"""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

import jtik

PANDA = jtik.Robot.builtin("panda")
ONE = jtik.FrameTask("tip")
STRETCHED = np.diag([2.0, 2.0, 2.0, 1.0])
MIRRORED = np.diag([1.0, 1.0, -1.0, 1.0])
SHEARED = np.array([[1.0, 0.1, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class TestFiles:
    @pytest.mark.parametrize("load", [jtik.Robot.from_urdf, jtik.Robot.from_mjcf])
    @pytest.mark.parametrize(
        ("content", "complaint"),
        [
            (b"", "line 1: not XML: no element found"),
            (b'{"robot": "arm"}', "line 1: not XML: not well-formed"),
            (bytes(range(256)), "line 1: not XML"),
            (b"<robot><link name='a'></robot>", "line 1: not XML: mismatched tag"),
            (b"<sdf version='1.6'><model name='arm'/></sdf>", "its outermost element is <sdf>, where <"),
        ],
    )
    def test_an_invalid_description_is_refused_with_its_path(self, load, content, complaint, tmp_path):
        path = tmp_path / "arm.txt"
        path.write_bytes(content)
        for given in (path, str(path)):
            with pytest.raises(jtik.RobotFileError, match=complaint) as caught:
                load(given)
            assert str(caught.value).startswith(str(path))

    @pytest.mark.parametrize("load", [jtik.Robot.from_urdf, jtik.Robot.from_mjcf])
    def test_a_folder_is_no_file(self, load, tmp_path):
        with pytest.raises(jtik.RobotFileError, match="accepted: the path of a file that can be read"):
            load(tmp_path)

    def test_macros_that_were_not_expanded_are_called_so(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "xacro", None)
        with pytest.raises(jtik.RobotFileError, match="no link.*xacro elements have to be expanded first"):
            jtik.Robot.from_urdf("<robot name='arm'><xacro:arm/></robot>")
        with pytest.raises(jtik.RobotFileError, match="no link; accepted: at least one link$"):
            jtik.Robot.from_urdf("<robot name='arm'/>")

    @pytest.mark.parametrize("kind", ["Revolute", "", "screw"])
    def test_an_unknown_type_of_joint_names_file_and_joint(self, kind, tmp_path):
        path = tmp_path / "arm.urdf"
        ends = '<parent link="a"/><child link="b"/>'
        path.write_text(f'<robot><link name="a"/><link name="b"/><joint name="j" type="{kind}">{ends}</joint></robot>')
        with pytest.raises(
            jtik.RobotFileError, match=f"joint 'j': unknown type '{kind}'; accepted: revolute, "
        ) as caught:
            jtik.Robot.from_urdf(path)
        assert (caught.value.file, caught.value.element) == (str(path), "joint 'j'")

    @pytest.mark.parametrize("load", [jtik.Trajectory.load, jtik.study.Comparison.load])
    def test_a_file_that_does_not_exist_is_named(self, load, tmp_path):
        for path in (tmp_path / "missing.npz", tmp_path / "folder.npz"):
            (tmp_path / "folder.npz").mkdir(exist_ok=True)
            with pytest.raises(
                jtik.ArgumentError,
                match=f"path: given {path}(, which is no regular file)?; accepted: ",
            ):
                load(path)


class TestNames:
    @pytest.mark.parametrize(
        "task",
        [
            jtik.FrameTask("panda_link88"),
            jtik.RelativeFrameTask("panda_link88", "panda_link1"),
            jtik.RelativeFrameTask("panda_link1", "panda_link88"),
            jtik.LookAtTask("panda_link88"),
            jtik.AxisTask("panda_link88"),
        ],
        ids=repr,
    )
    def test_every_task_suggests_the_frame_that_was_meant(self, task):
        with pytest.raises(jtik.UnknownNameError, match="frame 'panda_link88'; did you mean 'panda_link8'") as caught:
            jtik.InverseKinematics(PANDA, task)
        assert caught.value.known == PANDA.frame_names

    def test_the_case_of_letters_does_not_hide_what_was_meant(self):
        with pytest.raises(jtik.UnknownNameError, match="'UR5e'; did you mean 'ur5e'"):
            jtik.Robot.builtin("UR5e")
        with pytest.raises(jtik.UnknownNameError, match="'PANDA_HAND'; did you mean 'panda_hand'"):
            PANDA.pose(PANDA.neutral, "PANDA_HAND")


class TestSubsets:
    def test_one_without_a_joint_of_the_task(self):
        wrist = PANDA.subset(["panda_joint6", "panda_joint7"])
        with pytest.raises(
            jtik.ArgumentError, match=r"task: given .*panda_link3.*accepted: a task on frames that .* move"
        ):
            jtik.InverseKinematics(wrist, jtik.FrameTask("panda_link3"))
        with pytest.raises(jtik.ArgumentError, match=r"joints: given \['panda_joint6'\]; accepted: .*'panda_joint3'\]"):
            jtik.InverseKinematics(PANDA, jtik.FrameTask("panda_link3"), joints=["panda_joint6"])
        with pytest.raises(
            jtik.ArgumentError, match=r"joints: given \[\]; accepted: at least one on which the tasks depend"
        ):
            jtik.InverseKinematics(PANDA, jtik.FrameTask("tip"), joints=[])

    @pytest.mark.parametrize("build", [PANDA.subset, lambda joints: jtik.InverseKinematics(PANDA, ONE, joints=joints)])
    def test_a_joint_that_is_named_twice(self, build):
        with pytest.raises(jtik.ArgumentError, match="joints: given 'panda_joint2' more than once"):
            build(["panda_joint2", "panda_joint3", "panda_joint2"])

    def test_one_joint_may_come_without_a_list(self):
        ik = jtik.InverseKinematics(PANDA, jtik.FrameTask("tip"), joints="panda_joint2")
        assert ik.robot.joint_names == PANDA.subset("panda_joint2").joint_names == ("panda_joint2",)
        with pytest.raises(jtik.ArgumentError, match=r"joints: given \['everything'\]"):
            jtik.InverseKinematics(PANDA, jtik.FrameTask("tip"), joints="everything")


class TestLimits:
    @pytest.mark.parametrize("end", ["lower", "upper"])
    @pytest.mark.parametrize(
        ("build", "joint"),
        [
            (lambda **one: jtik.Robot.planar(3, **one), "joint1"),
            (lambda **one: jtik.Robot.vehicle(2, **one), "joint1"),
            (lambda **one: jtik.Robot.vehicle(2, **{f"vehicle_{end}": limit for end, limit in one.items()}), "x"),
            (lambda **one: jtik.Robot.from_dh([{"a": 1, "alpha": 0, "d": 0, "theta": 0, **one}]), "joint1"),
            (lambda **one: jtik.Joint("joint1", jtik.JointType.REVOLUTE, "base", "tip", **one), "joint1"),
        ],
    )
    def test_nan_names_the_joint(self, build, joint, end):
        with pytest.raises(
            jtik.ArgumentError, match=f"joint '{joint}' limits: given .*nan.*; accepted: lower <= upper, no NaN"
        ):
            build(**{end: math.nan})

    def test_a_solver_takes_them_from_the_robot_or_not_at_all(self):
        """Arrays would look as if they were used."""
        with pytest.raises(jtik.ArgumentError, match="limits: .*accepted: True or False"):
            jtik.InverseKinematics(PANDA, jtik.FrameTask("tip"), limits=(np.full(7, np.nan), np.ones(7)))


class TestTargets:
    @pytest.mark.quick(1)
    @pytest.mark.parametrize("pose", [STRETCHED, MIRRORED, SHEARED, np.zeros((4, 4))])
    def test_what_is_no_rotation_is_named_wherever_it_stands(self, pose):
        one = jtik.InverseKinematics(PANDA, jtik.FrameTask("tip", "pose"))
        two = jtik.InverseKinematics(
            PANDA, [jtik.FrameTask("tip", "pose"), jtik.FrameTask("panda_link4", name="elbow")]
        )
        calls = {
            r"target": lambda: one.solve(pose),
            r"target\['tip'\]": lambda: two.solve({"tip": pose, "elbow": (0.0, 0.0, 0.5)}),
            r"targets\[1\]": lambda: one.solve_batch([np.eye(4), pose]),
            r"targets\[2\]": lambda: one.track([np.eye(4), np.eye(4), pose]),
        }
        for name, call in calls.items():
            with pytest.raises(jtik.ArgumentError, match=f"(?s)^{name}: given .*accepted: a rotation: orthonormal"):
                call()
