"""Scenes: named obstacles with a gain each, and the file they are kept in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik import arguments
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry.scene_data import from_json, from_toml, obstacle_from, obstacle_to, read_table, to_json, to_toml
from jtik.geometry.slots import ACCEPTED, read_gains
from jtik.geometry.solids import Solid
from jtik.types import Array

FILES = "the path of a .toml or .json file"


class Scene(metaclass=Constructed):
    """Named obstacles with a gain each. It never changes: `with_` and `without` return another scene.

    It is given as ``obstacles`` to a criterion, which multiplies the terms of each obstacle by its gain; an obstacle
    with gain 0 is absent. `to_dict` describes its file, TOML or JSON, which `save` writes and `load` reads::

        [obstacles.table]
        shape = "box"
        center = [0.5, 0.0, 0.2]
        half = [0.3, 0.4, 0.02]
        rotation = [1.0, 0.0, 0.0, 0.0]
        gain = 1.0

    Shapes and their keys: ``point`` (center), ``circle`` and ``sphere`` (center, radius), ``capsule`` and ``cylinder``
    (start, end, radius), ``box`` (center, half; rotation, a quaternion (w, x, y, z) or an angle [rad], none by
    default), ``half_space`` (point, normal), ``polygon`` (vertices); ``gain`` is 1 by default. Lengths are in [m].

    Args:
        obstacles: a dict from name to obstacle, or obstacles, which are named by their shape and number.
        gains: a dict from name to gain, or a gain for each obstacle, non-negative; 1 by default.

    Raises:
        ArgumentError: when one is no obstacle, they are not all in the plane or all in space, or a gain is negative.
        UnknownNameError: when a gain names no obstacle.

    Example:
        >>> table = jtik.Box.at([0.6, 0.0, -0.05], [0.4, 0.8, 0.05])
        >>> scene = jtik.Scene({"table": table, "post": jtik.Sphere((0.4, 0.3, 0.5), 0.1)})
        >>> scene.save("scene.toml")
        >>> jtik.Scene.load("scene.toml") == scene
        True
    """

    def __init__(
        self,
        obstacles: Mapping[str, Solid] | Iterable[Solid] | Solid = (),
        gains: Mapping[str, float] | ArrayLike | None = None,
    ) -> None:
        accepted = f"{ACCEPTED[2]}; or in space {ACCEPTED[3]}"
        if isinstance(obstacles, Scene):
            gains = obstacles.gains if gains is None else gains
            obstacles = obstacles.obstacles
        if isinstance(obstacles, Mapping):
            named = {arguments.name("obstacles", name): each for name, each in obstacles.items()}
        else:
            given = arguments.instances("obstacles", obstacles, Solid, accepted)
            named = {f"{type(each).__name__.lower()}{i}": each for i, each in enumerate(given)}
        for name, each in named.items():
            if not isinstance(each, Solid):
                raise ArgumentError(f"obstacles[{name!r}]", each, accepted)
        if len({each.dimension for each in named.values()}) > 1:
            raise ArgumentError("obstacles", "obstacles in the plane and in space", "obstacles of one dimension")
        self._obstacles = MappingProxyType(named)
        self._gains = MappingProxyType(dict(zip(named, self._read(gains).tolist(), strict=True)))

    def _read(self, gains: Mapping[str, float] | ArrayLike | None) -> Array:
        if not isinstance(gains, Mapping):
            return np.ones(len(self)) if gains is None else read_gains(gains, len(self))
        for name in gains:
            self._check(name)
        return read_gains([gains.get(name, 1.0) for name in self.names], len(self))

    @property
    def obstacles(self) -> Mapping[str, Solid]:
        """The obstacles by name."""
        return self._obstacles

    @property
    def gains(self) -> Mapping[str, float]:
        """The gains by name."""
        return self._gains

    @property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(self._obstacles)

    def __iter__(self) -> Iterator[Solid]:
        return iter(self._obstacles.values())

    def __len__(self) -> int:
        return len(self._obstacles)

    def __getitem__(self, name: str) -> Solid:
        self._check(name)
        return self._obstacles[name]

    def __contains__(self, name: object) -> bool:
        return name in self._obstacles

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]  # as of a dict

    def __repr__(self) -> str:
        return f"Scene({', '.join(f'{name}: {type(each).__name__}' for name, each in self._obstacles.items())})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene, (dict(self._obstacles), dict(self._gains))

    def with_(self, name: str, obstacle: Solid, gain: float = 1.0) -> Scene:
        """The scene with one more obstacle, or with another one of that name, in its place.

        Args:
            name: its name.
            obstacle: the obstacle.
            gain: its gain, non-negative.

        Raises:
            ArgumentError: for anything else.
        """
        gain = arguments.non_negative_number("gain", gain)
        arguments.instance("obstacle", obstacle, Solid, ACCEPTED[2])
        return Scene({**self._obstacles, arguments.name("name", name): obstacle}, {**self._gains, name: gain})

    def without(self, name: str) -> Scene:
        """The scene without one obstacle.

        Args:
            name: name of the obstacle.

        Raises:
            UnknownNameError: when no obstacle has that name.
        """
        self._check(name)
        kept = {each: solid for each, solid in self._obstacles.items() if each != name}
        return Scene(kept, {each: self._gains[each] for each in kept})

    def to_dict(self) -> dict[str, Any]:
        """The scene as dicts, lists, texts and numbers."""
        rows = {name: {**obstacle_to(each), "gain": self._gains[name]} for name, each in self._obstacles.items()}
        return {"obstacles": rows}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Scene:
        """The scene that `to_dict` described.

        Args:
            data: the scene as plain dicts, lists, numbers and texts.

        Raises:
            ArgumentError: for other data; it names the key.
        """
        return cls._from("", data)

    @classmethod
    def _from(cls, where: str, data: object) -> Scene:
        """The scene; ``where`` is in front of the keys that errors name."""
        rows = read_table(f"{where}obstacles", read_table(f"{where}scene", data, ("obstacles",))["obstacles"])
        found = {name: obstacle_from(f"{where}obstacles.{name}", row) for name, row in rows.items()}
        obstacles = {name: obstacle for name, (obstacle, _) in found.items()}
        if len({each.dimension for each in obstacles.values()}) > 1:
            given = "obstacles in the plane and in space"
            raise ArgumentError(f"{where}obstacles", given, "obstacles of one dimension")
        return cls(obstacles, {name: gain for name, (_, gain) in found.items()})

    def save(self, path: str | PathLike[str]) -> None:
        """Write the scene to a .toml or .json file.

        Args:
            path: the file; its suffix says which format.

        Raises:
            ArgumentError: for another name of a file, or a name of an obstacle that cannot be written.
            OSError: when the file cannot be written.
        """
        file = arguments.path("path", path, FILES)
        if file.suffix not in (".toml", ".json"):
            raise ArgumentError("path", str(file), FILES)
        data = self.to_dict()
        text = to_toml(data) if file.suffix == ".toml" else to_json(data)
        try:
            content = text.encode("utf-8")
        except UnicodeEncodeError as error:  # before the file is opened, which would empty it
            given = f"names with {error.object[error.start]!a}, which no file can hold"
            raise ArgumentError("obstacles", given, "names of Unicode characters") from error
        file.write_bytes(content)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Scene:
        """Read a scene from a .toml or .json file.

        Args:
            path: the file; its suffix says which format.

        Raises:
            ArgumentError: when there is no such file, it is no TOML or JSON, or a key is missing, unknown or wrong; it
                names the file and the key.
        """
        file = arguments.existing_file("path", path)
        if file.suffix not in (".toml", ".json"):
            raise ArgumentError("path", str(file), FILES)
        try:
            text = file.read_text(encoding="utf-8-sig")
            data = from_toml(text) if file.suffix == ".toml" else from_json(text)
        except (ValueError, RecursionError) as error:  # what both readers raise, and a text in another encoding
            raise ArgumentError(str(file), f"{error}", f"a {file.suffix[1:].upper()} file of a scene") from error
        return cls._from(f"{file}: ", data)

    def _check(self, name: str) -> None:
        if name not in self._obstacles:
            raise UnknownNameError("obstacle", name, self._obstacles)
