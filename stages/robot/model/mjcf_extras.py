"""Describes the content of an MJCF source that only an MJCF can carry."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkwright.stages.robot.model.scene import Setting

if TYPE_CHECKING:  # numpy comes with it
    from linkwright.stages.robot.model.arrays import Array

Attributes = tuple[tuple[str, str], ...]
"""Attributes of an element of an MJCF: (name, text)."""

NewName = Callable[[str, str], str]
"""A function from a kind and a name to the new name."""


@dataclass(frozen=True, slots=True)
class MjcfElement:
    """An element of an MJCF."""

    tag: str
    attributes: Attributes = ()
    names: tuple[tuple[str, str, str], ...] = ()
    """The attributes that name other elements: (attribute, kind, name). The kind is the tag of the named
    element; "body" also for an xbody."""
    children: tuple[MjcfElement, ...] = ()

    @property
    def name(self) -> str:
        """Its own name, "" if it is unnamed."""
        return dict(self.attributes).get("name", "")

    def inside(self) -> Iterator[MjcfElement]:
        """Yields the elements in it, at any depth."""
        for child in self.children:
            yield child
            yield from child.inside()

    def named(self) -> Iterator[tuple[str, str]]:
        """Yields (kind, name) of everything that it and the elements in it name."""
        yield from ((kind, name) for _, kind, name in self.names)
        for child in self.children:
            yield from child.named()

    def renamed(self, new_name: NewName) -> MjcfElement:
        """Returns the element with new names for the things that it refers to."""
        return replace(
            self,
            names=tuple((attribute, kind, new_name(kind, name)) for attribute, kind, name in self.names),
            children=tuple(child.renamed(new_name) for child in self.children),
        )


@dataclass(frozen=True, slots=True, eq=False)
class MjcfBodyFrame:
    """The pose of the source's body in its link."""

    link: str
    link_from_body: Array
    """Pose of the body in the link (4, 4)."""
    body_from_inertial: Array | None = None
    """Axes of its inertia (3, 3), in the order of the source; None for a body without mass."""


@dataclass(frozen=True, slots=True)
class MjcfAttributes:
    """Attributes of an element that the robot itself has."""

    kind: str
    """joint (named by its dof), freejoint (of the floating root, by its link), body (by its link), site (by
    its frame), equality (by its loop or relation), actuator or sensor."""
    name: str
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
    """The content of a keyframe beside the values of the robot's turns and slides."""

    name: str
    world_from_root: tuple[float, ...] = ()
    """Position and quaternion (x, y, z, qw, qx, qy, qz) of a floating root; () for none."""
    scene: tuple[float, ...] = ()
    """The numbers in `qpos` of the scene's objects."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfExtras:
    """The extras of an MJCF source."""

    bodies: tuple[MjcfBodyFrame, ...] = ()
    """An entry for each link that is a body of the source."""
    attributes: tuple[MjcfAttributes, ...] = ()
    mounted: tuple[MjcfMounted, ...] = ()
    sections: tuple[MjcfElement, ...] = ()
    """Elements in a section of an MJCF, such as tendons, that name only parts of the robot."""
    order: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """(section, names of all elements of the source in its order)."""
    scene: tuple[MjcfElement, ...] = ()
    """The sections of the objects beside the robot."""
    scene_qpos: tuple[float, ...] = ()
    """The numbers in `qpos0` of the scene's objects."""
    keyframes: tuple[MjcfKeyframe, ...] = ()
    has_ground: bool = False
    """Whether an object of the scene is fixed to the world and can be touched."""
    option: tuple[tuple[str, Setting], ...] = ()
    """Attributes of MuJoCo's element <option> that the source sets."""
    flag: Attributes = ()
    """Attributes of MuJoCo's element <flag> that the source sets."""

    def renamed(self, new_name: NewName) -> MjcfExtras:
        """Returns the extras of a robot with other names."""
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
        """Whether something beside the robot moves in the scene, or is driven there: then the keyframes are
        the scene's, since MuJoCo before version 4 takes none with the numbers of the robot alone."""
        return bool(self.scene_qpos) or any(section.tag == "actuator" for section in self.scene)

    def attributes_of(self, kind: str) -> dict[str, dict[str, str]]:
        """Returns the attributes of the things of this kind, by name."""
        return {entry.name: dict(entry.attributes) for entry in self.attributes if entry.kind == kind}

    def in_order(self, section: str, names: Iterable[str]) -> list[str]:
        """Returns the names as the source orders them, with names that it lacks at the end."""
        place = {name: index for index, name in enumerate(dict(self.order).get(section, ()))}
        return sorted(names, key=lambda name: place.get(name, len(place)))


def children_of(sections: Iterable[MjcfElement], tag: str) -> Iterator[MjcfElement]:
    """Yields the elements in the sections of this tag."""
    for section in sections:
        if section.tag == tag:
            yield from section.children


NO_EXTRAS = MjcfExtras()
"""The extras of a robot from another source."""
