"""What the tests of the planner's data share: attempts that need no solver and no clock."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner.attempts.attempt import Attempt

SCENE = {"obstacles": {"post": {"shape": "circle", "center": [2.0, 1.0], "radius": 0.25, "gain": 1.0}}}


def make_attempt(name="attempt 1", k=50, nq=3, **changes) -> Attempt:
    """Smooth joint motions with numbers that no short decimal has."""
    times = np.arange(k) / 60
    phases = np.arange(1, nq + 1) / 3
    configurations = np.sin(times[:, None] * phases + phases)
    targets = np.stack([np.cos(times), np.sin(times)], axis=1) * np.e
    values = {
        "name": name,
        "dt": 1 / 60,
        "times": times,
        "configurations": configurations,
        "targets": targets,
        "strategy": "hybrid",
        "criteria": ("joint_centering",),
        "settings": {"gains": {"joint_centering.gain": 0.1}, "limits": True},
    }
    return Attempt(**(values | changes))


def same(a: Attempt, b: Attempt) -> bool:
    """Whether two attempts are the same to the last bit."""
    return a.to_json() == b.to_json()


@pytest.fixture(scope="session")
def arm() -> jtik.Robot:
    return jtik.Robot.planar(3)
