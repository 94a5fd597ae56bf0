"""Numbers for the joints of a robot that is not known yet: what can be checked without it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of
from jtik.types import Array

JointNumbers = ArrayLike | Mapping[str, ArrayLike]
"""One number for each entry of q, in any form of `Robot.joint_values`."""


def joint_numbers(argument: str, given: JointNumbers) -> Array | dict[str, Array]:
    """A copy of one number, of numbers, or of a dict by joint name. Raises ArgumentError where one is not finite."""
    return _read(argument, given, "finite numbers", np.isfinite)


def non_negative_joint_numbers(argument: str, given: JointNumbers) -> Array | dict[str, Array]:
    """The same; raises ArgumentError also where a number is negative."""
    return _read(argument, given, "non-negative numbers", lambda x: (x >= 0) & np.isfinite(x))


def positive_joint_numbers(argument: str, given: JointNumbers) -> Array | dict[str, Array]:
    """The same; raises ArgumentError also where a number is not positive."""
    return _read(argument, given, "positive numbers", lambda x: (x > 0) & np.isfinite(x))


def configuration_numbers(argument: str, given: JointNumbers) -> Array | dict[str, Array]:
    """A copy of a configuration: one number for each entry of q, or a dict. Raises ArgumentError for anything else."""
    return _read(argument, given, "finite numbers", np.isfinite, one=False)


def _read(
    argument: str, given: JointNumbers, numbers: str, valid: Callable[[Array], Any], *, one: bool = True
) -> Array | dict[str, Array]:
    if isinstance(given, Mapping):
        accepted = f"{numbers}: one, or one for each entry of the joint"
        return {
            joint: array_of(f"{argument}[{joint!r}]", each, [(), (None,)], accepted, valid)
            for joint, each in given.items()
        }
    accepted = f"{numbers}: {'one, ' if one else ''}one for each entry of the joints, or a dict by joint name"
    return array_of(argument, given, [(), (None,)] if one else [(None,)], accepted, valid)
