"""Joint commands as a ROS 2 message trajectory_msgs/JointTrajectory, and as YAML."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from jtik.types import Array


def message(
    joint_names: Sequence[str], times: Array, positions: Array, velocities: Array, accelerations: Array
) -> dict[str, Any]:
    """The fields of a message trajectory_msgs/JointTrajectory, as plain data.

    Args:
        joint_names: names of the n joints.
        times: (k,) [s].
        positions: (k, n) [rad] and [m].
        velocities: (k, n) [rad/s] and [m/s].
        accelerations: (k, n) [rad/s^2] and [m/s^2].
    """
    rows = zip(times.tolist(), positions.tolist(), velocities.tolist(), accelerations.tolist(), strict=True)
    points = [
        {
            "positions": q,
            "velocities": v,
            "accelerations": a,
            "effort": [],
            "time_from_start": _duration(time),
        }
        for time, q, v, a in rows
    ]
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "joint_names": list(joint_names), "points": points}


def as_yaml(value: Any, indent: str = "") -> str:
    """Mappings and lists of mappings as blocks, other lists on one line: what YAML 1.1 and 1.2 read alike."""
    if isinstance(value, Mapping):
        return "\n".join(f"{indent}{key}:{_nested(each, indent)}" for key, each in value.items())
    if value and isinstance(value, list) and isinstance(value[0], Mapping):
        return "\n".join(f"{indent}- {as_yaml(each, indent + '  ').lstrip()}" for each in value)
    return indent + _scalar(value)


def _nested(value: Any, indent: str) -> str:
    blocks = isinstance(value, Mapping) or (value and isinstance(value, list) and isinstance(value[0], Mapping))
    return "\n" + as_yaml(value, indent + "  ") if blocks else " " + _scalar(value)


def _scalar(value: Any) -> str:
    """A value on one line: YAML 1.1 takes 1e-05 for a text, so that a number with an exponent gets a point."""
    if isinstance(value, list):
        return f"[{', '.join(map(_scalar, value))}]"
    if isinstance(value, float):
        text = repr(value)
        return text if "." in text or "e" not in text else text.replace("e", ".0e")
    return json.dumps(value, ensure_ascii=not (isinstance(value, str) and value.isprintable()))


def _duration(time: float) -> dict[str, int]:
    """A builtin_interfaces/Duration."""
    total = round(time * 10**9)
    return {"sec": total // 10**9, "nanosec": total % 10**9}
