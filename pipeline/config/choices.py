"""Choices after composition: the precedence of values, and the default name of the robot."""

import copy
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any

from linkwright.stages.export.section import ExportSection
from linkwright.stages.fetch.section import SOURCES

UNSET = "???"
"""Hydra's mark of a value that must be given."""


@dataclass(frozen=True, slots=True)
class Choices:
    """The choices behind a composed tree.

    `robot`: the robot's option; `formats`: the chosen options of `export`; `experiments`: the chosen
    experiments; `presets`: the content of each option that the command line chose, by group; `keys`: the full
    keys that the command line or an experiment set.
    """

    robot: str
    formats: tuple[str, ...]
    experiments: tuple[str, ...] = ()
    presets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    keys: frozenset[str] = frozenset()

    def sets(self, key: str) -> bool:
        """Whether the command line set this key or a mapping that contains it."""
        return any(key == one or key.startswith(f"{one}.") for one in self.keys)

    def touches(self, key: str) -> bool:
        """Whether the command line set this key, a key below it, or a mapping that contains it."""
        return self.sets(key) or any(one.startswith(f"{key}.") for one in self.keys)


def resolved_tree(tree: Mapping[str, Any], choices: Choices) -> dict[str, Any]:
    """The composed tree in the form that the plan reads.

    - An option chosen on the command line overrides the values of the robot's file.
    - Keys of other kinds of source are dropped if the command line chooses the source.
    - Of the known formats, only the chosen formats stay.
    - A robot without a name gets a default name; the robot of an experiment is `<robot>_<experiment>`, unless
      the experiment or the command line gives a name.
    """
    resolved = copy.deepcopy(dict(tree))
    for group, preset in choices.presets.items():
        section = resolved.setdefault(group, {})
        if isinstance(section, dict):
            _again(section, preset, group, choices)
    if "source" in choices.presets:
        _drop_other_sources(resolved, choices)
    _keep_chosen_formats(resolved, choices)
    if resolved.get("name") is None:
        resolved["name"] = name_of(resolved.get("source"), choices.robot)
    if choices.experiments and not choices.sets("name"):
        resolved["name"] = "_".join([str(resolved["name"]), *map(_safe, choices.experiments)])
    return resolved


def _again(section: dict[str, Any], preset: Mapping[str, Any], where: str, choices: Choices) -> None:
    for name, value in preset.items():
        key = f"{where}.{name}"
        if isinstance(value, Mapping) and isinstance(section.get(name), dict):
            _again(section[name], value, key, choices)
        elif value != UNSET and not choices.sets(key):
            section[name] = copy.deepcopy(value)


def _drop_other_sources(tree: dict[str, Any], choices: Choices) -> None:
    source = tree["source"]
    here = SOURCES.get(str(source.get("kind"))) if isinstance(source, dict) else None
    if here is None:
        return
    known = {name for keys in SOURCES.values() for name in keys.model_fields}
    others = known - set(here.model_fields)
    tree["source"] = {
        name: value
        for name, value in source.items()
        if name not in others or choices.touches(f"source.{name}")
    }


def _keep_chosen_formats(tree: dict[str, Any], choices: Choices) -> None:
    formats = tree.setdefault("export", {})
    if not isinstance(formats, dict):
        return
    for name in ExportSection.model_fields:
        if name not in choices.formats:
            formats.pop(name, None)
        else:
            formats.setdefault(name, {})


def name_of(source: Any, robot: str = "bare") -> str:
    """The name of the robot's file, else the stem of the source's path, else a name with the element's id."""
    if robot != "bare":
        return _safe(PurePath(robot).name)
    source = source if isinstance(source, dict) else {}
    if isinstance(source.get("path"), str):
        path = PurePath(source["path"])
        stem = path.stem.removesuffix(".urdf")
        # `scene` is a common name of a file around the robot, and linkwright writes its own scene.xml.
        return _safe((path.parent.name or "robot") if stem.lower() == "scene" else stem)
    element = re.search(r"/e/([0-9a-fA-F]{8})", str(source.get("url")))
    if element:
        return f"onshape_{element.group(1).lower()}"
    return _safe(str(source.get("kind", "robot")))


def _safe(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name) or "robot"
