"""A criterion: the end effector at a height."""

from collections.abc import Mapping

from jtik import Criterion
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression


class ExampleHeight(Criterion):
    """H = 1/2 (z - height)^2 [m^2], z the last coordinate of the end effector.

    Args:
        height: the wanted height [m]; a live parameter.
    """

    summary = "keeps the end effector at a height"
    source = "an example"

    def __init__(self, height: float = 0.5) -> None:
        self.height = height

    def parameters(self, robot: Robot) -> Mapping[str, float]:
        return {"height": self.height}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        z = kinematics.position(kinematics.robot.tip)[-1]
        return (z - parameters["height"]) ** 2 / 2
