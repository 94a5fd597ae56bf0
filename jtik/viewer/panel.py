"""The panel of one arm: whether it is shown, its joints, and what its solver says."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import contextmanager
from typing import Any

import numpy as np

from jtik.robot import JointType, Robot
from jtik.types import Array

TURN, STROKE = math.pi, 1.0
"""Range of the slider of a joint without limits: from minus to plus as many [rad] or [m]."""


class ArmPanel:
    """Sliders of the revolute and prismatic joints of an arm.

    Args:
        gui: viser's panel.
        label: name of the arm.
        robot: the robot.
        q: its configuration, (nq,).
        color: its colour: red, green and blue, 0 to 255.
        moved: called with a configuration when a slider is moved.
        shown: called with whether the arm is shown.
        expanded: whether the sliders are seen at once.

    Attributes:
        sliders: the sliders by joint name.
        visible: the check box.
        status: the text.
    """

    def __init__(
        self,
        gui: Any,
        label: str,
        robot: Robot,
        q: Array,
        *,
        color: tuple[int, int, int],
        moved: Callable[[Array], None],
        shown: Callable[[bool], None],
        expanded: bool,
    ) -> None:
        self._robot, self._moved, self._quiet = robot, moved, False
        self._q = q.copy()
        self.sliders: dict[str, Any] = {}
        self.folder = gui.add_folder(label)
        with self.folder:
            gui.add_html(f'<div style="height:4px;margin:0 0.75em;background:rgb{color}"></div>')
            self.visible = gui.add_checkbox("shown", True)
            self.status = gui.add_markdown("")
        with self.folder, gui.add_folder("joints", expand_by_default=expanded):
            for joint in robot.joints:
                if joint.is_independent and joint.type in (JointType.REVOLUTE, JointType.PRISMATIC):
                    self.sliders[joint.name] = self._slider(gui, joint)
        self.visible.on_update(lambda _: shown(bool(self.visible.value)))

    def _slider(self, gui: Any, joint: Any) -> Any:
        value = float(self._q[self._robot.q_slice(joint.name)][0])
        low, high = slider_range(joint.type, joint.lower, joint.upper, value)
        unit = "rad" if joint.type is JointType.REVOLUTE else "m"
        step = max(round((high - low) / 1000, 4), 1e-4)
        slider = gui.add_slider(joint.name, low, high, step, value, hint=f"[{unit}]")
        slider.on_update(lambda _: self._on_slider(joint.name))
        return slider

    def _on_slider(self, joint: str) -> None:
        if self._quiet:
            return
        q = self._q.copy()
        q[self._robot.q_slice(joint)] = self.sliders[joint].value
        self._moved(q)

    def show(self, q: Array) -> None:
        """Set the sliders to a configuration (nq,), without moving the arm again."""
        self._q = np.array(q)
        with self._silent():
            for name, slider in self.sliders.items():
                value = float(q[self._robot.q_slice(name)][0])
                slider.min, slider.max = min(slider.min, value), max(slider.max, value)
                slider.value = value

    def say(self, text: str) -> None:
        """Show a sentence."""
        if self.status.content != text:
            self.status.content = text

    @contextmanager
    def _silent(self) -> Any:
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def remove(self) -> None:
        """Remove the panel."""
        self.folder.remove()


def slider_range(kind: JointType, lower: float, upper: float, value: float) -> tuple[float, float]:
    """The range of a slider: the limits, or where there are none a turn [rad] or a stroke of 2 m about the value."""
    reach = TURN if kind is JointType.REVOLUTE else STROKE
    if math.isinf(lower) and math.isinf(upper):
        lower, upper = -reach, reach
    elif math.isinf(lower):
        lower = upper - 2 * reach
    elif math.isinf(upper):
        upper = lower + 2 * reach
    low, high = min(lower, value), max(upper, value)
    return (low, high) if high > low else (low - 1e-3, high + 1e-3)
