"""Targets and starts on the command line: numbers, names, or ``@file``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jtik.cli.checks import InputError, read_text
from jtik.errors import UnknownNameError
from jtik.robot import Robot

COLUMNS = {9: 3, 12: 4, 16: 4}
"""Numbers of a matrix that is given row by row, and its columns."""

POSES = (7, 12, 16)
"""Numbers of a pose; a task without a kind then is one of the pose."""


def read_values(option: str, words: Sequence[str]) -> Any:
    """The values of an option: numbers, nested where they are those of a matrix, or what ``@file`` holds.

    Args:
        option: the option, for errors.
        words: its words: numbers, or one that starts with "@".

    Raises:
        InputError: for anything else.
    """
    if len(words) == 1 and words[0].startswith("@"):
        return _from_file(option, Path(words[0][1:]))
    return shaped([_number(option, word) for word in words])


def read_start(option: str, words: Sequence[str]) -> Any:
    """The values of an option as `read_values` gives them, or one name."""
    if len(words) == 1 and not words[0].startswith("@") and not _is_number(words[0]):
        return words[0]
    return read_values(option, words)


def start_of(robot: Robot, given: Any) -> Any:
    """The configuration to start from. Other values than a name are returned as they are.

    Args:
        robot: the robot.
        given: "home", "mid" for the middle of the limits (where a joint has none, its home), or a keyframe's name.

    Raises:
        UnknownNameError: for another name.
    """
    if not isinstance(given, str):
        return given
    if given == "home":
        return robot.home
    if given in robot.keyframes:
        return robot.keyframes[given]
    if given != "mid":
        raise UnknownNameError("start", given, dict.fromkeys(("home", "mid", *robot.keyframes)))
    limited = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    with np.errstate(invalid="ignore"):
        return np.where(limited, (robot.lower + robot.upper) / 2, robot.home)


def shaped(numbers: list[float]) -> list[Any]:
    """The numbers, as rows where they are those of a matrix."""
    columns = COLUMNS.get(len(numbers))
    return numbers if columns is None else [numbers[i : i + columns] for i in range(0, len(numbers), columns)]


def size(values: Any) -> int:
    """How many numbers there are; 0 for what is no list of numbers, or of rows of numbers."""
    if not isinstance(values, list):
        return 0
    return sum(len(row) if isinstance(row, list) else 1 for row in values)


def _from_file(option: str, path: Path) -> Any:
    """The numbers of a text, or the value of a ``.json``."""
    text = read_text(path)
    if path.suffix.lower() == ".json":
        try:
            return json.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}: not valid JSON: {error}") from None
    lines = [line.partition("#")[0] for line in text.splitlines()]
    words = " ".join(lines).translate(str.maketrans(",;[]", "    ")).split()
    return shaped([_number(f"{option} {path}", word) for word in words])


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _number(where: str, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        shown = word if len(word) < 40 else f"{word[:40]}..."
        raise InputError(f"{where}: given {shown!r}; accepted: numbers, or @FILE with numbers") from None
