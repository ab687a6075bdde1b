"""Makes the sensors and cameras that a frame or link carries."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.export.configuration.sensor_section import MEASURES
from linkwright.stages.export.ground.extents import Extents
from linkwright.stages.export.sensors.mounts import Mount, mounts_of, report_unknown_mount
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.poses import from_parts, inverse, rotation_from_rpy
from linkwright.stages.robot.model.robot import Array, Robot, Sensor, frozen
from linkwright.stages.robot.model.sensing import SensorCamera, SensorSite, SensorTarget, ZoneShape
from linkwright.stages.robot.text.names import free_name

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.sensor_section import SensorSection

WORLD = "world"
"""Name of the link at the assembly's origin, which is a site in the MJCF."""

LOOP_SITE_SUFFIXES = ("a", "b", "a_axis", "b_axis")
"""Suffixes of the names of sites that close loops, after the name of the loop and "_"."""

ZONE_MARGIN = 1e-3
"""Margin [m] around the colliders, of the box in which contact is felt."""

BOX_DIGITS = 4
"""Decimal places [m] to which the sides of the box are rounded."""


class MountedSensors:
    """A maker of sensors on frames and links, which collects their `sites` and `cameras`.

    `fused`: the links that are sites on other bodies in the MJCF; `site_names`: the sites that only the MJCF
    has; `camera_places`: name of each other camera → where it is defined.
    """

    def __init__(
        self,
        robot: Robot,
        geometry: Geometry,
        fused: Collection[str],
        site_names: Collection[str],
        camera_places: Mapping[str, str],
        log: Diagnostics,
    ) -> None:
        self.sites: list[SensorSite] = []
        self.cameras: list[SensorCamera] = []
        self._geometry = geometry
        self._sites_have_shapes = robot.mjcf is not None
        self._mounts = mounts_of(robot)
        self._links_as_sites = {WORLD, *fused}
        self._camera_places = camera_places
        self._site_names = {*self._mounts, *site_names}
        self._site_names |= {f"{loop.name}_{end}" for loop in robot.loops for end in LOOP_SITE_SUFFIXES}
        self._log = log

    def sensors(self, name: str, keys: "SensorSection") -> Iterator[Sensor]:
        """Yields the sensors of an entry. Reports frames and links that do not exist (E-FRAME) and impossible
        sensors (E-SENSOR), and yields no sensors for these."""
        mount = self._mount(keys.frame or name, f"sensors.{name}.frame")
        if mount is None:
            return
        if keys.type == "camera":
            yield from self._camera(name, keys, mount)
            return
        target, reference = self._object_of(name, keys, mount), self._reference(name, keys)
        if target is None or reference is None:
            return
        has_several = len(MEASURES[keys.type]) > 1
        for measured in keys.measured:
            kind = MEASURES[keys.type][measured]
            yield Sensor(
                f"{name}_{measured}" if has_several else name,
                kind,
                *target,
                *reference,
                noise=keys.noise_of(measured),
                cutoff=keys.cutoff_of(measured),
            )

    def of_source(self, sensor: Sensor) -> Sensor:
        """Returns a sensor of the source, on a site of its own if it needs a shape. The sites of an MJCF
        source have their shapes."""
        mount = self._mounts.get(sensor.name_of_target)
        if not sensor.shape or mount is None or self._sites_have_shapes:
            return sensor
        pose = mount.link_from_mount
        _, site = self._site(f"{sensor.name_of_target}_zone", mount, pose, sensor.shape, sensor.size)
        return replace(sensor, name_of_target=site)

    def _mount(self, name: str, where: str) -> Mount | None:
        """Returns the frame or link of this name; None if it does not exist, which is reported."""
        if name not in self._mounts:
            report_unknown_mount(name, where, self._mounts, self._log)
        return self._mounts.get(name)

    def _reference(self, name: str, keys: "SensorSection") -> tuple[SensorTarget, str] | None:
        """Returns the object that the sensor is relative to; None if it does not exist."""
        if keys.relative_to is None:
            return "", ""
        mount = self._mount(keys.relative_to, f"sensors.{name}.relative_to")
        return None if mount is None else self._mjcf_object(mount)

    def _mjcf_object(self, mount: Mount) -> tuple[SensorTarget, str]:
        """Returns a frame or link in MJCF's terms: its site if it has a site."""
        return "site" if mount.is_frame or mount.name in self._links_as_sites else "xbody", mount.name

    def _object_of(self, name: str, keys: "SensorSection", mount: Mount) -> tuple[SensorTarget, str] | None:
        """Returns the object of the sensor: its mount if the type allows that, else a site of its own."""
        pose = mount.link_from_mount @ _offset(keys)
        if keys.type == "touch":
            return self._zone(name, keys, mount, pose)
        if not any((*keys.xyz, *keys.rpy)):
            target = self._mjcf_object(mount)
            if keys.type == "frame" or target[0] == "site":
                return target
        return self._site(name, mount, pose)

    def _site(
        self,
        name: str,
        mount: Mount,
        link_from_site: Array,
        shape: ZoneShape = "",
        size: tuple[float, ...] = (),
    ) -> tuple[SensorTarget, str]:
        """Adds a site for a sensor, and returns it as an object of MJCF."""
        unique_name = free_name(name, self._site_names)
        self._site_names.add(unique_name)
        self.sites.append(SensorSite(unique_name, mount.link, frozen(link_from_site), shape, size))
        return "site", unique_name

    def _zone(
        self, name: str, keys: "SensorSection", mount: Mount, link_from_site: Array
    ) -> tuple[SensorTarget, str] | None:
        """Returns the site inside which contact is felt, by default the box around the link's colliders.
        Reports a link without colliders (E-SENSOR), and returns None."""
        if keys.size is not None:
            shape: ZoneShape = "sphere" if len(keys.size) == 1 else "box"
            return self._site(name, mount, link_from_site, shape, keys.size)
        shapes = tuple(self._geometry.shapes_of(mount.link, "collision"))
        low, high = Extents(
            Geometry(shapes, self._geometry.files), {mount.link: inverse(link_from_site)}
        ).box()
        if not np.isfinite(low).all():
            text = f"{mount.link} has no collider, so nothing presses on it"
            self._log.report("E-SENSOR", text, f"sensors.{name}", "give the touch sensor a size")
            return None
        low, high = np.round(low - ZONE_MARGIN, BOX_DIGITS), np.round(high + ZONE_MARGIN, BOX_DIGITS)
        box_pose = link_from_site @ from_parts(np.eye(3), (low + high) / 2)
        return self._site(name, mount, box_pose, "box", tuple(float(side) for side in high - low))

    def _camera(self, name: str, keys: "SensorSection", mount: Mount) -> Iterator[Sensor]:
        """Adds a camera, and yields its projections of the frames and links that it sees."""
        if name in self._camera_places:
            text = f"there is a camera {name!r} already, in {self._camera_places[name]}"
            self._log.report("E-SENSOR", text, f"sensors.{name}", "give this camera another name")
            return
        pose = frozen(mount.link_from_mount @ _offset(keys))
        self.cameras.append(SensorCamera(name, mount.link, pose, keys.fovy, keys.resolution))
        for target_name in keys.sees:
            target = self._mount(target_name, f"sensors.{name}.sees")
            if target is None:
                continue
            kind, site = self._mjcf_object(target)
            if kind != "site":
                _, site = self._site(f"{name}_{target_name}", target, target.link_from_mount)
            yield Sensor(
                f"{name}_{target_name}",
                MEASURES["camera"]["projection"],
                "site",
                site,
                "camera",
                name,
                noise=keys.noise_of("projection"),
                cutoff=keys.cutoff_of("projection"),
            )


def _offset(keys: "SensorSection") -> Array:
    """Returns mount_from_sensor (4, 4)."""
    return from_parts(rotation_from_rpy(keys.rpy), np.array(keys.xyz))
