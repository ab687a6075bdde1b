"""The graph stage: turns a CAD assembly, or a robot's own file, into a robot."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.graph.mechanism import MechanismReader
    from linkwright.stages.graph.section import GraphSections
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.model.robot import Robot

VERSION = 25

READERS: Mapping[str, str] = {
    "onshape": "linkwright.stages.graph.onshape.reader",
    "urdf": "linkwright.stages.graph.urdf.reader",
    "mjcf": "linkwright.stages.graph.mjcf.reader",
}
"""Kind of bundle → the module whose `read_mechanism` is its reader."""


def build_robot(bundle: "Bundle", keys: "GraphSections") -> "Robot":
    """The robot in a bundle, with its diagnostics. AssemblyError names all problems at once."""
    import gc

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
    from importlib import import_module

    from linkwright.stages.robot.errors import ProtocolError

    if kind not in READERS:
        msg = f"unknown kind of bundle {kind!r}: expected one of {', '.join(READERS)}"
        raise ProtocolError(msg, hint="make the bundle again")
    reader: MechanismReader = import_module(READERS[kind]).read_mechanism
    return reader
