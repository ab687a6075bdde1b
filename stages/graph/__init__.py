"""The graph stage: turns a CAD assembly, or a robot's own file, into a robot.

- added_section: Configuration of the graph stage: links and frames that CAD does not have.
- build: The main flow of the graph stage: read, rename, root, place, and then one pass after the other.
- cad_only_keys: Keys that apply only to CAD assemblies, where the source is a robot's own file.
- dofs: The dofs of each type of joint, their values in a pose, and the inverse of a chain of dofs.
- globs: Globs and names that users give: a glob must match something, a new name must be free.
- mass_section: Configuration of the graph stage: masses.
- mechanism: A mechanism at its saved pose: rigid bodies and the connections between them, without a root.
- naming: Names from a robot's own file: kept where the target formats allow them, else mapped.
- relation_steps: Relations between dofs as trees of steps, in each of which one dof drives all others.
- robot_from_tree: Builds a robot from a mechanism and its tree: frames, joints, loops and links.
- root: Chooses the root body and its frame, and whether it is fixed to the world.
- section: Configuration of the graph stage: how an assembly becomes links and joints.
- tree: The kinematic tree: which connections are in the tree, which close loops, and the order of the bodies.
"""

import gc
from typing import TYPE_CHECKING, Any

from linkwright.stages.robot.errors import ProtocolError

if TYPE_CHECKING:
    from linkwright.stages.graph.mechanism import MechanismReader
    from linkwright.stages.graph.section import GraphSections
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.robot import Robot

VERSION = 26


def build_robot(bundle: "Bundle", keys: "GraphSections") -> "Robot":
    """The robot in a bundle, with its diagnostics. AssemblyError names all problems at once."""
    # Late: a build has one source, and the configuration reads this package and builds nothing.
    from linkwright.stages.graph.build import assemble

    # The stage makes values by the hundred thousand and next to no cycles: to look for those each time
    # that there are a quarter more would cost a fifth of its time, and a larger share of a larger robot's.
    collects = gc.isenabled()
    gc.disable()
    try:
        return assemble(bundle, keys, reader_of(bundle.kind))
    finally:
        if collects:
            gc.enable()


def reader_of(kind: str) -> "MechanismReader":
    """The reader of a kind of bundle; ProtocolError for a kind that has none."""
    reader: Any
    # Each reader is imported where a robot has its kind of bundle: they take 35 to 80 ms.
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
    found: MechanismReader = reader
    return found
