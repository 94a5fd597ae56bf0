"""Planar arms whose reach, solutions and optima have closed forms."""

from __future__ import annotations

import math

import numpy as np

from jtik.problems.case import Case, ProblemSet
from jtik.problems.collection.named_problem import NamedProblem, centering
from jtik.problems.five_families import five_families, tip
from jtik.robot import Robot
from jtik.task import FrameTask
from jtik.types import Array


def _entry(name: str, summary: str, origin: str, robot: Robot, cases: list[Case]) -> NamedProblem:
    problems = ProblemSet(name, tuple(cases), origin=origin)
    return NamedProblem(
        name=name, summary=summary, robot=robot, task=FrameTask("tip"), problems=problems, origin=origin
    )


def das1988_families() -> NamedProblem:
    """The problems of the table of papers/das1988."""
    problems = five_families()
    return NamedProblem(
        name="das1988_families",
        summary="ten unit links: 200 problems of each of six kinds, with the smallest error of each",
        robot=Robot.planar(10),
        task=FrameTask("tip"),
        problems=problems,
        origin=problems.origin,
    )


def centering_3r() -> NamedProblem:
    """A target for which the optimum of joint centring is known.

    The preferred angles are q* - J(q*)' (0.3, -0.2). Then dH/dq = J' (0.3, -0.2) at q* is orthogonal to the
    self-motion, and H there is half its squared norm.
    """
    best, multipliers = np.array([0.4, 0.9, -0.7]), np.array([0.3, -0.2])
    gradient = _jacobian(best).T @ multipliers
    origin = "constructed so that Lagrange's condition dH/dq + J' lambda = 0 holds at a chosen posture"
    known = {"error": 0.0, "H": float(gradient @ gradient / 2)}
    known |= {f"q_{i}": float(angle) for i, angle in enumerate(best, 1)}
    starts = [best + 0.3, np.zeros(3), np.array([0.8, 0.5, 0.5]), np.array([1.2, -0.4, 0.3]), np.array([0.1, 1.2, 0.2])]
    cases = [
        Case(
            name=f"centering_3r-{i:03d}",
            kind="optimum",
            q0=q0,
            targets=(tip(best),),
            reachable=True,
            known=known,
            origin=origin,
        )
        for i, q0 in enumerate(starts)
    ]
    return NamedProblem(
        name="centering_3r",
        summary="smallest H of joint centring on a target, at the posture q_i [rad]",
        robot=Robot.planar(3),
        task=FrameTask("tip"),
        criteria=centering(best - gradient),
        problems=ProblemSet("centering_3r", tuple(cases), origin=origin),
        origin=origin,
    )


def straight_10r() -> NamedProblem:
    """An exactly straight arm with a target on its line: J' e = 0, so no first-order strategy moves."""
    origin = "Das, Slotine and Sheridan 1988, 'moves out of singular positions'; ten unit links"
    cases = [
        Case(
            name=f"straight_10r at {length:g}",
            kind="near_singular",
            q0=np.zeros(10),
            targets=((length, 0.0),),
            reachable=True,
            known={"error": 0.0, "sigma_min": 0.0},
            origin=origin,
        )
        for length in (3.0, 6.0, 9.0)
    ]
    return _entry(
        "straight_10r",
        "a straight arm with its target on its own line: J' e = 0 at the start",
        origin,
        Robot.planar(10),
        cases,
    )


def elbow_2r() -> NamedProblem:
    """A target with two solutions, one of which lies within the joint limits."""
    origin = "two unit links, elbow limited to one side: closed form by the law of cosines"
    starts = {"folded": (2.0, 3.0), "straight": (0.5, 0.1), "behind": (-3.0, 1.0)}
    cases = [
        Case(
            name=f"elbow_2r {name}",
            kind="near_limits",
            q0=np.array(q0),
            targets=((1.0, 1.0),),
            reachable=True,
            known={"error": 0.0, "q_1": 0.0, "q_2": math.pi / 2},
            origin=origin,
        )
        for name, q0 in starts.items()
    ]
    robot = Robot.planar(2, lower=[-math.pi, 0.1], upper=[math.pi, 3.0])
    return _entry("elbow_2r", "the only solution q_i [rad] within the limits", origin, robot, cases)


def unreachable_10r() -> NamedProblem:
    """A target half a metre beyond the reach."""
    origin = "ten unit links and a target at 10.5 m: the triangle inequality"
    directions = {"ahead": 0.0, "across": 1.0, "behind": math.pi}
    cases = [
        Case(
            name=f"unreachable_10r {name}",
            kind="unreachable",
            q0=np.full(10, 0.1),
            targets=((10.5 * math.cos(angle), 10.5 * math.sin(angle)),),
            reachable=False,
            known={"error": 0.5},
            origin=origin,
        )
        for name, angle in directions.items()
    ]
    return _entry("unreachable_10r", "the smallest error of an unreachable target", origin, Robot.planar(10), cases)


def circle_3r() -> NamedProblem:
    """Circles for three links, within reach."""
    origin = (
        "closed paths of a planar 3R, on which pseudo-inverse control drifts (Klein and Huang 1983); radii chosen here"
    )
    q0 = np.array([0.3, 0.9, 0.6])
    robot = Robot.planar(3)
    cases = [_circle(f"circle_3r r={radius:g}", q0, radius, origin) for radius in (0.2, 0.5)]
    return _entry(
        "circle_3r", "a circle that passes through the start: every target is reachable", origin, robot, cases
    )


def circle_10r() -> NamedProblem:
    """Circles for ten links, within reach."""
    origin = "a circle of ten unit links, within 10 m of the base"
    cases = [_circle(f"circle_10r r={radius:g}", np.full(10, 0.15), radius, origin) for radius in (0.5, 2.0)]
    return _entry(
        "circle_10r",
        "a circle that passes through the start: every target is reachable",
        origin,
        Robot.planar(10),
        cases,
    )


def _circle(name: str, q0: Array, radius: float, origin: str) -> Case:
    """One circle in 100 steps of 0.02 s, from the tip position at q0, with its centre in direction -x."""
    angle = np.linspace(0, 2 * np.pi, 101)
    places = tip(q0) + radius * np.column_stack([np.cos(angle) - 1, np.sin(angle)])
    places[-1] = places[0]
    return Case(
        name=name,
        kind="circle",
        q0=q0,
        targets=tuple(places),
        dt=0.02,
        closed=True,
        reachable=bool(np.linalg.norm(places, axis=1).max() <= len(q0)),
        known={"error": 0.0, "size": radius},
        origin=origin,
    )


def _jacobian(q: Array) -> Array:
    """Jacobian (2, n) of the tip position of an arm of unit links."""
    angle = np.cumsum(q)
    reverse = slice(None, None, -1)
    return np.stack([-np.cumsum(np.sin(angle)[reverse])[reverse], np.cumsum(np.cos(angle)[reverse])[reverse]])
