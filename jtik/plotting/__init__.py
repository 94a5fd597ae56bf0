"""Pictures of robots: postures, obstacles, paths, motions and animations.

`posture_figure`, `trajectory_figure` and `trace_figure` make figures, `write_motion` and `write_animation` GIFs. The
other functions draw planar robots on axes of your own, in metres. They need the extra "plot" (matplotlib and pillow),
and open no window.
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
from jtik.plotting.iterations import trace_figure
from jtik.plotting.motion import trajectory_figure, write_motion
from jtik.plotting.postures import configurations_of, posture_figure
from jtik.plotting.scenery import draw_base, draw_obstacles, draw_path
from jtik.plotting.skeleton import Skeleton
from jtik.plotting.style import (
    BACKGROUND,
    COLORMAP,
    COLORS,
    INK,
    LIGHTEST,
    LINK_WIDTH,
    MARGIN,
    MUTED,
    OBSTACLE_EDGE,
    OBSTACLE_FACE,
    SINGLE,
    THIN,
    shades,
)

__all__ = [
    "BACKGROUND",
    "COLORMAP",
    "COLORS",
    "INK",
    "LIGHTEST",
    "LINK_WIDTH",
    "MARGIN",
    "MUTED",
    "OBSTACLE_EDGE",
    "OBSTACLE_FACE",
    "SINGLE",
    "THIN",
    "Axes",
    "DrawnArm",
    "Figure",
    "Skeleton",
    "Window",
    "blank_figure",
    "configurations_of",
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
    "trace_figure",
    "trajectory_figure",
    "window_around",
    "write_animation",
    "write_motion",
]
