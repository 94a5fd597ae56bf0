"""Built-in arms against the URDF files of ``example-robot-data``, read and evaluated by Pinocchio.

Poses, Jacobians, limits, and the meshes of the links, which the solids must hold. The package has no UR5e, iiwa 14 or
Gen3: those are compared with the tables of their makers only.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import jtik

pin = pytest.importorskip("pinocchio")

pytestmark = pytest.mark.robots

AGREEMENT = 1e-9
"""[m], [rad]: the files write pi with 10 to 16 digits."""
OUTSIDE = 5e-3
"""Distance by which a mesh may exceed the solids around it [m]: the gallery rounds to millimetres."""


@dataclass(frozen=True)
class RobotFile:
    """A built-in robot and its file: its root link, and the frames and joints that are the same in both."""

    name: str
    file: str
    base: str
    frames: tuple[str, ...]
    meshes: str = "COLLISION"
    speed: float = 0.0


FILES = [
    RobotFile(
        "panda",
        "panda.urdf",
        "panda_link0",
        (*(f"panda_link{k}" for k in range(9)), "panda_hand", "panda_hand_tcp"),
    ),
    RobotFile("xarm7", "xarm7.urdf", "link_base", (*(f"link{k}" for k in range(1, 8)), "link_eef"), speed=0.002),
    # the file has other link frames, and speeds of 3.15 and 3.2 rad/s where 180 degrees/s are published
    RobotFile("ur5", "ur5_robot.urdf", "base_link", ("base", "tool0"), speed=0.06),
    RobotFile(
        "jaco2",
        "kinova.urdf",
        "j2s6s200_link_base",
        (*(f"j2s6s200_link_{k}" for k in range(1, 7)), "j2s6s200_end_effector"),
        meshes="VISUAL",  # the file has no others
    ),
]
ROUNDED_LIMITS = {"xarm7": 1e-3}
"""The file rounds -118 degrees to -2.059 rad."""


@pytest.fixture(scope="module", params=FILES, ids=lambda entry: entry.name)
def entry(request):
    return request.param


def path_of(file):
    try:
        package = metadata.distribution("example-robot-data")
    except metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    (found,) = [entry for entry in package.files if entry.name == file]
    return Path(package.locate_file(found)).resolve()


class Described:
    """Pinocchio's model of the file, with exact right angles, in the frame of the root link."""

    def __init__(self, entry):
        self.path, self.entry = path_of(entry.file), entry
        self.model = pin.buildModelFromUrdf(str(self.path))
        for placement in self.model.jointPlacements:
            # one file writes pi / 2 as 1.5708; all its joints are at right angles
            placement.rotation = np.round(placement.rotation)
        self.data = self.model.createData()

    def configuration(self, robot, q):
        result = pin.neutral(self.model)
        for name, value in zip(robot.joint_names, q, strict=True):
            joint = self.model.joints[self.model.getJointId(name)]
            rotation = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            result[joint.idx_q : joint.idx_q + joint.nq] = rotation
        return result

    def placement(self, robot, q):
        at = self.configuration(robot, q)
        pin.computeJointJacobians(self.model, self.data, at)
        pin.updateFramePlacements(self.model, self.data)
        return at

    @property
    def root(self):
        return self.data.oMf[self.model.getFrameId(self.entry.base)]

    def pose(self, frame):
        return (self.root.inverse() * self.data.oMf[self.model.getFrameId(frame)]).homogeneous

    def jacobian(self, robot, frame):
        index = self.model.getFrameId(frame)
        J = pin.getFrameJacobian(self.model, self.data, index, pin.LOCAL_WORLD_ALIGNED)
        columns = [self.model.joints[self.model.getJointId(name)].idx_v for name in robot.joint_names]
        turned = np.kron(np.eye(2), self.root.rotation.T)
        return turned @ J[:, columns]

    def limits(self, robot):
        joints = [self.model.joints[self.model.getJointId(name)] for name in robot.joint_names]
        endless = np.array([joint.nq == 2 for joint in joints])
        at = [joint.idx_q for joint in joints]
        lower, upper = self.model.lowerPositionLimit[at], self.model.upperPositionLimit[at]
        speed = self.model.velocityLimit[[joint.idx_v for joint in joints]]
        return np.where(endless, -np.inf, lower), np.where(endless, np.inf, upper), speed


@pytest.fixture(scope="module")
def described(entry):
    return Described(entry)


@pytest.fixture(scope="module")
def robot(entry):
    return jtik.Robot.builtin(entry.name)


@pytest.mark.quick(2)
def test_all_frames_and_jacobians_agree(entry, described, robot):
    generator = np.random.default_rng(11)
    for _ in range(20):
        q = robot.random_configuration(generator)
        described.placement(robot, q)
        for frame in entry.frames:
            assert robot.pose(q, frame) == pytest.approx(described.pose(frame), abs=AGREEMENT)
        end = entry.frames[-1]
        assert robot.jacobian(q, end) == pytest.approx(described.jacobian(robot, end), abs=AGREEMENT)


def test_limits_agree(entry, described, robot):
    lower, upper, speed = described.limits(robot)
    rounding = ROUNDED_LIMITS.get(entry.name, 1e-9)
    assert robot.lower == pytest.approx(lower, abs=rounding)
    assert robot.upper == pytest.approx(upper, abs=rounding)
    assert robot.velocity_limit == pytest.approx(speed, abs=entry.speed or 1e-9)


def surface(mesh, generator, count=400):
    """Vertices of a mesh and points on its triangles, (k, 3) [m]."""
    vertices = np.array(mesh.vertices())
    corners = np.array([[mesh.tri_indices(t)[k] for k in range(3)] for t in range(mesh.num_tris)])
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = generator.choice(len(corners), count, p=area / area.sum())
    weights = generator.dirichlet(np.ones(3), count)
    inside = sum(weights[:, [k]] * corner[chosen] for k, corner in enumerate((a, b, c)))
    return np.concatenate([inside, vertices[generator.choice(len(vertices), min(count, len(vertices)), replace=False)]])


def outside(points, capsule):
    """Distance of each point from a capsule [m], negative inside."""
    along = capsule.end - capsule.start
    share = np.clip((points - capsule.start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - capsule.start - share[:, None] * along, axis=1) - capsule.radius


@pytest.mark.quick(1)
def test_the_solids_hold_the_meshes_of_the_links(entry, described, robot):
    share = next(parent for parent in described.path.parents if parent.name == "example-robot-data").parent
    kind = pin.GeometryType.COLLISION if entry.meshes == "COLLISION" else pin.GeometryType.VISUAL
    geometry = pin.buildGeomFromUrdf(described.model, str(described.path), kind, package_dirs=[str(share)])
    placed = geometry.createData()
    q = robot.keyframes["home"]
    pin.updateGeometryPlacements(described.model, described.data, geometry, placed, described.placement(robot, q))
    pin.updateFramePlacements(described.model, described.data)
    generator = np.random.default_rng(0)
    checked = set()
    for solid, at in zip(geometry.geometryObjects, placed.oMg, strict=True):
        link = described.model.frames[solid.parentFrame].name
        carrier = "j2s6s200_link_6" if "finger" in link and entry.name == "jaco2" else link
        if carrier not in robot.shapes or not hasattr(solid.geometry, "num_tris"):
            continue
        points = surface(solid.geometry, generator) * np.array(solid.meshScale)
        T = np.linalg.inv(robot.pose(q, carrier)) @ (described.root.inverse() * at).homogeneous
        local = points @ T[:3, :3].T + T[:3, 3]
        apart = np.min([outside(local, capsule) for capsule in robot.shapes[carrier]], axis=0)
        assert apart.max() < OUTSIDE, f"{link}: {apart.max():.4f} m at {local[apart.argmax()].round(3)}"
        checked.add(carrier)
    assert checked == set(robot.shapes)
