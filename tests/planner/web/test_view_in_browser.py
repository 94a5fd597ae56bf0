"""The planar view in a headless Chromium: what it draws again, and when it follows the pointer."""

from __future__ import annotations

import numpy as np
import pytest

from .waiting import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]


def test_the_pointer_is_followed_before_the_next_picture(page, planner):
    page.js("""() => {
        window.late = (event) => event.stopPropagation();
        window.addEventListener("pointermove", window.late, true);
    }""")
    start = planner.loop.frame.position.copy()
    page.drag(start, start + np.array([0.3, 0.2]), steps=12)
    wait_for(lambda: np.linalg.norm(planner.loop.frame.position - start) > 0.2)
    page.js("() => window.removeEventListener('pointermove', window.late, true)")


BELOW = """(clear) => {
    const { below } = planner.view;
    if (clear) {
        document.querySelector("#tools button:last-child").click();
        planner.view.draw();
    }
    const data = below.getContext("2d").getImageData(0, 0, below.width, below.height).data;
    window.clean ??= data;
    return data.reduce((count, value, k) => count + (value !== window.clean[k]), 0);
}"""
"""How many numbers of the pixels below the arm are others than at first; with a true argument, without a path."""

COLOUR = """(place) => {
    const { canvas, toScreen } = planner.view;
    return canvas.getContext("2d").getImageData(...toScreen(place), 1, 1).data.join();
}"""


def test_an_obstacle_that_is_switched_off_is_an_outline(page, planner):
    name, disc = list(planner.loop.settings.to_json()["scene"].items())[-1]
    beside = [disc["center"][0] + 0.13, disc["center"][1] - disc["radius"] - 0.27]
    ground, filled = page.evaluate(COLOUR, beside), page.evaluate(COLOUR, disc["center"])
    assert filled != ground
    for gain, shown in ((0, ground), (1, filled)):
        page.evaluate("(fields) => planner.send('set_obstacle_gain', fields)", {"name": name, "gain": gain})
        wait_for(lambda shown=shown: page.evaluate(COLOUR, disc["center"]) == shown)


def test_the_path_is_drawn_until_it_is_cleared(page, planner):
    assert page.evaluate(BELOW, True) == 0
    start = planner.loop.frame.position.copy()
    page.drag(start, start + np.array([-0.3, -0.2]), steps=12)
    wait_for(lambda: page.evaluate(BELOW, False) > 100)
    assert page.evaluate(BELOW, True) == 0
