"""Priority levels: two for ten links, three for a humanoid, each a quadratic program with limits, DAQP.

Ten links move their tip to one target and, with lower priority, their middle to another. TALOS on a free base keeps its
feet fixed, with lower priority moves its centre of mass to a target, and with the lowest priority its hands. The
reference is mink's step of a Panda with one level of weighted tasks, as in qp_step.py. All run in closed loop, in one
process and interleaved.

    python benchmarks/levels.py [--scenes compatible conflicting saturated humanoid] [--code C machine] [--cpu]

The humanoid needs example-robot-data, and Pinocchio for the check. The first run compiles C for some minutes.
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

import qp_step  # sets the number of threads, so it is imported before NumPy
from clearances import CODES, HOME, LENGTH, LINKS, Step, lap_time, points, step_alone, stepping
from qp_step import DT, Clock, add_times, write_json

# isort: split
import numpy as np

import jtik
from jtik_formulations import JointCentering, LexicographicQP

Array = np.ndarray
TARGETS = 50
"""Number of targets on a path."""
MIDDLE = "link6"
"""The frame in the middle of the arm."""
ACCURACY = 1e-6
"""Distance to a limit within which a joint is at the limit, and allowed violation [rad]."""
MINK = "mink (DAQP), Panda, one level"

Errors = Callable[[Array, Any], "list[float]"]
"""(q, target) -> norm of the error of each level [mm], where one radian counts as one metre."""


@dataclass(frozen=True)
class Scene:
    """A robot with tasks at several levels, and a closed path.

    Attributes:
        robot: the robot.
        tasks: the tasks with their priorities.
        home: start of the path, and preferred posture.
        path: targets.
        errors: independent evaluation of the errors.
    """

    robot: jtik.Robot
    tasks: list[jtik.Task]
    home: Array
    path: list[Any]
    errors: Errors

    def solver(self, code: str, *, posture: bool) -> jtik.InverseKinematics:
        """The problem for jtik, with or without a preferred posture below all levels."""
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
    """Figures of one kind of step.

    Attributes:
        name: name of the row.
        median: median time [us].
        p10: tenth percentile of the time [us].
        p90: ninetieth percentile of the time [us].
        left: median remaining error of each level after a step [mm].
        beyond: largest violation of a limit [rad].
        active: share of steps with a joint at a limit.
        missing: why there are no figures.
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
    """Targets of tip and middle from a motion of all joints; ``apart`` offsets the middle [m], ``speed`` is [rad/s]."""
    robot = jtik.Robot.planar([LENGTH] * LINKS, lower=-2.0, upper=2.0, velocity_limit=speed)
    phase = np.random.default_rng(0).uniform(0, 2 * np.pi, LINKS)
    path = []
    for angle in np.linspace(0, 2 * np.pi, TARGETS, endpoint=False):
        ends = points(HOME + 0.2 * (np.sin(angle + phase) - np.sin(phase)))
        path.append({"tip": ends[-1], "middle": ends[LINKS // 2] + (0.0, apart)})

    def errors(q: Array, target: dict[str, Array]) -> list[float]:
        ends = points(q)
        places = {"tip": ends[-1], "middle": ends[LINKS // 2]}
        return [1e3 * float(np.linalg.norm(places[name] - target[name])) for name in places]

    tasks = [jtik.FrameTask(name="tip"), jtik.FrameTask(MIDDLE, name="middle", priority=1)]
    return Scene(robot, tasks, HOME, path, errors)


FEET = {"left foot": "left_sole_link", "right foot": "right_sole_link"}
HANDS = {"left hand": "gripper_left_base_link", "right hand": "gripper_right_base_link"}
HOME_ANGLES = {
    **{f"leg_{side}_{k}_joint": angle for side in ("left", "right") for k, angle in ((3, -0.4), (4, 0.8), (5, -0.4))},
    **{"arm_left_2_joint": 0.4, "arm_right_2_joint": -0.4, "arm_left_4_joint": -1.2, "arm_right_4_joint": -1.2},
}
"""Angles of hips, knees, ankles, shoulders and elbows at home [rad]."""


def humanoid() -> Scene:
    """TALOS moves its centre of mass over its feet, and its hands along circles."""
    import pinocchio as pin

    package = metadata.distribution("example-robot-data")
    file = next(Path(package.locate_file(path)) for path in package.files or () if path.name == "talos_reduced.urdf")
    robot = jtik.Robot.from_urdf(file, free_base=True)
    model = pin.buildModelFromUrdf(str(file), pin.JointModelFreeFlyer())
    data = model.createData()
    places = [model.joints[model.getJointId(name)].idx_q for name in robot.joint_names[1:]]
    frames = FEET | HANDS
    home = robot.neutral.copy()
    for joint, angle in HOME_ANGLES.items():
        home[robot.q_slice(joint)] = angle
    home = np.clip(home, robot.lower, robot.upper)

    def frame_poses(q: Array) -> dict[str, Array]:
        pinocchio_q = np.zeros(model.nq)
        x, y, z, *quaternion = q[robot.q_slice("free_base")]
        pinocchio_q[:7], pinocchio_q[places] = [x, y, z, *np.roll(quaternion, -1)], q[7:]
        pin.framesForwardKinematics(model, data, pinocchio_q)
        found = {name: data.oMf[model.getFrameId(frame)].homogeneous for name, frame in frames.items()}
        return found | {"center_of_mass": pin.centerOfMass(model, data, pinocchio_q).copy()}

    initial, path = frame_poses(home), []
    for angle in np.linspace(0, 2 * np.pi, TARGETS, endpoint=False):
        target = {name: initial[name] for name in FEET}
        target["center_of_mass"] = initial["center_of_mass"] + (0.0, 0.02 * np.sin(angle), 0.02 * (np.cos(angle) - 1))
        for name in HANDS:
            target[name] = initial[name][:3, 3] + (0.05 * np.sin(angle), 0.0, 0.05 * (1 - np.cos(angle)))
        path.append(target)

    def errors(q: Array, target: dict[str, Array]) -> list[float]:
        found = frame_poses(q)
        feet = [pin.log6(pin.SE3(target[name]).actInv(pin.SE3(found[name]))).vector for name in FEET]
        hands = [found[name][:3, 3] - target[name] for name in HANDS]
        mass = found["center_of_mass"] - target["center_of_mass"]
        return [1e3 * float(np.linalg.norm(each)) for each in (np.concatenate(feet), mass, np.concatenate(hands))]

    tasks = [
        *(jtik.FrameTask(frame, "pose", name=name) for name, frame in FEET.items()),
        jtik.CenterOfMassTask(priority=1),
        *(jtik.FrameTask(frame, name=name, priority=2) for name, frame in HANDS.items()),
    ]
    return Scene(robot, tasks, home, path, errors)


SCENES: dict[str, tuple[str, Callable[[], Scene]]] = {
    "compatible": ("ten links, two compatible levels", ten_links),
    "conflicting": ("ten links, two conflicting levels", lambda: ten_links(apart=0.2)),
    "saturated": ("ten links, saturated velocities", lambda: ten_links(speed=0.6)),
    "humanoid": ("TALOS, three levels", humanoid),
}


def checked(name: str, scene: Scene, step: Step) -> Row:
    """Run two laps: remaining errors of the second, and violations of limits in both."""
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
            left.append(scene.errors(q, target))
    return Row(
        name,
        left=tuple(np.median(left, axis=0).tolist()),
        beyond=max(*over, 0.0),
        active=float(np.mean(np.array(over[len(scene.path) :]) > -ACCURACY)),
    )


def panda() -> tuple[Step, Array, list[Any]]:
    """mink's step of qp_step.py, with its path and settings."""
    given = jtik.Robot.builtin("panda")
    robot = jtik.Robot.from_urdf(qp_step.urdf(given), tip=given.tip)
    path = qp_step.Path.tracked(robot, given.keyframes["home"])
    displacement = qp_step.minks(robot, path)
    return (lambda q, target: q + displacement(q, target)), path.q[0], path.targets


def main() -> None:
    """Build, check, time and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40, help="rounds (default %(default)s)")
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument(
        "--code",
        nargs="+",
        choices=CODES,
        default=list(CODES),
        help="evaluation of jtik's step: generated C or virtual machine",
    )
    parser.add_argument("--posture", action="store_true", help="also with a posture below all levels")
    parser.add_argument("--cpu", action="store_true", help="processor time instead of wall time, for a busy machine")
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
                rows[f"{name}, ik.step"] = checked(f"{name}, ik.step", scene, stepping(ik))
                timers[f"{name}, ik.step"] = lap_time(stepping(ik), scene.home, scene.path, clock)
                timers[f"{name}, fused"] = step_alone(ik, scene.home, scene.path, clock)
    try:
        timers[MINK] = lap_time(*panda(), clock)
    except ImportError as error:
        rows[MINK] = Row(MINK, missing=f"not installed: {error}")

    add_times(rows, timers, arguments.repeats, Row)
    show(list(rows.values()))
    if arguments.json:
        write_json(list(rows.values()), arguments)


def show(rows: list[Row]) -> None:
    """Print a table with ratios to mink's step."""
    mink = {row.name: row.median for row in rows}.get(MINK, math.nan)
    width = max(len(row.name) for row in rows)
    print(f"{'':{width}}  median [us]     10 %     90 %  mink /  at limits  beyond  error of each level [mm]")
    for row in rows:
        if row.missing:
            print(f"{row.name:{width}}  {row.missing}")
            continue
        extra = ""
        if row.left:
            extra = f"  {row.active:9.0%}  {row.beyond if row.beyond > ACCURACY else 0:6.0e}  "
            extra += ", ".join(f"{each:.2g}" for each in row.left)
        print(
            f"{row.name:{width}}  {row.median:11.2f}  {row.p10:7.2f}  {row.p90:7.2f}  {mink / row.median:6.2f}{extra}"
        )


if __name__ == "__main__":
    sys.exit(main())
