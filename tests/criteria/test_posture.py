"""MinimumDisplacement, FrameProximity, SwivelAngle, CompactPosture, LookAt and Visibility."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik_formulations import CompactPosture, FrameProximity, LookAt, MinimumDisplacement, SwivelAngle, Visibility

from ..conftest import EXACT, ball_arm, dh_arm, floating_arm, planar, planar_points, shared_solver
from .derivatives import panda


class TestMinimumDisplacement:
    def test_of_scalar_joints_it_is_half_the_weighted_square(self, rng):
        robot = dh_arm(6, 1)
        reference, k = rng.uniform(-1, 1, 6), rng.uniform(0, 2, 6)
        q = robot.random_configuration(rng)
        criterion = MinimumDisplacement(reference, k)
        assert criterion(q, robot) == pytest.approx(k @ (q - reference) ** 2 / 2, rel=EXACT)
        assert criterion.gradient(q, robot) == pytest.approx(k * (q - reference), rel=EXACT)

    def test_the_default_is_where_a_solve_starts(self, rng):
        robot = panda()
        assert MinimumDisplacement()(robot.home, robot) == 0
        start = shared_solver(robot, jtik.FrameTask()).solve([0.4, 0.1, 0.4], max_iterations=0).q
        assert MinimumDisplacement()(start, robot) == 0

    @pytest.mark.parametrize("angle", [1e-9, 0.4, 2.0, np.pi - 1e-7, np.pi, 3.5])
    def test_of_a_rotation_it_is_one_minus_the_cosine(self, angle, rng):
        robot = ball_arm()
        reference = robot.random_configuration(rng)
        axis = rng.standard_normal(3)
        turn = np.zeros(robot.n)
        turn[robot.v_slice("shoulder")] = angle * axis / np.linalg.norm(axis)
        q = robot.integrate(reference, turn)
        assert MinimumDisplacement(reference)(q, robot) == pytest.approx(1 - np.cos(angle), abs=1e-12)

    def test_a_free_joint_counts_with_position_and_rotation(self, rng):
        robot = floating_arm()
        reference = robot.random_configuration(rng)
        motion = rng.standard_normal(robot.n)
        q = robot.integrate(reference, motion)
        k = rng.uniform(0, 2, robot.n)
        moved = (q - reference)[:3]
        turned = (Rotation.from_quat(reference[[4, 5, 6, 3]]).inv() * Rotation.from_quat(q[[4, 5, 6, 3]])).as_quat()[:3]
        wanted = k[:3] @ moved**2 / 2 + 2 * k[3:6] @ turned**2 + k[6:] @ motion[6:] ** 2 / 2
        assert MinimumDisplacement(reference, k)(q, robot) == pytest.approx(wanted, rel=1e-10)

    def test_a_quaternion_of_the_other_sign_is_the_same_reference(self, rng):
        robot = ball_arm()
        q, reference = robot.random_configuration(rng), robot.random_configuration(rng)
        other = reference.copy()
        other[robot.q_slice("wrist")] *= -3
        assert MinimumDisplacement()(q, robot, reference=other) == pytest.approx(
            MinimumDisplacement()(q, robot, reference=reference), rel=1e-12
        )

    def test_it_changes_a_posture_less_than_a_solve_without(self, rng):
        robot, q0 = planar(8), np.full(8, 0.3)
        target = robot.position(q0) - np.array([0.4, 0.6])
        ik = shared_solver(robot, jtik.FrameTask(), criteria=MinimumDisplacement())
        ik.parameters["minimum_displacement.reference"] = q0
        with_it = ik.solve(target, q0=q0, until="stationary")
        without = shared_solver(robot, jtik.FrameTask()).solve(target, q0=q0)
        assert with_it.status is jtik.Status.CONVERGED
        assert np.linalg.norm(with_it.q - q0) <= np.linalg.norm(without.q - q0)
        assert robot.jacobian(with_it.q)[:2].T @ np.linalg.lstsq(
            robot.jacobian(with_it.q)[:2].T, with_it.q - q0, rcond=None
        )[0] == pytest.approx(with_it.q - q0, abs=1e-5)  # in the row space: the shortest

    def test_wrong_arguments_are_refused(self):
        with pytest.raises(jtik.ArgumentError, match="^stiffness"):
            MinimumDisplacement(stiffness=-1.0)([0.0, 0.0], planar(2))
        with pytest.raises(jtik.ArgumentError, match="stiffness.*non-negative"):
            MinimumDisplacement()([0.0, 0.0], planar(2), stiffness=[1.0, -1.0])
        with pytest.raises(jtik.ArgumentError, match="^reference"):
            MinimumDisplacement([0.0])([0.0, 0.0], planar(2))
        with pytest.raises(jtik.UnknownNameError):
            MinimumDisplacement(stiffness={"knee": 1.0})([0.0, 0.0], planar(2))


class TestFrameProximity:
    @pytest.mark.parametrize("name", ["planar", "dh"])
    def test_distances_in_closed_form(self, name, rng):
        robot = {"planar": planar(5), "dh": dh_arm(6, 2)}[name]
        d, frame = robot.dimension, robot.moving_frames[2]
        a, n = rng.standard_normal(d), rng.standard_normal(d)
        unit = n / np.linalg.norm(n)
        for _ in range(4):
            q = robot.random_configuration(rng)
            p = robot.position(q, frame)
            across = (p - a) - unit * (unit @ (p - a))
            wanted = {
                "point": np.sum((p - a) ** 2) / 2,
                "line": across @ across / 2,
                "plane": (unit @ (p - a)) ** 2 / 2,
                "height": (p[-1] - 0.3) ** 2 / 2,
            }
            places = {"point": a, "line": (a, n), "plane": (a, n), "height": 0.3}
            for place, value in places.items():
                assert FrameProximity(frame, **{place: value})(q, robot) == pytest.approx(wanted[place], rel=1e-10)

    def test_a_direction_of_any_length_is_live(self, rng):
        robot, q = planar(4), planar(4).random_configuration(rng)
        criterion = FrameProximity(plane=((0, 0), (0, 1)))
        y = robot.position(q)[1]
        assert criterion(q, robot) == pytest.approx(y**2 / 2)
        x = robot.position(q)[0]
        assert criterion(q, robot, direction=[5.0, 0.0]) == pytest.approx(x**2 / 2)
        assert criterion(q, robot, direction=[0.0, 0.0]) == 0

    def test_the_elbow_comes_nearer_beside_the_task(self):
        robot = panda()
        q0 = robot.home
        criterion = FrameProximity("panda_link4", height=0.4)
        ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), criteria=criterion)
        solution = ik.solve(robot.pose(q0), q0=q0, until="stationary")
        assert solution.converged
        assert abs(robot.position(solution.q, "panda_link4")[2] - 0.4) < abs(robot.position(q0, "panda_link4")[2] - 0.4)

    @pytest.mark.parametrize(
        ("places", "argument"),
        [
            ({}, "place"),
            ({"height": 1.0, "point": (0, 0)}, "place"),
            ({"point": (0, 0, 0)}, "point"),
            ({"line": ((0, 0), (0, 0))}, "line[1]"),
            ({"plane": ((0, 0), (0, 1), (1, 0))}, "plane"),
            ({"plane": 3.0}, "plane"),
            ({"plane": ("a", (0, 1))}, "plane[0]"),
            ({"height": np.nan}, "height"),
        ],
    )
    def test_wrong_places_are_refused(self, places, argument):
        with pytest.raises(jtik.ArgumentError) as caught:
            FrameProximity(**places)([0.1, 0.2], planar(2))
        assert caught.value.argument == argument

    def test_an_unknown_frame_is_refused(self):
        with pytest.raises(jtik.UnknownNameError):
            FrameProximity("knee", height=1.0)([0.1, 0.2], planar(2))


ARM = ("panda_link2", "panda_link4", "panda_link6")


class TestSwivelAngle:
    def test_it_is_the_angle_of_the_elbow_about_the_line(self, rng):
        robot, r = panda(), np.array([0.0, 0.0, 1.0])
        for _ in range(5):
            q = robot.random_configuration(rng)
            s, e, w = (robot.position(q, frame) for frame in ARM)
            line = (w - s) / np.linalg.norm(w - s)
            x = r - line * (r @ line)
            x /= np.linalg.norm(x)
            y = np.cross(line, x)
            phi = np.arctan2((e - s) @ y, (e - s) @ x)
            for angle in (0.0, 0.7, -2.5):
                found = SwivelAngle(*ARM, angle=angle, floor=1e-9)(q, robot)
                assert found == pytest.approx(1 - np.cos(phi - angle), abs=1e-8)

    def test_turning_the_elbow_about_the_line_turns_the_angle(self):
        """A solve with the hand held and another angle: H falls to 0, and the hand stays."""
        robot = panda()
        q0 = robot.home
        ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), criteria=SwivelAngle(*ARM, floor=1e-4))
        for angle in (0.0, 0.3, -0.4):
            ik.parameters["swivel_angle.angle"] = angle
            solution = ik.solve(robot.pose(q0), q0=q0, until="stationary", max_iterations=1000)
            assert solution.converged
            assert solution.cost < 1e-5

    def test_on_a_planar_robot_it_is_the_side_of_the_elbow(self):
        robot = planar(2)
        right = SwivelAngle("base", "link2", "tip", angle=np.pi / 2, floor=1e-3)
        for bend in (0.8, -0.8):  # a positive bend leaves the elbow on the right of the line
            assert right([0.3, bend], robot) == pytest.approx(0.0 if bend > 0 else 2.0, abs=1e-4)

    @pytest.mark.parametrize("q", [[0.0, 0.0], [0.5, np.pi], [0.4, 1e-9]])
    def test_finite_where_the_angle_has_no_meaning(self, q):
        """A straight arm, and a folded one, whose wrist is on the shoulder."""
        robot = planar(2)
        for options in ({}, {"reference": (1.0, 0.0, 0.0)}):
            criterion = SwivelAngle("base", "link2", "tip", angle=1.0, **options)
            assert 0 <= criterion(q, robot) <= 2
            assert np.isfinite(criterion.gradient(q, robot)).all()

    def test_wrong_arguments_are_refused(self):
        with pytest.raises(jtik.ArgumentError, match="^reference"):
            SwivelAngle(*ARM, reference=(0, 0, 0))
        with pytest.raises(jtik.ArgumentError, match="^floor"):
            SwivelAngle(*ARM, floor=0.0)
        with pytest.raises(jtik.UnknownNameError):
            SwivelAngle("base", "knee", "tip")([0.1, 0.2], planar(2))


class TestCompactPosture:
    def test_it_is_half_the_mean_squared_distance(self, rng):
        robot, q = planar(6), planar(6).random_configuration(rng)
        points, center = planar_points(q), rng.standard_normal(2)
        assert CompactPosture()(q, robot) == pytest.approx(np.mean(np.sum(points**2, axis=1)) / 2, rel=EXACT)
        moved = np.mean(np.sum((points - center) ** 2, axis=1)) / 2
        assert CompactPosture(center)(q, robot) == pytest.approx(moved, rel=EXACT)
        assert CompactPosture()(q, robot, center=center) == pytest.approx(moved, rel=EXACT)

    def test_a_straight_arm_is_the_largest(self):
        robot = planar(6)
        straight = CompactPosture()(np.zeros(6), robot)
        assert straight == pytest.approx(np.mean(np.arange(1, 7) ** 2) / 2)
        assert CompactPosture()(np.full(6, 0.3), robot) < straight

    def test_a_center_of_another_dimension_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="^center"):
            CompactPosture((0, 0, 0))([0.1, 0.2], planar(2))


class TestSight:
    def test_the_angle_in_closed_form(self, rng):
        robot = dh_arm(6, 2)
        for _ in range(5):
            q, target, axis = robot.random_configuration(rng), rng.standard_normal(3), rng.standard_normal(3)
            T = robot.pose(q)
            sight = target - T[:3, 3]
            cosine = (T[:3, :3] @ axis) @ sight / np.linalg.norm(axis) / np.linalg.norm(sight)
            assert LookAt(target, axis=axis, floor=1e-7)(q, robot) == pytest.approx(1 - cosine, abs=1e-10)
            for half in (0.3, 1.2, 2.8):
                wanted = max(0.0, np.cos(half) - cosine) ** 3 / (1 + np.cos(half)) ** 3
                found = Visibility(target, axis=axis, half_angle=half, floor=1e-7)(q, robot)
                assert found == pytest.approx(wanted, abs=1e-9)

    def test_the_default_axis_is_z_and_x_on_a_planar_robot(self):
        arm = planar(2)
        assert LookAt((7.0, 0.0))([0.0, 0.0], arm) == pytest.approx(0, abs=1e-6)
        assert LookAt((-7.0, 0.0))([0.0, 0.0], arm) == pytest.approx(2, abs=1e-6)
        robot = panda()
        T = robot.pose(robot.home)
        assert LookAt(T[:3, 3] + 0.5 * T[:3, 2])(robot.home, robot) == pytest.approx(0, abs=1e-5)

    def test_in_view_visibility_is_zero_with_zero_gradient(self):
        arm, q = planar(3), [0.1, 0.2, -0.1]
        ahead = arm.position(q) + 3 * np.array([np.cos(0.2 + 0.4), np.sin(0.2 + 0.4)])
        assert Visibility(ahead, half_angle=0.5)(q, arm) == 0
        assert Visibility(ahead, half_angle=0.5).gradient(q, arm).tolist() == [0, 0, 0]
        assert Visibility(ahead, half_angle=0.3)(q, arm) > 0

    @pytest.mark.parametrize("criterion", [LookAt, Visibility])
    def test_finite_with_the_target_on_the_frame(self, criterion):
        arm, q = planar(3), [0.4, 0.2, -0.1]
        made = criterion(arm.position(q))
        assert np.isfinite(made(q, arm))
        assert np.isfinite(made.gradient(q, arm)).all()
        assert np.isfinite(made.gradient(q, arm, axis=[0.0, 0.0])).all()

    @pytest.mark.parametrize("scale", [1e200, 1e-200])
    def test_the_length_of_the_axis_does_not_matter(self, scale):
        q, arm = [0.1, 0.2], planar(2)
        scaled = LookAt((1, 1), axis=(0.6 * scale, 0.8 * scale))(q, arm)
        assert scaled == pytest.approx(LookAt((1, 1), axis=(0.6, 0.8))(q, arm), rel=EXACT)

    def test_a_camera_is_turned_beside_a_position_task(self, rng):
        robot, q0 = panda(), panda().home
        target = np.array([0.6, 0.3, 0.1])
        criteria = [LookAt(target), Visibility(target)]
        for criterion in criteria:
            ik = shared_solver(robot, jtik.FrameTask(), criteria=criterion)
            before = criterion(q0, robot)
            solution = ik.solve(robot.position(q0), q0=q0, until="stationary", max_iterations=2000)
            assert solution.converged
            assert solution.cost < 0.1 * before + 1e-9

    @pytest.mark.parametrize(
        ("make", "argument"),
        [
            (lambda: LookAt((1, 1, 1))([0.1, 0.2], planar(2)), "target"),
            (lambda: LookAt((1, 1), axis=(0, 0))([0.1, 0.2], planar(2)), "axis"),
            (lambda: LookAt((1, 1), floor=0.0), "floor"),
            (lambda: Visibility((1, 1), half_angle=np.pi), "half_angle"),
            (lambda: Visibility((1, 1), half_angle=0.0), "half_angle"),
        ],
    )
    def test_wrong_arguments_are_refused(self, make, argument):
        with pytest.raises(jtik.ArgumentError) as caught:
            make()
        assert caught.value.argument == argument


def test_the_repr_shows_what_was_given():
    assert repr(MinimumDisplacement()) == "MinimumDisplacement()"
    assert repr(FrameProximity("elbow", height=0.4)) == "FrameProximity(frame='elbow', height=0.4)"
    assert repr(CompactPosture(name="folded")) == "CompactPosture(name='folded')"
    assert repr(LookAt((1, 2, 3))) == "LookAt(target=[1.0, 2.0, 3.0])"
    assert "half_angle=0.5" in repr(Visibility((1, 2), half_angle=0.5))
    assert repr(SwivelAngle("a", "b", "c", angle=1.0)) == "SwivelAngle(shoulder='a', elbow='b', wrist='c', angle=1.0)"
