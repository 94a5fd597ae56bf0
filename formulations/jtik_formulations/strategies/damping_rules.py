"""Damped least squares by other rules for the damping (formulations/damped.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik import register_strategy
from jtik.strategy import LocalModel, Positive, Share
from jtik.symbolic import Expression, fmax, ratio
from jtik_formulations.bibliography import NAKAMURA_HANAFUSA_1986, SUGIHARA_2011, WAMPLER_1986
from jtik_formulations.strategies._parts.damped_least_squares import DampedLeastSquares


@register_strategy("damped_constant")
@dataclass(frozen=True, kw_only=True)
class ConstantDamped(DampedLeastSquares):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H, with one mu for all poses.

    For comparison: it converges linearly, the more slowly the smaller the singular values of J are, and fails at
    targets close to singular poses (formulations/damped.md). For a target out of reach it does not find the closest
    posture where mu is small beside the curvature of the arm times the error: a planar arm of four metres ends up to a
    fifth of its reach away from it (29 of 30 solves, 1000 steps). In a control loop it lags behind the other
    strategies, which a timed step damps only where it has to: along a singular value sigma a step leaves
    mu / (sigma^2 + mu) of the error.

    Attributes:
        damping: mu, in the unit of J J' [m^2 / rad^2]. It is lambda^2 of Buss, of Siciliano et al. and of KDL: a
            textbook's lambda = 0.1 is 0.01 here. mink, pink and Corke's toolbox have mu itself.
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Wampler (1986).
    """

    damping: Positive = 1e-3

    summary = "damped least squares with constant damping"
    source = "Wampler 1986"
    bibtex = WAMPLER_1986

    def damps_stagnation(self) -> bool:
        """With backtracking."""
        return self.backtracking

    def damping_of(self, model: LocalModel) -> Expression:
        """The damping."""
        return self.damping + model.stagnation_damping


@register_strategy("sugihara")
@dataclass(frozen=True, kw_only=True)
class Sugihara(DampedLeastSquares):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H, with mu = V + bias.

    Levenberg and Marquardt's step with the error as its damping. It needs no rank decision anywhere, on the way or at
    a target out of reach. The bias bounds the last steps at singular targets and slows down those to targets close to
    singular poses: along a singular value sigma each multiplies the error by bias / (sigma^2 + bias). To poses out of
    reach it converges linearly; one of 200 solves of a Panda needed more than 1000 steps to the closest posture.

    Attributes:
        bias: smallest mu, in the unit of J J' [m^2 / rad^2]; the gain ``k`` of Corke's toolbox. Values of 1e-3 of a
            squared link length and above, as in the paper, fail at targets close to singular poses
            (formulations/damped.md).
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Sugihara (2011), with one bias for all joints.
    """

    bias: Positive = 1e-6

    summary = "damped least squares, damped by V and a constant bias"
    source = "Sugihara 2011"
    bibtex = SUGIHARA_2011

    def damping_of(self, model: LocalModel) -> Expression:
        """V and the bias."""
        return model.here.V + self.bias


@register_strategy("nakamura")
@dataclass(frozen=True, kw_only=True)
class NakamuraHanafusa(DampedLeastSquares):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H, mu growing as manipulability w falls below w0.

    mu = mu0 (1 - w / w0)^2 where w < w0, else 0. Newton's step in good poses, a damped one near singular poses,
    whatever the error. w is the volume of the manipulability ellipsoid, sqrt(det J J'), here relative to that of a
    ball with the same Frobenius norm of J, so that w and w0 lie between 0 and 1 for every robot and unit; mu0 is
    relative to |J|^2 / m, the mean square of the singular values. For a target out of reach it does not find the
    closest posture where mu is small beside the curvature of the arm times the error: a planar arm ends up to a fifth
    of its reach away from it (29 of 30 solves, 1000 steps).

    Attributes:
        damping: mu0, at a singular pose, relative to |J|^2 / m. k_0 of the paper is mu0 |J|^2 / m.
        threshold: w0, in (0, 1].
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Nakamura and Hanafusa (1986); Yoshikawa (1985) for w.
    """

    damping: Positive = 1e-4
    threshold: Share = 0.1

    summary = "damped least squares, damped where manipulability is low"
    source = "Nakamura and Hanafusa 1986"
    bibtex = NAKAMURA_HANAFUSA_1986

    def damps_stagnation(self) -> bool:
        """With backtracking."""
        return self.backtracking

    def damping_of(self, model: LocalModel) -> Expression:
        """mu0 (1 - w / w0)^2 below the threshold."""
        m = model.J.shape[0]
        mean_square = model.row_space_free.squared_length / m
        manipulability = ratio(model.row_space_free.volume, mean_square ** (m / 2))
        damping = self.damping * mean_square * fmax(1 - manipulability / self.threshold, 0) ** 2
        return damping + model.stagnation_damping
