"""The settings of a session as plain data, for attempts and files of plans, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from jtik.arguments import array_of, flag, mapping, non_negative_number
from jtik.errors import ArgumentError
from jtik.planner.edits.messages import SetCriteria, SetGain, SetStrategy, SetTargetSpeed
from jtik.planner.session.frames import plain
from jtik.planner.session.settings import joint_weights
from jtik.planner.session.state import State
from jtik.robot import Robot
from jtik.types import Array


def to_plain(state: State) -> dict[str, Any]:
    """Everything that is set but the obstacles."""
    wanted, values = state.wanted, state.values
    found: dict[str, Any] = plain(
        {
            "strategy": {"name": wanted.strategy, "options": wanted.options},
            "criteria": wanted.criteria,
            "joint_weights": wanted.joint_weights,
            "limits": wanted.limits,
            "clearance": wanted.clearance,
            "safe": values.safe,
            "preferred": values.preferred,
            "gains": values.gains,
            "target_speed": {"speed": state.target.speed, "rotation": state.target.rotation_speed},
        }
    )
    return found


@dataclass(frozen=True, eq=False)
class Restored:
    """Settings that were read from plain data; None for one that is not there.

    Attributes:
        strategy: the strategy.
        criteria: the criteria.
        joint_weights: weights of the velocity entries (n,).
        limits: whether the position limits hold.
        clearance: whether the clearance holds.
        safe: its smallest distance [m].
        preferred: preferred posture (nq,) [rad] and [m].
        gains: values of live parameters by name.
        target_speed: speed of the target.
    """

    strategy: SetStrategy | None
    criteria: SetCriteria | None
    joint_weights: tuple[float, ...] | None
    limits: bool | None
    clearance: bool | None
    safe: float | None
    preferred: Array | None
    gains: Mapping[str, Any] | None
    target_speed: SetTargetSpeed | None


def from_plain(data: object, robot: Robot) -> Restored:
    """The settings of `to_plain`. Raises ArgumentError for other data, naming the key."""
    given = mapping("settings", data, "the settings of a plan")
    known = tuple(each.name for each in fields(Restored))
    for key in given:
        if key not in known:
            raise ArgumentError(f"settings.{key}", given[key], f"one of {', '.join(known)}")
    preferred = given.get("preferred")
    if preferred is not None:
        accepted = f"{robot.nq} finite numbers"
        preferred = array_of("settings.preferred", preferred, [(robot.nq,)], accepted)
    weights = given.get("joint_weights")
    if weights is not None:
        weights = array_of("settings.joint_weights", weights, [(robot.n,)], f"{robot.n} positive numbers")
        weights = joint_weights(robot, weights)
    gains = given.get("gains")
    if gains is not None:
        gains = {name: _gain(name, value) for name, value in mapping("settings.gains", gains, "a mapping").items()}
    return Restored(
        strategy=_edit(SetStrategy, "strategy", given),
        criteria=SetCriteria(given["criteria"]) if "criteria" in given else None,
        joint_weights=weights,
        limits=_flag("limits", given),
        clearance=_flag("clearance", given),
        safe=non_negative_number("settings.safe", given["safe"]) if "safe" in given else None,
        preferred=preferred,
        gains=gains,
        target_speed=_edit(SetTargetSpeed, "target_speed", given),
    )


def _flag(key: str, given: Mapping[str, Any]) -> bool | None:
    return flag(f"settings.{key}", given[key]) if key in given else None


def _gain(name: str, value: object) -> Any:
    return np.array(SetGain(name, value).value)  # type: ignore[arg-type]  # which reads it


def _edit(kind: Any, key: str, given: Mapping[str, Any]) -> Any:
    if key not in given:
        return None
    found = mapping(f"settings.{key}", given[key], "a mapping")
    try:
        return kind(**found)
    except TypeError:
        raise ArgumentError(f"settings.{key}", found, f"the fields of {kind.__name__}") from None
