"""The runners of a solver: the same step on the virtual machine and as generated C."""

from __future__ import annotations

import pytest

import jtik
from jtik.symbolic.compile import CompilerError
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar
from .conftest import FIELD, new_solver


class TestCompiled:
    """The same step as generated C."""

    @pytest.mark.slow
    def test_agrees_with_the_virtual_machine(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        options = {"criteria": JointCentering() + 0.3 * ObstacleAvoidance(FIELD[:1])}
        try:
            fast = new_solver(planar(4), compiled=True, **options)
        except CompilerError as error:
            pytest.skip(str(error))
        slow = new_solver(planar(4), **options)
        for target in ([2.0, 2.0], [3.0, -1.0], [5.0, 5.0]):
            one, other = (ik.solve(target, q0=[0.3, 0.2, 0.1, 0.4]) for ik in (fast, slow))
            assert one.status is other.status
            assert one.q == pytest.approx(other.q, abs=1e-6)  # the compiler may contract a * b + c

    def test_without_a_compiler_says_what_was_tried(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        monkeypatch.setenv("CC", "/nowhere/to/be/found")
        with pytest.raises(jtik.JtikError, match="/nowhere/to/be/found"):
            new_solver(planar(2), compiled=True)
