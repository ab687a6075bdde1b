"""The interface of every kind of source, and the values that it exchanges with the stage.

A new source is one folder with a `section.py` and a `source.py`, and a row in `stages.fetch.section` and
`stages.fetch.sources` each.
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
    """The API calls of one build: filled in while it fetches, so that a failed fetch is counted too.

    `made`: calls that count against the quota; `saved`: replies that were cached; `year`: all
    calls of this key in this year, None where nothing counts them; `remaining`: calls left in the
    server's rate-limit windows, by kind of request; `served`: the server's own report: its
    `api` version, that of definitions (`definition_api`) and its `release`; `waited`: seconds waited
    because the server asked for that.
    """

    made: int = 0
    saved: int = 0
    year: int | None = None
    remaining: Mapping[str, int] = field(default_factory=dict)
    served: Mapping[str, str] = field(default_factory=dict)
    waited: float = 0.0


def _ignore(line: str) -> None:
    """Shows nothing."""


def _nothing() -> None:
    """Does nothing."""


@dataclass(frozen=True, slots=True)
class FetchContext:
    """The environment of a fetch: caches, progress, retries.

    `replies`: where replies are kept; `environ`: the environment variables. `progress` gets lines about
    progress, and `transient` those that the next line replaces. Calls are recorded in the folder `ledger`,
    and in `calls` also where the fetch fails. `patience`: how often and how long failed calls are retried,
    apart from `source.max_wait`. `began`: the start of the sweep that this build belongs to [s since the
    epoch]. `while_waiting` is called while a reply or a guest process is awaited, to prepare later stages; it
    must return at once.
    """

    replies: ReplyStore
    environ: Mapping[str, str]
    progress: Callable[[str], None] = _ignore
    transient: Callable[[str], None] = _ignore
    ledger: Path | None = None
    calls: Calls = field(default_factory=Calls)
    patience: Patience | None = None
    began: float | None = None
    while_waiting: Callable[[], None] = _nothing


@dataclass(frozen=True, slots=True)
class Fetched:
    """A bundle, the `calls` made for it that count against the quota, and the calls `saved`.

    `title`: the name of the assembly's tab, where a reply has it. `stale`: the bundle is from the last
    complete fetch, since the quota is used up, and `source.stale` does not accept that as success. `lasts`:
    whether a later fetch of pinned content gives the same; otherwise it is not taken from the cache.
    """

    bundle: Bundle
    calls: int = 0
    saved: int = 0
    diagnostics: tuple[Diagnostic, ...] = ()
    title: str = ""
    stale: bool = False
    lasts: bool = True


class Source(Protocol):
    """One source as it is configured. What most sources have in common is defined here."""

    recorded: ClassVar[bool] = False
    """Whether bundles of this kind exist: then `replay`, `largest_reply` and `summary` are defined."""

    on_this_computer: ClassVar[bool] = False
    """Whether `pinned` reads the source, whose content may have changed; else its address stands for it."""

    def __init__(self, keys: Any) -> None: ...

    def label(self) -> str:
        """The source as messages name it."""
        ...

    def preflight(self, environ: Mapping[str, str]) -> None:
        """ConfigError for errors that are known before any work."""

    def pinned(self, environ: Mapping[str, str]) -> dict[str, Any] | None:
        """What identifies the content for ever, as plain data; None where it may change."""
        ...

    def fetch(self, context: FetchContext) -> Fetched:
        """The source's content as a bundle."""
        ...

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
        """Diagnostics about the place that credentials are read from."""
        return ()

    def describe(self) -> dict[str, str]:
        """The report's data about the source, besides its kind."""
        return {}

    @staticmethod
    def replay(recording: Recording, where: str) -> Bundle:
        """The bundle of a recording of this kind; `where` names its file in messages."""
        raise NotImplementedError

    @staticmethod
    def largest_reply(request: str) -> int:
        """The size limit of the reply to a request in a recording [bytes]."""
        raise NotImplementedError

    @staticmethod
    def summary(bundle: Bundle) -> str:
        """What a bundle of this kind holds, in words."""
        raise NotImplementedError


class FileSource(Source):
    """A source that is the file at `source.path`."""

    wanted: ClassVar[str]
    """What the file must be: "a URDF is a file"."""

    example: ClassVar[str]
    """A path of such a file."""

    on_this_computer: ClassVar[bool] = True

    def __init__(self, keys: Any) -> None:
        self._keys = keys

    def label(self) -> str:
        return str(self._keys.path)

    def preflight(self, environ: Mapping[str, str]) -> None:
        regular_files.require(self._keys.path, "source.path", self.wanted, self.example)
