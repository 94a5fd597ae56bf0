"""The meshes that the page draws: normals, the layout of the data, and what is said where there are none."""

from __future__ import annotations

import json
from urllib.parse import unquote

import numpy as np
import pytest

from jtik.planner import Planner
from jtik.planner.session.arm import Arm
from jtik.planner.web.desk import Desk
from jtik.planner.web.documents import NOTES
from jtik.planner.web.meshes import encoded, shaded
from jtik.planner.web.server import Server

from .plated import CORNERS, MIDDLE, TRIANGLES, plated_arm
from .test_server import get


def parts(data: bytes) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Frame, corners with normals and triangles of each part, by the description of the layout."""
    words, found, at = np.frombuffer(data, "<u4"), [], 1
    for _ in range(words[0]):
        frame, c, t = (int(each) for each in words[at : at + 3])
        at += 3
        corners = words[at : at + 6 * c].view("<f4").reshape(c, 6)
        at += 6 * c
        found.append((frame, corners, words[at : at + 3 * t].reshape(t, 3)))
        at += 3 * t
    assert at == len(words)
    return found


def area(places: np.ndarray) -> float:
    """Of triangles (t, 3, 3)."""
    a, b, c = places.transpose(1, 0, 2)
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_a_box_has_edges() -> None:
    corners, triangles = shaded(CORNERS, TRIANGLES)
    for triangle in corners[triangles]:
        places, normals = triangle[:, :3], triangle[:, 3:]
        side = np.flatnonzero(np.ptp(places, axis=0) == 0)[0]
        np.testing.assert_allclose(normals, np.tile(np.sign(places[0, side]) * np.eye(3)[side], (3, 1)), atol=1e-12)
    assert area(corners[triangles][:, :, :3]) == pytest.approx(2 * (0.3 * 0.3 + 2 * 0.3 * 0.04))


def ball(rows: int = 24, columns: int = 48) -> tuple[np.ndarray, np.ndarray]:
    """A ball of radius 2, each triangle with corners of its own, as in an STL file."""
    height, around = np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1)
    around[-1] = 0.0
    places = np.stack(
        [
            2 * np.sin(height)[:, None] * np.cos(around),
            2 * np.sin(height)[:, None] * np.sin(around),
            2 * np.repeat(np.cos(height)[:, None], columns + 1, axis=1),
        ],
        axis=2,
    )
    a, b, c, d = places[:-1, :-1], places[1:, :-1], places[1:, 1:], places[:-1, 1:]
    corners = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def test_a_ball_is_smooth_and_its_corners_are_merged() -> None:
    vertices, faces = ball()
    corners, triangles = shaded(vertices, faces)
    assert len(corners) < len(vertices) / 5
    used = corners[np.unique(triangles)]
    assert np.einsum("cd,cd->c", used[:, :3] / 2, used[:, 3:]).min() > 0.995
    assert area(corners[triangles][:, :, :3]) == pytest.approx(16 * np.pi, rel=0.01)


def test_triangles_without_an_area_are_left_out() -> None:
    corners, triangles = shaded(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]]), np.array([[0, 1, 2], [0, 1, 3]])
    )
    assert len(triangles) == 1
    np.testing.assert_allclose(corners[triangles][0, :, 3:], [[0, 0, 1]] * 3)


def test_the_data_is_laid_out_as_described(tmp_path) -> None:
    robot = plated_arm(tmp_path)
    meshes = encoded(robot)
    ((frame, corners, triangles),) = parts(meshes.data)
    assert robot.frame_names[frame] == "link6"
    assert meshes.notes == ()
    np.testing.assert_allclose(np.unique(corners[triangles][..., :3].reshape(-1, 3).round(6), axis=0), CORNERS + MIDDLE)


def test_a_file_that_cannot_be_read_is_told_and_the_others_are_shown(tmp_path) -> None:
    robot = plated_arm(tmp_path)
    (tmp_path / "plate.obj").write_text("this is no mesh")
    meshes = encoded(robot)
    assert parts(meshes.data) == []
    assert len(meshes.notes) == 1
    assert meshes.notes[0].startswith("link6 is shown by capsules: ")
    assert "plate.obj" in meshes.notes[0]


@pytest.mark.parametrize(("name", "said"), [("plate.obj", ""), ("other.obj", "names no mesh files")])
def test_the_setup_says_why_there_are_no_meshes(tmp_path, name: str, said: str) -> None:
    robot = plated_arm(tmp_path, file=name)
    found = Arm(robot, robot.tip).description()["no_meshes"]
    assert found == said if not said else said in found


def test_the_setup_says_that_the_files_are_gone(tmp_path) -> None:
    robot = plated_arm(tmp_path)
    (tmp_path / "plate.obj").unlink()
    assert "plate.obj" in Arm(robot, robot.tip).description()["no_meshes"]


@pytest.mark.slow
def test_they_are_served(tmp_path) -> None:
    with Planner(plated_arm(tmp_path), folder=False) as planner, Server(Desk(planner.loop), port=0) as server:
        status, body, headers = get(server.port, "/meshes")
        (tmp_path / "plate.obj").unlink()  # it is read once
        again = get(server.port, "/meshes")[1]
    assert status == 200
    assert body == again
    assert len(parts(body)) == 1
    assert json.loads(unquote(headers[NOTES])) == []
