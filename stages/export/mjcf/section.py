"""Defines the configuration of the MJCF writer."""

from typing import Literal

from linkwright.stages.export.configuration.format_section import FormatSection


class MjcfFormatSection(FormatSection):
    """The MJCF and its scene."""

    files = ("<name>.xml", "scene.xml")

    fixed_joints: Literal["auto", "merge", "keep"] = "auto"
    """Links on fixed joints. merge: each becomes part of the body above it, with its mass, inertia and
    shapes, and a site keeps its name and frame; keep: each has its own body; auto: the bodies of an MJCF
    source stay bodies, and other links are merged. MuJoCo's own `fusestatic` would drop the names and frames.
    A link that is fixed to a link `world` always has a body, and so has a link that needs a body: for a
    sensor or exclude of an MJCF source, a loop, or contacts that MuJoCo could not distinguish."""
