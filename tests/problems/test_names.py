"""Public names of `jtik.problems`, and the old ones."""

from __future__ import annotations

import pytest

from jtik import problems


def test_the_old_name_of_a_named_problem_warns():
    with pytest.warns(DeprecationWarning, match=r"jtik\.problems\.Named is now jtik\.problems\.NamedProblem"):
        assert problems.Named is problems.NamedProblem
    assert isinstance(problems.named("elbow_2r"), problems.NamedProblem)


def test_public_names_exist():
    assert all(hasattr(problems, name) for name in problems.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        problems.nothing  # noqa: B018
