"""Steps with QPs: their parts as generated C, and their QPs by name."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.qp import Conic, QPRecorder, QPSolversBackend, QuadraticProgram
from jtik.qp.staged import staged
from jtik.symbolic.compile import CompilerError, bind
from jtik_formulations import JointCentering

from ..conftest import planar


@pytest.mark.slow
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


def one_qp(backend):
    """A step whose QP, minimise |x|^2 cos(a)/2 - (1, 1)'x where |x| <= 1, is known to have the solution a where a > 2.

    Only the data contains a cosine. The step returns x and whether it is a solution.
    """
    a, at, recorder = casadi.SX.sym("a"), casadi.SX.sym("at"), QPRecorder(1e-6)
    ones = casadi.SX.ones(2, 1)
    known = at * ones, at > 2
    solution = recorder.solve(
        QuadraticProgram(casadi.cos(at) * casadi.SX.eye(2), -ones, -ones, ones, closed_form=known)
    )
    return staged([a], [a], [at], recorder, [solution.x, recorder.solved()], backend)


def test_the_data_of_a_qp_is_evaluated_only_where_it_is_solved():
    parts = one_qp(Conic())

    def cosines(of):
        return sum(of.instruction_id(i) == casadi.OP_COS for i in range(of.n_instructions()))

    assert [cosines(each) for each in (parts.fast_path, *parts.stages, *parts.data)] == [0, 0, 0, 1]


@pytest.mark.parametrize(
    ("a", "x", "good"), [(3.0, 3.0, 1), (0.5, 1.0, 1), (1.5, 1.0, 1), (np.nan, np.nan, 0), (np.inf, np.inf, 0)]
)
@pytest.mark.parametrize("how", ["joined", "fast or QP path", "bound", "called"])
def test_a_known_solution_is_taken_and_others_are_checked(a, x, good, how):
    """A known one only has to be finite; data that is not calls no solver."""
    parts = one_qp(QPSolversBackend("daqp") if how == "called" else Conic())
    found = [np.zeros(2), np.zeros(1)]
    if how == "joined":
        bind(parts.joined(), [np.array([a])], found)()
    elif how == "fast or QP path":
        outputs = [*found, *[np.zeros(parts.fast_path.numel_out(i)) for i in range(2, parts.fast_path.n_out())]]
        bind(parts.fast_path, [np.array([a])], outputs)()
        if not outputs[2][0]:
            bind(parts.qp_path, [np.array([a]), *outputs[3:]], found)()
    else:
        parts.bind([np.array([a])], found)()
        if how == "called" and a == 3.0:  # a called back end always solves: cos(3) is negative, the QP not convex
            x, good = found[0], 0
    assert bool(found[1]) == bool(good)
    if good:
        assert found[0] == pytest.approx([x, x], abs=1e-6)
