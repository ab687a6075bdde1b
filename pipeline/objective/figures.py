"""Computes the figures of an objective for a robot from the graph stage."""

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright import Robot
from linkwright.pipeline.config.messages import nearest
from linkwright.pipeline.errors import ConfigError
from linkwright.stages.export import export
from linkwright.stages.formats.written import NO_SHAPES
from linkwright.stages.robot.motion.reach import reaches
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.validate.check_options import CheckOptions, known_payload
from linkwright.stages.validate.torque_share import torque_share

if TYPE_CHECKING:
    from linkwright.pipeline.config.objective_section import ObjectiveSection
    from linkwright.pipeline.config.plan import Plan
    from linkwright.stages.robot.model import robot as model

KEY = "objective.figure"


def figures(names: Sequence[str], robot: "model.Robot", plan: "Plan", robot_json: bytes) -> dict[str, float]:
    """Returns the figures that `ObjectiveSection` describes, by name, except `checks_failed`. `robot_json`:
    the content of robot.json. Raises ConfigError if the robot has no figure of that name."""
    values: dict[str, float] = {}
    for name in names:
        if name == "mass":
            values[name] = sum(link.inertial.mass for link in robot.links)
        elif name == "torque_margin":
            values[name] = _torque_margin(robot, plan)
        elif name == "reach" or name.startswith("reach."):
            values[name] = _reach(robot, name.partition(".")[2])
        else:
            values[name] = number_at(json.loads(robot_json), name)
    return values


def figures_of_function(
    function: Callable[..., Any], section: "ObjectiveSection", robot: "model.Robot"
) -> dict[str, float]:
    """Calls the user's own function; returns its numbers by its name, and several numbers by name and index.
    Raises ConfigError if the function fails."""
    try:
        result = function(Robot(robot), **section.args)
        numbers = [float(number) for number in (result if isinstance(result, list | tuple) else [result])]
        if not numbers:
            raise ValueError("it returned an empty list")
    except Exception as error:
        msg = f"{section.target} failed: {type(error).__name__}: {error}"
        hint = "it is called with a linkwright.Robot and with args, and returns a number or several"
        raise ConfigError(msg, "objective", hint) from error
    name = str(section.target).rpartition(".")[2]
    names = [name] if len(numbers) == 1 else [f"{name}.{index}" for index in range(len(numbers))]
    return dict(zip(names, numbers, strict=True))


def _reach(robot: "model.Robot", frame: str) -> float:
    """Returns the reach [m] of a frame, or without a frame the largest reach of all."""
    reach_of = reaches(robot)
    if frame and frame not in reach_of:
        msg = f"the robot has no frame {frame}"
        raise ConfigError(msg, KEY, nearest(frame, reach_of) or f"it has {name_list(reach_of)}")
    return reach_of[frame] if frame else max(reach_of.values())


def _torque_margin(robot: "model.Robot", plan: "Plan") -> float:
    """Returns the torque share of the check C-TORQUE. It is computed on an MJCF without shapes, which have no
    mass. Raises ConfigError if no joint with a limited force holds the robot."""
    mjcf_only = type(plan.export).model_validate({"mjcf": plan.export.mjcf or {}})
    keys = plan.model_copy(update={"export": mjcf_only, "elements": {}, "attributes": {}})
    exported = export(robot, NO_SHAPES, keys)
    options = CheckOptions(payload=known_payload(robot, plan.validate.payload))
    with tempfile.TemporaryDirectory() as folder:
        for path, data in exported.files.items():
            file = Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)
        share = torque_share(Path(folder), exported.written, options)
    if share is None:
        msg = "torque_margin: no joint with a limited force holds the robot"
        raise ConfigError(msg, KEY, "name motors, or give actuators.<glob>.force")
    return share


def number_at(tree: Mapping[str, Any], path: str) -> float:
    """Returns the number at a path of robot.json: names and, for lists, names or indices, with dots between
    them. Raises ConfigError without such a number."""
    value: Any = tree
    words = path.split(".")
    start = 0
    while start < len(words):
        entries = _entries(value)
        # A name may have dots.
        ends = [end for end in range(len(words), start, -1) if ".".join(words[start:end]) in entries]
        if not ends:
            msg = f"robot.json has no {path}"
            parent = ".".join(words[:start]) or "it"
            names = [name for name in entries if not name.isdecimal()] or list(entries)
            hint = nearest(words[start], names) or (f"{parent} has {name_list(names)}" if names else "")
            raise ConfigError(msg, KEY, hint)
        value = entries[".".join(words[start : ends[0]])]
        start = ends[0]
    if not isinstance(value, int | float) or isinstance(value, bool):
        msg = f"{path} of robot.json is not a number"
        raise ConfigError(msg, KEY, f"it is {json.dumps(value)[:60]}")
    return float(value)


def _entries(value: Any) -> Mapping[str, Any]:
    """Returns the entries of a mapping, by name, or of a list, by index and by name."""
    if isinstance(value, Mapping):
        return value
    if not isinstance(value, Sequence) or isinstance(value, str):
        return {}
    entries_by_name = {
        str(entry["name"]): entry for entry in value if isinstance(entry, Mapping) and "name" in entry
    }
    return {str(index): entry for index, entry in enumerate(value)} | entries_by_name
