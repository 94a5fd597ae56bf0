"""The viewer: arms, obstacles and the time of their motions in a browser."""

from __future__ import annotations

import html
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from jtik.geometry import HalfSpace
from jtik.plotting.obstacles_in import obstacles_in
from jtik.plotting.style import COLORS, OBSTACLE_EDGE, SINGLE
from jtik.plotting.surfaces import Extent, obstacle_surface
from jtik.types import Array
from jtik.viewer.playing import Player
from jtik.viewer.server import HOST, start, stop
from jtik.viewer.shown_arm import ShownArm
from jtik.viewer.subjects import Size, Subject, size_of

if TYPE_CHECKING:
    from jtik.solver import InverseKinematics


class Viewer:
    """What `jtik.view` shows, at `url`. In a notebook it shows itself as the value of a cell.

    ``with jtik.view(...) as viewer:`` closes it at the end. It ends with the program; `wait` keeps a script running.

    Args:
        subjects: the arms and their motions, as `jtik.view` makes them.
        obstacles: obstacles to draw.
        show: "meshes", "shapes" or "links", what is drawn of a robot.
        port: port of the server; any free one when None.
        height: height of the frame in a notebook [pixel].
        unit: label of the time axis.
        rate: how much of the time passes in a second.
        title: title of the page.

    Attributes:
        arms: what is shown of each arm, in the order given: ``viewer.arms[0].move(q)`` moves the first one.
        player: the time of the motions; None where nothing moves by itself.
        obstacles: the nodes of the obstacles.
        url: its address on this machine.
    """

    def __init__(
        self,
        subjects: Sequence[Subject],
        obstacles: Sequence[Any],
        *,
        show: str,
        port: Any,
        height: int,
        unit: str = "time [s]",
        rate: float = 1.0,
        title: str = "jtik",
    ) -> None:
        self._height, self._subjects, self._given = height, list(subjects), tuple(obstacles)
        self._show, self._closed = show, threading.Event()
        self._server = start(port, title)
        self.url = f"http://{HOST}:{self._server.get_port()}"
        self.obstacles: list[Any] = []
        self.player: Player | None = None
        self.arms: list[ShownArm] = []
        try:
            end = max(float(subject.times[-1]) for subject in subjects)
            if any(subject.moves for subject in subjects):
                self.player = Player(self._server.gui, unit, end, rate, self._at)
            self._show_all()
        except BaseException:
            self.close()
            raise

    def _show_all(self) -> None:
        size = size_of(self._subjects, self._given)
        with self._server.atomic():
            self._draw_obstacles(size.extent)
            for k, subject in enumerate(self._subjects):
                single = len(self._subjects) == 1
                color = rgb(SINGLE if single else COLORS[k % len(COLORS)])
                arm = ShownArm(self._server, subject, color=color, show=self._show, expanded=single)
                self.arms.append(arm)
            self._place_camera(size)

    def _place_camera(self, size: Size) -> None:
        camera, planar = self._server.initial_camera, size.planar
        camera.look_at = size.extent.middle
        offset = np.array([0.0, -1e-3, 1.0]) if planar else np.array([0.75, -1.0, 0.5])
        away = (1.2 if planar else 1.35) * size.extent.radius
        camera.position = size.extent.middle + away * offset / np.linalg.norm(offset)
        camera.up = (0.0, 1.0, 0.0) if planar else (0.0, 0.0, 1.0)
        if not any(isinstance(each, HalfSpace) for each in self._every()):  # else that is the floor
            self._add_floor(size)

    def _add_floor(self, size: Size) -> None:
        cell = 10.0 ** np.floor(np.log10(max(size.extent.radius, 1e-3)))
        self._server.scene.add_grid(
            "/floor",
            width=40 * cell,
            height=40 * cell,
            cell_size=cell / 2,
            section_size=cell,
            cell_color=(225, 227, 230),
            section_color=(205, 208, 212),
            position=(0.0, 0.0, -3 * size.thickness if size.planar else 0.0),
            fade_distance=12 * size.extent.radius,
        )

    def _every(self) -> tuple[Any, ...]:
        """The obstacles that are shown."""
        return self._given or tuple(each for subject in self._subjects for each in subject.obstacles)

    def _draw_obstacles(self, extent: Extent) -> None:
        for node in self.obstacles:
            node.remove()
        self.obstacles = []
        for k, obstacle in enumerate(self._every()):
            each = obstacle_surface(obstacle, extent)
            vertices, faces = each.vertices.astype(np.float32), each.faces.astype(np.uint32)
            style = {"color": rgb(OBSTACLE_EDGE), "opacity": 0.75, "flat_shading": not each.smooth, "side": "double"}
            self.obstacles.append(self._server.scene.add_mesh_simple(f"/obstacles/{k}", vertices, faces, **style))

    def _at(self, moment: float) -> None:
        """Move the arms that have a motion to a time."""
        with self._server.atomic():
            for arm in self.arms:
                if arm.subject.moves:
                    arm.move(arm.subject.at(moment))

    def update(self, ik: InverseKinematics) -> None:
        """Take the live parameters of a solver: its obstacles are drawn, and targets are followed with them.

        Args:
            ik: the solver that was given to `jtik.view`.
        """
        if not self._given:
            for k, subject in enumerate(self._subjects):
                if subject.ik is ik:
                    self._subjects[k] = subject.with_obstacles(obstacles_in(ik.parameters))
        for arm in self.arms:
            if arm.subject.ik is ik and arm.target is not None:
                arm.target.update(ik)
        self._draw_obstacles(size_of(self._subjects, self._given).extent)

    def replace(self, subjects: Sequence[Subject], obstacles: Sequence[Any]) -> None:
        """Show other subjects and obstacles; the view stays.

        Args:
            subjects: the arms and their motions, as `jtik.view` makes them.
            obstacles: obstacles to draw.
        """
        for arm in self.arms:
            arm.remove()
        self.arms, self._subjects, self._given = [], list(subjects), tuple(obstacles)
        if self.player is not None:
            self.player.end = max(float(subject.times[-1]) for subject in subjects)
        self._show_all()

    @property
    def gui(self) -> Any:
        """viser's panel, for elements of your own."""
        return self._server.gui

    @property
    def scene(self) -> Any:
        """viser's scene, for nodes of your own."""
        return self._server.scene

    @property
    def q(self) -> dict[str, Array]:
        """The configuration (nq,) of each arm, by its label."""
        return {arm.subject.label: arm.q for arm in self.arms}

    def wait(self) -> None:
        """Wait until it is closed, or for Ctrl-C."""
        try:
            while not self._closed.wait(0.5):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """End the server; its port is free again."""
        if not self._closed.is_set():
            self._closed.set()
            if self.player is not None:
                self.player.close()
            stop(self._server)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        names = ", ".join(subject.label for subject in self._subjects)
        return f"Viewer: {names} at {self.url}{' (closed)' if self._closed.is_set() else ''}"

    def _repr_html_(self) -> str:
        if self._closed.is_set():
            return html.escape(repr(self))
        title = html.escape(repr(self))
        return f'<iframe src="{self.url}" height="{self._height}" style="width:100%;border:0" title="{title}"></iframe>'


def rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of a colour such as "#0072b2"."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
