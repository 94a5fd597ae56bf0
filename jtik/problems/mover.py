"""The task whose position a problem moves: along a ray, a line or a circle, while everything else stays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.problems import reach
from jtik.problems.subject import Subject
from jtik.task import FrameTask
from jtik.types import Array

ACCEPTED = "a FrameTask of kind 'position' or 'pose', alone or among others"


@dataclass(frozen=True)
class Mover:
    """The first `FrameTask` of a subject that reads a position.

    Attributes:
        subject: robot and tasks.
        task: that task.
        axes: which coordinates of the position it keeps, places in (x, y, z).
    """

    subject: Subject
    task: FrameTask
    axes: tuple[int, ...]

    @classmethod
    def of(cls, subject: Subject, *, least: int = 1) -> Mover:
        """The mover; raises ArgumentError when no task reads at least that many coordinates of a position."""
        names = "xyz"[: subject.robot.dimension]
        for task in subject.tasks.tasks:
            if isinstance(task, FrameTask) and task.kind != "orientation":
                axes = tuple(i for i, name in enumerate(names) if task.axes is None or name in task.axes)
                if len(axes) >= least:
                    return cls(subject, task, axes)
        many = f", that keeps at least {least} coordinates" if least > 1 else ""
        raise ArgumentError("task", subject.tasks.tasks, ACCEPTED + many)

    @property
    def center(self) -> Array:
        """See `reach.center`."""
        return reach.center(self.subject.robot, self.task.frame)

    @property
    def bound(self) -> float:
        """See `reach.bound`."""
        return reach.bound(self.subject.robot, self.task.frame)

    @property
    def is_exact(self) -> bool:
        """Whether `bound` is the edge in every direction: one position of a planar chain of hinges without limits."""
        alone = len(self.subject.tasks.tasks) == 1 and self.task.kind == "position" and len(self.axes) == 2
        return alone and reach.is_free_chain(self.subject.robot, self.task.frame)

    def position(self, q: Array) -> Array:
        """Where the frame is at q [m], (dimension,)."""
        return np.asarray(self.subject.robot.position(q, self.task.frame))

    def direction(self, generator: np.random.Generator) -> Array:
        """A unit vector (dimension,) in the coordinates kept, uniform over directions."""
        return self.basis(generator, 1)[:, 0]

    def basis(self, generator: np.random.Generator, count: int) -> Array:
        """Orthonormal vectors (dimension, count) in the coordinates kept, uniform over rotations."""
        drawn = generator.standard_normal((len(self.axes), count))
        vectors, triangle = np.linalg.qr(drawn)
        full = np.zeros((self.subject.robot.dimension, count))
        full[list(self.axes)] = vectors * np.sign(np.diag(triangle))
        return full

    def only(self, vector: Array) -> Array:
        """The vector (dimension,) with zeros for coordinates that the task does not keep."""
        kept = np.zeros_like(vector)
        kept[list(self.axes)] = vector[list(self.axes)]
        return kept

    def moved(self, target: Any, offset: Array) -> Any:
        """A target of `Subject.target_at` with this task's position moved by ``offset`` (dimension,) [m]."""
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
