"""A secondary term: the projected gradient with shorter steps."""

from dataclasses import dataclass

from jtik_formulations import ProjectedGradient


@dataclass(frozen=True, kw_only=True)
class ExampleGradient(ProjectedGradient):
    """A projected-gradient step of at most ``step_limit`` [rad]."""

    step_limit: float = 0.1

    summary = "projected gradient with shorter steps"
    source = "an example"
