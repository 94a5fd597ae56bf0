"""solve: converges, is deterministic, and does not change its arguments, on any robot.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import EXACT, ball_arm, families_first, floating_arm, planar, planar_points, shared_solver, slow
from .conftest import EVERY_STRATEGY, FIELD, STRATEGIES, solver

pytestmark = pytest.mark.thinned(together=True)


class TestSolve:
    def test_the_example_of_the_readme(self):
        ik = shared_solver(
            jtik.Robot.planar(10),
            jtik.FrameTask("tip", kind="position"),
            criteria=1.0 * JointCentering() + 0.3 * ObstacleAvoidance(FIELD),
            strategy="hybrid",
        )
        solution = ik.solve([6.0, 3.0], q0=[0.1] * 10)
        assert solution.status is jtik.Status.CONVERGED
        assert planar_points(solution.q)[-1] == pytest.approx([6, 3], abs=1e-6)

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    @pytest.mark.parametrize("n", [1, 3, *slow(2, 15)])
    def test_any_number_of_joints(self, strategy, n):
        robot = planar(n)
        q0 = np.linspace(0.5, 0.1, n)
        target = robot.position(q0 + 0.1)
        for criteria in (None, JointCentering()):
            solution = solver(robot, strategy=strategy, criteria=criteria).solve(
                target, q0=q0, max_iterations=5000, position_tolerance=1e-3
            )
            assert robot.position(solution.q) == pytest.approx(target, abs=1e-3)
            assert solution.jacobian.shape == (2, n)
            assert solution.gradient.shape == (n,)

    @pytest.mark.parametrize("strategy", ["weighted_qp", "hybrid+qp"])
    def test_solves_before_it_change_no_bit(self, strategy, rng):
        """Quadratic programs among them: whether one was needed last does not matter to the next solve."""
        robot = planar(5, lower=-2, upper=2)
        first, last = (solver(robot, strategy=strategy, criteria=JointCentering()) for _ in range(2))
        problems = [(rng.uniform(-2, 2, 5), robot.position(rng.uniform(-2, 2, 5))) for _ in range(60)]
        forwards = [first.solve(target, q0=q0, max_iterations=200) for q0, target in problems]
        backwards = [last.solve(target, q0=q0, max_iterations=200) for q0, target in reversed(problems)]
        for one, other in zip(forwards, reversed(backwards), strict=True):
            assert one.q.tolist() == other.q.tolist()
            assert one.iterations == other.iterations

    def test_tolerances_are_kept_and_matter(self):
        ik, q0 = solver(planar(5)), [0.3] * 5
        for tolerance in (1e-1, 1e-4, 1e-10):
            solution = ik.solve([2.0, 3.0], q0=q0, position_tolerance=tolerance)
            assert solution.converged
            assert solution.position_error <= tolerance
            assert solution.position_error == pytest.approx(
                np.linalg.norm(planar_points(solution.q)[-1] - (2, 3)), abs=EXACT
            )
        assert ik.solve([2.0, 3.0], q0=q0, position_tolerance=1e-1).position_error > 1e-10

    def test_position_and_orientation_have_tolerances_of_their_own(self):
        ik, target = solver(planar(5), kind="pose"), (2.0, 3.0, 1.0)
        loose = ik.solve(target, q0=[0.3] * 5, position_tolerance=1e-9, orientation_tolerance=10.0)
        assert loose.position_error <= 1e-9
        other = ik.solve(target, q0=[0.3] * 5, position_tolerance=10.0, orientation_tolerance=1e-9)
        assert other.orientation_error <= 1e-9
        assert other.iterations <= loose.iterations

    def test_optimality_tolerance_bounds_the_projected_gradient(self):
        ik = solver(planar(6), criteria=JointCentering())
        q0 = [0.8, -0.5, 0.3, 0.9, -0.2, 0.4]
        for tolerance in (1e-1, 1e-3, 1e-8):
            solution = ik.solve([3.0, 2.0], q0=q0, optimality_tolerance=tolerance)
            J, g = solution.jacobian, solution.gradient
            h = g - np.linalg.pinv(J) @ J @ g
            assert solution.status is jtik.Status.CONVERGED
            assert np.linalg.norm(h) <= tolerance * max(1, np.linalg.norm(g))
            assert solution.null_space_residual == pytest.approx(np.linalg.norm(h), abs=1e-10)

    def test_from_home_by_default(self):
        robot = jtik.Robot.planar(3, lower=[0.2, -1, -1], upper=[2, 1, 1])
        ik = solver(robot)
        targets = [[2.0, 1.5], [1.5, 2.0]]
        from_home = [ik.solve(target, q0=[1.1, 0.0, 0.0]).q.tolist() for target in targets]
        assert [ik.solve(target).q.tolist() for target in targets] == from_home
        assert ik.solve_batch(targets).q.tolist() == from_home
        assert ik.solve(targets[0], max_iterations=0).q.tolist() == robot.home.tolist() == [1.1, 0.0, 0.0]
        path = ik.track([targets[0]]), ik.track([targets[0]], q0=robot.home)
        assert path[0].q.tolist() == path[1].q.tolist()

    def test_arguments_are_not_changed_and_results_are_copies(self):
        q0 = np.array([0.3, 0.4, 0.5])
        ik = solver(planar(3))
        first = ik.solve([1.0, 1.5], q0=q0)
        kept = first.q.copy()
        first_error = first.error.copy()
        ik.solve([0.5, 2.0], q0=first.q)
        assert q0.tolist() == [0.3, 0.4, 0.5]
        assert first.q.tolist() == kept.tolist()
        assert first.error.tolist() == first_error.tolist()

    def test_a_start_on_the_target_takes_no_iteration(self):
        q0 = np.array([0.3, 0.4, 0.5])
        ik = solver(planar(3))
        solution = ik.solve(planar_points(q0)[-1], q0=q0)
        assert solution.status is jtik.Status.CONVERGED
        assert solution.iterations == 0
        assert solution.q.tolist() == q0.tolist()

    @pytest.mark.parametrize("strategy", families_first(STRATEGIES, large=False))
    def test_the_same_question_has_the_same_answer(self, strategy):
        options = {"criteria": JointCentering() + ObstacleAvoidance(FIELD), "strategy": strategy}
        ik, q0 = solver(planar(10), **options), np.full(10, 0.1)
        first = ik.solve([6.0, 3.0], q0=q0, max_iterations=300)
        ik.solve([1.0, 1.0], q0=-q0, max_iterations=50)
        ik.step(q0, [3.0, 3.0])
        again = ik.solve([6.0, 3.0], q0=q0, max_iterations=300)
        traced = ik.solve([6.0, 3.0], q0=q0, max_iterations=300, trace=True)
        elsewhere = solver(planar(10), **options).solve([6.0, 3.0], q0=q0, max_iterations=300)
        for other in (again, traced, elsewhere):
            assert other.q.tolist() == first.q.tolist()
            assert other.iterations == first.iterations
            assert other.status is first.status

    def test_nothing_is_printed(self, capfd):
        ik = solver(planar(5), criteria=JointCentering() + ObstacleAvoidance(FIELD))
        for target in ([3.0, 1.0], [9.0, 0.0]):
            ik.solve(target, trace=True)
            ik.step([0.1] * 5, target)
        ik.track([[3.0, 1.0], [3.0, 1.2]])
        repr(ik)
        assert capfd.readouterr() == ("", "")

    def test_limits_can_be_ignored(self):
        robot = jtik.Robot.planar(3, lower=-0.2, upper=0.2)
        assert solver(robot).solve([0.5, 2.0]).status is not jtik.Status.CONVERGED
        free = solver(robot, limits=False).solve([0.5, 2.0], q0=[0.1, 0.1, 0.1])
        assert free.converged
        assert np.abs(free.q).max() > 0.2


class TestManifolds:
    """Ball and free joints: nq is not n, and quaternions stay unit quaternions."""

    @pytest.mark.parametrize("name", ["ball", *slow("floating")])
    @pytest.mark.parametrize("strategy", families_first(STRATEGIES, large=False))
    def test_pose_tasks_with_criteria(self, name, strategy, rng):
        robot = {"ball": ball_arm, "floating": floating_arm}[name]()
        criteria = JointCentering() + 0.1 * ObstacleAvoidance(jtik.Sphere((0.6, 0.6, 0.2), 0.1))
        ik = solver(robot, kind="pose", strategy=strategy, criteria=criteria)
        q0 = np.clip(robot.random_configuration(rng), robot.lower, robot.upper)
        moved = robot.integrate(q0, rng.uniform(-0.1, 0.1, robot.n))
        target = robot.pose(np.clip(moved, robot.lower, robot.upper))
        solution = ik.solve(
            target,
            q0=q0,
            trace=True,
            restarts=3,  # a limit may hold the first attempt
            max_iterations=3000,
            position_tolerance=1e-4,
            orientation_tolerance=1e-4,
            optimality_tolerance=1e-4,
        )
        assert robot.pose(solution.q) == pytest.approx(target, abs=3e-4)
        starts = [3] if name == "floating" else [0, 6]
        for start in starts:
            lengths = np.linalg.norm(solution.trace.q[:, start : start + 4], axis=1)
            assert lengths == pytest.approx(1.0, abs=EXACT)
        assert solution.gradient.shape == (robot.n,)
        assert solution.jacobian.shape == (6, robot.n)

    @pytest.mark.parametrize("name", ["ball", "floating"])
    def test_hybrid_converges_to_a_constrained_optimum(self, name, rng):
        robot = {"ball": ball_arm, "floating": floating_arm}[name]()
        ik = solver(robot, kind="pose", criteria=JointCentering())
        for _ in range(5):
            q0 = robot.random_configuration(rng)
            target = robot.pose(robot.integrate(q0, rng.uniform(-0.2, 0.2, robot.n)))
            solution = ik.solve(target, q0=q0)
            assert solution.position_error <= 1e-6
            assert solution.orientation_error <= 1e-6
            assert solution.status is jtik.Status.CONVERGED

    def test_a_quaternion_that_is_not_of_unit_length_is_read_as_a_direction(self):
        robot = ball_arm()
        q0 = robot.integrate(robot.neutral, np.full(robot.n, 0.1))
        long = q0.copy()
        long[:4] *= 3.0
        ik = solver(robot)
        target = robot.position(robot.integrate(q0, np.linspace(-0.3, 0.3, robot.n)))
        solution = ik.solve(target, q0=long)
        assert solution.converged
        assert np.linalg.norm(solution.q[:4]) == pytest.approx(1.0, abs=EXACT)
        assert robot.position(solution.q) == pytest.approx(target, abs=2e-6)


class TestItsOwn:
    """A Solution has what its report needs, whatever happens to the arrays of the caller."""

    @pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])
    @pytest.mark.parametrize("target", [[1.0, 1.5], [9.0, 0.0]], ids=["reached", "missed"])
    def test_its_q_may_be_changed(self, compiled, target):
        ik = solver(planar(3), compiled=compiled)
        for _ in range(2):  # the second with known options
            solution, expected = (ik.solve(target, q0=[0.3, 0.4, 0.5]) for _ in range(2))
            solution.q[:] = 0.7
            assert solution.position_error == expected.position_error
            assert solution.jacobian.tolist() == expected.jacobian.tolist()
            assert solution.status is expected.status

    def test_reports_read_in_another_thread(self):
        """Each equals the report that its own thread computes while no other one is solving."""
        ik, rng = solver(planar(3, lower=-1.0, upper=1.0), criteria=JointCentering()), np.random.default_rng(0)
        cases = [(rng.uniform(-3, 3, 2), rng.uniform(-1, 1, 3)) for _ in range(150)]

        def figures(solution):
            return solution.status, solution.error.tolist(), solution.null_space_residual, solution.second_order

        expected = [figures(ik.solve(target, q0=q0, max_iterations=30)) for target, q0 in cases]
        before = sys.getswitchinterval()
        sys.setswitchinterval(1e-6)
        try:
            with ThreadPoolExecutor(2) as readers:
                read = [readers.submit(figures, ik.solve(target, q0=q0, max_iterations=30)) for target, q0 in cases]
                assert [each.result() for each in read] == expected
        finally:
            sys.setswitchinterval(before)
