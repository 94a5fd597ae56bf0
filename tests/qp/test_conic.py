"""CasADi's plugins as back ends: names, default accuracies, options, messages and the fallback of DAQP."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp import BackendError, Conic, QPSolversBackend
from jtik.qp.backend import PLUGINS
from jtik.symbolic import has_conic
from jtik.symbolic.compile import CompiledFunction


def solve(backend, low=-2.0):
    """x of: minimise x^2/2 + x, low <= x <= inf, -3 <= x <= 3."""
    return CompiledFunction(backend.function(1, 1))(1, 1, 1, low, np.inf, -3, 3)[0].item()


@pytest.mark.parametrize("name", [name for name in PLUGINS if has_conic(name) and name not in ("qrqp", "qpoases")])
def test_each_plugin_has_its_name_and_accuracy(name):
    backend = Conic(name)
    assert (backend.name, backend.accuracy) == (name, PLUGINS[name])
    assert repr(backend) == f"Conic({name!r})"
    assert solve(backend) == pytest.approx(-1, abs=1e-4)
    assert solve(backend, low=-0.5) == pytest.approx(-0.5, abs=1e-4)


def test_the_accuracy_can_be_set():
    assert Conic("daqp", accuracy=1e-3).accuracy == 1e-3


def test_only_daqp_with_default_options_has_a_fallback():
    assert isinstance(Conic("daqp").fallback, QPSolversBackend)
    assert Conic("daqp", daqp={"primal_tol": 1e-9}).fallback is None
    assert Conic("osqp").fallback is None


def test_options_are_passed_to_the_plugin():
    few = Conic("osqp", osqp={"verbose": False, "max_iter": 1, "eps_abs": 1e-12, "eps_rel": 1e-12})
    assert abs(solve(few) + 1) > 1e-6
    assert solve(Conic("osqp")) == pytest.approx(-1, abs=1e-6)


@pytest.mark.parametrize("name", ["qrqp", "nothing"])
def test_an_unusable_plugin_lists_the_usable_ones(name):
    with pytest.raises(BackendError, match=r"is no usable plugin of this CasADi; use one of daqp, ") as caught:
        Conic(name)
    assert caught.value.solver == name
    assert "qrqp" not in caught.value.reason


def test_an_unknown_option_is_named_without_casadis_stack():
    with pytest.raises(BackendError) as caught:
        Conic("daqp", nonsense=1).function(1, 1)
    assert "nonsense" in caught.value.reason
    assert ".cpp" not in caught.value.reason
