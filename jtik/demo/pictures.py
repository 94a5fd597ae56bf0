"""The pictures of the demo: postures along the path, and an animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jtik import plotting
from jtik.demo.measure import clearances
from jtik.demo.scene import Scene
from jtik.types import Array

WINDOW: plotting.Window = (-3.0, 9.5, -2.66, 3.74)
INSET_WINDOW: plotting.Window = (-0.35, 9.35, -2.3, 4.15)
"""What the picture shows, and what its inset shows: (left, right, bottom, top) [m]."""

INSET_LEFT, INSET_BOTTOM, INSET_WIDTH = -2.3, -2.38, 3.0
"""Place of the inset, the picture without avoidance [m]; this corner of the scene is empty."""

POSTURES = 12
"""Number of postures in the picture."""

HIT, CLEAR = "#c2412d", "#b9bec6"
"""Colours of links that touch an obstacle, and of the others."""

TRAIL = 10
"""Number of frames of the animation between two postures that stay visible."""

TEXT = {"color": "#4a4f57", "fontsize": 13}


def draw_stills(scene: Scene, q: Array, without: Array, folder: Path) -> list[Path]:
    """Draw postures from light to dark, as postures.png (1600 pixels wide) and postures.svg.

    Args:
        scene: the scene.
        q: configurations along the path (k, n).
        without: configurations along the same path without obstacle avoidance (j, n), for the inset.
        folder: folder to write to.

    Returns:
        The two files.
    """
    figure, axes = plotting.blank_figure(WINDOW)
    plotting.label_axes(axes)
    plotting.draw_obstacles(axes, scene.obstacles)
    plotting.draw_path(axes, scene.path(400))
    chosen = q[_spread(len(q), POSTURES)]
    plotting.draw_postures(axes, scene.robot, chosen)
    plotting.draw_base(axes)
    _draw_legend(axes, len(chosen))
    _draw_inset(axes, scene, without)
    paths = [folder / "postures.png", folder / "postures.svg"]
    figure.savefig(paths[0], dpi=100)
    figure.savefig(paths[1], metadata={"Date": None})
    return paths


def animate(scene: Scene, q: Array, path: Path, frames: int) -> Path:
    """Write an animation of the arm along the path as a GIF.

    Args:
        scene: the scene.
        q: configurations along the path (k, n).
        path: the file to write.
        frames: number of frames.

    Returns:
        The file.
    """
    figure, axes = plotting.blank_figure(WINDOW, width=8.0)
    plotting.label_axes(axes, size=8.0)
    plotting.draw_obstacles(axes, scene.obstacles)
    plotting.draw_path(axes, scene.path(400))
    skeleton = plotting.Skeleton(scene.robot)
    chosen = q[_spread(len(q), frames)]
    colors = plotting.shades(len(chosen))
    arm = plotting.DrawnArm(axes, skeleton, color=colors[-1], zorder=4)
    plotting.draw_base(axes)

    def draw(k: int) -> None:
        arm.move(chosen[k])
        if k % TRAIL == 0:
            plotting.DrawnArm(axes, skeleton, color=(*colors[k][:3], 0.35), zorder=2.5, joints=False, halo=False).move(
                chosen[k]
            )

    plotting.write_animation(path, figure, draw, len(chosen))
    return path


def _spread(count: int, wanted: int) -> NDArray[np.int_]:
    """``wanted`` evenly spaced indices of 0 ... count - 1, with both ends."""
    return np.unique(np.linspace(0, count - 1, min(wanted, count)).round().astype(int))


def _draw_legend(axes: plotting.Axes, count: int) -> None:
    """Draw the legend: what the colours and the dashes mean."""
    left, top = 3.4, 3.3
    for k, color in enumerate(plotting.shades(count)):
        axes.plot(
            [left + 0.16 * k, left + 0.16 * (k + 1)],
            [top, top],
            color=color,
            linewidth=8,
            solid_capstyle="butt",
        )
    end = left + 0.16 * count
    axes.text(left - 0.14, top, "first posture", ha="right", va="center", **TEXT)
    axes.text(end + 0.14, top, "last", ha="left", va="center", **TEXT)
    plotting.draw_path(axes, [(6.24, top), (6.74, top)])
    axes.text(6.88, top, "path of the end effector", ha="left", va="center", **TEXT)


def _draw_inset(axes: plotting.Axes, scene: Scene, without: Array) -> None:
    """Draw the same targets without obstacle avoidance, links that touch an obstacle in red."""
    left, right, bottom, top = INSET_WINDOW
    height = INSET_WIDTH * (top - bottom) / (right - left)
    inset = axes.inset_axes((INSET_LEFT, INSET_BOTTOM, INSET_WIDTH, height), transform=axes.transData, zorder=6)
    inset.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
    inset.set_facecolor(plotting.BACKGROUND)
    plotting.frame_axes(inset)
    plotting.draw_obstacles(inset, scene.obstacles)
    plotting.draw_path(inset, scene.path(200), linewidth=0.7)
    skeleton = plotting.Skeleton(scene.robot)
    for q in without[_spread(len(without), 4)]:
        _, distances = clearances(skeleton.links(q), scene.obstacles)
        arm = plotting.DrawnArm(inset, skeleton, width=0.1, joints=False).move(q)
        arm.recolor([HIT if distance < 0 else CLEAR for distance in distances.min(axis=1)])
    plotting.draw_base(inset, size=0.12)
    axes.text(INSET_LEFT + INSET_WIDTH + 0.14, INSET_BOTTOM + 0.02, "without\navoidance", va="bottom", **TEXT)
