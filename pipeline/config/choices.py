"""Resolves a composed tree: command line over robot file, chosen formats and targets, default name."""

import copy
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any

from linkwright.stages.export.section import ExportSection
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.targets.section import TargetSection

UNSET = "???"
"""Hydra's marker for a mandatory value that is not set."""


@dataclass(frozen=True, slots=True)
class Choices:
    """The options and keys that led to a composed tree.

    Choices and keys of an experiment count as if they were typed on the command line.
    """

    robot: str
    """The option of the group `robot`."""
    multiple_choices: Mapping[str, tuple[str, ...]]
    """The chosen options of each group that allows several, such as `export`."""
    experiments: tuple[str, ...] = ()
    presets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """The content of each option that the command line chose, by group."""
    keys: frozenset[str] = frozenset()
    """The full keys that the command line set."""
    explicit_groups: frozenset[str] = frozenset()
    """The groups in `multiple_choices` for which the command line chose options."""

    def sets(self, key: str) -> bool:
        """Tells whether the command line set this key or a mapping that contains it."""
        return any(key == set_key or key.startswith(f"{set_key}.") for set_key in self.keys)

    def touches(self, key: str) -> bool:
        """Tells whether the command line set this key, a key below it, or a mapping that contains it."""
        return self.sets(key) or any(set_key.startswith(f"{key}.") for set_key in self.keys)


def resolve_choices(tree: Mapping[str, Any], choices: Choices) -> dict[str, Any]:
    """Returns the composed tree in the form that the plan reads.

    - An option chosen on the command line overrides the values of the robot's file.
    - If the command line chooses the source, keys of other kinds of source are dropped.
    - Of the known formats, only the chosen formats stay. Keys of a target choose it too, but if the command
      line chooses targets, keys in the robot's file do not.
    - A robot without a name gets a default name; the robot of an experiment is `<robot>_<experiment>`, unless
      the experiment or the command line gives a name.
    """
    resolved = copy.deepcopy(dict(tree))
    for group, preset in choices.presets.items():
        section = resolved.setdefault(group, {})
        if isinstance(section, dict):
            _reapply_preset(section, preset, group, choices)
    if "source" in choices.presets:
        _drop_other_sources(resolved, choices)
    _keep_chosen_formats(resolved, choices.multiple_choices["export"])
    _keep_chosen_targets(resolved, choices)
    if resolved.get("name") is None:
        resolved["name"] = default_robot_name(resolved.get("source"), choices.robot)
    if choices.experiments and not choices.sets("name"):
        resolved["name"] = "_".join([str(resolved["name"]), *map(_safe_name, choices.experiments)])
    return resolved


def _reapply_preset(section: dict[str, Any], preset: Mapping[str, Any], where: str, choices: Choices) -> None:
    """Sets the values of a chosen preset over those of the robot's file, except keys that the user set."""
    for name, value in preset.items():
        key = f"{where}.{name}"
        if isinstance(value, Mapping) and isinstance(section.get(name), dict):
            _reapply_preset(section[name], value, key, choices)
        elif value != UNSET and not choices.sets(key):
            section[name] = copy.deepcopy(value)


def _drop_other_sources(tree: dict[str, Any], choices: Choices) -> None:
    source = tree["source"]
    source_section = SOURCES.get(str(source.get("kind"))) if isinstance(source, dict) else None
    if source_section is None:
        return
    all_keys = {name for keys in SOURCES.values() for name in keys.model_fields}
    other_keys = all_keys - set(source_section.model_fields)
    tree["source"] = {
        name: value
        for name, value in source.items()
        if name not in other_keys or choices.touches(f"source.{name}")
    }


def _keep_chosen_formats(tree: dict[str, Any], chosen: Collection[str]) -> None:
    formats = tree.setdefault("export", {})
    if not isinstance(formats, dict):
        return
    for name in ExportSection.model_fields:
        if name not in chosen:
            formats.pop(name, None)
        else:
            formats.setdefault(name, {})


def _keep_chosen_targets(tree: dict[str, Any], choices: Choices) -> None:
    targets = tree.setdefault("target", {})
    if not isinstance(targets, dict):
        return
    for name in TargetSection.model_fields:
        if name in choices.multiple_choices["target"]:
            targets.setdefault(name, {})
        elif "target" in choices.explicit_groups and not choices.touches(f"target.{name}"):
            targets.pop(name, None)


def default_robot_name(source: Any, robot: str = "bare") -> str:
    """Returns the default name of a robot: from the robot's file, else the source's path, else the element
    id, else the robot of the gallery, else the kind of source."""
    if robot != "bare":
        return _safe_name(PurePath(robot).name)
    source = source if isinstance(source, dict) else {}
    if isinstance(source.get("path"), str):
        path = PurePath(source["path"])
        stem = path.stem.removesuffix(".urdf")
        # `scene` is a common name of a file around the robot, and linkwright writes its own scene.xml.
        return _safe_name((path.parent.name or "robot") if stem.lower() == "scene" else stem)
    element = re.search(r"/e/([0-9a-fA-F]{8})", str(source.get("url")))
    if element:
        return f"onshape_{element.group(1).lower()}"
    return _safe_name(str(source.get("robot") or source.get("kind", "robot")))


def _safe_name(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name) or "robot"
