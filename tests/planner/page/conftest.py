"""A planner of the ten-link arm and its server, for the tests of the page."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from jtik.planner.history import History
from jtik.planner.planner import ten_links
from jtik.planner.server import Server


class Planned:
    def __init__(self):
        self.loop = ten_links()
        self.arm = self.loop._state.arm
        if not hasattr(self.loop, "history"):
            self.loop.history = History()

    def measures(self, attempt):
        return {}

    def findings(self, attempt):
        return []

    def exported(self, attempt, kind):
        return b""

    def plan_text(self):
        return "{}"

    def load_text(self, text):
        pass


@pytest.fixture(scope="module")
def planner():
    planned = Planned()
    planned.loop.start()
    yield planned
    planned.loop.close()


@pytest.fixture(scope="module")
def server(planner) -> Iterator[Server]:
    with Server(planner, port=0) as server:
        yield server
