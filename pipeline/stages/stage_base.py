"""Defines the protocol of a stage, and a base class with the parts that most stages share."""

from collections.abc import Mapping
from types import ModuleType
from typing import Any, Protocol

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.stages.context import BuildContext


class Stage(Protocol):
    """A stage of a build.

    `version`, which the stage's package declares, is increased when the same inputs give another result;
    `libraries` are the distributions whose version may change the result; `modules` are its slow imports.
    """

    @property
    def name(self) -> str: ...

    @property
    def version(self) -> int: ...

    @property
    def libraries(self) -> tuple[str, ...]: ...

    @property
    def modules(self) -> tuple[str, ...]: ...

    def preflight(self, plan: Plan, environ: Mapping[str, str]) -> None:
        """Raises ConfigError for problems that can be found before the first stage runs."""

    def config(self, context: BuildContext) -> Any:
        """Returns the stage's part of the plan, as plain data; None for a result that must not be cached."""

    def force(self, context: BuildContext) -> bool:
        """Tells whether the stage runs even if its result is in the cache, and replaces that result."""

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        """Returns the digests of the files that the stage reads."""

    def run(self, context: BuildContext) -> dict[str, bytes]:
        """Returns the stage's files, by relative path."""


class StageBase:
    """A stage with the defaults that most stages share. `face`: the stage's package, which declares the
    version."""

    name: str
    face: ModuleType
    libraries: tuple[str, ...] = ()

    @property
    def modules(self) -> tuple[str, ...]:
        return ()

    @property
    def version(self) -> int:
        version: int = self.face.VERSION
        return version

    def preflight(self, plan: Plan, environ: Mapping[str, str]) -> None:
        pass

    def force(self, context: BuildContext) -> bool:
        return False
