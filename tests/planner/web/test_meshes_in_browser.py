"""Meshes in the browser: a plate far from the skeleton is seen while the switch is on, and moves with its link."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.edits.messages import MoveTarget
from jtik.planner.web.desk import Desk

from .plated import MIDDLE, plated_arm
from .waiting import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

START = np.array([0.3, 0.5, 0.7, 0.2, 0.4, 0.1])


@pytest.fixture(scope="module")
def planner(tmp_path_factory):
    with Planner(plated_arm(tmp_path_factory.mktemp("plated")), q0=START, criteria=(), folder=False) as session:
        yield Desk(session.loop)


def seen(page, planner):
    """Whether the middle of the plate, which is not near a capsule, has the colour of the arm on the picture."""
    robot: jtik.Robot = planner.arm.robot
    pose = robot.pose(planner.loop.frame.q, "link6")
    place = (pose @ [*MIDDLE, 1.0])[:3]
    red, _, blue = page.evaluate(
        """([place]) => {
        const { view } = planner;
        view.draw();
        const gl = view.renderer.gl;
        const [u, v] = view.toScreen(place);
        const ratio = view.canvas.width / view.size[0];
        const data = new Uint8Array(4);
        const [column, row] = [Math.round(u * ratio), view.canvas.height - Math.round(v * ratio)];
        gl.readPixels(column, row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, data);
        return [...data].slice(0, 3);
    }""",
        [place.tolist()],
    )
    return blue - red > 40


def test_the_switch_shows_the_meshes_which_move_with_the_arm(page, planner):
    wait_for(lambda: page.js("() => planner.state.drawn") > 1)
    asked = sum(url.endswith("/meshes") for url in page.requested)
    assert asked == 0
    assert not seen(page, planner)
    switch = page.get_by_label("Meshes")
    switch.check()
    wait_for(lambda: page.js("() => planner.view.meshes !== null"))
    assert seen(page, planner)
    start = planner.loop.frame.position
    planner.loop.submit(MoveTarget((start[0], start[1], start[2] - 0.2)))
    wait_for(lambda: "rest" in planner.loop.status.words and planner.loop.frame.position[2] < start[2] - 0.19)
    wait_for(lambda: seen(page, planner))
    switch.uncheck()
    assert not seen(page, planner)
    switch.check()
    wait_for(lambda: seen(page, planner))
    assert sum(url.endswith("/meshes") for url in page.requested) == 1
    assert page.js("() => planner.view.renderer.gl.getError()") == 0


def test_a_mesh_has_the_colour_of_a_violated_clearance(page, planner):
    page.get_by_label("Meshes").check()
    wait_for(lambda: seen(page, planner))
    colour = page.js("""() => {
        const shown = [];
        const { renderer } = planner.view;
        const draw = renderer.draw.bind(renderer);
        renderer.draw = (mesh, pose, size, colour, options) => {
            if (mesh.index) shown.push([...colour]);
            draw(mesh, pose, size, colour, options);
        };
        planner.state.status = { ...planner.state.status, violated: ['link6'] };
        planner.view.draw();
        delete renderer.draw;
        return shown;
    }""")
    assert len(colour) == 1
    assert colour[0][0] - colour[0][2] > 0.2


def test_the_switch_is_remembered(page):
    page.get_by_label("Meshes").check()
    page.reload()
    page.wait_for_function("() => window.planner?.view?.meshes")
    assert page.get_by_label("Meshes").is_checked()
