"""Levels of priority: two for ten links, three for a humanoid, each level a program with limits in it, DAQP.

Ten links bring their tip to one target and, as far as that allows, their middle to another. TALOS on a free base keeps
its feet where they are, below that brings its centre of mass to a target, below that its hands. Beside them mink's step
of a Panda, one level of weighted tasks, as in qp_step.py. All in closed loop, in one process and interleaved.

    python benchmarks/levels.py [--scenes met missed hurried humanoid] [--code C machine] [--cpu]

The humanoid takes example-robot-data and, as its judge, Pinocchio; and some minutes of a C compiler, once.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import qp_step  # sets the numbers of threads, so before NumPy
from clearances import CODES, HOME, LENGTH, LINKS, Step, along, bare, points, stepping
from qp_step import DT, Clock, add_times, write_json

# isort: split
import numpy as np

import jtik
from jtik_formulations import JointCentering, LexicographicQP

Array = np.ndarray
PLACES = 50
"""Targets on a path."""
MIDDLE = "link6"
"""The frame half-way along the arm."""
ACCURACY = 1e-6
"""How near [rad] a joint is at its limit, or how far beyond it may be."""
MINK = "mink (DAQP), Panda, one level"

Judge = Callable[[Array, Any], "list[float]"]
"""(q, target) -> what is left of the error of each level [mm], for a pose with its angle as a metre a radian."""


@dataclass(frozen=True)
class Scene:
    """A robot, its tasks with their levels, a closed path of targets and who judges."""

    robot: jtik.Robot
    tasks: list[jtik.Task]
    home: Array
    path: list[Any]
    judge: Judge

    def solver(self, code: str, *, posture: bool) -> jtik.InverseKinematics:
        """The problem as jtik has it, with or without a posture to prefer below all levels."""
        ik = jtik.InverseKinematics(
            self.robot,
            self.tasks,
            criteria=JointCentering() if posture else None,
            strategy=LexicographicQP(),
            joints="all",
            compiled=code == "C",
        )
        if posture:
            ik.parameters["joint_centering.preferred"] = self.home[ik.robot.scalar_q]
        return ik


@dataclass(frozen=True)
class Row:
    """Figures of one way to step.

    Attributes: times [us]; what a step leaves of each level's error, median [mm]; farthest beyond a limit [rad]; the
    share of steps with a joint at a limit; why there are no figures.
    """

    name: str
    median: float = math.nan
    p10: float = math.nan
    p90: float = math.nan
    left: tuple[float, ...] = ()
    beyond: float = math.nan
    active: float = math.nan
    missing: str = ""


def ten_links(*, apart: float = 0.0, speed: float = 2.0) -> Scene:
    """Tip and middle of a motion of all joints, the middle's targets ``apart`` [m] from there; at a speed [rad/s]."""
    robot = jtik.Robot.planar([LENGTH] * LINKS, lower=-2.0, upper=2.0, velocity_limit=speed)
    phase = np.random.default_rng(0).uniform(0, 2 * np.pi, LINKS)
    path = []
    for angle in np.linspace(0, 2 * np.pi, PLACES, endpoint=False):
        ends = points(HOME + 0.2 * (np.sin(angle + phase) - np.sin(phase)))
        path.append({"tip": ends[-1], "middle": ends[LINKS // 2] + (0.0, apart)})

    def judge(q: Array, target: dict[str, Array]) -> list[float]:
        ends = points(q)
        places = {"tip": ends[-1], "middle": ends[LINKS // 2]}
        return [1e3 * float(np.linalg.norm(places[name] - target[name])) for name in places]

    tasks = [jtik.FrameTask(name="tip"), jtik.FrameTask(MIDDLE, name="middle", priority=1)]
    return Scene(robot, tasks, HOME, path, judge)


FEET = {"left foot": "left_sole_link", "right foot": "right_sole_link"}
HANDS = {"left hand": "gripper_left_base_link", "right hand": "gripper_right_base_link"}
BENT = {
    **{f"leg_{side}_{k}_joint": angle for side in ("left", "right") for k, angle in ((3, -0.4), (4, 0.8), (5, -0.4))},
    **{"arm_left_2_joint": 0.4, "arm_right_2_joint": -0.4, "arm_left_4_joint": -1.2, "arm_right_4_joint": -1.2},
}
"""Knees and elbows [rad]."""


def humanoid() -> Scene:
    """TALOS sways over its feet, and its hands draw circles."""
    import pinocchio as pin

    package = metadata.distribution("example-robot-data")
    file = next(Path(package.locate_file(path)) for path in package.files or () if path.name == "talos_reduced.urdf")
    robot = jtik.Robot.from_urdf(file, free_base=True)
    model = pin.buildModelFromUrdf(str(file), pin.JointModelFreeFlyer())
    data = model.createData()
    places = [model.joints[model.getJointId(name)].idx_q for name in robot.joint_names[1:]]
    frames = FEET | HANDS
    home = robot.neutral.copy()
    for joint, angle in BENT.items():
        home[robot.q_slice(joint)] = angle
    home = np.clip(home, robot.lower, robot.upper)

    def seen(q: Array) -> dict[str, Array]:
        theirs = np.zeros(model.nq)
        x, y, z, *turn = q[robot.q_slice("free_base")]
        theirs[:7], theirs[places] = [x, y, z, *np.roll(turn, -1)], q[7:]
        pin.framesForwardKinematics(model, data, theirs)
        found = {name: data.oMf[model.getFrameId(frame)].homogeneous for name, frame in frames.items()}
        return found | {"center_of_mass": pin.centerOfMass(model, data, theirs).copy()}

    still, path = seen(home), []
    for angle in np.linspace(0, 2 * np.pi, PLACES, endpoint=False):
        target = {name: still[name] for name in FEET}
        target["center_of_mass"] = still["center_of_mass"] + (0.0, 0.02 * np.sin(angle), 0.02 * (np.cos(angle) - 1))
        for name in HANDS:
            target[name] = still[name][:3, 3] + (0.05 * np.sin(angle), 0.0, 0.05 * (1 - np.cos(angle)))
        path.append(target)

    def judge(q: Array, target: dict[str, Array]) -> list[float]:
        found = seen(q)
        feet = [pin.log6(pin.SE3(target[name]).actInv(pin.SE3(found[name]))).vector for name in FEET]
        hands = [found[name][:3, 3] - target[name] for name in HANDS]
        mass = found["center_of_mass"] - target["center_of_mass"]
        return [1e3 * float(np.linalg.norm(each)) for each in (np.concatenate(feet), mass, np.concatenate(hands))]

    tasks = [
        *(jtik.FrameTask(frame, "pose", name=name) for name, frame in FEET.items()),
        jtik.CenterOfMassTask(priority=1),
        *(jtik.FrameTask(frame, name=name, priority=2) for name, frame in HANDS.items()),
    ]
    return Scene(robot, tasks, home, path, judge)


SCENES: dict[str, tuple[str, Callable[[], Scene]]] = {
    "met": ("ten links, two levels met", ten_links),
    "missed": ("ten links, second level missed", lambda: ten_links(apart=0.2)),
    "hurried": ("ten links, speeds at their limits", lambda: ten_links(speed=0.6)),
    "humanoid": ("TALOS, three levels", humanoid),
}


def judged(name: str, scene: Scene, step: Step) -> Row:
    """What a step leaves of each level, the second time round; limits, all the time."""
    robot, q, left, over = scene.robot, scene.home, [], []
    scalar_q, scalar_v = robot.scalar_q, robot.scalar_v
    for i, target in enumerate([*scene.path, *scene.path]):
        after = step(q, target)
        assert after is not None
        dq = after[scalar_q] - q[scalar_q]
        lower, upper = robot.lower[scalar_q], robot.upper[scalar_q]
        beyond = (after[scalar_q] - upper, lower - after[scalar_q], abs(dq) - DT * robot.velocity_limit[scalar_v])
        q = after
        over.append(float(np.max(beyond)))
        if i >= len(scene.path):
            left.append(scene.judge(q, target))
    return Row(
        name,
        left=tuple(np.median(left, axis=0).tolist()),
        beyond=max(*over, 0.0),
        active=float(np.mean(np.array(over[len(scene.path) :]) > -ACCURACY)),
    )


def panda() -> tuple[Step, Array, list[Any]]:
    """mink's step of qp_step.py: path and settings are its own."""
    given = jtik.Robot.builtin("panda")
    robot = jtik.Robot.from_urdf(qp_step.urdf(given), tip=given.tip)
    path = qp_step.Path.tracked(robot, given.keyframes["home"])
    move = qp_step.minks(robot, path)
    return (lambda q, target: q + move(q, target)), path.q[0], path.targets


def main() -> None:
    """Build, judge, time, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40, help="rounds (default %(default)s)")
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--code", nargs="+", choices=CODES, default=list(CODES), help="what evaluates jtik's step")
    parser.add_argument("--posture", action="store_true", help="also with a posture below all levels")
    parser.add_argument("--cpu", action="store_true", help="processor time in place of time: for a busy machine")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE")
    arguments = parser.parse_args()
    if arguments.repeats < 1:
        parser.error("--repeats must be at least 1")

    clock: Clock = time.thread_time if arguments.cpu else time.perf_counter
    rows: dict[str, Row] = {}
    timers: dict[str, Callable[[], float]] = {}
    for title, build in (SCENES[name] for name in arguments.scenes):
        try:
            scene = build()
        except (ImportError, metadata.PackageNotFoundError) as error:
            rows[title] = Row(title, missing=f"not installed: {error}")
            continue
        for code in arguments.code:
            for posture in (False, True)[: 1 + arguments.posture]:
                name = f"{title}{' and a posture' if posture else ''}, {code}"
                ik = scene.solver(code, posture=posture)
                rows[f"{name}, ik.step"] = judged(f"{name}, ik.step", scene, stepping(ik))
                timers[f"{name}, ik.step"] = along(stepping(ik), scene.home, scene.path, clock)
                timers[f"{name}, fused"] = bare(ik, scene.home, scene.path, clock)
    try:
        timers[MINK] = along(*panda(), clock)
    except ImportError as error:
        rows[MINK] = Row(MINK, missing=f"not installed: {error}")

    add_times(rows, timers, arguments.repeats, Row)
    show(list(rows.values()))
    if arguments.json:
        write_json(list(rows.values()), arguments)


def show(rows: list[Row]) -> None:
    """A table with ratios to mink's step."""
    mink = {row.name: row.median for row in rows}.get(MINK, math.nan)
    width = max(len(row.name) for row in rows)
    print(f"{'':{width}}  median [us]     10 %     90 %  mink /  at limits  beyond  left of each level [mm]")
    for row in rows:
        if row.missing:
            print(f"{row.name:{width}}  {row.missing}")
            continue
        kept = ""
        if row.left:
            kept = f"  {row.active:9.0%}  {row.beyond if row.beyond > ACCURACY else 0:6.0e}  "
            kept += ", ".join(f"{each:.2g}" for each in row.left)
        print(f"{row.name:{width}}  {row.median:11.2f}  {row.p10:7.2f}  {row.p90:7.2f}  {mink / row.median:6.2f}{kept}")


if __name__ == "__main__":
    sys.exit(main())
