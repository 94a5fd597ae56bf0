"""What several tests of criteria use."""

from __future__ import annotations

import jtik

from ..conftest import families_first, report_at, shared_solver

STRATEGIES = families_first(sorted(jtik.strategies))


@jtik.criterion
def link_height(q, robot, *, height=0.5):
    """Squared distance of the third joint's y from a height [m]."""
    return (robot.position(q, "link3")[1] - height) ** 2


def new_solver(robot, criteria, strategy="hybrid", **options):
    """A solver whose functions are all built for it."""
    return jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, **options)


def solver(robot, criteria, strategy="hybrid", **options):
    """A solver whose functions are shared with those of equal arguments."""
    return shared_solver(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, **options)


def at(ik, q):
    return report_at(ik, q, ik.robot.position(q))
