"""Reads the parts of a compiled model that only an MJCF has: tendons, their actuators and sensors, options,
and the scene around the robot."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from linkwright.stages.fetch.mjcf.compiled.equalities import carried
from linkwright.stages.fetch.mjcf.compiled.geoms import touches
from linkwright.stages.fetch.mjcf.compiled.options import flags, options
from linkwright.stages.formats.mjcf.model import MjcfPlaced
from linkwright.stages.mujoco import elements
from linkwright.stages.mujoco.bodies import CompiledBodies, light_pose, pose_of
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.mujoco.sensors import sensor
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement, MjcfExtras
from linkwright.stages.robot.model.robot import frozen
from linkwright.stages.robot.text.names import free

_ON_BODIES = (
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
        self._stands = any(
            int(model.body_parentid[body]) == 0 and not _floats(model, body) for body in kept if body
        )

    def frames(self, body: int) -> list[int]:
        """Returns the sites that are frames: those with names on the robot, and on the world if the robot is
        fixed there."""
        model = self._model
        if not body and not self._stands:
            return []
        return [int(site) for site in np.flatnonzero(model.site_bodyid == body) if model.site(site).name]

    def mounted(self, body: int, geoms: Sequence[MjcfPlaced]) -> tuple[MjcfPlaced, ...]:
        """Returns the cameras, lights and sites without names on a body, after these `geoms`."""
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

    def read(self, acting: Collection[int], measured: Collection[int]) -> FoundExtras:
        """Returns the extras of the whole model. `acting`, `measured`: the actuators and sensors that the
        robot has itself."""
        sections = FoundExtras(self._model, self._kept, acting, measured)
        bodies = CompiledBodies(self._model, lambda body: body not in self._kept)
        world = [
            element
            for element in bodies.world()
            if not (self._stands and element.tag == "site" and element.name)
        ]
        sections.scene["asset"], sections.scene["worldbody"] = list(bodies.assets()), world
        sections.read()
        return sections


def _floats(model: Any, body: int) -> bool:
    return bool(model.body_jntnum[body]) and int(model.jnt_type[model.body_jntadr[body]]) == 0


class FoundExtras:
    """The sections of a model: those of the robot, and those of the scene, whose elements name things outside
    the robot. `lost`: (tag, number) of the elements that are not carried over."""

    def __init__(
        self, model: Any, kept: Collection[int], acting: Collection[int], measured: Collection[int]
    ) -> None:
        self._model, self._kept = model, kept
        self._acting, self._measured = acting, measured
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
        for tag, count, kind, bodies in _ON_BODIES:
            for index in range(getattr(model, count)):
                on = int(getattr(model, bodies)[index])
                # Elements on the world belong to the scene, except the frames of a robot that is fixed there.
                self._add(tag, name_of(model, kind, index), on in self._kept and (on > 0 or tag == "site"))
        self._section("contact", "pair", ((i, elements.pair(model, i)) for i in range(model.npair)))
        self._section("contact", "exclude", ((i, elements.exclude(model, i)) for i in range(model.nexclude)))
        self._section("tendon", "tendon", ((i, elements.tendon(model, i)) for i in range(model.ntendon)))
        ties = (eq for eq in range(model.neq) if not carried(model, eq, self._kept))
        self._section("equality", "equality", ((eq, elements.equality(model, eq)) for eq in ties))
        self._section("actuator", "actuator", self._titled("actuator", OBJ.mjOBJ_ACTUATOR, self._acting))
        self._section("sensor", "sensor", self._titled("sensor", OBJ.mjOBJ_SENSOR, self._measured))

    def _add(self, kind: str, name: str, robots: bool) -> None:
        if name:
            (self._names if robots else self._scene_names).add((kind, name))

    def _section(self, section: str, kind: str, numbered: Iterator[Numbered]) -> None:
        """Puts each element into the robot or the scene, by the things that it names. An element that names a
        lost element is lost too."""
        for number, element in numbered:
            if element is None or not set(element.named()) <= self._names | self._scene_names:
                self.lost.add((kind, number))
                continue
            robots = set(element.named()) <= self._names
            (self.sections if robots else self.scene).setdefault(section, []).append(element)
            self._add(kind, element.name, robots)
            if robots and section in self.order:
                self.order[section].append(element.name)

    def _titled(self, kind: str, obj: Any, robots_own: Collection[int]) -> Iterator[Numbered]:
        """Yields the actuators or sensors except `robots_own`, each with a name."""
        model = self._model
        number = len(model.actuator_trntype) if kind == "actuator" else model.nsensor
        names = [name_of(model, obj, index) for index in range(number)]
        used_names = set(names)
        for index, name in enumerate(names):
            if index in robots_own:
                self._add(kind, name, robots=True)
                self.order[kind].append(name)
                continue
            element = elements.actuator(model, index) if kind == "actuator" else sensor(model, index)
            name = name or free(f"{kind}_{index}", used_names)
            used_names.add(name)
            title: Attributes = (("name", name),)
            yield (
                index,
                element and replace(element, attributes=(*title, *element.attributes)),
            )

    def extras(self) -> MjcfExtras:
        """Returns the extras as a value, without the attributes of the robot's own things."""
        model = self._model
        scene_joints = [
            joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) not in self._kept
        ]
        fixed = [
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
            has_ground=any(touches(model, geom) for geom in fixed),
            option=tuple(options(model)),
            flag=tuple(flags(model)),
        )


def _sections(by_tag: dict[str, list[MjcfElement]]) -> tuple[MjcfElement, ...]:
    return tuple(MjcfElement(tag, children=tuple(children)) for tag, children in by_tag.items() if children)


_SIZES = {0: 7, 1: 4, 2: 1, 3: 1}
"""MuJoCo's type of joint → its number of values in `qpos`."""


def qpos_of(model: Any, joints: Collection[int], qpos: Any) -> tuple[float, ...]:
    """Returns the values of these joints in `qpos`."""
    return tuple(
        float(qpos[int(model.jnt_qposadr[joint]) + place])
        for joint in joints
        for place in range(_SIZES[int(model.jnt_type[joint])])
    )
