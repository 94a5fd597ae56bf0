"""Norms without overflow."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.result.length import length, lengths


@pytest.mark.parametrize("scale", [1e-300, 1.0, 1e155, 1e300])
def test_any_scale(scale):
    assert length(scale * np.array([[3.0, 0.0], [0.0, -4.0]])) == pytest.approx(5 * scale)
    assert lengths(scale * np.array([[3.0, 4.0], [0.0, 0.0]])) == pytest.approx([5 * scale, 0.0])


def test_what_is_no_number():
    assert length(np.zeros(0)) == 0.0
    assert np.isnan(length(np.array([np.nan, 1.0])))
    assert np.isinf(length(np.array([np.inf, 1.0])))
