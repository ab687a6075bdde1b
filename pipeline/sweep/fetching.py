"""Fetches the sources of a sweep once, before its first job: the jobs then build from the cache, each from
the same state of a document, and need no key."""

import contextlib
import functools
import json
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.output.room import require_room
from linkwright.pipeline.run.preflight import suffix_of
from linkwright.pipeline.stages.context import NOTES, BuildContext
from linkwright.pipeline.stages.prefetched import Prefetched, source_identity
from linkwright.pipeline.stages.stage import FetchStage, perform
from linkwright.pipeline.sweep.run import print_line
from linkwright.stages.fetch import is_remote
from linkwright.stages.fetch.onshape.api.ledger import FOLDER as LEDGER
from linkwright.stages.fetch.onshape.call_budget import allow
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.source import CallsAhead, SweepState
from linkwright.stages.robot.errors import (
    AuthError,
    LinkwrightError,
    Offline,
    QuotaExhausted,
    RateLimited,
)
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.pipeline.sweep.run import Job

BUDGET = "source.max_calls"

MAX_NAMED_JOBS = 3
"""Largest number of jobs that a message names by their numbers; it counts the rest."""

_STAGE = FetchStage()


@dataclass(slots=True)
class JobGroup:
    """A group of jobs that build from the same replies of a server."""

    plan: Plan
    """The plan of the first job."""

    pin: str = ""
    """The version or microversion that is fetched; "" before it is known."""

    numbers: list[int] = field(default_factory=list)
    """The numbers of the jobs."""

    ahead: CallsAhead | None = None
    """The calls that the fetch will make; None before `Fetching.ask_servers`."""

    error: LinkwrightError | None = None
    """The error that ended the fetch."""


def fetch_sources(
    jobs: Sequence["Job"], *, is_quiet: bool, state: SweepState | None = None
) -> Sequence["Job"]:
    """Fetches the sources of a sweep, after telling what that costs; returns the jobs of `Fetching.fetch`.
    `state`: the state of earlier fetches of the same sweep."""
    fetching = Fetching(jobs, state=state)
    if not fetching.groups:
        return jobs
    say: Callable[[str], None] = (lambda _: None) if is_quiet else print_line
    fetching.ask_servers()
    say(fetching.line(len(jobs)))
    return fetching.fetch(say)


def groups_of(jobs: Sequence["Job"]) -> list[JobGroup]:
    """Returns the groups of the jobs whose source is on a server."""
    groups: dict[bytes, JobGroup] = {}
    for job in jobs:
        if is_remote(job.plan):
            cache = job.plan.cache
            key = actions.canonical([source_identity(job.plan), cache.mode, cache.dir, job.pin])
            groups.setdefault(key, JobGroup(job.plan, job.pin)).numbers.append(job.number)
    return list(groups.values())


class Fetching:
    """The fetch of a whole sweep: `ask_servers` finds its cost, `fetch` does it."""

    def __init__(
        self,
        jobs: Sequence["Job"],
        environ: Mapping[str, str] = os.environ,
        state: SweepState | None = None,
    ) -> None:
        self._jobs = {job.number: job for job in jobs}
        self._environ = environ
        self.groups = groups_of(jobs)
        self.state = state or SweepState(time.time())
        self.exact, self.more = True, 0
        """The number of calls that `fetch` will make, and whether it is exact."""

    def ask_servers(self) -> None:
        """Asks which state of each document is fetched, and for the definition of each configuration.
        Raises SourceError if `source.max_calls` allows fewer calls than the sweep needs.
        """
        for group in self.groups:
            if group.error:
                continue
            try:
                with self._build_context(group) as context:
                    group.ahead = _STAGE.ahead(context)
                group.pin = group.ahead.pin
            except QuotaExhausted:
                continue  # The last fetched state may do, which the fetch decides.
            except LinkwrightError as error:
                self._record_failure(group, error)
        self._count()
        for group in self.groups:
            if group.ahead and self.more and not _source(group).offline:
                allow(self.more, 0, _source(group).max_calls, self.state.made)

    def estimate_from_cache(self) -> None:
        """Estimates the cost as `ask_servers` does, but from the cache alone: no server is asked, and no
        workspace is pinned."""
        unknown, workspaces = 0, set()
        for group in self.groups:
            source = _source(group)
            offline = group.plan.model_copy(update={"source": source.model_copy(update={"offline": True})})
            try:
                with self._build_context(replace(group, plan=offline)) as context:
                    group.ahead = _STAGE.ahead(context)
            except LinkwrightError:
                unknown += 1
            if not source.url.pinned and not source.offline:
                workspaces.add(_workspace_path(group))
        self._count()
        # A workspace tells by a single call whether it changed, or by none with a first definition.
        self.more += max(unknown, len(workspaces))
        self.exact = self.exact and not unknown and not workspaces

    def _count(self) -> None:
        """Counts the calls that `fetch` will make."""
        requests: dict[str, tuple[str, ...]] = {}
        for ahead in (group.ahead for group in self.groups if group.ahead and not _source(group).offline):
            # For a part studio, two assemblies may need a request each for the triangles of their parts.
            are_same = all(requests.get(request, parts) == parts for request, parts in ahead.requests.items())
            self.exact = self.exact and ahead.exact and are_same
            requests |= ahead.requests
        self.more = len(requests)

    def line(self, jobs: int) -> str:
        """Returns the cost of a sweep of `jobs` jobs: `64 jobs, 5 configurations, 11 calls`."""
        bound = "" if self.exact else "at least "
        calls = f"{bound}{count(self.state.made + self.more, 'call')}"
        return f"{count(jobs, 'job')}, {count(len(self.groups), 'configuration')}, {calls}"

    def fetch(self, say: Callable[[str], None] = lambda _: None) -> list["Job"]:
        """Fetches each configuration; returns the jobs, each with its fetched source, or the reason for a
        failure."""
        jobs = dict(self._jobs)
        for position, group in enumerate(self.groups, 1):
            if group.ahead and group.ahead.requests:
                say(
                    f"fetching configuration {position} of {len(self.groups)}: {jobs[group.numbers[0]].label}"
                )
            stage = self._fetch_group(group)
            for job in group.numbers:
                jobs[job] = replace(jobs[job], fetched=stage, pin=group.pin)
        return list(jobs.values())

    def failures(self) -> list[str]:
        """Returns a message for each reason why configurations cannot be fetched. It names the first job of
        each of these configurations."""
        by_message: dict[str, list[Job]] = {}
        for group in self.groups:
            if group.error:
                by_message.setdefault(str(group.error), []).append(self._jobs[group.numbers[0]])
        return [f"{job_names(jobs)}: {message}" for message, jobs in by_message.items()]

    def _fetch_group(self, group: JobGroup) -> Prefetched:
        identity = source_identity(group.plan)
        if group.error is None:
            try:
                with self._build_context(group) as context:
                    files, _ = perform(_STAGE, context)
                    if not _source(group).url.pinned:
                        group.pin = f"m/{json.loads(files[NOTES])['source']['microversion']}"
                    stage = Prefetched(identity, group.pin)
                    stage.keep(files, context.cache)
                    return stage
            except LinkwrightError as error:
                self._record_failure(group, error)
        return Prefetched(identity, group.pin, group.error)

    def _record_failure(self, group: JobGroup, error: LinkwrightError) -> None:
        """Fails the group, and the other groups too if no other request to that server would succeed."""
        if error.where == BUDGET:
            raise error
        is_general = isinstance(error, AuthError | RateLimited) or (
            isinstance(error, Offline) and not _source(group).offline
        )
        for affected in self.groups if is_general else [group]:
            if affected is group or _workspace_path(affected) == _workspace_path(group):
                affected.error = affected.error or error

    @contextlib.contextmanager
    def _build_context(self, group: JobGroup) -> Iterator[BuildContext]:
        plan, environ = group.plan, self._environ
        if group.error:
            raise group.error
        if group.pin and not _source(group).url.pinned:
            self.state.pins[_workspace_path(group)] = group.pin[2:]
        with actions.opened(plan.cache.mode, plan.cache.dir, environ) as cache:
            ledger = actions.folder(plan.cache.dir, environ) / LEDGER
            context = BuildContext(plan, cache, environ, ledger=ledger, sweep=self.state)
            output = Output(plan.folder)
            context.require_room = functools.partial(require_room, cache.store, output, suffix_of(plan))
            try:
                yield context
            finally:
                self.state.made += context.calls["made"]


def job_names(jobs: Sequence["Job"]) -> str:
    """Names jobs in a message: a single job by number and label, several by the first numbers."""
    if len(jobs) == 1:
        return f"job {jobs[0].number} ({jobs[0].label})"
    numbers = [str(job.number) for job in jobs]
    remainder = f" and {len(jobs) - MAX_NAMED_JOBS} more" if len(jobs) > MAX_NAMED_JOBS else ""
    return f"jobs {', '.join(numbers[:MAX_NAMED_JOBS])}{remainder}"


def _source(group: JobGroup) -> OnshapeSourceSection:
    source = group.plan.source
    assert isinstance(source, OnshapeSourceSection)  # no other source is remote
    return source


def _workspace_path(group: JobGroup) -> str:
    """Returns the path of a document's workspace, version or microversion in requests."""
    url = _source(group).url
    return f"/documents/d/{url.document}/{url.pin}"
