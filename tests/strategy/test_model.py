"""The local model: linear algebra against NumPy, limits against clipping, candidates, all joints and free joints."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.qp import QPRecorder, QuadraticProgram
from jtik.robot import WeightedCoordinates
from jtik.strategy import limited_box

from ..conftest import EXACT
from .conftest import numbers, quadratic_model

LIMITS = np.array([-0.2, -0.5, -1.0, -0.1]), np.array([0.3, 0.5, 1.0, 0.1])


@pytest.fixture
def data(rng):
    """J (2, 4), r (2,), gradient (4,)."""
    return rng.normal(size=(2, 4)), rng.normal(size=2), rng.normal(size=4)


class TestLinearAlgebra:
    @pytest.mark.parametrize("active", [(), (1,)], ids=["all free", "one active"])
    def test_quantities_of_free_joints_agree_with_numpy(self, data, active):
        J, r, g = data
        model = quadratic_model(J, r, gradient=g, limits=LIMITS, active=active)
        free = np.delete(np.arange(4), active)
        F, h = np.zeros_like(J), np.zeros(4)
        F[:, free] = J[:, free]
        h[free] = g[free]
        null = h - np.linalg.pinv(F) @ F @ h
        assert numbers(model.null_gradient_free) == pytest.approx(null, abs=EXACT)
        assert numbers(model.null_gradient_norm) == pytest.approx(np.linalg.norm(null))
        assert numbers(model.gradient_norm) == pytest.approx(np.linalg.norm(h))
        assert numbers(model.jacobian_norm) == pytest.approx(np.linalg.norm(F))
        assert numbers(model.multipliers) == pytest.approx(np.linalg.pinv(F).T @ h)
        assert numbers(model.task_gradient) == pytest.approx(F.T @ r)
        assert numbers(model.task_gradient_rows.vector) == pytest.approx(F.T @ r)
        assert numbers(model.task_gradient_norm) == pytest.approx(np.linalg.norm(F.T @ r))

    def test_quantities_of_all_joints_do_not_depend_on_the_active_set(self, data):
        J, r, g = data
        model = quadratic_model(J, r, gradient=g, limits=LIMITS, active=(0, 2))
        step = model.row_space.least_squares(model.here.residual)
        assert numbers(step.vector) == pytest.approx(np.linalg.pinv(J) @ r)
        assert numbers(model.null_gradient) == pytest.approx(g - np.linalg.pinv(J) @ J @ g, abs=EXACT)

    def test_without_limits_both_pairs_are_the_same_expressions(self, data):
        J, r, g = data
        model = quadratic_model(J, r, gradient=g)
        assert model.row_space is model.row_space_free
        assert model.null_gradient is model.null_gradient_free

    def test_without_a_criterion_the_norm_of_the_task_gradient_needs_no_factorisation(self, data):
        J, r, _ = data
        model = quadratic_model(J, r)
        assert numbers(model.task_gradient_norm) == pytest.approx(np.linalg.norm(J.T @ r))
        assert "row_space_free" not in vars(model)

    def test_the_change_of_the_criterion_along_a_step_in_the_row_space(self, data):
        J, r, g = data
        model = quadratic_model(J, r, gradient=g)
        step = model.row_space.least_squares(model.here.residual)
        assert numbers(model.criterion_change(step)) == pytest.approx(g @ np.linalg.pinv(J) @ r)


class TestLimits:
    def test_the_box_is_the_distance_to_the_limits(self, data):
        J, r, _ = data
        q = np.array([0.1, -0.5, 2.0, 0.0])  # the third joint is outside
        low, high = map(numbers, quadratic_model(J, r, q=q, limits=LIMITS).box)
        assert low == pytest.approx(np.minimum(LIMITS[0] - q, 0))
        assert high == pytest.approx(np.maximum(LIMITS[1] - q, 0))

    def test_without_limits_the_box_is_infinite(self, data):
        J, r, _ = data
        low, high = map(numbers, quadratic_model(J, r).box)
        assert (low == -np.inf).all()
        assert (high == np.inf).all()

    def test_a_displacement_is_shortened_joint_by_joint(self, data, rng):
        J, r, _ = data
        q = np.array([0.1, -0.5, 0.9, 0.0])
        for dq in rng.normal(size=(10, 4)):
            found = numbers(quadratic_model(J, r, q=q, limits=LIMITS).within_limits(casadi.SX(dq)))
            assert q + found == pytest.approx(np.clip(q + dq, *LIMITS), abs=EXACT)

    def test_a_candidate_is_never_outside_the_limits_by_rounding(self, data, rng):
        J, r, _ = data
        for q in rng.uniform(*LIMITS, size=(50, 4)):
            model = quadratic_model(J, r, q=q, limits=LIMITS)
            for limit in LIMITS:
                found = numbers(model.candidate(casadi.SX(limit - q)).q)
                assert found == pytest.approx(limit, abs=EXACT)
                assert (found >= LIMITS[0]).all()
                assert (found <= LIMITS[1]).all()


class TestCandidate:
    def test_task_and_criterion_are_evaluated_where_the_step_ends(self, data, rng):
        J, r, g = data
        q, dq, M = rng.normal(size=4), rng.normal(size=4), np.diag([1.0, 2.0, 3.0, 4.0])
        found = quadratic_model(J, r, gradient=g, hessian=M, q=q).candidate(casadi.SX(dq))
        assert numbers(found.q) == pytest.approx(q + dq)
        assert numbers(found.residual) == pytest.approx(r + J @ dq)
        assert numbers(found.H) == pytest.approx(g @ dq + dq @ M @ dq / 2)
        assert numbers(found.dq).tolist() == dq.tolist()

    def test_without_a_criterion_H_is_zero(self, data):
        J, r, _ = data
        assert quadratic_model(J, r).candidate(casadi.SX(np.ones(4))).H == 0

    def test_the_predicted_decrease_of_a_linear_task_is_its_decrease(self, data, rng):
        J, r, _ = data
        model, dq = quadratic_model(J, r), rng.normal(size=4)
        actual = numbers(model.here.V) - numbers(model.candidate(casadi.SX(dq)).V)
        assert numbers(model.predicted_decrease(casadi.SX(J @ dq))) == pytest.approx(actual)


class TestRotations:
    crane = jtik.Robot.from_dh([{"a": 0.5, "alpha": 0.3, "joint": kind} for kind in ("revolute", "prismatic")])

    def test_only_rotations_are_measured(self):
        model = quadratic_model(np.ones((1, 2)), np.ones(1), robot=self.crane)
        assert (model.rotational_entries, model.all_rotational) == ([0], False)
        assert numbers(model.rotation_norm(casadi.SX([-0.3, 5.0]))) == pytest.approx(0.3)
        assert numbers(model.rotation_dot(casadi.SX([2.0, 5.0]), casadi.SX([3.0, 7.0]))) == 6.0
        # the squared norm of the whole displacement is of no use here
        assert numbers(model.rotation_norm(casadi.SX([-0.3, 5.0]), 25.09)) == pytest.approx(0.3)


class TestWeights:
    """A displacement is z; angles, limits and configurations are those of the joints."""

    W = np.array([9.0, 1.0, 4.0, 25.0])

    def model(self, data, **options):
        J, r, g = data
        D = self.W**-0.5
        return quadratic_model(J * D, r, gradient=D * g, coordinates=WeightedCoordinates.of(self.W), **options)

    def test_limits(self, data):
        model, scale = self.model(data, limits=LIMITS), np.sqrt(self.W)
        assert [numbers(bound) for bound in model.box] == [
            pytest.approx(scale * LIMITS[0]),
            pytest.approx(scale * LIMITS[1]),
        ]
        ends = numbers(model.within_limits(casadi.SX([9.0, -9.0, 9.0, 0.01])))
        assert ends == pytest.approx([0.9, -0.5, 2.0, 0.01])
        low, high = (numbers(bound) for bound in limited_box(model, 0.25))
        assert (low, high) == (
            pytest.approx(scale * np.maximum(LIMITS[0], -0.25)),
            pytest.approx(scale * np.minimum(LIMITS[1], 0.25)),
        )

    def test_a_candidate_is_where_the_joints_move(self, data):
        at = self.model(data).candidate(casadi.SX([0.3, 0.1, -0.2, 1.0]))
        assert numbers(at.q) == pytest.approx([0.1, 0.1, -0.1, 0.2])
        assert numbers(at.dq) == pytest.approx([0.3, 0.1, -0.2, 1.0])

    def test_rotations_are_angles(self, data):
        model, z = self.model(data), casadi.SX([3.0, 4.0, 0.0, 0.0])
        assert not model.all_rotational
        assert numbers(model.rotation_norm(z, 25.0)) == pytest.approx(np.hypot(1, 4))
        assert numbers(model.rotation_dot(z, z)) == pytest.approx(17.0)

    def test_the_stationarity_residual_is_of_the_joints_themselves(self, data):
        """At least the norm of the gradient without its part in the row space; zero with it."""
        J, _, g = data
        null = g - np.linalg.pinv(J) @ J @ g
        assert numbers(self.model(data).stationarity_residual) >= np.linalg.norm(null)
        balanced = (J, data[1], J.T @ np.array([2.0, -3.0]))
        assert numbers(self.model(balanced).stationarity_residual) == pytest.approx(0, abs=1e-12)

    def test_without_weights_it_is_that_of_the_null_space(self, data):
        model = quadratic_model(data[0], data[1], gradient=data[2])
        assert model.stationarity_residual is model.null_gradient_norm


class TestQuadraticPrograms:
    program = QuadraticProgram(casadi.SX.eye(2), casadi.SX([1.0, 1.0]), -casadi.SX([9, 9]), casadi.SX([9, 9]))

    def test_they_are_recorded(self):
        qps = QPRecorder(1e-6)
        model = quadratic_model(np.ones((1, 2)), np.ones(1), qps=qps)
        solution = model.solve(self.program)
        (answer,) = model.compute("norm", lambda _: None, [model.J], [(3, 1)])
        assert [recorded.name for recorded in qps.calls] == ["qp", "norm"]
        assert (solution.x.shape, answer.shape) == ((2, 1), (3, 1))

    def test_a_strategy_whose_uses_qp_is_false_gets_an_error(self):
        model = quadratic_model(np.ones((1, 2)), np.ones(1))
        with pytest.raises(jtik.JtikError, match="'qp' of a strategy whose uses_qp"):
            model.solve(self.program)
        with pytest.raises(jtik.JtikError, match="'norm' of a strategy whose uses_qp"):
            model.compute("norm", lambda _: None, [model.J], [(3, 1)])
        with pytest.raises(jtik.JtikError, match="without clearances"):
            _ = model.restoration
