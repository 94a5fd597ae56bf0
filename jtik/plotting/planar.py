"""Pictures of planar robots: postures, obstacles and paths on axes in metres, and animations of them.

matplotlib is imported where it is needed, and only its object interface: no window, no pyplot, no global state. Draw
on axes of your own, or let `posture_figure` and `write_animation` make them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, MissingExtraError, finite_array
from jtik.geometry import Obstacle
from jtik.robot import Robot
from jtik.symbolic import function, symbol, vertcat
from jtik.types import Array

Window: TypeAlias = tuple[float, float, float, float]
"""What a picture shows: (left, right, bottom, top) [m]."""
Axes: TypeAlias = Any
Figure: TypeAlias = Any

COLORMAP = "YlGnBu"
LIGHTEST = 0.26
"""Where in the colour map a sequence starts; paler colours are lost on white."""
BACKGROUND, INK, MUTED, THIN = "#fdfdfb", "#2b2f36", "#6b7078", "#c3c7cc"
OBSTACLE_FACE, OBSTACLE_EDGE = "#f3d2ae", "#bf7a3a"
LINK_WIDTH = 0.09
"""Drawn width of a link [m]."""
MARGIN = 0.006
"""Rim around the frame, of the figure's width."""


class Skeleton:
    """Where the links of one robot are: one compiled function for the ends of all of them.

    Args:
        robot: the robot; its ``segments`` are the links.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        q = symbol("q", robot.nq)
        kinematics = robot.at(q)
        ends = [kinematics.position(frame) for pair in robot.segments for frame in pair]
        self._function = function("skeleton", [q], [vertcat(*ends)])

    def links(self, q: ArrayLike) -> Array:
        """Both ends of every link [m]: (links, 2, dimension) for q (nq,), (k, links, 2, dimension) for q (k, nq)."""
        array = np.asarray(q, dtype=float)
        robot = self.robot
        if array.ndim not in (1, 2) or array.shape[-1] != robot.nq:
            raise ArgumentError("q", f"shape {array.shape}", f"shape ({robot.nq},) or (any, {robot.nq})")
        ends = self._function(array.reshape(-1, robot.nq).T).full().T
        return np.array(ends).reshape(*array.shape[:-1], len(robot.segments), 2, robot.dimension)


def blank_figure(window: Window, width: float = 16.0) -> tuple[Figure, Axes]:
    """A figure with a narrow rim and its axes, which show ``window`` at equal scale.

    Args:
        window: (left, right, bottom, top) [m].
        width: of the figure [inch]; the height follows from the window.

    Raises:
        ArgumentError: when the window is empty.
        MissingExtraError: without matplotlib.
    """
    left, right, bottom, top = finite_array("window", window, (4,)).tolist()
    if not (left < right and bottom < top):
        raise ArgumentError("window", window, "(left, right, bottom, top) [m] with left < right, bottom < top")
    scale = width * (1 - 2 * MARGIN) / (right - left)
    rim = width * MARGIN
    height = scale * (top - bottom) + 2 * rim
    figure = new_figure((width, height))
    axes = figure.add_axes((MARGIN, rim / height, 1 - 2 * MARGIN, 1 - 2 * rim / height))
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", facecolor=BACKGROUND)
    frame_axes(axes)
    return figure, axes


def label_axes(axes: Axes, size: float = 13.0) -> None:
    """Ticks and units inside the frame, where they take no room from the picture."""
    axes.tick_params(direction="in", length=0.4 * size, color=THIN, labelcolor=MUTED, labelsize=size, pad=-0.5 * size)
    style = {"textcoords": "offset points", "color": MUTED, "fontsize": size}
    axes.annotate("x [m]", (1, 0), (-0.6 * size, 0.5 * size), xycoords="axes fraction", ha="right", **style)
    axes.annotate("y [m]", (0, 1), (0.5 * size, -0.6 * size), xycoords="axes fraction", va="top", **style)
    for label in axes.get_xticklabels():
        label.set_verticalalignment("bottom")
    for label in axes.get_yticklabels():
        label.set_horizontalalignment("left")


def frame_axes(axes: Axes) -> None:
    """The thin frame alone."""
    for spine in axes.spines.values():
        spine.set(color=THIN, linewidth=1.0)


def draw_obstacles(axes: Axes, obstacles: Iterable[Obstacle]) -> None:
    """Discs, and crosses for points. Raises ArgumentError for an obstacle that is not in the plane."""
    from matplotlib.patches import Circle

    for obstacle in obstacles:
        if obstacle.center.shape != (2,):
            raise ArgumentError("obstacles", obstacle, "points and circles with center (2,)")
        if obstacle.radius > 0:
            style = {"facecolor": OBSTACLE_FACE, "edgecolor": OBSTACLE_EDGE, "linewidth": 1.2, "zorder": 1}
            axes.add_patch(Circle(tuple(obstacle.center), obstacle.radius, **style))
        else:
            axes.plot(*obstacle.center, "x", color=OBSTACLE_EDGE, markersize=9, markeredgewidth=2, zorder=1)


def draw_path(axes: Axes, points: ArrayLike, **style: Any) -> Any:
    """A thin line through positions (k, 2) [m]; ``style`` are matplotlib's line properties."""
    x, y = finite_array("points", points, (None, 2)).T
    return axes.plot(x, y, **{"color": INK, "linewidth": 1.1, "linestyle": (0, (5, 3)), "zorder": 2, **style})[0]


class DrawnArm:
    """One robot on axes: rounded links, joints, and a base. ``move`` draws it elsewhere.

    Args:
        axes: what to draw on, limits set.
        robot: a planar robot, or its Skeleton.
        color: of the links.
        width: of a link [m].
        joints: whether to mark the joints.
        zorder: matplotlib's drawing order.
        halo: whether a light rim sets the arm off from what is below it.

    Raises:
        ArgumentError: when the robot is not planar.
    """

    def __init__(
        self,
        axes: Axes,
        robot: Robot | Skeleton,
        *,
        color: Any = INK,
        width: float = LINK_WIDTH,
        joints: bool = True,
        zorder: float = 3.0,
        halo: bool = True,
    ) -> None:
        from matplotlib.collections import LineCollection

        self._skeleton = robot if isinstance(robot, Skeleton) else Skeleton(robot)
        if self._skeleton.robot.dimension != 2:
            raise ArgumentError("robot", self._skeleton.robot, "a planar robot")
        thick = width * points_per_metre(axes)
        rims = [(BACKGROUND, thick + 1.8)] if halo else []
        self._links = [
            axes.add_collection(
                LineCollection([], colors=[tint], linewidths=points, capstyle="round", zorder=zorder),
                autolim=False,
            )
            for tint, points in [*rims, (color, thick)]
        ]
        marks = {"marker": "o", "linestyle": "none", "markeredgewidth": 0, "zorder": zorder}
        self._joints = axes.plot([], [], color=BACKGROUND, markersize=0.42 * thick, **marks)[0] if joints else None

    def move(self, q: ArrayLike) -> DrawnArm:
        """Draw it at ``q`` (nq,)."""
        links = self._skeleton.links(finite_array("q", q, (self._skeleton.robot.nq,)))
        for collection in self._links:
            collection.set_segments(links)
        if self._joints is not None:
            self._joints.set_data(*links[:, 0].T)
        return self

    def recolor(self, colors: Sequence[Any]) -> None:
        """One colour for every link."""
        self._links[-1].set_color(colors)


def points_per_metre(axes: Axes) -> float:
    """Points (1/72 inch) that a metre takes on axes of equal scale."""
    axes.apply_aspect()
    ends = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    return float((ends[1, 0] - ends[0, 0]) * 72 / axes.figure.dpi)


def shades(count: int, colormap: str = COLORMAP) -> list[Any]:
    """``count`` colours of a matplotlib colour map, from light to dark; a single one is dark."""
    import matplotlib

    chosen = matplotlib.colormaps[colormap]
    return [chosen(LIGHTEST + (1 - LIGHTEST) * share) for share in np.linspace(1, 0, count)[::-1]]


def draw_postures(
    axes: Axes,
    robot: Robot | Skeleton,
    configurations: ArrayLike,
    *,
    colormap: str = COLORMAP,
    width: float = LINK_WIDTH,
) -> list[DrawnArm]:
    """Configurations (k, nq) from light (first) to dark (last). Raises ArgumentError for a robot out of the plane."""
    skeleton = robot if isinstance(robot, Skeleton) else Skeleton(robot)
    table = finite_array("configurations", configurations, (None, skeleton.robot.nq))
    return [
        DrawnArm(axes, skeleton, color=color, width=width, zorder=3 + k / (len(table) + 1)).move(q)
        for k, (q, color) in enumerate(zip(table, shades(len(table), colormap), strict=True))
    ]


def draw_base(axes: Axes, position: ArrayLike = (0.0, 0.0), size: float = LINK_WIDTH) -> None:
    """A round foot where the arm stands."""
    from matplotlib.patches import Circle

    x, y = finite_array("position", position, (2,))
    axes.add_patch(Circle((x, y), 1.5 * size, facecolor=INK, edgecolor=BACKGROUND, linewidth=1.5, zorder=5))
    axes.add_patch(Circle((x, y), 0.45 * size, facecolor=BACKGROUND, zorder=5.1))


def window_around(points: ArrayLike, obstacles: Iterable[Obstacle] = (), margin: float = 0.06) -> Window:
    """A window that shows positions (..., 2) and obstacles, with ``margin`` of the larger side around them."""
    flat = np.asarray(points, dtype=float).reshape(-1, 2)
    discs = list(obstacles)
    low = np.min([*flat, *(disc.center - disc.radius for disc in discs)], axis=0)
    high = np.max([*flat, *(disc.center + disc.radius for disc in discs)], axis=0)
    room = margin * max(float((high - low).max()), 1e-6)
    return (float(low[0] - room), float(high[0] + room), float(low[1] - room), float(high[1] + room))


def posture_figure(
    robot: Robot,
    configurations: ArrayLike,
    *,
    obstacles: Iterable[Obstacle] = (),
    path: ArrayLike | None = None,
    window: Window | None = None,
    width: float = 12.0,
) -> Figure:
    """A figure of one configuration (nq,), or of several (k, nq) from light to dark.

    Args:
        robot: a planar robot.
        configurations: of a Solution or a Trajectory: their ``q``.
        obstacles: points and circles.
        path: positions (k, 2) [m] to draw as a line.
        window: (left, right, bottom, top) [m]; around everything by default.
        width: of the figure [inch].

    Raises:
        ArgumentError: when the robot is not planar or an argument has another shape.
        MissingExtraError: without matplotlib.
    """
    skeleton, discs = Skeleton(robot), list(obstacles)
    if robot.dimension != 2:
        raise ArgumentError("robot", robot, "a planar robot")
    links = skeleton.links(configurations).reshape(-1, 2)
    seen = links if path is None else np.concatenate([links, finite_array("path", path, (None, 2))])
    figure, axes = blank_figure(window or window_around(seen, discs), width)
    label_axes(axes)
    draw_obstacles(axes, discs)
    if path is not None:
        draw_path(axes, path)
    draw_postures(axes, skeleton, np.atleast_2d(np.asarray(configurations, dtype=float)))
    return figure


def write_animation(
    path: str | Path,
    figure: Figure,
    draw: Callable[[int], None],
    frames: int,
    *,
    seconds: float = 0.06,
    hold: float = 1.2,
) -> None:
    """A GIF that repeats: ``draw(k)`` changes the figure to frame k of ``frames``.

    Args:
        path: the file to write.
        figure: a figure of `blank_figure`; its size and dpi are the animation's.
        draw: called with 0, 1, ... frames - 1.
        frames: how many.
        seconds: that a frame is shown [s].
        hold: that the last frame is shown [s].

    Raises:
        MissingExtraError: without pillow.
    """
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError("pillow", "plot", "an animation") from error
    pictures = []
    for k in range(frames):
        draw(k)
        figure.canvas.draw()
        pictures.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()))
    palette = pictures[-1].quantize(96, dither=Image.Dither.NONE)
    indexed = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    durations = [round(1000 * seconds)] * (frames - 1) + [round(1000 * hold)]
    indexed[0].save(path, save_all=True, append_images=indexed[1:], duration=durations, loop=0, optimize=True)


@cache
def _picture(figure_class: Any, canvas_class: Any) -> Any:
    """The class of all figures: matplotlib's, which notebooks show without pyplot."""

    class Picture(figure_class):  # type: ignore[misc]
        """A figure that draws itself as PNG where it is the value of a cell."""

        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            canvas_class(self)

        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png", dpi=100)
            return file.getvalue()

    return Picture


def new_figure(size: tuple[float, float], **options: Any) -> Figure:
    """An empty figure of this width and height [inch]; ``options`` are those of ``matplotlib.figure.Figure``.

    Raises:
        MissingExtraError: without matplotlib.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", "plot", "a picture") from error
    return _picture(Figure, FigureCanvasAgg)(figsize=size, facecolor=BACKGROUND, **options)
