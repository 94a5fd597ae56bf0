"""Robots, tasks and their parts as plain data and back, for files without pickles.

Only the classes that this module lists are created from a file.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

import numpy as np

from jtik import geometry, task
from jtik.errors import JtikError
from jtik.robot import Joint, JointType, Robot
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.tree import Mimic

_OPTIONS = ("masses", "shapes", "keyframes")

_KINDS: tuple[type[Any], ...] = (
    *(each for each in vars(geometry).values() if isinstance(each, type) and issubclass(each, geometry.Solid)),
    *(each for each in vars(task).values() if isinstance(each, type) and issubclass(each, task.Task)),
    Joint,
    Mass,
    Mimic,
)

_CLASSES = {kind.__name__: kind for kind in _KINDS}


class DescriptionError(JtikError):
    """A value that cannot be described, or data that describes no value.

    Attributes:
        given: the value or the data.
    """

    def __init__(self, given: object) -> None:
        super().__init__(given)
        self.given = given

    def __str__(self) -> str:
        return f"no description for {self.given!r}"


def as_data(value: Any) -> Any:
    """A value as strings, numbers, lists and dicts. Raises DescriptionError for a class that is not jtik's."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (np.ndarray, np.generic)):
        return {"array": np.asarray(value).tolist(), "shape": list(np.shape(value))}
    if isinstance(value, JointType):
        return {"joint type": value.name}
    if isinstance(value, tuple):
        return {"tuple": [as_data(each) for each in value]}
    if isinstance(value, list):
        return [as_data(each) for each in value]
    if isinstance(value, dict):
        return {"dict": [[str(key), as_data(each)] for key, each in value.items()]}
    if isinstance(value, Robot):
        options = {name: as_data(dict(getattr(value, name))) for name in _OPTIONS}
        options["neutral"] = as_data(value.neutral)
        own = {"name": value.name, "planar": value.dimension == 2, "base": value.base, "tip": value.tip, **options}
        return {"robot": own, "joints": [as_data(joint) for joint in value.joints]}
    if _CLASSES.get(type(value).__name__) is type(value) and not isinstance(value, Enum):
        return {"class": type(value).__name__, "state": {name: as_data(each) for name, each in vars(value).items()}}
    raise DescriptionError(value)


def from_data(data: Any) -> Any:
    """The value that `as_data` described. Raises DescriptionError for other data."""
    if isinstance(data, list):
        return [from_data(each) for each in data]
    if not isinstance(data, dict):
        return data
    if "array" in data:
        array = np.array(data["array"], dtype=np.float64).reshape(data["shape"])
        array.flags.writeable = False
        return array
    if "joint type" in data:
        return JointType[data["joint type"]]
    if "tuple" in data:
        return tuple(from_data(each) for each in data["tuple"])
    if "dict" in data:
        return {key: from_data(each) for key, each in data["dict"]}
    if "robot" in data:
        options = {name: from_data(each) for name, each in data["robot"].items()}
        return Robot([from_data(joint) for joint in data["joints"]], **options)
    if data.get("class") in _CLASSES:
        instance = object.__new__(_CLASSES[data["class"]])
        for name, each in data["state"].items():
            object.__setattr__(instance, name, from_data(each))
        return instance
    raise DescriptionError(data)
