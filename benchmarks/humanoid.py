"""Humanoids whose target of the centre of mass drops: where they settle, and how quietly, beside pink.

The feet and the right wrist are to stay where they are. The weights of feet and centre of mass are those of pink's
examples: humanoid_g1_com.py for the Unitree G1, humanoid_jvrc_com.py for TALOS. The wrist weighs as a foot. pink
and jtik solve the same problem, with the same limits, in the same run; all errors are evaluated by Pinocchio.

    python benchmarks/humanoid.py [--scenes g1 talos talos_straight] [--strategies hybrid] [--acceleration 100]

It needs Pinocchio and example-robot-data; without pink there are no rows of pink.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import json
import logging
import math
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pinocchio as pin

import jtik
from jtik_formulations import JointCentering, WeightedQP

Array = np.ndarray
DROP = 0.15
"""How far the target of the centre of mass drops, at once [m]."""
DT = 0.005
"""Time of a step, as in pink's examples [s]."""
SECONDS = 4.0
"""Length of a run; its last second is judged [s]."""
GAINS = (1.0, 0.5)
"""Shares of the distance to a position limit that a step may use."""
BENT = {f"leg_{side}_{k}_joint": angle for side in ("left", "right") for k, angle in ((3, -0.45), (4, 0.9), (5, -0.45))}
STRATEGIES = ("as pink", "weighted_qp", "hybrid", "damped", "sns", "lexicographic_qp", "task_priority")
LEVELS = ("lexicographic_qp", "task_priority")
"""Strategies for which the feet have priority over the wrist and the centre of mass."""


@dataclass(frozen=True)
class Scene:
    """A humanoid, its start and the costs of its tasks, in the words of pink.

    Attributes:
        urdf: name of its file in example-robot-data.
        feet: frames of the feet.
        wrist: frame of the wrist.
        position: cost of positions of feet and wrist [1 / m].
        orientation: cost of their orientations [1 / rad].
        mass: cost of the centre of mass [1 / m].
        posture: cost of the posture [1 / rad].
        damping: damping of pink's QP.
        bent: positions of joints at the start, where they are not zero [rad].
    """

    urdf: str
    feet: tuple[str, str]
    wrist: str
    position: float
    orientation: float
    mass: float
    posture: float
    damping: float
    bent: dict[str, float]


TALOS = Scene(
    urdf="talos_full_v2.urdf",
    feet=("left_sole_link", "right_sole_link"),
    wrist="gripper_right_base_link",
    position=1.0,
    orientation=3.0,
    mass=2.0,
    posture=0.01,
    damping=1e-12,
    bent={},
)
SCENES = {
    "g1": Scene(
        urdf="g1_29dof_rev_1_0.urdf",
        feet=("left_ankle_roll_link", "right_ankle_roll_link"),
        wrist="right_wrist_yaw_link",
        position=200.0,
        orientation=10.0,
        mass=200.0,
        posture=0.1,
        damping=0.01,
        bent={},
    ),
    "talos": Scene(**{**asdict(TALOS), "bent": {**BENT, "arm_left_4_joint": -1.2, "arm_right_4_joint": -1.2}}),
    "talos_straight": TALOS,
}


@dataclass(frozen=True)
class Row:
    """Figures of the last second of a run.

    Attributes:
        scene: name of the scene.
        solver: what solved it, "pink" or a strategy of jtik.
        gain: share of the distance to a position limit that a step may use.
        foot: largest position error of a foot [mm].
        wrist: largest position error of the wrist [mm].
        mass: largest error of the centre of mass [mm].
        rms: root mean square of the joint accelerations [rad/s^2].
        largest: largest joint acceleration [rad/s^2].
        rms_of_all: root mean square over the run [rad/s^2].
        accepted: share of accepted steps of the run.
    """

    scene: str
    solver: str
    gain: float
    foot: float
    wrist: float
    mass: float
    rms: float
    largest: float
    rms_of_all: float
    accepted: float = math.nan


class Humanoid:
    """A scene in Pinocchio, which judges.

    Attributes:
        model: the model.
        start: the start (nq,), quaternions in Pinocchio's order.
        poses: targets of feet and wrist.
        mass: target of the centre of mass.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.path = scene, _file(scene.urdf)
        self.model = pin.buildModelFromUrdf(str(self.path), pin.JointModelFreeFlyer())
        self._data = self.model.createData()
        self.start = pin.neutral(self.model)
        for name, angle in scene.bent.items():
            self.start[self.index(name)] = angle
        self.start[7:] = np.clip(self.start[7:], self.model.lowerPositionLimit[7:], self.model.upperPositionLimit[7:])
        self.frames = (*scene.feet, scene.wrist)
        pin.framesForwardKinematics(self.model, self._data, self.start)
        self.poses = {name: self._data.oMf[self.model.getFrameId(name)].copy() for name in self.frames}
        self.mass = pin.centerOfMass(self.model, self._data, self.start) - [0, 0, DROP]

    def index(self, joint: str) -> int:
        """Where the joint's position is in a configuration of Pinocchio."""
        return int(self.model.joints[self.model.getJointId(joint)].idx_q)

    def errors(self, q: Array) -> list[float]:
        """Distances of both feet, the wrist and the centre of mass from their targets [mm]."""
        pin.framesForwardKinematics(self.model, self._data, q)
        at = [self._data.oMf[self.model.getFrameId(name)].translation for name in self.frames]
        found = [np.linalg.norm(a - self.poses[name].translation) for a, name in zip(at, self.frames, strict=True)]
        return [
            1e3 * float(d) for d in (*found, np.linalg.norm(pin.centerOfMass(self.model, self._data, q) - self.mass))
        ]

    def row(self, name: str, solver: str, gain: float, path: list[Array], accepted: float = math.nan) -> Row:
        """The figures of a path of configurations."""
        speeds = np.array([pin.difference(self.model, a, b) for a, b in itertools.pairwise(path)])[:, 6:] / DT
        accelerations, last = np.diff(speeds, axis=0) / DT, round(1 / DT)
        errors = np.array([self.errors(q) for q in path[-last:]]).max(axis=0)
        rms, rms_of_all = (float(np.sqrt(np.mean(part**2))) for part in (accelerations[-last:], accelerations))
        largest = float(np.abs(accelerations[-last:]).max())
        foot = float(errors[:2].max())
        return Row(name, solver, gain, foot, float(errors[2]), float(errors[3]), rms, largest, rms_of_all, accepted)


def by_pink(humanoid: Humanoid, gain: float) -> list[Array]:
    """The path of pink."""
    import pink
    from pink.limits import ConfigurationLimit, VelocityLimit
    from pink.tasks import ComTask, FrameTask, PostureTask

    scene, model = humanoid.scene, humanoid.model
    configuration = pink.Configuration(model, model.createData(), humanoid.start)
    mass, posture = ComTask(cost=scene.mass), PostureTask(cost=scene.posture)
    mass.set_target(humanoid.mass)
    posture.set_target(humanoid.start)
    tasks = [mass, posture]
    for frame, pose in humanoid.poses.items():
        tasks.append(FrameTask(frame, position_cost=scene.position, orientation_cost=scene.orientation))
        tasks[-1].set_target(pose)
    limits = [ConfigurationLimit(model, gain), VelocityLimit(model)]
    options = {"solver": "daqp", "damping": scene.damping, "limits": limits, "safety_break": False}
    path = [humanoid.start]
    for _ in range(round(SECONDS / DT)):
        velocity = pink.solve_ik(configuration, tasks, DT, **options)
        configuration.integrate_inplace(velocity, DT)
        path.append(configuration.q.copy())
    return path


def by_jtik(humanoid: Humanoid, strategy: str, gain: float, acceleration: float | None) -> tuple[list[Array], float]:
    """The path of a strategy of jtik, and the share of its steps that were accepted."""
    scene, robot = humanoid.scene, jtik.Robot.from_urdf(humanoid.path, free_base=True)
    to_jtik, to_pinocchio = _conversions(humanoid, robot)
    lower = 1 if strategy in LEVELS else 0
    stiffness = [scene.position**2] * 3 + [scene.orientation**2] * 3
    tasks = [jtik.FrameTask(foot, "pose", stiffness=stiffness) for foot in scene.feet]
    tasks.append(jtik.FrameTask(scene.wrist, "pose", stiffness=stiffness, priority=lower))
    tasks.append(jtik.CenterOfMassTask(stiffness=scene.mass**2, priority=lower))
    as_pink = WeightedQP(
        lm_damping=0.0, damping=scene.damping, weight=scene.posture**2, q_limit=math.inf, backtracking=False
    )
    ik = jtik.InverseKinematics(
        robot,
        tasks,
        criteria=JointCentering(preferred=to_jtik(humanoid.start)),
        strategy=as_pink if strategy == "as pink" else strategy,
        limits=jtik.Limits(position_gain=gain, acceleration=acceleration),
        joints="all",
    )
    target = {name: pose.homogeneous for name, pose in humanoid.poses.items()} | {"center_of_mass": humanoid.mass}
    q, path, accepted, count = to_jtik(humanoid.start), [humanoid.start], 0, round(SECONDS / DT)
    for _ in range(count):
        step = ik.step(q, target, dt=DT)
        q, accepted = step.q, accepted + step.accepted
        path.append(to_pinocchio(q))
    return path, accepted / count


def _conversions(humanoid: Humanoid, robot: jtik.Robot) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Configurations of Pinocchio as those of jtik, and back; quaternions are (x, y, z, w) there, (w, x, y, z) here."""
    base, *joints = robot.joint_names
    at = robot.q_slice(base).start
    ours = [*range(at, at + 7), *(robot.q_slice(joint).start for joint in joints)]
    theirs = [0, 1, 2, 6, 3, 4, 5, *(humanoid.index(joint) for joint in joints)]

    def to_jtik(q: Array) -> Array:
        converted = robot.neutral.copy()
        converted[ours] = q[theirs]
        return converted

    def to_pinocchio(q: Array) -> Array:
        converted = pin.neutral(humanoid.model)
        converted[theirs] = q[ours]
        return converted

    return to_jtik, to_pinocchio


def _file(name: str) -> Path:
    package = metadata.distribution("example-robot-data")
    return next(Path(package.locate_file(path)) for path in package.files or () if path.name == name)


def rows(scenes: list[str], strategies: list[str], acceleration: float | None) -> Iterator[Row]:
    """One row for each scene, solver and gain."""
    for name in scenes:
        humanoid = Humanoid(SCENES[name])
        if importlib.util.find_spec("pink"):
            for gain in GAINS:
                yield humanoid.row(name, "pink", gain, by_pink(humanoid, gain))
        else:
            print("pink: not installed; pip install pin-pink daqp")
        for strategy, gain in itertools.product(strategies, GAINS):
            yield humanoid.row(name, strategy, gain, *by_jtik(humanoid, strategy, gain, acceleration))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--strategies", nargs="+", default=list(STRATEGIES))
    parser.add_argument("--acceleration", type=float, help="limit for jtik [rad/s^2]; none by default")
    parser.add_argument("--json", type=Path, help="file for the figures")
    given = parser.parse_args()
    logging.disable(logging.WARNING)  # pink warns at each step of a joint that is 1e-6 outside its limits
    print(
        "scene           solver            gain |    foot   wrist    mass [mm] |       rms   largest   of all [rad/s^2]"
    )
    found = []
    for row in rows(given.scenes, given.strategies, given.acceleration):
        found.append(row)
        errors = f"{row.foot:7.2f} {row.wrist:7.2f} {row.mass:7.2f}"
        accelerations = f"{row.rms:9.2f} {row.largest:9.1f} {row.rms_of_all:9.1f}"
        share = "" if math.isnan(row.accepted) else f" | {row.accepted:.2f} accepted"
        print(f"{row.scene:15s} {row.solver:17s} {row.gain:4.2f} | {errors} | {accelerations}{share}", flush=True)
    if given.json:
        given.json.write_text(json.dumps([asdict(row) for row in found], indent=1))


if __name__ == "__main__":
    main()
