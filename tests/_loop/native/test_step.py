"""The native step: the numbers of the step in Python, bit by bit, and those of the virtual machine up to rounding.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import copy
import functools

import numpy as np
import pytest

import jtik
from jtik._loop.native import object_layout
from jtik._loop.target_memory import TargetMemory
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering, ObstacleAvoidance

from ...conftest import dh_arm, planar, slow

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

ROUNDED = 1e-10
"""Difference of a step from the same step on the virtual machine, whose operations are rounded in another order."""

STRATEGIES = ("hybrid", *slow("weighted_qp"))

TAKEN, REFUSED, DONE, ESCAPED = "taken", "refused", "done", "escaped"


@functools.cache
def made(strategy="hybrid", *, kind="pose", compiled=True, **options):
    """A solver with limits of position, velocity and acceleration, and a criterion; the same for the same arguments."""
    options = {"criteria": JointCentering(), "limits": jtik.Limits(acceleration=5.0)} | options
    task = jtik.FrameTask("tip", kind=kind)
    ik = jtik.InverseKinematics(dh_arm(limit=2.0), task, strategy=strategy, compiled=compiled, **options)
    ik.warm_up()  # its copies in Python share what it compiles, not the other way round
    return ik


@pytest.fixture
def hybrid():
    return copy.copy(made())


def path(arm, count, seed):
    """Poses of a controller: a smooth path, then jumps, then out of reach, then one that stays."""
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-1.0, 1.0, arm.n), rng.normal(size=arm.n)
    for k in range(count):
        part = 4 * k // count
        if part == 0 or (part == 1 and k % 10 == 0):
            q = q + 0.01 * v if part == 0 else rng.uniform(-1.9, 1.9, arm.n)
        T = arm.pose(q, "tip")
        if part == 2:
            T[:3, 3] *= 1.0 + 0.05 * (k % 40)
        yield T


def stepped(ik, q, target, dt):
    """The step as numbers; the message where an argument is refused."""
    try:
        step = ik.step(q, target, dt=dt)
    except jtik.ArgumentError as error:
        return str(error)
    return (step.q.tolist(), *step[1:])


def in_python(ik):
    """A copy with the same step in generated C, around which everything is Python."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(object_layout, "is_known", lambda: False)
        return copy.copy(ik)


def compared(ik, targets, *, dt, start=0.1, other=None, exactly=True):
    """Steps along a path, beside those of another solver; those in Python by default.

    Returns:
        What the steps were.
    """
    other = other or in_python(ik)
    q, kinds = ik.robot.neutral + start, set()
    for k, target in enumerate(targets):
        duration = dt and (2 * dt if k % 50 == 7 else dt)
        given = (q.tolist(), target.tolist()) if k % 3 == 1 else (q, target)
        one, two = stepped(ik, *given, duration), stepped(other, q, target, duration)
        if exactly or isinstance(one, str):
            assert one == two, k
        else:
            assert one[0] == pytest.approx(two[0], abs=ROUNDED), k
            assert one[1:3] == pytest.approx(two[1:3], abs=ROUNDED), k
            assert one[3:] == two[3:], k
        if isinstance(one, tuple):
            q = np.array(one[0])
            kinds.add(ESCAPED if one[5] else DONE if one[4] else TAKEN if one[3] else REFUSED)
    assert native(ik, dt)
    assert not native(other, dt)
    return kinds


def native(ik, dt):
    """The step in C of a solver; None on the virtual machine."""
    way = ik._stepping._untimed if dt is None else ik._stepping._timed
    return way[2]


@pytest.mark.quick(1)
@pytest.mark.thinned
@pytest.mark.parametrize("dt", [None, 0.01])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_it_steps_as_python_does(strategy, dt):
    ik = copy.copy(made(strategy))
    kinds = compared(ik, path(ik.robot, 150, 1), dt=dt)
    assert TAKEN in kinds


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_it_steps_as_the_virtual_machine_does(strategy):
    ik, other = copy.copy(made(strategy)), copy.copy(made(strategy, compiled=False))
    compared(ik, path(ik.robot, 150, 2), dt=0.01, other=other, exactly=False)


@pytest.mark.quick(1)
@pytest.mark.parametrize("dt", [None, 0.01])
def test_refusals_rest_and_escapes_are_those_of_python(hybrid, dt):
    """At a straight arm the task has a saddle point; on target the criterion has one; then the arm is at rest."""
    arm = hybrid.robot
    straight, kinds = arm.neutral, set()
    for goal in (arm.pose(straight, "tip"), arm.pose(straight + 0.3, "tip")):
        for copied in (copy.copy(hybrid), copy.copy(made(kind="position", criteria=None, strategy="damped"))):
            kinds |= compared(copied, 60 * [goal], dt=dt, start=0.0)
    assert {TAKEN, DONE} <= kinds


def test_vectors_are_read_in_c(monkeypatch):
    ik, read = copy.copy(made("damped", kind="position", criteria=None)), []
    compared(ik, (T[:3, 3].copy() for T in path(ik.robot, 200, 3)), dt=0.01)
    monkeypatch.setattr(TargetMemory, "copy", lambda self, target: read.append(target))
    ik.step(ik.robot.neutral, np.array([0.5, 0.2, 0.4]), dt=0.01)
    assert not read


VECTORS = {
    "a pose": lambda T: T,
    "another pose": lambda T: np.diag([1.0, -1.0, -1.0, 1.0]) @ T,
    "two numbers": lambda T: np.ones(2),
    "no numbers": lambda T: np.zeros(0),
    "a number": lambda T: np.array(0.5),
    "a row": lambda T: np.ones((1, 3)),
    "a column": lambda T: np.ones((3, 1)),
    "too many": lambda T: np.ones(4),
    "three numbers": lambda T: np.array([0.5, 0.2, 0.1]),
    "three of single precision": lambda T: np.array([0.5, 0.2, 0.1], np.float32),
    "every second": lambda T: np.array([0.5, 9.0, 0.2, 9.0, 0.1])[::2],
    "NaN": lambda T: np.array([0.5, np.nan, 0.1]),
    "a pose with NaN": lambda T: np.where(np.arange(16).reshape(4, 4) == 3, np.nan, T),
    "three rows": lambda T: T[:3],
    "no rotation": lambda T: 2 * T,
}


@pytest.mark.parametrize("kind", ["position", "planar position", "planar pose"])
def test_a_target_that_is_no_vector_is_read_or_refused_by_python(kind):
    """A step never goes to the target of the one before."""
    arm = planar(5) if "planar" in kind else dh_arm(limit=2.0)
    task = jtik.FrameTask("tip", kind.split()[-1])
    ik = jtik.InverseKinematics(arm, task, strategy="damped", compiled=True)
    other, q = in_python(ik), arm.neutral + 0.1
    for name, given in VECTORS.items():
        target = given(arm.pose(q + 0.2, "tip"))
        assert stepped(ik, q, target, None) == stepped(other, q, target, None), name
    assert native(ik, None)


@pytest.mark.parametrize("layout", ["columns first", "every second", "backwards"])
def test_arrays_of_any_layout(hybrid, layout):
    ik, q, T = copy.copy(hybrid), hybrid.robot.neutral + 0.1, hybrid.robot.pose(hybrid.robot.neutral + 0.3, "tip")
    expected = stepped(in_python(hybrid), q, T, 0.01)
    given = {
        "columns first": (q, np.asfortranarray(T)),
        "every second": (np.repeat(q, 2)[::2], np.repeat(np.repeat(T, 2, 0), 2, 1)[::2, ::2]),
        "backwards": (q[::-1].copy()[::-1], T[::-1, ::-1].copy()[::-1, ::-1]),
    }[layout]
    assert stepped(ik, *given, 0.01) == expected


class Own(np.ndarray):
    """An array of another class."""


OTHERS = {
    "a row": lambda q, T: (q[None], T),
    "one too few": lambda q, T: (q[1:], T),
    "integers": lambda q, T: (np.zeros(7, int), T),
    "single precision": lambda q, T: (q.astype(np.float32), T.astype(np.float32)),
    "the other byte order": lambda q, T: (q.astype(q.dtype.newbyteorder()), T.astype(T.dtype.newbyteorder())),
    "another class": lambda q, T: (q.view(Own), T.view(Own)),
    "NaN in q": lambda q, T: (np.where(np.arange(7) == 3, np.nan, q), T),
    "infinite q": lambda q, T: (np.where(np.arange(7) == 3, np.inf, q), T),
    "NaN in the target": lambda q, T: (q, np.where(np.eye(4)[[2, 0, 1, 3]] > 0, np.nan, T)),
    "no rotation": lambda q, T: (q, 2 * T),
    "three rows": lambda q, T: (q, T[:3]),
    "no number": lambda q, T: ("q", T),
    "nothing": lambda q, T: (q, None),
    "a number": lambda q, T: (q, 1.0),
}


@pytest.mark.parametrize("name", OTHERS)
def test_anything_else_is_read_or_refused_by_python(hybrid, name):
    """With the message of Python; the step after it is the one without it."""
    ik, other = hybrid, copy.copy(made(compiled=False))
    q, T = ik.robot.neutral + 0.1, ik.robot.pose(ik.robot.neutral + 0.3, "tip")
    for each in (ik, other):
        stepped(each, q, T, 0.01)
    one, two = (stepped(each, *OTHERS[name](q, T), 0.01) for each in (ik, other))
    if isinstance(one, str):
        assert one == two
    else:
        assert one[0] == pytest.approx(two[0], abs=ROUNDED)
    one, two = (stepped(each, q, T, 0.01) for each in (ik, other))
    assert one[0] == pytest.approx(two[0], abs=ROUNDED)


def test_a_wrong_duration_is_refused_and_the_last_one_holds(hybrid):
    ik, q, T = copy.copy(hybrid), hybrid.robot.neutral + 0.1, hybrid.robot.pose(hybrid.robot.neutral + 0.3, "tip")
    changing = np.array(0.01)
    first = ik.step(q, T, dt=changing)
    changing[()] = 0.02  # the same object
    other = in_python(hybrid)
    other.step(q, T, dt=0.01)
    for wrong in (0.0, -1.0, np.nan, "x", True):
        with pytest.raises(jtik.ArgumentError, match="dt"):
            ik.step(q, T, dt=wrong)
    assert stepped(ik, first.q, T, changing) == stepped(other, first.q, T, 0.02)


def test_results_and_arguments_stay_as_they_are(hybrid):
    ik, q, T = copy.copy(hybrid), hybrid.robot.neutral + 0.1, hybrid.robot.pose(hybrid.robot.neutral + 0.3, "tip")
    before, goal = q.copy(), T.copy()
    first = ik.step(q, T, dt=0.01)
    kept = first.q.copy()
    ik.step(first.q, T, dt=0.01)
    assert first.q.tolist() == kept.tolist()
    assert q.tolist() == before.tolist()
    assert T.tolist() == goal.tolist()


def test_a_reset_and_a_velocity_count(hybrid):
    q, T = hybrid.robot.neutral + 0.1, hybrid.robot.pose(hybrid.robot.neutral + 0.3, "tip")
    one, two = hybrid, in_python(hybrid)
    for ik in (one, two):
        ik.step(q, T, dt=0.01)
        ik.reset(velocity=np.full(7, 0.2))
    assert stepped(one, q, T, 0.01) == stepped(two, q, T, 0.01)
    one.reset()
    assert stepped(one, q, T, 0.01) == stepped(in_python(hybrid), q, T, 0.01)


def test_clearances_are_kept_where_obstacles_move():
    arm = planar(4, lower=-2.5, upper=2.5, velocity_limit=2.0)
    kept = jtik.Clearance(ObstacleAvoidance([jtik.Circle((2.0, 1.0), 0.5)]))
    task = jtik.FrameTask("tip", "position")
    ik = jtik.InverseKinematics(arm, task, strategy="hybrid+qp", clearances=kept, compiled=True)
    other = in_python(ik)
    q, name = np.array([0.9, -0.4, 0.2, 0.1]), next(name for name in ik.parameters if name.endswith("centers"))
    for k in range(100):
        for each in (ik, other):
            each.parameters[name] = [[2.0 + 0.3 * np.sin(0.3 * k), 1.0]]
        target = np.array([3.0 - 0.02 * k, 0.5])
        one, two = stepped(ik, q, target, 0.02), stepped(other, q, target, 0.02)
        assert one == two
        q = np.array(one[0])
    assert native(ik, 0.02)


def test_several_tasks_have_dicts_of_targets():
    arm = dh_arm(limit=2.0)
    tasks = [jtik.FrameTask("tip", "position", name="tip"), jtik.FrameTask("tip", "orientation", name="turn")]
    ik = jtik.InverseKinematics(arm, tasks, strategy="damped", compiled=True)
    other, q = in_python(ik), arm.neutral + 0.1
    for T in path(arm, 60, 4):
        one, two = (stepped(each, q, {"tip": T[:3, 3], "turn": T[:3, :3]}, None) for each in (ik, other))
        assert one == two
        q = np.array(one[0])
    assert native(ik, None)


def test_the_layout_of_arrays_is_known():
    assert object_layout.is_known()
