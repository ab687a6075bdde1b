"""Composes plans from a command line.

Hydra composes; `Plan` validates the composed tree as plain data. A single build never runs under Hydra;
a sweep runs under Hydra's launcher after every job's plan is validated.
"""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from warnings import catch_warnings, filterwarnings

from hydra import __version__, initialize_config_module
from hydra.core.global_hydra import GlobalHydra
from hydra.errors import MissingConfigException
from hydra.types import RunMode
from omegaconf import DictConfig, open_dict
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config import interpolated
from linkwright.pipeline.config.choices import resolve_choices
from linkwright.pipeline.config.files import hosts, trust
from linkwright.pipeline.config.files.places import OUTPUT, SWEEP_DIR, folder_problems
from linkwright.pipeline.config.hydra.errors import composition_problem
from linkwright.pipeline.config.hydra.files import guarded_reading
from linkwright.pipeline.config.hydra.loader import PRIMARY, composed, set_aside, speed_up, use_loader
from linkwright.pipeline.config.hydra.node import HydraSettings, JobIdentity, quote_text, search_path_override
from linkwright.pipeline.config.hydra.reading import Reading
from linkwright.pipeline.config.messages import with_example
from linkwright.pipeline.config.optional import add_optional
from linkwright.pipeline.config.overrides import Override, hydra_problem, read
from linkwright.pipeline.config.partial import Draft
from linkwright.pipeline.config.plain import plain
from linkwright.pipeline.config.plan import Judge, Plan
from linkwright.pipeline.config.presets import GROUPS, Presets, content, default_option, options_in
from linkwright.pipeline.errors import ConfigError, Diagnostic, refusal
from linkwright.pipeline.key_path import Place
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.terminal import pasted

DEFAULT_ROBOT = "robot=sample"

_ROBOT_CHOICE = re.compile(r"[+~]*(robot|source)(=|$)")

_COMMAND_LINE_KEYS = (*trust.SAFE_VALUES, OUTPUT)  # files may set these only to some values
HYDRA_ARGUMENTS: Mapping[str, str] = {"version_base": "1.3"} if __version__.startswith("1.3.") else {}
"""Arguments that give Hydra its current defaults: 1.3 needs `version_base`, and 1.4 warns about it."""


@dataclass(frozen=True, slots=True)
class Composed:
    """A plan, and the composed tree behind it."""

    plan: Plan
    tree: dict[str, Any]  # the plain data from which the plan was parsed
    robot: str  # the option of the group `robot`
    sweeping: trust.SweepSettings  # as files set it
    config: DictConfig  # the tree as Hydra composed it
    computed: Collection[Place]  # the places of interpolations in the tree


@dataclass(frozen=True, slots=True)
class SweepRequest:
    """A requested sweep."""

    overrides: Sequence[Override]
    problems: Sequence[Diagnostic]  # of invalid overrides
    tree: DictConfig | None = None  # where all jobs start; None if it cannot be composed
    sweeping: trust.SweepSettings = field(default_factory=trust.SweepSettings)


def compose_plan(
    arguments: Sequence[str],
    config_dirs: Iterable[str | Path] = (),
    cwd: Path | None = None,
    judge: Judge | None = None,
    environ: Mapping[str, str] = os.environ,
    addresses: Iterable[str] = (),
) -> Composed:
    """Returns the plan of a single build, with its tree; raises a ConfigError that lists all problems.

    If there is any problem, `judge` adds the problems that it finds in the valid rest. `addresses`: values of
    `source.url` that the caller gives besides the arguments.
    """
    with session(config_dirs, cwd, judge, environ) as composer:
        composer.addresses |= {*addresses}
        overrides, problems = composer.read(arguments)
        return composer.compose([override.hydra for override in overrides], problems)


@contextmanager
def session(
    config_dirs: Iterable[str | Path] = (),
    cwd: Path | None = None,
    judge: Judge | None = None,
    environ: Mapping[str, str] = os.environ,
) -> Iterator["Composer"]:
    """Sets up Hydra to compose from `conf`, `./robot/` of `cwd` and `config_dirs`, and yields a composer."""
    presets = Presets(config_dirs, cwd)
    with (
        set_aside(),
        initialize_config_module("linkwright.conf", job_name="linkwright", **HYDRA_ARGUMENTS),
        guarded_reading(),
        speed_up(),
        catch_warnings(),
    ):
        # Hydra's advice to program authors, for example about a file with the name of a launcher.
        filterwarnings("ignore", message=r"\s*'hydra/launcher/", category=UserWarning)
        use_loader()
        yield Composer(presets, judge, environ, cwd)


class Composer:
    """Composes plans while a `session` is open."""

    def __init__(
        self,
        presets: Presets,
        judge: Judge | None = None,
        environ: Mapping[str, str] = os.environ,
        cwd: Path | None = None,
    ) -> None:
        self._presets = presets
        self._judge = judge
        self._environ = environ
        self._secrets = Secrets(environ, cwd)
        self.reading = Reading(presets)
        self._hydra = HydraSettings(presets)
        self.addresses: set[str] = set()
        """The addresses of assemblies that the user gave, not a file."""
        self._typed = ["linkwright"]
        self._arguments: list[str] = []

    def read(
        self, arguments: Sequence[str], multirun: bool = False
    ) -> tuple[list[Override], list[Diagnostic]]:
        """Returns the overrides of a command line, and the problems of invalid arguments."""
        clean, leaks = self._secrets.split_arguments(arguments)
        self._typed = ["linkwright", *["-m"] * multirun, *self._presets.options_typed, *clean]
        paths = [self._with_robot_option(argument) for argument in clean]
        overrides, problems = read(paths, GROUPS, self.reading.values, multirun, self._presets.own_groups())
        overrides = [replace(override, typed=clean[paths.index(override.typed)]) for override in overrides]
        problems += leaks
        problems += [problem for override in overrides if (problem := hydra_problem(override, multirun))]
        overrides = [override for override in overrides if not hydra_problem(override, multirun)]
        problems += self._hydra.accept_overrides(overrides, self._typed)
        self.addresses |= self.reading.addresses(overrides)
        return overrides, problems

    def _with_robot_option(self, argument: str) -> str:
        """Replaces the paths in `robot=PATH` by their options; returns other arguments unchanged."""
        sign, _, value = argument.partition("robot=")
        if sign.strip("+") or not value or value[0] in "[{":
            return argument
        words = [word.strip().strip("'\"") for word in value.split(",")]
        options = [self._presets.option_of_path(word) for word in words]
        if not any(options):
            return argument
        texts = [quote_text(option) if option else word for option, word in zip(options, words, strict=True)]
        return f"{sign}robot={','.join(texts)}"

    def compose(
        self, overrides: Sequence[str], earlier: Iterable[Diagnostic] = (), job: JobIdentity | None = None
    ) -> Composed:
        """Returns the plan of overrides in Hydra's form; `job`: number and label of a sweep's job.
        The sample is built if neither the command line nor a defaults list chooses a robot or a source.
        Raises a ConfigError that lists all problems; the `earlier` are those of the command line. An option
        that cannot be composed is replaced by the default of `build`, so that the rest is validated too.
        """
        valid, invalid = self._presets.partition(overrides)
        draft = Draft.of(earlier, invalid)
        # An override that adds or deletes a key may fail; the rest is validated without it.
        safe = [override for override in valid if override.startswith("++") or override[0] not in "+~"]
        # Only a choice of an option can add a defaults list, and only files of the user choose a robot
        # there.
        chooses_robot = any(map(_ROBOT_CHOICE.match, overrides))
        lists_may_choose = self._presets.own and any(not override.startswith("++") for override in valid)
        composition = self._compose(valid, draft) if chooses_robot or lists_may_choose else None
        if not chooses_robot and (composition is None or lacks_a_robot(composition[0])):
            valid, safe = [DEFAULT_ROBOT, *valid], [DEFAULT_ROBOT, *safe]
            composition = self._compose(valid, draft)
        config, tree_files = composition or self._compose(safe, draft) or self._compose_rest(safe, draft)
        robot = config.hydra.runtime.choices.get("robot") or "bare"
        ambiguous = self._presets.problem("robot", robot)
        draft.problems += [ambiguous] if ambiguous else []
        unresolved: list[Diagnostic] = []
        computed: set[Place] = set()
        tree = plain(config, (), unresolved, computed)
        kind = str((tree.get("source") or {}).get("kind", "")) if isinstance(tree.get("source"), dict) else ""
        unresolved = [with_example(problem, kind) for problem in unresolved]
        draft.problems += [problem for problem in unresolved if not draft.is_unsure(problem)]
        draft.problems += self._leaks(config, tree)
        tree = self._secrets.within(tree)
        resolved = resolve_choices(tree, self._presets.choices(robot, valid, tree_files))
        interpolated.convert_texts(resolved, computed)
        add_optional(resolved, self._presets.shared(tree_files))
        sweeping = self._hydra.sweep_settings(config, draft, resolved.get("name"), job)
        for problem in self._params(sweeping.params)[1]:
            draft.add(problem)
        files, command = self._presets.own_files(tree_files), pasted.line(self._typed)
        draft.problems += trust.forbidden_target_problems(resolved, command)
        places = {problem.where for problem in draft.problems}
        overridden = trust.overridden_group_problems(map(content, files))
        draft.problems += [problem for problem in overridden if problem.where not in places]
        draft.problems += self._presets.chosen_twice(files)
        draft.problems += hosts.host_problems(resolved, self.addresses, self._environ)
        typed = self._hydra.typed_keys([SWEEP_DIR]) | self.reading.typed_keys(valid, _COMMAND_LINE_KEYS)
        distrusted = trust.trust_problems(resolved, typed, files, self._environ, command)
        draft.problems += distrusted
        if any(problem.where == "plugins" for problem in distrusted):
            # The judge of the rest imports plug-ins.
            resolved["plugins"] = []
        own_places = {OUTPUT: resolved.get(OUTPUT), SWEEP_DIR: sweeping.dir}
        draft.problems += folder_problems(own_places, config, typed, files, self._environ, command)
        folders, judge = self._presets.with_motors, self._judge
        plan = Plan.parse(resolved, draft.problems, is_unsure=draft.is_unsure, judge=judge, folders=folders)
        return Composed(plan, resolved, robot, sweeping, config, computed)

    def _leaks(self, config: DictConfig, tree: dict[str, Any]) -> list[Diagnostic]:
        """Returns a problem for each key of a composed configuration, and of Hydra's, with a secret in it."""
        if not self._secrets:
            return []
        hydra = plain(config.hydra, ("hydra",), [])
        # These hold the environment, and the command line, which was checked before.
        hydra |= {"runtime": {}, "overrides": {}, "job": {**hydra["job"], "override_dirname": ""}}
        return self._secrets.problems({**tree, "hydra": hydra})

    def _compose(self, overrides: Sequence[str], draft: Draft) -> tuple[DictConfig, Mapping[str, Any]] | None:
        """Composes a tree; returns it with its files by their paths, or None if composition fails."""
        stand_ins: dict[str, str] = {}
        own_folders = search_path_override(self._presets.own)
        while True:
            arguments = [*overrides, *stand_ins.values(), *self._hydra.typed_overrides, *own_folders]
            try:
                config, files = composed(arguments)
            except Exception as error:
                draft.add(composition_problem(error, self._presets))
                missing = error.missing_cfg_file if isinstance(error, MissingConfigException) else None
                group = (missing or "").rpartition("/")[0]
                if group not in GROUPS or group == "robot" or group in stand_ins:
                    return None
                stand_ins[group] = f"{group}={default_option(group)}"
                draft.ignored_groups.add(group)
            else:
                self._arguments = arguments
                if len(config.hydra.overrides.hydra) + len(config.hydra.overrides.task) != len(arguments):
                    draft.add(trust.forbidden_key_problem("overrides"))
                return config, files

    def _compose_rest(self, overrides: Sequence[str], draft: Draft) -> tuple[DictConfig, Mapping[str, Any]]:
        """Composes a tree without the robot's invalid defaults list, but with the keys of its file."""
        robots = [override.partition("=")[2] for override in overrides if override.startswith("robot=")]
        own = self._presets.content("robot", options_in(robots[-1])[0]) if robots else {}
        own.pop("defaults", None)
        draft.ignored_groups |= {"robot", "source"}
        remaining = [override for override in overrides if not override.startswith("robot=")]
        try:
            composition = self._compose(["robot=bare", *remaining], draft) if robots else None
            if composition is None:
                raise refusal(draft.problems)
            config, files = composition
            with open_dict(config):
                config.merge_with(own)
        except OmegaConfBaseException:
            raise refusal(draft.problems) from None
        return config, files

    def with_params(self, overrides: Sequence[Override], problems: Iterable[Diagnostic]) -> SweepRequest:
        """Adds the `hydra.sweeper.params` of files to a sweep's overrides; the command line wins."""
        own = [override for override in overrides if not override.for_hydra_itself]
        valid, invalid = self._presets.partition([override.hydra for override in own if not override.swept])
        draft = Draft.of((), invalid)
        # An interpolation may name a key that is swept.
        first_jobs = [override.first for override in own]
        composition = self._compose(valid, draft) or self._compose(first_jobs, draft)
        settings = self._hydra.sweep_settings(composition[0], draft) if composition else trust.SweepSettings()
        typed_keys = {override.key for override in overrides}
        added = [override for override in self._params(settings.params)[0] if override.key not in typed_keys]
        return SweepRequest([*added, *overrides], list(problems), composition and composition[0], settings)

    def _params(self, params: Mapping[str, str]) -> tuple[list[Override], list[Diagnostic]]:
        """Returns the overrides that files sweep, and the problems of invalid entries."""
        added: list[Override] = []
        problems: list[Diagnostic] = []
        for key, values in params.items():
            swept, wrong = read([f"{key}={values}"], GROUPS, self.reading.values, multirun=True)
            place = f"sweeper.params.{key}"
            keys = self.reading.typed_keys((override.hydra for override in swept), _COMMAND_LINE_KEYS)
            if keys or any(override.for_hydra_itself for override in swept):
                problems.append(trust.forbidden_key_problem(place, values))
            else:
                added += swept
            problems += [replace(problem, where=f"hydra.{place}") for problem in wrong]
        return added, problems

    def show(self, kind: str, overrides: Sequence[Override], problems: Iterable[Diagnostic]) -> None:
        """Lets Hydra print how it composes a tree, even an invalid tree. `kind`: a word of `--info`."""
        with suppress(ConfigError):
            self.compose([override.hydra for override in overrides], problems)
        hydra = GlobalHydra.instance().hydra
        if hydra is None or not self._arguments:
            raise refusal(list(problems))
        hydra.show_info(kind, PRIMARY, self._arguments, RunMode.RUN)

    def hydra_config(self, launcher: str, sweeper: str = "") -> DictConfig:
        """Composes Hydra's configuration from the command line alone; a sweep runs under it."""
        return self._hydra.trusted_config(launcher, sweeper)


def lacks_a_robot(config: DictConfig) -> bool:
    """Tells whether a composed tree has no robot and no source."""
    return config.hydra.runtime.choices.get("robot") in (None, "bare") and not config.get("source")
