"""Masses and shapes on frames: what is kept, and what is refused."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import jtik
from jtik.robot import Mass
from jtik.robot.masses_and_shapes import masses_on, shapes_on

FRAMES = ("base", "arm")


class TestMass:
    def test_it_is_at_the_origin_of_its_frame_by_default(self):
        assert Mass(2).center.tolist() == [0, 0, 0]
        assert isinstance(Mass(2).mass, float)

    def test_what_comes_in_is_copied_and_read_only(self):
        center = np.ones(3)
        mass = Mass(1.0, center)
        center[:] = 7
        assert mass.center.tolist() == [1, 1, 1]
        with pytest.raises(ValueError, match="read-only"):
            mass.center[0] = 2

    @pytest.mark.parametrize("copied", [copy.deepcopy, lambda mass: pickle.loads(pickle.dumps(mass))])
    def test_a_copy_is_equal_and_read_only(self, copied):
        again = copied(Mass(1.5, [1, 2, 3]))
        assert (again.mass, again.center.tolist()) == (1.5, [1, 2, 3])
        assert not again.center.flags.writeable

    @pytest.mark.parametrize(
        ("arguments", "named"),
        [
            ((-1.0,), "non-negative mass"),
            ((np.nan,), "mass"),
            ((1.0, [1, 2]), "center"),
            ((1.0, [np.inf] * 3), "center"),
        ],
    )
    def test_invalid_masses_are_refused(self, arguments, named):
        with pytest.raises(jtik.ArgumentError, match=named):
            Mass(*arguments)


def test_masses_of_zero_are_left_out():
    assert masses_on(FRAMES, None) == {}
    kept = Mass(1.0)
    assert masses_on(FRAMES, {"base": Mass(0.0), "arm": kept}) == {"arm": kept}


def test_frames_without_shapes_are_left_out():
    ball = jtik.Sphere((0, 0, 0), 0.1)
    assert shapes_on(FRAMES, None) == {}
    assert shapes_on(FRAMES, {"base": [], "arm": [ball, ball]}) == {"arm": (ball, ball)}


def test_an_unknown_frame_lists_the_frames():
    with pytest.raises(jtik.UnknownNameError, match="frame of a mass 'hand'.*base, arm"):
        masses_on(FRAMES, {"hand": Mass(1.0)})
    with pytest.raises(jtik.UnknownNameError, match="frame of a shape 'hand'.*base, arm"):
        shapes_on(FRAMES, {"hand": []})


def test_other_objects_are_refused():
    with pytest.raises(jtik.ArgumentError, match=r"masses\['arm'\]: given 1.0; accepted: a jtik.robot.Mass"):
        masses_on(FRAMES, {"arm": 1.0})
    with pytest.raises(jtik.ArgumentError, match=r"shapes\['arm'\]: given ball; accepted: a jtik.Sphere, Capsule"):
        shapes_on(FRAMES, {"arm": ["ball"]})
