"""The time of the motions: a slider, and a button that lets it run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

PERIOD = 1 / 30
"""Time between two pictures of a motion that plays [s]."""


class Player:
    """A slider over the time of motions.

    Args:
        gui: viser's panel.
        label: what the slider shows, with its unit.
        end: the last time.
        rate: how much of the time passes in a second.
        changed: called with the time.

    Attributes:
        slider: the slider.
        button: plays and pauses.
    """

    def __init__(self, gui: Any, label: str, end: float, rate: float, changed: Callable[[float], None]) -> None:
        self._rate, self._changed = rate, changed
        self._running, self._closed = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self.slider = gui.add_slider(label, 0.0, max(end, 1e-3), max(end / 1000, 1e-4), 0.0)
        self.button = gui.add_button("Play")
        self.slider.on_update(lambda _: self._changed(float(self.slider.value)))
        self.button.on_click(lambda _: self.pause() if self._running.is_set() else self.play())

    @property
    def end(self) -> float:
        """The last time."""
        return float(self.slider.max)

    @end.setter
    def end(self, value: float) -> None:
        self.slider.value = 0.0
        self.slider.max, self.slider.step = max(value, 1e-3), max(value / 1000, 1e-4)

    def play(self) -> None:
        """Let the time run, again and again."""
        self._running.set()
        self.button.label = "Pause"
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="jtik view", daemon=True)
            self._thread.start()

    def pause(self) -> None:
        """Stop the time."""
        self._running.clear()
        self.button.label = "Play"

    def _run(self) -> None:
        while not self._closed.is_set():
            if not self._running.wait(0.2):
                continue
            before = time.monotonic()
            if self._closed.wait(PERIOD):
                break
            now = float(self.slider.value) + (time.monotonic() - before) * self._rate
            if self._running.is_set():
                self.slider.value = now if now <= self.end else 0.0

    def close(self) -> None:
        """End the thread."""
        self._closed.set()
        if self._thread is not None:
            self._thread.join()
