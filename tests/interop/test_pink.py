"""Criteria as pink tasks, pink tasks, limits and barriers on jtik robots; skipped without the extra "pink"."""

from __future__ import annotations

import inspect

import mink
import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import DIFFERENCES, differences

pink = pytest.importorskip("pink")
pinocchio = pytest.importorskip("pinocchio")

from jtik.interop.pink import PinocchioCorrespondence, as_criterion, criterion_task, fresh, limit_rows  # noqa: E402

DAQP = 1e-8
"""Tolerance on the solution of DAQP, without damping."""

JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{xyz}" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/>{limit}</joint>"""
LIMIT = '<limit lower="-2" upper="2.5" velocity="1.5" effort="1"/>'
JOINTS = [
    ("yaw", "continuous", "0 0 0.3", "0 0 1", ""),
    ("shoulder", "revolute", "0.1 0 0", "0 1 0", LIMIT),
    ("reach", "prismatic", "0.3 0 0", "1 0 0", LIMIT),
    ("elbow", "continuous", "0.2 0.1 0", "0 1 0", ""),
    ("wrist", "revolute", "0.2 0 0", "1 0 0", LIMIT),
]


def arm():
    """A URDF of every type of scalar joint, links a to f."""
    links = "".join(f'<link name="{name}"/>' for name in "abcdef")
    joints = "".join(
        JOINT.format(name=name, kind=kind, parent="abcdef"[i], child="abcdef"[i + 1], xyz=xyz, axis=axis, limit=limit)
        for i, (name, kind, xyz, axis, limit) in enumerate(JOINTS)
    )
    return f'<robot name="arm">{links}{joints}</robot>'


def fixed():
    """The arm on the ground."""
    return jtik.Robot.from_urdf(arm()), pinocchio.buildModelFromXML(arm())


def floating():
    """The arm on a free base."""
    return (
        jtik.Robot.from_urdf(arm(), free_base=True),
        pinocchio.buildModelFromXML(arm(), pinocchio.JointModelFreeFlyer()),
    )


BOTH = pytest.mark.parametrize("build", [fixed, floating])


def configuration(model, q):
    return pink.Configuration(model, model.createData(), q)


@jtik.criterion
def low(q, robot, *, wanted=0.1):
    """A function of the height and the reach of the tip, which depends on every joint."""
    p = robot.position(q)
    return (p[2] - wanted) ** 2 + p[0] * p[1]


@BOTH
class TestCorrespondence:
    def test_numbers_are_converted_both_ways(self, build, rng):
        robot, model = build()
        correspondence = PinocchioCorrespondence(robot, model)
        q = robot.random_configuration(rng)
        assert robot.difference(q, correspondence.q(correspondence.theirs(q))) == pytest.approx(
            np.zeros(robot.n), abs=1e-12
        )

    def test_the_same_poses_and_displacements(self, build, rng):
        robot, model = build()
        correspondence, data = PinocchioCorrespondence(robot, model), model.createData()
        q, v = robot.random_configuration(rng), 0.1 * rng.standard_normal(robot.n)
        for at in (correspondence.theirs(q), correspondence.theirs(robot.integrate(q, v))):
            pinocchio.framesForwardKinematics(model, data, at)
            pose = data.oMf[model.getFrameId("f")].homogeneous
            assert robot.pose(correspondence.q(at), "f") == pytest.approx(pose, abs=1e-10)
        # to first order: a free joint's path differs, since Pinocchio rotates its translation with it
        small = 1e-6 * v
        moved = pinocchio.integrate(model, correspondence.theirs(q), correspondence.moves(q) @ small)
        assert robot.difference(robot.integrate(q, small), correspondence.q(moved)) == pytest.approx(
            np.zeros(robot.n), abs=1e-11
        )


@BOTH
class TestCriterionAsTask:
    def test_its_objective_is_the_gradient(self, build, rng):
        robot, model = build()
        task = criterion_task(low, robot, model, gain=0.7)
        correspondence = PinocchioCorrespondence(robot, model)
        q = robot.random_configuration(rng)
        P, c = task.compute_qp_objective(configuration(model, correspondence.theirs(q)))
        gradient = differences(lambda at: task.value(configuration(model, correspondence.theirs(at))), robot, q)[0]
        assert correspondence.moves(q).T @ c == pytest.approx(0.7 * gradient, abs=DIFFERENCES)
        assert pytest.approx(np.eye(model.nv), abs=1e-12) == P

    def test_pink_solves_with_it_below_a_constraint(self, build, rng):
        """Newton with the projected gradient, in Pinocchio's velocities."""
        robot, model = build()
        task = criterion_task(low, robot, model, gain=0.4)
        correspondence = PinocchioCorrespondence(robot, model)
        q = robot.random_configuration(rng)
        at = configuration(model, correspondence.theirs(q))
        tip = pink.tasks.FrameTask("f", position_cost=1.0, orientation_cost=1.0)
        tip.set_target(pinocchio.SE3(robot.pose(robot.random_configuration(rng), "f")))
        J, e = tip.compute_jacobian(at)[:3], tip.compute_error(at)[:3]

        class Position:
            gain = 1.0

            def compute_jacobian(self, configuration):
                return J

            def compute_error(self, configuration):
                return e

        dq = pink.solve_ik(
            configuration=at, tasks=[task], dt=1.0, solver="daqp", damping=0.0, limits=[], constraints=[Position()]
        )
        gradient = task.compute_qp_objective(at)[1]
        inverse = np.linalg.pinv(J)
        assert dq == pytest.approx(-inverse @ e - (gradient - inverse @ (J @ gradient)), abs=DAQP)


def test_live_parameters_and_a_name():
    robot, model = fixed()
    task = criterion_task(JointCentering(), robot, model)
    at = configuration(model, PinocchioCorrespondence(robot, model).theirs(np.zeros(5)))
    assert task.compute_qp_objective(at)[1] == pytest.approx(np.zeros(5))
    task.parameters["joint_centering.preferred"] = np.full(5, 0.5)
    assert task.compute_qp_objective(at)[1] == pytest.approx(np.full(5, -0.5))
    assert "joint_centering" in repr(task)


@BOTH
def test_value_and_gradient_of_a_task_belong_together(build, rng):
    robot, model = build()
    task = pink.tasks.FrameTask("f", position_cost=2.0, orientation_cost=0.5, gain=0.3, lm_damping=1.0)
    q = robot.random_configuration(rng)
    close = robot.integrate(q, 0.1 * rng.standard_normal(robot.n))
    task.set_target(pinocchio.SE3(robot.pose(close, "f")))
    H = as_criterion(task, robot, model)
    assert H.gradient(q) == pytest.approx(differences(H.value, robot, q)[0], abs=DIFFERENCES)
    assert H.value(close) == pytest.approx(0, abs=1e-20)
    assert H.hessian(q) == pytest.approx(H.hessian(q).T)


class TestBarriers:
    def barrier(self):
        return pink.barriers.PositionBarrier("f", indices=[2], p_min=np.array([-1.0]), gain=np.array([2.0]))

    def test_pinks_own_barrier_ignores_a_change_of_the_bound(self):
        _, model = fixed()
        at = configuration(model, pinocchio.neutral(model))
        stale, current = self.barrier(), self.barrier()
        wrapped = fresh(current)
        before = stale.compute_qp_inequalities(at, 0.1)[1]
        assert wrapped.compute_qp_inequalities(at, 0.1)[1] == pytest.approx(before)
        stale.p_min, current.p_min = np.array([-0.6]), np.array([-0.6])
        assert stale.compute_qp_inequalities(at, 0.1)[1] == pytest.approx(before)
        assert wrapped.compute_qp_inequalities(at, 0.1)[1] == pytest.approx(before - 2.0 * 0.4)

    def test_it_is_the_same_otherwise(self, rng):
        robot, model = fixed()
        at = configuration(model, PinocchioCorrespondence(robot, model).theirs(robot.random_configuration(rng)))
        options = {"gain": np.array([2.0]), "safe_displacement_gain": 0.5}
        theirs = pink.barriers.PositionBarrier("f", indices=[2], p_min=np.array([-1.0]), **options)
        for found, expected in zip(
            fresh(theirs).compute_qp_inequalities(at, 0.1), theirs.compute_qp_inequalities(at, 0.1), strict=True
        ):
            assert found == pytest.approx(expected)
        for found, expected in zip(
            fresh(theirs).compute_qp_objective(at), theirs.compute_qp_objective(at), strict=True
        ):
            assert found == pytest.approx(expected)

    def test_pink_solves_with_it(self):
        robot, model = fixed()
        at = configuration(model, pinocchio.neutral(model))
        height = at.get_transform_frame_to_world("f").translation[2]
        down = criterion_task(low(wanted=-9.0), robot, model, gain=1.0)
        barrier = pink.barriers.PositionBarrier("f", indices=[2], p_min=np.array([height - 0.01]), gain=np.array([1.0]))
        v = pink.solve_ik(configuration=at, tasks=[down], dt=0.1, solver="daqp", limits=[], barriers=[fresh(barrier)])
        J = robot.jacobian(PinocchioCorrespondence(robot, model).q(at.q), "f")[2]
        assert J @ v == pytest.approx(-0.01, abs=1e-7)

    def test_as_rows_on_a_displacement(self, rng):
        robot, model = fixed()
        q, dt = robot.random_configuration(rng), 0.05
        G, h = limit_rows(self.barrier(), robot, model, dt=dt)(q)
        assert pytest.approx(-robot.jacobian(q, "f")[2:3], abs=1e-9) == G
        assert h == pytest.approx([2.0 * dt * (robot.position(q, "f")[2] + 1.0)])

    def test_wrong_input(self):
        with pytest.raises(jtik.ArgumentError, match="barrier"):
            fresh("wall")


def test_limits_as_rows():
    robot, model = fixed()
    q = np.array([0.1, 2.45, 0.3, 2.0, -1.0])
    speed = limit_rows(model_limit("velocity", model), robot, model, dt=0.02)(q)
    assert speed[1] == pytest.approx(np.full(len(speed[1]), 0.03))
    _, h = limit_rows(model_limit("position", model), robot, model)(q)
    assert h.min() == pytest.approx(0.5 * 0.05)  # its default gain times the distance of the shoulder to its limit


def model_limit(kind, model):
    made = {"velocity": pink.limits.VelocityLimit, "position": pink.limits.ConfigurationLimit}
    return made[kind](model)


def test_the_order_of_arguments_differs_between_the_two():
    """Pass arguments by keyword: the sixth argument is a list of limits in one library and a switch in the other."""
    theirs, others = (list(inspect.signature(library.solve_ik).parameters) for library in (pink, mink))
    assert theirs[:5] == others[:5]
    assert (theirs[5], others[5]) == ("limits", "safety_break")
    defaults = [inspect.signature(library.solve_ik).parameters["safety_break"].default for library in (pink, mink)]
    assert defaults == [True, False]


class TestWrongInput:
    def test_another_robot(self):
        _, model = fixed()
        with pytest.raises(jtik.ArgumentError, match="a revolute joint 'joint1'"):
            PinocchioCorrespondence(jtik.Robot.planar(2), model)

    def test_something_else(self):
        robot, model = fixed()
        with pytest.raises(jtik.ArgumentError, match="pink task"):
            as_criterion(3, robot, model)
        with pytest.raises(jtik.ArgumentError, match="limit or barrier"):
            limit_rows(3, robot, model)
        with pytest.raises(jtik.ArgumentError, match="dt"):
            limit_rows(model_limit("velocity", model), robot, model, dt=-1.0)
        with pytest.raises(jtik.ArgumentError, match="gain"):
            criterion_task(low, robot, model, gain=0.0)
