"""Other libraries as contenders, if they are installed, with MuJoCo as the oracle."""

from __future__ import annotations

import importlib
import math
import pickle
import sys
import warnings
from dataclasses import fields

import mujoco
import numpy as np
import pytest

import jtik
from jtik.interop.mujoco_model import MujocoCorrespondence, to_mujoco
from jtik.robot.tree import Mimic
from jtik.study import peers
from jtik.study.contender import Setting
from jtik_formulations import JointCentering

MODULES = {
    "mink": "mink",
    "pink": "pink",
    "placo": "placo",
    "rtb": "roboticstoolbox",
    "optik": "optik",
    "pyroki": "pyroki",
}
TOLERANCE = 1e-6
SLACK = 1e-9
"""Relative rounding difference between two kinematics of one robot."""

EACH = pytest.mark.parametrize("name", MODULES)


def prepared(name, **options):
    """The prepared peer, without the warnings that the import of its library raises."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            importlib.import_module(MODULES[name])
        except ImportError as error:
            pytest.skip(f"{name}: {error}")
        return peers.named(name).prepare(Setting(**options))


class MujocoPose:
    """Forward kinematics of a robot's tip by MuJoCo."""

    def __init__(self, robot):
        self.robot, self.model = robot, to_mujoco(robot)
        self.data, self.places = mujoco.MjData(self.model), MujocoCorrespondence(robot, self.model)

    def pose(self, q):
        self.data.qpos[:] = self.places.qpos(q)
        mujoco.mj_kinematics(self.model, self.data)
        pose, tip = np.eye(4), self.data.body(self.robot.tip)
        pose[:3, :3], pose[:3, 3] = tip.xmat.reshape(3, 3), tip.xpos
        return pose

    def error(self, q, target, kind):
        """The larger of distance [m] and angle [rad], for the rows of the task."""
        pose = self.pose(q)
        cosine = (np.trace(target[:3, :3].T @ pose[:3, :3]) - 1) / 2
        small = np.linalg.norm(target[:3, :3] - pose[:3, :3]) / math.sqrt(2)
        errors = {
            "position": np.linalg.norm(pose[:3, 3] - target[:3, 3]),
            "orientation": small if cosine > 0.9 else math.acos(max(cosine, -1.0)),
        }
        return max(errors.values()) if kind == "pose" else errors[kind]


def problems(robot, rng, count=8):
    """(target, start): starts up to 0.2 rad or m from the solution, both well within the limits."""
    lower, upper = (
        np.where(np.isfinite(robot.lower), robot.lower, -2.0),
        np.where(np.isfinite(robot.upper), robot.upper, 2.0),
    )
    middle, half = (lower + upper) / 2, 0.6 * (upper - lower) / 2
    oracle = MujocoPose(robot)
    for _ in range(count):
        q = middle + half * rng.uniform(-1, 1, robot.n)
        yield oracle.pose(q), q + rng.uniform(-0.2, 0.2, robot.n)


def robot_of(name):
    return jtik.Robot.planar(4) if name == "planar" else jtik.Robot.builtin(name)


def test_names():
    assert set(peers.names()) == set(MODULES)
    assert [peers.named(name).label for name in peers.names()] == list(peers.names())
    with pytest.raises(jtik.errors.UnknownNameError, match="peer 'plako'; did you mean 'placo'"):
        peers.named("plako")


@EACH
class TestContender:
    def test_a_peer_can_be_pickled(self, name):
        assert pickle.loads(pickle.dumps(peers.named(name))) == peers.named(name)

    def test_options_and_label_can_be_set(self, name):
        kind = type(peers.named(name))
        option = next(each for each in fields(kind) if each.name == "restarted" or each.name == "threads")
        assert kind(label="other", **{option.name: 3}).label == "other"

    def test_the_error_says_how_to_install_the_library(self, name, monkeypatch):
        monkeypatch.setitem(sys.modules, MODULES[name], None)
        with pytest.raises(ImportError) as caught:
            peers.named(name).prepare(Setting(robot=jtik.Robot.planar(3), task=jtik.FrameTask("tip")))
        assert str(caught.value) == f"not installed: python -m pip install {peers.named(name).package}"

    def test_the_error_names_a_missing_dependency(self, name, monkeypatch, tmp_path):
        monkeypatch.delitem(sys.modules, MODULES[name], raising=False)
        (tmp_path / f"{MODULES[name]}.py").write_text("import no_such_thing")
        monkeypatch.syspath_prepend(tmp_path)
        with pytest.raises(ImportError, match=r"cannot be imported \(No module named 'no_such_thing'\)"):
            peers.named(name).prepare(Setting(robot=jtik.Robot.planar(3), task=jtik.FrameTask("tip")))

    def test_unsupported_tasks_are_refused(self, name):
        robot = jtik.Robot.builtin("panda")
        two = [jtik.FrameTask("tip"), jtik.FrameTask(robot.frame_names[3], name="elbow")]
        part = jtik.FrameTask("tip", kind="pose", axes=("x", "y"))
        for task in (two, jtik.AxisTask("tip"), part):
            with pytest.raises(jtik.ArgumentError, match=f"for {name}: one FrameTask with all of its axes"):
                peers.named(name).prepare(Setting(robot=robot, task=task))

    def test_mimic_joints_are_refused(self, name):
        lead = jtik.Joint("lead", jtik.JointType.REVOLUTE, "base", "one")
        follow = jtik.Joint("follow", jtik.JointType.REVOLUTE, "one", "two", mimic=Mimic("lead"), origin=shifted(0.5))
        robot = jtik.Robot([lead, follow, jtik.Joint("end", jtik.JointType.FIXED, "two", "tip", origin=shifted(0.5))])
        with pytest.raises(jtik.ArgumentError, match=f"joint 'follow', which follows 'lead'; accepted: for {name}"):
            peers.named(name).prepare(Setting(robot=robot, task=jtik.FrameTask("tip")))


def shifted(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


@pytest.mark.parametrize("name", [name for name in MODULES if name != "mink"])
def test_only_mink_supports_ball_joints(name):
    ball = jtik.Joint("ball", jtik.JointType.BALL, "base", "hand")
    robot = jtik.Robot([ball, jtik.Joint("end", jtik.JointType.FIXED, "hand", "tip", origin=shifted(0.5))])
    with pytest.raises(
        jtik.ArgumentError, match=f"a ball joint 'ball'; accepted: for {name}: revolute and prismatic joints"
    ):
        peers.named(name).prepare(Setting(robot=robot, task=jtik.FrameTask("tip")))


def test_prismatic_joints_that_the_toolbox_would_wrap_are_refused():
    rail = jtik.Joint("rail", jtik.JointType.PRISMATIC, "base", "cart", lower=0.0, upper=4.0)
    robot = jtik.Robot([rail, jtik.Joint("end", jtik.JointType.FIXED, "cart", "tip")])
    with pytest.raises(jtik.ArgumentError, match="prismatic joint 'rail', from 0 to 4 m"):
        peers.named("rtb").prepare(Setting(robot=robot, task=jtik.FrameTask("tip")))


@pytest.mark.quick(2, slow=20)
@EACH
@pytest.mark.parametrize(
    ("arm", "kind"),
    [
        pytest.param(arm, kind, marks=[] if row == column else pytest.mark.slow)
        for row, arm in enumerate(["panda", "ur5e", "planar"])
        for column, kind in enumerate(["pose", "position", "orientation"])
    ],
)
def test_nearby_targets_are_reached_according_to_mujoco(name, kind, arm, rng):
    robot = robot_of(arm)
    solver = prepared(name, robot=robot, task=jtik.FrameTask("tip", kind=kind))
    reduced = jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind=kind)).robot
    oracle, reached, count = MujocoPose(reduced), 0, 8
    for target, q0 in problems(reduced, rng, count):
        answer = solver.solve(solver.convert(target), q0)
        assert answer.q.shape == (reduced.nq,)
        if answer.claimed:
            assert oracle.error(answer.q, target, kind) <= TOLERANCE * (1 + SLACK)
            assert (answer.q >= reduced.lower - SLACK).all()
            assert (answer.q <= reduced.upper + SLACK).all()
            reached += 1
    assert reached >= 0.75 * count


@EACH
def test_restarts_solve_problems_that_the_start_does_not(name, rng):
    robot = jtik.Robot.builtin("panda")
    options = {"robot": robot, "task": jtik.FrameTask("tip", kind="pose")}
    solver, part = prepared(name, restarts=50, **options), Setting(**options).reduced()[0]
    found = [
        solver.solve(solver.convert(part.pose(part.random_configuration(rng))), part.random_configuration(rng)).claimed
        for _ in range(10)
    ]
    assert sum(found) == 10


@EACH
def test_success_is_not_reported_for_an_unreachable_target(name):
    solver = prepared(name, robot=jtik.Robot.planar(3), task=jtik.FrameTask("tip"), max_iterations=50)
    answer = solver.solve(solver.convert((3.5, 0.0)), np.array([0.3, 0.4, 0.5]))
    assert not answer.claimed
    assert answer.q.shape == (3,)


@EACH
def test_joints_outside_the_chain_do_not_move(name, rng):
    robot = jtik.Robot.builtin("panda")
    solver = prepared(name, robot=robot, task=jtik.FrameTask("tip", kind="pose"), joints="all")
    start = robot.keyframes["home"].copy()
    fingers = [robot.q_slice(joint).start for joint in robot.joint_names if "finger" in joint]
    start[fingers] = 0.01
    target = start.copy()
    target[0] += 0.2
    answer = solver.solve(solver.convert(robot.pose(target)), start)
    assert answer.claimed
    assert answer.q[fingers] == pytest.approx(start[fingers], abs=TOLERANCE)


@EACH
def test_limits_can_be_switched_off(name):
    """A target whose solution has the elbow outside its limits."""
    limited = jtik.Robot.planar(2, lower=0.5, upper=2.0)
    target, q0 = limited.position([0.1, 0.2]), np.array([0.6, 0.6])
    for limits in (True, False):
        solver = prepared(name, robot=limited, task=jtik.FrameTask("tip"), limits=limits, max_iterations=100)
        answer = solver.solve(solver.convert(target), q0)
        assert answer.claimed is not limits


class TestCriteria:
    @pytest.mark.parametrize("name", ["mink", "pink"])
    def test_mink_and_pink_minimise_the_criterion(self, name, rng):
        """The optimum of joint centring on the target agrees with that of jtik."""
        robot, task = jtik.Robot.planar(4), jtik.FrameTask("tip")
        solver = prepared(name, robot=robot, task=task, criteria=JointCentering(), until="stationary")
        ik = jtik.InverseKinematics(robot, task, criteria=JointCentering())
        q0, target = np.array([0.3, 0.4, 0.2, 0.5]), np.array([2.0, 2.0])
        answer = solver.solve(solver.convert(target), q0)
        assert answer.claimed
        assert answer.status == "CONVERGED"
        assert answer.q == pytest.approx(ik.solve(target, q0=q0).q, abs=1e-5)
        solver.set({"joint_centering.preferred": np.full(4, 0.5)})
        ik.parameters["joint_centering.preferred"] = np.full(4, 0.5)
        moved = solver.solve(solver.convert(target), q0).q
        assert moved == pytest.approx(ik.solve(target, q0=q0).q, abs=1e-5)
        assert np.abs(moved - answer.q).max() > 0.01
        solver.set({})
        assert solver.solve(solver.convert(target), q0).q == pytest.approx(answer.q)
        assert solver.note == ""

    @EACH
    def test_peers_without_criteria_say_so_in_their_note(self, name):
        options = {"robot": jtik.Robot.planar(3), "task": jtik.FrameTask("tip")}
        solver = prepared(name, criteria=JointCentering(), **options)
        optimizes = name in ("mink", "pink")
        assert peers.named(name).optimizes is optimizes
        assert solver.note == ("" if optimizes else "without the criterion")


@pytest.mark.parametrize("name", ["mink", "pink", "placo"])
def test_loops_record_their_iterations(name, rng):
    robot = jtik.Robot.planar(4)
    solver = prepared(name, robot=robot, task=jtik.FrameTask("tip"))
    target, q0 = next(problems(robot, rng))
    answer, trace = solver.traced(solver.convert(target), q0)
    assert len(trace) == answer.iterations > 0
    assert trace.q[0] == pytest.approx(q0)
    assert trace.q[-1] == pytest.approx(answer.q)
    p = np.linalg.norm(robot.position(q0) - target[:2, 3])
    assert trace.error[0] == pytest.approx(p, rel=0.1)  # a body twist is a little longer than the distance
    assert trace.error[-1] <= TOLERANCE
    assert solver.solve(solver.convert(target), q0).q == pytest.approx(answer.q)
    assert trace.figures["attempt"].shape == (len(trace),)
