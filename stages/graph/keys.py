"""What the graph stage is told: how an assembly becomes links and joints."""

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, Strict
from pydantic_core import PydanticCustomError

from stages.graph.added_keys import AddedFrameKeys, AddedLinkKeys
from stages.graph.mass_keys import MassKeys
from stages.robot.keys import (
    Flag,
    Interval,
    Keys,
    NonNegative,
    Number,
    Positive,
    Text,
)

NAME_PATTERN = "[A-Za-z0-9_-]+"


def _file_name(name: str) -> str:
    if not re.fullmatch(NAME_PATTERN, name):
        text = "must be letters, digits, _ and - only: it names files (the key `output` moves the folder)"
        raise PydanticCustomError("file_name", text)
    if name.lower() == "scene":
        text = "must be another word: <name>.xml would take the place of scene.xml, the world around it"
        raise PydanticCustomError("file_name", text)
    return name


def _of_one_form(solref: tuple[float, float]) -> tuple[float, float]:
    if not (min(solref) > 0 or max(solref) < 0):
        text = "must be [time constant, damping ratio] above 0, or [-stiffness, -damping]"
        raise PydanticCustomError("solref", text)
    return solref


class RootKeys(Keys):
    """The link that the tree hangs on."""

    select: Text = "auto"
    """auto (what is fixed in CAD, else the heaviest), central (the nearest to all others, whatever is
    fixed), or the name of a link or an instance, or a glob."""

    base: Literal["auto", "fixed", "free"] = "auto"
    """Whether the root is fixed to the world; auto: if CAD fixes one of its occurrences."""

    frame: Text | None = None
    """The mate connector whose frame is the root's (its link is the root, if select is auto); null: the
    assembly's origin."""

    disconnected: Literal["error", "weld", "drop", "separate"] = "error"
    """What becomes of parts that hang on nothing. weld: fixed to the root where they are; drop: left out;
    separate: they float on their own."""


class DepthKeys(Keys):
    """Which sub-assemblies may move inside; by default all of them, at any depth."""

    max: Annotated[int, Strict(), Field(ge=0)] | None = None
    """Levels of sub-assemblies that are taken apart; 0: each is rigid; null: no bound."""

    rigid: tuple[Text, ...] = ()
    """Globs of sub-assemblies that are rigid, with all in them; one with a slash fits whole titles."""

    flexible: tuple[Text, ...] = ()
    """Globs of sub-assemblies that are flexible all the same."""


class NamesKeys(Keys):
    """Names of the user's own: CAD name or glob → name."""

    links: dict[Text, Text] = Field(default_factory=dict)
    """Names of links: each entry means exactly one."""

    joints: dict[Text, Text] = Field(default_factory=dict)
    """Names of joints: each entry means exactly one."""


class JointKeys(Keys):
    """Properties of the dofs that a glob matches; what is left out or null stays as it is."""

    limits: Interval | None = None
    """[lower, upper] [rad or m] in the mate's own value; a side that is null is open. Of a ball
    [null, cone]: the half angle that its z axis stays in."""

    effort: Positive | None = None
    """Largest torque or force [N m or N]."""

    velocity: Positive | None = None
    """Largest speed [rad/s or m/s]."""

    damping: NonNegative | None = None
    """Viscous friction [N m s/rad or N s/m]."""

    friction: NonNegative | None = None
    """Dry friction [N m or N]."""

    armature: NonNegative | None = None
    """The rotor's inertia as the joint feels it [kg m² or kg]."""


class RelationKeys(Keys):
    """What a relation means; what is left out or null stays as it is drawn."""

    invert: Flag | None = None
    """Whether the follower moves in the direction opposite to the one that is drawn."""

    offset: Number | None = None
    """Where the follower is when its driver is at 0 [rad or m, in the mates' own values]; null: as the
    saved pose has it."""

    drop: Flag | None = None
    """Whether it is left out: its joints move independently."""


class FramesKeys(Keys):
    """Named frames on links."""

    include: tuple[Text, ...] = ("*",)
    """Globs of mate connectors that become frames."""

    add: dict[Text, AddedFrameKeys] = Field(default_factory=dict)
    """Frames that CAD does not have, by name."""


class LoopsKeys(Keys):
    """Closed kinematic loops."""

    cut: tuple[Text, ...] = ()
    """Names or globs of the mates at which loops are cut; the others are chosen."""

    solref: Annotated[tuple[Number, Number], AfterValidator(_of_one_form)] = (0.005, 1)
    """MuJoCo's [time constant in s, damping ratio] of the constraint that closes a loop, or its
    [-stiffness, -damping]."""


class GraphKeys(Keys):
    """The graph stage's part of the configuration."""

    name: Annotated[Text, AfterValidator(_file_name)] = "robot"
    """Names the robot, its files and its folder."""

    root: RootKeys = RootKeys()
    """The link that the tree hangs on."""

    depth: DepthKeys = DepthKeys()
    """Which sub-assemblies may move inside."""

    hidden: Literal["keep", "drop"] = "keep"
    """What becomes of instances that are hidden in CAD; drop: as if they were suppressed."""

    zero: Literal["mate", "saved"] = "mate"
    """Where q = 0. mate: where the mate's frames coincide; saved: in the pose that CAD was left in."""

    mirror: Literal["joints", "weld"] = "joints"
    """What becomes of mirrored and patterned instances: joints copies the seed's joints, weld none."""

    conventions: Literal["linkwright", "onshape_to_robot"] = "linkwright"
    """Names in CAD that carry meaning. onshape_to_robot: those of that tool (dof_, closing_, frame_, fix_,
    link_, _inv), and with them its zero (saved), its root (the first instance) and rigid sub-assemblies."""

    names: NamesKeys = NamesKeys()
    """Names of the user's own."""

    joints: dict[Text, JointKeys] = Field(default_factory=dict)
    """Glob on names of dofs → properties; later entries win, property by property. A joint of one dof
    lends it its name; others have e.g. lift_slide and lift_turn."""

    relations: dict[Text, RelationKeys] = Field(default_factory=dict)
    """Glob on relations, by their names or as CAD calls them → what they mean; later entries win, property
    by property."""

    mass: MassKeys = MassKeys()
    """What is done about parts without mass."""

    links: dict[Text, AddedLinkKeys] = Field(default_factory=dict)
    """Links that CAD does not have, by name."""

    frames: FramesKeys = FramesKeys()
    """Named frames on links."""

    loops: LoopsKeys = LoopsKeys()
    """Closed kinematic loops."""
