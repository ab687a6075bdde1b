"""The graph stage: an assembly as drawn becomes a robot."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stages.graph.keys import GraphKeys
    from stages.robot.bundle import Bundle
    from stages.robot.model import Robot

VERSION = 10


def build_robot(bundle: "Bundle", keys: "GraphKeys") -> "Robot":
    """The robot in a bundle. AssemblyError tells all problems at once; findings are on the robot."""
    import gc

    from stages.graph.build import assemble

    # The stage makes values by the hundred thousand and next to no cycles: to look for those each time
    # that there are a quarter more would cost a fifth of its time, and a larger share of a larger robot's.
    collects = gc.isenabled()
    gc.disable()
    try:
        return assemble(bundle, keys)
    finally:
        if collects:
            gc.enable()
