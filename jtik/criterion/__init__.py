"""The secondary: a scalar H(q) that the freedom left by the task minimises, with live parameters."""

from jtik.criterion.base import Criteria, Criterion, CriterionError, CriterionSum
from jtik.criterion.decorator import FunctionCriterion, criterion
from jtik.criterion.parameters import Parameters, Parametric
from jtik.criterion.terms import CriterionTerms

__all__ = [
    "Criteria",
    "Criterion",
    "CriterionError",
    "CriterionSum",
    "CriterionTerms",
    "FunctionCriterion",
    "Parameters",
    "Parametric",
    "criterion",
]
