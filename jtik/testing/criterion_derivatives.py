"""The derivatives of a criterion against differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jtik.robot import Robot
from jtik.testing.common import require
from jtik.types import Array

DIFFERENCE_STEPS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Steps of the central differences [rad] or [m]; a correct gradient agrees at one of them for every scale of H."""

DIFFERENCE_TOLERANCE = 1e-4
"""Relative disagreement allowed between a gradient and its best central difference."""

HESSIAN_STEPS = (1e-3, 1e-4, 1e-5, 1e-6)
"""Steps of the differences of the gradient [rad] or [m]."""

HESSIAN_TOLERANCE = 1e-3
"""Relative disagreement allowed between second derivatives and the best differences of the gradient."""


def check_gradient(who: str, robot: Robot, q: Array, analytic: Array, value: Callable[[Array], float]) -> None:
    """Check a gradient by central differences of H.

    Args:
        who: how a message begins.
        robot: the robot.
        q: configuration, (nq,).
        analytic: the gradient there, (n,).
        value: H at a configuration.

    Raises:
        AssertionError: when they disagree.
    """
    scale = max(1.0, float(np.abs(analytic).max()))
    for j, unit in enumerate(np.eye(robot.n)):
        found = []
        for step in DIFFERENCE_STEPS:
            ahead, behind = robot.integrate(q, step * unit), robot.integrate(q, -step * unit)
            found.append((value(ahead) - value(behind)) / (2 * step))
        finite = [number for number in found if np.isfinite(number)]
        best = min(finite, key=lambda number: abs(number - analytic[j]), default=np.nan)
        require(
            abs(best - analytic[j]) <= DIFFERENCE_TOLERANCE * scale,
            f"gradient of {who} along velocity {j} is {analytic[j]}, by differences {best}, at q = {q.tolist()}",
        )


def check_hessian(who: str, robot: Robot, q: Array, analytic: Array, gradient: Callable[[Array], Array]) -> None:
    """Check second derivatives by differences of the gradient.

    Second derivatives may jump, as those of a one-sided square do: each entry has to lie between the differences on
    both sides of q.

    Args:
        who: how a message begins.
        robot: the robot.
        q: configuration, (nq,).
        analytic: derivative of the gradient with respect to the velocity there, (n, n).
        gradient: the gradient (n,) at a configuration.

    Raises:
        AssertionError: when they disagree, or are not finite.
    """
    require(bool(np.isfinite(analytic).all()), f"the second derivatives of {who} are {analytic} at q = {q.tolist()}")
    here, allowed = gradient(q), HESSIAN_TOLERANCE * max(1.0, float(np.abs(analytic).max()))
    for j, unit in enumerate(np.eye(robot.n)):
        best, least = here, np.inf
        for step in HESSIAN_STEPS:
            ahead = (gradient(robot.integrate(q, step * unit)) - here) / step
            behind = (here - gradient(robot.integrate(q, -step * unit))) / step
            nearest = np.clip(analytic[:, j], np.minimum(ahead, behind), np.maximum(ahead, behind))
            off = float(np.abs(nearest - analytic[:, j]).max())
            if off < least:
                best, least = (ahead + behind) / 2, off
        require(
            least <= allowed,
            f"the second derivatives of {who} along velocity {j} are {analytic[:, j]}, by differences of its gradient "
            f"{best}, at q = {q.tolist()}",
        )
