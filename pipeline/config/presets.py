"""The YAML files that a configuration is composed from: ours in `conf`, and the user's own."""

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

SEVERAL = ("export",)
"""Groups of which several options are chosen at once."""

_PACKAGED = re.compile(r"(\s*#.*\n)*\s*#\s*@package\s+(?!_group_)\S")
"""The head of a file with its place in the tree."""


class Presets:
    """Options of groups, in `conf` and in the user's folders, which hold `robot/`."""

    def __init__(self, config_dirs: Iterable[str | Path] = (), cwd: Path | None = None) -> None:
        """ConfigError where one of `config_dirs` is not a folder. `./robot/` is included if it exists."""
        self._here, dirs = cwd or Path.cwd(), list(config_dirs)
        here = self._here
        folders = [here] if any(observed.is_folder(here / group) for group in ("robot", EXPERIMENT)) else []
        given = []
        self.options_typed = [text for named in dirs for text in ("--config-dir", str(named))]
        for named in dirs:
            folder = here / Path(named).expanduser()
            _check_place(folder, str(named))
            given.append(observed.real(folder))
        self.given = tuple(dict.fromkeys(folder for folder in given if folder != OURS))
        """The folders of `config_dirs`, whose launchers are trusted."""
        own = [*map(observed.real, folders), *given]
        self.own = tuple(dict.fromkeys(folder for folder in own if folder != OURS))

    def named(self, value: str) -> str | None:
        """The option of a robot's file, where `value` is its path: relative to `conf/robot`, so that Hydra
        finds it anywhere. Adds the folder of the file, or the parent of `robot/`, to the search path."""
        path = Path(value).expanduser()
        file = self._here / (path if path.suffix == ".yaml" else path.with_name(f"{path.name}.yaml"))
        by_path = path.suffix == ".yaml" or "/" in value
        if not by_path or (path.suffix != ".yaml" and self.files("robot", value)):
            return None
        if not observed.is_file(file):
            return None
        file = observed.real(file)
        place = file.parent.parent if file.parent.name == "robot" else file.parent
        self.own = tuple(dict.fromkeys([*self.own, place]))
        return Path(os.path.relpath(file.with_suffix(""), OURS.resolve() / "robot")).as_posix()

    def options(self, group: str) -> list[str]:
        """The options of a group, sorted."""
        found = set()
        for folder in (OURS, *self.own):
            for path in map(PurePath, observed.yaml_below(folder / group)):
                if not is_motor(folder / group / path, folder / group):
                    found.add(path.with_suffix("").as_posix())
        return sorted(found)

    def files(self, group: str, option: str) -> list[Path]:
        """The files of an option; more than one file is a conflict."""
        # The path of a robot's file is one from our own folder.
        bases = (OURS.resolve(),) if option.startswith("../") else (OURS, *self.own)
        inside = (OURS.resolve(), *self.own)
        found = [place for base in bases if (place := reach.place(base, f"{group}/{option}.yaml", inside))]
        if group == "actuators" and option.startswith(f"{MOTORS}/"):
            return []
        return [file for file in found if observed.is_file(file)]

    @property
    def with_motors(self) -> tuple[Path, ...]:
        """The folders that may hold motors: also where the user works, without a `robot/` there."""
        here = observed.real(self._here)
        return tuple(dict.fromkeys([*([here] if observed.is_folder(here / MOTORS) else []), *self.own]))

    def own_files(self, paths: Iterable[str]) -> list[Path]:
        """The files of a composed tree that are not ours, by their paths in the search path."""
        found = []
        for path in paths:
            name = f"{path.removesuffix('.yaml')}.yaml"
            files = [folder / name for folder in self.own if observed.is_file(folder / name)]
            ours = observed.real(OURS / name)
            if observed.is_file(ours) and not ours.is_relative_to(OURS.resolve()):
                files = [ours]
            elif not files and not observed.is_file(ours) and not path.startswith("hydra/"):
                files = [Path(path)]
            found += files
        return found

    def shared(self, files: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        """What the files set that several robots share: those of groups other than the robot and the
        experiment, and what robots of ours but the sample give to others. `files`: those of a composed tree,
        by their paths in the search path."""
        single = [path for path in files if path.partition("/")[0] in ("robot", EXPERIMENT)]
        strict = {"robot/sample", *(path for path in single if self.own_files([path]))}
        return [tree for path, tree in files.items() if isinstance(tree, Mapping) and path not in strict]

    def problem(self, group: str, option: str) -> Diagnostic | None:
        """The problem of a choice of an option, or None."""
        files = self.files(group, option)
        if len(files) > 1:
            text = f"ambiguous: {' and '.join(str(file) for file in files)}"
            return Diagnostic("E-OPTION", text, f"{group}={option}", "give your own file another name")
        return None if files else self.unknown(group, option)

    def judged(self, overrides: Iterable[str]) -> tuple[list[str], dict[str, list[Diagnostic]]]:
        """The overrides whose options exist, and the problems of the others, by group."""
        good, bad = [], {}
        for override in overrides:
            group, _, value = override.lstrip("+~").partition("=")
            chooses = group in GROUPS and not override.startswith(("++", "~")) and value[:1] != "{"
            problems = self._problems(group, value) if chooses else []
            if problems:
                bad[group] = problems
            else:
                good.append(override)
        return good, bad

    def _problems(self, group: str, value: str) -> list[Diagnostic]:
        options = chosen(value)
        listed = value.startswith("[") and group in SEVERAL
        if not listed and (len(options) != 1 or value.startswith("[")):
            hint = f"options: {', '.join(self.options(group))}"
            return [Diagnostic("E-OPTION", "expected one option", f"{group}={value}", hint)]
        return [found for option in options if (found := self.problem(group, option))]

    def content(self, group: str, option: str) -> dict[str, Any]:
        """The content of an option's file; {} where it cannot be read."""
        files = self.files(group, option)
        return content(files[0]) if files else {}

    def _section(self, group: str, option: str) -> dict[str, Any]:
        """The keys that an option sets in its group; {} where its file belongs elsewhere in the tree."""
        files = self.files(group, option)
        if not files or _PACKAGED.match(files[0].read_text(encoding="utf-8", errors="replace")):
            return {}
        return {key: value for key, value in content(files[0]).items() if key != "defaults"}

    def own_groups(self) -> list[str]:
        """The groups that exist only in the user's folders, such as `experiment`; sorted."""
        folders = {name for own in self.own for name in observed.folders_with_yaml(own)}
        return sorted(folders - {*GROUPS, "hydra", MOTORS})

    def choices(
        self, robot: str, formats: tuple[str, ...], overrides: Iterable[str], paths: Iterable[str] = ()
    ) -> Choices:
        """The choices of a tree that was composed of these valid overrides and of the files at `paths`; a
        choice of an experiment counts as a choice on the command line."""
        presets: dict[str, dict[str, Any]] = {}
        keys: set[str] = set()
        groups = self.own_groups()
        experiments = [path.partition("/")[2] for path in paths if path.startswith(f"{EXPERIMENT}/")]
        for file in self.own_files(path for path in paths if path.partition("/")[0] in groups):
            experiment = content(file)
            for group, option in _overridden(experiment.pop("defaults", None)):
                if group in GROUPS and group != "robot" and group not in SEVERAL:
                    presets[group] = self._section(group, option)
            keys |= {key_of(place) for place in ends(experiment)}
        for text in overrides:
            key, _, value = text.lstrip("+~").partition("=")
            if key not in GROUPS or text.startswith("+"):
                keys.add(key)
            elif key != "robot" and key not in SEVERAL and not text.startswith("~"):
                presets[key] = self._section(key, chosen(value)[0])
        return Choices(robot, formats, tuple(experiments), presets, frozenset(keys))

    def chosen_twice(self, files: Iterable[Path]) -> list[Diagnostic]:
        """The problems of files whose defaults lists override a group more than once."""
        found = []
        for file in files:
            options: dict[str, list[str]] = {}
            for group, option in _overridden(content(file).get("defaults")):
                options.setdefault(group, []).append(option)
            for group, several in options.items():
                if len(several) > 1:
                    msg = f"its defaults list overrides {group} more than once: {', '.join(several)}"
                    hint = f"keep one line, override /{group}: {several[-1]}"
                    found.append(Diagnostic("E-OPTION", msg, f"{file.parent.name}/{file.name}", hint))
        return found

    def unknown(self, group: str, option: str) -> Diagnostic:
        """The problem of an option without a file."""
        where = f"{group}={option}"
        if group != "robot" and not reach.is_plain(option):
            return reach.outside(option, where)
        options = self.options(group)
        if not options:
            hint = f"groups: {', '.join([*GROUPS, *self.own_groups()])}"
            return Diagnostic("E-OPTION", f"there is no folder {group}/", where, hint)
        hint = f"options: {', '.join(options)}"
        if group == "robot" and (option.endswith((".yaml", ".yml")) or "/" in option):
            if (self._here / option).is_file() and not option.endswith((".yaml", ".yml")):
                hint = "a URDF or an MJCF is a source: source=urdf source.path=arm.urdf"
                return Diagnostic("E-OPTION", "a robot's file is YAML: its name ends in .yaml", where, hint)
            return Diagnostic("E-OPTION", "there is no such file", where, self._near(option, options))
        near = nearest(option.removesuffix(".yaml").rpartition("/")[2], options)
        if near:
            hint = f"{near} {hint}"
        if group == "robot":
            places = " and ".join(str(folder / "robot") for folder in self.own)
            hint += f"; robots of your own: {places}" if places else "; robots of your own belong in ./robot/"
            misnamed = [file for folder in self.own for file in (folder / "robot").glob(f"{option}.yml")]
            if misnamed:
                hint = f"{misnamed[0]} must end in .yaml"
        return Diagnostic("E-OPTION", "there is no such option", where, hint)

    def _near(self, path: str, options: Iterable[str]) -> str:
        """Suggestions for the path of a robot's file that does not exist."""
        stem = Path(path).stem
        near = nearest(stem, options)
        other = (self._here / path).with_suffix(".yaml")
        if path.endswith(".yml") and (self._here / path).is_file():
            return f"rename it: mv {pasted.line([path, other.name])}"
        places = " and ".join(str(folder / "robot") for folder in self.own)
        return f"{near} paths start at {self._here}{f'; robots by name: {places}' if places else ''}".strip()

    def not_utf8(self) -> Path | None:
        """A file of the user's own that cannot be read as text."""
        for file in (file for folder in self.own for file in sorted((folder / "robot").rglob("*.yaml"))):
            try:
                yaml_file.text(file)
            except UnicodeDecodeError:
                return file
            except (OSError, yaml_file.RefusedError):
                continue
        return None


def content(file: Path) -> dict[str, Any]:
    """The content of a file; {} where it cannot be read."""
    try:
        read = yaml_file.read(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return {}
    return read if isinstance(read, dict) else {}


def _check_place(folder: Path, named: str) -> None:
    """ConfigError where a folder cannot be one of `--config-dir`, which holds `robot/` or other groups."""
    wanted = "name the folder that holds robot/, that is DIR of DIR/robot/my_arm.yaml"
    if not observed.is_folder(folder):
        msg = f"{named} is {'a file' if folder.exists() else 'not a folder'}"
        raise ConfigError(msg, "--config-dir", wanted)
    if observed.holds_yaml(folder):
        return
    if any(folder.glob("*.yaml")):
        msg = f"{named} contains YAML files, but no folder robot/"
        above = folder.resolve().parent
        if folder.resolve().name == "robot":
            wanted = f"name the folder above it: --config-dir {pasted.word(str(above))}"
        raise ConfigError(msg, "--config-dir", wanted)
    msg = f"{named} has no folder robot/ with a robot in it"
    raise ConfigError(msg, "--config-dir", wanted)


def _overridden(defaults: Any) -> Iterator[tuple[str, str]]:
    """Group and option of each override in a defaults list."""
    for entry in defaults if isinstance(defaults, list) else ():
        for key, option in entry.items() if isinstance(entry, dict) else ():
            sign, _, group = str(key).partition(" ")
            if sign == "override" and isinstance(option, str):
                yield group.strip().lstrip("/"), option


def ends(tree: Any, place: Place = ()) -> Iterator[Place]:
    """The places of all values below mappings."""
    if isinstance(tree, dict) and tree:
        for name, value in tree.items():
            yield from ends(value, (*place, str(name)))
    else:
        yield place


def stand_in(group: str) -> str:
    """The default option of a group in `build`; for the source, the sample."""
    defaults = yaml.safe_load((OURS / "build.yaml").read_text(encoding="utf-8"))["defaults"]
    options = {key: one for entry in defaults if isinstance(entry, dict) for key, one in entry.items()}
    option = options.get(group) or "sample"
    return f"[{','.join(option)}]" if isinstance(option, list) else str(option)


def chosen(value: str) -> Sequence[str]:
    """The options that the value of a group's override names: `hull`, `[urdf, mjcf]`."""
    text = value.strip()
    inside = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    options = (re.sub(r"\\(.)", r"\1", one).strip().strip("'\"") for one in inside.split(","))
    return [option for option in options if option]
