"""``jtik plan`` as a process: wrong input in one line, Ctrl-C, and a kill in the middle of a recording."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest
from websockets.sync.client import connect

from jtik.cli import main
from jtik.planner.files.sessions import recoverable
from jtik.planner.web.server import PORT

PATIENCE = 120.0
"""Longest time to wait for the process [s]."""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("plan --port 70000", "0 to 65535"),
        ("plan --port -1", "0 to 65535"),
        ("plan --port here", "invalid int"),
        ("plan --robot pnada --port 0", "did you mean 'panda'"),
        ("plan --scene none.toml --port 0", "none.toml"),
        ("plan --robot planar:3 --strategy hybird --port 0", "did you mean 'hybrid'"),
        ("plan --robot planar:3 --criterion nothing --port 0", "nothing"),
    ],
)
def test_wrong_input_is_one_line(words, said, capsys):
    assert main(words.split()) == 2
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1


def test_a_wrong_scene_is_one_line(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text('[obstacles."disc"]\nshape = "disk"\ncenter = [1, 2]\n')
    assert main(["plan", "--scene", str(path), "--port", "0"]) == 2
    error = capsys.readouterr().err.strip()
    assert "disk" in error
    assert len(error.splitlines()) == 1


def test_a_port_in_use_is_one_line_and_told_at_once(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["plan", "--port", str(port)]) == 2
    printed = capsys.readouterr()
    assert f"port {port} cannot be opened" in printed.err
    assert len(printed.err.strip().splitlines()) == 1
    assert "building" not in printed.out
    assert PORT > 1024


class Running:
    """The command as a process of its own, and a page that talks to it."""

    def __init__(self, folder, *program):
        words = ["plan", "--no-browser", "--port", "0", "--robot", "planar:3", "--folder", str(folder)]
        self.process = subprocess.Popen(
            [sys.executable, *(program or ("-m", "jtik")), *words],
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # which a background process may ignore
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        assert self.process.stdout is not None
        self.printed = ""
        while not (found := re.search(r"http://(127\.0\.0\.1:\d+)/", self.printed)):
            line = self.process.stdout.readline()
            assert line, self.process.stderr.read()
            self.printed += line
        self.host = found[1]
        self.page = connect(f"ws://{self.host}/socket", origin=f"http://{self.host}", close_timeout=0.5)

    def ask(self, **edit):
        self.page.send(json.dumps(edit))

    def wait(self, kind, condition=lambda message: True):
        """The next message of a kind for which a condition holds."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self.page.recv(timeout=PATIENCE)
            if isinstance(message, str) and (found := json.loads(message))["type"] == kind and condition(found):
                return found
        raise AssertionError(f"no such {kind}")

    def position(self):
        """Position of the target in the next frame."""
        while isinstance(message := self.page.recv(timeout=PATIENCE), str):
            pass
        return np.frombuffer(message, "<f4")[8:10].astype(float)

    def end(self, number):
        """Send a signal, and give the exit code and what was printed as an error."""
        self.process.send_signal(number)
        _, error = self.process.communicate(timeout=PATIENCE)
        with contextlib.suppress(Exception):  # the process is gone
            self.page.close()
        return self.process.returncode, error


@pytest.mark.slow
def test_it_ends_cleanly(tmp_path):
    running = Running(tmp_path)
    running.wait("status")
    code, error = running.end(signal.SIGTERM)
    assert code == 0
    assert error.strip() == "the planner is closed"


ENDLESS = """
import sys, threading
import jtik
from jtik.cli import main
from jtik_formulations import Newton

@jtik.register_strategy("endless")
class Endless(Newton):
    def update(self, model, state):
        threading.Event().wait()

sys.exit(main(sys.argv[1:]))
"""
"""The command, with a strategy whose solver is never built."""


@pytest.mark.slow
def test_it_ends_while_a_solver_is_built(tmp_path):
    running = Running(tmp_path, "-c", ENDLESS)
    running.ask(edit="record")
    running.ask(edit="set_strategy", name="endless")
    running.wait("status", lambda found: found["rebuilding"])
    code, error = running.end(signal.SIGINT)
    assert code == 0
    assert error.strip() == "the planner is closed"
    (session,) = recoverable(tmp_path)
    assert session.closed


@pytest.mark.slow
def test_what_was_recorded_before_a_kill_is_offered_by_the_next_start(tmp_path):
    running = Running(tmp_path)
    start = running.position()
    running.ask(edit="record")
    for k in range(30):
        running.ask(edit="move_target", position=(start + 0.02 * (k + 1) * np.array([-1.0, 0.5])).tolist())
        time.sleep(0.1)
    running.end(signal.SIGKILL)

    again = Running(tmp_path)
    offered = again.wait("sessions")["sessions"]
    assert len(offered) == 1
    again.ask(edit="recover", session=offered[0]["name"])
    (attempt,) = again.wait("attempts", lambda found: found["attempts"])["attempts"]
    assert attempt["duration"] > 1.5, "three seconds were recorded, and one may be lost"
    code, error = again.end(signal.SIGINT)
    assert code == 0, error
