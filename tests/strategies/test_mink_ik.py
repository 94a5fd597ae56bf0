"""The strategy "mink": mink's own step, strict or soft, and the poses at which mink has no step."""

from __future__ import annotations

import sys

import mink
import mujoco
import numpy as np
import pytest

import jtik
from jtik.interop.mink import MujocoCorrespondence, to_mujoco
from jtik_formulations import JointCentering, Mink, Newton, ProjectedGradient

from ..conftest import ball_arm, dh_arm, floating_arm, planar, shared_solver
from ..interop.test_mujoco_model import gripper

DAQP = 1e-6
"""mink's damping of 1e-12 over the smallest squared singular value, and DAQP's own tolerance."""

WHOLE = {"step_limit": np.inf}


def solver(robot, kind="position", *, strategy=None, criteria=None, **options):
    return shared_solver(
        robot, jtik.FrameTask(robot.tip, kind), criteria=criteria, strategy=strategy or Mink(), **options
    )


class TestOneStep:
    def test_strict_without_a_criterion_is_newtons(self, rng):
        robot = planar(5)
        newton = Newton(backtracking=False, q_limit=np.inf)
        for _ in range(5):
            q, target = rng.uniform(0.2, 0.8, 5), rng.uniform(1, 2, 2)
            steps = [
                solver(robot, strategy=strategy, limits=False).step(q, target).q for strategy in (Mink(**WHOLE), newton)
            ]
            assert steps[0] == pytest.approx(steps[1], abs=DAQP)

    def test_strict_with_a_criterion_is_newton_with_the_projection(self, rng):
        robot = planar(5)
        strategy = Mink(**WHOLE, descent=ProjectedGradient(beta_max=0.05))
        for _ in range(5):
            q, target = rng.uniform(0.2, 0.8, 5), rng.uniform(1, 2, 2)
            J = robot.jacobian(q)[:2]
            inverse = np.linalg.pinv(J)
            expected = inverse @ (target - robot.position(q)) - 0.05 * (q - inverse @ (J @ q))
            step = solver(robot, strategy=strategy, criteria=JointCentering(), limits=False).step(q, target).q - q
            assert step == pytest.approx(expected, abs=DAQP)

    @pytest.mark.parametrize("strict", [True, False])
    def test_a_pose_is_minks_own_frame_task(self, strict, rng):
        """The very numbers of mink.solve_ik on the same model."""
        robot = dh_arm(7, limit=1.4)
        model = to_mujoco(robot)
        model.jnt_limited[:] = 0
        q = rng.uniform(-0.5, 0.5, 7)
        target = robot.pose(q + rng.uniform(-0.05, 0.05, 7))
        tip = mink.FrameTask("tip", "body", position_cost=1.0, orientation_cost=1.0, lm_damping=0.1)
        tip.set_target(mink.SE3.from_matrix(target))
        configuration = mink.Configuration(model, q)
        hard = {"tasks": [], "constraints": [tip], "damping": 1.0} if strict else {"tasks": [tip]}
        expected = mink.solve_ik(configuration=configuration, dt=1.0, solver="daqp", limits=[], **hard)
        step = solver(robot, "pose", strategy=Mink(strict=strict, **WHOLE)).step(q, target)
        assert step.q - q == pytest.approx(expected, abs=1e-9)

    def test_the_box_is_the_limits_of_the_solver_and_the_step_limit(self):
        robot = planar(3, lower=-0.1, upper=0.25)
        q = np.array([0.2, 0.0, -0.05])
        after = solver(robot, strategy=Mink(step_limit=0.15)).step(q, [0.0, 3.0]).q
        assert after == pytest.approx([0.25, 0.15, 0.10], abs=1e-9)


class TestSolves:
    @pytest.mark.thinned
    @pytest.mark.parametrize("strict", [True, False])
    @pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["alone", "centred"])
    @pytest.mark.parametrize(
        "build", [lambda: planar(5, lower=-1, upper=1), lambda: dh_arm(7, limit=2.0), ball_arm, floating_arm]
    )
    def test_reaches_and_settles(self, strict, criteria, build, rng):
        robot = build()
        q0 = robot.integrate(robot.neutral, rng.uniform(0.0, 0.1, robot.n))
        target = robot.position(robot.integrate(q0, rng.uniform(0.0, 0.2, robot.n)))
        solution = solver(robot, strategy=Mink(strict=strict), criteria=criteria).solve(target, q0=q0)
        assert solution.converged, solution
        assert solution.null_space_residual <= 1e-5

    def test_the_same_optimum_as_jtiks_own(self):
        robot = planar(5, lower=-0.9, upper=0.9)
        costs = [
            solver(robot, strategy=strategy, criteria=JointCentering()).solve([2.5, 2.5], q0=np.full(5, 0.3)).cost
            for strategy in (Mink(), Mink(strict=False), "newton+qp")
        ]
        assert costs[:2] == pytest.approx([costs[2]] * 2, rel=1e-6)

    def test_through_a_joint_that_follows(self):
        """The follower's part in the motion counts, and it follows."""
        robot = gripper()
        task = jtik.FrameTask("thumb")
        ik = shared_solver(robot, task, strategy="mink")
        solution = ik.solve(robot.position([0.6, 0.0, 0.06], "thumb"), q0=ik.robot.neutral)
        assert solution.converged, solution

    def test_several_tasks_by_priority(self):
        """The first is met, the second as far as the first allows."""
        robot = planar(4)
        tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link3", priority=1)]
        ik = shared_solver(robot, tasks, strategy="mink")
        targets = {"tip": [2.0, 2.0], "link3": [9.0, 0.0]}
        q = ik.solve(targets, q0=np.full(4, 0.3), max_iterations=50).q
        assert robot.position(q) == pytest.approx([2.0, 2.0], abs=1e-5)  # while the other still creeps
        assert robot.position(q, "link3")[0] > 0.9

    def test_tasks_of_minks_own(self):
        """A posture task of mink, nearly stationary on arrival, and the same posture as a criterion."""
        robot, q0, target = planar(4), np.full(4, 0.3), [2.0, 2.0]
        posture = mink.PostureTask(to_mujoco(robot), cost=1.0)
        posture.set_target(np.array([0.1, 0.9, 0.2, 0.4]))
        theirs = solver(robot, strategy=Mink(tasks=[posture])).step
        q = q0
        for _ in range(120):
            q = theirs(q, target).q
        ik = solver(robot, strategy="newton", criteria=JointCentering())
        ik.parameters["joint_centering.preferred"] = posture.target_q
        assert q == pytest.approx(ik.solve(target, q0=q0).q, abs=1e-3)


class TestWhereMinkHasNoSolution:
    def test_a_straight_arm_pulled_inwards(self):
        """Every strict step fails there; the soft step does not, and the saddle escape leaves the straight line.

        Solvers may call it solved with a row 0 = -2 in it: their word is not enough.
        """
        solution = solver(planar(5)).solve([3.0, 0.0], q0=np.zeros(5), trace=True)
        assert solution.converged
        assert solution.escapes > 0
        assert solution.trace.figures["strict"][0] == 0

    def test_a_target_beyond_the_limits_of_a_step_is_the_soft_form(self):
        ik = solver(planar(3))
        trace = ik.solve([0.5, 1.0], q0=np.array([0.1, 0.1, 0.1]), trace=True).trace
        strict = trace.figures["strict"]
        assert strict[0] == 0
        assert strict[-1] == 1


class TestArguments:
    def test_mink_is_called_by_keyword_only(self, monkeypatch):
        """``limits`` is the seventh argument of mink's and the sixth of pink's; by position it becomes a switch."""
        from jtik_formulations.strategies._parts import mink_step

        given = {}
        original = mink.solve_ik

        def spy(*arguments, **options):
            assert not arguments
            given.update(options)
            return original(**options)

        monkeypatch.setattr(mink_step.mink, "solve_ik", spy)
        solver(planar(3), solver="osqp").step(np.full(3, 0.2), [1.0, 1.0])
        assert given["solver"] == "osqp"
        assert len(given["limits"]) == 1

    def test_a_solver_that_mink_cannot_use(self):
        if "qpoases" not in jtik.qp.available():
            pytest.skip("no such plugin")
        with pytest.raises(jtik.ArgumentError, match="one that mink can use"):
            solver(planar(3), solver="qpoases")

    @pytest.mark.parametrize(
        ("option", "value"),
        [
            ("gain", 0.0),
            ("gain", 1.5),
            ("weight", 0.0),
            ("lm_damping", -1.0),
            ("step_limit", 0.0),
            ("tasks", ["posture"]),
        ],
    )
    def test_options_are_checked(self, option, value):
        with pytest.raises(jtik.ArgumentError, match=option):
            Mink(**{option: value})

    def test_the_papers_rules_are_not_for_it(self):
        with pytest.raises(jtik.ArgumentError, match=r"descent\.rule"):
            Mink(descent=ProjectedGradient(rule="paper"))


@pytest.mark.slow
def test_jtik_without_it_does_not_load_mujoco():
    """It takes longer to load than everything else together."""
    import subprocess

    code = "import sys, jtik; list(jtik.strategies); print('mujoco' in sys.modules)"
    paths = ["/".join(module.__file__.split("/")[:-2]) for module in (jtik, sys.modules["jtik_formulations"])]
    found = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {paths!r}; {code}"], capture_output=True, text=True
    )
    assert found.stdout.strip() == "False", found.stderr


def test_correspondence_of_the_model_it_works_on():
    """What the strategy steps is MuJoCo's model of the reduced robot."""
    robot = gripper()
    part = shared_solver(robot, jtik.FrameTask("tip"), strategy="mink").robot
    assert isinstance(to_mujoco(part), mujoco.MjModel)
    assert MujocoCorrespondence(part, to_mujoco(part)).moves.shape[1] == part.n == 2
