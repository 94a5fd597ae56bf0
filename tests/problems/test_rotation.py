"""Rotation matrices from rotation vectors, against SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik.problems.rotation import rotation_about


@pytest.mark.parametrize("vector", [(0, 0, 0), (1e-9, 0, 0), (0.3, -0.4, 1.2), (0, np.pi, 0), (2, 2, -5)])
def test_the_matrix_is_that_of_scipy(vector):
    expected = Rotation.from_rotvec(vector).as_matrix()
    np.testing.assert_allclose(rotation_about(np.array(vector, dtype=float)), expected, atol=1e-14)
