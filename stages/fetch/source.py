"""Defines the interface of every kind of source, and the values that it exchanges with the stage.

A new source is a folder with a `section.py` and a `source.py`, and a row each in `stages.fetch.section` and
`stages.fetch.sources`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from linkwright.stages.robot.system import regular_files

if TYPE_CHECKING:
    from linkwright.stages.fetch.onshape.api.retries import Patience
    from linkwright.stages.fetch.onshape.replies.store import ReplyStore
    from linkwright.stages.fetch.recording import Recording
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.errors import Diagnostic


@dataclass(slots=True)
class Calls:
    """The API calls of a build: filled in during the fetch, so that a failed fetch is counted too."""

    made: int = 0
    """Calls that count against the quota."""

    saved: int = 0
    """Replies that were cached."""

    year: int | None = None
    """All calls of this key in this year; None if nothing counts them."""

    remaining: Mapping[str, int] = field(default_factory=dict)
    """Kind of request → calls left in the server's rate-limit window."""

    served: Mapping[str, str] = field(default_factory=dict)
    """The server's report: its `api` version, its version for definitions (`definition_api`) and its
    `release`."""

    waited: float = 0.0
    """Seconds waited at the server's request."""


@dataclass(slots=True)
class SweepState:
    """The state that the fetches of a sweep share: they see the same state of a document and share a
    budget."""

    began: float
    """Time at which the first fetch began [s since the epoch]."""

    made: int = 0
    """Calls that all fetches of the sweep made so far; `source.max_calls` limits their sum."""

    pins: dict[str, str] = field(default_factory=dict)
    """Path of a workspace in requests → its microversion."""

    asked: set[str] = field(default_factory=set)
    """The requests whose replies are not older than the sweep."""


@dataclass(frozen=True, slots=True)
class CallsAhead:
    """The calls that a fetch will make, as far as the definition of the assembly determines them."""

    pin: str
    """The version ("v/<id>") or microversion ("m/<id>") that is fetched."""

    requests: Mapping[str, tuple[str, ...]]
    """Request → the parts that it is about."""

    exact: bool
    """Whether no other request will be made, unless a request is refused."""


def _ignore(line: str) -> None:
    """Discards a line."""


def _do_nothing() -> None:
    """Does nothing."""


@dataclass(frozen=True, slots=True)
class FetchContext:
    """The environment of a fetch: caches, progress, retries."""

    replies: ReplyStore
    """The store of replies."""

    environ: Mapping[str, str]
    """The environment variables."""

    progress: Callable[[str], None] = _ignore
    """Shows a line about progress."""

    transient: Callable[[str], None] = _ignore
    """Shows a line that the next line replaces."""

    ledger: Path | None = None
    """The folder where calls are recorded."""

    calls: Calls = field(default_factory=Calls)
    """The calls made; filled in even if the fetch fails."""

    patience: Patience | None = None
    """The numbers and times of retries of failed calls, apart from `source.max_wait`."""

    sweep: SweepState | None = None
    """The state that the fetches of a sweep share; None outside a sweep."""

    while_waiting: Callable[[], None] = _do_nothing
    """Function that is called before the fetch waits for a reply or a guest process, to prepare later stages;
    it must return at once."""


@dataclass(frozen=True, slots=True)
class Fetched:
    """The result of a fetch: a bundle, and the calls made for it."""

    bundle: Bundle
    calls: int = 0
    """Calls that count against the quota."""

    saved: int = 0
    """Calls that cached replies saved."""

    diagnostics: tuple[Diagnostic, ...] = ()
    title: str = ""
    """The name of the assembly's tab, if a reply has it."""

    stale: bool = False
    """Whether the bundle is from the last complete fetch, since the quota is used up, and `source.stale` does
    not accept that as success."""

    lasts: bool = True
    """Whether a later fetch of pinned content gives the same bundle; otherwise the cache is not used for
    it."""


class Source(Protocol):
    """The interface of a configured source, with the behaviour that most sources share."""

    recorded: ClassVar[bool] = False
    """Whether bundles of this kind exist; if so, `replay`, `largest_reply` and `summary` are defined."""

    remote: ClassVar[bool] = False
    """Whether the source is fetched from a server; in a sweep, once before all jobs. If so, `ahead` is
    defined."""

    on_this_computer: ClassVar[bool] = False
    """Whether `pinned` reads the source, whose content may have changed; otherwise its address identifies
    it."""

    def __init__(self, keys: Any) -> None: ...

    def label(self) -> str:
        """Returns the name of the source in messages."""
        ...

    def preflight(self, environ: Mapping[str, str]) -> None:
        """Raises ConfigError for errors that are known before any work."""

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any] | None:
        """Returns the permanent identity of the content as plain data; None if the content may change."""
        ...

    def fetch(self, context: FetchContext) -> Fetched:
        """Fetches the source's content as a bundle."""
        ...

    def survey(self, context: FetchContext, *, masses: bool) -> Fetched:
        """Fetches what describes the mechanism, and with `masses` the mass of each part; by default, all of
        the source's content."""
        return self.fetch(context)

    def ahead(self, context: FetchContext) -> CallsAhead:
        """Returns the calls that `fetch` will make. It already makes the calls for the definition and for the
        state to fetch."""
        raise NotImplementedError

    @property
    def spends(self) -> bool:
        """Whether a fetch may make calls that count against a quota."""
        return False

    @property
    def writes(self) -> bool:
        """Whether a fetch changes the source, if only for a moment."""
        return False

    @property
    def force(self) -> bool:
        """Whether the source must be read again although nothing about it may have changed."""
        return False

    def remarks(self) -> tuple[Diagnostic, ...]:
        """Returns diagnostics about the place where credentials are read from."""
        return ()

    def describe(self) -> dict[str, str]:
        """Returns the report's data about the source, besides its kind."""
        return {}

    @staticmethod
    def replay(recording: Recording, where: str) -> Bundle:
        """Returns the bundle of a recording of this kind; `where` names its file in messages."""
        raise NotImplementedError

    @staticmethod
    def largest_reply(request: str) -> int:
        """Returns the size limit of the reply to a request in a recording [bytes]."""
        raise NotImplementedError

    @staticmethod
    def summary(bundle: Bundle) -> str:
        """Describes the content of a bundle of this kind in words."""
        raise NotImplementedError


class FileSource(Source):
    """A source that is the file at `source.path`."""

    description: ClassVar[str]
    """The expected kind of file: "a URDF is a file"."""

    example: ClassVar[str]
    """A path of such a file."""

    on_this_computer: ClassVar[bool] = True

    def __init__(self, keys: Any) -> None:
        self._keys = keys

    def label(self) -> str:
        return str(self._keys.path)

    def preflight(self, environ: Mapping[str, str]) -> None:
        regular_files.require(self._keys.path, "source.path", self.description, self.example)
