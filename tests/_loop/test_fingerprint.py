"""Fingerprints of values."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik._loop.fingerprint import fingerprint
from jtik_formulations import Damped, JointCentering, ObstacleAvoidance


class TestFingerprint:
    def test_equal_values_have_equal_fingerprints(self):
        def made():
            arm = jtik.Robot.planar(3, lower=-1.0, upper=1.0)
            field = ObstacleAvoidance([jtik.Circle(center=(1.0, 1.0), radius=0.1)])
            return arm, 2.0 * JointCentering() + field, Damped(damping=0.2), jtik.FrameTask("tip", stiffness=[1, 2])

        assert fingerprint(*made()) == fingerprint(*made())

    @pytest.mark.parametrize(
        ("one", "other"),
        [
            (1, 1.0),
            ("1", 1),
            ((1, 2), (2, 1)),
            (("ab", "c"), ("a", "bc")),
            (np.array([1.0]), np.array([1.0 + 1e-16 * 4])),
            (np.zeros((2, 3)), np.zeros((3, 2))),
            (jtik.Robot.planar(3), jtik.Robot.planar([1, 1, 1 + 1e-12])),
            (jtik.FrameTask("tip"), jtik.FrameTask("tip", stiffness=2.0)),
            (jtik.criterion(lambda q, robot: q[0]), jtik.criterion(lambda q, robot: q[1])),
            (jtik.criterion(lambda q, robot: 2 * q[0]), jtik.criterion(lambda q, robot: 3 * q[0])),
        ],
    )
    def test_different_values_have_different_fingerprints(self, one, other):
        assert fingerprint(one) != fingerprint(other)

    def test_a_recursive_value_has_a_fingerprint(self):
        ring = []
        ring.append(ring)
        assert fingerprint(ring) == fingerprint(ring)

    @pytest.mark.slow
    def test_a_fingerprint_is_the_same_in_another_process(self):
        import subprocess
        import sys

        code = (
            "import jtik; from jtik._loop.fingerprint import fingerprint; from jtik_formulations import Damped;"
            "print(fingerprint(jtik.Robot.planar(3), jtik.FrameTask('tip'), Damped(), frozenset('abc')))"
        )
        run = [sys.executable, "-c", f"import sys; sys.path[:0] = {sys.path!r}; {code}"]
        prints = {subprocess.run(run, capture_output=True, text=True, check=True).stdout for _ in range(2)}
        own = fingerprint(jtik.Robot.planar(3), jtik.FrameTask("tip"), Damped(), frozenset("abc"))
        assert prints == {own + "\n"}
