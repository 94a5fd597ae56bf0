"""Studies on executors give the figures of a serial study."""

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


class Unpicklable(Contender):
    """Cannot be pickled."""

    label = "unpicklable"

    def __reduce__(self):
        raise TypeError("cannot be pickled")

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


def test_figures_do_not_depend_on_the_unit_size(serial, arm, task, assert_same):
    assert_same(serial, jtik.compare(arm, task, **{**options(arm, task), "block": 100}))


def test_a_process_pool_gives_the_same_figures(serial, arm, task, assert_same):
    reported = []
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        study = jtik.compare(
            arm, task, **options(arm, task), executor=pool, progress=lambda done, total: reported.append((done, total))
        )
    assert_same(serial, study)
    assert study.complete
    assert study.fingerprint == serial.fingerprint
    assert reported == [(done, 8) for done in range(1, 9)]


def test_threads_give_the_same_figures(serial, arm, task, assert_same):
    with ThreadPoolExecutor(3) as pool:
        assert_same(serial, jtik.compare(arm, task, **options(arm, task), executor=pool))


def test_a_dask_cluster_gives_the_same_figures(serial, arm, task, assert_same):
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Dask warns about ports and sockets
        cluster = distributed.LocalCluster(
            n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None, silence_logs=50
        )
        with cluster, distributed.Client(cluster) as client:
            workers = client.run(lambda: __import__("os").getpid())
            assert len(set(workers.values())) == 2
            study = jtik.compare(arm, task, **options(arm, task), executor=client.get_executor())
    assert_same(serial, study)


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

    def test_a_lambda_can_be_sent_with_cloudpickle(self, arm, task, assert_same):
        pytest.importorskip("cloudpickle")
        norm = jtik.criterion(lambda q, robot: q.T @ q)
        chosen = {**options(arm, task, norm), "strategies": "damped"}
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            assert_same(jtik.compare(arm, task, **chosen), jtik.compare(arm, task, **chosen, executor=pool))

    def test_without_cloudpickle_a_lambda_is_refused_with_a_hint(self, arm, task, monkeypatch):
        monkeypatch.setattr("jtik.study.serialization._pickler", lambda: pickle)
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
