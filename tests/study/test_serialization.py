"""Pickling of a study and its parts."""

from __future__ import annotations

import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

import jtik
from jtik._loop.fingerprint import fingerprint
from jtik.study import Contender
from jtik.study.serialization import PlanDeserializationError, SerializedPlan, run_serialized
from jtik.testing import example_criterion


@jtik.criterion
def elbow_height(q, robot, *, height=1.0):
    """A criterion at the top level of a module."""
    return (robot.position(q, robot.frame_names[2])[1] - height) ** 2


class Unpicklable(Contender):
    """Cannot be pickled."""

    label = "unpicklable"

    def __reduce__(self):
        raise TypeError("cannot be pickled")

    def prepare(self, setting):
        raise AssertionError


class TestPickling:
    @pytest.mark.parametrize("name", [*jtik.strategies, *(f"newton+{name}" for name in jtik.secondaries)])
    def test_every_strategy_can_be_pickled(self, name):
        contender = jtik.study.StrategyContender(jtik.registry.strategy_of(name))
        copy = pickle.loads(pickle.dumps(contender))
        assert (copy.label, copy.strategy) == (contender.label, contender.strategy)
        assert fingerprint(copy) == fingerprint(contender)

    @pytest.mark.parametrize("name", jtik.criteria)
    def test_every_criterion_can_be_pickled(self, name, arm):
        criterion = example_criterion(jtik.criteria[name], arm)
        copy = pickle.loads(pickle.dumps(criterion))
        assert fingerprint(copy) == fingerprint(criterion)

    def test_a_criterion_of_a_module_is_pickled_by_name(self):
        copy = pickle.loads(pickle.dumps(elbow_height(height=0.3)))
        assert copy.value.__func__ is elbow_height.value.__func__
        assert copy._function is elbow_height._function
        assert copy.parameters(None) == {"height": 0.3}

    @pytest.mark.slow
    def test_a_lambda_can_be_sent_with_cloudpickle(self, arm, task, assert_same):
        pytest.importorskip("cloudpickle")
        norm = jtik.criterion(lambda q, robot: q.T @ q)
        chosen = {"strategies": "damped", "criteria": norm, "count": 5, "block": 2, "repeats": 1, "traces": 2}
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            assert_same(jtik.compare(arm, task, **chosen), jtik.compare(arm, task, **chosen, executor=pool))

    def test_without_cloudpickle_a_lambda_is_refused_with_a_hint(self, arm, task, monkeypatch):
        monkeypatch.setattr("jtik.study.serialization.pickler", lambda: pickle)
        norm = jtik.criterion(lambda q, robot: q.T @ q)
        with (
            ThreadPoolExecutor(1) as pool,
            pytest.raises(jtik.ArgumentError, match=r"criteria\['norm'\].*cannot be pickled.*cloudpickle"),
        ):
            jtik.compare(arm, task, strategies="damped", criteria={"norm": norm}, count=1, executor=pool)

    def test_a_contender_that_cannot_be_pickled_is_named(self, arm, task):
        with (
            ThreadPoolExecutor(1) as pool,
            pytest.raises(jtik.ArgumentError, match=r"strategies\['unpicklable'\].*cannot be pickled"),
        ):
            jtik.compare(arm, task, strategies=["damped", Unpicklable()], count=1, executor=pool)

    def test_a_process_that_cannot_import_a_part_raises(self):
        lost = SerializedPlan("lost", b"cnowhere_to_be_found\nelbow\n.")
        with pytest.raises(PlanDeserializationError, match=r"nowhere_to_be_found.*top level of a module"):
            run_serialized(lost, None)
