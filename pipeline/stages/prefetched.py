"""Defines the fetch stage of a job whose source was fetched before: it takes the result from the cache."""

from collections.abc import Mapping
from typing import Any

import linkwright.stages.fetch
from linkwright.pipeline.caching.actions import Action, Cache, Files
from linkwright.pipeline.config.plan import Plan, is_run_key
from linkwright.pipeline.stages.context import BuildContext
from linkwright.pipeline.stages.stage import STAGES, Stage, libraries
from linkwright.pipeline.stages.stage_base import StageBase
from linkwright.stages.robot.errors import LinkwrightError, Offline


class Prefetched(StageBase):
    """A fetch stage that takes the result for a `source` (as `source_identity` describes it), at the version
    or microversion `pin`, from the cache; or raises the `error` that ended the fetch."""

    name = "fetch"
    face = linkwright.stages.fetch

    def __init__(self, source: Mapping[str, Any], pin: str, error: LinkwrightError | None = None) -> None:
        self._state = {"source": dict(source), "pin": pin}
        self._error = error

    @property
    def action(self) -> Action:
        return Action(self.name, self.version, {"prefetched": self._state}, libraries=libraries(self))

    def keep(self, files: Files, cache: Cache) -> None:
        """Records the result of the fetch, for jobs with the same cache."""
        cache.name(self.action, files)

    def config(self, context: BuildContext) -> Any:
        return None if self._error else self.action.config

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        return {}

    def run(self, context: BuildContext) -> dict[str, bytes]:
        if self._error:
            raise self._error
        # With cache.mode=refresh a stage makes its result again; this stage still takes the cached result.
        files = context.cache.find(self.action.key)
        if files is None:
            state = self._state["pin"] or "a state that is not known yet"
            msg = f"the cache does not have the assembly at {state}"
            raise Offline(
                msg, "source.url", "fetch into the cache that the jobs use: cache.dir=FOLDER names it"
            )
        return dict(files)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """The stages of a job that begins with this stage."""
        return (self, *STAGES[1:])


def source_identity(plan: Plan) -> dict[str, Any]:
    """Returns the keys that identify a source's content, without keys about the way it is fetched."""
    keys = plan.source.model_dump(mode="json")
    return {key: value for key, value in keys.items() if not is_run_key(f"source.{key}")}
