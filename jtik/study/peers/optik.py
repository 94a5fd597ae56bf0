"""optik as a contender: sequential quadratic programming in Rust from many starts."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from jtik.study.contender import Answer, PreparedContender
from jtik.study.peers.base import Goal, Peer
from jtik.types import Array


@dataclass(kw_only=True)
class OptikPeer(Peer):
    """``Robot.ik`` in its speed mode. It reports no iterations, and no configuration if it fails.

    The defaults are the best of a search over seven arms: pi and 2 pi for joints without limits, one and two threads,
    orientation weights 1, 0.5 and 0.25.

    Attributes:
        label: name of the library in a study.
        orientation_weight: weight of one radian relative to one metre.
        turn: limits -turn and turn of revolute joints without limits [rad].
        seconds: maximum time of a solve [s]; it has no limit on iterations.
        threads: number of threads for its starts.
    """

    label: str = "optik"
    orientation_weight: float = 0.5
    turn: float = 2 * math.pi
    seconds: float = 1.0
    threads: int = 1
    module: ClassVar[str] = "optik"
    package: ClassVar[str] = "optik-py"
    optimizes = False

    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """Build it on the chain from the base to the frame, as a URDF."""
        return _PreparedOptik(library, goal, self)


class _PreparedOptik(PreparedContender):
    """The solver of optik."""

    def __init__(self, library: Any, goal: Goal, options: OptikPeer) -> None:
        from jtik.interop.urdf import to_urdf

        setting, weight = goal.setting, options.orientation_weight
        self._goal, self._numbers = goal, list(goal.chain_indices)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "chain.urdf"
            file.write_text(to_urdf(goal.bare, revolute_limit=options.turn, frame=goal.frame), encoding="utf-8")
            self._robot = library.Robot.from_urdf_file(str(file), goal.robot.base, goal.frame)
        self._robot.set_parallelism(options.threads)
        self._lower, self._upper = map(np.array, self._robot.joint_limits())
        squares = [
            *([setting.position_tolerance**2] if goal.has_position else []),
            *([weight**2 * setting.orientation_tolerance**2] if goal.has_orientation else []),
        ]
        self._config = library.SolverConfig(
            solution_mode="speed",
            max_time=options.seconds,
            max_restarts=setting.restarts + 1,
            tol_f=min(squares),
            linear_weight=[1.0 if goal.has_position else 0.0] * 3,
            angular_weight=[weight if goal.has_orientation else 0.0] * 3,
        )

    def convert(self, target: Any) -> Any:
        """The pose as nested lists."""
        return self._goal.pose(target).tolist()

    def solve(self, target: Any, q0: Array) -> Answer:
        """Solve with ``ik``."""
        q = np.array(q0, dtype=float)
        start = np.clip(q[self._numbers], self._lower, self._upper)
        found = self._robot.ik(self._config, target, start.tolist())
        if found is None:
            return Answer(q, "NO_ANSWER", False)
        q[self._numbers] = found[0]
        return Answer(q, "REACHED", True)
