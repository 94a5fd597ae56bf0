"""Solvers that the tests of the loop share."""

from __future__ import annotations

import jtik

from ..conftest import families_first, shared_solver

STRATEGIES = sorted(jtik.strategies)
EVERY_STRATEGY = families_first(STRATEGIES)

FIELD = [jtik.Circle((4.0, 2.0), 0.6), jtik.Circle((6.5, -1.0), 0.8)]
"""Two obstacles for a planar arm of ten links."""


def new_solver(robot, *, kind="position", **options):
    """A solver for the frame "tip" of a robot, whose functions are all built for it."""
    return jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), **options)


def solver(robot, *, kind="position", **options):
    """A solver for the frame "tip" of a robot; its functions are shared with those of equal arguments."""
    return shared_solver(robot, jtik.FrameTask("tip", kind), **options)
