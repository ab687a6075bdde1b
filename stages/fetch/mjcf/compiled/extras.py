"""Reads the parts of a compiled model that only an MJCF has: tendons, their actuators and sensors, options,
and the scene around the robot."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from linkwright.stages.fetch.mjcf.compiled.equalities import is_carried_over
from linkwright.stages.fetch.mjcf.compiled.geoms import can_collide
from linkwright.stages.fetch.mjcf.compiled.options import flags, options
from linkwright.stages.formats.mjcf.model import MjcfPlaced
from linkwright.stages.mujoco import elements
from linkwright.stages.mujoco.bodies import CompiledBodies, light_pose, pose_of
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.mujoco.sensors import sensor
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement, MjcfExtras
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.text.names import free_name

_ELEMENTS_ON_BODIES = (
    ("joint", "njnt", OBJ.mjOBJ_JOINT, "jnt_bodyid"),
    ("geom", "ngeom", OBJ.mjOBJ_GEOM, "geom_bodyid"),
    ("site", "nsite", OBJ.mjOBJ_SITE, "site_bodyid"),
    ("camera", "ncam", OBJ.mjOBJ_CAMERA, "cam_bodyid"),
)
"""Elements on bodies that may have names: tag, MuJoCo's count, kind, and the array of their bodies."""

Numbered = tuple[int, MjcfElement | None]
"""MuJoCo's number of an element, and the element; None if it is not carried over."""


class ExtrasReader:
    """Reader of the parts of a model that only an MJCF has. `kept`: the robot's bodies, the world first."""

    def __init__(self, model: Any, kept: Sequence[int]) -> None:
        self._model = model
        self._kept = set(kept)
        self._is_fixed_to_world = any(
            int(model.body_parentid[body]) == 0 and not _floats(model, body) for body in kept if body
        )

    def frames(self, body: int) -> list[int]:
        """Returns the numbers of a body's sites that become frames: those with names; for the world only if
        the robot is fixed to it."""
        model = self._model
        if not body and not self._is_fixed_to_world:
            return []
        return [int(site) for site in np.flatnonzero(model.site_bodyid == body) if model.site(site).name]

    def mounted(self, body: int, geoms: Sequence[MjcfPlaced]) -> tuple[MjcfPlaced, ...]:
        """Returns the elements on a body: these `geoms`, then sites without names, cameras and lights."""
        model = self._model
        mounted = list(geoms)
        for site in np.flatnonzero(model.site_bodyid == body):
            if not model.site(site).name:
                pose = pose_of(model.site_pos[site], model.site_quat[site])
                mounted.append(MjcfPlaced(frozen(pose), elements.site(model, int(site))))
        for camera in np.flatnonzero(model.cam_bodyid == body):
            pose = pose_of(model.cam_pos[camera], model.cam_quat[camera])
            mounted.append(MjcfPlaced(frozen(pose), elements.camera(model, int(camera))))
        for light in np.flatnonzero(model.light_bodyid == body):
            pose = light_pose(model, int(light))
            mounted.append(MjcfPlaced(frozen(pose), elements.light(model, int(light))))
        return tuple(mounted)

    def read(self, acting: Collection[int], measured: Collection[int]) -> ExtrasSections:
        """Returns the extras of the whole model. `acting`, `measured`: the actuators and sensors that the
        robot has itself."""
        sections = ExtrasSections(self._model, self._kept, acting, measured)
        bodies = CompiledBodies(self._model, lambda body: body not in self._kept)
        world = [
            element
            for element in bodies.world()
            if not (self._is_fixed_to_world and element.tag == "site" and element.name)
        ]
        sections.scene["asset"], sections.scene["worldbody"] = list(bodies.assets()), world
        sections.read()
        return sections


def _floats(model: Any, body: int) -> bool:
    return bool(model.body_jntnum[body]) and int(model.jnt_type[model.body_jntadr[body]]) == 0


class ExtrasSections:
    """The sections of a model: those of the robot, and those of the scene, whose elements name things outside
    the robot. `lost`: (tag, number) of the elements that are not carried over."""

    def __init__(
        self, model: Any, kept: Collection[int], acting: Collection[int], measured: Collection[int]
    ) -> None:
        self._model, self._kept = model, kept
        self._robot_actuators, self._robot_sensors = acting, measured
        self._names = {("body", name_of(model, OBJ.mjOBJ_BODY, body)) for body in kept}
        self._scene_names: set[tuple[str, str]] = set()
        self.sections: dict[str, list[MjcfElement]] = {}
        self.scene: dict[str, list[MjcfElement]] = {}
        self.order: dict[str, list[str]] = {"actuator": [], "sensor": []}
        self.lost: set[tuple[str, int]] = set()

    def read(self) -> None:
        """Reads all sections of the model, after the names of the elements on bodies that they refer to."""
        model = self._model
        for body in range(model.nbody):
            self._add("body", name_of(model, OBJ.mjOBJ_BODY, body), body in self._kept)
        for tag, count, kind, bodies in _ELEMENTS_ON_BODIES:
            for index in range(getattr(model, count)):
                body_of_element = int(getattr(model, bodies)[index])
                # Elements on the world belong to the scene, except the frames of a robot that is fixed there.
                self._add(
                    tag,
                    name_of(model, kind, index),
                    body_of_element in self._kept and (body_of_element > 0 or tag == "site"),
                )
        self._section("contact", "pair", ((i, elements.pair(model, i)) for i in range(model.npair)))
        self._section("contact", "exclude", ((i, elements.exclude(model, i)) for i in range(model.nexclude)))
        self._section("tendon", "tendon", ((i, elements.tendon(model, i)) for i in range(model.ntendon)))
        other_equalities = (eq for eq in range(model.neq) if not is_carried_over(model, eq, self._kept))
        self._section("equality", "equality", ((eq, elements.equality(model, eq)) for eq in other_equalities))
        self._section(
            "actuator", "actuator", self._with_names("actuator", OBJ.mjOBJ_ACTUATOR, self._robot_actuators)
        )
        self._section("sensor", "sensor", self._with_names("sensor", OBJ.mjOBJ_SENSOR, self._robot_sensors))

    def _add(self, kind: str, name: str, is_robots: bool) -> None:
        if name:
            (self._names if is_robots else self._scene_names).add((kind, name))

    def _section(self, section: str, kind: str, numbered: Iterator[Numbered]) -> None:
        """Adds each element to the robot, or to the scene if it names an object of the scene. An element that
        names a lost element is lost too."""
        for number, element in numbered:
            if element is None or not set(element.named()) <= self._names | self._scene_names:
                self.lost.add((kind, number))
                continue
            is_robots = set(element.named()) <= self._names
            (self.sections if is_robots else self.scene).setdefault(section, []).append(element)
            self._add(kind, element.name, is_robots)
            if is_robots and section in self.order:
                self.order[section].append(element.name)

    def _with_names(self, kind: str, obj: Any, robots_own: Collection[int]) -> Iterator[Numbered]:
        """Yields the actuators or sensors except `robots_own`, each with a name."""
        model = self._model
        number = len(model.actuator_trntype) if kind == "actuator" else model.nsensor
        names = [name_of(model, obj, index) for index in range(number)]
        used_names = set(names)
        for index, name in enumerate(names):
            if index in robots_own:
                self._add(kind, name, is_robots=True)
                self.order[kind].append(name)
                continue
            element = elements.actuator(model, index) if kind == "actuator" else sensor(model, index)
            name = name or free_name(f"{kind}_{index}", used_names)
            used_names.add(name)
            name_attribute: Attributes = (("name", name),)
            yield (
                index,
                element and replace(element, attributes=(*name_attribute, *element.attributes)),
            )

    def extras(self) -> MjcfExtras:
        """Returns the extras as a value, without the attributes of the robot's own things."""
        model = self._model
        scene_joints = [
            joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) not in self._kept
        ]
        fixed_geoms = [
            geom
            for geom in range(model.ngeom)
            if model.body_weldid[model.geom_bodyid[geom]] == 0
            and (model.geom_bodyid[geom] == 0 or int(model.geom_bodyid[geom]) not in self._kept)
        ]
        return MjcfExtras(
            sections=_sections(self.sections),
            order=tuple((section, tuple(names)) for section, names in self.order.items() if names),
            scene=_sections(self.scene),
            scene_qpos=qpos_of(model, scene_joints, model.qpos0),
            has_ground=any(can_collide(model, geom) for geom in fixed_geoms),
            option=tuple(options(model)),
            flag=tuple(flags(model)),
        )


def _sections(by_tag: dict[str, list[MjcfElement]]) -> tuple[MjcfElement, ...]:
    return tuple(MjcfElement(tag, children=tuple(children)) for tag, children in by_tag.items() if children)


_QPOS_SIZES = {0: 7, 1: 4, 2: 1, 3: 1}
"""MuJoCo's type of joint → its number of values in `qpos`."""


def qpos_of(model: Any, joints: Collection[int], qpos: Any) -> tuple[float, ...]:
    """Returns the values of these joints in `qpos`."""
    return tuple(
        float(qpos[int(model.jnt_qposadr[joint]) + offset])
        for joint in joints
        for offset in range(_QPOS_SIZES[int(model.jnt_type[joint])])
    )
