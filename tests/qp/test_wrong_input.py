"""Solvers, options, QPs and weights that cannot be used: a clear error when built, a status inside a solve.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import casadi
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.qp import BackendError, Conic, PersistentOSQP, QPSolversBackend, QuadraticProgram, Rows, available, backend_of
from jtik.strategy import Strategy, Update
from jtik.symbolic import fmax, fmin, has_conic, identity
from jtik_formulations import JointCentering, Mink, Newton, ObstacleAvoidance, QPSecondary, SecondOrder, WeightedQP

from ..conftest import planar, slow

pytestmark = pytest.mark.thinned

START = np.array([0.3, 0.2, 0.1, 0.4])
TARGET = np.array([2.0, 1.5])
SILENT = [name for name in available() if name != "qpoases"]  # it prints its licence


def solver(strategy="newton+qp", criteria=None, **options):
    robot = planar(4, lower=-2.0, upper=2.0)
    criteria = JointCentering() if criteria is None else criteria
    return jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, **options)


class TestASolverThatIsNotInstalled:
    def test_the_error_lists_the_installed_ones_and_how_to_install_it(self, monkeypatch):
        monkeypatch.setattr(qpsolvers, "available_solvers", ["daqp", "quadprog"])
        with pytest.raises(BackendError) as caught:
            solver(solver="ecos")
        assert "'ecos': not installed; there are daqp, osqp" in str(caught.value)
        assert "quadprog; install it with: pip install 'qpsolvers[ecos]'" in str(caught.value)
        assert (caught.value.solver, isinstance(caught.value, jtik.JtikError)) == ("ecos", True)

    @pytest.mark.parametrize("name", ["DAQP", "nothing", ""])
    def test_an_unknown_name_is_not_offered_for_installation(self, name):
        with pytest.raises(
            BackendError, match=f"'{name}': not installed; there are daqp.*no solver that qpsolvers"
        ) as e:
            solver(solver=name)
        assert "pip install" not in str(e.value)

    @pytest.mark.parametrize("given", [3.0, ["daqp"], Conic])
    def test_neither_a_name_nor_a_back_end(self, given):
        with pytest.raises(BackendError, match=r"give a FusedBackend or a CalledBackend of jtik.qp, or one of daqp"):
            solver(solver=given)

    def test_mink_lists_the_solvers_it_can_use(self):
        plugins = [name for name in SILENT if name not in qpsolvers.available_solvers]
        if not plugins:
            pytest.skip("qpsolvers has all of them")
        with pytest.raises(jtik.ArgumentError, match=r"one that mink can use: .*daqp.*; more come with: pip install"):
            solver("mink", solver=plugins[0])


class TestABackEndThatCannotSolveTheQP:
    @pytest.mark.parametrize("plugin", ["clp", "cbc"])
    def test_a_solver_of_linear_programs(self, plugin):
        if not has_conic(plugin):
            pytest.skip("no such plugin")
        with pytest.raises(BackendError, match=f"'{plugin}': cannot do dense quadratic programs.*Not an LP"):
            solver(solver=Conic(plugin))

    @pytest.mark.parametrize(
        "build",
        [
            lambda: solver(solver=Conic("daqp", nonsense=1)),
            lambda: solver(solver=Conic("daqp", daqp={"nonsense": 1})),
            lambda: QPSolversBackend("daqp", nonsense=1),
            lambda: QPSolversBackend("osqp", nonsense=1),
            lambda: PersistentOSQP(nonsense=1),
        ],
    )
    def test_an_unknown_option(self, build):
        with pytest.raises(BackendError, match="nonsense"):
            build()

    @pytest.mark.parametrize("accuracy", [0.0, -1.0, np.nan, np.inf, "high"])
    @pytest.mark.parametrize("backend", [Conic, lambda **options: QPSolversBackend("daqp", **options), PersistentOSQP])
    def test_an_invalid_accuracy(self, backend, accuracy):
        with pytest.raises(jtik.ArgumentError, match="accuracy"):
            backend(accuracy=accuracy)


@dataclass(frozen=True, kw_only=True)
class Faulty(Strategy):
    """A third-party strategy, Gauss-Newton within a box, with one mistake in its QP."""

    mistake: str

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n, J, r = model.robot.n, model.J, model.here.residual
        P, (low, high), rows = J.T @ J + 1e-3 * identity(n), model.box, []
        low, high, nan = fmax(low, -0.2), fmin(high, 0.2), casadi.sqrt(-1 - r[0] ** 2)
        if self.mistake == "not convex":
            P = J.T @ J - 0.5 * identity(n)
        if self.mistake == "nowhere convex":
            P = -(J.T @ J) - identity(n)
        if self.mistake == "crossed box":
            low, high = high, low - 0.1
        if self.mistake == "crossed rows":
            rows = [Rows("mine", J, 0 * r + 1, 0 * r - 1)]
        if self.mistake == "contradictory":
            rows = [Rows("mine", J, 0 * r + 9, 0 * r + 10)]
        if self.mistake == "nan in P":
            P = nan * P
        if self.mistake == "nan in the box":
            low = low + nan
        dq = model.solve(QuadraticProgram(P=P, q=J.T @ r, lower=low, upper=high, rows=rows, name="mine")).x
        candidate = model.candidate(dq)
        return Update(dq, accepted=candidate.V < model.here.V, candidate=candidate)


MISTAKES = [
    "not convex",
    "nowhere convex",
    "crossed box",
    "crossed rows",
    "contradictory",
    "nan in P",
    "nan in the box",
]


@functools.cache
def backend(name):
    special = {"persistent": PersistentOSQP, "qpsolvers daqp": lambda: QPSolversBackend("daqp")}
    return special.get(name, lambda: backend_of(name))()


@pytest.mark.parametrize("name", [*available(), "persistent", "qpsolvers daqp"])
class TestAQPWithoutSolution:
    """Solvers fail differently: some raise, some leave their results as they were, some return wrong numbers."""

    @pytest.mark.quick(3)
    @pytest.mark.parametrize("mistake", ["contradictory", "nan in P", *slow(*MISTAKES[:4], MISTAKES[6])])
    def test_is_a_status_and_q_stays(self, mistake, name):
        ik = solver(Faulty(mistake=mistake), solver=backend(name))
        for start in (START, START + 5.0):
            solution = ik.solve(TARGET, q0=start, restarts=1, max_iterations=20)
            assert solution.status is jtik.Status.UNSOLVED
            assert np.abs(solution.q).max() <= 2.0
        step = ik.step(START, TARGET)
        assert not step.accepted
        assert step.q.tolist() == START.tolist()
        assert step.position_error > 0.1

    def test_without_the_mistake_it_is_solved(self, name):
        assert solver(Faulty(mistake=""), solver=backend(name)).solve(TARGET, q0=START).position_error <= 1e-6


def test_a_criterion_need_not_be_convex():
    """The second-order term makes its QP convex itself."""

    @jtik.criterion
    def hills(q, robot):
        return sum(casadi.cos(2 * q[i]) for i in range(4))

    ik = solver("hybrid+second_order", criteria=hills)
    assert ik.solve(TARGET, q0=START, until="stationary").converged
    assert np.linalg.eigvalsh(ik.build(START, TARGET).P)[0] > 0


class TestWeights:
    @pytest.mark.parametrize("weight", [np.nan, np.inf, [1.0, 2.0], "much"])
    def test_of_criteria(self, weight):
        with pytest.raises(jtik.ArgumentError, match="weight"):
            solver(criteria=weight * JointCentering() if weight != "much" else JointCentering().__rmul__("much"))
        ik = solver()
        before = ik.parameters["joint_centering.weight"]
        with pytest.raises(jtik.ArgumentError, match=r"joint_centering\.weight"):
            ik.parameters["joint_centering.weight"] = weight
        assert ik.parameters["joint_centering.weight"] == before == 1.0

    @pytest.mark.parametrize(
        "stiffness", [-1.0, 0.0, np.nan, [1, -1], [1, 1, 1], [[1, 2], [0, 1]], [[1, 2], [2, 1]], "x"]
    )
    def test_of_task_rows(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="stiffness"):
            jtik.InverseKinematics(planar(4), jtik.FrameTask(stiffness=stiffness))

    @pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, np.inf, [1.0, 0.0], [1.0, 1.0], np.eye(4), "heavy", None])
    def test_of_the_secondary_qp(self, weight):
        with pytest.raises(jtik.ArgumentError, match="(?s)weight: given .*; accepted: a positive number, or"):
            solver(Newton(secondary=QPSecondary(weight=weight)))

    @pytest.mark.parametrize("strategy", [WeightedQP, Mink])
    @pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, np.inf, [1.0, 2.0], "heavy"])
    def test_of_weighted_qps(self, strategy, weight):
        with pytest.raises(jtik.ArgumentError, match="weight"):
            strategy(weight=weight)

    @pytest.mark.parametrize("stiffness", [-1.0, [1, 1, 1, -1], [1, 1, 1], np.nan, np.eye(4), "stiff"])
    def test_of_joints(self, stiffness):
        with pytest.raises(jtik.ArgumentError, match="stiffness"):
            solver(criteria=JointCentering(stiffness))

    @pytest.mark.parametrize("gain", [-1.0, np.nan, np.inf, [1.0, 2.0], "much"])
    def test_of_obstacles(self, gain):
        with pytest.raises(jtik.ArgumentError, match="gain"):
            ObstacleAvoidance(jtik.Circle((1, 1), 0.2), gain=gain)

    def test_a_hessian_is_not_an_option(self):
        with pytest.raises(jtik.ArgumentError, match="(?s)curvature: given .*accepted: 'exact' or 'gauss_newton'"):
            SecondOrder(curvature=np.eye(4))
