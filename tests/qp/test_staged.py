"""Steps with QPs: their parts as generated C, and their QPs by name."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.symbolic.compile import CompilerError
from jtik_formulations import JointCentering

from ..conftest import planar


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
