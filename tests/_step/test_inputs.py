"""Inputs of the step: one piece of memory, a view of each part, in the order of the named structure."""

from __future__ import annotations

import numpy as np

from jtik._step.inputs import SETTING, InputMemory, Inputs, Settings
from jtik.criterion import Parameters

from ..conftest import planar


def memory():
    parameters = Parameters({"a.weight": 2.0, "a.centers": [[1.0, 2.0], [3.0, 4.0]]}, planar(2))
    return parameters, InputMemory(3, parameters, np.array([-1.0, -2.0]), np.array([1.0, 2.0]))


def test_parts_are_views_one_after_the_other():
    _, inputs = memory()
    assert [len(part) for part in inputs.inputs] == [3, 5, 2, 2, len(Settings())]
    assert np.concatenate(inputs.inputs).tolist() == inputs.numbers.tolist()
    for part in inputs.inputs:
        assert np.shares_memory(part, inputs.numbers)


def test_a_copy_of_the_memory_has_views_of_its_own():
    _, inputs = memory()
    copied = inputs.numbers.copy()
    views = inputs.views(copied)
    inputs.inputs.target[:] = 7.0
    assert views.target.tolist() == [0.0, 0.0, 0.0]
    assert views.lower.tolist() == [-1.0, -2.0]
    assert isinstance(views, Inputs)


def test_live_parameters_are_written_where_the_step_reads_them():
    parameters, inputs = memory()
    parameters["a.weight"] = 5.0
    assert 5.0 in inputs.inputs.parameters.tolist()


def test_settings_are_found_by_name():
    _, inputs = memory()
    settings = inputs.inputs.settings
    settings[SETTING.optimality_tolerance] = 0.5
    assert Settings(*settings.tolist())._asdict() == {**Settings()._asdict(), "optimality_tolerance": 0.5}
