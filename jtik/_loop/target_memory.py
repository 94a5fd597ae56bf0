"""Targets into the memory that the steps read: the usual arrays as fast as they can be copied, all others through the
tasks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jtik.symbolic.compile import bind
from jtik.task import TaskStack
from jtik.types import Array

_FLOAT = np.dtype(np.float64)


class TargetMemory:
    """The memory of the numbers of a target.

    Args:
        tasks: what the targets are for.
        memory: the numbers (size,), which the steps read.

    Attributes:
        vector_shape: shape of an array that is used as it is; None where none is.
        matrix_shape: shape of an array that a function reads; None where none does.
    """

    def __init__(self, tasks: TaskStack, memory: Array) -> None:
        self._tasks, self._memory = tasks, memory
        self.vector_shape: tuple[int, ...] | None = memory.shape if tasks.target_is_vector else None
        self.matrix_shape: tuple[int, ...] | None = None
        reader = tasks.matrix_reader
        if reader is not None:
            self._matrix, self._numbers, valid = np.zeros((4, 4)), np.zeros_like(memory), np.zeros(1)
            self._read_matrix = bind(reader, [self._matrix.ravel()], [self._numbers, valid])
            self._is_valid: Any = memoryview(valid.data)
            self.matrix_shape = (4, 4)

    def copy(self, target: Any) -> None:
        """Write a target. An array that is used as it is may have NaN or infinity: what reads it has to tell.

        Raises:
            ArgumentError: for anything that is no target.
        """
        if type(target) is np.ndarray and target.dtype == _FLOAT and target.shape == self.vector_shape:
            self._memory[:] = target
        else:
            self.read(target)

    def read(self, target: Any) -> None:
        """Write a target that is checked.

        Raises:
            ArgumentError: for anything that is no target.
        """
        if type(target) is np.ndarray and target.dtype == _FLOAT and target.shape == self.matrix_shape:
            self._matrix[:] = target
            self._read_matrix()
            if self._is_valid[0]:
                self._memory[:] = self._numbers
                return
        self._memory[:] = self._tasks.read_target(target)
