"""The former name of `jtik.qp.fast_path`, for its remaining caller."""

from jtik.qp.fast_path import fast_or_qp_path as near_or_far

__all__ = ["near_or_far"]
