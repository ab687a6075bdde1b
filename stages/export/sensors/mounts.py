"""Finds the frames and links of a robot on which sensors can be mounted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Array, Robot, frozen
from linkwright.stages.robot.text.globs import no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.sensor_section import SensorSection

LOAD_SENSOR_TYPES = ("force", "torque", "force_torque")
"""Types of sensors that measure the force or torque between a link and its parent."""


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """A frame or link on which sensors can be mounted."""

    name: str

    link: str
    """The link that the frame is on, or the link itself."""

    link_from_mount: Array
    """The pose (4, 4) of the frame in its link; the identity for a link."""

    is_frame: bool
    """Whether it is a frame, which the MJCF has as a site of the same name."""


def mounts_of(robot: Robot) -> dict[str, Mount]:
    """Returns the mounts of a robot by name. If a frame and a link have the same name, the frame counts."""
    links = {
        link.name: Mount(link.name, link.name, frozen(np.eye(4)), is_frame=False) for link in robot.links
    }
    frames = {
        frame.name: Mount(frame.name, frame.link, frame.link_from_frame, is_frame=True)
        for frame in robot.frames
    }
    return links | frames


def report_unknown_mount(name: str, where: str, mounts: Mapping[str, Mount], log: Diagnostics) -> None:
    """Reports E-FRAME for a name in the key `where` that no frame and no link has."""
    hint = no_match_hint(name, {"frames and links": mounts})
    log.report("E-FRAME", f"there is no frame or link {name!r}", where, hint)


def links_with_load_sensors(robot: Robot, sensors: Mapping[str, "SensorSection"]) -> set[str]:
    """Returns the links with sensors of `LOAD_SENSOR_TYPES`. Each needs its own body in the MJCF, since
    MuJoCo measures the load between a body and its parent."""
    mounts = mounts_of(robot)
    load_sensors = {name: section for name, section in sensors.items() if section.type in LOAD_SENSOR_TYPES}
    mount_names = [section.frame or name for name, section in load_sensors.items()]
    return {mounts[name].link for name in mount_names if name in mounts}
