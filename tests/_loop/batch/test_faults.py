"""Batches that are interrupted, spread over processes, saved, and found again after faults."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik._loop.batch import file as batch_file
from jtik._loop.batch.pool import solve_block
from jtik._loop.native import search_source as native_source
from jtik._loop.native.search import NativeSearch
from jtik_formulations import JointCentering

from ...conftest import shared_solver

TARGETS = np.random.default_rng(3).uniform(-2.4, 2.4, (60, 2))
Q0 = np.full(4, 0.3)
COLUMNS = ("q", "converged", "position_error", "orientation_error", "iterations", "escapes", "restarts", "targets")


def solver(**options):
    return shared_solver(jtik.Robot.planar(4), jtik.FrameTask(kind="position"), **options)


@pytest.fixture
def interruptible():
    """Ctrl-C raises KeyboardInterrupt, as in a shell; a process in the background may have been told to ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def same(one, other, rows=slice(None)):
    for name in COLUMNS:
        assert np.array_equal(getattr(one, name), getattr(other, name)[rows]), name
    assert list(one.status) == list(np.array(other.status)[rows])


class TestInterrupt:
    @pytest.mark.parametrize("compiled", [False, True])
    def test_returns_what_is_done(self, compiled):
        ik = solver(compiled=compiled)

        def report(done, total):
            if done == 20:
                raise KeyboardInterrupt

        batch = ik.solve_batch(TARGETS, q0=Q0, progress=report)
        assert not batch.complete
        assert batch.indices.tolist() == list(range(20))
        assert "; incomplete" in repr(batch)
        complete = ik.solve_batch(TARGETS, q0=Q0)
        assert complete.complete
        assert complete.indices.tolist() == list(range(60))
        same(batch, complete, slice(20))
        assert np.array_equal(batch[3].jacobian, complete[3].jacobian)

    @pytest.mark.slow
    def test_a_signal_ends_a_batch_in_c(self, monkeypatch, interruptible):
        ik, search = solver(compiled=True), NativeSearch.batch

        def batch_with_signal(*arguments):
            monkeypatch.setattr(NativeSearch, "batch", search)
            threading.Timer(0.01, os.kill, [os.getpid(), signal.SIGINT]).start()
            return search(*arguments)

        def first_batch(*arguments):
            monkeypatch.setattr(NativeSearch, "batch", batch_with_signal)
            return search(*arguments)

        monkeypatch.setattr(NativeSearch, "batch", first_batch)
        many = np.tile([[5.0, 0.0]], (20_000, 1))  # out of reach
        batch = ik.solve_batch(many, q0=Q0)
        assert not batch.complete
        assert 0 < len(batch) < len(many)

    def test_a_signal_ends_the_threads_of_a_batch(self, monkeypatch, interruptible):
        ik, search, called = solver(compiled=True), NativeSearch.batch, []
        both = threading.Barrier(2, timeout=60)

        def batch_with_signal(*arguments):
            own = threading.get_ident()
            called.append(own)
            if called.count(own) == 1:
                both.wait()
            if len(called) == 20:
                os.kill(os.getpid(), signal.SIGINT)
            return search(*arguments)

        expected = ik.solve_batch(np.tile(TARGETS, (100, 1)), q0=Q0)
        monkeypatch.setattr(NativeSearch, "batch", batch_with_signal)
        batch = ik.solve_batch(np.tile([[1.5, 1.0]], (240_000, 1)), q0=Q0, threads=2)
        monkeypatch.setattr(NativeSearch, "batch", search)
        assert not batch.complete
        assert batch.converged.sum() > 0
        assert "jtik batch" not in [each.name for each in threading.enumerate()]
        same(ik.solve_batch(np.tile(TARGETS, (100, 1)), q0=Q0, threads=2), expected)

    @pytest.mark.parametrize("restarts", [0, 40])
    def test_a_search_in_c_gives_way_to_python_and_ends_with_the_same_numbers(self, restarts, monkeypatch):
        expected = solver(compiled=True).solve_batch(TARGETS, q0=Q0, restarts=restarts)
        monkeypatch.setattr(native_source, "BUDGET", 0.0)
        monkeypatch.setattr(native_source, "CHECKED", 3)
        interrupted = jtik.InverseKinematics(jtik.Robot.planar(4), jtik.FrameTask(kind="position"), compiled=True)
        same(interrupted.solve_batch(TARGETS, q0=Q0, restarts=restarts), expected)
        alone = [interrupted.solve(target, q0=Q0, restarts=restarts) for target in TARGETS]
        assert np.array_equal([one.q for one in alone], expected.q)
        assert [one.iterations for one in alone] == expected.iterations.tolist()


class TestExecutor:
    @pytest.mark.slow
    @pytest.mark.parametrize("criteria", ["joint_centering", None])
    def test_gives_the_same_numbers(self, criteria):
        ik = solver(criteria=criteria)
        if criteria:
            ik.parameters["joint_centering.weight"] = 0.3
        serial = ik.solve_batch(TARGETS, q0=Q0, restarts=5)
        seen = []
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
            spread = ik.solve_batch(
                TARGETS, q0=Q0, restarts=5, executor=pool, block=7, progress=lambda *now: seen.append(now)
            )
        same(spread, serial)
        assert seen[-1] == (60, 60)
        for i in (0, 30, 59):
            assert np.array_equal(spread[i].jacobian, serial[i].jacobian)

    def test_a_start_each_in_threads(self):
        ik, starts = solver(criteria=JointCentering()), np.random.default_rng(0).uniform(-1, 1, (60, 4))
        with ThreadPoolExecutor(3) as pool:
            same(ik.solve_batch(TARGETS, q0=starts, executor=pool, block=11), ik.solve_batch(TARGETS, q0=starts))

    def test_an_interrupt_keeps_what_is_done(self):
        ik = solver()

        def report(done, total):
            if done == 15:
                raise KeyboardInterrupt

        with ThreadPoolExecutor(1) as pool:
            batch = ik.solve_batch(TARGETS, q0=Q0, executor=pool, block=10, progress=report)
        assert len(batch) >= 15
        assert batch.complete is (len(batch) == 60)
        same(batch, ik.solve_batch(TARGETS, q0=Q0), batch.indices)

    @pytest.mark.slow
    def test_a_dask_cluster_gives_the_same_numbers(self):
        distributed = pytest.importorskip("distributed")
        ik = solver()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Dask warns about ports and sockets
            cluster = distributed.LocalCluster(
                n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None, silence_logs=50
            )
            with cluster, distributed.Client(cluster) as client:
                batch = ik.solve_batch(TARGETS, q0=Q0, executor=client.get_executor(), block=7)
        same(ik.solve_batch(TARGETS, q0=Q0), batch)

    def test_what_is_no_executor_and_what_cannot_be_sent_are_named(self):
        @jtik.criterion
        def local(q, robot):
            return q[0] ** 2

        with pytest.raises(jtik.ArgumentError, match="executor: given 4; accepted: a concurrent.futures.Executor"):
            solver().solve_batch(TARGETS, executor=4)
        with pytest.raises(jtik.ArgumentError, match="block: given 0; accepted: a positive integer"):
            solver().solve_batch(TARGETS, block=0)
        with ThreadPoolExecutor(1) as pool, pytest.raises(jtik.ArgumentError, match="cannot be pickled.*local"):
            solver(criteria=local).solve_batch(TARGETS, executor=pool)
        with pytest.raises(jtik.JtikError, match="cannot rebuild the solver"):
            solve_block("x", b"junk", [], [], ())

    def test_an_error_of_a_process_is_raised_and_the_rest_is_saved(self, tmp_path):
        class Failing(ThreadPoolExecutor):
            def submit(self, *arguments, **options):
                if self.count == 3:
                    future = Future()
                    future.set_exception(RuntimeError("the process is gone"))
                    return future
                self.count += 1
                return super().submit(*arguments, **options)

        ik, path = solver(), tmp_path / "batch.npz"
        with Failing(1) as pool:
            pool.count = 0
            with pytest.raises(RuntimeError, match="the process is gone"):
                ik.solve_batch(TARGETS, q0=Q0, executor=pool, block=10, save=path)
        same(ik.solve_batch(TARGETS, q0=Q0, save=path), ik.solve_batch(TARGETS, q0=Q0))


class TestSaved:
    def test_a_batch_goes_on_where_it_was_interrupted(self, tmp_path, monkeypatch):
        ik, path = solver(criteria=JointCentering()), tmp_path / "batch.npz"

        def report(done, total):
            if done == 20:
                raise KeyboardInterrupt

        first = ik.solve_batch(TARGETS, q0=Q0, progress=report, save=path)
        assert len(first) == 20
        totals = []
        second = ik.solve_batch(TARGETS, q0=Q0, progress=lambda done, total: totals.append(total), save=path)
        assert totals == [40] * 40
        same(second, ik.solve_batch(TARGETS, q0=Q0))
        assert second.seconds[:20].tolist() == first.seconds.tolist()
        assert np.array_equal(second[3].jacobian, first[3].jacobian)
        totals.clear()
        same(ik.solve_batch(TARGETS, q0=Q0, progress=lambda *_: totals.append(1), save=path), second)
        assert totals == []
        assert [each.name for each in tmp_path.iterdir()] == ["batch.npz"]

    def test_another_batch_is_refused(self, tmp_path):
        ik, path = solver(criteria=JointCentering()), tmp_path / "batch.npz"
        ik.solve_batch(TARGETS[:3], q0=Q0, save=path)
        other = {
            "targets": lambda: ik.solve_batch(TARGETS[1:4], q0=Q0, save=path),
            "start": lambda: ik.solve_batch(TARGETS[:3], q0=Q0 + 1, save=path),
            "options": lambda: ik.solve_batch(TARGETS[:3], q0=Q0, position_tolerance=1e-3, save=path),
            "solver": lambda: solver().solve_batch(TARGETS[:3], q0=Q0, save=path),
        }
        for solve in other.values():
            with pytest.raises(jtik.ArgumentError, match=r"save: given .*batch.npz, which holds another batch"):
                solve()
        ik.parameters["joint_centering.weight"] = 2.0
        with pytest.raises(jtik.ArgumentError, match="another batch"):
            ik.solve_batch(TARGETS[:3], q0=Q0, save=path)

    @pytest.mark.parametrize("name", ["batch.txt", "no/batch.npz", "b\0.npz"])
    def test_a_name_that_cannot_be_used(self, tmp_path, name):
        with pytest.raises(jtik.ArgumentError, match="save: given"):
            solver().solve_batch(TARGETS, save=f"{tmp_path}/{name}")

    def test_a_full_disk_does_not_cost_the_batch(self, tmp_path, monkeypatch):
        def full(*_):
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr(batch_file, "write_archive", full)
        monkeypatch.setattr(batch_file, "PAUSE", 0.0)
        with pytest.warns(RuntimeWarning, match="the batch was not saved: .*No space left") as warned:
            batch = solver().solve_batch(TARGETS, q0=Q0, save=tmp_path / "batch.npz")
        assert warned[0].filename == __file__
        same(batch, solver().solve_batch(TARGETS, q0=Q0))


KILLED = """
import sys
import numpy as np
import jtik
from jtik._loop.batch import file as batch_file
batch_file.PAUSE, batch_file.SHARE = 0.0, 1e9
ik = jtik.InverseKinematics(jtik.Robot.planar(4), jtik.FrameTask(kind="position"))
targets = np.random.default_rng(3).uniform(-2.4, 2.4, (60, 2))
print("ready", flush=True)
ik.solve_batch(targets, q0=np.full(4, 0.3), save=sys.argv[1])
print("done", flush=True)
"""


@pytest.mark.slow
def test_a_batch_that_is_killed_again_and_again_is_found_again(tmp_path):
    ik, path = solver(), tmp_path / "batch.npz"
    expected, found = ik.solve_batch(TARGETS, q0=Q0), [0]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(each for each in sys.path if each)}
    for patience, moment in ((0.0, 0.0), (0.0, 0.02), (0.0, 0.04), (60.0, 0.01)):  # the last one has stored something
        call = [sys.executable, "-c", KILLED, str(path)]
        with subprocess.Popen(call, stdout=subprocess.PIPE, env=environment) as process:
            process.stdout.readline()
            end = time.monotonic() + patience
            while not path.exists() and time.monotonic() < end:
                time.sleep(0.001)
            time.sleep(moment)
            process.send_signal(signal.SIGKILL)
        file = batch_file.BatchFile(path, (ik.identity, *_rest()), 60, 4)
        found.append(len(file.known.numbers))
        assert np.array_equal(file.known.q, expected.q[file.known.numbers])
    assert found == sorted(found)
    assert found[-1] > 0
    same(ik.solve_batch(TARGETS, q0=Q0, save=path), expected)


def _rest():
    """The targets, the starts and the options of the batch, as it identifies itself by them."""
    return list(TARGETS), [Q0], (0, None, 1000, 1, None, 1e-6, 1e-6, 1e-6, "stationary")
