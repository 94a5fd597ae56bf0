"""All generators: seeds, names, validity, reachability and invalid input."""

from __future__ import annotations

import functools
import json

import numpy as np
import pytest

import jtik
from jtik import problems

from ..conftest import ball_arm, dh_arm, floating_arm, planar, shared_solver
from .conftest import ARRIVED, distance_to, gallery, inside

GENERATORS = {
    name: getattr(problems, name)
    for name in (
        "reachable",
        "near_limits",
        "near_singular",
        "boundary",
        "unreachable",
        "circle",
        "line",
        "lissajous",
        "scene",
    )
}
PATHS = {"circle": {"points": 10}, "line": {"points": 10}, "lissajous": {"points": 10}}
POSITIONS = ("boundary", "unreachable", "circle", "line", "lissajous")
"""Generators that move a position."""


@functools.cache
def limited():
    return planar(4, lower=-2.0, upper=2.0)


SETUPS = {
    "planar position": (limited, lambda: jtik.FrameTask()),
    "planar pose": (limited, lambda: jtik.FrameTask(kind="pose")),
    "panda pose": (lambda: gallery("panda"), lambda: jtik.FrameTask(kind="pose")),
    "ball arm pose": (ball_arm, lambda: jtik.FrameTask(kind="pose")),
}


def draw(generator, robot, task, count=2, **options):
    return GENERATORS[generator](robot, task, count, **PATHS.get(generator, {}) | options)


@functools.cache
def drawn(generator, setup):
    robot, task = (make() for make in SETUPS[setup])
    return robot, task, draw(generator, robot, task)


@functools.cache
def solver(setup):
    robot, task = (make() for make in SETUPS[setup])
    return shared_solver(robot, task)


@pytest.mark.quick(5, slow=10)
@pytest.mark.parametrize(
    ("generator", "setup"),
    [
        pytest.param(generator, setup, marks=[] if (row + column) % 2 == 0 else pytest.mark.slow)
        for row, generator in enumerate(GENERATORS)
        for column, setup in enumerate(SETUPS)
        if setup.startswith("planar") or generator not in ("line", "lissajous")
    ],
)
def test_cases_are_valid_and_reachable_according_to_mujoco(generator, setup):
    robot, task, made = drawn(generator, setup)
    made.check(robot, task)
    assert [case.name for case in made] == [f"{generator}-000", f"{generator}-001"]
    assert made.kinds == (generator,)
    assert made.seed == 0
    assert made[0].q0.tolist() != made[1].q0.tolist()
    for case in made:
        assert inside(robot, case.q0)
        assert case.reachable is (generator != "unreachable")
        q = case.q0
        for target in case.targets if case.reachable else ():
            q = solver(setup).solve(target, q0=q, restarts=60, until="reached").q
            assert inside(robot, q)
            assert distance_to(robot, q, target, task.kind) < ARRIVED


@pytest.mark.quick(3)
@pytest.mark.parametrize("generator", GENERATORS)
def test_cases_depend_on_the_seed_and_not_on_the_count(generator):
    robot, task, made = drawn(generator, "planar position")
    again = draw(generator, robot, task, 1)
    assert again.cases == made.cases[:1]
    assert again[0].as_data() != draw(generator, robot, task, 1, seed=1)[0].as_data()
    assert problems.ProblemSet.from_data(json.loads(json.dumps(made.as_data(), allow_nan=False))) == made


def test_different_kinds_draw_different_starts_from_one_seed():
    robot, task = limited(), jtik.FrameTask()
    starts = {tuple(drawn(generator, "planar position")[2][0].q0) for generator in GENERATORS}
    assert len(starts) == len(GENERATORS)
    assert draw("reachable", robot, task, seed=5).seed == 5


@pytest.mark.parametrize("generator", [name for name in GENERATORS if name != "near_singular"])
def test_a_given_start_is_used_in_every_case(generator):
    q0 = np.array([0.5, 0.6, 0.7, 0.8])
    options = (
        {} if generator not in PATHS else {{"circle": "radius", "line": "length"}.get(generator, "amplitude"): 0.1}
    )
    made = draw(generator, limited(), jtik.FrameTask(), q0=q0, **options)
    assert all(case.q0.tolist() == q0.tolist() for case in made)


@pytest.mark.parametrize("generator", ["reachable", "near_limits", "scene"])
def test_orientations_can_be_drawn(generator):
    for robot in (limited(), dh_arm(7, limit=2.5)):
        task = jtik.FrameTask(kind="orientation")
        made = draw(generator, robot, task)
        made.check(robot, task)
        ik = shared_solver(robot, task)
        for case in made:
            q = ik.solve(case.target, q0=case.q0, restarts=20, until="reached").q
            assert distance_to(robot, q, case.target, "orientation") < ARRIVED


@pytest.mark.parametrize("generator", POSITIONS)
def test_generators_that_move_a_position_refuse_tasks_without_one(generator):
    for task in (jtik.FrameTask(kind="orientation"), jtik.AxisTask("tip", (1.0, 0.0))):
        with pytest.raises(jtik.ArgumentError, match="FrameTask of kind 'position' or 'pose'") as caught:
            draw(generator, limited(), task)
        assert caught.value.argument == "task"


@pytest.mark.quick(3)
@pytest.mark.parametrize("generator", GENERATORS)
def test_several_tasks_have_targets_by_name(generator):
    robot = limited()
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link3", kind="orientation", name="turn")]
    made = draw(generator, robot, tasks, 1)
    made.check(robot, tasks)
    assert made[0].target.keys() == {"tip", "turn"}
    ik = shared_solver(robot, tasks)
    if made[0].reachable:
        q = ik.solve(made[0].target, q0=made[0].q0, restarts=60, until="reached").q
        assert distance_to(robot, q, made[0].target["tip"], "position", "tip") < ARRIVED
        assert distance_to(robot, q, made[0].target["turn"], "orientation", "link3") < ARRIVED
    if generator in ("circle", "line", "lissajous"):
        assert len({target["turn"] for target in made[0].targets}) == 1
        assert len({tuple(target["tip"]) for target in made[0].targets}) > 5


TASKS = {
    "relative": (lambda: gallery("panda"), lambda: jtik.RelativeFrameTask("tip", "panda_link3")),
    "planar relative": (limited, lambda: jtik.RelativeFrameTask("tip", "link2", kind="position")),
    "axis": (lambda: gallery("panda"), lambda: jtik.AxisTask("tip")),
    "planar axis": (limited, lambda: jtik.AxisTask("tip", (0.0, 1.0))),
    "look": (lambda: gallery("panda"), lambda: jtik.LookAtTask("tip")),
    "planar look": (limited, lambda: jtik.LookAtTask("tip", (1.0, 0.0))),
    "free base": (floating_arm, lambda: jtik.FrameTask(kind="pose")),
}


@pytest.mark.quick(3)
@pytest.mark.parametrize(("robot", "task"), TASKS.values(), ids=TASKS)
def test_targets_of_all_tasks_are_those_of_the_goal(robot, task):
    robot, task = robot(), task()
    ik = shared_solver(robot, task)
    for case in draw("reachable", robot, task, 3):
        solution = ik.solve(case.target, q0=case.q0, restarts=60, until="reached")
        assert solution.converged


def test_a_centre_of_mass_can_be_drawn():
    mass = {"link1": jtik.robot.Mass(1.0, [0.5, 0, 0]), "link2": jtik.robot.Mass(2.0, [0.5, 0, 0])}
    robot = jtik.Robot(planar(2).joints, planar=True, masses=mass)
    task = jtik.CenterOfMassTask()
    for case in draw("reachable", robot, task, 3):
        assert shared_solver(robot, task).solve(case.target, q0=case.q0, restarts=20).error == pytest.approx(
            [0, 0], abs=1e-5
        )


def test_a_custom_task_needs_target_at():
    class Height(jtik.FrameTask):
        def target_at(self, robot, q):
            return [0.25, 0.5]

    class Own(jtik.Task):
        name, priority = "own", 0
        target_size = read_target = rows = weight = None

        def frames(self, robot):
            return ("tip",)

    assert draw("reachable", limited(), Height())[0].target.tolist() == [0.25, 0.5]
    with pytest.raises(jtik.ArgumentError, match="target_at"):
        draw("reachable", limited(), Own())


def test_cases_belong_to_the_reduced_robot():
    robot = limited()
    made = draw("reachable", robot, jtik.FrameTask("link3"))
    assert made[0].q0.shape == (3,)
    assert draw("reachable", robot, jtik.FrameTask("link3"), joints="all")[0].q0.shape == (4,)
    locked = draw("boundary", robot, jtik.FrameTask(), 1, joints=["joint1", "joint2"], at=[0, 0, 0, np.pi / 2 - 0.1])
    # two free links, the second longer by the two that are locked at an angle
    rigid = np.linalg.norm([2 + np.cos(np.pi / 2 - 0.1), np.sin(np.pi / 2 - 0.1)])
    assert locked[0].known["reach"] <= 1 + rigid + 1e-4
    locked.check(robot, jtik.FrameTask(), joints=["joint1", "joint2"])


@pytest.mark.parametrize("generator", GENERATORS)
def test_invalid_arguments_of_generators_are_named(generator):
    make = GENERATORS[generator]
    robot, task = limited(), jtik.FrameTask()
    for options, argument in (
        ({"count": 0}, "count"),
        ({"count": 2.5}, "count"),
        ({"count": True}, "count"),
        ({"seed": -1}, "seed"),
        ({"seed": "one"}, "seed"),
    ):
        with pytest.raises(jtik.ArgumentError) as caught:
            make(robot, task, **{"count": 1} | options)
        assert caught.value.argument == argument
    for wrong_robot, wrong_task in ((robot, "tip"), ("arm", task), (robot, [])):
        with pytest.raises(jtik.ArgumentError):
            make(wrong_robot, wrong_task, 1)
    with pytest.raises(jtik.UnknownNameError):
        make(robot, jtik.FrameTask("hand"), 1)


@pytest.mark.quick(9)
@pytest.mark.parametrize(
    ("generator", "options", "argument"),
    [
        ("reachable", {"q0": [0.1]}, "q0"),
        ("near_limits", {"share": 0.6}, "share"),
        ("near_singular", {"start_distance": (1e-3, 1e-6)}, "start_distance"),
        ("near_singular", {"target_distance": (0, 1)}, "target_distance"),
        ("boundary", {"share": 1.0}, "share"),
        ("unreachable", {"beyond": (0.9, 1.2)}, "beyond"),
        ("circle", {"radius": -1.0}, "radius"),
        ("circle", {"radius": 3.9}, "radius"),
        ("circle", {"points": 1}, "points"),
        ("line", {"length": np.inf}, "length"),
        ("line", {"dt": 0.0}, "dt"),
        ("lissajous", {"frequencies": (1, 0)}, "frequencies"),
        ("lissajous", {"frequencies": (1.5, 2)}, "frequencies"),
        ("scene", {"obstacles": 0}, "obstacles"),
        ("scene", {"radius": (0.1, 0.0)}, "radius"),
        ("scene", {"clearance": -0.1}, "clearance"),
        ("scene", {"clearance": 5.0}, "clearance"),
        ("scene", {"shapes": True}, "shapes"),
    ],
)
def test_invalid_options_of_generators_are_named(generator, options, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        draw(generator, limited(), jtik.FrameTask(), 1, **options)
    assert caught.value.argument == argument


@pytest.mark.parametrize("generator", ["boundary", "unreachable"])
def test_a_robot_with_unbounded_reach_has_no_boundary(generator):
    with pytest.raises(jtik.ArgumentError, match="bounded reach"):
        draw(generator, gallery("vehicle3"), jtik.FrameTask())


def test_near_limits_needs_joint_limits():
    with pytest.raises(jtik.ArgumentError, match="a lower and an upper limit"):
        draw("near_limits", planar(3), jtik.FrameTask())
