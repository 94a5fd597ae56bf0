"""Seven arms from URDF files of installed packages, and the check of answers by Pinocchio's forward kinematics.

Every solver gets the same chain, from the root of the file to the tip, with all other joints locked at zero. jtik reads
the file itself. The other solvers get a URDF of the chain alone, which contains only the moving links.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray
FILE_SLACK = 1e-9
"""Tolerance of the check of limits and errors [rad], [m]: the solvers read different roundings of the same arm."""


@dataclass(frozen=True, eq=False)
class Link:
    """A revolute joint of a chain.

    Attributes:
        name: name of the joint.
        placement: its pose on the previous link, (4, 4).
        axis: its axis there, (3,).
        lower: lower limit [rad].
        upper: upper limit [rad].
        speed: velocity limit [rad/s].
    """

    name: str
    placement: Array
    axis: Array
    lower: float
    upper: float
    speed: float

    @property
    def continuous(self) -> bool:
        """Whether it has no position limits."""
        return math.isinf(self.lower)


@dataclass(frozen=True, eq=False)
class Arm:
    """A chain of revolute joints from the root frame to the tip.

    Attributes:
        name: as in ``--arms``.
        path: the URDF file.
        tip: the end-effector frame.
        links: the joints.
        tool: pose of the tip on the last link, (4, 4).
        pose: forward kinematics of the file by Pinocchio, (n,) -> (4, 4).
    """

    name: str
    path: Path
    tip: str
    links: tuple[Link, ...]
    tool: Array
    pose: Callable[[Array], Array]

    @property
    def lower(self) -> Array:
        """Lower limits, (n,) [rad]; -inf if there is none."""
        return np.array([link.lower for link in self.links])

    @property
    def upper(self) -> Array:
        """Upper limits, (n,) [rad]; inf if there is none."""
        return np.array([link.upper for link in self.links])

    def bounds(self, *, turn: float = math.pi) -> tuple[Array, Array]:
        """Limits, with -turn and turn for those that are infinite [rad]."""
        lower, upper = self.lower, self.upper
        return np.where(np.isinf(lower), -turn, lower), np.where(np.isinf(upper), turn, upper)

    def middle(self) -> Array:
        """The middle of the limits, (n,) [rad]."""
        return sum(self.bounds()) / 2

    def draw(self, generator: np.random.Generator) -> Array:
        """A configuration uniform within the limits, (n,) [rad]."""
        return generator.uniform(*self.bounds())

    def urdf(self, *, turn: float = math.inf) -> str:
        """The chain alone, from "base" to "tip". Joints without limits get -turn and turn [rad], unless infinite."""
        lower, upper = self.bounds(turn=turn)
        parts = ['<robot name="chain"><mujoco><compiler fusestatic="false"/></mujoco>', _body("base")]
        for k, link in enumerate(self.links):
            free = link.continuous and math.isinf(turn)
            bounds = "" if free else f'lower="{float(lower[k])!r}" upper="{float(upper[k])!r}" '
            parts.append(_body(f"link{k + 1}"))
            parts.append(
                f'<joint name="{link.name}" type="{"continuous" if free else "revolute"}">'
                f'<parent link="{f"link{k}" if k else "base"}"/><child link="link{k + 1}"/>{_origin(link.placement)}'
                f'<axis xyz="{_numbers(link.axis)}"/>'
                f'<limit {bounds}effort="100" velocity="{link.speed!r}"/></joint>'
            )
        parts.append(_body("tip"))
        parts.append(
            f'<joint name="tool" type="fixed"><parent link="link{len(self.links)}"/><child link="tip"/>'
            f"{_origin(self.tool)}</joint></robot>"
        )
        return "\n".join(parts)


def _numbers(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _body(name: str) -> str:
    inertia = 'ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"'
    return f'<link name="{name}"><inertial><mass value="1"/><inertia {inertia}/></inertial></link>'


def _origin(T: Array) -> str:
    pitch = math.atan2(-T[2, 0], math.hypot(T[0, 0], T[1, 0]))
    if math.hypot(T[0, 0], T[1, 0]) > 1e-9:
        roll, yaw = math.atan2(T[2, 1], T[2, 2]), math.atan2(T[1, 0], T[0, 0])
    else:
        roll, yaw = math.atan2(-T[1, 2], T[1, 1]), 0.0
    return f'<origin xyz="{_numbers(T[:3, 3])}" rpy="{_numbers(np.array([roll, pitch, yaw]))}"/>'


ROBOTS, TOOLBOX = "example-robot-data", "rtb-data"
SOURCES = {
    "panda": (ROBOTS, "panda_description/urdf/panda.urdf", "panda_link8", 7),
    "iiwa14": (TOOLBOX, "lbr_iiwa_14_r820.urdf", "tool0", 7),
    "ur5": (ROBOTS, "ur_description/urdf/ur5_robot.urdf", "tool0", 6),
    "xarm7": (ROBOTS, "xarm_description/urdf/xarm7.urdf", "link_eef", 7),
    "jaco2": (ROBOTS, "kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", 6),
    "baxter": (ROBOTS, "baxter_description/urdf/baxter.urdf", "left_gripper", 7),
    "pr2": (ROBOTS, "pr2_description/urdf/pr2.urdf", "r_wrist_roll_link", 7),
}
"""Package, file, tip, and number of joints of each arm."""


def _installed(package: str, file: str) -> Path:
    """A file of an installed package, by the end of its path."""
    for each in metadata.files(package) or ():
        if str(each).endswith(file):
            return Path(str(each.locate())).resolve()
    raise FileNotFoundError(f"{file} is not in {package}")


def read_arm(name: str) -> Arm:
    """Read an arm of SOURCES. Raises PackageNotFoundError or FileNotFoundError if its file is not installed."""
    import pinocchio as pin

    package, file, tip, count = SOURCES[name]
    path = _installed(package, file)
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    neutral = pin.neutral(model)
    frame = model.getFrameId(tip)
    chain = [int(i) for i in model.supports[model.frames[frame].parentJoint]][1:][-count:]
    pin.framesForwardKinematics(model, data, neutral)

    # Pinocchio represents a continuous joint by (cos, sin)
    turning = [model.joints[i].nq == 2 for i in chain]
    places = [model.joints[i].idx_q for i in chain]

    def pose(q: Array) -> Array:
        full = neutral.copy()
        for value, place, turns in zip(q, places, turning, strict=True):
            if turns:
                full[place : place + 2] = math.cos(value), math.sin(value)
            else:
                full[place] = value
        pin.framesForwardKinematics(model, data, full)
        return data.oMf[frame].homogeneous.copy()

    links, before = [], pin.SE3.Identity()
    for i, turns, place in zip(chain, turning, places, strict=True):
        joint, at = model.joints[i], data.oMi[i]
        links.append(
            Link(
                name=model.names[i],
                placement=(before.inverse() * at).homogeneous,
                axis=_axis(model, i),
                lower=-math.inf if turns else float(model.lowerPositionLimit[place]),
                upper=math.inf if turns else float(model.upperPositionLimit[place]),
                speed=float(model.velocityLimit[joint.idx_v]),
            )
        )
        before = at
    tool = (before.inverse() * data.oMf[frame]).homogeneous
    return Arm(name, path, tip, tuple(links), tool, pose)


def _axis(model: Any, i: int) -> Array:
    """The axis of a revolute joint in its own frame, from its angular velocity."""
    import pinocchio as pin

    joint = model.joints[i]
    v = np.zeros(model.nv)
    v[joint.idx_v] = 1.0
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model), v)
    return pin.getVelocity(model, data, i).angular.copy()


@dataclass(frozen=True)
class CheckResult:
    """Result of the check of an answer.

    Attributes:
        position: norm of the position error [m].
        orientation: norm of the orientation error [rad].
        within: whether it is within the limits.
    """

    position: float
    orientation: float
    within: bool


def check(arm: Arm, target: Array, q: Array) -> CheckResult:
    """Check an answer with Pinocchio."""
    import pinocchio as pin

    q = np.asarray(q, dtype=float)
    if q.shape != arm.lower.shape or not np.isfinite(q).all():
        return CheckResult(math.inf, math.inf, False)
    T = arm.pose(q)
    turn = pin.log3(T[:3, :3].T @ target[:3, :3])
    within = bool((q >= arm.lower - FILE_SLACK).all() and (q <= arm.upper + FILE_SLACK).all())
    return CheckResult(float(np.linalg.norm(T[:3, 3] - target[:3, 3])), float(np.linalg.norm(turn)), within)
