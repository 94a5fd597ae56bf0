"""The transpose step with alpha and S from the discrete stability proof (formulations/transpose.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik.strategy import LocalModel
from jtik.symbolic import Expression, dot, fmin, if_else, norm, ratio, sumsqr, vertcat


def optimal_gain(decrease: Expression, image: Expression, curvature: Expression = 0) -> Expression:
    """alpha = N / 2D = u'Mu / |image|^2, the minimum of the linear model of V along a step with J dq = -alpha image.

    Args:
        decrease: decrease of V per unit of alpha, to first order.
        image: J times the direction (m, 1).
        curvature: further curvature of V along the direction, that of a timed step.
    """
    return ratio(decrease, sumsqr(image) + curvature)


@dataclass(frozen=True)
class CauchyStep:
    """The transpose step -gain * direction, with direction = S J' r.

    Attributes:
        direction: S J' r (n, 1).
        image: J direction (m, 1).
        gain: factor of the direction.
        alpha: the paper's alpha.
        s: entry of S for rotational joints.
    """

    direction: Expression
    image: Expression
    gain: Expression
    alpha: Expression
    s: Expression


def cauchy_step(model: LocalModel, limit: Expression) -> CauchyStep:
    """The transpose step whose rotational part is at most ``limit`` [rad] long.

    S = diag(1 for prismatic, s for rotational joints) with s = min(1, limit / Q), Q from the step with S = I; then
    alpha = min(alpha0, alpha*(S)), so that the linear model of V falls and the limit holds on mixed arms too.
    """
    J, g = model.J_free, model.task_gradient
    image = J @ g
    alpha = optimal_gain(sumsqr(g), image, model.curvature * sumsqr(g))
    s = fmin(1, ratio(limit, alpha * model.rotation_norm(g)))
    if model.all_rotational:
        return CauchyStep(g, image, alpha * s, alpha, s)
    limited = _scaled(model, s, g)
    image = J @ limited
    alpha = fmin(alpha, optimal_gain(dot(g, limited), image, model.curvature * sumsqr(limited)))
    return CauchyStep(limited, image, alpha, alpha, s)


def printed_step(model: LocalModel, limit: float) -> CauchyStep:
    """The step as the paper prints it: s = 1/Q whenever Q exceeds the limit, and S inside N and D.

    Q is of all joints here, as printed. The null-space step, which the paper's Q contains as well, is left out. On an
    all-revolute arm alpha(S) S does not depend on S, so the printed S changes nothing there.
    """
    J, g = model.J_free, model.task_gradient
    Q = optimal_gain(sumsqr(g), J @ g) * norm(model.coordinates.to_joints(g))
    longer = limit < Q
    s = if_else(longer, 1 / if_else(longer, Q, 1), 1)
    limited = _scaled(model, s, g)
    image = J @ limited
    alpha = optimal_gain(dot(g, limited), image)
    return CauchyStep(limited, image, alpha, alpha, s)


def _scaled(model: LocalModel, s: Expression, g: Expression) -> Expression:
    """S g."""
    return vertcat(*[(s if model.rotational[i] else 1) * g[i] for i in range(model.robot.n)])
