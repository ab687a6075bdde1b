"""Writes the sites and cameras of sensors in MJCF."""

from collections.abc import Mapping

from linkwright.stages.export.mjcf.placement import move_before_bodies, placement
from linkwright.stages.export.mjcf.sensing.cameras import write_sensor_camera
from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.dynamics.fusing import Holders
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.model.sensing import Sensing, SensorSite

HIDDEN_GROUP = "3"
"""Group of sites that MuJoCo's viewers hide by default."""


def write_sites_and_cameras(
    elements: Mapping[str, tuple[Element, Array]], holders: Holders, sensing: Sensing
) -> None:
    """Writes the sites and cameras of sensors under the bodies that carry them. `elements`: link with a body
    → the body's element, and body_from_link (4, 4)."""

    def body_and_pose(link: str, link_from_object: Array) -> tuple[Element, Array]:
        """Returns the element of the body that carries an object, and body_from_object (4, 4)."""
        holder, holder_from_link = holders[link]
        body, body_from_holder = elements[holder]
        return body, body_from_holder @ holder_from_link @ link_from_object

    for site in sensing.sites:
        body, pose = body_and_pose(site.link, site.link_from_site)
        move_before_bodies(
            body, element(body, "site", name=site.name, **placement(pose), **_shape_attributes(site))
        )
    for camera in sensing.cameras:
        body, pose = body_and_pose(camera.link, camera.link_from_camera)
        move_before_bodies(body, write_sensor_camera(body, pose, camera))


def _shape_attributes(site: SensorSite) -> dict[str, str]:
    """Returns the attributes of a site that define its shape, with MuJoCo's half lengths. A site with a shape
    is hidden in viewers, since it covers a link."""
    if not site.shape:
        return {}
    radius_count = 0 if site.shape in ("box", "ellipsoid") else 1
    size = [*site.size[:radius_count], *(length / 2 for length in site.size[radius_count:])]
    return {"type": site.shape, "size": spaced(size), "group": HIDDEN_GROUP}
