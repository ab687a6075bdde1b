"""The frames and cameras of a USD against the robot's."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.usd.names import UsdNames, identifiers
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.sensing import Sensing
from linkwright.stages.validate.findings import differs, named, place_differs
from linkwright.stages.validate.usd.place_reader import ReadUsdPlace
from linkwright.stages.validate.usd.reader import UsdRobot

PLACE = 1e-9
"""Frames are in double precision [m, rad]."""

ANGLE = 1e-5
"""Fields of view and aspects, relatively: those are in single precision."""


def places(usd: UsdRobot, robot: Robot, names: UsdNames, sensing: Sensing) -> Iterator[Finding]:
    """Each frame, site of a sensor and camera is on its body, where it must be."""
    for link, body in names.links.items():
        there = usd.bodies[body].places
        poses = {one.name: one.link_from_frame for one in robot.frames if one.link == link}
        poses |= {one.name: one.link_from_site for one in sensing.sites if one.link == link}
        own = identifiers(poses)
        for name, pose in poses.items():
            yield from _at(there, body, own[name], ReadUsdPlace(pose))
        cameras = {one.name: one for one in sensing.cameras if one.link == link}
        for name, prim in identifiers(cameras, own.values()).items():
            camera = cameras[name]
            width, height = camera.resolution
            place = ReadUsdPlace(camera.link_from_camera, camera.fovy, width / height)
            yield from _at(there, body, prim, place)


def _at(there: Mapping[str, ReadUsdPlace], body: str, name: str, wanted: ReadUsdPlace) -> Iterator[Finding]:
    element, found = named("def", body), there.get(name)
    if found is None:
        yield Finding(element, name, "there is no frame or camera of this name")
        return
    attributes = (f"{name} xformOp:translate", f"{name} xformOp:orient")
    yield from place_differs(element, found.body_from_place, wanted.body_from_place, attributes, PLACE)
    for attribute, value, expected in (
        ("verticalAperture", found.fovy, wanted.fovy),
        ("horizontalAperture", found.aspect, wanted.aspect),
    ):
        if not abs(value - expected) <= ANGLE * expected:
            yield differs(element, f"{name} {attribute}", value, expected)
