"""Criteria as mink tasks, mink tasks and limits on jtik robots, and where mink's own values differ."""

from __future__ import annotations

import mink
import mujoco
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.interop.criterion_evaluation import convex
from jtik.interop.mink import (
    MujocoCorrespondence,
    as_criterion,
    criterion_task,
    limit_rows,
    to_mujoco,
    velocity_limit,
)
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, differences, floating_arm, planar
from .test_mujoco_model import gripper

DAQP = 1e-8
"""Tolerance on the solution of DAQP, without damping."""


@jtik.criterion
def height(q, robot, *, wanted=0.3):
    return (robot.position(q)[2] - wanted) ** 2


@jtik.criterion
def saddle(q, robot):
    return q[0] ** 2 - 2 * q[1] ** 2


class Position(mink.Task):
    """x and y of a body."""

    def __init__(self, body, target):
        super().__init__(cost=np.ones(2))
        self.body, self.target = body, target

    def compute_error(self, configuration):
        return configuration.data.body(self.body).xpos[:2] - self.target

    def compute_jacobian(self, configuration):
        jacobian = np.zeros((3, configuration.nv))
        body = configuration.data.body(self.body).id
        mujoco.mj_jacBody(configuration.model, configuration.data, jacobian, None, body)
        return jacobian[:2]


class TestCriterionAsTask:
    @pytest.mark.parametrize("robot", [planar(5), gripper(), floating_arm()], ids=["planar", "gripper", "floating"])
    def test_its_objective_is_the_gradient(self, robot, rng):
        criterion = JointCentering() if robot.dimension == 2 else height
        model = to_mujoco(robot)
        task = criterion_task(criterion, robot, model, gain=0.7)
        correspondence = MujocoCorrespondence(robot, model)
        q = robot.random_configuration(rng)
        configuration = mink.Configuration(model, correspondence.qpos(q))
        P, c = task.compute_qp_objective(configuration)
        gradient = differences(lambda at: task.value(mink.Configuration(model, correspondence.qpos(at))), robot, q)[0]
        assert correspondence.leads.T @ c == pytest.approx(0.7 * gradient, abs=DIFFERENCES)
        assert pytest.approx(correspondence.leads @ correspondence.leads.T) == P

    def test_mink_prefers_a_lower_criterion(self, rng):
        """The sign: a soft mink step lowers H."""
        robot = planar(5)
        model = to_mujoco(robot)
        task = criterion_task(ObstacleAvoidance([jtik.Circle((2.0, 1.0), 0.3)]), robot, model, gain=1e-3)
        configuration = mink.Configuration(model, np.linspace(0.1, 0.5, 5))
        before = task.value(configuration)
        configuration.integrate_inplace(
            mink.solve_ik(configuration=configuration, tasks=[task], dt=1.0, solver="daqp", limits=[]), 1.0
        )
        assert task.value(configuration) < before

    def test_below_constraints_it_is_newton_with_the_projection(self, rng):
        robot = planar(6)
        model = to_mujoco(robot)
        task = criterion_task(JointCentering(), robot, model, gain=0.4)
        for _ in range(5):
            q, preferred = rng.uniform(-1, 1, (2, 6))
            task.parameters["joint_centering.preferred"] = preferred
            target = robot.position(q) + rng.uniform(-0.2, 0.2, 2)
            dq = mink.solve_ik(
                configuration=mink.Configuration(model, q),
                tasks=[task],
                dt=1.0,
                solver="daqp",
                damping=0.0,
                limits=[],
                constraints=[Position("tip", target)],
            )
            J = robot.jacobian(q)[:2]
            inverse, gradient = np.linalg.pinv(J), q - preferred
            newton = inverse @ (target - robot.position(q)) - 0.4 * (gradient - inverse @ (J @ gradient))
            assert dq == pytest.approx(newton, abs=DAQP)

    def test_the_convex_part_of_the_hessian(self):
        robot = planar(3)
        model = to_mujoco(robot)
        task = criterion_task(saddle, robot, model, gain=0.5, curvature="convex")
        P, _ = task.compute_qp_objective(mink.Configuration(model, np.array([0.2, 0.1, 0.4])))
        assert pytest.approx(np.diag([1.0, 0, 0]), abs=1e-12) == P

    def test_the_closest_semidefinite_matrix(self, rng):
        M = rng.standard_normal((4, 4))
        M = M + M.T
        close = convex(M)
        assert np.linalg.eigvalsh(close).min() >= -1e-12
        assert np.linalg.norm(close - M) == pytest.approx(np.linalg.norm(np.minimum(np.linalg.eigvalsh(M), 0)))

    def test_minks_own_value_lacks_a_half(self):
        """mink's ``Objective.value``, x'Hx + c'x, is not the objective that mink minimises."""
        x = np.ones(2)
        objective = mink.tasks.Objective(np.eye(2), np.zeros(2))
        minimised = mink.build_ik(
            configuration=mink.Configuration(to_mujoco(planar(2))), tasks=[_Fixed(objective)], dt=1.0, limits=[]
        )
        assert x @ minimised.P @ x / 2 == pytest.approx(1.0)
        assert objective.value(x) == pytest.approx(2.0)

    def test_wrong_input(self):
        robot = planar(3)
        model = to_mujoco(robot)
        with pytest.raises(jtik.ArgumentError, match="gain"):
            criterion_task(JointCentering(), robot, model, gain=-1.0)
        with pytest.raises(jtik.ArgumentError, match="'identity' or 'convex'"):
            criterion_task(JointCentering(), robot, model, curvature="exact")
        with pytest.raises(jtik.ArgumentError, match="joint4"):
            criterion_task(JointCentering(), planar(4), model)


class _Fixed(mink.tasks.BaseTask):
    def __init__(self, objective):
        self.objective = objective

    def compute_qp_objective(self, configuration):
        return self.objective


class TestTaskAsCriterion:
    @pytest.mark.parametrize("robot", [planar(5), gripper(), floating_arm()], ids=["planar", "gripper", "floating"])
    def test_value_and_gradient_belong_together(self, robot, rng):
        model = to_mujoco(robot)
        task = mink.FrameTask(
            frame_name=robot.tip, frame_type="body", position_cost=2.0, orientation_cost=0.5, gain=0.3, lm_damping=1.0
        )
        q = robot.random_configuration(rng)
        close = robot.integrate(q, 0.1 * rng.standard_normal(robot.n))
        task.set_target(mink.SE3.from_matrix(robot.pose(close)))
        H = as_criterion(task, robot, model)
        assert H.gradient(q) == pytest.approx(differences(H.value, robot, q)[0], abs=DIFFERENCES)
        assert H.value(close) == pytest.approx(0, abs=1e-20)
        assert H.hessian(q) == pytest.approx(H.hessian(q).T)

    def test_a_change_of_the_target_has_effect_at_the_same_q(self):
        robot = planar(3)
        task = Position("tip", np.array([1.0, 1.0]))
        H = as_criterion(task, robot, to_mujoco(robot))
        q = np.zeros(3)
        assert H.value(q) == pytest.approx((4 + 1) / 2)
        task.target = np.array([2.0, 1.0])
        assert H.value(q) == pytest.approx((1 + 1) / 2)

    def test_a_task_with_an_objective_only(self):
        robot = planar(2)
        objective = mink.tasks.Objective(np.diag([1.0, 3.0]), np.array([0.5, -1.0]))
        H = as_criterion(_Fixed(objective), robot, to_mujoco(robot))
        assert H.gradient(np.zeros(2)) == pytest.approx([0.5, -1.0])
        assert H.hessian(np.zeros(2)) == pytest.approx(np.diag([1.0, 3.0]))

    def test_something_else(self):
        with pytest.raises(jtik.ArgumentError, match="mink task"):
            as_criterion("posture", planar(2), to_mujoco(planar(2)))


def ball_on_rail():
    """A ball of radius 0.1 m on a rail along x, in front of a wall whose face is at x = 1 m."""
    rail = jtik.Joint("rail", jtik.JointType.PRISMATIC, "base", "ball", axis=np.array([1.0, 0, 0]), velocity_limit=2.0)
    robot = jtik.Robot([rail], shapes={"ball": [jtik.Sphere([0, 0, 0], 0.1)]})
    pose = np.eye(4)
    pose[0, 3] = 1.5
    return robot, to_mujoco(robot, obstacles=[jtik.Box(pose, [0.5, 1, 1])])


def avoidance(model, **options):
    pairs = [(["ball solid0"], ["obstacle0"])]
    return mink.CollisionAvoidanceLimit(
        model,
        pairs,
        gain=0.5,
        minimum_distance_from_collisions=0.02,
        collision_detection_distance=2.0,
        **options,
    )


class TestLimits:
    @pytest.mark.parametrize("dt", [1.0, 0.1, 0.002])
    def test_the_collision_limit_is_a_displacement_whatever_dt(self, dt):
        robot, model = ball_on_rail()
        G, h = limit_rows(avoidance(model, bound_relaxation=0.001), robot, model, dt=dt)([0.3])
        assert pytest.approx(np.array([[1.0]])) == G
        assert h == pytest.approx([0.5 * (0.6 - 0.02) + 0.001], abs=1e-9)

    def test_minks_own_lets_a_short_step_through_the_wall(self):
        """With dt = 0.01 mink's bound is 100 times the remaining distance."""
        robot, model = ball_on_rail()
        configuration = mink.Configuration(model, np.array([0.3]))
        (theirs,) = avoidance(model).compute_qp_inequalities(configuration=configuration, dt=0.01).h
        assert theirs > 10 * 0.6
        assert limit_rows(avoidance(model), robot, model, dt=0.01)([0.3]).h[0] < 0.6

    def test_rows_without_a_bound_are_left_out(self):
        robot, model = ball_on_rail()
        limit = avoidance(model)
        limit.collision_detection_distance = 0.1
        rows = limit_rows(limit, robot, model)
        assert rows([0.3]).G.shape == (0, 1)
        assert rows([0.85]).G.shape == (1, 1)

    def test_obstacles_of_to_mujoco_count_for_a_link_mounted_on_the_world(self):
        """mink drops geoms of the world body: it counts them as parent of the link."""
        _, model = ball_on_rail()
        assert len(avoidance(model).geom_id_pairs) == 1
        spec = mujoco.MjSpec.from_string(
            """<mujoco><worldbody><geom name="obstacle0" size=".5" pos="1.5 0 0"/><body name="ball">
            <joint type="slide"/><geom name="ball solid0" size=".1"/></body></worldbody></mujoco>"""
        )
        assert len(avoidance(spec.compile()).geom_id_pairs) == 0

    def test_velocity_limits_are_displacements_in_dt(self):
        robot, model = ball_on_rail()
        G, h = limit_rows(velocity_limit(robot, model), robot, model, dt=0.02)([0.0])
        assert np.sort(G[:, 0]) == pytest.approx([-1, 1])
        assert h == pytest.approx([0.04, 0.04])

    def test_position_limits_through_followers(self):
        """The rows of a follower are on the displacement of its leader."""
        robot = gripper()
        model = to_mujoco(robot)
        model.joint("right").limited, model.joint("right").range = 1, [-0.02, 0.02]
        limit = mink.ConfigurationLimit(model, gain=1.0)
        G, h = limit_rows(limit, robot, model)(np.array([0.0, 0.0, 0.05]))
        follower = [(row[2], bound) for row, bound in zip(G, h, strict=True) if abs(row[2]) == 0.5]
        assert sorted(follower) == [(-0.5, pytest.approx(0.035)), (0.5, pytest.approx(0.005))]

    def test_an_inactive_limit_has_no_rows(self):
        robot = planar(2)
        model = to_mujoco(robot)
        assert limit_rows(mink.ConfigurationLimit(model), robot, model)(np.zeros(2)).G.shape == (0, 2)

    def test_wrong_input(self):
        robot, model = ball_on_rail()
        with pytest.raises(jtik.ArgumentError, match=r"mink\.Limit"):
            limit_rows(0.5, robot, model)
        with pytest.raises(jtik.ArgumentError, match="dt"):
            limit_rows(avoidance(model), robot, model, dt=0.0)


def test_limit_rows_in_the_quadratic_program_of_a_strategy():
    """The target is behind the wall: every step stays in front of it, and so does the solution."""
    robot, model = ball_on_rail()
    limit = limit_rows(avoidance(model), robot, model, dt=0.01)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("ball", axes="x"), strategy=_Behind(limit))
    solution = ik.solve([1.4, 0, 0], max_iterations=30, trace=True)
    assert not solution.converged
    assert solution.trace.q.max() <= 1 - 0.1 - 0.02 + 1e-9
    assert solution.q[0] == pytest.approx(0.88, abs=1e-6)
    problem = ik.build([0.3], [1.4, 0, 0])
    assert qpsolvers.solve_problem(problem, solver="daqp").x == pytest.approx([0.29], abs=1e-9)


class _Push(mink.Limit):
    """dq >= 0.5."""

    def compute_qp_inequalities(self, configuration, dt):
        return mink.Constraint(G=np.array([[-1.0]]), h=np.array([-0.5]))


def test_contradicting_limits_end_as_a_status_or_are_relaxed():
    """One requires 0.5 m, the wall is closer: hard limits leave no step; an elastic limit is relaxed."""
    robot, model = ball_on_rail()
    wall, push = limit_rows(avoidance(model), robot, model, dt=0.01), limit_rows(_Push(), robot, model)
    task = jtik.FrameTask("ball", axes="x")
    stuck = jtik.InverseKinematics(robot, task, strategy=_Behind(wall, push)).solve([1.4, 0, 0], q0=[0.6])
    assert stuck.status is jtik.Status.UNSOLVED
    assert stuck.q == pytest.approx([0.6])
    strategy = _Behind(wall, push, elastic=jtik.qp.Elastic(100.0, curvature=1e-3))
    ik = jtik.InverseKinematics(robot, task, strategy=strategy)
    solution = ik.solve([1.4, 0, 0], q0=[0.6], max_iterations=5)
    assert solution.status is not jtik.Status.UNSOLVED
    assert solution.q[0] <= 0.88 + 1e-9  # the wall is hard
    [entry] = solution.relaxed
    assert entry.name == "qp: limit 1, row 0"
    step = ik.step(solution.q, [1.4, 0, 0]).q[0] - solution.q[0]
    assert entry.amount == pytest.approx(0.5 - step, abs=1e-6)


class _Behind(jtik.Strategy):
    """min 1/2 |J dq + r|^2 subject to mink limits, of which all but the first may be elastic."""

    def __init__(self, *limits, elastic=None):
        self._limits, self._elastic = limits, elastic

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        J, r = model.J, model.here.residual
        low, high = model.box
        first, *rest = self._limits
        rows = [first.rows(model)]
        rows += [each.rows(model, f"limit {i}", elastic=self._elastic) for i, each in enumerate(rest, start=1)]
        program = jtik.qp.QuadraticProgram(P=J.T @ J, q=J.T @ r, lower=low, upper=high, rows=rows)
        dq = model.solve(program).x
        return jtik.strategy.Update(dq)
