"""Manipulability, Isotropy, SmallestSingularValue and DirectionalManipulability: measures of a task's Jacobian."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import DirectionalManipulability, Isotropy, Manipulability, SmallestSingularValue

from ..conftest import dh_arm, planar, shared_solver
from .derivatives import panda

ALL = (Manipulability, Isotropy, SmallestSingularValue, DirectionalManipulability)
ORACLE = 1e-9
"""Agreement with NumPy's decompositions, relative; the condition numbers here are below 1e3."""

DAMPING = 1e-3


def task_rows(robot, q, kind, length=1.0):
    """J (m, n) of the tip in NumPy, lengths divided by ``length``, angles in base axes."""
    J = robot.jacobian(q)
    if robot.dimension == 2:
        linear, angular = J[:2], J[5:]
    else:
        linear, angular = J[:3], J[3:]
    return {"position": linear / length, "orientation": angular, "pose": np.vstack([linear / length, angular])}[kind]


def damped_values(J, damping=DAMPING):
    """sqrt(sigma_i^2 + damping^2), the largest first."""
    s = np.linalg.svd(J, compute_uv=False)
    s = np.concatenate([s, np.zeros(len(J) - len(s))])
    return np.sqrt(s**2 + damping**2)


ROBOTS = {"planar": lambda: planar(5), "dh": lambda: dh_arm(7, 1), "panda": panda, "short": lambda: dh_arm(3, 2)}


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        pytest.param(name, kind, marks=[] if (row + column) % 2 == 0 else pytest.mark.slow)
        for row, name in enumerate(ROBOTS)
        for column, kind in enumerate(["position", "orientation", "pose"])
    ],
)
def test_values_are_those_of_numpys_singular_values(name, kind, rng):
    robot, length = ROBOTS[name](), 0.7
    options = {"kind": kind} if kind == "orientation" else {"kind": kind, "length": length}
    for _ in range(4):
        q = robot.random_configuration(rng)
        s = damped_values(task_rows(robot, q, kind, length))
        m = len(s)
        w = np.prod(s)
        assert Manipulability(**options)(q, robot) == pytest.approx(-np.log(w), rel=ORACLE, abs=ORACLE)
        assert Manipulability(measure="volume", **options)(q, robot) == pytest.approx(-w, rel=ORACLE)
        kappa = np.sqrt(np.sum(s**2) * np.sum(s**-2.0)) / m
        assert Isotropy(**options)(q, robot) == pytest.approx(np.log(kappa), abs=1e-8)
        bound = np.sum(s**-16.0) ** (-1 / 16)
        found = -SmallestSingularValue(**options)(q, robot)
        assert found == pytest.approx(bound, rel=ORACLE)
        assert s[-1] * m ** (-1 / 16) * (1 - ORACLE) <= found <= s[-1] * (1 + ORACLE)


@pytest.mark.parametrize("kind", ["position", "pose"])
def test_directions_are_radii_of_the_ellipsoids(kind, rng):
    robot = dh_arm(7, 1)
    for _ in range(4):
        q = robot.random_configuration(rng)
        J = task_rows(robot, q, "position")
        if kind == "pose":
            J = np.vstack([J, robot.pose(q)[:3, :3].T @ task_rows(robot, q, "orientation")])
        u = rng.standard_normal(len(J))
        options = {"kind": kind, "length": 1.0, "damping": 1e-6}
        fast, strong = (DirectionalManipulability(u, measure=m, **options)(q, robot) for m in ("velocity", "force"))
        u /= np.linalg.norm(u)
        dq = np.linalg.lstsq(J, u, rcond=None)[0]  # the shortest velocities of the motion along u
        assert fast == pytest.approx(np.log(np.linalg.norm(dq)), abs=1e-8)
        assert strong == pytest.approx(np.log(np.linalg.norm(J.T @ u)), abs=1e-8)
        assert fast >= -strong - 1e-9  # the chord along u is at most the support of the ellipsoid


def kinematic_hessian(J):
    """dJ/dq_k for every k, (n, 6, n), of revolute joints: the formulas of Corke and Haviland."""
    n = J.shape[1]
    v, w = J[:3].T, J[3:].T
    T = np.zeros((n, 6, n))
    for k in range(n):
        for i in range(n):
            first, last = min(k, i), max(k, i)
            T[k, :3, i] = np.cross(w[first], v[last])
            if k < i:
                T[k, 3:, i] = np.cross(w[k], w[i])
    return T


@pytest.mark.parametrize("kind", ["position", "pose"])
def test_the_gradient_is_that_of_the_toolboxs_closed_form(kind, rng):
    """dw/dq_k = w vec(J T_k')' vec((J J')^-1), with T_k = dJ/dq_k."""
    robot = panda()
    criterion = Manipulability(kind=kind, measure="volume", length=1.0, damping=1e-8)
    rows = slice(0, 3 if kind == "position" else 6)
    for _ in range(4):
        q = robot.random_configuration(rng)
        full = robot.jacobian(q)
        J, T = full[rows], kinematic_hessian(full)[:, rows]
        w = np.sqrt(np.linalg.det(J @ J.T))
        inverse = np.linalg.inv(J @ J.T)
        slope = [w * np.sum((J @ T[k].T) * inverse) for k in range(robot.n)]
        assert criterion(q, robot) == pytest.approx(-w, rel=1e-8)
        assert criterion.gradient(q, robot) == pytest.approx(-np.array(slope), rel=1e-6, abs=1e-8)


def test_value_and_gradient_are_those_of_pink(rng):
    pink = pytest.importorskip("pink")
    pinocchio = pytest.importorskip("pinocchio")
    from jtik.interop.urdf import to_urdf

    robot = panda()
    model = pinocchio.buildModelFromXML(to_urdf(robot))
    # of all six rows the determinant does not depend on the frame of reference
    task = pink.tasks.ManipulabilityTask(robot.tip, model, reference_frame=pinocchio.ReferenceFrame.WORLD)
    order = [model.joints[model.getJointId(name)].idx_q for name in robot.joint_names]
    criterion = Manipulability(kind="pose", measure="volume", length=1.0, damping=1e-8)
    for _ in range(3):
        q = robot.random_configuration(rng)
        theirs = np.zeros(model.nq)
        theirs[order] = q
        configuration = pink.Configuration(model, model.createData(), theirs)
        w = task.compute_manipulability(configuration)
        slope = task.compute_jacobian(configuration)[0][order]
        assert criterion(q, robot) == pytest.approx(-w, rel=1e-6)
        assert criterion.gradient(q, robot) == pytest.approx(-slope, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("criterion", ALL)
def test_a_task_gives_its_rows(criterion, rng):
    """The rows are those of the task's Jacobian on its target."""
    robot, q = dh_arm(6, 3), dh_arm(6, 3).random_configuration(rng)
    task = jtik.FrameTask("tip", "pose", axes=("x", "z", "rx", "ry"))
    J = shared_solver(robot, task).solve(robot.pose(q), q0=q, max_iterations=0).jacobian
    s = damped_values(J)
    given = criterion(frame=task, length=1.0)
    assert given.row_count(robot) == 4
    if criterion is Manipulability:
        assert given(q, robot) == pytest.approx(-np.log(s).sum(), rel=1e-8)
    if criterion is DirectionalManipulability:
        u = np.array([0.3, -0.2, 0.5, 0.4])
        A = J @ J.T + DAMPING**2 * np.eye(4)
        wanted = np.log(u @ np.linalg.solve(A, u) / (u @ u)) / 2
        assert criterion(u, frame=task, length=1.0)(q, robot) == pytest.approx(wanted, abs=1e-8)
    by_name = criterion(frame="tip", kind="pose", axes=("x", "z", "rx", "ry"), length=1.0)
    assert given(q, robot) == by_name(q, robot)


def test_the_frame_may_be_another_than_the_task(rng):
    robot = dh_arm(7, 1)
    q = robot.random_configuration(rng)
    frame = robot.moving_frames[3]
    s = damped_values(robot.jacobian(q, frame)[:3])
    assert Manipulability(frame)(q, robot) == pytest.approx(-np.log(s).sum(), rel=1e-8)


def test_the_default_length_balances_linear_and_angular_rows():
    robot = panda()
    length = Manipulability(kind="pose").parameters(robot)["length"]
    J = robot.jacobian(robot.home)
    assert np.linalg.norm(J[:3]) / length == pytest.approx(np.linalg.norm(J[3:]), rel=1e-12)
    flat = planar(5)
    length = Manipulability(kind="pose").parameters(flat)["length"]
    J = flat.jacobian(flat.home)
    assert np.sqrt(np.sum(J[:2] ** 2) / 2) / length == pytest.approx(np.linalg.norm(J[5]), rel=1e-12)
    assert Manipulability().parameters(robot)["length"] == 1
    assert "length" not in Manipulability(kind="orientation").parameters(robot)


@pytest.mark.parametrize("criterion", ALL)
def test_live_parameters_act_as_if_built_with_them(criterion, rng):
    robot = panda()
    q = robot.random_configuration(rng)
    built = criterion(kind="pose", length=0.3, damping=0.2)
    assert criterion(kind="pose")(q, robot, length=0.3, damping=0.2) == pytest.approx(built(q, robot), rel=1e-12)


@pytest.mark.parametrize("measure", ["velocity", "force"])
def test_the_direction_is_live_and_of_any_length(measure, rng):
    robot = planar(5)
    q = robot.random_configuration(rng)
    criterion = DirectionalManipulability(measure=measure)
    wanted = DirectionalManipulability([0.0, 1.0], measure=measure)(q, robot)
    assert criterion(q, robot, direction=[0.0, 7.0]) == pytest.approx(wanted, rel=1e-12)
    assert np.isfinite(criterion(q, robot, direction=[0.0, 0.0]))
    assert np.isfinite(criterion.gradient(q, robot, direction=[0.0, 0.0])).all()


@pytest.mark.thinned
@pytest.mark.parametrize("criterion", ALL)
@pytest.mark.parametrize("damping", [1e-3, 1e-300])
def test_finite_at_singular_poses_with_any_damping(criterion, damping):
    for robot in (planar(6), planar(1), panda()):
        q = np.clip(np.zeros(robot.nq), robot.lower, robot.upper)
        made = criterion(kind="pose")
        assert np.isfinite(made(q, robot, damping=damping))
        assert np.isfinite(made.gradient(q, robot, damping=damping)).all()


def test_a_chain_without_some_rows_is_finite():
    """Prismatic joints have no angular rows."""
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    robot = jtik.Robot(
        [
            jtik.Joint("x", jtik.robot.JointType.PRISMATIC, "base", "a", axis=x),
            jtik.Joint("y", jtik.robot.JointType.PRISMATIC, "a", "tip", axis=y),
        ]
    )
    for criterion in ALL:
        assert np.isfinite(criterion(kind="pose")([0.3, 0.1], robot))
        assert criterion(kind="pose").gradient([0.3, 0.1], robot).tolist() == [0, 0]


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda: Manipulability(kind="speed"), "kind"),
        (lambda: Manipulability(measure="log"), "measure"),
        (lambda: Manipulability(damping=0.0), "damping"),
        (lambda: Isotropy(length=-1.0), "length"),
        (lambda: Isotropy(axes=3), "axes"),
        (lambda: DirectionalManipulability(measure="speed"), "measure"),
        (lambda: DirectionalManipulability([1.0, 0.0, 0.0])([0.1, 0.2], planar(2)), "direction"),
        (lambda: DirectionalManipulability([0.0, 0.0])([0.1, 0.2], planar(2)), "direction"),
        (lambda: SmallestSingularValue(axes=("x", "z"))([0.1, 0.2], planar(2)), "axes"),
    ],
)
def test_wrong_arguments_are_refused(make, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        make()
    assert caught.value.argument == argument


def test_an_unknown_frame_is_refused():
    with pytest.raises(jtik.UnknownNameError):
        Manipulability("flange")([0.1, 0.2], planar(2))


def test_the_repr_shows_what_was_given():
    assert repr(Manipulability()) == "Manipulability(kind='position', measure='logarithm')"
    assert "axes=['x', 'y']" in repr(Isotropy(axes="xy"))
