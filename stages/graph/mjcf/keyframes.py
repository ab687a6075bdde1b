"""Keyframes of an MJCF, by the names that its joints have now."""

from linkwright.stages.formats.mjcf.model import Mjcf
from linkwright.stages.graph.mjcf.naming import MjcfFileNames
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Keyframe
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.robot.text.names import free


def keyframes_of(mjcf: Mjcf, names: MjcfFileNames, root: int, log: Diagnostics) -> tuple[Keyframe, ...]:
    """The keyframes; one without a name gets one. I-KEYFRAME for balls and free bodies that they move: where
    the body `root` floats is for the scene to say.
    """
    dofs = [(number, name) for number in range(len(mjcf.bodies)) for name in names.dofs[number]]
    taken = {one.name for one in mjcf.keyframes}
    found = []
    for index, one in enumerate(mjcf.keyframes):
        name = one.name or free(f"keyframe_{index}", taken)
        taken.add(name)
        lost = [dofs[joint][1] for joint in one.moved if dofs[joint][0] != root]
        if lost:
            text = f"the source's keyframe moves balls or free bodies, which is left out: {listed(lost)}"
            log.report("I-KEYFRAME", text, name, "a keyframe has values of turns and slides")
        found.append(Keyframe(name, tuple((dofs[joint][1], value) for joint, value in one.values)))
    return tuple(found)
