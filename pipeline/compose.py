"""From a command line to plans: the only module that imports Hydra.

Hydra composes; the composed tree, as plain data, is judged by `Plan`. A single build never runs
under Hydra; a sweep runs under Hydra's own launcher once every job's plan is known to be good.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from hydra import compose, initialize_config_module
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Glob
from hydra.errors import HydraException, MissingConfigException
from hydra.types import RunMode
from omegaconf import DictConfig, ListConfig, OmegaConf, open_dict
from omegaconf.errors import OmegaConfBaseException

from pipeline.draft import Draft
from pipeline.errors import Diagnostic, refusal
from pipeline.interrupt import kept_from_workers
from pipeline.overrides import Override, read, refused
from pipeline.plan import Judge, Plan
from pipeline.presets import GROUPS, Presets, chosen, stand_in
from pipeline.problems import how_to_give
from pipeline.schema import key_of
from pipeline.settle import settle

PRIMARY = "build"
DEFAULT_ROBOT = "sample"

HEADER = "the first line of a robot's file must be: # @package _global_"


@dataclass(frozen=True, slots=True)
class Composed:
    """A plan, the tree that it was parsed from, and the robot's option."""

    plan: Plan
    tree: dict[str, Any]
    robot: str


def compose_plan(
    arguments: Sequence[str],
    config_dirs: Iterable[str | Path] = (),
    cwd: Path | None = None,
    judge: Judge | None = None,
) -> Composed:
    """The plan of a single build; ConfigError lists everything that is wrong.

    Where anything is wrong `judge` adds what it knows about the rest.
    """
    with session(config_dirs, cwd, judge) as composer:
        overrides, problems = composer.read(arguments)
        return composer.compose([override.hydra for override in overrides], problems)


@contextmanager
def session(
    config_dirs: Iterable[str | Path] = (), cwd: Path | None = None, judge: Judge | None = None
) -> Iterator["Composer"]:
    """Hydra, ready to compose from `conf`, `./robot/` of `cwd` and `config_dirs`."""
    presets = Presets(config_dirs, cwd)
    with initialize_config_module("conf", job_name="linkwright", version_base="1.3"):
        yield Composer(presets, judge)


class Composer:
    """Composes plans while a `session` is open."""

    def __init__(self, presets: Presets, judge: Judge | None = None) -> None:
        self._presets = presets
        self._judge = judge
        self._parser = OverridesParser.create()
        folders = ",".join(_hydra_text(f"file://{folder}") for folder in presets.own)
        self._search = [f"hydra.searchpath=[{folders}]"] if presets.own else []

    def read(
        self, arguments: Sequence[str], multirun: bool = False
    ) -> tuple[list[Override], list[Diagnostic]]:
        """The overrides of a command line, and what is wrong with the others.

        The sample, where neither robot nor source is named.
        """
        overrides, problems = read(arguments, GROUPS, self._values, multirun)
        problems += [problem for one in overrides if (problem := refused(one, multirun))]
        overrides = [one for one in overrides if not refused(one, multirun)]
        if not any(re.match(r"[+~]*(robot|source)(=|$)", argument) for argument in arguments):
            typed = f"robot={DEFAULT_ROBOT}"
            overrides.insert(0, Override(typed, "robot", (DEFAULT_ROBOT,), typed))
        return overrides, problems

    def compose(self, overrides: Sequence[str], known: Iterable[Diagnostic] = ()) -> Composed:
        """The plan of overrides in Hydra's form, none of them swept.

        ConfigError lists the `known` problems of the command line and everything else that is wrong:
        what cannot be composed is replaced by what `build` chooses, so that the rest is judged too.
        """
        good, bad = self._presets.judged(overrides)
        draft = Draft.of(known, bad)
        # What adds or deletes a key by force may not fit; what remains is judged without it.
        plain = [one for one in good if one.startswith("++") or one[0] not in "+~"]
        config, paths = self._whole(good, draft) or self._whole(plain, draft) or self._around(plain, draft)
        robot = config.hydra.runtime.choices.get("robot") or "bare"
        ambiguous = self._presets.problem("robot", robot)
        draft.problems += [ambiguous] if ambiguous else []
        unresolved: list[Diagnostic] = []
        tree = _plain(config, (), unresolved)
        draft.problems += [problem for problem in unresolved if not draft.unsure(problem)]
        tree.pop("hydra", None)
        formats = tuple(path.removeprefix("export/") for path in paths if path.startswith("export/"))
        settled = settle(tree, self._presets.choices(robot, formats, good))
        plan = Plan.parse(settled, draft.problems, unsure=draft.unsure, judge=self._judge)
        return Composed(plan, settled, robot)

    def _whole(self, overrides: Sequence[str], draft: "Draft") -> tuple[DictConfig, list[str]] | None:
        """The composed tree and the paths of its files; None where it cannot be composed so."""
        stand_ins: dict[str, str] = {}
        while True:
            everything = [*overrides, *stand_ins.values(), *self._search]
            try:
                config = compose(PRIMARY, everything, return_hydra_config=True)
                loader = GlobalHydra.instance().config_loader()
                defaults = loader.compute_defaults_list(PRIMARY, everything, RunMode.RUN).defaults
            except Exception as error:
                problem = self._explained(error)
                if problem is None:
                    raise
                draft.add(problem)
                missing = error.missing_cfg_file if isinstance(error, MissingConfigException) else None
                group = (missing or "").rpartition("/")[0]
                if group not in GROUPS or group == "robot" or group in stand_ins:
                    return None
                stand_ins[group] = f"{group}={stand_in(group)}"
                draft.without.add(group)
            else:
                return config, [default.config_path or "" for default in defaults]

    def _around(self, overrides: Sequence[str], draft: "Draft") -> tuple[DictConfig, list[str]]:
        """As `_whole`, with the robot's own keys, but without its defaults list, which is at fault."""
        robots = [one.partition("=")[2] for one in overrides if one.startswith("robot=")]
        own = self._presets.content("robot", chosen(robots[-1])[0]) if robots else {}
        own.pop("defaults", None)
        draft.without |= {"robot", "source"}
        others = [one for one in overrides if not one.startswith("robot=")]
        try:
            found = self._whole(["robot=bare", *others], draft) if robots else None
            if found is None:
                raise refusal(draft.problems)
            config, paths = found
            with open_dict(config):
                config.merge_with(own)
        except OmegaConfBaseException:
            raise refusal(draft.problems) from None
        return config, paths

    def jobs(self, overrides: Iterable[Override]) -> list[list[str]]:
        """The overrides of each job, as Hydra's own sweeper splits them and in its order."""
        wanted = [override.hydra for override in overrides if not override.for_hydra_itself]
        parsed = self._parser.parse_overrides(wanted)
        return [list(job) for batch in BasicSweeper.split_arguments(parsed, None) for job in batch]

    def launch(self, overrides: Sequence[Override], task: Callable[[int], Any], folder: Path) -> list[Any]:
        """Runs `task(number)` for every job under Hydra's multirun; what each returned.

        `task` goes to other processes with some launchers, and must not raise.
        """
        hydra = GlobalHydra.instance().hydra
        assert hydra is not None
        place = f"hydra.sweep.dir={_hydra_text(str(folder))}"
        arguments = [*(override.hydra for override in overrides), *self._search, place]
        alone = all("basic" in one.values for one in overrides if one.key == "hydra/launcher")
        try:
            with nullcontext() if alone else kept_from_workers():
                batches = hydra.multirun(PRIMARY, _Numbered(task), arguments)
        except (HydraException, OmegaConfBaseException, MissingConfigException) as error:
            problem = self._explained(error)
            if problem is None:
                raise
            raise refusal([problem]) from error
        return [job.return_value for batch in batches for job in batch]

    def check_launcher(self, overrides: Iterable[Override]) -> list[Diagnostic]:
        """What is wrong with what concerns Hydra itself, the launcher say."""
        arguments = [override.hydra for override in overrides if override.for_hydra_itself]
        hydra = GlobalHydra.instance().hydra
        assert hydra is not None
        try:
            hydra.compose_config(PRIMARY, arguments, RunMode.MULTIRUN, with_log_configuration=False)
        except Exception as error:
            problem = self._explained(error)
            if problem is None:
                raise
            return [problem]
        return []

    def _values(self, text: str) -> list[str]:
        try:
            override = self._parser.parse_override(text)
        except HydraException as error:
            raise ValueError(str(error).splitlines()[0]) from None
        if not override.is_sweep_override():
            return [override.get_value_element_as_str()]
        value: Any = override.value()
        if isinstance(value, Glob):
            group = override.key_or_group
            if group not in GROUPS:
                msg, hint = "glob() chooses among the options of a group", f"groups: {', '.join(GROUPS)}"
                raise ValueError(msg, hint)
            there = self._presets.options(group)
            options = value.filter(there)
            if not options:
                raise ValueError("no option matches", f"options: {', '.join(there)}")
            return [one if re.fullmatch(r"[\w/-]+", one) else _hydra_text(one) for one in options]
        if not override.is_discrete_sweep():
            msg = "a sweep needs a list of values"
            raise ValueError(msg)
        return list(override.sweep_string_iterator())

    def _explained(self, error: Exception) -> Diagnostic | None:
        """What the user did wrong where Hydra could not compose; None where it is a fault of ours."""
        if isinstance(error, yaml.MarkedYAMLError):
            mark = error.problem_mark or error.context_mark
            where = f"{mark.name}, line {mark.line + 1}, column {mark.column + 1}" if mark else ""
            text = f"not valid YAML: {error.problem or error.context}"
            return Diagnostic("E-YAML", text, where, "check quotes, colons and indentation there")
        if isinstance(error, MissingConfigException) and error.missing_cfg_file:
            group, _, option = error.missing_cfg_file.rpartition("/")
            if group == "hydra/launcher":
                options = ", ".join(error.options or ())
                hint = f'launchers here: {options}; more come with pip install "linkwright[sweep]"'
                return Diagnostic("E-OPTION", f"there is no launcher {option}", f"{group}={option}", hint)
            return self._presets.unknown(group, option)
        if isinstance(error, UnicodeDecodeError):
            file = str(self._presets.not_utf8() or "")
            return Diagnostic("E-YAML", "not UTF-8 text", file, "save it as UTF-8")
        if isinstance(error, HydraException | OmegaConfBaseException | ValueError):
            if "@robot." in str(error):
                return Diagnostic("E-KEY", "its file chooses options for itself alone", "robot", HEADER)
            lines = [
                line for line in str(error).splitlines() if line.strip() and "append to your" not in line
            ]
            text = f"cannot be composed: {' '.join(lines[:2])}"
            hint = "look at the defaults list of the robot's file and at the overrides"
            return Diagnostic("E-OVERRIDE", text, "", hint)
        if isinstance(error, OSError):
            return Diagnostic(
                "E-YAML", f"cannot be read: {error.strerror or error}", str(error.filename or "")
            )
        return None


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
                problems.append(Diagnostic("E-MISSING", text, key_of(inner), how_to_give(key_of(inner))))
                continue
            value = node[index]
        except OmegaConfBaseException as error:
            text = f"cannot be resolved: {str(error).splitlines()[0]}"
            problems.append(Diagnostic("E-VALUE", text, key_of(inner)))
            continue
        found[name] = _plain(value, inner, problems)
    return list(found.values()) if isinstance(node, ListConfig) else found
