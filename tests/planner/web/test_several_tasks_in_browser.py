"""Several tasks in the browser: a list chooses the one whose target is dragged; the others are marked and stay."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.web.desk import Desk

from .waiting import is_still, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

TASKS = [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow")]
START = [0.9, -0.5, -0.5, 0.4, 0.5, -0.6, -0.5]


@pytest.fixture(scope="module")
def planner():
    with Planner(jtik.Robot.planar(7), TASKS, criteria=(), q0=START, folder=False) as session:
        yield Desk(session.loop)


def at(planner, frame):
    return planner.arm.robot.position(planner.loop.frame.q, frame)


def test_the_list_chooses_the_target_that_is_dragged(page, planner):
    elbow, tip = at(planner, "link4"), at(planner, "tip")
    page.drag(tip, tip + np.array([-0.5, 0.3]))
    wait_for(lambda: is_still(planner) and planner.loop.status.error < 1e-3)
    np.testing.assert_allclose(at(planner, "tip"), np.add(tip, [-0.5, 0.3]), atol=0.03)
    np.testing.assert_allclose(at(planner, "link4"), elbow, atol=1e-3)
    moved = at(planner, "tip")
    page.select('select[aria-label="task to guide"]', "elbow")
    wait_for(lambda: np.allclose(planner.loop.frame.position, elbow, atol=1e-3))
    wait_for(lambda: page.js("() => planner.state.settings.tasks.map(({ held }) => held === null)") == [False, True])
    page.drag(elbow, elbow + np.array([0.1, -0.3]))
    wait_for(lambda: is_still(planner) and planner.loop.status.error < 1e-3)
    np.testing.assert_allclose(at(planner, "link4"), np.add(elbow, [0.1, -0.3]), atol=0.03)
    np.testing.assert_allclose(at(planner, "tip"), moved, atol=2e-3)
