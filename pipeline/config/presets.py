"""Finds the YAML files that a configuration is composed from: in `conf`, and in the user's folders."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import yaml

import linkwright.conf
from linkwright.pipeline import observed
from linkwright.pipeline.config.choices import Choices
from linkwright.pipeline.config.files import reach, yaml_file
from linkwright.pipeline.config.messages import EXPERIMENT, nearest
from linkwright.pipeline.key_path import Place, key_of
from linkwright.pipeline.motor_files import FOLDER as MOTORS
from linkwright.pipeline.motor_files import is_motor
from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.errors import ConfigError, Diagnostic

OURS = Path(linkwright.conf.__file__).parent

GROUPS = tuple(sorted(folder.name for folder in OURS.iterdir() if any(folder.glob("*.yaml"))))
"""The groups that a robot chooses from, and `robot` itself."""

MULTIPLE_GROUPS = ("export", "target")
"""Groups of which several options can be chosen at once."""

_PACKAGE_HEADER = re.compile(r"(\s*#.*\n)*\s*#\s*@package\s+(?!_group_)\S")
"""The start of a file whose header names its place in the tree."""


class Presets:
    """The options of all groups, in `conf` and in the user's folders, which contain `robot/`."""

    def __init__(self, config_dirs: Iterable[str | Path] = (), cwd: Path | None = None) -> None:
        """Includes `./robot/` if it exists. Raises ConfigError if one of `config_dirs` is not a folder."""
        self._cwd, dirs = cwd or Path.cwd(), list(config_dirs)
        here = self._cwd
        folders = [here] if any(observed.is_folder(here / group) for group in ("robot", EXPERIMENT)) else []
        named_folders = []
        self.options_typed = [text for named in dirs for text in ("--config-dir", str(named))]
        for named in dirs:
            folder = here / Path(named).expanduser()
            _check_place(folder, str(named))
            named_folders.append(observed.real_path(folder))
        self.config_folders = tuple(dict.fromkeys(folder for folder in named_folders if folder != OURS))
        """The folders of `config_dirs`, whose launchers are trusted."""
        own = [*map(observed.real_path, folders), *named_folders]
        self.own = tuple(dict.fromkeys(folder for folder in own if folder != OURS))

    def option_of_path(self, value: str) -> str | None:
        """Returns the option of a robot's file if `value` is its path, relative to `conf/robot`, so that
        Hydra finds it anywhere. Adds the folder of the file, or the parent of `robot/`, to `own`."""
        path = Path(value).expanduser()
        file = self._cwd / (path if path.suffix == ".yaml" else path.with_name(f"{path.name}.yaml"))
        by_path = path.suffix == ".yaml" or "/" in value
        if not by_path or (path.suffix != ".yaml" and self.files("robot", value)):
            return None
        if not observed.is_file(file):
            return None
        file = observed.real_path(file)
        place = file.parent.parent if file.parent.name == "robot" else file.parent
        self.own = tuple(dict.fromkeys([*self.own, place]))
        return Path(os.path.relpath(file.with_suffix(""), OURS.resolve() / "robot")).as_posix()

    def options(self, group: str) -> list[str]:
        """Returns the options of a group, sorted."""
        names = set()
        for folder in (OURS, *self.own):
            for path in map(PurePath, observed.yaml_files_below(folder / group)):
                if not is_motor(folder / group / path, folder / group):
                    names.add(path.with_suffix("").as_posix())
        return sorted(names)

    def files(self, group: str, option: str) -> list[Path]:
        """Returns the files of an option; more than one file is a conflict."""
        # The path of a robot's file is one from our own folder.
        bases = (OURS.resolve(),) if option.startswith("../") else (OURS, *self.own)
        inside = (OURS.resolve(), *self.own)
        places = [place for base in bases if (place := reach.place(base, f"{group}/{option}.yaml", inside))]
        if group == "actuators" and option.startswith(f"{MOTORS}/"):
            return []
        return [file for file in places if observed.is_file(file)]

    @property
    def with_motors(self) -> tuple[Path, ...]:
        """The folders that may hold motors: also where the user works, without a `robot/` there."""
        here = observed.real_path(self._cwd)
        return tuple(dict.fromkeys([*([here] if observed.is_folder(here / MOTORS) else []), *self.own]))

    def own_files(self, paths: Iterable[str]) -> list[Path]:
        """Returns the user's own files among the `paths` in the search path of a composed tree."""
        own = []
        for path in paths:
            name = f"{path.removesuffix('.yaml')}.yaml"
            files = [folder / name for folder in self.own if observed.is_file(folder / name)]
            shipped_file = observed.real_path(OURS / name)
            if observed.is_file(shipped_file) and not shipped_file.is_relative_to(OURS.resolve()):
                files = [shipped_file]
            elif not files and not observed.is_file(shipped_file) and not path.startswith("hydra/"):
                files = [Path(path)]
            own += files
        return own

    def shared(self, files: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        """Returns the content of the files that several robots share: our bases of robots, and files of all
        groups except robot and experiment. `files`: path in the search path → content, of a composed tree."""
        bases = {path for path in ("robot/bare", "robot/legged") if not self.own_files([path])}
        own_paths = {path for path in files if path.partition("/")[0] in ("robot", EXPERIMENT)} - bases
        return [tree for path, tree in files.items() if isinstance(tree, Mapping) and path not in own_paths]

    def problem(self, group: str, option: str) -> Diagnostic | None:
        """Returns the problem of a choice of an option, or None."""
        files = self.files(group, option)
        if len(files) > 1:
            text = f"ambiguous: {' and '.join(map(str, files))}"
            return Diagnostic("E-OPTION", text, f"{group}={option}", "rename a file of your own")
        return None if files else self.unknown(group, option)

    def partition(self, overrides: Iterable[str]) -> tuple[list[str], dict[str, list[Diagnostic]]]:
        """Returns the overrides whose options exist, and the problems of the others, by group."""
        valid, problems_by_group = [], {}
        for override in overrides:
            group, _, value = override.lstrip("+~").partition("=")
            chooses = group in GROUPS and not override.startswith(("++", "~")) and value[:1] != "{"
            problems = self._problems(group, value) if chooses else []
            if problems:
                problems_by_group[group] = problems
            else:
                valid.append(override)
        return valid, problems_by_group

    def _problems(self, group: str, value: str) -> list[Diagnostic]:
        options = options_in(value)
        is_list = value.startswith("[") and group in MULTIPLE_GROUPS
        if not is_list and (len(options) != 1 or value.startswith("[")):
            hint = f"options: {', '.join(self.options(group))}"
            return [Diagnostic("E-OPTION", "expected one option", f"{group}={value}", hint)]
        return [problem for option in options if (problem := self.problem(group, option))]

    def content(self, group: str, option: str) -> dict[str, Any]:
        """Returns the content of an option's file; {} if it cannot be read."""
        files = self.files(group, option)
        return content(files[0]) if files else {}

    def _section(self, group: str, option: str) -> dict[str, Any]:
        """Returns the keys that an option sets in its group; {} if its file belongs elsewhere in the tree."""
        files = self.files(group, option)
        if not files or _PACKAGE_HEADER.match(files[0].read_text(encoding="utf-8", errors="replace")):
            return {}
        return {key: value for key, value in content(files[0]).items() if key != "defaults"}

    def own_groups(self) -> list[str]:
        """Returns the groups that exist only in the user's folders, such as `experiment`; sorted."""
        folders = {name for own in self.own for name in observed.folders_with_yaml(own)}
        return sorted(folders - {*GROUPS, "hydra", MOTORS})

    def choices(self, robot: str, overrides: Iterable[str], paths: Iterable[str] = ()) -> Choices:
        """Returns the choices of a tree that was composed of valid overrides and of the files at `paths`. A
        choice of an experiment counts as a choice on the command line."""
        presets: dict[str, dict[str, Any]] = {}
        keys: set[str] = set()
        explicit_groups: set[str] = set()
        several = {group: tuple(_options_among(group, paths)) for group in MULTIPLE_GROUPS}
        groups = self.own_groups()
        experiments = [path.partition("/")[2] for path in paths if path.startswith(f"{EXPERIMENT}/")]
        for file in self.own_files(path for path in paths if path.partition("/")[0] in groups):
            experiment = content(file)
            for group, option in _overridden(experiment.pop("defaults", None)):
                if group in MULTIPLE_GROUPS:
                    explicit_groups.add(group)
                elif group in GROUPS and group != "robot":
                    presets[group] = self._section(group, option)
            keys |= {key_of(place) for place in leaf_places(experiment)}
        for text in overrides:
            key, _, value = text.lstrip("+~").partition("=")
            if key not in GROUPS or text.startswith("+"):
                keys.add(key)
            elif key in MULTIPLE_GROUPS:
                explicit_groups.add(key)
            elif key != "robot" and not text.startswith("~"):
                presets[key] = self._section(key, options_in(value)[0])
        sets = frozenset(keys), frozenset(explicit_groups)
        return Choices(robot, several, tuple(experiments), presets, *sets)

    def chosen_twice(self, files: Iterable[Path]) -> list[Diagnostic]:
        """Returns the problems of files whose defaults lists override a group more than once."""
        problems = []
        for file in files:
            options: dict[str, list[str]] = {}
            for group, option in _overridden(content(file).get("defaults")):
                options.setdefault(group, []).append(option)
            for group, several in options.items():
                if len(several) > 1:
                    msg = f"its defaults list overrides {group} more than once: {', '.join(several)}"
                    hint = f"keep one line, override /{group}: {several[-1]}"
                    problems.append(Diagnostic("E-OPTION", msg, f"{file.parent.name}/{file.name}", hint))
        return problems

    def unknown(self, group: str, option: str) -> Diagnostic:
        """Returns the problem of an option without a file."""
        where = f"{group}={option}"
        if group != "robot" and not reach.is_inside(option):
            return reach.outside_problem(option, where)
        options = self.options(group)
        if not options:
            hint = f"groups: {', '.join([*GROUPS, *self.own_groups()])}"
            if (name := group.removeprefix("robot/")) in GROUPS:
                hint = f"in a robot's defaults list write: - override /{name}: {option}"
            return Diagnostic("E-OPTION", f"there is no folder {group}/", where, hint)
        noun = "robot" if group == "robot" else "option"
        hint, is_yaml = f"{noun}s: {', '.join(options)}", option.endswith((".yaml", ".yml"))
        if group == "robot" and (is_yaml or "/" in option):
            if (self._cwd / option).is_file() and not is_yaml:
                hint = "a URDF or an MJCF is a source: source=urdf source.path=arm.urdf"
                return Diagnostic("E-OPTION", "a robot's file is YAML: its name ends in .yaml", where, hint)
            return Diagnostic("E-OPTION", "there is no such file", where, self._path_hint(option, options))
        hint = f"{nearest(option.removesuffix('.yaml').rpartition('/')[2], options)} {hint}".lstrip()
        if group == "robot":
            places = " and ".join(str(folder / "robot") for folder in self.own)
            hint += f"; your own: {places}" if places else f"; there is no folder {self._cwd}/robot"
            misnamed = [file for folder in self.own for file in (folder / "robot").glob(f"{option}.yml")]
            if misnamed:
                hint = f"{misnamed[0]} must end in .yaml"
        return Diagnostic("E-OPTION", f"there is no such {noun}", where, hint)

    def _path_hint(self, path: str, options: Iterable[str]) -> str:
        """Returns a hint for the path of a robot's file that does not exist."""
        suggestion = nearest(Path(path).stem, options)
        other = (self._cwd / path).with_suffix(".yaml")
        if path.endswith(".yml") and (self._cwd / path).is_file():
            return f"rename it: mv {pasted.line([path, other.name])}"
        places = " and ".join(str(folder / "robot") for folder in self.own)
        named_robots = f"; robots by name: {places}" if places else ""
        return f"{suggestion} paths start at {self._cwd}{named_robots}".strip()

    def not_utf8(self) -> Path | None:
        """Returns a file of the user's own that cannot be read as text."""
        for file in (file for folder in self.own for file in sorted((folder / "robot").rglob("*.yaml"))):
            try:
                yaml_file.text(file)
            except UnicodeDecodeError:
                return file
            except (OSError, yaml_file.RefusedError):
                continue
        return None


def content(file: Path) -> dict[str, Any]:
    """Returns the content of a file; {} if it cannot be read."""
    try:
        tree = yaml_file.read(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return {}
    return tree if isinstance(tree, dict) else {}


def _options_among(group: str, paths: Iterable[str]) -> Iterator[str]:
    """Returns the options of a group among the files of a composed tree."""
    return (path.removeprefix(f"{group}/") for path in paths if path.startswith(f"{group}/"))


def _check_place(folder: Path, named: str) -> None:
    """Raises ConfigError unless a folder can be a `--config-dir`: it must hold `robot/` or other groups."""
    hint = "name the folder that holds robot/, that is DIR of DIR/robot/my_arm.yaml"
    if not observed.is_folder(folder):
        msg = f"{named} is {'a file' if folder.exists() else 'not a folder'}"
        raise ConfigError(msg, "--config-dir", hint)
    if observed.has_yaml_in_subfolders(folder):
        return
    if any(folder.glob("*.yaml")):
        msg = f"{named} contains YAML files, but no folder robot/"
        above = folder.resolve().parent
        if folder.resolve().name == "robot":
            hint = f"name the folder above it: --config-dir {pasted.word(str(above))}"
        raise ConfigError(msg, "--config-dir", hint)
    msg = f"{named} has no folder robot/ with a robot in it"
    raise ConfigError(msg, "--config-dir", hint)


def _overridden(defaults: Any) -> Iterator[tuple[str, str]]:
    """Yields group and option of each override in a defaults list."""
    for entry in defaults if isinstance(defaults, list) else ():
        for key, option in entry.items() if isinstance(entry, dict) else ():
            sign, _, group = str(key).partition(" ")
            if sign == "override" and isinstance(option, str | list):
                text = option if isinstance(option, str) else f"[{', '.join(map(str, option))}]"
                yield group.strip().lstrip("/"), text


def leaf_places(tree: Any, place: Place = ()) -> Iterator[Place]:
    """Yields the places of all values below mappings."""
    if isinstance(tree, dict) and tree:
        for name, value in tree.items():
            yield from leaf_places(value, (*place, str(name)))
    else:
        yield place


def default_option(group: str) -> str:
    """Returns the default option of a group in `build`; for the source, the sample."""
    defaults = yaml.safe_load((OURS / "build.yaml").read_text(encoding="utf-8"))["defaults"]
    options = {key: option for entry in defaults if isinstance(entry, dict) for key, option in entry.items()}
    option = options.get(group) or "sample"
    return f"[{','.join(option)}]" if isinstance(option, list) else str(option)


def options_in(value: str) -> Sequence[str]:
    """Returns the options that the value of a group's override names: `hull`, `[urdf, mjcf]`."""
    text = value.strip()
    inside = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    options = (re.sub(r"\\(.)", r"\1", word).strip().strip("'\"") for word in inside.split(","))
    return [option for option in options if option]
