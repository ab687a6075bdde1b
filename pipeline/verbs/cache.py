"""`linkwright cache info|gc|verify`: shows, shrinks and checks the cache."""

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from linkwright.pipeline.caching import maintenance
from linkwright.pipeline.caching.actions import folder
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.cache import (
    CacheCleared,
    CacheDocument,
    CacheInfo,
    CacheVerified,
    CallsDocument,
)
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.options import JSON
from linkwright.pipeline.reference.exit_status import BUILT, FAILED
from linkwright.pipeline.terminal.output import say
from linkwright.stages.fetch.onshape.api import ledger
from linkwright.stages.robot.text.plural import count

HELP = """\
linkwright cache: look after the cache, where builds keep what they fetched and
made.

usage: linkwright cache info|gc|verify [--max-size SIZE] [--json]
                                       [cache.dir=FOLDER]

  linkwright cache info             where it is, its size, and the API calls
                                    counted
  linkwright cache gc --max-size 5G
                                    free space: drop the files that were not
                                    used for longest
  linkwright cache verify           check every file; remove corrupt files

The calls are those that count against the yearly quota, by key and calendar
year (UTC), as far as builds with this cache made them. A key is shown by the
start of its hash, and stored nowhere.

--max-size is a number with K, M, G or T (powers of 1000); the default is 20G.
Replies that cost API calls are dropped last; files used within the last hour
stay. Lock files that no build uses are removed too, also those beside the
builds in ./outputs. The cache folder is cache.dir=, else the environment
variable LINKWRIGHT_CACHE, else the platform's cache folder. With --json one
JSON document is printed.
"""

_USAGE = "linkwright cache info|gc|verify; linkwright cache --help shows more"
_DIR_KEY = "cache.dir="
_SIZE = re.compile(r"(\d+(?:\.\d+)?)([KMGT]?)B?", re.IGNORECASE)
_POWERS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}
_DEFAULT_SIZE = 20 * 10**9
"""Size [bytes] to which `gc` shrinks the cache without `--max-size`."""

_SHOWN_CHARACTERS = 8
"""Characters of a key's hash that are shown."""


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ) -> int | CommandDocument:
    """Runs the verb and returns the exit status, or its document. Raises ConfigError for wrong usage, and
    CacheError if the cache folder cannot be used."""
    dirs = [text for text in arguments if text.startswith(_DIR_KEY)]
    rest = [text for text in arguments if text not in dirs and text != JSON]
    max_size = _max_size(rest)
    verbs: dict[str, Callable[[Path], CacheDocument]] = {
        "info": _info,
        "gc": lambda root: _gc(root, _DEFAULT_SIZE if max_size is None else max_size),
        "verify": _verify,
    }
    if len(rest) != 1 or rest[0] not in verbs or (max_size is not None and rest[0] != "gc"):
        msg = f"expected info, gc or verify, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "cache", _USAGE)
    configured = dirs[-1].removeprefix(_DIR_KEY) if dirs else None
    document = verbs[rest[0]](folder(configured, environ))
    if JSON in arguments:
        return document
    for line in _lines(document):
        say(line)
    return document.exit_status


def _max_size(rest: list[str]) -> int | None:
    """Removes `--max-size SIZE` or `--max-size=SIZE` from `rest`; returns the bytes, or None."""
    for index, text in enumerate(rest):
        option, equal, value = text.partition("=")
        if option != "--max-size":
            continue
        rest.pop(index)
        if not equal:
            value = rest.pop(index) if index < len(rest) else ""
        match = _SIZE.fullmatch(value)
        if match is None:
            msg = f"--max-size needs a number with K, M, G or T, not {value or 'nothing'}"
            raise ConfigError(msg, "cache gc", "linkwright cache gc --max-size 20G")
        return int(float(match[1]) * _POWERS[match[2].upper()])
    return None


def _info(root: Path) -> CacheDocument:
    summary = maintenance.summary(root)
    years = tuple(
        CallsDocument(year.who[:_SHOWN_CHARACTERS], year.year, year.counted, year.calls, year.exhausted)
        for year in ledger.years(root / ledger.FOLDER)
    )
    info = CacheInfo(summary.size, summary.blobs, summary.records, summary.replies, years)
    return CacheDocument(0, str(root), info=info)


def _gc(root: Path, max_size: int) -> CacheDocument:
    result = maintenance.collect(root, max_size)
    for outputs in (Path("outputs"), *Path("outputs").glob("*.sweep")):
        maintenance.drop_locks(outputs / LOCKS)
    numbers = result.freed, result.size, max_size, result.blobs, result.records, result.paid
    return CacheDocument(0, str(root), cleared=CacheCleared(*numbers))


def _verify(root: Path) -> CacheDocument:
    result = maintenance.verify(root)
    verified = CacheVerified(result.blobs, result.broken, result.records, result.paid)
    return CacheDocument(FAILED if result.broken or result.records else BUILT, str(root), verified=verified)


def _lines(document: CacheDocument) -> Iterator[str]:
    """Yields the lines of a document."""
    if document.info:
        yield document.folder
        yield from _info_lines(document.info)
    if document.cleared:
        yield from _cleared_lines(document.folder, document.cleared)
    if document.verified:
        yield from _verified_lines(document.folder, document.verified)


def _info_lines(info: CacheInfo) -> Iterator[str]:
    yield (
        f"  {_size(info.size)}: {count(info.files, 'file')} and {count(info.records, 'record')}, "
        f"{info.replies} of them replies that were paid for"
    )
    yield "API calls counted, by key (start of its hash) and year:" if info.years else "no API call counted"
    for year in info.years:
        kinds = ", ".join(f"{number} {kind}" for kind, number in year.calls.items())
        end = "; the quota is used up (402)" if year.exhausted else ""
        yield f"  {year.key:{_SHOWN_CHARACTERS}}  {year.year}  {year.counted:5d}  {kinds}{end}"


def _cleared_lines(root: str, cleared: CacheCleared) -> Iterator[str]:
    paid = f" ({cleared.paid} of them replies that were paid for)" if cleared.paid else ""
    yield f"{root}: {_size(cleared.freed)} freed, {_size(cleared.size)} left"
    yield f"  dropped {count(cleared.records, 'record')}{paid} and {count(cleared.files, 'file')}"
    if cleared.size > cleared.limit:
        size = _size(cleared.limit)
        yield f"  more than {size} is left: the rest was used within the last hour; try again later"


def _verified_lines(root: str, verified: CacheVerified) -> Iterator[str]:
    if not verified.corrupt and not verified.records:
        yield f"{root}: {count(verified.files, 'file')}, all intact"
        return
    yield f"{root}: {count(verified.files, 'file')}, {len(verified.corrupt)} corrupt and removed"
    for digest in verified.corrupt:
        yield f"  {digest}"
    yield (
        f"  {count(verified.records, 'record')} of missing files removed: "
        "the next build makes these files again"
    )
    if verified.paid:
        yield f"  {verified.paid} of them were replies: fetching them again costs as many API calls"


def _size(number: int) -> str:
    for unit, power in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if number >= power:
            return f"{number / power:.2f} {unit}"
    return f"{number} bytes"
