"""The position task of a problem: the task whose target position a generator moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.problems import reach
from jtik.problems.problem_setup import ProblemSetup
from jtik.task import FrameTask
from jtik.types import Array

ACCEPTED = "a FrameTask of kind 'position' or 'pose', alone or among others"


@dataclass(frozen=True)
class PositionTask:
    """The first `FrameTask` of a setup that has a position.

    Attributes:
        setup: robot and tasks.
        task: the task.
        axes: indices of the position coordinates that the task keeps, in (x, y, z).
    """

    setup: ProblemSetup
    task: FrameTask
    axes: tuple[int, ...]

    @classmethod
    def of(cls, setup: ProblemSetup, *, dimensions: int = 1) -> PositionTask:
        """Find the task. Raises ArgumentError if none has at least that many coordinates of a position."""
        names = "xyz"[: setup.robot.dimension]
        for task in setup.tasks.tasks:
            if isinstance(task, FrameTask) and task.kind != "orientation":
                axes = tuple(i for i, name in enumerate(names) if task.axes is None or name in task.axes)
                if len(axes) >= dimensions:
                    return cls(setup, task, axes)
        many = f", that keeps at least {dimensions} coordinates" if dimensions > 1 else ""
        raise ArgumentError("task", setup.tasks.tasks, ACCEPTED + many)

    @property
    def center(self) -> Array:
        """See `reach.center`."""
        return reach.center(self.setup.robot, self.task.frame)

    @property
    def bound(self) -> float:
        """See `reach.bound`."""
        return reach.bound(self.setup.robot, self.task.frame)

    @property
    def is_exact(self) -> bool:
        """Whether `bound` is the exact reach: a position task on a planar revolute chain without limits."""
        alone = len(self.setup.tasks.tasks) == 1 and self.task.kind == "position" and len(self.axes) == 2
        return alone and reach.is_free_chain(self.setup.robot, self.task.frame)

    def position(self, q: Array) -> Array:
        """Position of the frame at q, (dimension,) [m]."""
        return np.asarray(self.setup.robot.position(q, self.task.frame))

    def direction(self, generator: np.random.Generator) -> Array:
        """A random unit vector (dimension,) in the kept coordinates, uniform over directions."""
        return self.basis(generator, 1)[:, 0]

    def basis(self, generator: np.random.Generator, count: int) -> Array:
        """Random orthonormal vectors (dimension, count) in the kept coordinates, uniform over rotations."""
        drawn = generator.standard_normal((len(self.axes), count))
        vectors, triangle = np.linalg.qr(drawn)
        full = np.zeros((self.setup.robot.dimension, count))
        full[list(self.axes)] = vectors * np.sign(np.diag(triangle))
        return full

    def only(self, vector: Array) -> Array:
        """The vector (dimension,) with zeros in the coordinates that the task does not keep."""
        kept = np.zeros_like(vector)
        kept[list(self.axes)] = vector[list(self.axes)]
        return kept

    def moved(self, target: Any, offset: Array) -> Any:
        """A target of `ProblemSetup.target_at`, with the position of this task moved by ``offset`` (dimension,) [m]."""
        if isinstance(target, dict):
            return target | {self.task.name: self._moved(target[self.task.name], offset)}
        return self._moved(target, offset)

    def _moved(self, target: Array, offset: Array) -> Array:
        moved = np.array(target)
        if moved.ndim == 2:
            moved[: len(offset), 3] += offset
        else:
            moved[: len(offset)] += offset
        return moved
