"""The options of every task: Kp, priority, name."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

from ..conftest import EXACT, report_at, shared_solver
from .conftest import dh_arm, planar, solver


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
            assert report_at(ik, q, target).error == pytest.approx(e, abs=EXACT)

    @pytest.mark.parametrize(("stiffness", "Kp"), CASES)
    def test_the_transpose_step_goes_along_the_weighted_gradient(self, stiffness, Kp, rng):
        robot = dh_arm(6, 5)
        strategy = jtik.strategies["transpose"](q_limit=np.inf, backtracking=False)
        ik = shared_solver(
            robot, jtik.FrameTask("tip", "position", stiffness=stiffness), strategy=strategy, limits=False
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
    def test_a_stiffness_that_is_not_positive_definite_or_of_another_size_is_refused(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="(?s)stiffness.*positive definite") as caught:
            solver(dh_arm(), jtik.FrameTask("tip", stiffness=stiffness))
        assert caught.value.argument == "stiffness"

    @pytest.mark.parametrize("stiffness", [np.nan, np.inf, [1.0, np.nan, 1.0], np.ones((1, 1, 1)), "soft", [[1.0], []]])
    def test_a_stiffness_that_is_not_finite_is_refused_when_the_task_is_created(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="stiffness"):
            jtik.FrameTask("tip", stiffness=stiffness)


class TestOldNamesOfMethods:
    """A subclass with an old name of a method works, with a warning that names the new one."""

    def test_of_a_placement_task(self):
        with pytest.warns(DeprecationWarning, match="^Tip.placed is now Tip.placement$"):

            class Tip(jtik.task.PlacementTask):
                def placed(self, kinematics):
                    return kinematics.rotation("tip"), kinematics.position("tip")

        robot = planar(3)
        task = Tip("tip", "position", axes=None, stiffness=1.0, priority=0, name=None)
        q = [0.1, 0.2, 0.3]
        error = report_at(shared_solver(robot, task), q, [1.0, 0.5]).error
        assert error == pytest.approx(robot.position(q) - [1.0, 0.5])

    def test_of_a_pointing_task(self):
        with pytest.warns(DeprecationWarning, match=r"^Up\.(wanted|swing) is now Up\.direction") as caught:

            class Up(jtik.task.PointingTask):
                def wanted(self, kinematics, target):
                    return target

                def swing(self, kinematics):
                    return super().direction_jacobian(kinematics)

                def read_target(self, robot, target):
                    return np.asarray(target, dtype=float)

        messages = ["Up.wanted is now Up.direction", "Up.swing is now Up.direction_jacobian"]
        assert [str(each.message) for each in caught] == messages
        robot = dh_arm()
        q = robot.random_configuration(3)
        error = report_at(shared_solver(robot, Up("tip")), q, [0.0, 0.0, 1.0]).error
        expected = report_at(shared_solver(robot, jtik.AxisTask("tip")), q, [0.0, 0.0, 1.0]).error
        assert error == pytest.approx(expected)
