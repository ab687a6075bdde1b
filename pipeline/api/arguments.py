"""Composes a plan from the arguments of `linkwright.build`, as from a command line."""

import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import RLock
from typing import Any

import yaml

from linkwright.pipeline.config.choices import default_robot_name
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.files.trust import TRUST_CODE
from linkwright.pipeline.config.hydra.node import quote_text
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError, Diagnostic, refusal
from linkwright.pipeline.run.preflight import plan_problems

HEADER = "# @package _global_\n"

_DATA_TEXT = "the robot's data"
"""Text that replaces the path of the temporary file in messages."""

TRUST_ARGUMENTS = {"source.trust": "trust=True", "plugins": "plugins=[...]", "output": "output=..."}
"""Keys that a robot's file may not set, or only within limits → the argument of `build` that sets them."""

_HYDRA_LOCK = RLock()
"""Hydra composes for one thread at a time."""


def plan_of(
    arguments: Sequence[str | os.PathLike[str] | Mapping[str, Any]],
    trust: bool,
    plugins: Sequence[str],
    output: str | os.PathLike[str] | None,
    config_dirs: Sequence[str | os.PathLike[str]],
) -> Plan:
    """Returns the plan that the arguments of `build` describe; raises ConfigError with all problems."""
    robots = [argument for argument in arguments if is_robot(argument)]
    if len(robots) > 1:
        names = " and ".join("a mapping" if isinstance(robot, Mapping) else str(robot) for robot in robots)
        raise ConfigError(f"one robot is built at a time, got {names}", "", "call build once for each")
    overrides = [str(argument) for argument in arguments if not is_robot(argument)]
    robot_override = next((text for text in overrides if text.lstrip("+").startswith("robot=")), None)
    if robots and robot_override:
        names = "a mapping" if isinstance(robots[0], Mapping) else str(robots[0])
        hint = (
            f"leave one out, or begin with the other: defaults: [/robot/{robot_override.partition('=')[2]}]"
        )
        raise ConfigError(f"one robot is built at a time, got {names} and {robot_override}", "", hint)
    overrides += ["source.trust=true"] if trust else []
    overrides += [f"plugins=[{','.join(map(quote_text, plugins))}]"] if plugins else []
    overrides += [f"output={quote_text(os.fspath(output))}"] if output is not None else []
    folders = [os.fspath(folder) for folder in config_dirs]
    robot = robots[0] if robots else None
    if isinstance(robot, Mapping) and output is None and _names_a_folder(robot.get("output")):
        # The caller may name any folder, as on the command line.
        overrides.insert(0, f"output={quote_text(os.fspath(robot['output']))}")
    with _HYDRA_LOCK, robot_file(robot) as file:
        overrides = [*([f"robot={file}"] if file else []), *overrides]
        try:
            addresses = _assembly_addresses(robot)
            return compose_plan(overrides, folders, judge=plan_problems, addresses=addresses).plan
        except ConfigError as error:
            if not error.problems:
                raise
            problems = [_with_python_hint(problem) for problem in error.problems]
            if isinstance(robot, Mapping):
                problems = [_without_path(problem, Path(file)) for problem in problems]
            raise refusal(problems) from None


def _names_a_folder(output: Any) -> bool:
    """Tells whether a robot's `output` names a folder without an interpolation."""
    return isinstance(output, str | os.PathLike) and "${" not in str(output)


def is_robot(argument: object) -> bool:
    """Tells whether an argument is a robot (data or the path of a file), not an override."""
    if isinstance(argument, str):
        return "=" not in argument and argument.endswith((".yaml", ".yml"))
    return isinstance(argument, Mapping | os.PathLike)


def _assembly_addresses(robot: Any) -> list[str]:
    """Returns the assembly's address in a robot given as data, else []: the caller, not a file, names it."""
    source = robot.get("source") if isinstance(robot, Mapping) else None
    address = source.get("url") if isinstance(source, Mapping) else None
    return [address] if isinstance(address, str) else []


@contextmanager
def robot_file(robot: Any) -> Iterator[str]:
    """Yields the path of a robot's file, or "" without a robot. Data is written to a temporary file, so that
    it is read, and trusted, like any file."""
    if not isinstance(robot, Mapping):
        yield "" if robot is None else os.fspath(robot)
        return
    data = as_data(robot)
    name = data.get("name") or default_robot_name(data.get("source"))
    stem = name if isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_-]+", name) else "robot"
    with tempfile.TemporaryDirectory(prefix="linkwright-") as folder:
        file = Path(folder) / "robot" / f"{stem}.yaml"
        file.parent.mkdir()
        text = yaml.dump(data, Dumper=_QuotingDumper, sort_keys=False, allow_unicode=True)
        file.write_text(HEADER + text, encoding="utf-8")
        yield str(file)


class _QuotingDumper(yaml.SafeDumper):  # type: ignore[misc]
    """Writes all texts in quotes, since YAML parsers differ about `1e5` or `on` without them."""


_QuotingDumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)


def as_data(value: Any, key: str = "") -> Any:
    """Converts a robot's data to types that YAML has: numpy arrays become lists, numpy numbers become
    numbers, and paths become texts. Raises ConfigError for other types."""
    if isinstance(value, Mapping):
        return {str(name): as_data(entry, f"{key}.{name}".lstrip(".")) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [as_data(entry, f"{key}[{index}]") for index, entry in enumerate(value)]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return as_data(value.tolist(), key)
    if value is None or type(value) in (str, int, float, bool):
        return value
    message = f"a robot is data: texts, numbers, lists and mappings; got {type(value).__name__}"
    raise refusal([Diagnostic("E-VALUE", message, key)])


def _with_python_hint(problem: Diagnostic) -> Diagnostic:
    """Returns the problem; if an argument of `build` allows the key, with a hint that names it."""
    if problem.code != TRUST_CODE or problem.where not in TRUST_ARGUMENTS:
        return problem
    return replace(problem, hint=f"if you trust it: linkwright.build(..., {TRUST_ARGUMENTS[problem.where]})")


def _without_path(problem: Diagnostic, file: Path) -> Diagnostic:
    """Returns a problem of a robot given as data, without the path of its temporary file."""
    name = re.escape(f"{file.parent.name}/{file.stem}")
    path = re.compile(rf"[^\s'\"]*{re.escape(file.parent.parent.name)}/{name}(\.yaml)?|\b{name}\.yaml")
    texts = (path.sub(_DATA_TEXT, text) for text in (problem.message, problem.where, problem.hint))
    return Diagnostic(problem.code, *texts)
