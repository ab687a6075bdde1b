"""Writes the bodies of an MJCF: links with their joints, inertials, geoms and sites."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.export.mjcf.contact.filters import WORLD, Geom
from linkwright.stages.export.mjcf.joints import free_joint_name, write_joints
from linkwright.stages.export.mjcf.loops import Closures
from linkwright.stages.export.mjcf.placement import move_before_bodies, orientation, placement, write_placed
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
"""Largest entry off the diagonal with which the axes of an MJCF source count as principal axes, relative to
the largest moment."""


class BodyWriter:
    """Writes the tree of bodies below the worldbody. `painted`: paint → name of the material; `bits`: geom →
    `contype` and `conaffinity`, as in `Filters`."""

    def __init__(
        self,
        world: Element,
        written: Written,
        world_from_root: Array,
        painted: dict[Paint, str],
        closures: Closures,
        bits: Mapping[Geom, tuple[int, int]],
    ) -> None:
        extras, geometry, actuation = written.extras, written.shapes, written.actuation
        self.frames = {frame.link: frame for frame in extras.bodies}
        self.extras = {kind: extras.attributes_of(kind) for kind in ("body", "joint", "freejoint", "site")}
        self.mounted = extras.mounted
        self.taken = {shape.form.name for shape in geometry.shapes}
        self.taken |= {mount.element.name for mount in extras.mounted if mount.element.tag == "geom"}
        self.written: set[str] = set()
        self.world = world
        self.robot = written.as_mjcf.robot
        self.held = written.as_mjcf.held
        self.groups = members(written.robot, self.held)
        """Link → (member, link_from_member (4, 4)) of the links whose shapes its body has."""
        self.shapes = geometry.by_link()
        self.start = written.start
        self.world_from_root = world_from_root
        self.painted = painted
        self.closures = closures
        self.compensated = dict(actuation.compensated)
        self.compensating = frozenset(actuation.compensating)
        self.bits = bits
        self.elements: dict[str, tuple[Element, Array]] = {}
        """Link → its element and element_from_link (4, 4). The latter is the identity except for the link
        `world`, and for a link whose body has another frame in an MJCF source."""
        self.colliders: dict[Geom, str] = {}
        """Geom that collides → its name."""
        self.contacts: dict[Geom, ContactProperties | None] = {}

    def write(self) -> None:
        joints = {joint.child: joint for joint in self.robot.joints}
        frames: dict[str, list[Frame]] = {}
        for frame in self.robot.frames:
            frames.setdefault(frame.link, []).append(frame)
        for link in self.robot.links:
            joint = joints.get(link.name)
            body, body_from_link = self._root() if joint is None else self._child(joint)
            self.elements[link.name] = body, body_from_link
            for name, text in self.extras["body"].get(link.name, {}).items():
                body.set(name, text)
            if link.name in self.compensated:
                body.set("gravcomp", number(self.compensated[link.name]))
            self._inertial(body, link, body_from_link)
            self._geoms(body, link.name, body_from_link)
            for frame in frames.get(link.name, ()):
                attributes = self.extras["site"].get(frame.name, {})
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
            _inertial(body, self.closures.carries(carrier))
            self.closures.write_sites(body, carrier.name, UNMOVED)

    def write_mounted(self) -> None:
        """Writes the elements that only an MJCF has, under the bodies that carry them."""
        for mount in self.mounted:
            holder, holder_from_link = self.held[mount.link]
            body, body_from_holder = self.elements[holder]
            # `mount` is relative to the body of the source, which may have another frame than the link.
            frame = self.frames.get(mount.link)
            link_from_body = UNMOVED if frame is None else frame.link_from_body
            pose = body_from_holder @ holder_from_link @ link_from_body @ mount.body_from_element
            move_before_bodies(body, write_placed(body, mount.element, pose))

    def _root(self) -> tuple[Element, Array]:
        name = self.robot.root.name
        if name == WORLD:
            element(self.world, "site", name=WORLD, **placement(self.world_from_root))
            return self.world, self.world_from_root
        body = element(self.world, "body", name=name, **placement(self.world_from_root))
        if not self.robot.base.fixed:
            attributes = self.extras["freejoint"].get(name)
            tag, kind = ("joint", {"type": "free"}) if attributes else ("freejoint", {})
            element(body, tag, name=free_joint_name(self.robot), **kind, **(attributes or {}))
        return body, UNMOVED

    def _child(self, joint: Joint) -> tuple[Element, Array]:
        parent, parent_from_link = self.elements[joint.parent]
        if joint.type == "free":
            parent, parent_from_link = self.world, self.world_from_root
        frame = self.frames.get(joint.child)
        link_from_body = UNMOVED if frame is None else frame.link_from_body
        pose = parent_from_link @ joint.parent_from_joint @ chain(joint.dofs, self.start) @ link_from_body
        body = element(parent, "body", name=joint.child, **placement(pose))
        body_from_link = inverse(link_from_body)
        write_joints(body, joint.dofs, self.start, self.compensating, body_from_link, self.extras["joint"])
        return body, body_from_link

    def _inertial(self, body: Element, link: Link, body_from_link: Array) -> None:
        """Writes the mass of a link's body, in the axes of an MJCF source if these still are principal
        axes."""
        frame = self.frames.get(link.name)
        axes = None if frame is None else frame.body_from_inertial
        _inertial(body, moved(self.closures.share(link.name, link.inertial), body_from_link), axes)

    def _geoms(self, body: Element, link: str, body_from_link: Array) -> None:
        group = [(member, body_from_link @ pose) for member, pose in self.groups[link]]
        for member, pose in group:
            for shape in self.shapes[member, "visual"]:
                material_paint = paint(shape)
                form = {**_form(shape, pose), **_contact(shape), **dict(shape.form.attributes)}
                material = None if material_paint is None else self.painted[material_paint]
                name = shape.form.name or None
                element(body, "geom", name=name, class_="visual", **form, material=material)
        count_before = 0
        for member, pose in group:
            collisions = self.shapes[member, "collision"]
            for count, shape in enumerate(collisions):
                suffix = f"_{count}" if len(collisions) > 1 else ""
                form = {**_form(shape, pose), **_contact(shape), **dict(shape.form.attributes)}
                geom = link, count_before + count
                bits = self.bits.get(geom)
                if bits is not None:
                    form |= zip(("contype", "conaffinity"), map(str, bits), strict=True)
                name = self._name(shape.form.name, f"{member}_collision{suffix}")
                self.colliders[geom], self.contacts[geom] = name, shape.contact
                element(body, "geom", name=name, class_="collision", **form)
            count_before += len(collisions)

    def _name(self, source_name: str, generated_name: str) -> str:
        """Returns the name of a collider: the first piece gets the source's name, the others a generated
        name."""
        if source_name and source_name not in self.written:
            self.written.add(source_name)
            return source_name
        name = free_name(source_name or generated_name, self.taken | self.written)
        self.written.add(name)
        return name


MIN_ANGLE = 1e-5
"""Smallest angle [rad] of principal axes that are written in their own order. MuJoCo ignores the orientation
of an inertial below about 1e-6 rad; in another order the axes are far from those of the body."""


def _inertial(body: Element, inertial: Inertial, source_axes: Array | None = None) -> None:
    """Writes the mass properties about principal axes: `source_axes` (3, 3) if they are principal axes, else
    computed axes. `fullinertia` is no alternative: MuJoCo up to 3.13 computes axes with an error of 1e-6 from
    it, and ignores entries below 1e-12 kg m²."""
    if inertial.mass == 0.0:
        return
    # The tensor is rounded first, because its smallest digits differ between machines.
    moments, axes = principal_axes(rounded_tensor(inertial.inertia))
    if source_axes is not None:
        about = source_axes.T @ inertial.inertia @ source_axes
        if np.abs(about - np.diag(np.diag(about))).max() <= PRINCIPAL_AXES_TOLERANCE * np.abs(about).max():
            moments, axes = np.diag(about), source_axes
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


def _form(shape: Shape, body_from_link: Array) -> dict[str, str]:
    """Returns the attributes of a geom: a mesh, which is in the link's frame, or a primitive."""
    primitive = shape.ellipsoid or shape.primitive
    if primitive is None:
        assert shape.file is not None
        return {"mesh": stem(shape.file), **placement(body_from_link)}
    pose = placement(body_from_link @ primitive.link_from_shape)
    return {"type": primitive.kind, "size": spaced(_half_sizes(primitive)), **pose}


def _contact(shape: Shape) -> dict[str, str]:
    """Returns the contact attributes of a geom that are set."""
    if shape.contact is None:
        return {}
    return {
        key: " ".join(number(component) for component in value) if isinstance(value, tuple) else number(value)
        for key, value in shape.contact.given().items()
    }


def _half_sizes(primitive: Primitive) -> list[float]:
    """Returns MuJoCo's sizes of a primitive: radii, and half lengths."""
    size = primitive.size
    if primitive.kind in ("box", "ellipsoid"):
        return [length / 2 for length in size]
    return [size[0], *(length / 2 for length in size[1:])]


def stem(file: str) -> str:
    """Returns the name of a mesh in MuJoCo: the name of its file, without the extension."""
    return file.rsplit(".", 1)[0]
