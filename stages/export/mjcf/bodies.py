"""Writes the bodies of an MJCF: links with their joints, inertials, geoms and sites."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.export.mjcf.contact.filters import WORLD, Geom
from linkwright.stages.export.mjcf.joints import free_joint_name, write_joints
from linkwright.stages.export.mjcf.loops import Closures
from linkwright.stages.export.mjcf.placement import move_before_bodies, orientation, placement, write_at_pose
from linkwright.stages.export.paints import Paint, paint
from linkwright.stages.formats.numbers import LENGTH, number, rounded_tensor, spaced
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.dynamics.fusing import members
from linkwright.stages.robot.dynamics.inertia import moved, principal_axes
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.poses import UNMOVED, inverse
from linkwright.stages.robot.model.robot import Array, Frame, Inertial, Joint, Link, Primitive
from linkwright.stages.robot.motion.kinematics import chain
from linkwright.stages.robot.text.names import free_name

PRINCIPAL_AXES_TOLERANCE = 1e-9
"""Largest entry of the tensor off the diagonal, relative to its largest entry, with which the axes of an MJCF
source count as principal axes."""

MIN_ANGLE = 1e-5
"""Smallest angle [rad] of principal axes that are written in their own order. MuJoCo ignores the orientation
of an inertial below about 1e-6 rad; in another order the axes are far from those of the body."""


class BodyWriter:
    """Writes the tree of bodies below the worldbody. `world_from_root` (4, 4): the pose of the root at qpos0;
    `material_names`: paint → name of the material; `bits`: geom → `contype` and `conaffinity`, as in
    `Filters`."""

    def __init__(
        self,
        world: Element,
        written: Written,
        world_from_root: Array,
        material_names: dict[Paint, str],
        closures: Closures,
        bits: Mapping[Geom, tuple[int, int]],
    ) -> None:
        extras, geometry, actuation = written.extras, written.shapes, written.actuation
        self.source_frames = {frame.link: frame for frame in extras.bodies}
        """Link → the frame of its body in an MJCF source."""
        self.source_attributes = {
            kind: extras.attributes_of(kind) for kind in ("body", "joint", "freejoint", "site")
        }
        self.mounted = extras.mounted
        self.source_geoms = {shape.form.name for shape in geometry.shapes}
        elements = [mount.element for mount in extras.mounted]
        elements += [element for section in extras.scene for element in section.inside()]
        self.source_geoms |= {element.name for element in elements if element.tag == "geom"}
        """The names of the geoms in an MJCF source."""
        self.collider_names: set[str] = set()
        self.world = world
        self.robot = written.as_mjcf.robot
        self.holders = written.as_mjcf.held
        self.groups = members(written.robot, self.holders)
        """Link → (member, link_from_member (4, 4)) of the links whose shapes its body has."""
        self.shapes = geometry.by_link()
        self.start = written.start
        self.world_from_root = world_from_root
        self.material_names = material_names
        self.closures = closures
        self.compensated = dict(actuation.compensated)
        self.compensating = frozenset(actuation.compensating)
        self.bits = bits
        self.elements: dict[str, tuple[Element, Array]] = {}
        """Link → its element and element_from_link (4, 4). The latter is the identity except for the link
        `world`, and for a link whose body has another frame in an MJCF source."""
        self.colliders: dict[Geom, str] = {}
        """Collider → its name."""
        self.contacts: dict[Geom, ContactProperties | None] = {}
        """Collider → the contact properties that the configuration gives it."""

    def write(self) -> None:
        """Writes the bodies of all links, parents first, and then those of the carriers of loops."""
        joints = {joint.child: joint for joint in self.robot.joints}
        frames: dict[str, list[Frame]] = {}
        for frame in self.robot.frames:
            frames.setdefault(frame.link, []).append(frame)
        for link in self.robot.links:
            joint = joints.get(link.name)
            body, body_from_link = self._root_body() if joint is None else self._child_body(joint)
            self.elements[link.name] = body, body_from_link
            for name, text in self.source_attributes["body"].get(link.name, {}).items():
                body.set(name, text)
            if link.name in self.compensated:
                body.set("gravcomp", number(self.compensated[link.name]))
            self._write_link_inertial(body, link, body_from_link)
            self._write_geoms(body, link.name, body_from_link)
            for frame in frames.get(link.name, ()):
                attributes = self.source_attributes["site"].get(frame.name, {})
                element(
                    body,
                    "site",
                    name=frame.name,
                    **placement(body_from_link @ frame.link_from_frame),
                    **attributes,
                )
            self.closures.write_sites(body, link.name, body_from_link)
        for carrier in self.closures.carriers:
            parent, body_from_link = self.elements[carrier.parent]
            pose = body_from_link @ carrier.pose(self.start)
            body = element(parent, "body", name=carrier.name, **placement(pose))
            write_joints(body, carrier.dofs, self.start)
            _write_inertial(body, self.closures.carrier_inertial(carrier))
            self.closures.write_sites(body, carrier.name, UNMOVED)

    def write_mounted(self) -> None:
        """Writes the elements that only an MJCF has, under the bodies that carry them."""
        for mount in self.mounted:
            holder, holder_from_link = self.holders[mount.link]
            body, body_from_holder = self.elements[holder]
            # `mount` is relative to the body of the source, which may have another frame than the link.
            frame = self.source_frames.get(mount.link)
            link_from_body = UNMOVED if frame is None else frame.link_from_body
            pose = body_from_holder @ holder_from_link @ link_from_body @ mount.body_from_element
            move_before_bodies(body, write_at_pose(body, mount.element, pose))

    def _root_body(self) -> tuple[Element, Array]:
        """Writes the body of the root link, and returns its element and body_from_link (4, 4). A link `world`
        is the worldbody, and a site there."""
        name = self.robot.root.name
        if name == WORLD:
            element(self.world, "site", name=WORLD, **placement(self.world_from_root))
            return self.world, self.world_from_root
        body = element(self.world, "body", name=name, **placement(self.world_from_root))
        if not self.robot.base.fixed:
            attributes = self.source_attributes["freejoint"].get(name)
            tag, kind = ("joint", {"type": "free"}) if attributes else ("freejoint", {})
            element(body, tag, name=free_joint_name(self.robot), **kind, **(attributes or {}))
        return body, UNMOVED

    def _child_body(self, joint: Joint) -> tuple[Element, Array]:
        """Writes the body of a joint's child with the joint, and returns its element and body_from_link (4,
        4)."""
        parent, parent_from_link = self.elements[joint.parent]
        if joint.type == "free":
            # MuJoCo has free joints only on children of the worldbody.
            parent, parent_from_link = self.world, self.world_from_root
        frame = self.source_frames.get(joint.child)
        link_from_body = UNMOVED if frame is None else frame.link_from_body
        pose = parent_from_link @ joint.parent_from_joint @ chain(joint.dofs, self.start) @ link_from_body
        body = element(parent, "body", name=joint.child, **placement(pose))
        body_from_link = inverse(link_from_body)
        write_joints(
            body, joint.dofs, self.start, self.compensating, body_from_link, self.source_attributes["joint"]
        )
        return body, body_from_link

    def _write_link_inertial(self, body: Element, link: Link, body_from_link: Array) -> None:
        """Writes the mass of a link's body, in the axes of an MJCF source if these still are principal
        axes."""
        frame = self.source_frames.get(link.name)
        axes = None if frame is None else frame.body_from_inertial
        inertial = self.closures.shared_inertial(link.name, link.inertial)
        _write_inertial(body, moved(inertial, body_from_link), axes)

    def _write_geoms(self, body: Element, link: str, body_from_link: Array) -> None:
        """Writes the shapes of a body: those of its link, and of the links that are part of it."""
        members_with_poses = [(member, body_from_link @ pose) for member, pose in self.groups[link]]
        for member, pose in members_with_poses:
            for shape in self.shapes[member, "visual"]:
                material_paint = paint(shape)
                attributes = _geom_attributes(shape, pose)
                material = None if material_paint is None else self.material_names[material_paint]
                name = shape.form.name or None
                element(body, "geom", name=name, class_="visual", **attributes, material=material)
        count_before = 0
        for member, pose in members_with_poses:
            collisions = self.shapes[member, "collision"]
            for index, shape in enumerate(collisions):
                suffix = f"_{index}" if len(collisions) > 1 else ""
                attributes = _geom_attributes(shape, pose)
                geom = link, count_before + index
                bits = self.bits.get(geom)
                if bits is not None:
                    attributes |= zip(("contype", "conaffinity"), map(str, bits), strict=True)
                name = self._collider_name(shape.form.name, f"{member}_collision{suffix}")
                self.colliders[geom], self.contacts[geom] = name, shape.contact
                element(body, "geom", name=name, class_="collision", **attributes)
            count_before += len(collisions)

    def _collider_name(self, source_name: str, generated_name: str) -> str:
        """Returns a free name for a collider. `source_name`: that of its geom in an MJCF source, or "". The
        first of several pieces of a geom gets it, and the others get it with a number."""
        if source_name and source_name not in self.collider_names:
            self.collider_names.add(source_name)
            return source_name
        name = free_name(source_name or generated_name, self.source_geoms | self.collider_names)
        self.collider_names.add(name)
        return name


def _write_inertial(body: Element, inertial: Inertial, source_axes: Array | None = None) -> None:
    """Writes the mass properties about principal axes: `source_axes` (3, 3) if they are principal axes, else
    computed axes. Writes nothing for a body without mass. `fullinertia` is no alternative: MuJoCo up to 3.13
    computes axes with an error of 1e-6 from it, and ignores entries below 1e-12 kg m²."""
    if inertial.mass == 0.0:
        return
    # The tensor is rounded first, because its smallest digits differ between machines.
    moments, axes = principal_axes(rounded_tensor(inertial.inertia))
    if source_axes is not None:
        tensor = source_axes.T @ inertial.inertia @ source_axes
        if np.abs(tensor - np.diag(np.diag(tensor))).max() <= PRINCIPAL_AXES_TOLERANCE * np.abs(tensor).max():
            moments, axes = np.diag(tensor), source_axes
    if 0.0 < np.abs(axes - np.eye(3)).max() < MIN_ANGLE:
        moments, axes = moments[[1, 2, 0]], axes[:, [1, 2, 0]]
    element(
        body,
        "inertial",
        pos=spaced(inertial.com, least=LENGTH),
        **orientation(axes),
        mass=number(inertial.mass),
        diaginertia=spaced(moments),
    )


def _geom_attributes(shape: Shape, body_from_link: Array) -> dict[str, str]:
    """Returns the attributes of a geom except its name, class and material. Those of an MJCF source override
    the others."""
    own_attributes = {**_shape_attributes(shape, body_from_link), **_contact_attributes(shape)}
    return own_attributes | dict(shape.form.attributes)


def _shape_attributes(shape: Shape, body_from_link: Array) -> dict[str, str]:
    """Returns the attributes of a geom that define its shape and pose: a mesh, which is in the link's frame,
    or a primitive."""
    primitive = shape.ellipsoid or shape.primitive
    if primitive is None:
        assert shape.file is not None
        return {"mesh": asset_name(shape.file), **placement(body_from_link)}
    pose = placement(body_from_link @ primitive.link_from_shape)
    return {"type": primitive.kind, "size": spaced(_half_sizes(primitive)), **pose}


def _contact_attributes(shape: Shape) -> dict[str, str]:
    """Returns the contact attributes that the configuration sets for a geom."""
    if shape.contact is None:
        return {}
    return {
        key: " ".join(number(component) for component in value) if isinstance(value, tuple) else number(value)
        for key, value in shape.contact.given().items()
    }


def _half_sizes(primitive: Primitive) -> list[float]:
    """Returns MuJoCo's sizes of a primitive [m]: radii, and half lengths."""
    size = primitive.size
    if primitive.kind in ("box", "ellipsoid"):
        return [length / 2 for length in size]
    return [size[0], *(length / 2 for length in size[1:])]


def asset_name(file: str) -> str:
    """Returns the name of a mesh or texture in MuJoCo: the name of its file, without the extension."""
    return file.rsplit(".", 1)[0]
