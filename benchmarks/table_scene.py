"""A Panda over a table, with a wall, a box and its own body: which of rows and costs keeps it off them?

Random goals above the table, the tool pointing down, each solved from one start. MuJoCo measures the distances between
the capsules of the arm, and between them and the scene, at the end of each solve and at points of each accepted step.
No time is measured.

    python benchmarks/table_scene.py                    # 100 goals
    python benchmarks/table_scene.py --goals 10 --only rows costs
    python benchmarks/table_scene.py --restarts 20      # other starts, too; then only the ends count
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import jtik
from jtik.interop.mujoco_model import MujocoCorrespondence, to_mujoco
from jtik_formulations import ObstacleBarrier, SelfCollision

SAFE = 0.005
"""Distance [m] that the rows keep."""

TOP = 0.07
"""Height of the table top [m]."""

SCENE = jtik.Scene(
    {
        "table": jtik.Box.at([0.65, 0.0, TOP - 0.02], [0.4, 0.7, 0.02]),
        "wall": jtik.HalfSpace([0.0, 0.6, 0.0], [0.0, -1.0, 0.0]),
        "box": jtik.Box.at([0.5, -0.15, TOP + 0.12], [0.08, 0.1, 0.12]),
    }
)

MARGIN = 0.004
"""How far above that the rows aim [m]: a goal closer than both together is not reached."""

SLOTS = {"box": 2, "half_space": 1}
"""Slots for obstacles: those of the scene, no others."""

ROWS = ("neither", "costs", "rows", "rows and costs")

TOLERANCE = 1e-5
"""Largest error of a goal that counts as reached [m] and [rad]."""

SHARES = np.linspace(0.0, 1.0, 6)[1:]
"""Points of a step at which distances are measured."""


class Judge:
    """The smallest distance between the capsules of a robot, and from those to the scene, by MuJoCo."""

    def __init__(self, robot: jtik.Robot, scene: jtik.Scene) -> None:
        self.model = to_mujoco(robot, obstacles=scene)
        self.data = mujoco.MjData(self.model)
        self.match = MujocoCorrespondence(robot, self.model)
        numbers = {self.model.geom(i).name: i for i in range(self.model.ngeom)}
        geoms = {}
        for frame, solids in robot.shapes.items():
            for i in range(len(solids)):
                geoms[f"{frame}[{i}]" if len(solids) > 1 else frame] = numbers[f"{frame} solid{i}"]
        own = [(geoms[pair.first], geoms[pair.second]) for pair in robot.collision_pairs()]
        still = geoms["panda_link0"]  # stands beside the table
        scenery = [(i, numbers[f"obstacle{k}"]) for i in geoms.values() for k in range(len(scene)) if i != still]
        self.pairs = own + scenery

    def distance(self, q: Any) -> float:
        """The smallest distance of all pairs at a configuration [m]."""
        self.data.qpos[:] = self.match.qpos(q)
        mujoco.mj_kinematics(self.model, self.data)
        return min(mujoco.mj_geomDistance(self.model, self.data, i, j, 10.0, None) for i, j in self.pairs)

    def on_the_way(self, trace: jtik.Trace) -> float:
        """The smallest distance at points of every accepted step [m]."""
        smallest = np.inf
        for start, end in zip(trace.q[:-1], trace.q[1:], strict=True):
            if not np.array_equal(start, end):
                smallest = min(smallest, *(self.distance(start + share * (end - start)) for share in SHARES))
        return float(smallest)


def solver(row: str) -> jtik.InverseKinematics:
    """The solver of a row of the table."""
    criteria, clearances = None, None
    if "costs" in row:
        criteria = [ObstacleBarrier(SCENE, bodies="shapes", influence=0.1, capacity=SLOTS), SelfCollision(gain=10.0)]
    if "rows" in row:
        scenery = ObstacleBarrier(SCENE, bodies="shapes", capacity=SLOTS)
        clearances = [
            jtik.Clearance(scenery, safe=SAFE, margin=MARGIN, name="scene"),
            jtik.Clearance(SelfCollision(), safe=SAFE, margin=MARGIN, name="body"),
        ]
    panda = jtik.Robot.builtin("panda")
    return jtik.InverseKinematics(
        panda, jtik.FrameTask("tip", kind="pose"), strategy="hybrid+qp", criteria=criteria, clearances=clearances
    )


def goals(count: int, seed: int = 1) -> Iterator[Any]:
    """Poses (4, 4) above the table, the tool down, turned by any angle, its hand at least 1 cm from the scene."""
    rng, robot = np.random.default_rng(seed), jtik.Robot.builtin("panda")
    hand = Hand(robot)
    while count:
        x, y, z, turn = rng.uniform([0.3, -0.45, TOP + 0.02, -np.pi], [0.7, 0.5, TOP + 0.45, np.pi])
        pose = np.eye(4)
        pose[:3, :3] = [[np.cos(turn), np.sin(turn), 0], [np.sin(turn), -np.cos(turn), 0], [0, 0, -1]]
        pose[:3, 3] = x, y, z
        if hand.distance(pose) > 2 * SAFE:
            count -= 1
            yield pose


class Hand:
    """The distance of the hand alone, which a goal determines, to the scene."""

    def __init__(self, robot: jtik.Robot) -> None:
        hand = robot.shapes["panda_hand"]
        self.offset = np.linalg.inv(robot.pose(robot.home)) @ robot.pose(robot.home, "panda_hand")
        free = jtik.robot.Joint("free", jtik.JointType.FREE, "base", "panda_hand")
        self.body = jtik.Robot([free], shapes={"panda_hand": hand})
        self.model = to_mujoco(self.body, obstacles=SCENE)
        self.data = mujoco.MjData(self.model)

    def distance(self, tip: Any) -> float:
        """The smallest distance for a pose of the tip [m]."""
        pose = tip @ self.offset
        self.data.qpos[:3] = pose[:3, 3]
        mujoco.mju_mat2Quat(self.data.qpos[3:], pose[:3, :3].ravel())
        mujoco.mj_kinematics(self.model, self.data)
        own, scenery = range(2), range(2, self.model.ngeom)
        return min(mujoco.mj_geomDistance(self.model, self.data, i, k, 10.0, None) for i in own for k in scenery)


@dataclass(frozen=True)
class Outcome:
    """One solve: whether the goal is reached, and the distances at its end and on the way [m]."""

    reached: bool
    end: float
    way: float
    status: str


def measure(row: str, poses: Sequence[Any], restarts: int) -> list[Outcome]:
    """The outcome for each goal."""
    ik = solver(row)
    judge, found = Judge(ik.robot, SCENE), []
    for pose in poses:
        s = ik.solve(pose, q0=ik.robot.home, trace=not restarts, restarts=restarts, seed=0)
        reached = max(s.position_error or 0.0, s.orientation_error or 0.0) < TOLERANCE
        way = np.inf if s.trace is None else judge.on_the_way(s.trace)
        found.append(Outcome(reached, judge.distance(s.q), way, str(s.status)))
    return found


def table(results: dict[str, list[Outcome]], restarts: int) -> list[str]:
    """The table in Markdown."""
    names = ("", "reached", "in collision there", "through something on the way", "smallest distance", "on the way")
    head = "| " + " | ".join(names) + " |"
    lines = [head, "|" + " --- |" * len(names)]
    for row, outcomes in results.items():
        ended = [each for each in outcomes if each.reached]
        end = min((each.end for each in ended), default=np.inf)
        way = min((each.way for each in outcomes), default=np.inf)
        through = sum(each.way < 0 for each in outcomes)
        cells = [row, len(ended), sum(each.end < 0 for each in ended)]
        cells += (
            ["", f"{1e3 * end:.1f} mm", ""] if restarts else [through, f"{1e3 * end:.1f} mm", f"{1e3 * way:.1f} mm"]
        )
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--goals", type=int, default=100)
    parser.add_argument("--restarts", type=int, default=0)
    parser.add_argument("--only", nargs="+", choices=ROWS, default=ROWS)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    poses = list(goals(options.goals))
    results = {row: measure(row, poses, options.restarts) for row in options.only}
    print("\n".join(table(results, options.restarts)))
    if options.json:
        kept = {row: [asdict(each) for each in outcomes] for row, outcomes in results.items()}
        options.json.write_text(json.dumps(kept, indent=1))


if __name__ == "__main__":
    main()
