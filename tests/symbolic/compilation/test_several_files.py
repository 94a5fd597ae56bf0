"""The compilation of a solver: its progress, and Ctrl-C, which ends the compilers and leaves nothing behind."""

from __future__ import annotations

import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik._loop.lanes import search as lane_search
from jtik.symbolic.compilation import c_compiler, library_cache
from jtik.symbolic.compile import CompilerError, compiler

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and scripts of POSIX")

SLOW = """
import os, signal, sys, time
if "-o" not in sys.argv:
    sys.exit(print("1.0"))
{first}
open(sys.argv[sys.argv.index("-o") + 1], "w").write("half")
open({pids!r} + "/" + str(os.getpid()), "w").close()
time.sleep(100)
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    try:
        compiler()
    except CompilerError as error:
        pytest.skip(str(error))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(c_compiler, "OPTIONS", ("-O0",))  # which compiles faster
    library_cache._temporary.cache_clear()
    return tmp_path / "jtik"


@pytest.fixture
def pids(tmp_path):
    folder = tmp_path / "pids"
    folder.mkdir()
    return folder


@pytest.fixture
def slow_compiler(tmp_path, pids, monkeypatch):
    """A compiler that writes half a library and then goes on for ever."""

    def use(first=""):
        path = tmp_path / "cc"
        path.write_text(f"#!{sys.executable}\n" + SLOW.format(first=first, pids=str(pids)))
        path.chmod(0o755)
        monkeypatch.setenv("CC", str(path))

    return use


@pytest.fixture
def interruptible():
    """Ctrl-C raises KeyboardInterrupt, as in a shell; a process in the background may have been told to ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def waiting(folder, count):
    """Wait until so many compilers run."""
    for _ in range(3000):
        if len(list(folder.iterdir())) >= count:
            return
        time.sleep(0.01)
    raise AssertionError(f"{count} compilers never ran")


def running(folder):
    """The compilers that still run."""
    found = []
    for each in folder.iterdir():
        try:
            os.kill(int(each.name), 0)
        except ProcessLookupError:
            continue
        found.append(each.name)
    return found


def solver(**options):
    given = {"criteria": "joint_centering", "strategy": "hybrid+qp"} | options
    return jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask(kind="position"), **given)


def interrupt_after(action):
    """Send this process Ctrl-C after an action, from another thread."""

    def send():
        action()
        os.kill(os.getpid(), signal.SIGINT)

    sender = threading.Thread(target=send)
    sender.start()
    return sender


def is_progress(calls):
    return all(0 <= done <= total for done, total in calls) and all(
        before[0] <= after[0] and before[1] <= after[1] for before, after in itertools.pairwise(calls)
    )


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid", "hybrid+qp"])
def test_each_file_counts_and_at_the_end_all_are_done(cache, strategy):
    calls = []
    ik = solver(strategy=strategy, compiled=True, progress=lambda *now: calls.append(now))
    files = len(list(cache.glob("*.so")))
    assert calls[0] == (0, 1)
    assert calls[-1] == (files + 1, files + 1)
    assert files >= 3
    assert is_progress(calls)
    later = []
    ik.warm_up(progress=lambda *now: later.append(now))
    more = len(list(cache.glob("*.so"))) - files
    assert more > 0
    assert is_progress(later)
    assert later[-1][0] == later[-1][1] >= 6 + more


def test_without_a_compiler_the_parts_count():
    calls = []
    ik = solver(progress=lambda *now: calls.append(now))
    assert calls == [(0, 1), (1, 1)]
    calls.clear()
    ik.warm_up(progress=lambda *now: calls.append(now))
    assert calls == [(i, 6) for i in range(7)]


def test_a_bar_is_on_stderr(capsys):
    pytest.importorskip("rich")
    solver(progress=True).warm_up(progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    assert "building" in err


def test_a_function_that_raises_ends_the_compilation(cache, slow_compiler, pids):
    slow_compiler()

    def report(done, total):
        if total > 2:
            waiting(pids, 1)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solver(compiled=True, progress=report)
    assert running(pids) == []
    assert list(cache.iterdir()) == []


@pytest.mark.parametrize("first", ["", "signal.signal(signal.SIGTERM, signal.SIG_IGN)"])
def test_ctrl_c_ends_the_compilers_and_leaves_nothing(cache, slow_compiler, pids, interruptible, monkeypatch, first):
    monkeypatch.setattr(c_compiler, "PATIENCE", 0.1)  # for one that does not end when it is asked to
    slow_compiler(first)
    sender = interrupt_after(lambda: waiting(pids, 2))
    with pytest.raises(KeyboardInterrupt):
        solver(compiled=True)
    sender.join()
    assert len(list(pids.iterdir())) >= 2
    assert running(pids) == []
    assert list(cache.iterdir()) == []


def test_ctrl_c_ends_the_compilers_of_lanes(cache, slow_compiler, pids, interruptible, monkeypatch):
    ik = solver(criteria=None, strategy="damped")
    monkeypatch.setattr(lane_search, "highest_level", lambda: 0)
    slow_compiler()
    sender = interrupt_after(lambda: waiting(pids, 2))  # one for each precision
    with pytest.raises(KeyboardInterrupt):
        ik.solve_batch([[1.5, 1.0]], restarts=3, lanes=True)
    sender.join()
    assert len(list(pids.iterdir())) == 2
    assert running(pids) == []
    assert list(cache.iterdir()) == []


@pytest.mark.slow
def test_after_ctrl_c_in_warm_up_the_solver_goes_on(cache, slow_compiler, pids, interruptible, monkeypatch):
    ik = solver(strategy="hybrid", compiled=True)
    end = time.monotonic() + 60
    while any(each.name.startswith("building") for each in cache.iterdir()) and time.monotonic() < end:
        time.sleep(0.05)  # what the solver does not wait for
    before = set(cache.iterdir())
    slow_compiler()
    sender = interrupt_after(lambda: waiting(pids, 1))
    with pytest.raises(KeyboardInterrupt):
        ik.warm_up()
    sender.join()
    assert running(pids) == []
    assert set(cache.iterdir()) == before
    monkeypatch.delenv("CC")
    ik.warm_up()
    assert len(set(cache.iterdir())) > len(before)
    q, target = np.array([0.3, 0.5, -0.2]), [1.5, 1.0]
    assert np.allclose(ik.step(q, target, dt=0.01).q, solver(strategy="hybrid").step(q, target, dt=0.01).q, atol=1e-12)


@pytest.mark.slow
def test_ctrl_c_on_the_command_line(cache, slow_compiler, pids):
    slow_compiler()
    root = Path(jtik.__file__).parents[1]
    path = os.pathsep.join([str(root), str(root / "formulations"), *sys.path])
    words = ["solve", "--robot", "planar:3", "--target", "1", "1", "--criterion", "joint_centering", "--compiled"]
    with subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, *words],
        env=os.environ | {"PYTHONPATH": path},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        waiting(pids, 2)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        _, err = process.communicate()
    assert process.returncode == 130
    assert err == "jtik: interrupted\n"
    assert running(pids) == []
    assert list(cache.iterdir()) == []


INTERRUPTIBLE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from jtik.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
def test_on_a_terminal_the_command_line_shows_a_bar(monkeypatch, capsys):
    pytest.importorskip("rich")
    from jtik.cli import main

    words = ["solve", "--robot", "planar:3", "--target", "1", "1"]
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main([*words, "--compiled"]) == 0
    assert "building" in capsys.readouterr().err
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert main(words) == 0
    assert "building" not in capsys.readouterr().err
