"""What the graph stage is told: how an assembly becomes links and joints."""

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from stages.robot.keys import (
    Interval,
    Keys,
    Later,
    NonNegative,
    Number,
    Positive,
    Text,
    not_yet,
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


class RootKeys(Keys):
    """The link that the tree hangs on."""

    select: Annotated[Text, Later("central")] = "auto"
    """auto (what is fixed in CAD, else the heaviest), or the name of a link, or a glob."""

    base: Literal["auto", "fixed", "free"] = "auto"
    """Whether the root is fixed to the world; auto: if CAD fixes one of its occurrences."""

    frame: Text | None = not_yet(None)
    """The mate connector or frame that is the root's frame; null: the assembly's origin."""

    disconnected: Literal["error"] = not_yet("error")
    """What becomes of parts that hang on nothing."""


class DepthKeys(Keys):
    """Which sub-assemblies may move inside; by default all of them, at any depth."""

    max: Annotated[int, Field(ge=0)] | None = not_yet(None)
    """Levels of sub-assemblies that are taken apart; 0: each is rigid; null: no bound."""

    rigid: tuple[Text, ...] = not_yet(())
    """Globs of sub-assemblies that are rigid."""

    flexible: tuple[Text, ...] = not_yet(())
    """Globs of sub-assemblies that are flexible all the same."""


class NamesKeys(Keys):
    """Names of the user's own: CAD name or glob → name."""

    links: dict[Text, Text] = not_yet(dict)
    """Names of links."""

    joints: dict[Text, Text] = not_yet(dict)
    """Names of joints."""


class JointKeys(Keys):
    """Properties of the joints that a glob matches; what is left out or null stays as it is."""

    limits: Interval | None = None
    """[lower, upper] [rad or m] in the mate's own value; a side that is null is open."""

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


class MassKeys(Keys):
    """What is done about parts without mass."""

    missing: Literal["auto"] = not_yet("auto")
    """auto: small parts are estimated, larger ones are an error."""

    density: Positive = not_yet(1200)
    """Density of estimated parts [kg/m³]."""

    parts: dict[Text, Any] = not_yet(dict)
    """Mass properties of parts, by glob."""

    links: dict[Text, Any] = not_yet(dict)
    """Mass properties of links, by glob."""


class FramesKeys(Keys):
    """Named frames on links."""

    include: tuple[Text, ...] = ("*",)
    """Globs of mate connectors that become frames."""

    add: dict[Text, Any] = not_yet(dict)
    """Frames that CAD does not have."""


class LoopsKeys(Keys):
    """Closed kinematic loops."""

    cut: tuple[Text, ...] = not_yet(())
    """Mates at which loops are cut; by default they are chosen."""

    solref: tuple[Number, Number] = (0.005, 1)
    """MuJoCo's [time constant in s, damping ratio] of the constraint that closes a loop."""


class GraphKeys(Keys):
    """The graph stage's part of the configuration."""

    name: Annotated[Text, AfterValidator(_file_name)] = "robot"
    """Names the robot, its files and its folder."""

    root: RootKeys = RootKeys()
    """The link that the tree hangs on."""

    depth: DepthKeys = DepthKeys()
    """Which sub-assemblies may move inside."""

    hidden: Literal["keep"] = not_yet("keep")
    """What becomes of instances that are hidden in CAD."""

    zero: Literal["mate"] = not_yet("mate")
    """mate: q = 0 where the mate's frames coincide."""

    mirror: Literal["joints"] = not_yet("joints")
    """What becomes of mirrored sub-assemblies: joints copies the seed's joints."""

    conventions: Literal["linkwright"] = not_yet("linkwright")
    """Names in CAD that carry meaning."""

    names: NamesKeys = NamesKeys()
    """Names of the user's own."""

    joints: dict[Text, JointKeys] = Field(default_factory=dict)
    """Glob on joint names → properties; later entries win, property by property."""

    mass: MassKeys = MassKeys()
    """What is done about parts without mass."""

    links: dict[Text, Any] = not_yet(dict)
    """Links that CAD does not have."""

    frames: FramesKeys = FramesKeys()
    """Named frames on links."""

    loops: LoopsKeys = LoopsKeys()
    """Closed kinematic loops."""
