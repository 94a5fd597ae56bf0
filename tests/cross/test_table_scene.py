"""A sample of benchmarks/table_scene.py: rows keep a Panda off table, wall, box and itself, and MuJoCo is the judge."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "table_scene.py"

GOALS = 10

ROUNDING = 1e-6
"""What MuJoCo's distances between capsules and boxes may be off by [m]."""


@pytest.fixture(scope="module")
def scene():
    if not SCRIPT.is_file():
        pytest.skip("the benchmarks are not part of this copy")
    pytest.importorskip("mujoco")
    spec = importlib.util.spec_from_file_location("table_scene", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_rows_keep_every_accepted_configuration_off_everything(scene):
    """These goals are such that without rows some ways lead through something."""
    poses = list(scene.goals(100))
    plain = scene.measure("neither", poses, restarts=0)
    hard = [pose for pose, each in zip(poses, plain, strict=True) if each.reached and each.way < 0][:GOALS]
    assert len(hard) >= GOALS // 2
    kept = scene.measure("rows", hard, restarts=0)
    assert min(each.way for each in kept) >= scene.SAFE - ROUNDING
    assert min(each.end for each in kept) >= scene.SAFE - ROUNDING
    assert sum(each.reached for each in kept) >= len(hard) // 2


def test_the_hand_alone_is_as_far_from_the_scene_as_the_arm_says(scene):
    """The distance by which goals are chosen, against that of the whole arm where its hand is closest."""
    robot = scene.jtik.Robot.builtin("panda")
    judge, hand = scene.Judge(robot, scene.SCENE), scene.Hand(robot)
    q = robot.home
    assert judge.distance(q) <= hand.distance(robot.pose(q)) + ROUNDING
    ik = scene.solver("neither")
    pose = next(iter(scene.goals(1)))
    pose[2, 3] = scene.TOP + 0.03  # the hand is the closest body
    pose[:2, 3] = 0.6, 0.25
    solution = ik.solve(pose, q0=q)
    assert solution.status.on_target
    assert judge.distance(solution.q) == pytest.approx(hand.distance(pose), abs=1e-5)
