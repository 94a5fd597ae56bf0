"""One arm that is shown: its nodes, its panel and its target."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from jtik.errors import JtikError
from jtik.plotting.body import reach
from jtik.types import Array
from jtik.viewer.arm import ArmNodes, quaternion_of
from jtik.viewer.panel import ArmPanel
from jtik.viewer.subjects import Subject
from jtik.viewer.target import LiveTarget


class ShownArm:
    """One arm with sliders for its joints and, where its solver has one, a target to drag.

    Args:
        server: viser's server.
        subject: the robot and its motion.
        color: red, green and blue, 0 to 255.
        show: "meshes", "shapes" or "links".
        expanded: whether its sliders are seen at once.

    Attributes:
        subject: the robot and its motion.
        nodes: its nodes in the scene.
        panel: its sliders.
        handle: the node to drag; None without a target.
    """

    def __init__(
        self,
        server: Any,
        subject: Subject,
        *,
        color: tuple[int, int, int],
        show: str,
        expanded: bool,
    ) -> None:
        self.subject, self._lock, self._solving = subject, threading.RLock(), threading.Lock()
        robot, path = subject.robot, f"/{subject.label.replace('/', '|')}"
        self._q = np.array(subject.q[0])
        self._wanted: Array | None = None
        self.nodes = ArmNodes(server.scene, path, robot, color, show, axes=subject.moves)
        self.panel = ArmPanel(
            server.gui,
            subject.label,
            robot,
            self._q,
            color=color,
            moved=self.move,
            shown=self._shown,
            expanded=expanded,
        )
        self.target: LiveTarget | None = None
        self.handle: Any = None
        if not subject.moves and LiveTarget.fits(subject.ik):
            self.target = LiveTarget(robot, subject.ik)
            planar = robot.dimension == 2
            self.handle = server.scene.add_transform_controls(
                f"{path} target",
                scale=0.2 * reach(robot),
                active_axes=(True, True, not planar),
                disable_rotations=not self.target.turns,
                disable_axes=not self.target.moves,
                disable_sliders=not self.target.moves,
                depth_test=False,
            )
            self.handle.on_update(lambda _: self._dragged())
        self.move(self._q)

    @property
    def q(self) -> Array:
        """Its configuration, (nq,)."""
        return self._q.copy()

    def move(self, q: Any) -> None:
        """Move it to a configuration, (nq,) in any form that `Robot.configuration` accepts; its target moves along."""
        q = self.subject.robot.configuration(q)
        with self._lock:
            self._place(q)
            if self.handle is not None and self.target is not None:
                pose = np.asarray(self.subject.robot.pose(q, self.target.frame))
                self.handle.position, self.handle.wxyz = pose[:3, 3], quaternion_of(pose[:3, :3])
            self.panel.say("")

    def _place(self, q: Array) -> None:
        self._q = np.array(q)
        self.nodes.move(q)
        self.panel.show(q)

    def _shown(self, visible: bool) -> None:
        self.nodes.visible = visible
        if self.handle is not None:
            self.handle.visible = visible

    def _dragged(self) -> None:
        """Solve for the place of the target; of several that arrive during a solve only the last one counts."""
        from viser.transforms import SO3

        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = SO3(np.array(self.handle.wxyz)).as_matrix(), self.handle.position
        self._wanted = pose
        while self._wanted is not None and self._solving.acquire(blocking=False):
            try:
                pose, self._wanted = self._wanted, None
                self._solve(pose)
            finally:
                self._solving.release()

    def _solve(self, pose: Array) -> None:
        assert self.target is not None
        try:
            q, solution = self.target.solve(pose, self.q)
        except JtikError as error:
            self.panel.say(str(error))
            return
        with self._lock:
            self._place(q)
            self.panel.say(f"target: {solution.status.value}, {solution.position_error:.3g} m away")

    def remove(self) -> None:
        """Remove its nodes and its panel."""
        if self.handle is not None:
            self.handle.remove()
        self.nodes.remove()
        self.panel.remove()
