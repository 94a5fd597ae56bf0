"""What a page is sent: what is new since the last time, texts as JSON and frames as numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Protocol

import numpy as np

from jtik.planner.files.sessions import Session
from jtik.planner.session.frames import Frame, plain

MODES = ("live", "playing", "scrubbing", "paused")
"""Modes of a frame, in the order of their numbers in a binary message."""


class Published(Protocol):
    """What a loop publishes."""

    @property
    def frame(self) -> Frame:
        """The arm at the moment."""

    @property
    def status(self) -> Any:
        """The state in words and figures."""

    @property
    def setup(self) -> Any:
        """What stays as it is."""

    @property
    def settings(self) -> Any:
        """What is set."""

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Former sessions that can be recovered."""

    @property
    def messages(self) -> Iterable[tuple[int, str, str]]:
        """The latest messages: number, level, text."""


class Outgoing:
    """What one page was sent, and what is new for it.

    Args:
        loop: the loop.
        rows: gives the rows of the table of attempts; another tuple when they have changed.
    """

    def __init__(self, loop: Published, rows: Callable[[], tuple[Mapping[str, Any], ...]]) -> None:
        self._loop, self._rows = loop, rows
        self._sent: dict[str, Any] = {}
        self._data = b""
        self._messages = max((number for number, _, _ in tuple(loop.messages)), default=0)
        self._answers: list[str] = []

    def answer(self, text: str) -> None:
        """Tell this page that a message of its own was refused."""
        self._answers.append(text)

    def news(self) -> Iterator[str | bytes]:
        """Messages with what is new: the setup first, which the others need."""
        loop = self._loop
        for kind in ("setup", "settings"):
            value = getattr(loop, kind)
            if value is not self._sent.get(kind):
                self._sent[kind] = value
                yield _text(kind, value.to_json())
        former = loop.sessions
        if former is not self._sent.get("sessions"):
            self._sent["sessions"] = former
            yield _text("sessions", {"sessions": [{"name": each.folder.name, "ended": each.ended} for each in former]})
        rows = self._rows()
        if rows is not self._sent.get("attempts"):
            self._sent["attempts"] = rows
            yield _text("attempts", {"attempts": rows})
        for number, level, text in tuple(loop.messages):
            if number > self._messages:
                self._messages = number
                yield _text("message", {"level": level, "text": text})
        answers, self._answers = self._answers, []
        for text in answers:
            yield _text("message", {"level": "error", "text": text})
        status = loop.status
        if status is not self._sent.get("status"):
            self._sent["status"] = status
            yield _text("status", status.to_json())
        frame = loop.frame
        if frame is not self._sent.get("frame"):
            self._sent["frame"] = frame
            data = encoded(frame)
            if data[8:] != self._data[8:]:  # tick and time alone are nothing new
                self._data = data
                yield data


def encoded(frame: Frame) -> bytes:
    """A frame as 32-bit floats.

    Returns:
        tick, time, mode, recording, d, nq, number of frames, time of the attempt shown or -1; the target, position (3,)
        and quaternion (4,); q (nq,); poses (frames, 7).
    """
    position = np.zeros(3)
    d = len(frame.position)
    position[:d] = frame.position
    shown = -1.0 if frame.shown is None else frame.shown[1]
    sizes = (d, len(frame.q), len(frame.poses))
    head = (frame.tick, frame.time, MODES.index(frame.mode), frame.recording, *sizes, shown)
    numbers = np.concatenate([np.array(head, float), position, frame.orientation, frame.q, np.ravel(frame.poses)])
    return numbers.astype("<f4").tobytes()


def _text(kind: str, fields: Mapping[str, Any]) -> str:
    return json.dumps({"type": kind, **plain(fields)}, separators=(",", ":"))
