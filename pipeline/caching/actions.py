"""Caches the results of actions: a result is reused while its inputs are the same.

The key of an action holds everything that its outputs depend on: the stage and its version, its section of
the configuration, the *content* of its inputs and the versions of the libraries that make the result. Its
record names the outputs by digest. A record with missing or corrupt blobs is a miss.
"""

import contextlib
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from linkwright.pipeline import interrupt
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError, ConfigError, reason
from linkwright.pipeline.secrets import Secrets

Mode = Literal["use", "refresh", "bypass"]
Memo = Callable[[str, Mapping[str, Any], Callable[[], bytes]], bytes]
OnResult = Callable[["MemoResult"], None]
Check = Callable[[Mapping[str, bytes]], None]
"""Raises an error for files that must not be kept."""

LAYOUT = 1
"""Version of the records, a part of every key: raised when their meaning changes."""


def canonical(value: Any) -> bytes:
    """Encodes plain data as bytes. Mappings keep their order: in a configuration later entries win."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).encode()


@dataclass(frozen=True, slots=True)
class Action:
    """Everything that a result depends on. `config`: the stage's section of the configuration, as plain data;
    `inputs`: digests by name; `libraries`: versions by name."""

    stage: str
    version: int
    config: Any = None
    inputs: Mapping[str, str] = field(default_factory=dict)
    libraries: Mapping[str, str] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """The SHA-256 under which the record of the action is stored."""
        return sha256(
            canonical(
                {
                    "layout": LAYOUT,
                    "stage": self.stage,
                    "version": self.version,
                    "config": self.config,
                    "inputs": dict(sorted(self.inputs.items())),
                    "libraries": dict(sorted(self.libraries.items())),
                }
            )
        )


@dataclass(frozen=True, slots=True)
class MemoResult:
    """A result inside a stage; `seconds`: the time to make it [s], also if it came from the cache."""

    kind: str
    key: Mapping[str, Any]
    cached: bool
    seconds: float


class Files(Mapping[str, bytes]):
    """Outputs by relative path, read on access. `digests`: path → SHA-256; `seconds`: time to make them."""

    def __init__(self, store: Store, digests: Mapping[str, str], seconds: float = 0.0) -> None:
        self._store = store
        self.digests = dict(digests)
        self.seconds = seconds

    def __getitem__(self, path: str) -> bytes:
        data = self._store.get(self.digests[path])
        if data is None:
            msg = f"{path} was lost from the cache during the build (digest {self.digests[path]})"
            raise CacheError(msg, where=str(self._store.root), hint="run the build again")
        return data

    def __iter__(self) -> Iterator[str]:
        return iter(self.digests)

    def __len__(self) -> int:
        return len(self.digests)

    def below(self, prefix: str) -> "Files":
        """Returns the files below a folder, with paths relative to it."""
        paths = [path for path in self.digests if path.startswith(prefix)]
        return Files(self._store, {path.removeprefix(prefix): self.digests[path] for path in paths})


class Cache:
    """Runs actions, and keeps their outputs in a store.

    In the mode `refresh`, each action runs once more and its record is overwritten. `on_wait` gets a line of
    text while a build waits for another process. `check` raises an error for files that must not be stored.
    """

    def __init__(self, store: Store, mode: Mode = "use", check: Check = lambda _: None) -> None:
        self.store = store
        self.mode = mode
        self.check = check
        self.on_wait: Callable[[str], None] = lambda _: None
        self._renewed_keys: set[str] = set()

    def run(
        self,
        action: Action,
        make: Callable[[], Mapping[str, bytes]],
        *,
        force: bool = False,
        lasts: Callable[[Mapping[str, bytes]], bool] = lambda _: True,
    ) -> tuple[Files, bool]:
        """Returns the outputs of `action`, and whether they came from the cache and not from `make()`.

        `force` makes them again and overwrites the record. Outputs for which `lasts` is false get no record,
        so that they are made again next time. Among several processes with the same action, the first runs it
        and the others wait.
        """
        key = action.key
        if not force and (files := self.reusable(action)) is not None:
            return files, True
        with self.store.lock(
            key, lambda: self.on_wait(f"waiting for another build of the same {action.stage}")
        ):
            if not force and (files := self.reusable(action)) is not None:
                return files, True
            start = time.perf_counter()
            outputs = make()
            interrupt.check()
            seconds = round(time.perf_counter() - start, 6)
            files = Files(self.store, self.keep(outputs).digests, seconds)
            if not lasts(outputs):
                return files, False
            record = {
                "stage": action.stage,
                "version": action.version,
                "outputs": files.digests,
                "sizes": {path: len(data) for path, data in outputs.items()},
                "seconds": seconds,
            }
            self.store.publish(key, record)
            self._renewed_keys.add(key)
        return files, False

    def keep(self, outputs: Mapping[str, bytes]) -> Files:
        """Stores outputs without a record, for an action without a key."""
        self.check(outputs)
        return Files(self.store, {path: self.store.put(outputs[path]) for path in sorted(outputs)})

    def name(self, action: Action, files: Files) -> None:
        """Publishes a record that names already stored files as the outputs of `action`."""
        record = {
            "stage": action.stage,
            "version": action.version,
            "outputs": files.digests,
            "sizes": {path: self.store.size(digest) for path, digest in files.digests.items()},
            "seconds": 0.0,
        }
        if self.store.record(action.key) != record:
            self.store.publish(action.key, record)

    def memo(
        self, stage: str, version: int, libraries: Mapping[str, str], on_result: OnResult = lambda _: None
    ) -> Memo:
        """Returns a function that caches results inside a stage, each as an action: `memo(kind, key, make)`.
        `on_result` is called with each result."""

        def remember(kind: str, key: Mapping[str, Any], make: Callable[[], bytes]) -> bytes:
            action = Action(f"{stage}/{kind}", version, config=dict(key), libraries=libraries)
            files, cached = self.run(action, lambda: {"value": make()})
            on_result(MemoResult(kind, key, cached, files.seconds))
            return files["value"]

        return remember

    def replies(self) -> "Replies":
        """Returns the replies of the fetch stage that this cache stores."""
        return Replies(self)

    def reusable(self, action: Action) -> Files | None:
        """Returns the outputs of an action if `run` would take them from the cache, else None."""
        if self.mode == "refresh" and action.key not in self._renewed_keys:
            return None
        return self.find(action.key)

    def find(self, key: str) -> Files | None:
        """Returns the outputs recorded under `key` if all of them exist and are intact, else None."""
        record = self.store.record(key)
        if record is None:
            return None
        outputs, sizes = record.get("outputs"), record.get("sizes")
        if not isinstance(outputs, dict) or not isinstance(sizes, dict) or not outputs:
            return None
        for path, digest in outputs.items():
            size = sizes.get(path)
            if not isinstance(digest, str) or not isinstance(size, int):
                return None
            if not self.store.intact(digest, size):
                return None
        seconds = record.get("seconds")
        return Files(self.store, outputs, seconds if isinstance(seconds, int | float) else 0.0)


class Replies:
    """The replies of the fetch stage by request, and facts that change by subject.

    A reply is to a pinned request, hence immutable: `cache.mode=refresh` makes no call for it.
    """

    def __init__(self, cache: Cache) -> None:
        self._cache = cache

    def get(self, request: str) -> bytes | None:
        """Returns the body of the reply to `request`, or None."""
        files = self._cache.find(self._action(request).key)
        return None if files is None else files.get("body")

    def put(self, request: str, body: bytes) -> None:
        """Keeps the body of the reply to a pinned request."""
        self._cache.check({request: body})
        files = self._cache.keep({"body": body})
        self._publish("reply", request, files.digests, {"body": len(body)})

    def recall(self, subject: str) -> Mapping[str, Any] | None:
        """Returns the last fact stored for `subject`, or None."""
        record = self._cache.store.record(self._action(subject, "fact").key)
        fact = None if record is None else record.get("fact")
        return fact if isinstance(fact, dict) else None

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        """Stores `fact` for `subject`, in place of the last fact."""
        self._cache.check({subject: json.dumps(fact).encode()})
        self._publish("fact", subject, {}, {}, fact=dict(fact))

    def lock(self, subject: str) -> contextlib.AbstractContextManager[None]:
        """Admits a single thread of all processes at a time, for each subject; a kill releases the lock."""
        return self._cache.store.lock(self._action(subject, "alone").key)

    def _publish(
        self, kind: str, request: str, outputs: Mapping[str, str], sizes: Mapping[str, int], **fields: Any
    ) -> None:
        record = {
            "stage": kind,
            "version": 1,
            "request": request,
            "outputs": dict(outputs),
            "sizes": dict(sizes),
            "seconds": 0.0,
            **fields,
        }
        self._cache.store.publish(self._action(request, kind).key, record)

    @staticmethod
    def _action(request: str, kind: str = "reply") -> Action:
        return Action(kind, 1, config=request)


def folder(configured: str | None, environ: Mapping[str, str]) -> Path:
    """Returns the cache folder: `cache.dir`, else LINKWRIGHT_CACHE, else the platform's cache folder.
    Raises ConfigError for the home folder of an unknown user."""
    named_folder = configured or environ.get("LINKWRIGHT_CACHE")
    if named_folder:
        try:
            return Path(named_folder).expanduser()
        except RuntimeError as error:
            msg = f"{named_folder} names the home folder of an unknown user"
            where = "cache.dir" if configured else "LINKWRIGHT_CACHE"
            raise ConfigError(msg, where, "name a folder, or remove the key") from error
    # Imported late: a cache in a named folder needs no platformdirs.
    import platformdirs

    return Path(platformdirs.user_cache_dir("linkwright", appauthor=False))


@contextlib.contextmanager
def opened(
    mode: Mode, configured: str | None = None, environ: Mapping[str, str] = os.environ
) -> Iterator[Cache]:
    """Opens the cache of a build, which stores no secret. The mode `bypass` works in a private folder that is
    removed at the end."""
    check = Secrets(environ).check
    if mode == "bypass":
        with _private_folder() as private:
            yield Cache(Store(private), check=check)
    else:
        yield Cache(Store(folder(configured, environ)), mode, check)


@contextlib.contextmanager
def _private_folder() -> Iterator[Path]:
    """Creates a private folder, and removes it at the end; raises CacheError if it cannot be created."""
    with contextlib.ExitStack() as stack:
        try:
            temporary = tempfile.TemporaryDirectory(prefix="linkwright-", ignore_cleanup_errors=True)
        except OSError as error:
            msg = f"no temporary folder can be made: {reason(error)}"
            hint = "free space there, or name another folder in the environment variable TMPDIR"
            raise CacheError(msg, tempfile.tempdir or "", hint) from error
        yield Path(stack.enter_context(temporary))
