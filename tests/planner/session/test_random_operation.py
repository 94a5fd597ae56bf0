"""Some minutes of an operator who does anything at random: nothing raises, nothing is lost, nothing grows."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import numpy as np
import pytest

from jtik.planner.edits import messages as edits
from jtik.planner.edits import of_attempts
from jtik.planner.session.loop import DT
from tests.planner.operator import Operator

STRATEGIES = ("newton", "hybrid", "damped")


def random_edits(generator: np.random.Generator, operator: Operator) -> Iterator[edits.Edit]:
    """Edits of every kind that builds little, some of them wrong."""
    names = [*operator.loop.settings.scene, "none"]
    attempts = [*operator.loop.history.names, "none"]
    while True:
        name, attempt = generator.choice(names), generator.choice(attempts)
        time = float(generator.uniform(0, 2))
        circle = {"shape": "circle", "center": generator.uniform(-4, 4, 2).tolist(), "radius": 0.2}
        choices = [
            edits.MoveTarget(generator.uniform(-5, 5, 2)),
            edits.HoldTarget(generator.uniform(-1, 1, 2)),
            edits.HoldTarget((0.0, 0.0)),
            edits.AddObstacle(f"disc {generator.integers(2)}", circle),
            edits.ChangeObstacle(name, circle),
            edits.DeleteObstacle(name),
            edits.SetObstacleGain(name, float(generator.uniform(0, 2))),
            edits.SetPreferred(f"joint{generator.integers(1, 6)}", float(generator.uniform(-2, 2))),
            edits.SetJointWeights({f"joint{generator.integers(1, 6)}": float(generator.choice([0.1, 1.0]))}),
            edits.TakePosture(),
            edits.SetGain("joint_centering.stiffness", float(generator.uniform(0, 3))),
            edits.SetGain("joint_centering.weight", float(generator.uniform(-0.1, 3))),
            edits.SetStrategy(str(generator.choice(STRATEGIES))),
            edits.SetTargetSpeed(float(generator.uniform(0.1, 20))),
            edits.Jog(float(generator.uniform(-1, 1))),
            edits.Jog(0.0),
            of_attempts.Record(),
            of_attempts.StopRecording(),
            of_attempts.Play(attempt, float(generator.uniform(0.5, 4))),
            of_attempts.Pause(),
            of_attempts.Live(),
            of_attempts.Scrub(attempt, time),
            of_attempts.Undo(attempt, time),
            of_attempts.Branch(attempt, time),
            of_attempts.Choose(attempt),
            of_attempts.DeleteAttempt(attempt),
        ]
        yield choices[generator.integers(len(choices))]


def operate(operator: Operator, generator: np.random.Generator, ticks: int) -> None:
    while ticks > 0:
        stream = random_edits(generator, operator)
        for _ in range(generator.integers(0, 4)):
            operator.loop.submit(next(stream))
        between = int(generator.integers(1, 20))
        operator.go(between * DT)
        ticks -= between
        assert np.isfinite(operator.loop.frame.q).all()
        assert operator.loop.frame.position.shape == (2,)


@pytest.mark.quick(0)
@pytest.mark.parametrize(("seed", "periods"), [(0, 1000), pytest.param(1, 2000, marks=pytest.mark.slow)])
def test_random_operation(seed: int, periods: int) -> None:
    operator, generator = Operator(), np.random.default_rng(seed)
    operate(operator, generator, periods)
    failed = [text for text in operator.told if "failed" in text or "Error" in text.split(":")[1]]
    assert failed == []
    assert operator.loop.status.heartbeat >= periods // 6 - 1
    while operator.loop.history.names:
        operator.does(of_attempts.DeleteAttempt(operator.loop.history.names[-1]), seconds=DT)
    operator.does(of_attempts.StopRecording(keep=False), of_attempts.Live(), edits.HoldTarget((0.0, 0.0)), seconds=1)
    assert operator.loop.frame.mode == "live"


@pytest.mark.slow
def test_memory_does_not_grow() -> None:
    operator, generator = Operator(), np.random.default_rng(5)

    def objects() -> int:
        operator.does(of_attempts.StopRecording(keep=False), of_attempts.Live(), edits.Jog(0.0))
        for name in operator.loop.history.names:
            operator.does(of_attempts.DeleteAttempt(name), seconds=DT)
        for name in operator.loop.settings.scene:
            operator.does(edits.DeleteObstacle(name), seconds=0.2)
        operator.go(0.5)
        operator.state.messages.latest.clear()
        gc.collect()
        return len(gc.get_objects())

    operate(operator, generator, 3000)  # until every form of a solver has been built once
    before = objects()
    operate(operator, generator, 2000)
    assert objects() - before < 500
