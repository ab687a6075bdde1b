"""The graph stage: an assembly as drawn becomes a robot."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stages.graph.keys import GraphKeys
    from stages.robot.bundle import Bundle
    from stages.robot.model import Robot

VERSION = 3


def build_robot(bundle: "Bundle", keys: "GraphKeys") -> "Robot":
    """The robot in a bundle. AssemblyError tells all problems at once; findings are on the robot."""
    from stages.graph.assemble import assemble

    return assemble(bundle, keys)
