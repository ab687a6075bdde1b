"""Reads the extras of an MJCF, and renames the bodies, joints and sites that they refer to."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.formats.mjcf.model import Mjcf, MjcfNamedPose
from linkwright.stages.graph.mjcf.actuation import actuator_names, sensor_names
from linkwright.stages.graph.mjcf.equalities import ClosureJoint
from linkwright.stages.graph.mjcf.naming import MjcfFileNames
from linkwright.stages.robot.model.mjcf_extras import (
    MjcfAttributes,
    MjcfBodyFrame,
    MjcfElement,
    MjcfExtras,
    MjcfKeyframe,
    MjcfMounted,
)
from linkwright.stages.robot.model.robot import Array, Keyframe


def extras_of(
    mjcf: Mjcf,
    names: MjcfFileNames,
    closure_joints: Sequence[ClosureJoint],
    keyframes: Sequence[Keyframe],
    link_from_body: Mapping[int, Array],
) -> MjcfExtras:
    """Returns the extras. `link_from_body`: number of each body that became a link → link_from_body (4,
    4)."""
    new_names = _new_names(mjcf, names)

    def renamed_element(element: MjcfElement) -> MjcfElement:
        return element.renamed(lambda kind, name: new_names.get((kind, name), name))

    link_bodies = [(number, mjcf.bodies[number]) for number in link_from_body if number]
    return replace(
        mjcf.extras,
        bodies=tuple(
            MjcfBodyFrame(
                names.links[number],
                link_from_body[number],
                body.axes if body.inertial is not None else None,
            )
            for number, body in link_bodies
        ),
        attributes=tuple(_attributes(mjcf, names, closure_joints)),
        mounted=tuple(
            MjcfMounted(names.links[number], element.body_from_element, renamed_element(element.element))
            for number, body in link_bodies
            for element in body.mounted
        ),
        sections=tuple(renamed_element(section) for section in mjcf.extras.sections),
        scene=tuple(renamed_element(section) for section in mjcf.extras.scene),
        order=tuple(_order(mjcf, names)),
        keyframes=tuple(
            _keyframe(pose, keyframe.name) for pose, keyframe in zip(mjcf.keyframes, keyframes, strict=True)
        ),
    )


def _new_names(mjcf: Mjcf, names: MjcfFileNames) -> dict[tuple[str, str], str]:
    new_names = {}
    for number, body in enumerate(mjcf.bodies):
        new_names["body", body.name] = names.links[number]
        new_names |= {
            ("joint", joint.name): name for joint, name in zip(body.joints, names.dofs[number], strict=True)
        }
        for index, site in enumerate(body.sites):
            new_names["site", site.name] = names.frames.get((number, index), site.name)
    return new_names


def _attributes(
    mjcf: Mjcf, names: MjcfFileNames, closure_joints: Sequence[ClosureJoint]
) -> Iterator[MjcfAttributes]:
    for number, body in enumerate(mjcf.bodies):
        rows = [("body", names.links[number], body.attributes)] if number else []
        rows += [
            ("freejoint", names.links[number], joint.attributes)
            if joint.type == "free"
            else ("joint", name, joint.attributes)
            for joint, name in zip(body.joints, names.dofs[number], strict=True)
        ]
        rows += [
            ("site", names.frames[number, index], site.attributes)
            for index, site in enumerate(body.sites)
            if (number, index) in names.frames
        ]
        yield from (MjcfAttributes(*row) for row in rows if row[2])
    for index, joint in enumerate(closure_joints):
        yield MjcfAttributes("equality", names.loops[index][0], joint.closure.attributes)
    for index, relation in enumerate(mjcf.relations):
        yield MjcfAttributes("equality", names.relations[index], relation.attributes)
    for actuator, name in zip(mjcf.actuators, actuator_names(mjcf, names), strict=True):
        if actuator.attributes:
            yield MjcfAttributes("actuator", name, actuator.attributes)
    for sensor, name in zip(mjcf.sensors, sensor_names(mjcf, names), strict=True):
        if sensor.attributes:
            yield MjcfAttributes("sensor", name, sensor.attributes)


def _order(mjcf: Mjcf, names: MjcfFileNames) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yields each section with the names of its elements in the file's order; elements without a name in the
    file have their new names."""
    new_names = {"actuator": actuator_names(mjcf, names), "sensor": sensor_names(mjcf, names)}
    source_names = {
        "actuator": [actuator.name for actuator in mjcf.actuators],
        "sensor": [sensor.name for sensor in mjcf.sensors],
    }
    for section, order in mjcf.extras.order:
        pairs = zip(source_names[section], new_names[section], strict=True)
        unnamed = iter([name for old, name in pairs if not old])
        yield section, tuple(name or next(unnamed) for name in order)


def _keyframe(pose: MjcfNamedPose, name: str) -> MjcfKeyframe:
    """Returns a keyframe's pose of a floating root, and its poses of the scene's objects."""
    floating = [numbers for _, numbers in pose.floating]
    return MjcfKeyframe(name, floating[0] if len(floating) == 1 else (), pose.scene)
