"""The bodies of an MJCF: links with their joints, inertials, geoms and sites."""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.export.mjcf.contact.filters import WORLD, Geom
from linkwright.stages.export.mjcf.joints import free_joint_name, write_joints
from linkwright.stages.export.mjcf.loops import Closures
from linkwright.stages.export.mjcf.placement import above_bodies, orientation, placement, write_placed
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
from linkwright.stages.robot.text.names import free

PRINCIPAL = 1e-9
"""What an MJCF source's axes of inertia may leave off the diagonal, as a share of the largest moment."""


class BodyWriter:
    """The tree of bodies, below the worldbody. `painted`: the names of the materials; `bits`: see
    `Filters`."""

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
        self.taken |= {one.element.name for one in extras.mounted if one.element.tag == "geom"}
        self.written: set[str] = set()
        self.world = world
        self.robot = written.as_mjcf.robot
        self.held = written.as_mjcf.held
        self.groups = members(written.robot, self.held)
        """By link: those whose shapes its body has, with link_from_one (4, 4)."""
        self.shapes = geometry.by_link()
        self.start = written.start
        self.world_from_root = world_from_root
        self.painted = painted
        self.closures = closures
        self.compensated = dict(actuation.compensated)
        self.compensating = frozenset(actuation.compensating)
        self.bits = bits
        self.elements: dict[str, tuple[Element, Array]] = {}
        """By link: its element, and element_from_link (4, 4): of the link `world`, and of a link whose body
        an MJCF source has in another frame."""
        self.colliders: dict[Geom, str] = {}
        """The names of the geoms that collide."""
        self.contacts: dict[Geom, ContactProperties | None] = {}

    def write(self) -> None:
        joints = {joint.child: joint for joint in self.robot.joints}
        frames: dict[str, list[Frame]] = {}
        for frame in self.robot.frames:
            frames.setdefault(frame.link, []).append(frame)
        for link in self.robot.links:
            joint = joints.get(link.name)
            body, place = self._root() if joint is None else self._child(joint)
            self.elements[link.name] = body, place
            for name, text in self.extras["body"].get(link.name, {}).items():
                body.set(name, text)
            if link.name in self.compensated:
                body.set("gravcomp", number(self.compensated[link.name]))
            self._inertial(body, link, place)
            self._geoms(body, link.name, place)
            for frame in frames.get(link.name, ()):
                more = self.extras["site"].get(frame.name, {})
                element(body, "site", name=frame.name, **placement(place @ frame.link_from_frame), **more)
            self.closures.write_sites(body, link.name, place)
        for carrier in self.closures.carriers:
            above, place = self.elements[carrier.parent]
            pose = place @ carrier.pose(self.start)
            body = element(above, "body", name=carrier.name, **placement(pose))
            write_joints(body, carrier.dofs, self.start)
            _inertial(body, self.closures.carries(carrier))
            self.closures.write_sites(body, carrier.name, UNMOVED)

    def write_mounted(self) -> None:
        """The elements that only an MJCF has, under the bodies that carry them."""
        for one in self.mounted:
            holder, holder_from_link = self.held[one.link]
            body, body_from_holder = self.elements[holder]
            # The source's body has the place that it has on the link.
            own = self.frames.get(one.link)
            link_from_body = UNMOVED if own is None else own.link_from_body
            pose = body_from_holder @ holder_from_link @ link_from_body @ one.body_from_element
            above_bodies(body, write_placed(body, one.element, pose))

    def _root(self) -> tuple[Element, Array]:
        name = self.robot.root.name
        if name == WORLD:
            element(self.world, "site", name=WORLD, **placement(self.world_from_root))
            return self.world, self.world_from_root
        body = element(self.world, "body", name=name, **placement(self.world_from_root))
        if not self.robot.base.fixed:
            more = self.extras["freejoint"].get(name)
            tag, kind = ("joint", {"type": "free"}) if more else ("freejoint", {})
            element(body, tag, name=free_joint_name(self.robot), **kind, **(more or {}))
        return body, UNMOVED

    def _child(self, joint: Joint) -> tuple[Element, Array]:
        above, place = self.elements[joint.parent]
        if joint.type == "free":
            above, place = self.world, self.world_from_root
        own = self.frames.get(joint.child)
        link_from_body = UNMOVED if own is None else own.link_from_body
        pose = place @ joint.parent_from_joint @ chain(joint.dofs, self.start) @ link_from_body
        body = element(above, "body", name=joint.child, **placement(pose))
        body_from_link = inverse(link_from_body)
        write_joints(body, joint.dofs, self.start, self.compensating, body_from_link, self.extras["joint"])
        return body, body_from_link

    def _inertial(self, body: Element, link: Link, body_from_link: Array) -> None:
        """The mass of a link's body, in the axes of an MJCF source's where these still are principal."""
        own = self.frames.get(link.name)
        axes = None if own is None else own.body_from_inertial
        _inertial(body, moved(self.closures.share(link.name, link.inertial), body_from_link), axes)

    def _geoms(self, body: Element, link: str, place: Array) -> None:
        group = [(one, place @ pose) for one, pose in self.groups[link]]
        for one, pose in group:
            for shape in self.shapes[one, "visual"]:
                own = paint(shape)
                form = {**_form(shape, pose), **_contact(shape), **dict(shape.form.attributes)}
                material = None if own is None else self.painted[own]
                name = shape.form.name or None
                element(body, "geom", name=name, class_="visual", **form, material=material)
        before = 0
        for one, pose in group:
            collisions = self.shapes[one, "collision"]
            for count, shape in enumerate(collisions):
                suffix = f"_{count}" if len(collisions) > 1 else ""
                form = {**_form(shape, pose), **_contact(shape), **dict(shape.form.attributes)}
                geom = link, before + count
                bits = self.bits.get(geom)
                if bits is not None:
                    form |= zip(("contype", "conaffinity"), map(str, bits), strict=True)
                name = self._name(shape.form.name, f"{one}_collision{suffix}")
                self.colliders[geom], self.contacts[geom] = name, shape.contact
                element(body, "geom", name=name, class_="collision", **form)
            before += len(collisions)

    def _name(self, own: str, made: str) -> str:
        """The name of a collider: its own, which its first piece has, else one that is made."""
        if own and own not in self.written:
            self.written.add(own)
            return own
        name = free(own or made, self.taken | self.written)
        self.written.add(name)
        return name


SAME_FRAME = 1e-5
"""MuJoCo takes an inertial that is turned by less than about 1e-6 rad for one that is not turned. In another
order the axes are far from the body's."""


def _inertial(body: Element, inertial: Inertial, own: Array | None = None) -> None:
    """Mass properties about principal axes, in the order of `own` (3, 3) where these are such: from
    `fullinertia` MuJoCo up to 3.13 finds the axes to 1e-6 only, and ignores entries below 1e-12 kg m²."""
    if inertial.mass == 0.0:
        return
    # Of the rounded tensor: the digits below differ between machines.
    moments, axes = principal_axes(rounded_tensor(inertial.inertia))
    if own is not None:
        about = own.T @ inertial.inertia @ own
        if np.abs(about - np.diag(np.diag(about))).max() <= PRINCIPAL * np.abs(about).max():
            moments, axes = np.diag(about), own
    if 0.0 < np.abs(axes - np.eye(3)).max() < SAME_FRAME:
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
    """The attributes of a geom: a mesh, which is in the link's frame, or a primitive."""
    primitive = shape.ellipsoid or shape.primitive
    if primitive is None:
        assert shape.file is not None
        return {"mesh": stem(shape.file), **placement(body_from_link)}
    pose = placement(body_from_link @ primitive.link_from_shape)
    return {"type": primitive.kind, "size": spaced(_half_sizes(primitive)), **pose}


def _contact(shape: Shape) -> dict[str, str]:
    """The attributes of a geom's contacts, as far as the configuration gives them."""
    if shape.contact is None:
        return {}
    return {
        key: " ".join(number(one) for one in value) if isinstance(value, tuple) else number(value)
        for key, value in shape.contact.given().items()
    }


def _half_sizes(primitive: Primitive) -> list[float]:
    """MuJoCo's sizes: radii, and half lengths."""
    size = primitive.size
    if primitive.kind in ("box", "ellipsoid"):
        return [length / 2 for length in size]
    return [size[0], *(length / 2 for length in size[1:])]


def stem(file: str) -> str:
    """A mesh's name in MuJoCo: its file's, without the extension."""
    return file.rsplit(".", 1)[0]
