"""What an MJCF source says of a robot that no other format has, and that only an MJCF can carry."""

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
"""From a kind and a name to the new name of what is called so."""


@dataclass(frozen=True, slots=True)
class MjcfElement:
    """An element of an MJCF. `names`: the attributes that name other elements, as (attribute, kind, name);
    the kind is the tag of what is named, "body" also for an xbody."""

    tag: str
    attributes: Attributes = ()
    names: tuple[tuple[str, str, str], ...] = ()
    children: tuple[MjcfElement, ...] = ()

    @property
    def name(self) -> str:
        """Its own name, "" where it has none."""
        return dict(self.attributes).get("name", "")

    def inside(self) -> Iterator[MjcfElement]:
        """The elements in it, at any depth."""
        for child in self.children:
            yield child
            yield from child.inside()

    def named(self) -> Iterator[tuple[str, str]]:
        """(kind, name) of all that it and the elements in it name."""
        yield from ((kind, name) for _, kind, name in self.names)
        for child in self.children:
            yield from child.named()

    def renamed(self, new_name: NewName) -> MjcfElement:
        """The element with other names of what it names."""
        return replace(
            self,
            names=tuple((attribute, kind, new_name(kind, name)) for attribute, kind, name in self.names),
            children=tuple(child.renamed(new_name) for child in self.children),
        )


@dataclass(frozen=True, slots=True, eq=False)
class MjcfBodyFrame:
    """Where the source's body of a link is: `link_from_body` (4, 4). `body_from_inertial` (3, 3): the axes of
    its inertia, in the order of the source, None for a body without mass."""

    link: str
    link_from_body: Array
    body_from_inertial: Array | None = None


@dataclass(frozen=True, slots=True)
class MjcfAttributes:
    """Attributes of a thing that the robot has itself: `kind` is joint (by the name of its dof), freejoint
    (of the floating root, by its link), body (of its link), site (of its frame), equality (of its loop or
    relation), actuator or sensor."""

    kind: str
    name: str
    attributes: Attributes


@dataclass(frozen=True, slots=True, eq=False)
class MjcfMounted:
    """An element on the body of a link, at `body_from_element` (4, 4)."""

    link: str
    body_from_element: Array
    element: MjcfElement


@dataclass(frozen=True, slots=True)
class MjcfKeyframe:
    """What a keyframe has beside the values of the robot's turns and slides. `world_from_root`: position and
    quaternion (x, y, z, qw, qx, qy, qz) of a floating root, () for none; `scene`: the numbers in `qpos` of
    what lies in the scene."""

    name: str
    world_from_root: tuple[float, ...] = ()
    scene: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class MjcfExtras:
    """`bodies`: of each link that is a body of the source. `sections`: elements in a section of an MJCF, as
    tendons, that name things of the robot alone; `order`: by section, the names of all of the source in its
    order. `scene`: the sections of what is in the scene beside the robot, and `scene_qpos` its numbers in
    `qpos0`; `has_ground`: whether something of that is fixed to the world and may be touched. `option`,
    `flag`: the attributes of MuJoCo's elements of these names that the source sets."""

    bodies: tuple[MjcfBodyFrame, ...] = ()
    attributes: tuple[MjcfAttributes, ...] = ()
    mounted: tuple[MjcfMounted, ...] = ()
    sections: tuple[MjcfElement, ...] = ()
    order: tuple[tuple[str, tuple[str, ...]], ...] = ()
    scene: tuple[MjcfElement, ...] = ()
    scene_qpos: tuple[float, ...] = ()
    keyframes: tuple[MjcfKeyframe, ...] = ()
    has_ground: bool = False
    option: tuple[tuple[str, Setting], ...] = ()
    flag: Attributes = ()

    def renamed(self, new_name: NewName) -> MjcfExtras:
        """The extras of a robot with other names."""
        kinds = {"freejoint": "body"}
        return replace(
            self,
            bodies=tuple(replace(one, link=new_name("body", one.link)) for one in self.bodies),
            attributes=tuple(
                replace(one, name=new_name(kinds.get(one.kind, one.kind), one.name))
                for one in self.attributes
            ),
            mounted=tuple(
                replace(one, link=new_name("body", one.link), element=one.element.renamed(new_name))
                for one in self.mounted
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
        """By name, the attributes of the things of this kind."""
        return {one.name: dict(one.attributes) for one in self.attributes if one.kind == kind}

    def in_order(self, section: str, names: Iterable[str]) -> list[str]:
        """The names as the source orders them, those that it has not at the end."""
        place = {name: index for index, name in enumerate(dict(self.order).get(section, ()))}
        return sorted(names, key=lambda name: place.get(name, len(place)))


def children_of(sections: Iterable[MjcfElement], tag: str) -> Iterator[MjcfElement]:
    """The elements in the sections of this tag."""
    for section in sections:
        if section.tag == tag:
            yield from section.children


NO_EXTRAS = MjcfExtras()
"""Those of a robot of another source."""
