"""Compares the frames and cameras of a USD with the robot's."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.usd.names import UsdNames, identifiers
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.model.sensing import Sensing
from linkwright.stages.validate.findings import differs, named, pose_findings
from linkwright.stages.validate.usd.place_reader import ReadUsdPlace
from linkwright.stages.validate.usd.reader import UsdRobot

FRAME_TOLERANCE = 1e-9
"""Tolerance [m, rad] of frames, which are in double precision."""

LENS_TOLERANCE = 1e-5
"""Relative tolerance of fields of view and aspects, whose apertures are in single precision."""


def place_findings(usd: UsdRobot, robot: Robot, names: UsdNames, sensing: Sensing) -> Iterator[Finding]:
    """Checks that each frame, site of a sensor and camera is at its place on its body."""
    for link, body in names.links.items():
        read_places = usd.bodies[body].places
        poses = {frame.name: frame.link_from_frame for frame in robot.frames if frame.link == link}
        poses |= {site.name: site.link_from_site for site in sensing.sites if site.link == link}
        titles = identifiers(poses)
        for name, pose in poses.items():
            yield from _place_differences(read_places, body, titles[name], ReadUsdPlace(pose))
        cameras = {camera.name: camera for camera in sensing.cameras if camera.link == link}
        for name, prim in identifiers(cameras, titles.values()).items():
            camera = cameras[name]
            width, height = camera.resolution
            place = ReadUsdPlace(camera.link_from_camera, camera.fovy, width / height)
            yield from _place_differences(read_places, body, prim, place)


def _place_differences(
    read_places: Mapping[str, ReadUsdPlace], body: str, name: str, expected: ReadUsdPlace
) -> Iterator[Finding]:
    """Yields the differences of a frame or camera of a body. `name`: the name of its prim."""
    element, place = named("def", body), read_places.get(name)
    if place is None:
        yield Finding(element, name, "there is no frame or camera of this name")
        return
    attributes = (f"{name} xformOp:translate", f"{name} xformOp:orient")
    yield from pose_findings(
        element, place.body_from_place, expected.body_from_place, attributes, FRAME_TOLERANCE
    )
    for attribute, actual_value, expected_value in (
        ("verticalAperture", place.fovy, expected.fovy),
        ("horizontalAperture", place.aspect, expected.aspect),
    ):
        if not abs(actual_value - expected_value) <= LENS_TOLERANCE * expected_value:
            yield differs(element, f"{name} {attribute}", actual_value, expected_value)
