"""Criteria: scalars H(q) that a redundant robot minimises besides its task, with live parameters."""

from jtik.criterion.base import Criteria, Criterion, CriterionError, CriterionSum
from jtik.criterion.decorator import criterion
from jtik.criterion.function_criterion import FunctionCriterion
from jtik.criterion.least_squares import ResidualCriterion
from jtik.criterion.numeric import NumericCriterion
from jtik.criterion.parameters import Parameters, Parametric
from jtik.criterion.terms import CriterionTerms

__all__ = [
    "Criteria",
    "Criterion",
    "CriterionError",
    "CriterionSum",
    "CriterionTerms",
    "FunctionCriterion",
    "NumericCriterion",
    "Parameters",
    "Parametric",
    "ResidualCriterion",
    "criterion",
]
