"""Strategies: the local model a law sees, the law, and laws composed of a task step and a null-space term."""

from jtik.strategy.base import Shape, State, Strategy, Update
from jtik.strategy.composition import (
    Acceptance,
    Composition,
    NullMove,
    Outcome,
    SecondaryTerm,
    TaskMove,
    TaskStep,
)
from jtik.strategy.model import LocalModel, Point

__all__ = [
    "Acceptance",
    "Composition",
    "LocalModel",
    "NullMove",
    "Outcome",
    "Point",
    "SecondaryTerm",
    "Shape",
    "State",
    "Strategy",
    "TaskMove",
    "TaskStep",
    "Update",
]
