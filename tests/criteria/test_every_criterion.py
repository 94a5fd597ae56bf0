"""The public contract, for every registered criterion: a new plugin is tested without editing tests.

Each criterion on two robots, in turn: ``--full`` runs it on all of them.
"""

from __future__ import annotations

import pytest

import jtik
from jtik.testing import check_criterion, example_criterion

from ..conftest import ball_arm, dh_arm, floating_arm, planar, weighted

ROBOTS = {
    "planar": lambda: planar(5),
    "limited": lambda: planar(4, lower=-1.0, upper=0.5),
    "vehicle": lambda: jtik.Robot.vehicle(3, heading=True),
    "spatial": lambda: dh_arm(6, 3),
    "ball": ball_arm,
    "floating": floating_arm,
}


NAMES = sorted(jtik.criteria)
QUICK = {(("planar", "ball")[row % 2], name) for row, name in enumerate(NAMES)}


@pytest.mark.quick(5)
@pytest.mark.thinned
@pytest.mark.parametrize(
    ("robot", "name"),
    [
        pytest.param(robot, name, marks=[] if (robot, name) in QUICK else pytest.mark.slow)
        for robot in ROBOTS
        for name in NAMES
    ],
)
def test_contract(robot, name):
    body = weighted(ROBOTS[robot]())
    check_criterion(example_criterion(jtik.criteria[name], body), body, samples=5)
