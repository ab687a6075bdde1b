"""Defines the key `optional`, and lists the globs of a configuration. The globs of presets, which several
robots share, may match nothing."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from linkwright.stages.robot.section import Section, Text, example

GLOB_KEYS = (
    "actuators",
    "contact.exclude",
    "depth.flexible",
    "depth.rigid",
    "frames.include",
    "geoms",
    "ignore.collision",
    "ignore.visual",
    "joints",
    "keyframes",
    "loops.cut",
    "mass.links",
    "mass.parts",
    "mesh.colliders",
    "mirrors",
    "names.joints",
    "names.links",
    "relations",
    "sensors",
    "variants.ranges",
)
"""The keys that hold globs."""


class OptionalSection(Section):
    """The part of the configuration for each stage that matches globs."""

    optional: Annotated[
        dict[Text, tuple[Text, ...]], example({"joints": ["*wheel*"], "sensors": ["*foot*"]})
    ] = Field(default_factory=dict)
    """Key that holds globs → those of its globs that may match nothing, which is then reported; any other
    glob that matches nothing is an error. The globs of presets (files of groups other than the robot and the
    experiment, such as actuators/lab.yaml) are added here automatically."""


def globs_of(tree: Mapping[str, Any], key: str) -> Iterator[str]:
    """Yields the globs of a key, such as "names.links", in a configuration or in a part of one."""
    value: Any = tree
    for name in key.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    if key == "sensors":
        value = [sensor.get(name) for sensor in _mappings(value) for name in ("joints", "actuators")]
    if key == "keyframes":
        value = [glob for keyframe in _mappings(value) for glob in keyframe]
    if key == "variants.ranges" and isinstance(value, str):
        return  # a word, and not a mapping by globs
    yield from _texts(value)


def all_globs(tree: Mapping[str, Any]) -> dict[str, list[str]]:
    """Returns the globs of each key of a configuration, or of a part of one, without repetition; keys without
    globs are left out."""
    globs_by_key = {key: list(dict.fromkeys(globs_of(tree, key))) for key in GLOB_KEYS}
    return {key: globs for key, globs in globs_by_key.items() if globs}


def _mappings(value: Any) -> Iterator[Mapping[str, Any]]:
    """Yields the values of a mapping that are mappings."""
    values = value.values() if isinstance(value, Mapping) else ()
    yield from (inner for inner in values if isinstance(inner, Mapping))


def _texts(value: Any) -> Iterator[str]:
    """Yields a text, the keys of a mapping that are texts, or the texts of a list and of the lists in it."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping | list | tuple):
        for inner in value:
            yield from _texts(inner)
