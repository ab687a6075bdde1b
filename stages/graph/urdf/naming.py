"""Names the links, joints and frames of a URDF: they keep their names."""

from collections.abc import Iterable, Sequence

from linkwright.stages.formats.urdf.model import Urdf, UrdfJoint
from linkwright.stages.graph.mechanism import WORLD_LINK
from linkwright.stages.graph.naming import FileNames, Namer
from linkwright.stages.graph.urdf.dummy_links import UrdfFrame, has_world
from linkwright.stages.graph.urdf.structure import SCALAR_TYPES
from linkwright.stages.robot.diagnostics import Diagnostics

UrdfFileNames = FileNames[str, str]

_PLANAR_SUFFIXES = ("_x", "_y", "_turn")
"""The suffixes of a planar joint's dofs."""


def names_of(urdf: Urdf, frames: Sequence[UrdfFrame], log: Diagnostics) -> UrdfFileNames:
    """Returns the file's own names wherever they can stay, `joints` with those that hold `frames`; reports
    W-NAME for each that changes."""
    namer = Namer()
    world = {WORLD_LINK: WORLD_LINK} if has_world(urdf) else {}
    links = namer.keep("link", _pairs(link.name for link in urdf.links if link.name not in world))
    frame_names = namer.keep("frame", _pairs(frame.name for frame in frames))
    sorted_joints = sorted(urdf.joints, key=lambda joint: joint.name)
    joints = namer.keep(
        "joint",
        _pairs(
            [
                *(frame_or_joint.name for frame_or_joint in sorted_joints),
                *(frame_or_joint.joint for frame_or_joint in frames),
            ]
        ),
    )
    dofs = {joint.name: _dofs(joint, joints[joint.name], namer) for joint in sorted_joints}
    followers = [
        joint.name for joint in sorted_joints if joint.mimic is not None and joint.type in SCALAR_TYPES
    ]
    relations = {name: namer.make("equality", f"{joints[name]}_mimic") for name in followers}
    namer.report(log)
    return FileNames(world | links, frame_names, joints, dofs, relations, {})


def _pairs(names: Iterable[str]) -> list[tuple[str, str]]:
    return [(name, name) for name in sorted(names)]


def _dofs(joint: UrdfJoint, name: str, namer: Namer) -> tuple[str, ...]:
    if joint.type == "planar":
        return tuple(namer.make("joint", name + end) for end in _PLANAR_SUFFIXES)
    return () if joint.type == "fixed" else (name,)
