"""Robot descriptions of folders: how many load, with or without warnings, or are refused, and their poses by MuJoCo.

    python benchmarks/robot_files.py FOLDER ... [--json FILE]

A folder is for instance that of an installed or unpacked package. Every URDF (``.urdf``) and every MJCF (``.xml`` with
the root ``mujoco``) below it is loaded. Of an MJCF that MuJoCo loads as it is, the poses of all
bodies and sites are compared at random configurations.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import jtik
from jtik.interop.mujoco_model import MujocoCorrespondence

AGREEMENT = 1e-10
"""Largest difference of an entry of a pose: rounding along chains of dozens of joints and metres."""

CONFIGURATIONS = 5


def described(folder: Path) -> list[Path]:
    """The descriptions below a folder."""
    files = [path for path in sorted(folder.rglob("*")) if path.suffix in (".urdf", ".xml") and path.is_file()]
    return [path for path in files if path.suffix == ".urdf" or re.search(rb"<mujoco[\s>/]", path.read_bytes())]


def survey(path: Path) -> dict[str, Any]:
    """What becomes of one description."""
    load = jtik.Robot.from_urdf if path.suffix == ".urdf" else jtik.Robot.from_mjcf
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            robot = load(path)
        except jtik.JtikError as error:
            reason = {"outcome": "refused", "messages": [str(error)]}
            return reason if path.suffix == ".urdf" else reason | {"mujoco": _model(path) is not None}
    messages = [str(warning.message) for warning in caught]
    found: dict[str, Any] = {
        "outcome": "warned" if messages else "loaded",
        "messages": messages,
        "ignored": list(robot.ignored),
        "joints": list(robot.joint_names),
        "tip": robot.tip,
    }
    if path.suffix != ".urdf":
        found |= compared(robot, path)
    return found


def _model(path: Path) -> Any:
    """MuJoCo's own model, or None where it refuses it."""
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return None


def compared(robot: jtik.Robot, path: Path) -> dict[str, Any]:
    """The largest difference of a pose from MuJoCo's, and the named frames that the robot does not have."""
    model = _model(path)
    if model is None:
        return {"mujoco": False}
    rng, data, worst = np.random.default_rng(0), mujoco.MjData(model), 0.0
    frames = {model.body(i).name: ("body", i) for i in range(model.nbody)}
    frames |= {model.site(i).name: ("site", i) for i in range(model.nsite) if model.site(i).name not in frames}
    missing = sorted(name for name in frames if name and name not in robot.frame_names)
    correspondence = MujocoCorrespondence(robot, model)
    for _ in range(CONFIGURATIONS):
        q = robot.random_configuration(rng)
        data.qpos[:] = correspondence.qpos(q)
        mujoco.mj_kinematics(model, data)
        for name in (name for name in frames if name and name not in missing):
            kind, number = frames[name]
            at, R = (data.xpos, data.xmat) if kind == "body" else (data.site_xpos, data.site_xmat)
            pose = robot.pose(q, name)
            worst = max(worst, np.abs(pose[:3, 3] - at[number]).max(), np.abs(pose[:3, :3].ravel() - R[number]).max())
    return {"mujoco": True, "difference": float(worst), "missing": missing}


def main() -> int:
    """Survey the folders. 1 where a pose differs, or a file that MuJoCo loads and that has a body is refused."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write what becomes of each file")
    arguments = parser.parse_args()
    everything, wrong = {}, 0
    for folder in arguments.folders:
        found = {str(path.relative_to(folder)): survey(path) for path in described(folder)}
        everything[str(folder)] = found
        kinds = Counter((Path(name).suffix, each["outcome"]) for name, each in found.items())
        print(folder, ", ".join(f"{suffix} {outcome}: {count}" for (suffix, outcome), count in sorted(kinds.items())))
        compare = [each["difference"] for each in found.values() if "difference" in each]
        if compare:
            print(f"  compared with MuJoCo: {len(compare)}, largest difference {max(compare):.1e}")
        for name, each in found.items():
            if each["outcome"] == "refused":
                by = " (MuJoCo loads it)" if each.get("mujoco") else ""
                print(f"  refused{by}: {name}: {each['messages'][0][-200:]}")
            if each.get("difference", 0) > AGREEMENT or each.get("missing"):
                print(f"  differs: {name}: {each['difference']:.1e}, missing {each['missing']}")
            wrong += each.get("difference", 0) > AGREEMENT
    if arguments.json:
        arguments.json.write_text(json.dumps(everything, indent=1) + "\n", encoding="utf-8")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
