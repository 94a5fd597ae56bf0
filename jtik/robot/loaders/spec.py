"""Compiles a description, with or without its mesh files, to a MuJoCo model for kinematics."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from jtik.errors import RobotFileError
from jtik.robot.loaders.meshes import MeshFile
from jtik.robot.loaders.source import Source

MINIMUM_MASS = 1e-12
"""Mass that moving bodies without one get for MuJoCo [kg]; a mass up to this counts as none."""


@dataclass(frozen=True)
class CompiledModel:
    """A MuJoCo model without its meshes.

    Attributes:
        model: the ``mujoco.MjModel``; a small sphere replaces each mesh.
        meshes: the meshes by the number of the geom that replaces them.
        has_inertias: whether its inertias are those of the description.
        without_mass: names of the bodies whose mass is negative or no finite number; they count as massless.
        against_tendons: why MuJoCo refuses the tendons, which are then left out; empty where it does not.
    """

    model: Any
    meshes: dict[int, MeshFile]
    has_inertias: bool
    without_mass: tuple[str, ...] = ()
    against_tendons: str = ""


def compile_source(
    source: Source, *, text: str | None = None, edit: Callable[[Any], None] | None = None
) -> CompiledModel:
    """The model of a description, without meshes, textures and other parts that kinematics does not need.

    Inertias that MuJoCo refuses are replaced, and geoms and tendons that it refuses are dropped. Masses and their
    centres are kept.

    Args:
        source: the description.
        text: the XML that MuJoCo reads; that of the source when None.
        edit: changes to make to the ``mujoco.MjSpec`` before it is compiled.

    Raises:
        RobotFileError: when MuJoCo still refuses it; the message is that of the first attempt.
    """
    first: ValueError | None = None
    with _no_warnings():
        for inertias, geoms, tendons in _ATTEMPTS:
            try:
                compiled = _compile(source, text, edit, inertias=inertias, geoms=geoms, tendons=tendons)
            except ValueError as error:
                first = first or error
            else:
                return compiled if tendons else replace(compiled, against_tendons=_reason(first))
    reason = _reason(first)
    if text is not None:
        reason = re.sub(r",? line \d+", "", reason)  # not a line of the file
    raise RobotFileError(source.label, "", f"MuJoCo refuses it: {reason}") from first


_ATTEMPTS = (
    (True, True, True),
    (False, True, True),
    (False, False, True),
    (True, True, False),
    (False, False, False),
)
"""What is compiled, one attempt after the other: with inertias, with geoms, with tendons."""


def _reason(error: ValueError | None) -> str:
    return " ".join(str(error).split())


def _compile(
    source: Source, text: str | None, edit: Callable[[Any], None] | None, *, inertias: bool, geoms: bool, tendons: bool
) -> CompiledModel:
    """The model with or without its inertias, its geoms and its tendons."""
    if text is not None:
        spec = mujoco.MjSpec.from_string(text)
    elif source.path is not None and source.is_utf8:
        spec = mujoco.MjSpec.from_file(str(source.path))
    else:
        spec = mujoco.MjSpec.from_string(source.text, include=_included(source.root, source.path))
    if edit is not None:
        edit(spec)
    meshes = _remove_meshes(spec, source.path)
    refused = [body for body in spec.bodies if body.explicitinertial and not 0 <= body.mass < math.inf]
    for body in refused:
        body.mass = 0.0
    if not inertias:
        _replace_inertias(spec)
    if not geoms:
        for element in (*spec.pairs, *spec.geoms):
            spec.delete(element)
    if not tendons:
        of_tendons = [equality for equality in spec.equalities if equality.type == mujoco.mjtEq.mjEQ_TENDON]
        for element in (*spec.actuators, *of_tendons, *spec.tendons):
            spec.delete(element)
    for sensor in spec.sensors:
        spec.delete(sensor)
    spec.memory = -1  # a file may state too little
    compiler = spec.compiler
    compiler.LRopt.mode = mujoco.mjtLRMode.mjLRMODE_NONE  # ranges of actuators are not needed, and may not converge
    compiler.fusestatic = False
    compiler.boundmass = max(compiler.boundmass, MINIMUM_MASS)
    compiler.boundinertia = max(compiler.boundinertia, MINIMUM_MASS)
    model = spec.compile()
    kept = {geom.name: geom.id for geom in spec.geoms}
    found = {kept[name]: mesh for name, mesh in meshes.items() if name in kept}
    return CompiledModel(model, found, has_inertias=inertias, without_mass=tuple(body.name for body in refused))


def _included(root: Element, path: Path | None) -> dict[str, bytes]:
    """The content of the files that a description includes, by the names that it has for them."""
    found: dict[str, bytes] = {}
    for name in (element.get("file", "") for element in root.iter("include")):
        file = None if path is None else path.resolve().parent / name
        if file is not None and file.is_file():
            found[name] = file.read_bytes()
    return found


def _replace_inertias(spec: Any) -> None:
    for body in spec.bodies:
        if body.explicitinertial:
            body.fullinertia = np.full(6, np.nan)
            body.inertia = np.ones(3)
            body.iquat = np.array([1.0, 0.0, 0.0, 0.0])
            body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _remove_meshes(spec: Any, path: Path | None) -> dict[str, MeshFile]:
    """Replace mesh geoms by small spheres; returns each mesh by the name of its sphere."""
    folder = None if path is None else path.resolve().parent
    known = {mesh.name or Path(mesh.file).stem: MeshFile.of(mesh, spec, folder) for mesh in spec.meshes}
    found = {}
    for number, geom in enumerate(spec.geoms):
        geom.material = ""
        if geom.meshname:
            mesh = known.get(geom.meshname)
            geom.meshname, geom.type, geom.size = "", mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, 1e-3)
            geom.mass = 0.0 if np.isnan(geom.mass) else geom.mass
            geom.name = geom.name or f"mesh geom {number}"
            if mesh is not None:
                found[geom.name] = mesh
        elif geom.type in (mujoco.mjtGeom.mjGEOM_HFIELD, mujoco.mjtGeom.mjGEOM_SDF):
            spec.delete(geom)
    for site in spec.sites:
        site.material = ""
    for tendon in spec.tendons:
        tendon.material = ""
    for element in (*spec.meshes, *spec.hfields, *spec.skins, *spec.materials, *spec.textures):
        spec.delete(element)
    return found


@contextmanager
def _no_warnings() -> Iterator[None]:
    """Suppresses MuJoCo's warnings on the screen, in its log file and as warnings of Python."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda message: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mujoco.set_mju_user_warning(before)
