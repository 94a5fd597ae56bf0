"""The eight postures of a UR5e for a pose, as the closed form of ssik has them: `best_of` finds them all."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jtik

from ..conftest import shared_solver, slow

ARM = jtik.Robot.builtin("ur5e")
HOME = ARM.keyframes["home"]
APART = 0.05
"""Postures that are closer to each other [rad], near a singular pose, are not told apart."""


def turned(difference):
    """A difference of joint positions without whole turns."""
    return (difference + np.pi) % (2 * np.pi) - np.pi


def branches(target):
    """The postures of the closed form, one for each set of equal link poses."""
    module = pytest.importorskip("ssik.prebuilt.universal_robots.ur5e_ik")
    zero = np.zeros(6)
    flange = np.linalg.inv(ARM.pose(zero)) @ module.fk(zero)
    found = []
    for answer in module.solve(target @ flange):
        if all(np.abs(turned(answer.q - other)).max() > 1e-6 for other in found):
            found.append(np.array(answer.q))
    return found


@functools.cache
def solver(compiled):
    return shared_solver(ARM, jtik.FrameTask("tip", "pose"), compiled=compiled)


@pytest.mark.slow
@pytest.mark.parametrize("compiled", [False, *slow(True)], ids=str)
def test_every_branch_of_the_closed_form_is_found(compiled, rng):
    tried = 0
    for _ in range(12):
        target = ARM.pose(rng.uniform(-np.pi, np.pi, 6))
        closed = branches(target)
        gaps = [np.abs(turned(a - b)).max() for i, a in enumerate(closed) for b in closed[:i]]
        if not closed or min(gaps, default=1.0) < APART:
            continue
        solution = solver(compiled).solve(target, q0=HOME, restarts=1000, best_of=len(closed))
        found = [solution, *solution.alternatives]
        assert len(found) == len(closed)
        for each in found:
            assert each.converged
            assert min(np.abs(turned(each.q - branch)).max() for branch in closed) < 1e-3
            nearer = each.q - 2 * np.pi * np.rint((each.q - HOME) / (2 * np.pi))
            outside = (nearer < ARM.lower) | (nearer > ARM.upper)
            assert ((np.abs(each.q - nearer) < 1e-9) | outside).all()
        distances = [np.linalg.norm(each.q - HOME) for each in found]
        assert distances == sorted(distances)
        tried += len(closed) == 8
    assert tried >= 5
