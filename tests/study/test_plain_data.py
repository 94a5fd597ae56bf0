"""Descriptions of robots, tasks and their parts as plain data."""

from __future__ import annotations

import json

import pytest

import jtik
from jtik._loop.fingerprint import fingerprint
from jtik.robot.masses_and_shapes import Mass
from jtik.study.plain_data import DescriptionError, as_data, from_data


class Fingers:
    """A class that is not jtik's."""


class TestDescriptions:
    @pytest.mark.parametrize(
        "value",
        [
            jtik.Robot.planar([1.0, 0.1 + 0.2], lower=-1.0, upper=2.0),
            jtik.Robot.builtin("panda"),
            jtik.Robot([jtik.Joint("float", jtik.JointType.FREE, "base", "body")], masses={"body": Mass(2.0)}),
            jtik.Robot(jtik.Robot.planar(2).joints, planar=True, neutral=[0.1, 0.2]),
            jtik.FrameTask("tip", "pose", axes=("x", "rz"), stiffness=[1.0, 2.0], priority=1, name="hand"),
            (jtik.AxisTask("tip", axis=(0, 1, 1)), jtik.LookAtTask("tip"), jtik.RelativeFrameTask("a", "b")),
            jtik.CenterOfMassTask(),
        ],
        ids=repr,
    )
    def test_descriptions_survive_json(self, value):
        loaded = from_data(json.loads(json.dumps(as_data(value))))
        assert fingerprint(loaded) == fingerprint(value)

    def test_other_classes_are_neither_described_nor_created(self):
        with pytest.raises(DescriptionError):
            as_data(Fingers())
        with pytest.raises(DescriptionError):
            from_data({"class": "Popen", "state": {"args": "true"}})
