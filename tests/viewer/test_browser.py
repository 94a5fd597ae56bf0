"""The viewer in a browser: it shows a picture of the arm, and a slider moves it."""

from __future__ import annotations

import io
import shutil
from typing import Any

import numpy as np
import pytest

import jtik

pytest.importorskip("viser")
playwright = pytest.importorskip("playwright.sync_api")
image = pytest.importorskip("PIL.Image")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.browser,
    pytest.mark.xdist_group("browser"),
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]

WAIT = 120_000
"""How long a page may take on a busy machine without a GPU [ms]."""

ARM_SHARE = 0.005
"""Smallest share of the pixels that has the colour of the arm."""


def bluish(page: Any) -> np.ndarray:
    """The pixels that have the colour of the arm, outside of the panel."""
    picture = np.asarray(image.open(io.BytesIO(page.screenshot(timeout=WAIT))).convert("RGB")).astype(int)
    red, _, blue = picture[:, :400].transpose(2, 0, 1)
    return np.asarray(blue - red > 40)


def test_the_arm_is_seen_and_a_slider_moves_it() -> None:
    with jtik.view(jtik.Robot.builtin("ur5e"), show="shapes") as viewer, playwright.sync_playwright() as p:
        options = ["--no-sandbox", "--enable-unsafe-swiftshader"]
        browser = p.chromium.launch(executable_path=CHROMIUM, args=options)
        try:
            page = browser.new_page(viewport={"width": 800, "height": 500})
            page.goto(viewer.url, timeout=WAIT)
            page.get_by_text("shoulder_pan_joint").wait_for(timeout=WAIT)
            for _ in range(60):  # the scene fades in
                before = bluish(page)
                if before.mean() > ARM_SHARE:
                    break
                page.wait_for_timeout(1000)
            assert before.mean() > ARM_SHARE
            number = page.locator('input[inputmode="decimal"]').first
            number.fill("1.5", timeout=WAIT)
            number.press("Enter")
            for _ in range(60):
                if abs(viewer.q["ur5e"][0] - 1.5) < 1e-6:
                    break
                page.wait_for_timeout(500)
            assert viewer.q["ur5e"][0] == pytest.approx(1.5)
            page.wait_for_timeout(2000)
            assert (bluish(page) != before).mean() > ARM_SHARE
        finally:
            browser.close()
