"""Trial of the criteria of a solver at a few configurations: a value that is not finite there is refused at once."""

from __future__ import annotations

import numpy as np

from jtik.criterion.terms import CriterionTerms
from jtik.criterion.tracing import CriterionError
from jtik.symbolic import Function
from jtik.symbolic.compile import CompiledFunction

CONFIGURATIONS = 5
"""Number of configurations tried: `Robot.home`, where a solve starts by default, and random ones within the limits."""


def check_finite(terms: CriterionTerms, values: Function) -> None:
    """Evaluate every criterion at the first configurations, with the first values of its parameters.

    A criterion may have no value in a part of the space, such as behind a barrier: no step leads there. It must have
    one where a solve starts by default, and at one of the random configurations.

    Args:
        terms: the criteria.
        values: (q, parameters) -> the weighted value of each criterion.

    Raises:
        CriterionError: when a value is not finite at home, or at all random configurations; the message contains the
            configuration.
    """
    if not terms.named:
        return
    evaluate, robot, generator = CompiledFunction(values), terms.robot, np.random.default_rng(0)
    tried = [robot.home, *[robot.random_configuration(generator) for _ in range(CONFIGURATIONS - 1)]]
    found = np.array([evaluate(q, terms.parameters.memory)[0][:, 0] for q in tried])
    for (name, _, _), own in zip(terms.named, found.T, strict=True):
        finite = np.isfinite(own)
        if finite[0] and finite[1:].any():
            continue
        k = int(finite[0])
        at = np.array2string(tried[k], separator=", ", max_line_width=1000)
        where = "" if k == 0 else f", and not finite at {CONFIGURATIONS - 2} more random configurations"
        raise CriterionError(
            name,
            f"is {own[k]} at q = {at}{where}; expected a finite number. Bound logarithms, roots and divisions, for "
            "instance by casadi.fmax, or give its parameters other first values",
        )
