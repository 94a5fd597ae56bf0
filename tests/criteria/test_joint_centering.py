"""JointCentering: H = 1/2 (q - preferred)' K (q - preferred)."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import DIFFERENCES, EXACT, ball_arm, dh_arm, differences, planar, report_at


def solver(robot, criterion, kind="position"):
    return jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), criteria=criterion, limits=False)


def at(ik, q):
    return report_at(ik, q, ik.robot.pose(q))


def test_default_is_half_the_squared_angles(rng):
    robot = planar(6)
    ik = solver(robot, JointCentering())
    for _ in range(10):
        q = robot.random_configuration(rng)
        found = at(ik, q)
        assert found.cost == pytest.approx(q @ q / 2, rel=EXACT)
        assert found.gradient == pytest.approx(q, abs=EXACT)
        assert found.criteria == {"joint_centering": pytest.approx(q @ q / 2)}


@pytest.mark.parametrize("stiffness", [0.7, [1.0, 0.0, 2.0, 3.0, 0.5, 4.0]])
def test_stiffness_and_preferred_angles(stiffness, rng):
    robot = dh_arm(6, 1)
    preferred = rng.uniform(-1, 1, 6)
    ik = solver(robot, JointCentering(stiffness, preferred))
    k = np.broadcast_to(stiffness, 6)
    for _ in range(10):
        q = robot.random_configuration(rng)
        found = at(ik, q)
        assert found.cost == pytest.approx(k @ (q - preferred) ** 2 / 2, rel=EXACT)
        assert found.gradient == pytest.approx(k * (q - preferred), abs=EXACT)


def test_a_zero_stiffness_has_no_force_and_no_nan():
    robot = planar(3)
    found = at(solver(robot, JointCentering([0.0, 0.0, 0.0])), [0.3, 0.0, -0.2])
    assert found.cost == 0
    assert found.gradient.tolist() == [0, 0, 0]


def test_the_default_is_the_position_within_the_limits_closest_to_zero():
    robot = jtik.Robot.planar(2, lower=[0.5, -1.0], upper=[1.0, 1.0])
    assert at(solver(robot, JointCentering()), [0.5, 0.0]).cost == 0


def test_only_revolute_and_prismatic_joints_have_a_spring(rng):
    robot = ball_arm()
    ik = solver(robot, JointCentering(2.0))
    q = robot.random_configuration(rng)
    found = at(ik, q)
    scalars = q[robot.scalar_q]
    assert found.cost == pytest.approx(scalars @ scalars, rel=EXACT)
    numeric = differences(lambda p: at(ik, p).cost, robot, q)[0]
    assert found.gradient == pytest.approx(numeric, abs=DIFFERENCES)


def test_live_parameters_act_as_if_built_with_them(rng):
    robot = planar(5)
    preferred, stiffness = rng.uniform(-1, 1, 5), rng.uniform(0.1, 2, 5)
    changed, built = solver(robot, JointCentering()), solver(robot, JointCentering(stiffness, preferred))
    changed.parameters["joint_centering.preferred"] = preferred
    changed.parameters["joint_centering.stiffness"] = stiffness
    q0 = rng.uniform(-1, 1, 5)
    target = robot.position(rng.uniform(-1, 1, 5))
    assert changed.solve(target, q0=q0).q.tolist() == built.solve(target, q0=q0).q.tolist()


@pytest.mark.parametrize("stiffness", [-1.0, [1.0, -0.1], np.nan])
def test_a_negative_stiffness_is_refused(stiffness):
    with pytest.raises(jtik.ArgumentError, match="^stiffness: given .*; accepted: non-negative numbers: "):
        JointCentering(stiffness)


def test_sizes_that_do_not_fit_the_robot_are_refused():
    with pytest.raises(jtik.ArgumentError, match=r"preferred.*\(3,\)"):
        solver(planar(3), JointCentering(preferred=[0.0, 0.0]))
    with pytest.raises(
        jtik.ArgumentError, match=r"stiffness: given shape \(2,\); accepted: 3 numbers for ik.robot, one"
    ):
        solver(planar(3), JointCentering([1.0, 2.0]))


def test_arrays_are_copied():
    preferred = np.zeros(3)
    criterion = JointCentering(preferred=preferred)
    preferred[:] = 7.0
    assert at(solver(planar(3), criterion), [0.0, 0.0, 0.0]).cost == 0


class TestStiffnessByJointName:
    def test_joints_not_named_keep_the_default(self):
        robot = planar(3)
        named = JointCentering({"joint2": 3.0, "joint3": 0})
        assert named.parameters(robot)["stiffness"].tolist() == [1.0, 3.0, 0.0]
        q = np.array([0.1, 0.2, 0.3])
        assert named(q, robot) == JointCentering([1.0, 3.0, 0.0])(q, robot)

    def test_places_follow_q_where_a_joint_has_several_entries(self, rng):
        robot = ball_arm()
        q = robot.random_configuration(rng)
        criterion = JointCentering({"lift": 5.0, "elbow": 2.0})
        elbow, lift = q[robot.q_slice("elbow")][0], q[robot.q_slice("lift")][0]
        assert criterion(q, robot) == pytest.approx(elbow**2 + 2.5 * lift**2)

    def test_a_name_that_is_no_revolute_or_prismatic_joint(self):
        with pytest.raises(jtik.UnknownNameError, match="revolute or prismatic joint 'wrist'.*known: elbow, lift"):
            JointCentering({"wrist": 2.0}).parameters(ball_arm())

    @pytest.mark.parametrize("joint", ["elbw", "tip"])
    def test_a_name_that_is_no_moving_joint(self, joint):
        with pytest.raises(jtik.UnknownNameError, match=f"unknown joint in stiffness '{joint}'.*elbow"):
            JointCentering({joint: 2.0}).parameters(ball_arm())

    def test_locked_joints_of_the_full_robot_are_ignored(self):
        part = planar(3).subset(["joint2"], at=np.zeros(3))
        for given in ({"joint1": 5.0, "joint2": 2.0}, [5.0, 2.0, 7.0], [2.0]):
            assert JointCentering(given).parameters(part)["stiffness"].tolist() == [2.0]

    @pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "stiff", [1.0, 2.0]])
    def test_a_value_that_is_no_non_negative_number(self, value):
        with pytest.raises(jtik.ArgumentError, match=r"^stiffness\['elbow'\]: .*; accepted: (a non-neg|one finite)"):
            JointCentering({"elbow": value})

    def test_it_is_copied(self):
        stiffness = {"joint1": 2.0}
        criterion = JointCentering(stiffness)
        stiffness["joint1"] = 7.0
        assert criterion.parameters(planar(3))["stiffness"].tolist() == [2.0, 1.0, 1.0]


class TestPreferred:
    """Whatever ``robot.configuration`` accepts: it reads the value that was given."""

    @pytest.mark.parametrize("given", [{"joint1": 0.4}, [0.4, 0.0, 0.0, 0.0, 0.0]])
    def test_the_robot_reads_it_as_given(self, given, monkeypatch):
        seen = []

        def configuration(robot, q, *, argument="q"):
            seen.append((q if isinstance(q, dict) else q.tolist(), argument))
            return np.array([0.4, 0.0, 0.0])

        monkeypatch.setattr(jtik.Robot, "configuration", configuration)
        assert JointCentering(preferred=given).parameters(planar(3))["preferred"].tolist() == [0.4, 0.0, 0.0]
        assert seen == [(given, "preferred")]

    def test_a_dict_is_copied(self):
        preferred = {"joint1": 0.4}
        criterion = JointCentering(preferred=preferred)
        preferred["joint1"] = 7.0
        assert repr(criterion) == "JointCentering(preferred={'joint1': 0.4})"

    @pytest.mark.parametrize(
        ("preferred", "message"),
        [
            ([0.0, 0.0], r"^preferred: given shape \(2,\); accepted: .*\(3,\)"),
            ([0.0, np.nan, 0.0], "^preferred: given nan at index 1"),
        ],
    )
    def test_an_invalid_configuration_is_refused(self, preferred, message):
        with pytest.raises(jtik.ArgumentError, match=message):
            solver(planar(3), JointCentering(preferred=preferred))

    @pytest.mark.parametrize("argument", ["stiffness", "preferred"])
    def test_a_value_that_is_not_numeric_is_refused(self, argument):
        with pytest.raises(jtik.ArgumentError, match=f"^{argument}: given .*; accepted: .*numbers.*one for each"):
            JointCentering(**{argument: "soft"})
        with pytest.raises(jtik.ArgumentError, match=f"^{argument}: given .*; accepted: .*numbers.*one for each"):
            JointCentering(**{argument: [1j, 0.0]})
