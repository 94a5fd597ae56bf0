"""The planner's page in a headless Chromium: mouse, keys and a gamepad, read back from the loop."""

from __future__ import annotations

import time

import numpy as np
import pytest

from .waiting import is_still, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

GAMEPAD = """() => {
  window.pad = { connected: true, axes: [0, 0, 0, 0], buttons: [] };
  navigator.getGamepads = () => [window.pad];
}"""


def tip(planner):
    return planner.arm.robot.position(planner.loop.frame.q)


def at_rest(planner):
    """Whether the arm is where it goes to."""
    before = planner.loop.frame.q.copy()
    time.sleep(0.2)
    return np.abs(planner.loop.frame.q - before).max() < 1e-4


def scene(planner):
    return planner.loop.settings.to_json()["scene"]


def test_the_page_opens_and_draws_without_a_complaint(page):
    assert page.title().startswith("planar10")
    assert page.js("() => planner.state.setup.robot.joints.length") == 10
    wait_for(lambda: page.js("() => planner.state.drawn") > 1)
    wait_for(lambda: page.text("#status") not in ("", "connecting"))
    assert page.text("#link") == "connected"
    colours = page.js("""() => {
        const canvas = document.querySelector("#view canvas");
        const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        const seen = new Set();
        for (let k = 0; k < data.length; k += 4) seen.add(data[k] << 16 | data[k + 1] << 8 | data[k + 2]);
        return seen.size;
    }""")
    assert colours > 20
    box = page.box("#view")
    time.sleep(0.5)
    assert page.box("#view") == box, "the view does not grow"


def test_the_page_asks_nobody_else(page, server):
    assert {url.split("/")[2] for url in page.requested} == {f"127.0.0.1:{server.port}"}


def test_the_target_is_dragged_and_the_arm_follows(page, planner):
    goal = np.array([5.2, 0.8])
    page.drag(planner.loop.frame.position, goal)
    wait_for(lambda: np.allclose(planner.loop.frame.position, goal, atol=0.05))
    wait_for(lambda: np.linalg.norm(tip(planner) - planner.loop.frame.position) < 1e-3)
    wait_for(lambda: at_rest(planner))
    shown = page.js("() => [...planner.state.frame.q]")
    np.testing.assert_allclose(planner.arm.robot.position(shown), planner.loop.frame.position, atol=1e-3)


def test_the_target_moves_at_most_at_its_speed(page, planner):
    start, begin = planner.loop.frame.position.copy(), planner.loop.frame.time
    page.drag(start, start + np.array([-1.0, 0.6]), steps=2)
    wait_for(lambda: is_still(planner))
    speed = planner.loop.settings.target_speed[0]
    moved = np.linalg.norm(planner.loop.frame.position - start)
    assert moved > 0.5
    assert planner.loop.frame.time - begin >= 0.9 * moved / speed


def test_a_number_moves_the_target(page, planner):
    y = planner.loop.frame.position[1]
    page.fill_number("x", 5.0)
    wait_for(lambda: np.allclose(planner.loop.frame.position, [5.0, y], atol=1e-3))


def test_an_obstacle_is_dragged_and_the_posture_changes(page, planner):
    wait_for(lambda: at_rest(planner))
    before, where = planner.loop.frame.q.copy(), tip(planner)
    name, disc = next(iter(scene(planner).items()))
    elbow = planner.arm.robot.position(before, "link5")
    goal = elbow + np.array([0.0, -0.9])
    page.drag(disc["center"], goal)
    wait_for(lambda: np.allclose(scene(planner)[name]["center"], goal, atol=0.05))
    wait_for(lambda: np.abs(planner.loop.frame.q - before).max() > 0.02)
    np.testing.assert_allclose(tip(planner), where, atol=1e-2)
    page.drag(goal, disc["center"])
    wait_for(lambda: np.allclose(scene(planner)[name]["center"], disc["center"], atol=0.05))


@pytest.mark.parametrize("shape", ["circle", "capsule", "box", "polygon", "half_space", "point"])
def test_an_obstacle_of_every_shape_is_added_changed_switched_off_and_deleted(page, planner, shape):
    before = set(scene(planner))
    page.select("#add-obstacle", shape)
    wait_for(lambda: set(scene(planner)) - before)
    (name,) = set(scene(planner)) - before
    assert scene(planner)[name]["shape"] == shape
    row = page.find(f'[data-obstacle="{name}"]')
    row.locator('.fields input[aria-label="x"]').fill("7.5")
    row.locator('.fields input[aria-label="x"]').press("Enter")
    row.locator('.fields input[aria-label="y"]').fill("-4.5")
    row.locator('.fields input[aria-label="y"]').press("Enter")

    def middle():
        made = scene(planner)[name]
        for keys in (("center",), ("point",), ("start", "end")):
            if keys[0] in made:
                return np.mean([made[key] for key in keys], axis=0)
        return np.mean(made["vertices"], axis=0)

    wait_for(lambda: np.allclose(middle(), [7.5, -4.5], atol=1e-6))
    row.locator("input[role=switch]").click()
    wait_for(lambda: scene(planner)[name]["gain"] == 0)
    row.locator("input[role=switch]").click()
    wait_for(lambda: scene(planner)[name]["gain"] == 1)
    row.locator(f'[aria-label="delete {name}"]').click()
    wait_for(lambda: name not in scene(planner))


def test_a_box_is_resized_and_turned_by_its_handles(page, planner):
    page.select("#add-obstacle", "box")
    wait_for(lambda: "box_1" in scene(planner))
    wait_for(lambda: page.js("() => 'box_1' in planner.state.settings.scene"))
    box = scene(planner)["box_1"]
    center, half = np.array(box["center"]), np.array(box["half"])
    page.drag(center + half, center + half + np.array([0.3, 0.2]))
    wait_for(lambda: np.allclose(scene(planner)["box_1"]["half"], half + np.array([0.3, 0.2]), atol=0.06))
    half = np.array(scene(planner)["box_1"]["half"])
    arm = half[0] + 26 / page.js("() => planner.view.zoom")
    page.drag(center + np.array([arm, 0]), center + np.array([arm * np.cos(0.6), arm * np.sin(0.6)]))
    wait_for(lambda: abs(scene(planner)["box_1"]["rotation"] - 0.6) < 0.1)
    page.focus()
    page.keyboard.press("Delete")
    wait_for(lambda: "box_1" not in scene(planner))


@pytest.mark.parametrize(("key", "direction"), [("ArrowLeft", [-1, 0]), ("KeyW", [0, 1])])
def test_a_key_moves_the_target_until_it_is_up(page, planner, key, direction):
    page.focus()
    before = planner.loop.frame.position.copy()
    page.keyboard.down(key)
    wait_for(lambda: (planner.loop.frame.position - before) @ direction > 0.15)
    page.keyboard.up(key)
    wait_for(lambda: is_still(planner))
    across = abs((planner.loop.frame.position - before) @ direction[::-1])
    assert across < 1e-9


def test_keys_act_on_the_focused_view_only(page, planner):
    page.find('input[aria-label="x"]').first.focus()
    before = planner.loop.frame.position.copy()
    page.keyboard.press("KeyD")
    time.sleep(0.3)
    np.testing.assert_array_equal(planner.loop.frame.position, before)


def test_a_view_that_loses_the_focus_stops_the_target(page, planner):
    page.focus()
    before = planner.loop.frame.position.copy()
    page.keyboard.down("ArrowRight")
    wait_for(lambda: planner.loop.frame.position[0] > before[0] + 0.1)
    page.find("#theme").focus()
    wait_for(lambda: is_still(planner))
    page.keyboard.up("ArrowRight")


def test_a_gamepad_steers_the_target_and_the_self_motion(page, planner):
    page.evaluate(GAMEPAD)
    before = planner.loop.frame.position.copy()
    page.evaluate("() => (window.pad.axes = [-0.6, 0, 0, 0])")
    wait_for(lambda: planner.loop.frame.position[0] < before[0] - 0.15)
    page.evaluate("() => (window.pad.axes = [0.05, 0, 0, 0])")  # at rest, a stick is never quite at zero
    wait_for(lambda: is_still(planner))
    wait_for(lambda: at_rest(planner))
    q, where = planner.loop.frame.q.copy(), tip(planner)
    page.evaluate("() => (window.pad.axes = [0, 0, 1, 0])")
    wait_for(lambda: np.abs(planner.loop.frame.q - q).max() > 0.02)
    np.testing.assert_allclose(tip(planner), where, atol=2e-3)
    page.evaluate("() => (window.pad.axes = [0, 0, 0, 0])")
    wait_for(lambda: at_rest(planner))


def test_the_slider_moves_the_arm_along_its_self_motion_until_it_is_let_go(page, planner):
    wait_for(lambda: at_rest(planner))
    before, where = planner.loop.frame.q.copy(), tip(planner)
    box = page.find('input[aria-label="self-motion"]').bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], box["y"] + box["height"] / 2, steps=4)
    wait_for(lambda: np.abs(planner.loop.frame.q - before).max() > 0.1)
    np.testing.assert_allclose(tip(planner), where, atol=2e-3)
    page.mouse.up()
    wait_for(lambda: at_rest(planner))
    assert page.js("() => document.querySelector('[aria-label=\"self-motion\"]').value") == "0"


def test_two_quick_clicks_are_both_taken(page, planner):
    page.click_text("joint centering")
    page.click_text("obstacle avoidance")
    wait_for(lambda: not planner.loop.settings.criteria)
    page.click_text("joint centering")
    page.click_text("obstacle avoidance")
    wait_for(lambda: set(planner.loop.settings.criteria) == {"joint_centering", "obstacle_avoidance"})
    wait_for(lambda: not planner.loop.status.rebuilding, 150)


def test_a_browser_that_is_closed_in_mid_drag_stops_the_target(open_page, planner):
    page = open_page()
    start = planner.loop.frame.position.copy()
    page.press(start)
    page.move(start + np.array([-2.0, 1.5]))
    wait_for(lambda: np.linalg.norm(planner.loop.frame.position - start) > 0.1)
    page.close()
    wait_for(lambda: is_still(planner))
    assert np.linalg.norm(planner.loop.frame.position - start) < 2.4


def test_a_browser_that_is_closed_with_a_key_down_stops_the_target(open_page, planner):
    page = open_page()
    page.focus()
    start = planner.loop.frame.position.copy()
    page.keyboard.down("ArrowRight")
    wait_for(lambda: planner.loop.frame.position[0] > start[0] + 0.05)
    page.close()
    wait_for(lambda: is_still(planner))


def test_two_browsers_see_the_same(page, open_page, planner):
    other = open_page()
    name, disc = list(scene(planner).items())[3]
    goal = np.array(disc["center"]) + np.array([0.0, 0.4])
    page.drag(disc["center"], goal)
    seen = f"() => planner.state.settings.scene[{name!r}].center"
    wait_for(lambda: np.allclose(other.js(seen), goal, atol=0.05))
    page.focus()
    page.keyboard.down("KeyS")
    wait_for(lambda: other.js("() => planner.state.frame.position[1]") < planner.loop.frame.position[1] + 1)
    page.keyboard.up("KeyS")
    wait_for(lambda: is_still(planner))
    wait_for(
        lambda: np.allclose(
            other.js("() => [...planner.state.frame.position]")[:2], planner.loop.frame.position, atol=1e-4
        )
    )
    other.close()
    wait_for(lambda: page.text("#link") == "connected")


def test_the_preferred_posture_is_set_and_taken(page, planner):
    page.set_slider("joint3", 0.8)
    wait_for(lambda: abs(planner.loop.settings.preferred[2] - 0.8) < 0.02)

    def slow(seconds=0.2):
        before = planner.loop.frame.q
        time.sleep(seconds)
        return np.abs(planner.loop.frame.q - before).max() < 5e-3

    wait_for(slow)
    here = planner.loop.frame.q  # from which the obstacles may lead the arm away later
    page.click_text("Take the present posture")
    wait_for(lambda: np.allclose(planner.loop.settings.preferred, here, atol=0.05))


def test_weights_of_joints_are_set_by_number_and_by_slider_and_made_equal(page, planner):
    def weights():
        return planner.loop.settings.joint_weights

    page.click_text("Joint weights")
    page.find('input[type=number][aria-label="weight of joint2"]').fill("30")
    page.keyboard.press("Enter")
    wait_for(lambda: weights()[1] == 30)
    slider = page.find('input[type=range][aria-label="weight of joint4"]')
    slider.scroll_into_view_if_needed()
    slider.press("End")
    wait_for(lambda: weights() == (1, 30, 1, 1000, 1, 1, 1, 1, 1, 1))
    page.find("#theme").focus()
    wait_for(lambda: page.find('input[type=number][aria-label="weight of joint4"]').input_value() == "1000")
    page.click_text("Equal weights")
    wait_for(lambda: weights() == (1,) * 10)
    wait_for(lambda: float(slider.input_value()) == 0)


def test_gains_strategy_criteria_limits_and_clearance_are_changed(page, planner):
    gain = page.find('[data-gain="obstacle_avoidance.gain"] input[type=number]')
    gain.fill("3.5")
    gain.press("Enter")
    wait_for(lambda: planner.loop.settings.to_json()["gains"]["obstacle_avoidance.gain"] == 3.5)
    page.select('[aria-label="strategy"]', "newton")
    wait_for(lambda: planner.loop.settings.strategy["name"] == "newton")
    page.click_text("joint centering")
    wait_for(lambda: "joint_centering" not in planner.loop.settings.criteria)
    page.click_text("joint centering")
    wait_for(lambda: "joint_centering" in planner.loop.settings.criteria)
    page.click_text("joint limits")
    wait_for(lambda: planner.loop.settings.limits is False)
    page.click_text("clearance", exact=True)
    wait_for(lambda: planner.loop.settings.clearance is True)
    page.click_text("clearance", exact=True)
    page.select('[aria-label="strategy"]', "hybrid")
    wait_for(lambda: planner.loop.settings.strategy["name"] == "hybrid")
    wait_for(lambda: not planner.loop.status.rebuilding, 150)


def test_what_is_refused_is_told_on_the_page(page):
    page.evaluate("() => planner.send('explode')")
    wait_for(lambda: "explode" in page.text("#toasts"))


def test_dark_and_light(page):
    before = page.js("() => getComputedStyle(document.body).backgroundColor")
    page.find("#theme").click()
    assert page.js("() => getComputedStyle(document.body).backgroundColor") != before
    page.find("#theme").click()
    assert page.js("() => getComputedStyle(document.body).backgroundColor") == before


@pytest.mark.parametrize("width", [1000, 1440, 2500])
def test_nothing_is_cut_off_at_any_width(page, width):
    page.set_viewport_size({"width": width, "height": 900})
    time.sleep(0.3)
    assert page.js("() => document.documentElement.scrollWidth <= innerWidth")
    assert page.js(
        "() => [...document.querySelectorAll('.transport, .bar')].every((row) => row.scrollWidth <= row.clientWidth)"
    )
    view = page.box("#view")
    assert view["width"] > 450
    assert view["height"] > 300
    page.set_viewport_size({"width": 1440, "height": 900})
