"""The whole configuration as one frozen value."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, ValidationError

from linkwright.pipeline.config.messages import diagnostics
from linkwright.pipeline.config.motor_library import with_motors
from linkwright.pipeline.config.optional import without_effect
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


def _module(name: str) -> str:
    if not all(part.isidentifier() for part in name.split(".")):
        raise invalid("must be the name of a module, such as my_checks or lab.checks")
    return name


Module = Annotated[Text, AfterValidator(_module)]
"""The name of a module, with the packages around it."""


def is_run_key(key: str) -> bool:
    """Whether a full key is about how a build runs, not about its result."""
    return any(key == one or key.startswith(f"{one}.") for one in RUN_KEYS)


class CacheSection(Section):
    """The cache of earlier results."""

    mode: Literal["use", "refresh", "bypass"] = "use"
    """use: read and store results; refresh: make everything again and store it; bypass: neither read nor
    store."""

    dir: Annotated[Text | None, example("~/.cache/linkwright")] = None
    """Folder of the cache; null: LINKWRIGHT_CACHE, else the platform's cache folder."""


class Plan(FetchSections, GraphSections, MeshSections, ExportSections, ValidateSections):
    """The whole configuration of a build: the sections of the stages, and how they run."""

    page: PageSection = PageSection()
    """The page about the build, and the robot's picture: no key of them changes a file of the robot."""

    cache: CacheSection = CacheSection()
    """The cache of earlier results."""

    vars: Annotated[dict[Text, Any], example({"reach": 0.3})] = Field(default_factory=dict)
    """Values of your own, for interpolations such as `${vars.reach}`."""

    plugins: Annotated[tuple[Module, ...], example(["my_checks"])] = ()
    """Modules whose functions and classes may be used as `_target_`. Counts on the command line, and in files
    that `LINKWRIGHT_TRUST` names."""

    output: Annotated[Text | None, example("~/robots/my_arm")] = None
    """The output folder; `~` is the home folder; null: `outputs/<name>`. It is new, empty or of an earlier
    build. In a file it lies below the working folder, or is `${oc.env:NAME}`, which may be any place."""

    overwrite: Flag = False
    """Whether files in the way of the build (files of an earlier build that were changed, and files of yours
    at a path that the build writes) are moved to `<output>.replaced`; else they stop the build."""

    until: Literal["fetch", "graph", "mesh", "export", "validate"] = "validate"
    """The last stage that runs."""

    @classmethod
    def parse(
        cls,
        data: Mapping[str, Any],
        known: Iterable[Diagnostic] = (),
        *,
        unsure: Callable[[Diagnostic], bool] = lambda _: False,
        judge: "Judge | None" = None,
        folders: Sequence[Path] = (),
    ) -> "Plan":
        """The plan that `data`, plain mappings and lists, describes.

        One ConfigError lists all problems: the `known` problems; each key that is unknown, missing, not
        supported yet or has a value that is not allowed, except those that may only follow from a known
        problem (`unsure`); and the problems that `judge` finds in the rest. `folders`: the user's own, which
        hold `robot/` and may hold `motors/`.
        """
        data, missing = with_motors(data, folders)
        problems = [*known, *missing, *without_effect(data)]
        plan: Plan | None
        try:
            plan = cls.model_validate(dict(data))
        except ValidationError as error:
            places = {problem.where for problem in problems}
            found = [one for one in diagnostics(error, cls) if one.where not in places]
            problems += [one for one in found if not unsure(one)]
            plan = cls._of_the_rest(data, [details["loc"] for details in error.errors()])
        if plan is not None and not problems:
            return plan
        if plan is not None and judge is not None:
            problems += judge(plan)
        raise refusal(problems)

    @classmethod
    def _of_the_rest(cls, data: Mapping[str, Any], wrong: Iterable[Sequence[int | str]]) -> "Plan | None":
        """The plan without the invalid sections; None where it is invalid without them."""
        rest = dict(data)
        for head, *below in wrong:
            if head == "source" and len(below) == 2 and isinstance(rest.get("source"), dict):
                # pydantic puts the kind of source between the two.
                rest["source"] = {key: one for key, one in rest["source"].items() if key != below[1]}
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
        """The plan as plain data in the order of the stages; `parse` reads it back."""
        data = self.identity()
        own = [name for keys in SECTIONS for name in keys.model_fields]
        own += [name for name in data if name not in own]
        return {name: data[name] for name in ["name", *(name for name in own if name != "name")]}


Judge = Callable[[Plan], Iterable[Diagnostic]]
"""Finds further problems of a plan before it is built."""


def section(plan: Plan, keys: type[Section]) -> dict[str, Any]:
    """One stage's part of the plan as plain data: its part of a cache key. Mappings keep their order."""
    return plan.model_dump(mode="json", by_alias=True, include=set(keys.model_fields))
