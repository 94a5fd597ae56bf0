"""Local models with a linear residual and a quadratic criterion, whose answers have closed forms."""

from __future__ import annotations

import casadi
import numpy as np

from jtik.strategy import Evaluation, LocalModel, NullSpaceDisplacement, Outcome
from jtik.symbolic import function

from ..conftest import planar


def numbers(expression):
    """The value of a constant expression: a number, or an array (n,) or (m, n)."""
    value = np.array(casadi.DM(casadi.SX(expression)))
    return value.item() if value.size == 1 else value[:, 0] if value.shape[1] == 1 else value


def quadratic_model(J, r, *, gradient=None, hessian=None, q=None, robot=None, active=(), limits=None, **fields):
    """A local model of constants: residual r + J dq and H = gradient' dq + dq' hessian dq / 2.

    Args:
        J: Jacobian (m, n).
        r: residual at q (m,).
        gradient: dH/dq (n,); None for no criterion.
        hessian: of H (n, n); the identity by default.
        q: configuration (n,); zeros by default.
        robot: a robot without quaternions; a planar arm by default.
        active: joints whose limit is active.
        limits: lower and upper limits (n,) each; None without.
        **fields: other fields of the model.
    """
    (m, n), has_criterion = J.shape, gradient is not None
    q = np.zeros(n) if q is None else q
    hessian = np.eye(n) if hessian is None else hessian
    gradient = np.zeros(n) if gradient is None else gradient
    at, none = casadi.SX.sym("at", n), casadi.SX.sym("none", 0)
    dq = at - q
    residual = function("residual", [at, none], [casadi.SX(r) + casadi.SX(J) @ dq])
    H = function("H", [at, none], [casadi.dot(gradient, dq) + dq.T @ casadi.SX(hessian) @ dq / 2])
    free = np.ones(n)
    free[list(active)] = 0
    lower, upper = limits or (np.full(n, -np.inf), np.full(n, np.inf))
    values = {
        "robot": robot or planar(n),
        "here": Evaluation(casadi.SX(q), casadi.SX(r), casadi.SX(0)),
        "J": casadi.SX(J),
        "gradient": casadi.SX(gradient),
        "J_free": casadi.SX(J * free),
        "gradient_free": casadi.SX(gradient * free),
        "has_criterion": has_criterion,
        "near_target": 0,
        "neighbourhood": 1.0,
        "lower": casadi.SX(lower),
        "upper": casadi.SX(upper),
        "bounded": tuple((i, i) for i in range(n)) if limits else (),
        "levels": (tuple(range(m)),),
        "residual_function": residual,
        "criterion_function": H,
        "target": casadi.SX(0, 1),
        "parameters": casadi.SX(0, 1),
    }
    return LocalModel(**values | fields)


def outcome(accepted, *, shorten_task=1, shorten_null_space=0, null_space=None, ratio=1.0):
    """The verdict on a step of three joints."""
    null_space = null_space or NullSpaceDisplacement.none(3)
    return Outcome(accepted, ratio, null_space, shorten_task, shorten_null_space)
