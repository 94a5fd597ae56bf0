"""Studies on executors give the figures of a serial study."""

from __future__ import annotations

import multiprocessing
import warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

import jtik
from jtik_formulations import Damped, JointCentering


@jtik.criterion
def elbow_height(q, robot, *, height=1.0):
    """A criterion at the top level of a module."""
    return (robot.position(q, robot.frame_names[2])[1] - height) ** 2


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


@pytest.mark.slow
def test_serial_runs_agree(serial, arm, task, assert_same):
    assert_same(serial, jtik.compare(arm, task, **options(arm, task)))


@pytest.mark.slow
def test_figures_do_not_depend_on_the_unit_size(serial, arm, task, assert_same):
    assert_same(serial, jtik.compare(arm, task, **{**options(arm, task), "block": 100}))


@pytest.mark.slow
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


@pytest.mark.slow
def test_threads_give_the_same_figures(serial, arm, task, assert_same):
    with ThreadPoolExecutor(3) as pool:
        assert_same(serial, jtik.compare(arm, task, **options(arm, task), executor=pool))


@pytest.mark.slow
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
