"""Partition of an expression graph into stages: the same values, each computed once."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.qp import QPSolversBackend, QuadraticProgram, Rows
from jtik.qp.partition import partitioned
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction, CompilerError
from jtik_formulations import JointCentering

from ..conftest import EXACT, planar


def run(stages, known):
    """The results of the stages, called in order as in `jtik.qp.staged`."""
    arguments, given = list(known[0]), []
    for k, stage in enumerate(stages):
        *outputs, handed = [*CompiledFunction(stage)(*arguments), None][: stage.n_out() + (k == len(stages) - 1)]
        given.append(outputs)
        if k < len(stages) - 1:
            arguments += [handed, *known[k + 1]]
    return given


def example():
    """Three stages, a costly value that all of them use, and outputs that are constant, zero and sparse."""
    a, b, c = symbol("a", 3), symbol("b", 2), symbol("c", 1)
    costly = casadi.exp(casadi.sin(a[0]) * a[1]) + casadi.sqrt(a[2] ** 2 + 1)
    second = costly * b[0] + casadi.if_else(b[1] > 0, b[1], -b[1])
    known = [[a], [b], [c]]
    wanted = [
        [casadi.vertcat(costly, 2.0), casadi.SX(2, 3)],
        [casadi.diag(casadi.vertcat(second, a[0]))],
        [second * c + costly],
    ]
    return known, wanted


def test_the_same_numbers(rng):
    known, wanted = example()
    stages = partitioned(["one", "two", "three"], known, wanted)
    numbers = [[rng.uniform(-1, 1, s.shape[0]) for s in group] for group in known]
    symbols = [s for group in known for s in group]
    flat = [n for group in numbers for n in group]
    for given, expected in zip(run(stages, numbers), wanted, strict=True):
        for mine, expression in zip(given, expected, strict=True):
            assert mine == pytest.approx(casadi.Function("f", symbols, [expression])(*flat).full(), abs=EXACT)


def test_nothing_is_computed_twice():
    known, wanted = example()
    stages = partitioned(["one", "two", "three"], known, wanted)
    transcendental = {casadi.OP_EXP, casadi.OP_SIN, casadi.OP_SQRT}
    counts = [sum(stage.instruction_id(i) in transcendental for i in range(stage.n_instructions())) for stage in stages]
    assert counts == [3, 0, 0]


def test_a_stage_without_intermediate_values():
    a, b = symbol("a", 1), symbol("b", 1)
    first, last = partitioned(["one", "two"], [[a], [b]], [[a + 1], [b * a]])
    assert first.numel_out(1) == 0
    assert run([first, last], [[2.0], [3.0]])[1][0] == pytest.approx(6.0)


class TestSolutionWithoutSolver:
    """The unconstrained minimiser, and whether it satisfies rows and box and so solves the QP."""

    def of(self, P, q, lower, upper, rows=()):
        x, solves = QuadraticProgram(*map(casadi.SX, (P, q, lower, upper)), rows=rows).solution_without_solver()
        x, solves = function("f", [], [x, solves])()["o0"].full()[:, 0], function("f", [], [solves])()["o0"]
        return x, bool(solves)

    def test_inside(self):
        x, solves = self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [-1, -1], [1, 1])
        assert (x.tolist(), solves) == ([-1.0, 0.5], True)

    @pytest.mark.parametrize("lower", [-0.5, -1 + 1e-9])
    def test_outside(self, lower):
        assert not self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [lower, -1], [1, 1])[1]

    @pytest.mark.parametrize(("bound", "solves"), [(-0.5, True), (-0.51, False)])
    def test_rows(self, bound, solves):
        rows = [Rows("r", *map(casadi.SX, ([[1.0, 1.0]], [-np.inf], [bound])))]
        assert self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [-5, -5], [5, 5], rows)[1] is solves

    def test_singular(self):
        assert not self.of(np.diag([1.0, 0.0]), [0.0, 1.0], [-1, -1], [1, 1])[1]

    def test_a_solve_is_the_same_as_with_a_back_end_that_always_solves(self):
        for strategy in ("newton+qp", "weighted_qp"):
            ends = []
            for solver in ("daqp", QPSolversBackend("daqp")):
                ik = jtik.InverseKinematics(
                    planar(6, lower=-0.7, upper=0.7),
                    jtik.FrameTask(),
                    criteria=JointCentering(),
                    strategy=strategy,
                    solver=solver,
                )
                ends.append(ik.solve([3.0, 3.0], q0=np.full(6, 0.2), max_iterations=40).q)
            assert ends[0] == pytest.approx(ends[1], abs=1e-6)


def test_generated_c_takes_the_same_steps(tmp_path, monkeypatch):
    """The solver itself is not compiled, because its header may be missing."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    options = {"criteria": JointCentering(), "strategy": "newton+qp"}
    steps = []
    for compiled in (False, True):
        try:
            ik = jtik.InverseKinematics(planar(4, lower=-1, upper=1), jtik.FrameTask(), compiled=compiled, **options)
        except CompilerError as error:
            pytest.skip(str(error))
        q = np.full(4, 0.3)
        for _ in range(5):
            q = ik.step(q, [2.0, 2.0]).q
        steps.append(q)
    assert steps[0] == pytest.approx(steps[1], abs=1e-9)
