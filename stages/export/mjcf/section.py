"""Defines the configuration of the MJCF writer."""

from typing import Literal

from linkwright.stages.export.configuration.format_section import FormatSection


class MjcfFormatSection(FormatSection):
    """The MJCF and its scene."""

    files = ("<name>.xml", "scene.xml")

    fixed_joints: Literal["auto", "merge", "keep"] = "auto"
    """Links on fixed joints. merge: each becomes part of its parent body, with its mass, inertia and shapes,
    and a site keeps its name and frame; keep: each has its own body; auto: the bodies of an MJCF source stay
    bodies, and other links are merged. MuJoCo's own `fusestatic` would drop the names and frames. Two kinds
    of links always have a body: links that are fixed to a link `world`, and links that need a body for a
    sensor or exclude of an MJCF source, for a loop, or for contacts that MuJoCo could not distinguish
    otherwise."""
