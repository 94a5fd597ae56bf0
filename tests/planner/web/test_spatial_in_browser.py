"""A spatial robot in the browser: drawn by WebGL, its target moved by arrows, squares and rings."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.web.desk import Desk

from .waiting import is_still, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

BALL = jtik.Sphere((0.45, 0.45, 0.35), 0.08)


@pytest.fixture(scope="module")
def planner():
    with Planner(jtik.Robot.builtin("panda"), scene=jtik.Scene({"ball": BALL}), folder=False) as session:
        yield Desk(session.loop)


def size(page, place):
    """Length of an arrow of the handles [m]."""
    return page.evaluate("(place) => planner.view.gizmoSize(place)", [float(x) for x in place])


def angle(a, b):
    """Angle between two orientations [rad]."""
    return 2 * np.arccos(min(1.0, abs(float(np.dot(a, b)))))


def test_the_robot_is_drawn(page):
    wait_for(lambda: page.js("() => planner.state.drawn") > 1)
    colours = page.js("""() => {
        planner.view.draw();
        const gl = planner.view.renderer.gl;
        const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
        const data = new Uint8Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
        const seen = new Set();
        for (let k = 0; k < data.length; k += 4) seen.add(data[k] << 16 | data[k + 1] << 8 | data[k + 2]);
        return [seen.size, gl.getError()];
    }""")
    assert colours[0] > 200
    assert colours[1] == 0


def test_edges_are_smooth_at_rest_where_the_processor_draws(page):
    pixels = "() => planner.view.canvas.width / planner.view.canvas.clientWidth"
    if not page.js("() => planner.view.renderer.software"):
        pytest.skip("this browser draws with a graphics card")
    wait_for(lambda: round(page.js(pixels)) == 2)
    assert (
        round(page.js("() => (planner.view.draw(), planner.view.canvas.width / planner.view.canvas.clientWidth)")) == 1
    )
    page.js("() => planner.emit('overlays')")  # the view is drawn again, and comes to rest
    wait_for(lambda: round(page.js(pixels)) == 2)
    assert page.js("() => planner.view.renderer.gl.getError()") == 0


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_arrow_moves_the_target_along_its_axis(page, planner, axis):
    start = planner.loop.frame.position.copy()
    along = np.eye(3)[axis]
    arrow = start + 0.9 * size(page, start) * along
    page.drag(arrow, arrow + 0.06 * along)
    wait_for(lambda: is_still(planner) and abs((planner.loop.frame.position - start) @ along - 0.06) < 0.01)
    np.testing.assert_allclose((planner.loop.frame.position - start) * (1 - along), 0, atol=1e-6)
    wait_for(
        lambda: np.allclose(planner.arm.robot.position(planner.loop.frame.q), planner.loop.frame.position, atol=2e-3)
    )


def test_a_square_moves_the_target_in_its_plane(page, planner):
    start = planner.loop.frame.position.copy()
    square = start + 0.42 * size(page, start) * np.array([0, 1, 1])
    page.drag(square, square + np.array([0, 0.03, -0.05]))
    wait_for(lambda: is_still(planner) and planner.loop.frame.position[2] < start[2] - 0.03)
    assert planner.loop.frame.position[0] == pytest.approx(start[0], abs=1e-6)


def test_a_ring_turns_the_target(page, planner):
    position, before = planner.loop.frame.position.copy(), planner.loop.frame.orientation.copy()
    radius = 0.8 * size(page, position)
    ring = [position + radius * np.array([np.cos(a), np.sin(a), 0]) for a in (1.25, 1.55)]
    page.drag(*ring)
    wait_for(lambda: abs(angle(before, planner.loop.frame.orientation) - 0.3) < 0.1)
    np.testing.assert_allclose(planner.loop.frame.position, position, atol=1e-6)
    wait_for(lambda: planner.loop.status.error < 1e-2)


def test_an_obstacle_is_selected_moved_and_the_target_is_not(page, planner):
    start = planner.loop.frame.position.copy()
    page.press(BALL.center)
    page.mouse.up()
    wait_for(lambda: page.js("() => planner.state.selected.name") == "ball")
    up = np.array([0.0, 0.0, 1.0])
    arrow = BALL.center + 0.9 * size(page, BALL.center) * up
    page.drag(arrow, arrow + 0.1 * up)
    wait_for(lambda: abs(planner.loop.settings.scene["ball"]["center"][2] - BALL.center[2] - 0.1) < 0.02)
    np.testing.assert_array_equal(planner.loop.frame.position, start)


def test_keys_move_the_target_as_the_camera_sees_it(page, planner):
    page.focus()
    start = planner.loop.frame.position.copy()
    right = np.array(page.js("() => planner.view.right()"))
    page.keyboard.down("KeyD")
    wait_for(lambda: (planner.loop.frame.position - start) @ right > 0.02)
    page.keyboard.up("KeyD")
    wait_for(lambda: is_still(planner))
    moved = planner.loop.frame.position - start
    np.testing.assert_allclose(moved, (moved @ right) * right, atol=1e-9)


def test_dragging_the_ground_orbits_the_camera(page, planner):
    yaw = page.js("() => planner.view.yaw")
    box = page.box("#view")
    page.mouse.move(box["x"] + 30, box["y"] + box["height"] - 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 130, box["y"] + box["height"] - 30, steps=4)
    page.mouse.up()
    assert page.js("() => planner.view.yaw") < yaw - 0.5


def test_a_robot_without_mesh_files_says_so(page):
    switch = page.get_by_label("Meshes")
    assert switch.is_disabled()
    assert "names no mesh files" in page.find(".tools .switch").get_attribute("title")
