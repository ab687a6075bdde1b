"""From a command line to plans: the only module that imports Hydra.

Hydra composes; the composed tree, as plain data, is judged by `Plan`. A single build never runs
under Hydra; a sweep runs under Hydra's own launcher once every job's plan is known to be good.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from hydra import compose, initialize_config_module
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException, MissingConfigException
from hydra.types import RunMode
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from pipeline.overrides import Override, read
from pipeline.plan import Plan
from pipeline.presets import GROUPS, SEVERAL, Presets, chosen
from pipeline.schema import key_of
from pipeline.settle import Choices, settle
from stages.robot.errors import ConfigError, Diagnostic

PRIMARY = "build"
DEFAULT_ROBOT = "sample"

FIXED = (
    "hydra.searchpath",
    "hydra.sweep.",
    "hydra.sweeper.params",
    "hydra/sweeper",
    "hydra.mode",
    "hydra.job.",
)
"""What of Hydra cannot be overridden: a sweep's jobs are known before it starts."""


@dataclass(frozen=True, slots=True)
class Composed:
    """A plan, the tree that it was parsed from, and the robot's option."""

    plan: Plan
    tree: dict[str, Any]
    robot: str


def compose_plan(
    arguments: Sequence[str], config_dirs: Iterable[str | Path] = (), cwd: Path | None = None
) -> Composed:
    """The plan of a single build; ConfigError lists everything that is wrong."""
    with session(config_dirs, cwd) as composer:
        return composer.compose([override.hydra for override in composer.read(arguments)])


@contextmanager
def session(config_dirs: Iterable[str | Path] = (), cwd: Path | None = None) -> Iterator["Composer"]:
    """Hydra, ready to compose from `conf`, `./robot/` of `cwd` and `config_dirs`."""
    presets = Presets(config_dirs, cwd)
    with initialize_config_module("conf", job_name="linkwright", version_base="1.3"):
        yield Composer(presets)


class Composer:
    """Composes plans while a `session` is open."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._parser = OverridesParser.create()
        folders = ",".join(_hydra_text(f"file://{folder}") for folder in presets.own)
        self._search = [f"hydra.searchpath=[{folders}]"] if presets.own else []

    def read(self, arguments: Sequence[str], multirun: bool = False) -> list[Override]:
        """The overrides of a command line; the sample where neither robot nor source is named."""
        overrides, problems = read(arguments, GROUPS, self._values, multirun)
        problems += [problem for override in overrides for problem in self._refused(override)]
        if problems:
            msg = "the command line cannot be used"
            raise ConfigError(msg, problems=problems, hint="linkwright --help shows what can be said")
        if not any(one.key in ("robot", "source") for one in overrides):
            typed = f"robot={DEFAULT_ROBOT}"
            overrides.insert(0, Override(typed, "robot", (DEFAULT_ROBOT,), typed))
        return overrides

    def compose(self, overrides: Sequence[str]) -> Composed:
        """The plan of overrides in Hydra's form, none of them swept."""
        everything = [*overrides, *self._search]
        try:
            config = compose(PRIMARY, everything, return_hydra_config=True)
            loader = GlobalHydra.instance().config_loader()
            defaults = loader.compute_defaults_list(PRIMARY, everything, RunMode.RUN).defaults
        except Exception as error:
            raise self._explained(error) from error
        robot = config.hydra.runtime.choices.get("robot") or "bare"
        ambiguous = self._presets.problem("robot", robot)
        problems = [ambiguous] if ambiguous else []
        tree = _plain(config, (), problems)
        tree.pop("hydra", None)
        paths = [default.config_path or "" for default in defaults]
        formats = tuple(path.removeprefix("export/") for path in paths if path.startswith("export/"))
        settled = settle(tree, self._choices(robot, formats, overrides))
        return Composed(Plan.parse(settled, problems), settled, robot)

    def jobs(self, overrides: Iterable[Override]) -> list[list[str]]:
        """The overrides of each job, as Hydra's own sweeper splits them and in its order."""
        parsed = self._parser.parse_overrides([override.hydra for override in overrides])
        return [list(job) for batch in BasicSweeper.split_arguments(parsed, None) for job in batch]

    def launch(self, overrides: Iterable[Override], task: Callable[[int], Any], folder: Path) -> list[Any]:
        """Runs `task(number)` for every job under Hydra's multirun; what each returned.

        `task` goes to other processes with some launchers, and must not raise.
        """
        hydra = GlobalHydra.instance().hydra
        assert hydra is not None
        place = f"hydra.sweep.dir={_hydra_text(str(folder))}"
        arguments = [*(override.hydra for override in overrides), *self._search, place]
        try:
            batches = hydra.multirun(PRIMARY, _Numbered(task), arguments)
        except (HydraException, OmegaConfBaseException, MissingConfigException) as error:
            raise self._explained(error) from error
        return [job.return_value for batch in batches for job in batch]

    def check_launcher(self, overrides: Iterable[Override]) -> None:
        """ConfigError where what concerns Hydra itself, the launcher say, cannot be composed."""
        arguments = [override.hydra for override in overrides if override.for_hydra_itself]
        hydra = GlobalHydra.instance().hydra
        assert hydra is not None
        try:
            hydra.compose_config(PRIMARY, arguments, RunMode.MULTIRUN, with_log_configuration=False)
        except Exception as error:
            raise self._explained(error) from error

    def _values(self, text: str) -> list[str]:
        try:
            override = self._parser.parse_override(text)
        except HydraException as error:
            raise ValueError(str(error).splitlines()[0]) from None
        if not override.is_sweep_override():
            return [override.get_value_element_as_str()]
        if not override.is_discrete_sweep():
            msg = "a sweep needs a list of values"
            raise ValueError(msg)
        return list(override.sweep_string_iterator())

    def _refused(self, override: Override) -> Iterator[Diagnostic]:
        if override.key.startswith(FIXED):
            hint = "--config-dir names folders of your own; the key `output` moves what is built"
            yield Diagnostic("E-OVERRIDE", "this part of Hydra is set by linkwright", override.typed, hint)
        if override.key not in GROUPS or override.hydra != override.typed:
            return
        for value in override.values:
            options = chosen(value)
            listed = value.startswith("[") and override.key in SEVERAL
            if not listed and (len(options) != 1 or value.startswith("[")):
                hint = f"options: {', '.join(self._presets.options(override.key))}"
                yield Diagnostic("E-OPTION", "one option is expected", override.typed, hint)
                continue
            problems = (self._presets.problem(override.key, option) for option in options)
            yield from (problem for problem in problems if problem)

    def _choices(self, robot: str, formats: tuple[str, ...], overrides: Sequence[str]) -> Choices:
        presets: dict[str, dict[str, Any]] = {}
        keys: set[str] = set()
        for text in overrides:
            key, _, value = text.lstrip("+~").partition("=")
            if key not in GROUPS or text.startswith("+"):
                keys.add(key)
            elif key != "robot" and key not in SEVERAL and not text.startswith("~"):
                file = self._presets.files(key, chosen(value)[0])[0]
                presets[key] = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
        return Choices(robot, formats, presets, frozenset(keys))

    def _explained(self, error: Exception) -> Exception:
        """A ConfigError for what Hydra could not compose; `error` itself where it is a fault."""
        if isinstance(error, yaml.MarkedYAMLError):
            mark = error.problem_mark or error.context_mark
            where = f"{mark.name}, line {mark.line + 1}, column {mark.column + 1}" if mark else ""
            msg = f"not valid YAML: {error.problem or error.context}"
            return ConfigError(msg, where, "check quotes, colons and indentation there")
        if isinstance(error, MissingConfigException) and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            if group == "hydra/launcher":
                msg = f"there is no launcher {option}"
                options = ", ".join(error.options or ())
                hint = f'launchers here: {options}; more come with pip install "linkwright[sweep]"'
                return ConfigError(msg, f"{group}={option}", hint)
            problem = self._presets.unknown(group, option)
            return ConfigError(problem.message, problem.where, problem.hint)
        if isinstance(error, UnicodeDecodeError):
            return ConfigError("not UTF-8 text", str(self._presets.not_utf8() or ""), "save it as UTF-8")
        if isinstance(error, HydraException | OmegaConfBaseException | ValueError):
            lines = [
                line for line in str(error).splitlines() if line.strip() and "append to your" not in line
            ]
            msg = f"the configuration cannot be composed: {' '.join(lines[:2])}"
            return ConfigError(msg, hint="look at the defaults list of the robot's file and at the overrides")
        if isinstance(error, OSError):
            msg = f"cannot be read: {error.strerror or error}"
            return ConfigError(msg, str(error.filename or ""))
        return error


class _Numbered:
    """Hydra's task: hands on the number of the job; its configuration is known already."""

    def __init__(self, task: Callable[[int], Any]) -> None:
        self._task = task

    def __call__(self, _: DictConfig) -> Any:
        return self._task(int(HydraConfig.get().job.num))


def _hydra_text(text: str) -> str:
    """`text` as a quoted value of Hydra's grammar."""
    escaped = text.replace("\\", "\\\\").replace("'", r"\'").replace("${", r"\${")
    return f"'{escaped}'"


def _plain(node: Any, place: tuple[int | str, ...], problems: list[Diagnostic]) -> Any:
    """The node as plain data, interpolations resolved; what is missing or cannot be resolved is a
    problem, and left out."""
    if isinstance(node, ListConfig):
        pairs: Iterable[tuple[Any, Any]] = enumerate(range(len(node)))
    elif isinstance(node, DictConfig):
        pairs = ((name, name) for name in list(node))
    else:
        return node
    found: dict[Any, Any] = {}
    for name, index in pairs:
        if name == "hydra" and not place:
            continue
        inner = (*place, name)
        try:
            if OmegaConf.is_missing(node, index):
                text = "must be given"
                problems.append(Diagnostic("E-MISSING", text, key_of(inner), _give(inner)))
                continue
            value = node[index]
        except OmegaConfBaseException as error:
            text = f"cannot be resolved: {str(error).splitlines()[0]}"
            problems.append(Diagnostic("E-VALUE", text, key_of(inner)))
            continue
        found[name] = _plain(value, inner, problems)
    return list(found.values()) if isinstance(node, ListConfig) else found


def _give(place: tuple[int | str, ...]) -> str:
    key = key_of(place)
    example = {"source.url": "https://cad.onshape.com/documents/...", "source.path": "arm.zip"}.get(
        key, "..."
    )
    return f"set it in the robot's file, or on the command line: \"{key}='{example}'\""
