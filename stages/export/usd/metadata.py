"""Makes SimReady's metadata: what a USD is, who made it, and how large and heavy it is."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.formats.numbers import LENGTH, number
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.robot import Array, Robot

METADATA_KEY = "SimReady_Metadata"
"""Key of the metadata in the custom data of a layer."""

MetadataValue = str | int | float | tuple[float, ...]

UNSPECIFIED = "unspecified"


def metadata(
    robot: Robot, keys: UsdFormatSection, body_count: int, size: Array
) -> Mapping[str, MetadataValue]:
    """Returns the metadata by the keys that SimReady's requirement SR.004 names. `body_count`: number of
    bodies in the USD; `size` (3,) [m]: sides of the box around the robot at `home`, not finite for a robot
    without shapes."""
    extents = size if np.isfinite(size).all() else np.zeros(3)
    total_mass = sum(link.inertial.mass or TINY_INERTIAL.mass for link in robot.links)
    return {
        "author": keys.author,
        "asset_name": robot.name,
        "asset_type": "robot",
        "asset_license": keys.license,
        "category": keys.category,
        "source_file": robot.provenance.document or UNSPECIFIED,
        "usd_date_generated": keys.date or UNSPECIFIED,
        "qcode": keys.qcode,
        "rigid_body_count": body_count,
        "asset_extents": tuple(float(number(side, least=LENGTH)) for side in extents),
        "mass": float(number(total_mass)),
    }
