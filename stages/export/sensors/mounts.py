"""Finds the frames and links that carry sensors, by the names that users give."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Array, Robot, frozen
from linkwright.stages.robot.text.globs import no_match_hint

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.sensor_section import SensorSection

LOAD_TYPES = ("force", "torque", "force_torque")
"""Types of sensors that measure the load on the link above."""


@dataclass(frozen=True, slots=True, eq=False)
class Mount:
    """A frame or link that can carry sensors."""

    name: str
    """Its name."""

    link: str
    """The link that it is part of."""

    link_from_mount: Array
    """(4, 4)."""

    is_frame: bool
    """Whether it is a frame, so that a site has its name."""


def mounts_of(robot: Robot) -> dict[str, Mount]:
    """Returns the mounts by name. A frame hides a link of the same name."""
    links = {link.name: Mount(link.name, link.name, frozen(np.eye(4)), False) for link in robot.links}
    frames = {
        frame.name: Mount(frame.name, frame.link, frame.link_from_frame, True) for frame in robot.frames
    }
    return links | frames


def report_unknown(name: str, where: str, mounts: Mapping[str, Mount], log: Diagnostics) -> None:
    """Reports that neither a frame nor a link has this name (E-FRAME)."""
    hint = no_match_hint(name, {"frames and links": mounts})
    log.report("E-FRAME", f"there is no frame or link {name!r}", where, hint)


def loaded_links(robot: Robot, sensors: Mapping[str, "SensorSection"]) -> set[str]:
    """Returns the links whose load sensors measure. Each needs a body of its own in the MJCF, since MuJoCo
    measures the load between a body and the body above."""
    mounts = mounts_of(robot)
    names = [keys.frame or name for name, keys in sensors.items() if keys.type in LOAD_TYPES]
    return {mounts[name].link for name in names if name in mounts}
