"""Files of studies that somebody else has made, and names in tables: no raw error, nothing that runs."""

from __future__ import annotations

import copy
import json
import os
import zipfile

import numpy as np
import pytest

import jtik
from jtik.study import tables


@pytest.fixture(scope="module")
def saved(arm, task, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "study.npz"
    jtik.compare(arm, task, strategies=["damped"], problems={"reachable": 2, "circle": 1}, repeats=1).save(path)
    with np.load(path, allow_pickle=False) as file:
        arrays = dict(file)
    return json.loads(str(arrays.pop("header"))), arrays


def refused(path):
    with pytest.raises(jtik.ArgumentError) as caught:
        jtik.Comparison.load(path)
    assert caught.value.argument == "path"
    assert str(path) in str(caught.value)
    return str(caught.value)


def loaded_or_refused(path):
    """What is loaded can be shown; what is not is refused with the path."""
    try:
        found = jtik.Comparison.load(path)
    except jtik.ArgumentError as error:
        message = str(error)
    else:
        message = str(path) + repr(found)
    assert str(path) in message


def write(path, header, arrays):
    np.savez(path, header=np.array(json.dumps(header)), **arrays)


WRONG = (None, 5, "x", [], {}, [1, "a"], {"a": 1}, [[1, 2]], -1, True)


@pytest.mark.slow
def test_a_forged_header(saved, tmp_path):
    header, arrays = saved
    path = tmp_path / "forged.npz"
    write(path, header, arrays)
    jtik.Comparison.load(path)
    for key in header:
        write(path, {name: value for name, value in header.items() if name != key}, arrays)
        if key == "obstacles":  # files of earlier versions do not have it
            assert not jtik.Comparison.load(path).obstacles
        else:
            refused(path)
        for wrong in WRONG:
            write(path, {**header, key: wrong}, arrays)
            loaded_or_refused(path)


def places(value, before=()):
    """The way to every part of nested lists and dicts."""
    yield before
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*before, key))


@pytest.mark.quick(1)
@pytest.mark.parametrize("part", ["robot", "tasks", "problems", "traces", "paths"])
def test_a_forged_part_of_a_header(saved, tmp_path, part):
    header, arrays = saved
    path, rng = tmp_path / "forged.npz", np.random.default_rng(0)
    ways = list(places(header[part]))[1:]
    for way in [ways[i] for i in rng.permutation(len(ways))[:60]]:
        forged = copy.deepcopy(header)
        inside = forged[part]
        for key in way[:-1]:
            inside = inside[key]
        inside[way[-1]] = WRONG[rng.integers(len(WRONG))]
        write(path, forged, arrays)
        loaded_or_refused(path)


@pytest.mark.slow
def test_forged_columns(saved, tmp_path):
    header, arrays = saved
    path = tmp_path / "forged.npz"
    for name, array in arrays.items():
        others = [{}, {name: array[:-1]}, {name: np.array("x")}, {name: np.zeros((2, 2, 2), dtype=complex)}]
        for other in others:
            write(path, header, {**{each: value for each, value in arrays.items() if each != name}, **other})
            if name.startswith("trace/") and other and array.ndim == other[name].ndim:
                continue  # a shorter trace is a trace
            if name.startswith("path/") and other and array.ndim == other[name].ndim:
                continue
            refused(path)


def test_a_resumed_study_names_the_file(saved, tmp_path, arm, task):
    header, arrays = saved
    path = tmp_path / "forged.npz"
    write(path, header, {name: array for name, array in arrays.items() if name != "answers"})
    with pytest.raises(jtik.ArgumentError, match=r"save: given .*forged.npz, whose parts do not fit together"):
        jtik.compare(arm, task, strategies=["damped"], problems={"reachable": 2}, save=path)


def test_what_is_no_archive(tmp_path):
    path = tmp_path / "study.npz"
    for content in (b"", b"PK", b"\x93NUMPY\x01\x00", b"PK\x03\x04" + bytes(100), b"\x80\x04N."):
        path.write_bytes(content)
        refused(path)
    write(path, [[[[]]]], {})
    refused(path)
    np.savez(path, header=np.array("[" * 100_000))
    refused(path)
    with zipfile.ZipFile(path, "w") as file:  # an array that says that it is larger than any memory
        file.writestr(
            "header.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (9" + b"9" * 15
        )
    refused(path)


def test_a_zip_bomb_is_not_unpacked(tmp_path):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file, file.open("header.npy", "w") as member:
        for _ in range(64):
            member.write(bytes(2**20))
    assert "unpacks from" in refused(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_or_a_device_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.npz")
    assert "no regular file" in refused(tmp_path / "pipe.npz")
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    assert "no regular file" in refused(tmp_path / "zero.npz")
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load("a\0.npz")


NAMES = [
    "<img src=x onerror=alert(1)>",
    "=cmd|' /C calc'!A0",
    "a | b",
    "[x](javascript:alert(1))",
    "+1",
    "@x",
    "a\nb",
    "`c`",
]


def test_names_in_markdown_are_shown_as_they_are_written():
    lines = tables.markdown({"contender": NAMES, "H|": [0.0] * len(NAMES)}).splitlines()
    assert len(lines) == 2 + len(NAMES)
    assert not any("<" in line for line in lines)
    assert "&lt;img src=x onerror=alert(1)&gt;" in lines[2]
    assert r"\[x\](javascript:alert(1))" in lines[5]
    for line in lines:
        assert line.replace(r"\|", "").count("|") == 3


@pytest.mark.slow
def test_a_table_for_a_spreadsheet_has_no_formulas(saved, tmp_path, arm, task):
    found = jtik.compare(
        arm, task, strategies=dict.fromkeys(NAMES, "damped"), problems={"reachable": 1}, repeats=1, traces=0
    )
    found.to_csv(tmp_path / "rows.csv")
    lines = (tmp_path / "rows.csv").read_text().splitlines()
    assert not any(line.startswith(("=", "+", "-", "@", '"=')) for line in lines)
    assert any(line.startswith("'=cmd|") for line in lines)
    assert "<img" not in found._repr_html_()
    assert "<img" not in found.to_markdown()
    found.save(tmp_path / "study.npz")
    assert jtik.Comparison.load(tmp_path / "study.npz").contenders == tuple(NAMES)
