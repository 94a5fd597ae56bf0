"""Figures, and axes in metres at equal scale.

matplotlib is imported where it is needed, and only its object interface: no window, no pyplot, no global state.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from io import BytesIO
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array, instances, non_negative_number, positive_number, shape_of
from jtik.errors import ArgumentError, MissingExtraError
from jtik.geometry import Obstacle, bounds
from jtik.plotting.style import BACKGROUND, MARGIN, MUTED, THIN

Window: TypeAlias = tuple[float, float, float, float]
"""What a picture shows: (left, right, bottom, top) [m]."""

Axes: TypeAlias = Any
"""Axes of matplotlib."""

Figure: TypeAlias = Any
"""A figure of matplotlib."""


def new_figure(size: tuple[float, float], **options: Any) -> Figure:
    """An empty figure.

    Args:
        size: width and height [inch].
        options: those of ``matplotlib.figure.Figure``.

    Raises:
        MissingExtraError: when matplotlib is not installed.
    """
    width, height = finite_array("size", size, (2,), "width and height [inch], positive").tolist()
    if not (width > 0 and height > 0):
        raise ArgumentError("size", size, "width and height [inch], positive")
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtraError("matplotlib", "plot", "a picture") from error
    return _picture(Figure, FigureCanvasAgg)(figsize=(width, height), facecolor=BACKGROUND, **options)


def blank_figure(window: Window, width: float = 16.0) -> tuple[Figure, Axes]:
    """A figure and its axes, which show ``window`` at equal scale.

    Args:
        window: (left, right, bottom, top) [m].
        width: width of the figure [inch]; the height follows from the window.

    Returns:
        The figure and the axes.

    Raises:
        ArgumentError: when the window is empty.
        MissingExtraError: when matplotlib is not installed.
    """
    width = positive_number("width", width)
    left, right, bottom, top = finite_array("window", window, (4,)).tolist()
    if not (left < right and bottom < top):
        raise ArgumentError("window", window, "(left, right, bottom, top) [m] with left < right, bottom < top")
    scale = width * (1 - 2 * MARGIN) / (right - left)
    margin = width * MARGIN
    height = scale * (top - bottom) + 2 * margin
    figure = new_figure((width, height))
    axes = figure.add_axes((MARGIN, margin / height, 1 - 2 * MARGIN, 1 - 2 * margin / height))
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", facecolor=BACKGROUND)
    frame_axes(axes)
    return figure, axes


def label_axes(axes: Axes, size: float = 13.0) -> None:
    """Label both axes with ticks and units, inside the frame.

    Args:
        axes: the axes.
        size: size of the text [points].
    """
    axes.tick_params(direction="in", length=0.4 * size, color=THIN, labelcolor=MUTED, labelsize=size, pad=-0.5 * size)
    for axis, room in ((axes.xaxis, 4.5 * size), (axes.yaxis, 2.2 * size)):
        axis.set_major_locator(_locator(room))
    style = {"textcoords": "offset points", "color": MUTED, "fontsize": size}
    axes.annotate("x [m]", (1, 0), (-0.6 * size, 0.5 * size), xycoords="axes fraction", ha="right", **style)
    axes.annotate("y [m]", (0, 1), (0.5 * size, -0.6 * size), xycoords="axes fraction", va="top", **style)
    for label in axes.get_xticklabels():
        label.set_verticalalignment("bottom")
    for label in axes.get_yticklabels():
        label.set_horizontalalignment("left")


def _locator(room: float) -> Any:
    """Ticks that leave the end of an axis free, where its label is, for as many points."""
    from matplotlib.ticker import AutoLocator

    class Locator(AutoLocator):
        def __call__(self) -> Any:
            axis: Any = self.axis
            axes, index = axis.axes, 0 if axis.axis_name == "x" else 1
            ticks = np.asarray(super().__call__())
            places = axes.transData.transform(np.outer(ticks, np.eye(2)[index]))[:, index]
            return ticks[places < axes.bbox.max[index] - room * axes.figure.dpi / 72]

    return Locator()


def frame_axes(axes: Axes) -> None:
    """Draw the frame of the axes as a thin line.

    Args:
        axes: the axes.
    """
    for spine in axes.spines.values():
        spine.set(color=THIN, linewidth=1.0)


def window_around(points: ArrayLike, obstacles: Iterable[Obstacle] = (), margin: float = 0.06) -> Window:
    """The window that shows positions and obstacles.

    Args:
        points: positions (..., 2) [m].
        obstacles: obstacles in the plane; of a half-space its point is shown.
        margin: margin on every side, as a share of the larger side.

    Returns:
        (left, right, bottom, top) [m].

    Raises:
        ArgumentError: when there is neither a point nor an obstacle, or an argument cannot be used.
    """
    shape = shape_of(points) or ()
    flat = finite_array("points", points, (*[None] * (len(shape) - 1), 2), "finite positions of shape (..., 2)")
    flat = flat.reshape(-1, 2)
    shown = instances("obstacles", obstacles, Obstacle, "obstacles in the plane")
    margin = non_negative_number("margin", margin)
    if not len(flat) and not shown:
        raise ArgumentError("points", "none", "at least one position or obstacle")
    low = np.min([*flat, *(bounds(each)[0] for each in shown)], axis=0)
    high = np.max([*flat, *(bounds(each)[1] for each in shown)], axis=0)
    border = margin * max(float((high - low).max()), 1e-6)
    return (float(low[0] - border), float(high[0] + border), float(low[1] - border), float(high[1] + border))


def points_per_metre(axes: Axes) -> float:
    """The length of a metre on axes of equal scale [points, 1/72 inch].

    Args:
        axes: the axes.
    """
    axes.apply_aspect()
    ends = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    return float((ends[1, 0] - ends[0, 0]) * 72 / axes.figure.dpi)


@cache
def _picture(figure_class: Any, canvas_class: Any) -> Any:
    """The class of all figures: matplotlib's, with a method by which notebooks show it without pyplot."""

    class Picture(figure_class):  # type: ignore[misc]
        """A figure that a notebook shows as PNG where it is the value of a cell."""

        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            canvas_class(self)

        def _repr_png_(self) -> bytes:
            file = BytesIO()
            self.savefig(file, format="png", dpi=100)
            return file.getvalue()

    return Picture
