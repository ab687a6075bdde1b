"""What only an MJCF has, in a robot.json."""

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
    TextPairs,
    TextsPairs,
)
from linkwright.stages.robot.model import mjcf_extras


@dataclass(frozen=True)
class MjcfElementRecord(JsonRecord[mjcf_extras.MjcfElement]):
    """An element.

    tag: its tag.
    attributes: those that name nothing.
    names: attribute → the kind and the name of what it names.
    children: the elements in it.
    """

    tag: str
    attributes: TextPairs
    names: NamePairs
    children: "tuple[MjcfElementRecord, ...]"


@dataclass(frozen=True)
class MjcfBodyRecord(JsonRecord[mjcf_extras.MjcfBodyFrame]):
    """Where the source's body of a link is.

    link: the link.
    pose: where the body is in it.
    inertial_axes: the axes of its inertia, in the order of the source; null for a body without mass.
    """

    link: str
    link_from_body: Pose
    body_from_inertial: Annotated[ExactTensor | None, Key("inertial_axes")]


@dataclass(frozen=True)
class MjcfAttributesRecord(JsonRecord[mjcf_extras.MjcfAttributes]):
    """Attributes of a thing that the robot has itself.

    kind: joint (by the name of its degree of freedom), freejoint (of the floating root, by its link), body
        (of its link), site (of its frame), equality (of its loop or relation), actuator or sensor.
    name: of the thing.
    attributes: those that no other format has.
    """

    kind: str
    name: str
    attributes: TextPairs


@dataclass(frozen=True)
class MjcfMountedRecord(JsonRecord[mjcf_extras.MjcfMounted]):
    """An element on the body of a link.

    link: the link.
    pose: where it is in the body.
    element: the element.
    """

    link: str
    body_from_element: Pose
    element: MjcfElementRecord


@dataclass(frozen=True)
class MjcfKeyframeRecord(JsonRecord[mjcf_extras.MjcfKeyframe]):
    """What a keyframe has beside the values of turns and slides.

    name: of the keyframe.
    root: position and quaternion of a floating root; empty for none.
    scene: the numbers in `qpos` of what moves in the scene.
    """

    name: str
    world_from_root: Annotated[RootValue, Key("root")]
    scene: ExactNumbers


@dataclass(frozen=True)
class MjcfRecord(JsonRecord[mjcf_extras.MjcfExtras]):
    """What an MJCF source has that no other format has.

    bodies: where its bodies are on the links.
    attributes: those of joints, sites and other things that the robot has itself.
    mounted: elements on the bodies of links.
    sections: elements in a section, such as tendons, that name things of the robot alone.
    order: section → the names of all in it, in the source's order.
    scene: the sections of what is in the scene beside the robot.
    scene_qpos: the numbers in `qpos0` of what moves in the scene.
    keyframes: what they have beside the values of turns and slides.
    has_ground: whether the scene has something to stand on.
    option: attribute of MuJoCo's element → its value.
    flag: attribute of MuJoCo's element → its value.
    """

    bodies: tuple[MjcfBodyRecord, ...]
    attributes: tuple[MjcfAttributesRecord, ...]
    mounted: tuple[MjcfMountedRecord, ...]
    sections: tuple[MjcfElementRecord, ...]
    order: TextsPairs
    scene: tuple[MjcfElementRecord, ...]
    scene_qpos: ExactNumbers
    keyframes: tuple[MjcfKeyframeRecord, ...]
    has_ground: bool
    option: SettingPairs
    flag: TextPairs
