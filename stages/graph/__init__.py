"""The graph stage: turns a CAD assembly, or a robot's own file, into a robot.

- added_section: Configuration of the graph stage: links and frames that CAD does not have.
- build: Runs the graph stage: reads the source, renames bodies, chooses the root, places the links, and then
  applies the passes in order.
- cad_only_keys: Reports keys that apply only to CAD assemblies, where the source is a robot's own file.
- dofs: Lists the dofs of each type of joint, computes their values in a pose, and reverses chains of dofs.
- globs: Matches the globs that users give with names, and checks that new names are free.
- mass_section: Configuration of the graph stage: masses.
- mechanism: Describes a mechanism at its saved pose: rigid bodies and the connections between them, without a
  root.
- naming: Keeps the names of a robot's own file if the target formats allow them, and replaces the others.
- relation_steps: Groups relations between dofs into trees of steps, in each of which one dof drives all
  others.
- robot_from_tree: Builds a robot from a mechanism and its tree: frames, joints, loops and links.
- root: Chooses the root body and its frame, and whether it is fixed to the world.
- section: Configuration of the graph stage: how an assembly becomes links and joints.
- tree: Chooses the kinematic tree: the connections in it, those that close loops, and the order of the
  bodies.
"""

import gc
from typing import TYPE_CHECKING, Any

from linkwright.stages.robot.errors import ProtocolError

if TYPE_CHECKING:
    from linkwright.stages.graph.mechanism import MechanismReader
    from linkwright.stages.graph.section import GraphSections
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.robot import Robot

VERSION = 32


def build_robot(bundle: "Bundle", keys: "GraphSections") -> "Robot":
    """Returns the robot in a bundle, with its diagnostics; raises AssemblyError with all problems at once."""
    # Imported late: the configuration imports this package and builds nothing.
    from linkwright.stages.graph.build import assemble

    # The stage makes values by the hundred thousand and next to no cycles: looking for cycles each time that
    # the values grow by a quarter would cost a fifth of its time, and more for larger robots.
    collects = gc.isenabled()
    gc.disable()
    try:
        return assemble(bundle, keys, reader_of(bundle.kind))
    finally:
        if collects:
            gc.enable()


def reader_of(kind: str) -> "MechanismReader":
    """Returns the reader of a kind of bundle; raises ProtocolError for an unknown kind."""
    reader: Any
    # Each reader is imported only for its own kind of bundle: an import takes 35 to 80 ms.
    match kind:
        case "onshape":
            from linkwright.stages.graph.onshape.reader import read_mechanism as reader  # late, as said
        case "urdf":
            from linkwright.stages.graph.urdf.reader import read_mechanism as reader  # late, as said
        case "mjcf":
            from linkwright.stages.graph.mjcf.reader import read_mechanism as reader  # late, as said
        case _:
            msg = f"unknown kind of bundle {kind!r}: expected one of onshape, urdf, mjcf"
            raise ProtocolError(msg, hint="make the bundle again")
    typed_reader: MechanismReader = reader
    return typed_reader
