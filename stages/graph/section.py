"""Configuration of the graph stage: how an assembly becomes links and joints."""

import re
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, Strict, model_validator

from linkwright.stages.graph.added_section import AddedFrameSection, AddedLinkSection, Direction
from linkwright.stages.graph.mass_section import MassSection
from linkwright.stages.robot.optional_section import OptionalSection
from linkwright.stages.robot.quantity_keys import Coordinate, Position, Range
from linkwright.stages.robot.section import (
    Flag,
    NonNegative,
    Positive,
    Section,
    Solref,
    Text,
    example,
    invalid,
)

NAME_PATTERN = "[A-Za-z0-9_-]+"


def _file_name(name: str) -> str:
    if not re.fullmatch(NAME_PATTERN, name):
        raise invalid(
            "must be letters, digits, _ and - only: it names files (the key `output` moves the folder)"
        )
    if name.lower() == "scene":
        raise invalid("choose another name: <name>.xml would overwrite scene.xml, the world around the robot")
    return name


class RootSection(Section):
    """The root link of the kinematic tree."""

    select: Annotated[Text, example("base*")] = "auto"
    """The root. auto: the link that is fixed in CAD, else the heaviest; central: the link nearest to all
    others; else the name of a link or an instance, or a glob."""

    base: Literal["auto", "fixed", "free"] = "auto"
    """How the root is connected to the world. fixed: fixed to it; free: by a floating joint; auto: fixed if
    CAD fixes one of its parts."""

    frame: Annotated[Text | None, example("base_frame")] = None
    """The mate connector whose frame becomes the root's frame; with `root.select: auto` its link is the root.
    null: the assembly's origin."""

    disconnected: Literal["error", "weld", "drop", "separate"] = "error"
    """Parts that no mate connects to the root. error: the build fails; weld: fixed to the root where they
    are; drop: left out; separate: each group floats on its own."""


class DepthSection(Section):
    """Sub-assemblies whose parts may move against each other; by default all of them, at any depth."""

    max: Annotated[Annotated[int, Strict(), Field(ge=0)] | None, example(1)] = None
    """Number of levels of sub-assemblies that are flexible; 0: every sub-assembly is rigid; null: no
    limit."""

    rigid: Annotated[tuple[Text, ...], example(["Servo*"])] = ()
    """Globs of sub-assemblies that are rigid, with everything in them; a glob with a slash matches the whole
    title."""

    flexible: Annotated[tuple[Text, ...], example(["Gripper*"])] = ()
    """Globs of sub-assemblies that are flexible, whatever `depth.max` and `depth.rigid` say."""


class NamesSection(Section):
    """Names of your own: CAD name or glob → name."""

    links: Annotated[dict[Text, Text], example({"Upper arm <1>": "upper_arm"})] = Field(default_factory=dict)
    """CAD name or glob → name of the link; each entry must match exactly one link."""

    joints: Annotated[dict[Text, Text], example({"Elbow": "elbow_pitch"})] = Field(default_factory=dict)
    """CAD name or glob → name of the joint; each entry must match exactly one joint."""


class JointSection(Section):
    """Properties of the degrees of freedom (dofs) that a glob matches; null: as in the source."""

    limits: Annotated[Range | None, example([-1.57, 1.57])] = None
    """[lower, upper] in the mate's own value [rad or m]; null leaves a side open. For a ball joint
    [null, cone]: the largest angle between its two z axes."""

    effort: Annotated[Positive | None, example(12)] = None
    """Largest torque or force [N m or N]."""

    velocity: Annotated[Positive | None, example(3)] = None
    """Largest speed [rad/s or m/s]."""

    damping: Annotated[NonNegative | None, example(0.1)] = None
    """Viscous damping [N m s/rad or N s/m]."""

    friction: Annotated[NonNegative | None, example(0.05)] = None
    """Dry (Coulomb) friction [N m or N]."""

    armature: Annotated[NonNegative | None, example(0.01)] = None
    """Inertia of the rotor, reflected to the joint [kg m² or kg]."""

    rotor_inertia: Annotated[NonNegative | None, example(1.2e-5)] = None
    """In place of `armature`: inertia of the rotor itself [kg m²]; the armature is this times `gear`²."""

    gear: Annotated[Positive | None, example(50)] = None
    """Gear for `rotor_inertia`: turns of the rotor per turn of the joint [-], or angle of the rotor per
    length of a slide [rad/m]; null: 1."""

    zero: Annotated[Coordinate | None, example(0.3)] = None
    """The mate's own value [rad or m] at which the joint's value is 0; null: as the key `zero` says. Limits
    are in the mate's own value; keyframes, controls and everything exported are in the joint's value."""

    invert: Annotated[Flag | None, example(True)] = None
    """Whether the joint's value grows when the mate's own value falls."""

    @model_validator(mode="after")
    def _one_armature(self) -> Self:
        if self.armature is not None and self.rotor_inertia is not None:
            raise invalid("must have an armature or a rotor_inertia, not both")
        return self


class RelationSection(Section):
    """Properties of the relations that a glob matches. What is left out or null stays as in CAD."""

    invert: Annotated[Flag | None, example(True)] = None
    """Whether the follower moves in the opposite direction."""

    offset: Annotated[Coordinate | None, example(0.1)] = None
    """Value of the follower when its driver is at 0, in the mates' own values [rad or m]; null: as in the
    saved pose."""

    drop: Annotated[Flag | None, example(True)] = None
    """Whether the relation is left out, so that its joints move independently."""


class MirrorSection(Section):
    """The plane of the mirrors that a glob matches, in the frame of the assembly that they are in."""

    normal: Annotated[Direction, example([0, 1, 0])]
    """A vector at right angles to the plane, of any length."""

    xyz: Annotated[Position, example([0, 0, 0])] = (0, 0, 0)
    """A point of the plane [m]."""


class FramesSection(Section):
    """Named frames on links."""

    include: Annotated[tuple[Text, ...], example(["tool*"])] = ("*",)
    """Globs of mate connectors that become frames."""

    add: Annotated[dict[Text, AddedFrameSection], example({"camera": {"link": "palm"}})] = Field(
        default_factory=dict
    )
    """Frames that CAD does not have, by name."""


class LoopsSection(Section):
    """Closed kinematic loops."""

    cut: Annotated[tuple[Text, ...], example(["Coupler*"])] = ()
    """Names or globs of mates that close a loop instead of becoming a joint of the tree; for other loops
    Linkwright chooses the mate."""

    solref: Annotated[Solref | None, example([0.005, 1])] = None
    """MuJoCo's solref of the constraints that close loops: [time constant, damping ratio] in s and without
    unit, or [-stiffness, -damping]; null: that of an MJCF source, else [0.005, 1]."""


class GraphSections(OptionalSection):
    """The graph stage's part of the configuration."""

    name: Annotated[Text, AfterValidator(_file_name), example("my_arm")] = "robot"
    """Name of the robot, of its files, and of its output folder."""

    root: RootSection = RootSection()
    """The root link of the kinematic tree."""

    depth: DepthSection = DepthSection()
    """Sub-assemblies whose parts may move relative to each other."""

    hidden: Literal["keep", "drop"] = "keep"
    """Instances that are hidden in CAD. keep: built; drop: left out, as if they were suppressed."""

    zero: Literal["mate", "saved"] = "mate"
    """The pose in which all joint values are 0. mate: the frames of each mate coincide; saved: the pose in
    which the document was saved."""

    mirror: Literal["joints", "weld"] = "joints"
    """Mirrored and patterned instances. joints: with copies of the seed's joints; weld: rigid."""

    conventions: Literal["linkwright", "onshape_to_robot"] = "linkwright"
    """Names in CAD that have a meaning. onshape_to_robot: the names of the tool onshape-to-robot (dof_,
    closing_, frame_, fix_, link_, _inv), and also its zero pose (saved), its root (the first instance) and
    rigid sub-assemblies."""

    names: NamesSection = NamesSection()
    """Names of your own."""

    joints: Annotated[dict[Text, JointSection], example({"*finger": {"damping": 0.1}})] = Field(
        default_factory=dict
    )
    """Glob on names of dofs → properties; later entries win, property by property. A joint's only dof has the
    joint's name; several dofs of a joint get suffixes, such as lift_slide and lift_turn."""

    relations: Annotated[dict[Text, RelationSection], example({"Gear*": {"invert": True}})] = Field(
        default_factory=dict
    )
    """Glob on names of relations, in the robot or in CAD → properties; later entries win, property by
    property."""

    mirrors: Annotated[dict[Text, MirrorSection], example({"Mirror 1": {"normal": [0, 1, 0]}})] = Field(
        default_factory=dict
    )
    """Glob on names of mirrors in CAD → the plane, where Linkwright cannot find it; later entries win."""

    mass: MassSection = MassSection()
    """Masses of parts and links."""

    links: Annotated[
        dict[Text, AddedLinkSection],
        example({"payload": {"parent": "tool", "mass": 0.3, "geometry": {"sphere": {"radius": 0.03}}}}),
    ] = Field(default_factory=dict)
    """Links that CAD does not have, by name."""

    frames: FramesSection = FramesSection()
    """Named frames on links."""

    loops: LoopsSection = LoopsSection()
    """Closed kinematic loops."""

    keyframes: Annotated[
        dict[Text, dict[Text, Coordinate] | None],
        example({"home": {"*knee*": 0.6}, "crouch": {"*knee*": 1.2}, "stand_on_left_leg": None}),
    ] = Field(default_factory=dict)
    """Name → glob on names of dofs → value [rad or m]; later entries win. The other joints stay as near to
    `home` as limits, relations and loops allow; for `home` itself, as near to the saved pose. `home` and
    `cad`, the saved pose, are always there; `cad` may lie outside the limits. Keyframes of an MJCF source,
    and states of a URDF's SRDF, are there too, within the limits; values here override the source's keyframe
    of the same name, and null leaves the source's keyframe out."""
