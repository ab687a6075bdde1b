"""Defines the whole configuration as one frozen value."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError

from linkwright.pipeline.config.messages import diagnostics
from linkwright.pipeline.config.motor_library import with_motors
from linkwright.pipeline.config.objective_section import ObjectiveSection
from linkwright.pipeline.config.optional import idle_entries
from linkwright.pipeline.config.page_section import PageSection
from linkwright.pipeline.errors import Diagnostic, refusal
from linkwright.stages.export.section import ExportSections
from linkwright.stages.fetch.section import FetchSections
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.section import Flag, Section, Text, example, invalid
from linkwright.stages.validate.section import ValidateSections

SECTIONS: tuple[type[Section], ...] = (
    FetchSections,
    GraphSections,
    MeshSections,
    ExportSections,
    ValidateSections,
)
"""Each stage's part of the configuration, in the order in which the stages run."""


RUN_KEYS = (
    "cache",
    "output",
    "overwrite",
    "page",
    "source.max_calls",
    "source.max_wait",
    "source.offline",
    "source.refresh",
    "source.stale",
    "source.trust",
)
"""Keys and sections about how a build runs, not about its result: they do not identify a job of a sweep and
are not part of a cache key."""


def _check_module_name(name: str) -> str:
    if not all(part.isidentifier() for part in name.split(".")):
        raise invalid("must be the name of a module, such as my_checks or lab.checks")
    return name


Module = Annotated[Text, AfterValidator(_check_module_name)]
"""The name of a module, with the packages around it."""


def is_run_key(key: str) -> bool:
    """Tells whether a full key is about how a build runs, not about its result."""
    return any(key == run_key or key.startswith(f"{run_key}.") for run_key in RUN_KEYS)


class CacheSection(Section):
    """The cache of earlier results."""

    mode: Literal["use", "refresh", "bypass"] = "use"
    """use: read and store results; refresh: compute everything again and store it; bypass: neither read nor
    store."""

    dir: Annotated[Text | None, example("~/.cache/linkwright")] = None
    """Folder of the cache; null: LINKWRIGHT_CACHE, else the platform's cache folder."""


class Plan(FetchSections, GraphSections, MeshSections, ExportSections, ValidateSections):
    """The whole configuration of a build: the sections of the stages, and how they run."""

    page: PageSection = PageSection()
    """The page about the build, and the robot's picture; these keys change no file of the robot."""

    objective: ObjectiveSection | None = None
    """The number that a search minimizes or maximizes over the robots of a sweep; no file of the robot has
    it."""

    cache: CacheSection = CacheSection()
    """The cache of earlier results."""

    vars: Annotated[dict[Text, Any], example({"reach": 0.3})] = Field(default_factory=dict)
    """Values of your own, for interpolations such as `${vars.reach}`."""

    plugins: Annotated[tuple[Module, ...], example(["my_checks"])] = ()
    """Modules whose functions and classes may be used as `_target_`. Counts only on the command line, and in
    files that `LINKWRIGHT_TRUST` names."""

    output: Annotated[Text | None, example("~/robots/my_arm")] = None
    """The output folder; `~` is the home folder; null: `outputs/<name>`. The folder must be new, empty or
    from an earlier build. A file may only name a folder below the working folder, or `${oc.env:NAME}`, which
    may be any place."""

    overwrite: Flag = False
    """Whether files in the way of the build (changed files of an earlier build, and your own files at a path
    that the build writes) are moved to `<output>.replaced`; otherwise they stop the build."""

    until: Literal["fetch", "graph", "mesh", "export", "validate"] = "validate"
    """The last stage that runs."""

    @classmethod
    def parse(
        cls,
        data: Mapping[str, Any],
        earlier: Iterable[Diagnostic] = (),
        *,
        is_unsure: Callable[[Diagnostic], bool] = lambda _: False,
        judge: "Judge | None" = None,
        folders: Sequence[Path] = (),
    ) -> "Plan":
        """Returns the plan that `data`, plain mappings and lists, describes.

        Raises a single ConfigError with all problems: the `earlier` problems; each key that is unknown,
        missing, not supported yet or has a value that is not allowed; and the problems that `judge` finds in
        the rest. Problems of keys are left out if they may only follow from an earlier problem
        (`is_unsure`). `folders`: the user's folders, which contain `robot/` and may contain `motors/`.
        """
        data, motor_problems = with_motors(data, folders)
        problems = [*earlier, *motor_problems, *idle_entries(data)]
        plan: Plan | None
        try:
            plan = cls.model_validate(dict(data))
        except ValidationError as error:
            places = {problem.where for problem in problems}
            invalid_keys = [problem for problem in diagnostics(error, cls) if problem.where not in places]
            problems += [problem for problem in invalid_keys if not is_unsure(problem)]
            plan = cls._without_invalid_sections(data, [details["loc"] for details in error.errors()])
        if plan is not None and not problems:
            return plan
        if plan is not None and judge is not None:
            problems += judge(plan)
        raise refusal(problems)

    @classmethod
    def _without_invalid_sections(
        cls, data: Mapping[str, Any], invalid_places: Iterable[Sequence[int | str]]
    ) -> "Plan | None":
        """Returns the plan without its invalid sections, or None if the rest is invalid too."""
        rest = dict(data)
        for head, *below in invalid_places:
            if head == "source" and len(below) == 2 and isinstance(rest.get("source"), dict):
                # pydantic puts the kind of source between the two.
                rest["source"] = {key: value for key, value in rest["source"].items() if key != below[1]}
            else:
                rest.pop(str(head), None)
        try:
            return cls.model_validate(rest)
        except ValidationError:
            return None

    @property
    def folder(self) -> Path:
        """The output folder."""
        if self.output is None:
            return Path("outputs") / self.name
        return Path(os.path.expanduser(self.output))  # noqa: PTH111  (a user that is not known is no error here)

    def tree(self) -> dict[str, Any]:
        """Returns the plan as plain data in the order of the stages; `parse` reads it back."""
        data = self.identity()
        names = [name for keys in SECTIONS for name in keys.model_fields]
        names += [name for name in data if name not in names]
        return {name: data[name] for name in ["name", *(name for name in names if name != "name")]}


Judge = Callable[[Plan], Iterable[Diagnostic]]
"""A function that finds further problems of a plan before it is built."""


def section(plan: Plan, keys: type[Section]) -> dict[str, Any]:
    """Returns a stage's part of the plan as plain data, for a cache key. Mappings keep their order."""
    return plan.model_dump(mode="json", by_alias=True, include=set(keys.model_fields))
