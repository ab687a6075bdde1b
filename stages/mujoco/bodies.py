"""Converts whole bodies of a compiled model back to MJCF, with everything on and below them and with the data
of their meshes and height fields."""

from collections.abc import Callable, Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.elements import camera, geom, light, site
from linkwright.stages.mujoco.fields import BODY, attributes, joint_attributes
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.robot.model.arrays import Array
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement
from linkwright.stages.robot.model.poses import from_parts, inverse, quat_from_rotation, rotation_from_quat

_JOINT_TYPES = {
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball",
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
}

CONVERTED_GEOM_TYPES = frozenset(
    int(getattr(mujoco.mjtGeom, f"mjGEOM_{kind}"))
    for kind in ("PLANE", "HFIELD", "SPHERE", "CAPSULE", "ELLIPSOID", "CYLINDER", "BOX", "MESH")
)
"""Types of geoms that are converted; others, such as those of a plug-in, are left out."""

MESH, HFIELD = int(mujoco.mjtGeom.mjGEOM_MESH), int(mujoco.mjtGeom.mjGEOM_HFIELD)
"""Types of geoms that have data: a mesh, a height field."""


def placed(element: MjcfElement, pose: Array) -> MjcfElement:
    """Returns the element at a pose (4, 4) relative to its parent. A light shines along the pose's z axis."""
    position = ("pos", exact(map(float, pose[:3, 3])))
    turn = ("quat", exact(map(float, quat_from_rotation(pose[:3, :3]))))
    if element.tag == "light":
        turn = ("dir", exact(map(float, pose[:3, 2])))
    return MjcfElement(element.tag, (*element.attributes, position, turn), element.names, element.children)


def pose_of(position: Array, quat: Array) -> Array:
    """Returns the pose (4, 4) of a position (3,) and a quaternion (w, x, y, z)."""
    return from_parts(rotation_from_quat(np.asarray(quat, dtype=float)), np.asarray(position, dtype=float))


def light_pose(model: Any, index: int) -> Array:
    """Returns the pose (4, 4) of a light in its body. Its z axis is the direction of the light, and its x
    axis is any."""
    z = np.asarray(model.light_dir[index], dtype=float)
    z = z / np.linalg.norm(z)
    x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
    x /= np.linalg.norm(x)
    return from_parts(np.column_stack([x, np.cross(z, x), z]), model.light_pos[index])


class CompiledBodies:
    """A converter of whole bodies."""

    def __init__(self, model: Any, keeps: Callable[[int], bool]) -> None:
        """`keeps`: tells by the index of a body whether it is converted, with all bodies below it."""
        self._model = model
        self._keeps = keeps
        self.meshes: dict[int, str] = {}
        """Index → name of each mesh of the geoms that were converted so far."""
        self.fields: dict[int, str] = {}
        """Index → name of each height field of the geoms that were converted so far."""

    def world(self) -> tuple[MjcfElement, ...]:
        """Returns the elements on the world, and the bodies below it that `keeps` accepts."""
        return (*self._on(0), *self._below(0))

    def _body(self, body: int) -> MjcfElement:
        model = self._model
        name = name_of(model, OBJ.mjOBJ_BODY, body)
        rows = ((("name", name),) if name else ()) + attributes(model, BODY, body)
        rows += (("mocap", "true"),) if model.body_mocapid[body] >= 0 else ()
        children = (*self._joints(body), *self._inertial(body), *self._on(body), *self._below(body))
        element = MjcfElement("body", rows, children=children)
        return placed(element, pose_of(model.body_pos[body], model.body_quat[body]))

    def _below(self, body: int) -> Iterator[MjcfElement]:
        for child in np.flatnonzero(self._model.body_parentid == body):
            # The world is its own parent.
            if child and self._keeps(int(child)):
                yield self._body(int(child))

    def _joints(self, body: int) -> Iterator[MjcfElement]:
        model = self._model
        first = int(model.body_jntadr[body])
        for joint in range(first, first + int(model.body_jntnum[body])):
            yield MjcfElement("joint", (*_joint_placement(model, joint), *joint_attributes(model, joint)))

    def _inertial(self, body: int) -> Iterator[MjcfElement]:
        model = self._model
        if model.body_mass[body] > 0:
            rows = (
                ("pos", exact(map(float, model.body_ipos[body]))),
                ("quat", exact(map(float, model.body_iquat[body]))),
                ("mass", exact([float(model.body_mass[body])])),
                ("diaginertia", exact(map(float, model.body_inertia[body]))),
            )
            yield MjcfElement("inertial", rows)

    def _on(self, body: int) -> Iterator[MjcfElement]:
        """Yields the geoms, sites, cameras and lights on a body."""
        model = self._model
        for index in np.flatnonzero(model.geom_bodyid == body):
            if int(model.geom_type[index]) in CONVERTED_GEOM_TYPES:
                yield self._geom(int(index))
        for index in np.flatnonzero(model.site_bodyid == body):
            yield placed(site(model, int(index)), pose_of(model.site_pos[index], model.site_quat[index]))
        for index in np.flatnonzero(model.cam_bodyid == body):
            yield placed(camera(model, int(index)), pose_of(model.cam_pos[index], model.cam_quat[index]))
        for index in np.flatnonzero(model.light_bodyid == body):
            yield placed(light(model, int(index)), light_pose(model, int(index)))

    def _geom(self, index: int) -> MjcfElement:
        model = self._model
        kind, data = int(model.geom_type[index]), int(model.geom_dataid[index])
        pose = pose_of(model.geom_pos[index], model.geom_quat[index])
        element = geom(model, index)
        # The inertial holds the whole mass of the body.
        asset: Attributes = (("mass", "0"),)
        if kind == MESH:
            name = self.meshes.setdefault(data, name_of(model, OBJ.mjOBJ_MESH, data) or f"mesh_{data}")
            # The compiler moves a mesh to its principal axes, and its geoms the opposite way.
            pose = pose @ inverse(pose_of(model.mesh_pos[data], model.mesh_quat[data]))
            asset = (*asset, ("mesh", name))
        elif kind == HFIELD:
            name = name_of(model, OBJ.mjOBJ_HFIELD, data) or f"hfield_{data}"
            asset = (*asset, ("hfield", self.fields.setdefault(data, name)))
        return placed(MjcfElement("geom", (*element.attributes, *asset)), pose)

    def assets(self) -> tuple[MjcfElement, ...]:
        """Returns the meshes and height fields of the geoms that were converted so far."""
        meshes = (self._mesh(index, name) for index, name in sorted(self.meshes.items()))
        fields = (self._field(index, name) for index, name in sorted(self.fields.items()))
        return (*meshes, *fields)

    def _mesh(self, mesh: int, name: str) -> MjcfElement:
        model = self._model
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        pose = pose_of(model.mesh_pos[mesh], model.mesh_quat[mesh])
        points = model.mesh_vert[first : first + count].astype(float) @ pose[:3, :3].T + pose[:3, 3]
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        faces = " ".join(map(str, model.mesh_face[first : first + count].ravel().tolist()))
        vertices = " ".join(f"{number:.9g}" for number in points.ravel().tolist())
        # MuJoCo accepts a shell of any volume; its mass does not count, since bodies have inertials.
        rows = (("name", name), ("inertia", "shell"), ("vertex", vertices), ("face", faces))
        return MjcfElement("mesh", rows)

    def _field(self, field: int, name: str) -> MjcfElement:
        model = self._model
        rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
        first = int(model.hfield_adr[field])
        heights = model.hfield_data[first : first + rows * columns].reshape(rows, columns)
        size = exact(float(number) for number in model.hfield_size[field])
        texts: Attributes = (("name", name), ("nrow", str(rows)), ("ncol", str(columns)), ("size", size))
        if heights.any():
            # MuJoCo stores the rows in the reverse order of the attribute.
            text = " ".join(f"{number:.9g}" for number in heights[::-1].ravel().tolist())
            texts = (*texts, ("elevation", text))
        return MjcfElement("hfield", texts)


def _joint_placement(model: Any, joint: int) -> Iterator[tuple[str, str]]:
    """Yields the name, type, position, range and references of a joint."""
    name, kind = name_of(model, OBJ.mjOBJ_JOINT, joint), _JOINT_TYPES[int(model.jnt_type[joint])]
    if name:
        yield "name", name
    yield "type", kind
    if kind == "free":
        return
    yield "pos", exact(map(float, model.jnt_pos[joint]))
    if model.jnt_limited[joint]:
        yield "range", exact(map(float, model.jnt_range[joint]))
    if kind != "ball":
        address = int(model.jnt_qposadr[joint])
        yield "axis", exact(map(float, model.jnt_axis[joint]))
        yield "ref", exact([float(model.qpos0[address])])
        yield "springref", exact([float(model.qpos_spring[address])])
