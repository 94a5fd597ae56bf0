"""What a solver assembles: its quadratic programs, and errors when it is built."""

from __future__ import annotations

import re

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar
from .conftest import new_solver

Q = np.array([0.3, 0.4, 0.5])


class TestBuild:
    def test_a_quadratic_program_is_called_by_its_name(self):
        ik = new_solver(planar(3), strategy="lexicographic_qp", criteria=JointCentering())
        first = ik.build(Q, (1.0, 1.5))
        named = [ik.build(Q, (1.0, 1.5), qp=name) for name in self.names(ik)]
        assert first.q.tolist() == named[0].q.tolist()
        assert len({problem.P.shape for problem in named}) > 1 or len(named) > 1

    def names(self, ik):
        with pytest.raises(jtik.UnknownNameError) as caught:
            ik.build(Q, (1.0, 1.5), qp="none of them")
        return caught.value.known

    def test_program_is_the_old_name_of_the_argument(self):
        ik = new_solver(planar(3), strategy="newton+qp", criteria=JointCentering())
        name = self.names(ik)[0]
        message = "build(program=) is deprecated: use build(qp=)"
        with pytest.warns(DeprecationWarning, match=re.escape(message)):
            old = ik.build(Q, (1.0, 1.5), program=name)
        assert old.q.tolist() == ik.build(Q, (1.0, 1.5), qp=name).q.tolist()

    def test_a_strategy_without_one(self):
        with pytest.raises(jtik.ArgumentError, match="strategy: .*accepted: one that uses quadratic programs"):
            new_solver(planar(3)).build(Q, (1.0, 1.5))


class TestInvalidInput:
    def test_a_solver_that_is_not_used(self):
        accepted = "None, as Hybrid solves no quadratic program here"
        with pytest.raises(jtik.ArgumentError, match=f"solver: given daqp; accepted: {accepted}"):
            new_solver(planar(3), solver="daqp")

    def test_clearances_that_a_strategy_does_not_support(self):
        clearance = jtik.Clearance(ObstacleAvoidance(jtik.Circle((2.0, 1.0), 0.3), bodies="links"))
        with pytest.raises(jtik.ArgumentError, match=r"clearances: given .*strategy=Newton.*accepted: .*weighted_qp"):
            new_solver(planar(3), strategy="newton", clearances=clearance)
