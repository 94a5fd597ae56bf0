"""FrameTask: errors, Jacobians, stiffness and the forms a target may take."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

import jtik

from .conftest import DIFFERENCES, EXACT, ball_arm, dh_arm, differences, floating_arm, look, planar

ROBOTS = {
    "dh5": lambda: dh_arm(5, 1),
    "dh7": lambda: dh_arm(7, 2),
    "ball": ball_arm,
    "floating": floating_arm,
}
KINDS = ("position", "orientation", "pose")


def solver(robot, task):
    return jtik.InverseKinematics(robot, task, limits=False)


def expected_error(robot, kind, q, target):
    """World-axes position error and the rotation vector of R_target' R, from robot.pose and scipy."""
    pose = robot.pose(q)
    position = (pose - target)[: robot.dimension, 3]
    turn = Turn.from_matrix(target[:3, :3].T @ pose[:3, :3]).as_rotvec()
    turn = turn[2:] if robot.dimension == 2 else turn
    return {"position": position, "orientation": turn, "pose": np.concatenate([position, turn])}[kind]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ROBOTS)
def test_error_in_space(name, kind, rng):
    robot = ROBOTS[name]()
    ik = solver(robot, jtik.FrameTask("tip", kind))
    for _ in range(10):
        q, other = robot.random_configuration(rng), robot.random_configuration(rng)
        target = robot.pose(other)
        # 1e-10: a random rotation may be within 1e-2 of a half turn, where rounding counts a hundredfold
        assert look(ik, q, _target(kind, target)).error == pytest.approx(
            expected_error(robot, kind, q, target), abs=1e-10
        )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("heading", [False, True])
def test_error_in_the_plane(kind, heading, rng):
    robot = jtik.Robot.vehicle(3, heading=heading)
    ik = solver(robot, jtik.FrameTask("tip", kind))
    for _ in range(10):
        q, target = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        found = look(ik, q, target)
        assert found.error == pytest.approx(expected_error(robot, kind, q, target), abs=EXACT)
        assert found.position_error == pytest.approx(
            0 if kind == "orientation" else np.linalg.norm(found.error[:2]), abs=EXACT
        )
        assert found.orientation_error == pytest.approx(0 if kind == "position" else abs(found.error[-1]), abs=EXACT)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [*ROBOTS, "plane"])
def test_jacobian_is_the_derivative_of_the_error(name, kind, rng):
    robot = jtik.Robot.vehicle(3, heading=True) if name == "plane" else ROBOTS[name]()
    ik = solver(robot, jtik.FrameTask("tip", kind))
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.integrate(q, rng.uniform(-0.3, 0.3, robot.n)))
        target = target if name == "plane" else _target(kind, target)
        numeric = differences(lambda at, t=target: look(ik, at, t).error, robot, q)
        assert look(ik, q, target).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_on_the_target_itself(name, rng):
    """The logarithm at the identity: angular rows in the target's axes, which are the frame's own there."""
    robot = ROBOTS[name]()
    ik = solver(robot, jtik.FrameTask("tip", "pose"))
    q = robot.random_configuration(rng)
    pose = robot.pose(q)
    geometric = robot.jacobian(q)
    geometric[3:] = pose[:3, :3].T @ geometric[3:]
    assert look(ik, q, pose).jacobian == pytest.approx(geometric, abs=1e-11)


def test_any_frame_may_be_the_one_that_works(rng):
    robot = planar(4)
    q = robot.random_configuration(rng)
    found = look(solver(robot, jtik.FrameTask("link3")), q, (0.0, 0.0))
    assert found.error == pytest.approx(robot.position(q, "link3"), abs=EXACT)
    assert not found.jacobian[:, 2:].any()


def _target(kind, pose):
    return {"position": pose[:3, 3], "orientation": pose[:3, :3], "pose": pose}[kind]


class TestAxes:
    ALL = ("x", "y", "z", "rx", "ry", "rz")

    @pytest.mark.parametrize("axes", ["x", "zy", ["rz"], ("rx", "ry"), ["x", "y", "z", "rx"], ["ry", "x"], [*ALL]])
    def test_keep_the_rows_named_in_the_order_named(self, axes, rng):
        robot = dh_arm(6, 3)
        q, target = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        all_rows = look(solver(robot, jtik.FrameTask("tip", "pose")), q, target)
        kept = look(solver(robot, jtik.FrameTask("tip", "pose", axes=axes)), q, target)
        rows = [self.ALL.index(axis) for axis in axes]
        assert kept.error.tolist() == all_rows.error[rows].tolist()
        assert kept.jacobian == pytest.approx(all_rows.jacobian[rows], abs=EXACT)

    def test_without_rz_the_tool_may_spin_about_its_own_z(self, rng):
        robot = dh_arm(7, 4)
        ik = solver(robot, jtik.FrameTask("tip", "pose", axes=("x", "y", "z", "rx", "ry")))
        start = robot.random_configuration(rng)
        target = robot.pose(start + rng.uniform(-0.2, 0.2, robot.n))
        target[:3, :3] = target[:3, :3] @ Turn.from_rotvec([0, 0, 0.8]).as_matrix()
        solution = ik.solve(target, q0=start)
        assert solution.converged
        reached = robot.pose(solution.q)
        assert reached[:3, 3] == pytest.approx(target[:3, 3], abs=2e-6)
        assert reached[:3, 2] == pytest.approx(target[:3, 2], abs=2e-6)
        assert not np.allclose(reached[:3, 0], target[:3, 0], atol=1e-3)

    @pytest.mark.parametrize(
        ("kind", "axes"),
        [("position", "q"), ("position", ["rx"]), ("orientation", "x"), ("pose", ""), ("pose", "xx")],
    )
    def test_unknown_repeated_or_no_axes_are_refused(self, kind, axes):
        with pytest.raises(jtik.ArgumentError, match="axes.*distinct names from") as caught:
            solver(dh_arm(), jtik.FrameTask("tip", kind, axes=axes))
        assert caught.value.argument == "axes"

    def test_a_planar_robot_has_no_z(self):
        with pytest.raises(jtik.ArgumentError, match=r"axes.*\['x', 'y', 'rz'\]"):
            solver(planar(3), jtik.FrameTask("tip", "pose", axes="xz"))


class TestStiffness:
    """Kp enters as V = 1/2 e' Kp e and as the gradient J' Kp e."""

    MATRIX = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, -0.2], [0.0, -0.2, 3.0]])
    CASES = (
        (1.0, np.eye(3)),
        (2.5, 2.5 * np.eye(3)),
        ([1.0, 2.0, 3.0], np.diag([1.0, 2.0, 3.0])),
        (MATRIX, MATRIX),
    )

    @pytest.mark.parametrize(("stiffness", "Kp"), CASES)
    def test_V_is_half_the_weighted_square_of_the_error(self, stiffness, Kp, rng):
        robot = dh_arm(6, 5)
        ik = solver(robot, jtik.FrameTask("tip", "position", stiffness=stiffness))
        for _ in range(5):
            q, target = robot.random_configuration(rng), robot.position(robot.random_configuration(rng))
            solution = ik.solve(target, q0=q, max_iterations=1, trace=True)
            e = robot.position(q) - target
            assert solution.trace.V[0] == pytest.approx(e @ Kp @ e / 2, rel=EXACT)
            assert look(ik, q, target).error == pytest.approx(e, abs=EXACT)

    @pytest.mark.parametrize(("stiffness", "Kp"), CASES)
    def test_the_transpose_step_goes_along_the_weighted_gradient(self, stiffness, Kp, rng):
        robot = dh_arm(6, 5)
        law = jtik.strategies["transpose"](q_limit=np.inf, backtracking=False)
        ik = jtik.InverseKinematics(
            robot, jtik.FrameTask("tip", "position", stiffness=stiffness), strategy=law, limits=False
        )
        q, target = robot.random_configuration(rng), robot.position(robot.random_configuration(rng))
        J = robot.jacobian(q)[:3]
        u = Kp @ (robot.position(q) - target)
        g = J.T @ u
        alpha = (g @ g) / ((J @ g) @ Kp @ (J @ g))
        assert ik.step(q, target).q - q == pytest.approx(-alpha * g, abs=EXACT * 1e2)

    @pytest.mark.parametrize(
        "stiffness",
        [0.0, -1.0, [1.0, 0.0, 1.0], [1.0, 2.0], np.ones((2, 2)), np.ones((3, 3)), np.triu(np.ones((3, 3)))],
    )
    def test_what_is_not_positive_definite_or_does_not_fit_is_refused(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="(?s)stiffness.*positive definite") as caught:
            solver(dh_arm(), jtik.FrameTask("tip", stiffness=stiffness))
        assert caught.value.argument == "stiffness"

    @pytest.mark.parametrize("stiffness", [np.nan, np.inf, [1.0, np.nan, 1.0], np.ones((1, 1, 1))])
    def test_what_is_not_finite_is_refused_at_once(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="stiffness"):
            jtik.FrameTask("tip", stiffness=stiffness)


class SE3:
    """What other libraries hand over: an object with ``as_matrix()``."""

    def __init__(self, matrix):
        self._matrix = matrix

    def as_matrix(self):
        return self._matrix


class TestTargets:
    def test_forms_of_one_target_in_space_give_the_same_error(self, rng):
        robot = dh_arm(6, 6)
        q, pose = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        forms = {
            "position": [pose[:3, 3], pose[:3, 3].tolist(), pose, SE3(pose), tuple(pose[:3, 3])],
            "orientation": [pose[:3, :3], pose, SE3(pose), Turn.from_matrix(pose[:3, :3])],
            "pose": [pose, pose.tolist(), SE3(pose)],
        }
        for kind, targets in forms.items():
            ik = solver(robot, jtik.FrameTask("tip", kind))
            for target in targets:
                assert look(ik, q, target).error == pytest.approx(expected_error(robot, kind, q, pose), abs=1e-10)

    def test_forms_of_one_target_in_the_plane_give_the_same_error(self, rng):
        robot = planar(3)
        q, other = robot.random_configuration(rng), robot.random_configuration(rng)
        pose, (x, y), angle = robot.pose(other), robot.position(other), float(other.sum())
        forms = {
            "position": [(x, y), np.array([x, y]), pose, SE3(pose)],
            "orientation": [
                angle,
                [angle],
                np.float64(angle),
                angle + 4 * np.pi,
                pose[:3, :3],
                pose,
                SE3(pose),
            ],
            "pose": [(x, y, angle), (x, y, angle - 2 * np.pi), pose, SE3(pose)],
        }
        for kind, targets in forms.items():
            ik = solver(robot, jtik.FrameTask("tip", kind))
            for target in targets:
                assert look(ik, q, target).error == pytest.approx(expected_error(robot, kind, q, pose), abs=1e-11)

    @pytest.mark.parametrize("turns", [-3, -1, 0, 1, 2])
    @pytest.mark.parametrize(("angle", "target"), [(3.1, -3.1), (-3.1, 3.1), (0.1, -0.1), (1.0, 4.0)])
    def test_a_planar_angle_takes_the_short_way_round(self, angle, target, turns):
        ik = solver(planar(2), jtik.FrameTask("tip", "orientation"))
        wanted = (angle - target + np.pi) % (2 * np.pi) - np.pi
        found = look(ik, [angle + 2 * np.pi * turns, 0.0], target).error[0]
        assert found == pytest.approx(wanted, abs=1e-11)
        assert abs(found) <= np.pi

    BENT = np.eye(4)
    BENT[0, 0] = 1.1
    MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])

    @pytest.mark.parametrize(
        ("kind", "target"),
        [
            ("position", (1.0, 2.0)),
            ("position", (1.0, 2.0, 3.0, 4.0)),
            ("position", 1.0),
            ("position", np.eye(3)),
            ("position", (1.0, np.nan, 0.0)),
            ("position", (1.0, np.inf, 0.0)),
            ("position", "there"),
            ("position", None),
            ("position", [[1.0], [2.0, 3.0]]),
            ("orientation", 0.3),
            ("orientation", (1.0, 0.0, 0.0)),
            ("orientation", BENT[:3, :3]),
            ("orientation", MIRROR[:3, :3]),
            ("orientation", np.zeros((3, 3))),
            ("pose", (1.0, 2.0, 3.0)),
            ("pose", np.ones(12)),
            ("pose", BENT),
            ("pose", MIRROR),
            ("pose", np.full((4, 4), np.nan)),
            ("position", MIRROR),
        ],
    )
    def test_what_is_no_target_is_refused_by_name(self, kind, target):
        ik = solver(dh_arm(), jtik.FrameTask("tip", kind))
        for call in (ik.solve, lambda wrong: ik.step(ik.robot.neutral, wrong)):
            with pytest.raises(jtik.ArgumentError, match="(?s)^target: .*accepted: .*") as caught:
                call(target)
            assert caught.value.argument == "target"
            assert any(word in caught.value.accepted for word in ("(x, y, z)", "(3, 3)", "(4, 4)", "rotation"))

    @pytest.mark.parametrize(
        ("kind", "target"),
        [
            ("position", (1.0, 2.0, 3.0)),
            ("position", 1.0),
            ("position", [np.nan, 0.0]),
            ("orientation", (1.0, 2.0)),
            ("orientation", np.nan),
            ("pose", (1.0, 2.0)),
            ("pose", (1.0, 2.0, np.inf)),
            ("pose", MIRROR),
        ],
    )
    def test_what_is_no_planar_target_is_refused_by_name(self, kind, target):
        ik = solver(planar(2), jtik.FrameTask("tip", kind))
        with pytest.raises(jtik.ArgumentError, match="(?s)^target: .*accepted: .*"):
            ik.solve(target)

    def test_an_object_whose_matrix_is_nonsense_is_refused(self):
        ik = solver(dh_arm(), jtik.FrameTask("tip", "pose"))
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(SE3(self.BENT))

    def test_a_pose_off_the_plane_is_no_planar_target(self):
        """Reading the angle of a tilted rotation would silently aim at something else."""
        tilted = np.eye(4)
        tilted[:3, :3] = Turn.from_rotvec([0.5, 0, 0]).as_matrix()
        ik = solver(planar(3), jtik.FrameTask("tip", "pose"))
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(tilted)

    def test_a_pose_whose_last_row_is_wrong_is_refused(self):
        scaled = np.eye(4)
        scaled[3, 3] = 2.0
        ik = solver(dh_arm(), jtik.FrameTask("tip", "pose"))
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(scaled)

    def test_a_target_printed_with_six_digits_is_accepted(self):
        R = np.round(Turn.from_rotvec([0.3, -0.4, 0.5]).as_matrix(), 6)
        ik = solver(dh_arm(), jtik.FrameTask("tip", "orientation"))
        assert np.isfinite(look(ik, ik.robot.neutral, R).error).all()

    def test_a_target_is_copied(self, rng):
        robot = planar(3)
        target = np.array([1.0, 1.0])
        ik = solver(robot, jtik.FrameTask())
        first = ik.solve(target, q0=[0.3, 0.3, 0.3])
        ik.solve([2.0, 0.5], q0=[0.3, 0.3, 0.3])
        assert target.tolist() == [1.0, 1.0]
        assert robot.position(first.q) == pytest.approx(target, abs=2e-6)


class TestSeveralTasks:
    def test_errors_and_jacobians_stack_in_the_order_given(self, rng):
        robot = planar(6)
        tip, elbow = jtik.FrameTask("tip"), jtik.FrameTask("link4", "orientation", name="elbow")
        both = solver(robot, [tip, elbow])
        q = robot.random_configuration(rng)
        found = look(both, q, {"tip": (1.0, 2.0), "elbow": 0.4})
        one, other = look(solver(robot, tip), q, (1.0, 2.0)), look(solver(robot, elbow), q, 0.4)
        assert found.error == pytest.approx([*one.error, *other.error], abs=EXACT)
        assert found.jacobian == pytest.approx(np.vstack([one.jacobian, other.jacobian]), abs=EXACT)
        assert found.position_error == pytest.approx(one.position_error, abs=EXACT)
        assert found.orientation_error == pytest.approx(other.orientation_error, abs=EXACT)

    def test_both_are_reached(self, rng):
        robot = planar(6)
        ik = solver(robot, [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow")])
        goal = rng.uniform(-0.5, 0.5, 6)
        solution = ik.solve({"tip": robot.position(goal), "elbow": robot.position(goal, "link4")}, q0=goal + 0.2)
        assert solution.converged
        assert robot.position(solution.q, "link4") == pytest.approx(robot.position(goal, "link4"), abs=2e-6)

    def test_stiffness_blocks_stay_apart(self, rng):
        robot = planar(6)
        tasks = [
            jtik.FrameTask("tip", stiffness=[[2.0, 0.5], [0.5, 1.0]]),
            jtik.FrameTask("link4", stiffness=3.0),
        ]
        q = robot.random_configuration(rng)
        solution = solver(robot, tasks).solve({"tip": (0, 1), "link4": (1, 1)}, q0=q, max_iterations=1, trace=True)
        Kp = np.diag([2.0, 1.0, 3.0, 3.0])
        Kp[0, 1] = Kp[1, 0] = 0.5
        e = np.concatenate([robot.position(q) - (0, 1), robot.position(q, "link4") - (1, 1)])
        assert solution.trace.V[0] == pytest.approx(e @ Kp @ e / 2, rel=EXACT)

    @pytest.mark.parametrize("target", [(1.0, 1.0), {"tip": (1.0, 1.0)}, {"tip": (1, 1), "link": (1, 1)}])
    def test_a_target_for_each_is_needed(self, target):
        ik = solver(planar(4), [jtik.FrameTask("tip"), jtik.FrameTask("link3")])
        with pytest.raises(jtik.ArgumentError, match=r"target.*\['tip', 'link3'\]"):
            ik.solve(target)

    @pytest.mark.parametrize("tasks", [[], [jtik.FrameTask(), jtik.FrameTask()], ["tip"], [None]])
    def test_none_the_same_twice_or_something_else_is_refused(self, tasks):
        with pytest.raises(jtik.ArgumentError, match="^task: "):
            solver(planar(2), tasks)


class TestRefusals:
    def test_an_unknown_frame_lists_the_frames(self):
        with pytest.raises(jtik.UnknownNameError) as caught:
            solver(planar(2), jtik.FrameTask("hand"))
        assert caught.value.name == "hand"
        assert set(caught.value.known) == set(planar(2).frame_names)
        assert "link1" in str(caught.value)

    @pytest.mark.parametrize("kind", ["velocity", None, 3])
    def test_an_unknown_kind_lists_the_kinds(self, kind):
        with pytest.raises(jtik.ArgumentError, match="kind.*'position', 'orientation' or 'pose'"):
            jtik.FrameTask("tip", kind)

    @pytest.mark.parametrize("priority", [-1, 0.5, "high"])
    def test_priorities_are_integers_from_zero(self, priority):
        with pytest.raises(jtik.ArgumentError, match="priority"):
            jtik.FrameTask("tip", priority=priority)

    def test_options_are_keyword_only(self):
        with pytest.raises(TypeError):
            jtik.FrameTask("tip", "position", "xy")
