"""Waiting for what comes about in other threads and in a browser."""

from __future__ import annotations

import time

import numpy as np


def wait_for(condition, seconds=45.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.03)


def is_still(planner, seconds=0.15):
    """Whether the target stands still."""
    before = planner.loop.frame.position.copy()
    time.sleep(seconds)
    return np.array_equal(before, planner.loop.frame.position)
