"""Deprecated names of tasks."""

from __future__ import annotations

import pytest

from jtik import FrameTask, Robot
from jtik.task import TaskStack

ARM = Robot.planar([1.0, 1.0])


def test_plain_is_the_deprecated_name_of_target_is_vector():
    with pytest.warns(DeprecationWarning, match="Task.plain is now Task.target_is_vector"):
        assert FrameTask().plain(ARM)
    with pytest.warns(DeprecationWarning, match="TaskStack.plain is deprecated: use target_is_vector"):
        assert TaskStack.of(ARM, FrameTask()).plain


def test_a_subclass_that_defines_plain():
    with pytest.warns(DeprecationWarning, match="Own.plain is now Own.target_is_vector"):

        class Own(FrameTask):
            def plain(self, robot):
                return False

    assert not Own().target_is_vector(ARM)
