"""Reads the keyframes of an MJCF, and renames the joints that they refer to."""

from linkwright.stages.formats.mjcf.model import Mjcf
from linkwright.stages.graph.mjcf.naming import MjcfFileNames
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Keyframe
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.names import free_name


def keyframes_of(mjcf: Mjcf, names: MjcfFileNames, root: int, log: Diagnostics) -> tuple[Keyframe, ...]:
    """Returns the keyframes; unnamed keyframes get names. Reports I-KEYFRAME for balls and free bodies that
    they move, except the body `root`, whose pose is part of the scene."""
    dofs = [(number, name) for number in range(len(mjcf.bodies)) for name in names.dofs[number]]
    taken_names = {frame.name for frame in mjcf.keyframes}
    keyframes = []
    for index, keyframe in enumerate(mjcf.keyframes):
        name = keyframe.name or free_name(f"keyframe_{index}", taken_names)
        taken_names.add(name)
        lost_names = [dofs[joint][1] for joint in keyframe.moved if dofs[joint][0] != root]
        if lost_names:
            text = "the source's keyframe moves balls or free bodies, which is left out: "
            text += name_list(lost_names)
            log.report("I-KEYFRAME", text, name, "a keyframe has values of turns and slides")
        keyframes.append(Keyframe(name, tuple((dofs[joint][1], value) for joint, value in keyframe.values)))
    return tuple(keyframes)
