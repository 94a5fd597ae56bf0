"""Where the attempts of a search begin after the first one, as the searches in Python and in C read it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jtik._loop.search.jump import Jump
from jtik._loop.search.restarts import RestartConfigurations
from jtik._loop.search.start_bank import SIZE, StartBank, StartBanks
from jtik.robot import Robot
from jtik.types import Array


class Starts:
    """Some restarts of a search.

    Args:
        configurations: one a row, contiguous.
        first: number of the restart in row 0.
        last: number of the last restart.
        bank: what the first rows are: restarts in the order of their distance; None for the order of the rows.

    Attributes:
        configurations: as given.
        first: as given.
        last: as given.
        bank: as given.
        address: of what the searches in C read, JTIK_NAME_starts in `jtik._loop.native.start_bank_source`.
    """

    def __init__(self, configurations: Array, first: int, last: int, bank: StartBank | None = None) -> None:
        self.configurations, self.first, self.last, self.bank = configurations, first, last, bank
        of_bank = [bank.coefficients.ctypes.data, bank.centre.ctypes.data, SIZE] if bank else [0, 0, 0]
        self._table = np.array([configurations.ctypes.data, *of_bank], dtype=np.uintp)
        self.address = int(self._table.ctypes.data)
        self._order: NDArray[np.intp] | None = None

    def of(self, number: int, target: Array) -> Array:
        """The configuration of a restart; ``target`` (target size,) is the same in all calls."""
        row: int | np.intp = number - self.first
        if self.bank is not None and number <= len(self.bank.configurations):
            if self._order is None:
                self._order = self.bank.order(target)
            row = self._order[row]
        found: Array = self.configurations[row]
        return found


class SearchStarts:
    """The restarts of searches: the nearest of a bank first, then all others as they are drawn.

    Args:
        robot: the robot.
        banks: the restarts by their distance from the target; None where they depend on where a search begins.
    """

    def __init__(self, robot: Robot, banks: StartBanks | None) -> None:
        self._drawn, self._banks = RestartConfigurations(robot), banks
        self._none = np.zeros((1, robot.nq))

    @property
    def depend_on_start(self) -> bool:
        """Whether they depend on where a search began."""
        return self._drawn.depend_on_start

    def around(self, number: int, seed: int, q0: Array, jump: Jump | None = None) -> Starts:
        """The restarts around attempt ``number``; around the first attempt none where a bank is not drawn yet.

        Args:
            number: the attempt, 0 for the first.
            seed: the seed.
            q0: where the search began, (nq,).
            jump: the jump limit within which to draw; None for the limits of the robot.
        """
        if self._banks is not None and jump is None and number <= SIZE:
            bank = self._banks.of(seed) if number else self._banks.known(seed)
            return Starts(self._none, 1, 0) if bank is None else Starts(*bank.starts, bank)
        return Starts(*self._drawn.block(seed, max(number, 1), q0, jump))

    def of_batch(self, seed: int, q0: Array, count: int) -> Starts:
        """The first restarts of all targets of a batch: ``count`` or more, and at least those around the first."""
        starts = self.around(1, seed, q0)
        blocks, last = [starts.configurations], starts.last
        while last < count:
            more, _, last = self._drawn.block(seed, last + 1, q0)
            blocks.append(more)
        return starts if len(blocks) == 1 else Starts(np.concatenate(blocks), 1, last, starts.bank)
