"""The public contract, for every registered strategy: a new plugin is tested without editing tests."""

from __future__ import annotations

import pytest

import jtik
from jtik.testing import check_strategy


@pytest.mark.parametrize("name", sorted(jtik.strategies))
def test_contract(name):
    check_strategy(name)
