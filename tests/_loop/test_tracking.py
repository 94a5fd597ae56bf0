"""track: a path of targets within the limits of a step.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import EXACT, planar, planar_points, slow
from .conftest import EVERY_STRATEGY, solver

pytestmark = pytest.mark.thinned(together=True, times=2)


class TestTrack:
    def circle(self, count=40):
        angle = np.linspace(0, 2 * np.pi, count)
        return np.stack([2.0 + 0.5 * np.cos(angle), 1.5 + 0.5 * np.sin(angle)], axis=1)

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_a_circle_is_followed(self, strategy):
        ik = solver(planar(4), strategy=strategy)
        q0 = ik.solve(self.circle()[0], q0=[0.5, 0.4, 0.3, 0.2], max_iterations=5000).q
        path = ik.track(self.circle(), q0=q0, dt=0.1, max_iterations=2000)
        assert path.converged
        assert len(path) == 40
        assert path.times == pytest.approx(0.1 * np.arange(1, 41))
        for q, target in zip(path.q, self.circle(), strict=True):
            assert planar_points(q)[-1] == pytest.approx(target, abs=2e-6)
        assert path.error_norm.max() <= 1e-6
        assert np.abs(np.diff(path.q, axis=0)).max() < 0.5  # no jumps

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_velocity_limits_hold_from_target_to_target(self, strategy, rng):
        self.check_velocities(strategy, JointCentering(), rng)

    @pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "sns_qp")])
    def test_velocity_limits_hold_without_a_criterion(self, strategy, rng):
        self.check_velocities(strategy, None, rng)

    def check_velocities(self, strategy, criteria, rng):
        speed, dt = np.array([0.5, 1.0, 0.3, 2.0]), 0.05
        robot = jtik.Robot.planar(4, velocity_limit=speed)
        ik = solver(robot, strategy=strategy, criteria=criteria)
        q0 = np.array([0.5, 0.4, 0.3, 0.2])
        targets = planar_points(q0)[-1] + np.cumsum(rng.uniform(-0.2, 0.2, (25, 2)), axis=0)
        path = ik.track(targets, q0=q0, dt=dt, until="stationary")
        steps = np.abs(np.diff(np.vstack([q0, path.q]), axis=0))
        assert (steps <= speed * dt + EXACT).all()
        assert (steps > 0.9 * speed * dt).any()  # the limits did bind

    def test_a_target_too_fast_is_followed_as_far_as_the_limits_allow(self):
        robot = jtik.Robot.planar(3, velocity_limit=1.0)
        q0 = np.array([0.5, 0.4, 0.3])
        goal = robot.position(q0 + 0.5)
        path = solver(robot).track([goal] * 30, q0=q0, dt=0.05)
        assert path.status[0] is jtik.Status.LIMITS
        assert not path.converged
        assert path.status[-1] is jtik.Status.CONVERGED
        assert (np.diff(path.error_norm) <= 1e-9).all()

    def test_position_limits_hold_as_well_and_come_back_unchanged(self, rng):
        robot = jtik.Robot.planar(4, lower=-0.6, upper=0.6, velocity_limit=2.0)
        ik = solver(robot)
        before = ik.solve([3.0, 1.0], q0=[0.1] * 4).q.tolist()
        path = ik.track(rng.uniform(0, 3, (20, 2)), q0=[0.1] * 4, dt=0.1)
        assert (np.abs(path.q) <= 0.6).all()
        assert ik.solve([3.0, 1.0], q0=[0.1] * 4).q.tolist() == before

    def test_a_start_outside_its_limits_returns_within_its_velocity_limit(self):
        robot = jtik.Robot.planar(3, lower=-0.5, upper=0.5, velocity_limit=1.0)
        q0 = np.array([1.0, 0.2, 0.1])
        path = solver(robot).track([[2.5, 1.0]] * 20, q0=q0, dt=0.1)
        steps = np.abs(np.diff(np.vstack([q0, path.q]), axis=0))
        assert (steps <= 0.1 + EXACT).all()
        assert path.q[0, 0] == pytest.approx(0.9, abs=EXACT)
        assert (np.abs(path.q[5:]) <= 0.5 + EXACT).all()

    def test_a_floating_base_keeps_its_speed_too(self):
        """Velocity limits of free and ball joints are limits like any other."""
        robot = jtik.Robot(
            [
                jtik.Joint("ball", jtik.JointType.BALL, "base", "arm", velocity_limit=0.5),
                jtik.Joint("tip", jtik.JointType.FIXED, "arm", "tip", origin=_shift(1.0)),
            ]
        )
        path = solver(robot).track([[0.0, 1.0, 0.0]] * 3, dt=0.1)
        turned = robot.difference(robot.neutral, path.q[0])
        assert (np.abs(turned) <= 0.05 + EXACT).all()

    def test_refusals(self):
        ik = solver(planar(2))
        with pytest.raises(jtik.ArgumentError, match="targets.*at least one"):
            ik.track([])
        for dt in (0.0, -0.1, np.nan):
            with pytest.raises(jtik.ArgumentError, match="dt"):
                ik.track([[1.0, 1.0]], dt=dt)

    def test_a_wrong_target_within_a_path_does_not_change_the_limits(self):
        robot = jtik.Robot.planar(3, velocity_limit=0.1)
        ik = solver(robot)
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.track([[1.0, 1.0], [np.nan, 1.0]], q0=[0.3] * 3, dt=0.01)
        assert ik.solve([1.0, 1.0], q0=[0.3] * 3).converged

    def test_repr_sums_it_up(self):
        path = solver(planar(3)).track([[1.0, 1.0], [9.0, 0.0]], q0=[0.3] * 3)
        assert "1 of 2 targets reached" in repr(path)


def _shift(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def test_progress_is_shown_when_asked_for():
    ik, path, seen = solver(planar(3)), [(2.0, 1.0 + 0.01 * i) for i in range(5)], []
    shown = ik.track(path, q0=[0.3, 0.4, 0.5], progress=lambda *now: seen.append(now))
    assert seen == [(i, 5) for i in range(1, 6)]
    assert np.array_equal(shown.q, ik.track(path, q0=[0.3, 0.4, 0.5]).q)


class TestInterruption:
    """Ctrl-C ends a path, and what is done is returned."""

    def track(self, done, **options):
        def report(count, total):
            if count == done:
                raise KeyboardInterrupt

        return solver(planar(4)).track(TestTrack().circle(), q0=[0.5, 0.4, 0.3, 0.2], progress=report, **options)

    def test_what_is_done_is_returned(self, tmp_path):
        path = self.track(7)
        whole = solver(planar(4)).track(TestTrack().circle(), q0=[0.5, 0.4, 0.3, 0.2])
        assert len(path) == 7
        assert path.q.tolist() == whole.q[:7].tolist()
        assert path.dq.tolist() == whole.dq[:7].tolist()
        assert path.reached.all()
        assert not path.complete
        assert not path.converged
        assert whole.complete
        assert "ended by Ctrl-C" in repr(path)
        for suffix in (".json", ".npz"):
            path.save(tmp_path / f"path{suffix}")
            assert not jtik.Trajectory.load(tmp_path / f"path{suffix}").complete

    def test_before_the_first_target_it_is_raised(self):
        ik = solver(planar(4))
        with pytest.raises(KeyboardInterrupt):
            ik.track(Interrupted(TestTrack().circle()), q0=[0.5, 0.4, 0.3, 0.2])
        assert ik.solve([3.0, 1.0], q0=[0.1] * 4).converged  # the solver can be used


class Interrupted(list):
    def __iter__(self):
        raise KeyboardInterrupt
