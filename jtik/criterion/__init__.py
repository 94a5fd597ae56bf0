"""Criteria: scalars H(q) that a redundant robot minimises besides its task, with live parameters."""

from jtik.criterion.base import Criteria, Criterion, CriterionError, CriterionSum
from jtik.criterion.decorator import FunctionCriterion, criterion
from jtik.criterion.least_squares import ResidualCriterion
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
    "ResidualCriterion",
    "criterion",
]
