"""The planner's server without a browser: who may open it, what it serves, and what it makes of messages."""

from __future__ import annotations

import http.client
import json
import re

import numpy as np
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import jtik
from jtik.planner import Planner
from jtik.planner.web.http import FILES, PAGE
from jtik.planner.web.outgoing import MODES
from jtik.planner.web.server import PortInUseError, Server

from .waiting import is_still, wait_for


def get(port, path, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body, answer.headers


def join(server, origin=None):
    host = f"127.0.0.1:{server.port}"
    return connect(f"ws://{host}/socket", origin=origin or f"http://{host}", open_timeout=10, close_timeout=0.5)


def texts(socket, kind, count=1):
    """The next messages of a kind."""
    found = []
    while len(found) < count:
        message = socket.recv(timeout=10)
        if isinstance(message, str) and json.loads(message)["type"] == kind:
            found.append(json.loads(message))
    return found if count > 1 else found[0]


def frame(socket):
    """The next frame, as the layout of its numbers says."""
    while isinstance(message := socket.recv(timeout=10), str):
        pass
    numbers = np.frombuffer(message, "<f4")
    names = ("tick", "time", "mode", "recording", "d", "nq", "frames", "shown")
    head = dict(zip(names, numbers[:8].tolist(), strict=True))
    nq, count = int(head["nq"]), int(head["frames"])
    rest = numbers[8:]
    assert len(rest) == 7 + nq + 7 * count
    return head, rest[:7], rest[7 : 7 + nq], rest[7 + nq :].reshape(count, 7)


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", sorted(FILES))
def test_every_file_of_the_page_is_served(server, name):
    status, body, headers = get(server.port, name)
    assert status == 200
    assert body == FILES[name].read_bytes()
    kinds = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml"}
    assert headers["Content-Type"].startswith(kinds[FILES[name].suffix])


def test_the_page_needs_nothing_from_elsewhere(server):
    _, _, headers = get(server.port, "/")
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    for path in PAGE.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        assert "http://" not in text
        assert "https://" not in text


@pytest.mark.parametrize(
    "path",
    [
        "/../server.py",
        "/..%2fserver.py",
        "/page/../../server.py",
        "//etc/passwd",
        "/style.css/",
        "/none.js",
        "/%00",
        "//[",
    ],
)
def test_no_other_file_is_served(server, path):
    status, body, _ = get(server.port, path)
    assert status == 404
    assert b"import" not in body


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "http://localhost.evil.example"]
)
def test_a_foreign_page_may_not_open_the_socket(server, origin):
    with pytest.raises(InvalidStatus) as refused, join(server, origin):
        pass
    assert refused.value.response.status_code == 403


def test_a_client_without_an_origin_may_not_open_the_socket(server):
    with pytest.raises(InvalidStatus) as refused, connect(f"ws://127.0.0.1:{server.port}/socket"):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "evil.example:80", "", "[::"])
def test_a_name_that_a_foreign_page_leads_here_is_refused(server, host):
    assert get(server.port, "/", Host=host)[0] == 403


def test_localhost_is_this_machine(server):
    assert get(server.port, "/", Host=f"localhost:{server.port}")[0] == 200


def test_a_page_is_told_everything_when_it_opens(server, planner):
    with join(server) as socket:
        setup = texts(socket, "setup")
        assert setup["robot"]["nq"] == planner.arm.robot.nq
        assert list(setup["frames"]) == list(planner.arm.robot.frame_names)
        settings = texts(socket, "settings")
        assert len(settings["preferred"]) == planner.arm.robot.nq
        head, target, q, poses = frame(socket)
        assert MODES[int(head["mode"])] == "live"
        assert head["shown"] == -1
        tip = planner.arm.robot.frame_names.index(planner.arm.tip)
        np.testing.assert_allclose(poses[tip, :2], planner.arm.robot.position(q.astype(float)), atol=1e-5)
        np.testing.assert_allclose(target[:2], planner.loop.frame.position, atol=1e-3)


def test_the_status_comes_apart_from_frames(server):
    with join(server) as socket:
        first, second = (each["heartbeat"] for each in texts(socket, "status", 2))
        assert second > first


def test_an_edit_moves_the_target_and_the_arm(server, planner):
    with join(server) as socket:
        goal = planner.loop.frame.position + np.array([0.3, 0.1])
        socket.send(json.dumps({"edit": "move_target", "position": goal.tolist()}))
        wait_for(lambda: np.allclose(planner.loop.frame.position, goal))
        robot = planner.arm.robot
        wait_for(lambda: np.allclose(robot.position(planner.loop.frame.q), goal, atol=1e-3))


def test_nothing_is_sent_twice(server, planner):
    with join(server) as socket:
        wait_for(lambda: is_still(planner))
        texts(socket, "status", 3)
        seen = []
        while len(seen) < 12:
            message = socket.recv(timeout=10)
            seen.append(message[8:] if isinstance(message, bytes) else json.loads(message)["type"])
        assert {"setup", "settings", "attempts"}.isdisjoint(seen)
        frames = [each for each in seen if isinstance(each, bytes)]
        assert len(frames) == len(set(frames))


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("not json", "no JSON"),
        (json.dumps({"type": "load_plan", "text": "{}", "name": "a" * 5000}), "no plan"),
        ('{"type": "load_plan", "text": "{}", "name": "../\\u0000.json"}', "no plan"),
        ('{"type": "load_plan", "text": "\\ud800"}', "no JSON"),
        ("[]", "edit"),
        ("7", "edit"),
        ('{"type": "other"}', "edit"),
        ('{"edit": "explode"}', "explode"),
        ('{"edit": "move_target"}', "position"),
        ('{"edit": "move_target", "position": ["a", 1]}', "position"),
        ('{"edit": "move_target", "position": [1e300, 0]}', "position"),
        ('{"edit": "save_plan", "path": "/tmp/plan.json"}', "no file"),
        ('{"edit": "load_plan", "path": "/etc/passwd"}', "no file"),
        ("[" * 5000 + "]" * 5000, ""),
        (b"\xff\xfe\x00", ""),
    ],
)
def test_a_message_that_is_no_command_is_answered(server, message, words):
    with join(server) as socket:
        texts(socket, "setup")
        socket.send(message)
        answer = texts(socket, "message")
        assert answer["level"] == "error"
        assert words in answer["text"]
        socket.send('{"type": "hello"}')
        texts(socket, "status")  # the socket is still open


def test_only_the_sender_is_told_of_its_mistake(server):
    with join(server) as one, join(server) as other:
        one.send("nonsense")
        assert texts(one, "message")["level"] == "error"
        kinds = [
            json.loads(each)["type"] for each in (other.recv(timeout=10) for _ in range(12)) if isinstance(each, str)
        ]
        assert "message" not in kinds


def test_a_page_that_is_gone_with_a_key_down_stops_the_target(server, planner):
    with join(server) as socket:
        before = planner.loop.frame.position.copy()
        socket.send(json.dumps({"edit": "hold_target", "velocity": [0.2, 0.0]}))
        wait_for(lambda: planner.loop.frame.position[0] > before[0] + 0.02)
    wait_for(lambda: is_still(planner))


def test_a_page_that_is_gone_in_mid_drag_stops_the_target(server, planner):
    start = planner.loop.frame.position.copy()
    with join(server) as socket:
        socket.send(json.dumps({"edit": "move_target", "position": [-9.0, 0.0]}))
        wait_for(lambda: not np.allclose(planner.loop.frame.position, start, atol=0.02))
    wait_for(lambda: is_still(planner))
    assert np.linalg.norm(planner.loop.frame.position - [-9.0, 0.0]) > 1.0


def test_a_page_that_only_looks_stops_nothing_when_it_is_gone(server, planner):
    with join(server) as one:
        with join(server) as other:
            texts(other, "status")
            before = planner.loop.frame.position.copy()
            one.send(json.dumps({"edit": "hold_target", "velocity": [0.0, 0.1]}))
            wait_for(lambda: planner.loop.frame.position[1] > before[1] + 0.01)
        here = planner.loop.frame.position[1]
        wait_for(lambda: planner.loop.frame.position[1] > here + 0.03)
    wait_for(lambda: is_still(planner))


@pytest.mark.slow
def test_a_page_that_reads_nothing_gets_the_newest_frame_and_holds_up_nobody(server, planner):
    with join(server) as slow, join(server) as quick:
        quick.send(json.dumps({"edit": "hold_target", "velocity": [0.0, -0.1]}))
        for _ in range(60):
            frame(quick)
        quick.send(json.dumps({"edit": "hold_target", "velocity": [0.0, 0.0]}))
        wait_for(lambda: is_still(planner))
        target = planner.loop.frame.position
        wait_for(lambda: np.allclose(frame(slow)[1][:2], target, atol=1e-5))


def test_a_port_in_use_is_told(server, planner):
    with pytest.raises(PortInUseError, match=f"port {server.port} cannot be opened"):
        Server(planner, port=server.port).start()


@pytest.mark.parametrize("port", [-1, 65536, "80", 1.5, True, None])
def test_a_wrong_port_is_refused(planner, port):
    with pytest.raises(Exception, match="port"):
        Server(planner, port=port)


def test_a_server_that_is_closed_can_be_closed_again(planner):
    server = Server(planner, port=0)
    with server:
        assert get(server.port, "/")[0] == 200
    server.close()
    with pytest.raises(ConnectionRefusedError):
        get(server.port, "/")


@pytest.mark.slow
def test_a_planner_shows_itself_in_a_notebook():
    with Planner(jtik.Robot.planar(3), folder=False) as planner:
        html = planner._repr_html_()
        url = re.search(r'src="(http://127\.0\.0\.1:\d+/)"', html)[1]
        port = int(url.split(":")[2].rstrip("/"))
        assert get(port, "/")[0] == 200
        assert planner._repr_html_() == html, "one server for all cells"
    with pytest.raises(ConnectionRefusedError):
        get(port, "/")
