"""Applies the user's choices to a composed tree: its source, formats and targets, and the robot's name."""

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
    """The chosen options of the group `experiment`."""
    presets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """The content of each option that the command line chose, by group."""
    keys: frozenset[str] = frozenset()
    """The full keys that the command line set, such as `mesh.visual.merge`."""
    explicit_groups: frozenset[str] = frozenset()
    """The groups in `multiple_choices` for which the command line chose options."""

    def sets(self, key: str) -> bool:
        """Tells whether the command line set this key or a mapping that contains it."""
        return any(key == set_key or key.startswith(f"{set_key}.") for set_key in self.keys)

    def sets_part_of(self, key: str) -> bool:
        """Tells whether the command line set this key, a key below it, or a mapping that contains it."""
        return self.sets(key) or any(set_key.startswith(f"{key}.") for set_key in self.keys)


def resolve_choices(tree: Mapping[str, Any], choices: Choices) -> dict[str, Any]:
    """Returns the composed tree in the form that the plan reads.

    - An option chosen on the command line overrides the values of the robot's file.
    - If the command line chooses the source, keys of other kinds of source are dropped.
    - Formats that are not chosen are dropped. A section below `target` chooses its target, but if the command
      line chooses targets, sections in the robot's file do not.
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


def _reapply_preset(section: dict[str, Any], preset: Mapping[str, Any], place: str, choices: Choices) -> None:
    """Overrides the section at the key `place` by a chosen preset, except keys that the command line set."""
    for name, value in preset.items():
        key = f"{place}.{name}"
        if isinstance(value, Mapping) and isinstance(section.get(name), dict):
            _reapply_preset(section[name], value, key, choices)
        elif value != UNSET and not choices.sets(key):
            section[name] = copy.deepcopy(value)


def _drop_other_sources(tree: dict[str, Any], choices: Choices) -> None:
    """Drops the keys that only other kinds of source have, except keys that the command line set."""
    source = tree["source"]
    chosen_section = SOURCES.get(str(source.get("kind"))) if isinstance(source, dict) else None
    if chosen_section is None:
        return
    all_keys = {name for section in SOURCES.values() for name in section.model_fields}
    other_keys = all_keys - set(chosen_section.model_fields)
    tree["source"] = {
        name: value
        for name, value in source.items()
        if name not in other_keys or choices.sets_part_of(f"source.{name}")
    }


def _keep_chosen_formats(tree: dict[str, Any], chosen_formats: Collection[str]) -> None:
    """Gives each chosen format a section, and drops the sections of the others. Unknown names stay: the plan
    reports them."""
    formats = tree.setdefault("export", {})
    if not isinstance(formats, dict):
        return
    for name in ExportSection.model_fields:
        if name not in chosen_formats:
            formats.pop(name, None)
        else:
            formats.setdefault(name, {})


def _keep_chosen_targets(tree: dict[str, Any], choices: Choices) -> None:
    """Gives each chosen target a section, and drops other sections if the command line chose targets."""
    targets = tree.setdefault("target", {})
    if not isinstance(targets, dict):
        return
    for name in TargetSection.model_fields:
        if name in choices.multiple_choices["target"]:
            targets.setdefault(name, {})
        elif "target" in choices.explicit_groups and not choices.sets_part_of(f"target.{name}"):
            targets.pop(name, None)


def default_robot_name(source: Any, robot: str = "bare") -> str:
    """Returns the default name of a robot. It is made from the name of the robot's file, else the source's
    path, else the element id, else the source's `robot` (a robot of the gallery), else the kind of source.

    `source`: the section `source`, not yet validated; `robot`: the option of the group `robot`.
    """
    # The option `bare` has no robot's file.
    if robot != "bare":
        return _safe_name(PurePath(robot).name)
    source = source if isinstance(source, dict) else {}
    if isinstance(source.get("path"), str):
        path = PurePath(source["path"])
        # `arm.urdf.xacro` has two suffixes.
        stem = path.stem.removesuffix(".urdf")
        # `scene` is a common name of a file around the robot, and Linkwright writes its own scene.xml.
        return _safe_name((path.parent.name or "robot") if stem.lower() == "scene" else stem)
    # Eight of the 24 digits of the id are enough to tell robots apart.
    element_match = re.search(r"/e/([0-9a-fA-F]{8})", str(source.get("url")))
    if element_match:
        return f"onshape_{element_match.group(1).lower()}"
    return _safe_name(str(source.get("robot") or source.get("kind", "robot")))


def _safe_name(name: str) -> str:
    """Returns a name that can be part of file names and of options."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", name) or "robot"
