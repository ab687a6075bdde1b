"""Defines the extras of an MJCF in robot.json."""

from dataclasses import dataclass
from typing import Annotated

from linkwright.stages.formats.robot_json.codec import JsonRecord, Key
from linkwright.stages.formats.robot_json.values import (
    ExactNumbers,
    ExactTensor,
    NamePairs,
    Pose,
    RootValue,
    SettingPairs,
    TextListPairs,
    TextPairs,
)
from linkwright.stages.robot.model import mjcf_extras


@dataclass(frozen=True)
class MjcfElementRecord(JsonRecord[mjcf_extras.MjcfElement]):
    """An element.

    tag: its tag.
    attributes: the attributes that refer to no element.
    names: attribute → the kind and the name of the element that it refers to.
    children: the elements in it.
    """

    tag: str
    attributes: TextPairs
    names: NamePairs
    children: "tuple[MjcfElementRecord, ...]"


@dataclass(frozen=True)
class MjcfBodyRecord(JsonRecord[mjcf_extras.MjcfBodyFrame]):
    """The pose of the source's body of a link.

    link: the link.
    pose: the pose of the body in the link.
    inertial_axes: the axes of its inertia, in the order of the source; null for a body without mass.
    """

    link: str
    link_from_body: Pose
    body_from_inertial: Annotated[ExactTensor | None, Key("inertial_axes")]


@dataclass(frozen=True)
class MjcfAttributesRecord(JsonRecord[mjcf_extras.MjcfAttributes]):
    """Attributes of an element that the robot has itself.

    kind: joint (by the name of its degree of freedom), freejoint (of the floating root, by its link), body
        (of its link), site (of its frame), equality (of its loop or relation), actuator or sensor.
    name: the name of the element.
    attributes: the attributes that no other format has.
    """

    kind: str
    name: str
    attributes: TextPairs


@dataclass(frozen=True)
class MjcfMountedRecord(JsonRecord[mjcf_extras.MjcfMounted]):
    """An element on the body of a link.

    link: the link.
    pose: the pose of the element in the body.
    element: the element.
    """

    link: str
    body_from_element: Pose
    element: MjcfElementRecord


@dataclass(frozen=True)
class MjcfKeyframeRecord(JsonRecord[mjcf_extras.MjcfKeyframe]):
    """The values of a keyframe other than those of turns and slides.

    name: the name of the keyframe.
    root: position and quaternion of a floating root; empty for a fixed root.
    scene: the numbers in `qpos` of the moving bodies of the scene.
    """

    name: str
    world_from_root: Annotated[RootValue, Key("root")]
    scene: ExactNumbers


@dataclass(frozen=True)
class MjcfRecord(JsonRecord[mjcf_extras.MjcfExtras]):
    """Content of an MJCF source that no other format has.

    bodies: the poses of its bodies on the links.
    attributes: attributes of joints, sites and other elements that the robot has itself.
    mounted: elements on the bodies of links.
    sections: elements in a section, such as tendons, that name things of the robot alone.
    order: section → the names of all its elements, in the source's order.
    scene: the sections of the elements in the scene around the robot.
    scene_qpos: the numbers in `qpos0` of moving bodies in the scene.
    keyframes: the values of keyframes other than those of turns and slides.
    has_ground: whether the scene has a ground to stand on.
    option: attribute of MuJoCo's element → its value.
    flag: attribute of MuJoCo's element → its value.
    """

    bodies: tuple[MjcfBodyRecord, ...]
    attributes: tuple[MjcfAttributesRecord, ...]
    mounted: tuple[MjcfMountedRecord, ...]
    sections: tuple[MjcfElementRecord, ...]
    order: TextListPairs
    scene: tuple[MjcfElementRecord, ...]
    scene_qpos: ExactNumbers
    keyframes: tuple[MjcfKeyframeRecord, ...]
    has_ground: bool
    option: SettingPairs
    flag: TextPairs
