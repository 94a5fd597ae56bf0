"""A planner of the ten-link arm and its server, for the tests of the page."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

from jtik.planner import Planner
from jtik.planner.web.desk import Desk
from jtik.planner.web.server import Server


@pytest.fixture(scope="module")
def planner() -> Iterator[Desk]:
    with Planner(folder=False) as session:
        yield Desk(session.loop)


@pytest.fixture(scope="module")
def server(planner) -> Iterator[Server]:
    with Server(planner, port=0) as server:
        yield server


class Page:
    """A page of the planner in a browser; places are in the robot's coordinates [m]."""

    def __init__(self, page, url):
        self._page = page
        self.requested, self.complaints = [], []
        page.on("request", lambda request: self.requested.append(request.url))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", lambda line: self.complaints.append(line.text) if line.type == "error" else None)
        page.goto(url)
        page.wait_for_function("() => window.planner?.view && planner.state.frame && planner.state.status")

    def __getattr__(self, name):
        return getattr(self._page, name)

    def js(self, function):
        return self._page.evaluate(function)

    def find(self, selector):
        return self._page.locator(selector)

    def text(self, selector):
        return self._page.locator(selector).inner_text()

    def box(self, selector):
        return self._page.locator(selector).bounding_box()

    def click_text(self, text, exact=False):
        self._page.get_by_text(text, exact=exact).first.click()

    def select(self, selector, value):
        self._page.locator(selector).select_option(value)

    def focus(self):
        self._page.locator("#view").focus()

    def fill_number(self, label, value):
        field = self._page.locator(f'input[aria-label="{label}"]').first
        field.fill(str(value))
        field.press("Enter")

    def set_slider(self, label, value):
        slider = self._page.locator(f'input[aria-label="{label}"]')
        slider.evaluate("(node, value) => { node.value = value; node.dispatchEvent(new Event('input')); }", value)

    def _pixel(self, place):
        u, v = self._page.evaluate("(place) => planner.view.toScreen(place)", [float(x) for x in place])
        box = self.box("#view")
        return box["x"] + u, box["y"] + v

    def press(self, place):
        self._page.mouse.move(*self._pixel(place))
        self._page.mouse.down()

    def move(self, place, steps=8):
        self._page.mouse.move(*self._pixel(place), steps=steps)

    def drag(self, start, end, steps=8):
        self.press(start)
        self.move(end, steps)
        self._page.mouse.up()


CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
"""Names of the browser's command."""


@pytest.fixture(scope="session")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api")
    command = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if command is None:
        pytest.skip("Chromium is not installed")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=command, args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def open_page(browser, server):
    contexts = []

    def opened():
        context = browser.new_context(viewport={"width": 1440, "height": 900}, accept_downloads=True)
        contexts.append(context)
        return Page(context.new_page(), server.url)

    yield opened
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def shared_page(open_page):
    return open_page()


@pytest.fixture
def page(shared_page, planner):
    """The page, which has nothing to complain about afterwards."""
    shared_page.complaints.clear()
    yield shared_page
    assert shared_page.complaints == []
