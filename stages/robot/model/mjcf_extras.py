"""Describes the content of an MJCF source that only MJCF can express."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.robot.model.scene import Setting

if TYPE_CHECKING:  # `arrays` imports numpy
    from linkwright.stages.robot.model.arrays import Array

Attributes = tuple[tuple[str, str], ...]
"""Attributes of an element of an MJCF: (name, text)."""

NewName = Callable[[str, str], str]
"""A function from a kind and a name to the new name."""


@dataclass(frozen=True, slots=True)
class MjcfElement:
    """An element of an MJCF, whose references to other elements can be renamed."""

    tag: str
    attributes: Attributes = ()
    names: tuple[tuple[str, str, str], ...] = ()
    """The attributes that name other elements: (attribute, kind, name). The kind is the tag of the named
    element; "body" also for an xbody."""
    children: tuple[MjcfElement, ...] = ()

    @property
    def name(self) -> str:
        """The name of the element; "" without a name."""
        return dict(self.attributes).get("name", "")

    def inside(self) -> Iterator[MjcfElement]:
        """Yields the elements inside this element, at any depth."""
        for child in self.children:
            yield child
            yield from child.inside()

    def named(self) -> Iterator[tuple[str, str]]:
        """Yields (kind, name) of each reference of this element and of the elements inside."""
        yield from ((kind, name) for _, kind, name in self.names)
        for child in self.children:
            yield from child.named()

    def renamed(self, new_name: NewName) -> MjcfElement:
        """Returns the element with new names in its references and in those of the elements inside."""
        return replace(
            self,
            names=tuple((attribute, kind, new_name(kind, name)) for attribute, kind, name in self.names),
            children=tuple(child.renamed(new_name) for child in self.children),
        )


@dataclass(frozen=True, slots=True, eq=False)
class MjcfBodyFrame:
    """The pose of a source's body in its link."""

    link: str
    link_from_body: Array
    """Pose of the body in the link (4, 4)."""
    body_from_inertial: Array | None = None
    """Principal axes of the body's inertia (3, 3), in the order of the source; None for a body without
    mass."""


@dataclass(frozen=True, slots=True)
class MjcfAttributes:
    """Further attributes of an element that represents something of the robot."""

    kind: str
    """The kind of the element: joint, freejoint, body, site, equality, actuator or sensor."""
    name: str
    """The robot's name: a dof for a joint, a link for a body or for the freejoint of a floating root, a frame
    for a site, a loop or relation for an equality."""
    attributes: Attributes


@dataclass(frozen=True, slots=True, eq=False)
class MjcfMounted:
    """An element on the body of a link."""

    link: str
    body_from_element: Array
    """Pose of the element in the body (4, 4)."""
    element: MjcfElement


@dataclass(frozen=True, slots=True)
class MjcfKeyframe:
    """The values of a keyframe beside those of the robot's turns and slides."""

    name: str
    world_from_root: tuple[float, ...] = ()
    """Position [m] and quaternion (x, y, z, qw, qx, qy, qz) of a floating root; () without one."""
    scene: tuple[float, ...] = ()
    """The part of `qpos` that belongs to the scene's objects."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfExtras:
    """The content of an MJCF source that only MJCF can express."""

    bodies: tuple[MjcfBodyFrame, ...] = ()
    """An entry for each link that is a body of the source."""
    attributes: tuple[MjcfAttributes, ...] = ()
    mounted: tuple[MjcfMounted, ...] = ()
    sections: tuple[MjcfElement, ...] = ()
    """Sections of an MJCF, such as <tendon>, with elements that refer only to the robot."""
    order: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """(section, names of its elements in the source's order), for actuators and sensors."""
    scene: tuple[MjcfElement, ...] = ()
    """Sections with the elements of the objects beside the robot."""
    scene_qpos: tuple[float, ...] = ()
    """The part of `qpos0` that belongs to the scene's objects."""
    keyframes: tuple[MjcfKeyframe, ...] = ()
    has_ground: bool = False
    """Whether an object of the scene is fixed to the world and can be touched."""
    option: tuple[tuple[str, Setting], ...] = ()
    """The attributes of <option> that the source sets."""
    flag: Attributes = ()
    """The attributes of <flag> that the source sets."""

    def renamed(self, new_name: NewName) -> MjcfExtras:
        """Returns the extras with new names of links, joints and frames."""
        # A freejoint is named by its link.
        kinds = {"freejoint": "body"}
        return replace(
            self,
            bodies=tuple(replace(body, link=new_name("body", body.link)) for body in self.bodies),
            attributes=tuple(
                replace(entry, name=new_name(kinds.get(entry.kind, entry.kind), entry.name))
                for entry in self.attributes
            ),
            mounted=tuple(
                replace(
                    mounted, link=new_name("body", mounted.link), element=mounted.element.renamed(new_name)
                )
                for mounted in self.mounted
            ),
            sections=tuple(section.renamed(new_name) for section in self.sections),
            scene=tuple(section.renamed(new_name) for section in self.scene),
        )

    @property
    def moves_in_scene(self) -> bool:
        """Whether an object beside the robot moves in the scene or has actuators. The keyframes are then in
        the scene's file: before version 4, MuJoCo refuses keyframes with the numbers of the robot alone
        there."""
        return bool(self.scene_qpos) or any(section.tag == "actuator" for section in self.scene)

    def attributes_of(self, kind: str) -> dict[str, dict[str, str]]:
        """Returns the attributes of the elements of this kind, by name."""
        return {entry.name: dict(entry.attributes) for entry in self.attributes if entry.kind == kind}

    def in_order(self, section: str, names: Iterable[str]) -> list[str]:
        """Returns the names in the source's order; names that the source lacks come last, in their order."""
        place = {name: index for index, name in enumerate(dict(self.order).get(section, ()))}
        return sorted(names, key=lambda name: place.get(name, len(place)))


def children_of(sections: Iterable[MjcfElement], tag: str) -> Iterator[MjcfElement]:
    """Yields the elements in all sections with this tag."""
    for section in sections:
        if section.tag == tag:
            yield from section.children


NO_EXTRAS = MjcfExtras()
"""The extras of a robot whose source is not an MJCF."""
