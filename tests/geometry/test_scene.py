"""Scenes: named obstacles, their gains and their file."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik

SPATIAL = jtik.Scene(
    {
        "table": jtik.Box.at((0.5, 0, 0.2), (0.3, 0.4, 0.02), (0.9, 0.1, 0.2, 0.3)),
        "floor": jtik.HalfSpace((0, 0, 0), (0.1, 0, 1)),
        "post": jtik.Cylinder((1, 0, 0), (1, 0, 1), 0.05),
        "cable": jtik.Capsule((1, 1, 0), (1, 0, 1), 0.01),
        'a "name" with é': jtik.Sphere((1, 2, 3), 0.25),
        "spot": jtik.Point((0.1, 0.2, 1e-5)),
    },
    {"floor": 0.5, "cable": 0.0},
)

PLANAR = jtik.Scene(
    [
        jtik.Circle((1, 2), 0.3),
        jtik.Polygon([(0, 0), (1, 0), (0.5, 1)]),
        jtik.Box.at((1, 1), (0.1, 0.2), 0.3),
        jtik.HalfSpace((0, -1), (0, 1)),
    ]
)


@pytest.mark.parametrize("scene", [SPATIAL, PLANAR, jtik.Scene()])
@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_what_is_saved_is_loaded(scene, suffix, tmp_path):
    path = tmp_path / f"scene.{suffix}"
    scene.save(path)
    again = jtik.Scene.load(path)
    assert again.names == scene.names
    assert dict(again.gains) == dict(scene.gains)
    for one, other in zip(scene, again, strict=True):
        assert type(one) is type(other)
        for field, value in vars(one).items():
            assert getattr(other, field) == pytest.approx(value, abs=1e-15)


def test_a_scene_survives_pickling_and_dicts():
    for scene in (SPATIAL, PLANAR):
        assert jtik.Scene.from_dict(scene.to_dict()).names == scene.names
        assert pickle.loads(pickle.dumps(scene)) == scene
    assert PLANAR != SPATIAL


def test_a_scene_with_one_more_or_one_less_is_another_scene():
    more = SPATIAL.with_("lamp", jtik.Sphere((0, 0, 2), 0.1), gain=0.3)
    assert "lamp" not in SPATIAL
    assert more.names == (*SPATIAL.names, "lamp")
    assert more.gains["lamp"] == 0.3
    assert more.gains["cable"] == 0.0
    moved = more.with_("table", jtik.Sphere((0, 0, 1), 0.1))
    assert moved.names == more.names
    assert isinstance(moved["table"], jtik.Sphere)
    assert more.without("lamp") == SPATIAL
    with pytest.raises(jtik.UnknownNameError, match=r"obstacle.*'lamp'.*table"):
        SPATIAL.without("lamp")
    with pytest.raises(TypeError):
        SPATIAL.obstacles["x"] = None


def test_obstacles_without_names_are_named_by_shape_and_number():
    assert PLANAR.names == ("circle0", "polygon1", "box2", "halfspace3")


GOOD = {"obstacles": {"table": {"shape": "box", "center": [0, 0, 0], "half": [1, 1, 1]}}}


def changed(**values):
    row = {**GOOD["obstacles"]["table"], **values}
    return {"obstacles": {"table": {key: value for key, value in row.items() if value is not None}}}


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({}, r"scene.obstacles: given nothing: the key is missing"),
        ([], r"scene: .*accepted: a table"),
        ({"obstacles": {}, "colour": 1}, r"scene.colour: given an unknown key"),
        ({"obstacles": [1]}, r"obstacles: "),
        ({"obstacles": {"table": 3}}, r"obstacles.table: given 3"),
        (changed(shape=None), r"obstacles.table.shape: given nothing"),
        (changed(shape="cube"), r"obstacles.table.shape: given 'cube'; accepted: one of .*'box'"),
        (changed(half=None), r"obstacles.table.half: given nothing: the key is missing"),
        (changed(half=[1, -1, 1]), r"obstacles.table.half: given .*-1"),
        (changed(half="big"), r"obstacles.table.half"),
        (changed(rotation=[0, 0, 0, 0]), r"obstacles.table.rotation: .*not zero"),
        (changed(radius=1), r"obstacles.table.radius: given an unknown key"),
        (changed(gain=-1), r"obstacles.table.gain: given -1"),
        (
            {"obstacles": {"a": {"shape": "polygon", "vertices": [[0, 0], [1, 1], [2, 2]]}}},
            r"obstacles.a.vertices: given a polygon with the area 0",
        ),
        (
            {"obstacles": {"a": {"shape": "circle", "center": [0, 0], "radius": -0.1}}},
            r"obstacles.a.radius: given -0.1",
        ),
        (
            {
                "obstacles": {
                    "a": {"shape": "point", "center": [0, 0]},
                    "b": {"shape": "point", "center": [0, 0, 0]},
                }
            },
            r"obstacles: given obstacles in the plane and in space",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_its_name_and_the_key(data, says, tmp_path):
    import json

    path = tmp_path / "scene.json"
    path.write_text(json.dumps(data))
    with pytest.raises(jtik.ArgumentError, match=says) as caught:
        jtik.Scene.load(path)
    assert str(path) in str(caught.value)
    with pytest.raises(jtik.ArgumentError, match=says):
        jtik.Scene.from_dict(data)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.toml", "x = ="),
        ("a.json", "{"),
        ("a.toml", "[obstacles]\nx = 3"),
        ("a.json", "[" * 100_000),
        ("a.toml", "a = " + "[" * 100_000),
        ("a.json", '{"obstacles": {"a": {"shape": "point", "center": [0, 0], "center": [1, 1]}}}'),
    ],
)
def test_a_file_that_is_no_scene(name, text, tmp_path):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(jtik.ArgumentError, match=name):
        jtik.Scene.load(path)


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: jtik.Scene("box"), "obstacles"),
        (lambda: jtik.Scene({"a": 3}), r"obstacles\['a'\]"),
        (lambda: jtik.Scene({"": jtik.Point((0, 0))}), "obstacles"),
        (lambda: jtik.Scene([jtik.Point((0, 0)), jtik.Point((0, 0, 0))]), "one dimension"),
        (lambda: jtik.Scene([jtik.Point((0, 0))], [1.0, 2.0]), "gains"),
        (lambda: jtik.Scene([jtik.Point((0, 0))], [-1.0]), "gains"),
        (lambda: jtik.Scene.load("/nowhere/scene.toml"), "path"),
        (lambda: jtik.Scene().save("scene.yaml"), "path"),
        (lambda: jtik.Scene().with_("a", 3), "obstacle"),
        (lambda: jtik.Scene().with_("a", jtik.Point((0, 0)), -1), "gain"),
    ],
)
def test_wrong_arguments_of_a_scene(build, says):
    with pytest.raises(jtik.ArgumentError, match=says):
        build()


@pytest.mark.parametrize(
    ("build", "argument"),
    [
        (lambda: jtik.HalfSpace((0, 0), (0, 0)), "normal"),
        (lambda: jtik.HalfSpace((0, 0), (0, 0, 1)), "normal"),
        (lambda: jtik.HalfSpace((0, np.nan), (0, 1)), "point"),
        (lambda: jtik.Polygon([(0, 0), (1, 0)]), "vertices"),
        (lambda: jtik.Polygon([(0, 0), (1, 0), (2, 1e-12)]), "vertices"),
        (lambda: jtik.Polygon([(0, 0), (2, 0), (1, 0.5), (1, 2)]), "vertices"),
        (lambda: jtik.Polygon([(np.cos(a), np.sin(a)) for a in np.arange(5) * 4 * np.pi / 5]), "vertices"),
        (lambda: jtik.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]), "vertices"),
        (lambda: jtik.Cylinder((0, 0), (0, 1), 0.1), "start"),
        (lambda: jtik.Cylinder((0, 0, 1), (0, 0, 1), 0.1), "end"),
        (lambda: jtik.Capsule((0, 0), (1, 0), -0.1), "radius"),
        (lambda: jtik.Box(np.diag([1.0, 2.0, 1.0, 1.0]), (1, 1, 1)), "pose"),
        (lambda: jtik.Box(np.diag([1.0, -1.0, 1.0]), (1, 1)), "pose"),
        (lambda: jtik.Box.at((0, 0), (1, 1), (1, 0, 0, 0)), "rotation"),
        (lambda: jtik.Box.at((0, 0, 0), (1, 1)), "half"),
    ],
)
def test_shapes_that_are_none(build, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        build()
    assert caught.value.argument == argument


@pytest.mark.parametrize("suffix", ["toml", "json"])
@pytest.mark.parametrize("name", ["\x7f", "\n\t", "\x01", "a.b", '"', "\\u0041", "[x]", "\U0001f600", "\u2028", "#"])
def test_names_of_any_characters_are_kept_in_a_file(name, suffix, tmp_path):
    scene = jtik.Scene({name: jtik.Circle((1, 2), 0.5)})
    scene.save(tmp_path / f"scene.{suffix}")
    assert jtik.Scene.load(tmp_path / f"scene.{suffix}") == scene


def test_a_name_that_cannot_be_written_leaves_the_file_as_it_was(tmp_path):
    path = tmp_path / "scene.toml"
    PLANAR.save(path)
    with pytest.raises(jtik.ArgumentError, match="obstacles"):
        jtik.Scene({"\ud800": jtik.Circle((1, 2), 0.5)}).save(path)
    assert jtik.Scene.load(path) == PLANAR


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_a_file_of_a_text_editor_with_a_byte_order_mark(suffix, tmp_path):
    path = tmp_path / f"scene.{suffix}"
    PLANAR.save(path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert jtik.Scene.load(path) == PLANAR


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rotated_box_is_read_as_it_was_saved(dimension, tmp_path, rng):
    """Digit for digit, again and again: a scene that comes from a file or a pickle is equal to what was saved."""
    for _ in range(50):
        rotation = rng.uniform(-9, 9) if dimension == 2 else rng.normal(size=4) * 10.0 ** rng.integers(-200, 150)
        scene = jtik.Scene([jtik.Box.at(np.zeros(dimension), np.ones(dimension), rotation)])
        scene.save(tmp_path / "scene.toml")
        read = jtik.Scene.load(tmp_path / "scene.toml")
        assert read == scene
        assert pickle.loads(pickle.dumps(scene)) == scene
        box, again = scene["box0"], read["box0"]
        assert again.pose.tolist() == box.pose.tolist()
        assert "_" not in repr(box)
