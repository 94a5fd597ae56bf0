"""Robots, solutions and trajectories in 3-D in a browser, with sliders and a target to drag: ``jtik.view``.

It needs the extra "view" (viser).
"""

from jtik.viewer.show import view
from jtik.viewer.viewer import Viewer

__all__ = ["Viewer", "view"]
