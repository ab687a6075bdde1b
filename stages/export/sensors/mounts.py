"""The frames and links that carry sensors, by the names that users give."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Array, Robot, frozen
from linkwright.stages.robot.text.globs import there_are

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.sensor_section import SensorSection

LOADED = ("force", "torque", "force_torque")
"""Types of sensors that measure what the link above exerts."""


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """Where the frame or link `name` is. `is_frame`: whether it is a frame, so that a site has its name."""

    name: str
    link: str
    link_from_mount: Array
    is_frame: bool


def mounts_of(robot: Robot) -> dict[str, Mount]:
    """By name; of a frame and a link of one name, the frame."""
    links = {link.name: Mount(link.name, link.name, frozen(np.eye(4)), False) for link in robot.links}
    frames = {one.name: Mount(one.name, one.link, one.link_from_frame, True) for one in robot.frames}
    return links | frames


def report_unknown(name: str, where: str, mounts: Mapping[str, Mount], log: Diagnostics) -> None:
    """E-FRAME: neither a frame nor a link has this name."""
    hint = there_are(name, {"frames and links": mounts})
    log.report("E-FRAME", f"there is no frame or link {name!r}", where, hint)


def loaded_links(robot: Robot, sensors: Mapping[str, "SensorSection"]) -> set[str]:
    """The links whose load sensors measure: each needs a body of its own in the MJCF, since MuJoCo measures
    what the body above exerts."""
    mounts = mounts_of(robot)
    names = [keys.frame or name for name, keys in sensors.items() if keys.type in LOADED]
    return {mounts[name].link for name in names if name in mounts}
