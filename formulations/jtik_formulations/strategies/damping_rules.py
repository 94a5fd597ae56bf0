"""Damped least squares by other rules for the damping (formulations/damped.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik import register_strategy
from jtik.strategy import LocalModel
from jtik.symbolic import Expression, fmax, ratio
from jtik_formulations.strategies.damped import DampedLeastSquares, positive


@register_strategy("damped_constant")
@dataclass(frozen=True, kw_only=True)
class ConstantDamped(DampedLeastSquares):
    """dq = -J' (J J' + lambda I)^-1 r - beta (I - J+ J) grad H, with one lambda for all poses.

    To compare with, and for servoing a path near singular poses, where equal steps count more than arrival: it
    converges linearly, the slower the weaker J is.

    Attributes:
        damping: lambda, in the unit of J J' [m^2 / rad^2].
        q_limit, backtracking, secondary: see `DampedLeastSquares`.

    Source: Wampler (1986).
    """

    damping: float = 1e-3

    summary = "damped least squares with constant damping"
    source = "Wampler 1986"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("damping", self.damping)

    def damping_of(self, model: LocalModel) -> Expression:
        """The damping."""
        return self.damping


@register_strategy("sugihara")
@dataclass(frozen=True, kw_only=True)
class Sugihara(DampedLeastSquares):
    """dq = -J' (J J' + lambda I)^-1 r - beta (I - J+ J) grad H, with lambda = V + bias.

    Levenberg and Marquardt's step with the error as its damping. It needs no look at the rank anywhere, on the way
    or at a target out of reach. The bias keeps the last steps bounded at singular targets and costs the quadratic end.

    Attributes:
        bias: least lambda, in the unit of J J' [m^2 / rad^2]; 1e-3 to 1e-2 of a link's length squared, says Sugihara.
        q_limit, backtracking, secondary: see `DampedLeastSquares`.

    Source: Sugihara (2011), with one bias for all joints.
    """

    bias: float = 1e-3

    summary = "damped least squares, damped by V and a constant bias"
    source = "Sugihara 2011"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("bias", self.bias)

    def damping_of(self, model: LocalModel) -> Expression:
        """V and the bias."""
        return model.here.V + self.bias


@register_strategy("nakamura")
@dataclass(frozen=True, kw_only=True)
class NakamuraHanafusa(DampedLeastSquares):
    """dq = -J' (J J' + lambda I)^-1 r - beta (I - J+ J) grad H, lambda growing as manipulability w falls below w0.

    lambda = lambda0 (1 - w / w0)^2 where w < w0, else 0. Newton's step in good poses, a damped one near singular poses,
    whatever the error. w is the volume of the manipulability ellipsoid, sqrt(det J J'), here relative to that of a
    ball with the same Frobenius norm of J, so that w and w0 lie between 0 and 1 for every robot and unit; lambda0 is
    relative to |J|^2 / m, the mean square of the singular values.

    Attributes:
        damping: lambda0, at a singular pose, relative to |J|^2 / m.
        threshold: w0, from 0 to 1.
        q_limit, backtracking, secondary: see `DampedLeastSquares`.

    Source: Nakamura and Hanafusa (1986); Yoshikawa (1985) for w.
    """

    damping: float = 1e-4
    threshold: float = 0.1

    summary = "damped least squares, damped where manipulability is low"
    source = "Nakamura and Hanafusa 1986"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("damping", self.damping)
        positive("threshold", self.threshold)

    def damping_of(self, model: LocalModel) -> Expression:
        """lambda0 (1 - w / w0)^2 below the threshold."""
        m = model.J.shape[0]
        mean_square = model.rows.squared_length / m
        manipulability = ratio(model.rows.volume, mean_square ** (m / 2))
        return self.damping * mean_square * fmax(1 - manipulability / self.threshold, 0) ** 2
