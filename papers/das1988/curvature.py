"""The order of magnitude (B.7), its use in Appendix B, and the motion of the tip by a null-space step.

(B.7) takes |Jdot qdot| to be of the order sigma_Jmax |qdot|^2, sigma_Jmax the largest singular value of J over all q.
On straight arms of n unit links, jtik's second derivatives give the bound, which is larger by a factor that grows with
the root of n. (B.10) sums the neglected terms to the order sigma_Jmax (e^Q - 1 - Q); the remainder of actual steps is
compared with it. Both are declared as orders of magnitude, and tested here as bounds as well. The last test
concerns "without affecting the motion of the end": the motion of the tip by a step in the null space of J.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import EXACT, Row, Script, Within, by_key, percent

import jtik
from jtik.symbolic import function, jacobian, symbol
from jtik.symbolic.compile import CompiledFunction

Array = np.ndarray
LINKS = (1, 2, 3, 5, 10, 20)
GROWTH = 4 * math.sqrt(3) / math.pi**2
"""Limit of the ratio of the bound to (B.7) over sqrt(n): (2n/pi)^2 over n^(3/2)/sqrt(3), for n links."""
LENGTHS = (1.0, 0.5, 0.25, 0.1)
"""Step lengths Q [rad]."""


class Arm:
    """A planar arm of unit links with second derivatives of its tip position."""

    def __init__(self, links: int) -> None:
        self.links = links
        robot = jtik.Robot.planar(links)
        q, v = symbol("q", links), symbol("v", links)
        tip = robot.at(q).position("tip")
        J = jacobian(tip, q)
        self._first = CompiledFunction(function("first", [q], [tip, J]))
        self._second = CompiledFunction(function("second", [q, v], [jacobian(J @ v, q)]))

    def tip(self, q: Array) -> Array:
        """Tip position [m]."""
        return self._first(q)[0][:, 0]

    def J(self, q: Array) -> Array:
        """Jacobian (2, n)."""
        return self._first(q)[1]

    def acceleration(self, q: Array, v: Array) -> Array:
        """Jdot qdot for qdot = v, (2,)."""
        return self._second(q, v)[0] @ v

    def curvature(self) -> tuple[float, Array]:
        """Largest |Jdot v| over unit vectors v at the straight arm, and its v.

        There the acceleration of the tip is along the arm, and is a quadratic form in v.
        """
        straight, eye = np.zeros(self.links), np.eye(self.links)
        form = np.array([self._second(straight, each)[0][0] for each in eye])
        values, vectors = np.linalg.eigh(form)
        k = int(np.argmax(np.abs(values)))
        return float(abs(values[k])), vectors[:, k]


def sigma(arm: Arm, q: Array) -> float:
    """Largest singular value of J [m/rad]."""
    return float(np.linalg.svd(arm.J(q), compute_uv=False)[0])


def bound(links: int, count: int) -> Row:
    """The bound for one arm.

    Columns:
        sigma_max: largest singular value of the straight arm [m/rad].
        elsewhere: largest one at random configurations, relative to it.
        L: largest |Jdot v| / |v|^2 of the straight arm.
        ratio: L / sigma_max, the factor by which (B.7) is exceeded.
        random: share of random v at the straight arm that exceed it [%].
        closed: relative difference of L from the closed form lambda_max(T'T), T lower triangular of ones.
    """
    arm, rng = Arm(links), np.random.default_rng(7)
    straight = np.zeros(links)
    top = sigma(arm, straight)
    L, v = arm.curvature()
    assert math.isclose(float(np.linalg.norm(arm.acceleration(straight, v))), L, rel_tol=1e-9)
    T = np.tril(np.ones((links, links)))
    closed = float(np.linalg.eigvalsh(T.T @ T)[-1])
    elsewhere = max(sigma(arm, rng.uniform(-1, 1, links) * rng.uniform(0, 3)) for _ in range(count))
    directions = rng.standard_normal((count, links))
    violated = [np.linalg.norm(arm.acceleration(straight, v)) > top * (v @ v) * (1 + 1e-12) for v in directions]
    return {
        "case": f"{links} link{'s' if links > 1 else ''}",
        "sigma_max": top,
        "elsewhere": elsewhere / top,
        "L": L,
        "ratio": L / top,
        "random": percent(violated),
        "closed": abs(L / closed - 1),
    }


def remainder(Q: float, count: int) -> Row:
    """Remainder of steps of length Q, ten links.

    Columns:
        neglected: (e^Q - 1 - Q) / Q, the terms that (B.10) neglects, relative to those kept.
        printed: largest |x(q + d) - x - J d| relative to sigma_Jmax (e^Q - 1 - Q); above 1 it is no bound.
        curved: the same relative to L Q^2 / 2.
        null: median motion of the tip by a null-space step of that length at random configurations [m].
        null_worst: largest motion of the tip by such a step [m].
    """
    arm, rng = Arm(10), np.random.default_rng(11)
    top, (L, worst) = sigma(arm, np.zeros(10)), arm.curvature()
    steps = [(np.zeros(10), Q * worst)]
    moved = []
    for _ in range(count):
        q, d = rng.uniform(-1, 1, 10), rng.standard_normal(10)
        steps.append((q, Q * d / np.linalg.norm(d)))
        J = arm.J(q)
        null = d - np.linalg.pinv(J) @ (J @ d)
        moved.append(float(np.linalg.norm(arm.tip(q + Q * null / np.linalg.norm(null)) - arm.tip(q))))
    left = max(float(np.linalg.norm(arm.tip(q + d) - arm.tip(q) - arm.J(q) @ d)) for q, d in steps)
    return {
        "case": f"Q = {Q:g}",
        "neglected": (math.exp(Q) - 1 - Q) / Q,
        "printed": left / (top * (math.exp(Q) - 1 - Q)),
        "curved": left / (L * Q**2 / 2),
        "null": float(np.median(moved)),
        "null_worst": max(moved),
    }


def compute(quick: bool) -> list[Row]:
    """The rows of both tests."""
    return [bound(links, 1000) for links in LINKS] + [remainder(Q, 1000) for Q in LENGTHS]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    arms, steps = [row for case, row in at.items() if "link" in case], [at[f"Q = {Q:g}"] for Q in LENGTHS]
    ratios = [float(row["ratio"]) for row in arms]
    return {
        "(B.7) is a bound for one link": ratios[0] <= 1 + 1e-12,
        "(B.7) is exceeded by every arm of two links and more": min(ratios[1:]) > 1,
        "by a factor between 0.7 and 1 times the root of the number of links": all(
            GROWTH <= ratio / math.sqrt(links) <= 1 + 1e-12 for links, ratio in zip(LINKS, ratios, strict=True)
        ),
        "no random configuration has a larger singular value than the straight arm": all(
            float(row["elsewhere"]) <= 1 + 1e-12 for row in arms
        ),
        "the true bound is lambda_max(T'T)": all(float(row["closed"]) < 1e-9 for row in arms),
        "(B.10) is exceeded by short steps": float(steps[-1]["printed"]) > 1,
        "but by no more than (B.7)": all(
            float(row["printed"]) <= float(at["10 links"]["ratio"]) * (1 + 1e-12) for row in steps
        ),
        "L Q^2 / 2 bounds every step tried": all(float(row["curved"]) <= 1 for row in steps),
        "at Q = 1 the neglected terms are not negligible": float(steps[0]["neglected"]) > 0.5,
        "a step in the null space moves the tip, by second order": all(
            2.5 < (float(a["null"]) / float(b["null"])) ** (1 / math.log2(p / q)) < 5
            for (a, p), (b, q) in zip(
                zip(steps[1:], LENGTHS[1:], strict=True), zip(steps[2:], LENGTHS[2:], strict=True), strict=False
            )
        ),
    }


SCRIPT = Script(
    name="curvature",
    keys=("case",),
    tolerances={
        "sigma_max": EXACT,
        "elsewhere": EXACT,
        "L": EXACT,
        "ratio": EXACT,
        "random": Within(absolute=0.2),
        "closed": Within(absolute=1e-9),
        "neglected": EXACT,
        "printed": EXACT,
        "curved": EXACT,
        "null": EXACT,
        "null_worst": EXACT,
    },
    compute=compute,
    statements=statements,
    quick_differs=False,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))
