"""A study on other processes gives the numbers of a serial one."""

from __future__ import annotations

import multiprocessing
import pickle
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

import jtik
from jtik.study import Contender
from jtik.study.fingerprint import fingerprint
from jtik.study.serialization import PlanDeserializationError, SerializedPlan, run_serialized
from jtik.testing import example_criterion
from jtik_formulations import Damped, JointCentering


@jtik.criterion
def elbow_height(q, robot, *, height=1.0):
    """A criterion at the top level of a module."""
    return (robot.position(q, robot.frame_names[2])[1] - height) ** 2


class Stubborn(Contender):
    """Does not travel."""

    label = "stubborn"

    def __reduce__(self):
        raise TypeError("I stay here")

    def prepare(self, setting):
        raise AssertionError


def options(arm, task, criteria=None):
    problems = jtik.problems.reachable(arm, task, 7) + jtik.problems.circle(arm, task, 1, points=10)
    labels = {"none": None, "centred": 0.5 * JointCentering() + elbow_height(height=0.5)}
    return {
        "strategies": ["hybrid", Damped(damping=0.2), "nonsense", "transpose"],
        "criteria": labels if criteria is None else criteria,
        "problems": problems,
        "block": 2,
        "repeats": 1,
        "traces": 2,
    }


@pytest.fixture(scope="module")
def serial(arm, task):
    return jtik.compare(arm, task, **options(arm, task))


def test_serial_runs_agree(serial, arm, task, assert_same):
    assert_same(serial, jtik.compare(arm, task, **options(arm, task)))


def test_the_size_of_a_unit_makes_no_difference(serial, arm, task, assert_same):
    assert_same(serial, jtik.compare(arm, task, **{**options(arm, task), "block": 100}))


def test_a_process_pool_gives_the_same(serial, arm, task, assert_same):
    told = []
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        study = jtik.compare(
            arm, task, **options(arm, task), executor=pool, progress=lambda done, total: told.append((done, total))
        )
    assert_same(serial, study)
    assert study.complete
    assert study.fingerprint == serial.fingerprint
    assert told == [(done, 8) for done in range(1, 9)]


def test_threads_give_the_same(serial, arm, task, assert_same):
    with ThreadPoolExecutor(3) as pool:
        assert_same(serial, jtik.compare(arm, task, **options(arm, task), executor=pool))


def test_a_dask_cluster_gives_the_same(serial, arm, task, assert_same):
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Dask's own, about ports and sockets
        cluster = distributed.LocalCluster(
            n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None, silence_logs=50
        )
        with cluster, distributed.Client(cluster) as client:
            workers = client.run(lambda: __import__("os").getpid())
            assert len(set(workers.values())) == 2
            study = jtik.compare(arm, task, **options(arm, task), executor=client.get_executor())
    assert_same(serial, study)


class TestTravelling:
    @pytest.mark.parametrize("name", [*jtik.strategies, *(f"newton+{name}" for name in jtik.secondaries)])
    def test_every_strategy_travels(self, name):
        law = jtik.study.StrategyContender(jtik.registry.strategy_of(name))
        twin = pickle.loads(pickle.dumps(law))
        assert (twin.label, twin.strategy) == (law.label, law.strategy)
        assert fingerprint(twin) == fingerprint(law)

    @pytest.mark.parametrize("name", jtik.criteria)
    def test_every_criterion_travels(self, name, arm):
        criterion = example_criterion(jtik.criteria[name], arm)
        twin = pickle.loads(pickle.dumps(criterion))
        assert fingerprint(twin) == fingerprint(criterion)

    def test_a_criterion_of_a_module_pickles_by_its_name(self):
        twin = pickle.loads(pickle.dumps(elbow_height(height=0.3)))
        assert twin.value.__func__ is elbow_height.value.__func__
        assert twin._function is elbow_height._function
        assert twin.parameters(None) == {"height": 0.3}

    def test_a_lambda_travels_with_cloudpickle(self, arm, task, assert_same):
        pytest.importorskip("cloudpickle")
        bend = jtik.criterion(lambda q, robot: q.T @ q)
        chosen = {**options(arm, task, bend), "strategies": "damped"}
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            assert_same(jtik.compare(arm, task, **chosen), jtik.compare(arm, task, **chosen, executor=pool))

    def test_without_it_a_lambda_is_refused_with_what_to_do(self, arm, task, monkeypatch):
        monkeypatch.setattr("jtik.study.serialization._pickler", lambda: pickle)
        bend = jtik.criterion(lambda q, robot: q.T @ q)
        with (
            ThreadPoolExecutor(1) as pool,
            pytest.raises(jtik.ArgumentError, match=r"criteria\['bent'\].*cannot be pickled.*cloudpickle"),
        ):
            jtik.compare(arm, task, strategies="damped", criteria={"bent": bend}, count=1, executor=pool)

    def test_a_contender_that_does_not_travel_is_named(self, arm, task):
        with (
            ThreadPoolExecutor(1) as pool,
            pytest.raises(jtik.ArgumentError, match=r"strategies\['stubborn'\].*I stay here"),
        ):
            jtik.compare(arm, task, strategies=["damped", Stubborn()], count=1, executor=pool)

    def test_a_process_that_cannot_find_a_part_says_so(self):
        lost = SerializedPlan("lost", b"cnowhere_to_be_found\nelbow\n.")
        with pytest.raises(PlanDeserializationError, match=r"nowhere_to_be_found.*top level of a module"):
            run_serialized(lost, None)
