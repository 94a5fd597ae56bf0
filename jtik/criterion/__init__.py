"""The secondary: a scalar H(q) that the freedom left by the task minimises, with live parameters."""

from jtik.criterion.base import Criterion, CriterionError, CriterionSum, CriterionTerms, Parameters, criterion

__all__ = ["Criterion", "CriterionError", "CriterionSum", "CriterionTerms", "Parameters", "criterion"]
