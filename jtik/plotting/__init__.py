"""Pictures of planar robots: postures, obstacles, paths and animations.

`posture_figure` makes a figure and `write_animation` a GIF. The other functions draw on axes of your own, in
metres. They need the extra "plot" (matplotlib and pillow), and open no window.
"""

from jtik.plotting.animation import write_animation
from jtik.plotting.drawn_arm import DrawnArm, draw_postures
from jtik.plotting.figure import (
    Axes,
    Figure,
    Window,
    blank_figure,
    frame_axes,
    label_axes,
    new_figure,
    points_per_metre,
    window_around,
)
from jtik.plotting.postures import posture_figure
from jtik.plotting.scenery import draw_base, draw_obstacles, draw_path
from jtik.plotting.skeleton import Skeleton
from jtik.plotting.style import (
    BACKGROUND,
    COLORMAP,
    INK,
    LIGHTEST,
    LINK_WIDTH,
    MARGIN,
    MUTED,
    OBSTACLE_EDGE,
    OBSTACLE_FACE,
    THIN,
    shades,
)

__all__ = [
    "BACKGROUND",
    "COLORMAP",
    "INK",
    "LIGHTEST",
    "LINK_WIDTH",
    "MARGIN",
    "MUTED",
    "OBSTACLE_EDGE",
    "OBSTACLE_FACE",
    "THIN",
    "Axes",
    "DrawnArm",
    "Figure",
    "Skeleton",
    "Window",
    "blank_figure",
    "draw_base",
    "draw_obstacles",
    "draw_path",
    "draw_postures",
    "frame_axes",
    "label_axes",
    "new_figure",
    "points_per_metre",
    "posture_figure",
    "shades",
    "window_around",
    "write_animation",
]
