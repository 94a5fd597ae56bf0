"""Robots and obstacles in space, on 3-D axes of equal scale: surfaces with light, sorted by depth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import product
from typing import Any

import numpy as np

from jtik.geometry import HalfSpace, Solid
from jtik.plotting.body import triangles
from jtik.plotting.figure import Axes, Figure, new_figure
from jtik.plotting.style import BACKGROUND, INK, MUTED, OBSTACLE_FACE, THIN
from jtik.plotting.surfaces import Surface, extent_of, obstacle_surface, surface
from jtik.types import Array

VIEW = (22.0, -52.0)
"""Elevation and azimuth from which a robot is seen [degrees]."""

LIGHT = np.array([0.35, -0.55, 0.76])
"""Direction to the light, relative to a viewer at azimuth -90 degrees."""

TRANSLUCENT = 0.7
"""Opacity of an obstacle, through which the arm is seen."""

SHADE = 0.45
"""How much darker a surface is that faces away from the light."""

THINNEST = 0.3
"""Smallest side of the box, as a share of its largest: below it the labels of its axis overlap."""

ROUNDS = 8
"""How often axes and figure are resized; each time the labels move."""

TALLEST = 1.25
"""Largest height of a figure, as a share of its width."""

PAD = 0.06
"""Margin around the picture [inch]."""


class SpatialScene:
    """Surfaces on 3-D axes, drawn together so that the nearer ones hide those behind them.

    Args:
        axes: 3-D axes.
        size: size of the labels [points].
    """

    def __init__(self, axes: Axes, size: float = 8.0) -> None:
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        self.axes, self._size = axes, size
        self._corners = np.zeros((0, 3))
        self._fixed: tuple[Array, Array] = (np.zeros((0, 3, 3)), np.zeros((0, 4)))
        self._collection = Poly3DCollection(np.zeros((1, 3, 3)), zsort="average", linewidths=0.25)
        axes.add_collection3d(self._collection, autolim=False)
        axes.computed_zorder = False

    def fix(self, obstacles: Iterable[Solid], bodies: Sequence[Surface]) -> None:
        """Draw obstacles, which stay; half-spaces as far as bodies and other obstacles reach."""
        given = tuple(obstacles)
        points = [each.vertices for each in bodies] + [self._corners]
        points += [surface(each).vertices for each in given if not isinstance(each, HalfSpace)]
        extent = extent_of(np.concatenate(points))
        surfaces = [obstacle_surface(each, extent) for each in given]
        corners, tints = self._lit(surfaces, [OBSTACLE_FACE] * len(surfaces), TRANSLUCENT)
        elevation, azimuth = np.deg2rad([self.axes.elev, self.axes.azim])
        viewer = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
        front = _normals(corners) @ viewer > 0  # else its own back shows through a translucent surface
        self._fixed = corners[front], tints[front]
        self._include(self._fixed[0])

    def show(self, bodies: Sequence[tuple[list[Surface], Any]]) -> None:
        """Draw bodies, each with a colour, instead of those that were shown before."""
        # of links that several postures share, the last is drawn: at equal depth neither hides the other
        unique = {each.vertices.round(6).tobytes(): (each, color) for body, color in bodies for each in body}
        surfaces, colors = [each for each, _ in unique.values()], [color for _, color in unique.values()]
        corners, faces = self._lit(surfaces, colors, 1.0)
        self._include(corners)
        polygons = np.concatenate([self._fixed[0], corners])
        tints = np.concatenate([self._fixed[1], faces])
        self._collection.set_verts(polygons)
        self._collection.set_facecolor(tints)
        self._collection.set_edgecolor(np.where(tints[:, 3:] < 1, 0.0, tints))
        self._collection.set_antialiased(tints[:, 3] == 1)  # else the edges within a translucent surface show

    def line(self, points: Array, **style: Any) -> Any:
        """Draw a path (k, 3) [m] as a thin dashed line."""
        self._include(points)
        style = {"color": INK, "linewidth": 1.1, "linestyle": (0, (5, 3)), "zorder": 3, **style}
        return self.axes.plot(*points.T, **style)[0]

    def _lit(self, surfaces: list[Surface], colors: Sequence[Any], alpha: float) -> tuple[Array, Array]:
        """Triangles (m, 3, 3) and their colours (m, 4)."""
        from matplotlib.colors import to_rgb

        corners, owners = triangles(surfaces)
        if not len(corners):
            return corners, np.zeros((0, 4))
        turn = np.deg2rad(self.axes.azim + 90)
        rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        bright = 1 - SHADE * (1 - _normals(corners) @ (rotation @ LIGHT)) / 2
        base = np.array([to_rgb(color) for color in colors])[owners]
        return corners, np.column_stack([np.clip(base * (0.12 + bright[:, None]), 0, 1), np.full(len(base), alpha)])

    def include(self, surfaces: Sequence[Surface]) -> None:
        """Leave room for surfaces that are not drawn now."""
        for each in surfaces:
            self._include(each.vertices)

    def _include(self, points: Array) -> None:
        self._corners = np.concatenate([self._corners, points.reshape(-1, 3)])

    def frame(self) -> None:
        """Set the limits to what is drawn, at equal scale, and label the axes."""
        low, high = self._corners.min(axis=0), self._corners.max(axis=0)
        span = np.maximum(high - low, max(THINNEST * float((high - low).max()), 1e-6))
        middle = (low + high) / 2
        axes = self.axes
        for name, at, side in zip("xyz", middle, span, strict=True):
            getattr(axes, f"set_{name}lim")(at - 0.52 * side, at + 0.52 * side, auto=None)
        axes.set_box_aspect(span)
        self._style(span / span.max())

    def _style(self, shares: Array) -> None:
        from matplotlib.ticker import MaxNLocator

        for axis, name, share in zip((self.axes.xaxis, self.axes.yaxis, self.axes.zaxis), "xyz", shares, strict=True):
            axis.set_pane_color(BACKGROUND)
            axis.line.set_color(THIN)
            axis._axinfo["grid"].update(color=THIN, linewidth=0.45)
            axis._axinfo["tick"].update(color=THIN, inward_factor=0.0, outward_factor=0.12)
            axis.set_major_locator(MaxNLocator(max(2, round(5 * share)), steps=[1, 2, 2.5, 5, 10]))
            axis.set_tick_params(labelsize=self._size, labelcolor=MUTED, pad=-1)
            axis.set_label_text(f"{name} [m]", color=MUTED, fontsize=self._size)
            axis.labelpad = -1


def _normals(corners: Array) -> Array:
    """Outward unit normals (m, 3) of triangles (m, 3, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12))


def spatial_figure(view: tuple[float, float], width: float, draw: Callable[[SpatialScene], None]) -> Figure:
    """A figure with 3-D axes that fill it; its height follows from what ``draw`` draws.

    Args:
        view: elevation and azimuth [degrees].
        width: width of the figure [inch].
        draw: draws on a `SpatialScene`.
    """
    figure = new_figure((width, width))
    axes = figure.add_axes((0, 0, 1, 1), projection="3d", facecolor=BACKGROUND)
    axes.view_init(*view)
    scene = SpatialScene(axes)
    draw(scene)
    scene.frame()
    fill(figure, axes, width)
    return figure


def fill(figure: Figure, axes: Axes, width: float) -> None:
    """Resize axes and figure, so that what is drawn fills the figure of that width [inch]."""
    from matplotlib.transforms import Bbox

    side, left, bottom, height = width, 0.0, 0.0, width
    for _ in range(ROUNDS):
        figure.set_size_inches(width, height)
        axes.set_position((left / width, bottom / height, side / width, side / height))
        figure.draw_without_rendering()
        renderer = figure.canvas.get_renderer()
        _separate_labels(axes, renderer)
        parts = [_box_of(axes), *(each.get_window_extent(renderer) for each in _labels(axes))]
        seen = Bbox.union(parts).transformed(figure.dpi_scale_trans.inverted())
        grow = min((width - 2 * PAD) / seen.width, (TALLEST * width - 2 * PAD) / seen.height)
        left, bottom = (width - seen.width * grow) / 2 + (left - seen.x0) * grow, PAD + (bottom - seen.y0) * grow
        side, height = side * grow, seen.height * grow + 2 * PAD
    figure.set_size_inches(width, height)
    axes.set_position((left / width, bottom / height, side / width, side / height))


def fit(figure: Figure, axes: Axes, cell: tuple[float, float, float, float]) -> None:
    """Resize axes, so that what is drawn fills a cell of the figure.

    Args:
        figure: the figure, without a layout engine.
        axes: 3-D axes.
        cell: left, bottom, width and height [inch].
    """
    from matplotlib.transforms import Bbox

    (left, bottom, width, height), side = cell, cell[2]
    across, up = figure.get_size_inches()
    x, y = left, bottom
    for _ in range(ROUNDS):
        axes.set_position((x / across, y / up, side / across, side / up))
        figure.draw_without_rendering()
        renderer = figure.canvas.get_renderer()
        _separate_labels(axes, renderer)
        parts = [_box_of(axes), *(each.get_window_extent(renderer) for each in _labels(axes))]
        seen = Bbox.union(parts).transformed(figure.dpi_scale_trans.inverted())
        grow = min((width - 2 * PAD) / seen.width, (height - 2 * PAD) / seen.height)
        x = left + (width - seen.width * grow) / 2 + (x - seen.x0) * grow
        y = bottom + (height - seen.height * grow) / 2 + (y - seen.y0) * grow
        side *= grow
    axes.set_position((x / across, y / up, side / across, side / up))


def _box_of(axes: Axes) -> Any:
    """The rectangle around the box of 3-D axes, in pixels."""
    from matplotlib.transforms import Bbox
    from mpl_toolkits.mplot3d import proj3d

    corners = product(axes.get_xlim(), axes.get_ylim(), axes.get_zlim())
    points = [proj3d.proj_transform(*corner, axes.get_proj())[:2] for corner in corners]
    pixels = axes.transData.transform(points)
    return Bbox([pixels.min(axis=0), pixels.max(axis=0)])


def _labels(axes: Axes) -> list[Any]:
    """The texts of 3-D axes that are drawn: the labels of the axes, and the numbers."""
    found = []
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        low, high = sorted(axis.get_view_interval())
        numbers = [tick.label1 for tick in axis.majorTicks if low <= tick.get_loc() <= high]
        found += [axis.label, *numbers]
    return [text for text in found if text.get_text()]


def _separate_labels(axes: Axes, renderer: Any) -> None:
    """Move the labels of axes away from the numbers that they touch."""
    every = (axes.xaxis, axes.yaxis, axes.zaxis)
    names = [axis.label for axis in every]
    numbers = [text.get_window_extent(renderer) for text in _labels(axes) if text not in names]
    for axis in every:
        if axis.label.get_window_extent(renderer).padded(2).count_overlaps(numbers):
            axis.labelpad += 3
