"""`linkwright cache info|gc|verify`: shows, shrinks and checks the cache."""

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from linkwright.pipeline.caching import maintenance
from linkwright.pipeline.caching.actions import folder
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.terminal.output import say
from linkwright.stages.fetch.onshape.api import ledger
from linkwright.stages.robot.text.plural import count

HELP = """\
linkwright cache: look after the cache, where builds keep what they fetched and
made.

usage: linkwright cache info|gc|verify [--max-size SIZE] [cache.dir=FOLDER]

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
variable LINKWRIGHT_CACHE, else the platform's cache folder.

exit status: 0 done; 1 verify found corrupt files, or the folder cannot be used;
2 wrong usage
"""

_USAGE = "linkwright cache info|gc|verify; linkwright cache --help shows more"
_DIR = "cache.dir="
_SIZE = re.compile(r"(\d+(?:\.\d+)?)([KMGT]?)B?", re.IGNORECASE)
_POWERS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}
_DEFAULT_SIZE = 20 * 10**9
"""Size [bytes] to which `gc` shrinks the cache without `--max-size`."""

_SHOWN_CHARACTERS = 8
"""Characters of a key's hash that are shown."""


def run(arguments: Sequence[str], environ: Mapping[str, str] = os.environ) -> int:
    """Runs the verb and returns the exit status. Raises ConfigError for wrong usage, and CacheError if the
    cache folder cannot be used."""
    dirs = [text for text in arguments if text.startswith(_DIR)]
    rest = [text for text in arguments if text not in dirs]
    max_size = _max_size(rest)
    verbs: dict[str, Callable[[Path], int]] = {
        "info": _info,
        "gc": lambda root: _gc(root, _DEFAULT_SIZE if max_size is None else max_size),
        "verify": _verify,
    }
    if len(rest) != 1 or rest[0] not in verbs or (max_size is not None and rest[0] != "gc"):
        msg = f"expected info, gc or verify, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "cache", _USAGE)
    configured = dirs[-1].removeprefix(_DIR) if dirs else None
    return verbs[rest[0]](folder(configured, environ))


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


def _info(root: Path) -> int:
    summary = maintenance.summary(root)
    say(str(root))
    say(
        f"  {_size(summary.size)}: {count(summary.blobs, 'file')} and {count(summary.records, 'record')}, "
        f"{summary.replies} of them replies that were paid for"
    )
    years = ledger.years(root / ledger.FOLDER)
    say("API calls counted, by key (start of its hash) and year:" if years else "no API call counted")
    for year in years:
        key_start = year.who[:_SHOWN_CHARACTERS]
        kinds = ", ".join(f"{number} {kind}" for kind, number in year.calls.items())
        end = "; the quota is used up (402)" if year.exhausted else ""
        say(f"  {key_start:{_SHOWN_CHARACTERS}}  {year.year}  {year.counted:5d}  {kinds}{end}")
    return 0


def _gc(root: Path, max_size: int) -> int:
    result = maintenance.collect(root, max_size)
    for outputs in (Path("outputs"), *Path("outputs").glob("*.sweep")):
        maintenance.drop_locks(outputs / LOCKS)
    paid = f" ({result.paid} of them replies that were paid for)" if result.paid else ""
    say(f"{root}: {_size(result.freed)} freed, {_size(result.size)} left")
    say(f"  dropped {count(result.records, 'record')}{paid} and {count(result.blobs, 'file')}")
    if result.size > max_size:
        say(f"  more than {_size(max_size)} is left: the rest was used within the last hour; try again later")
    return 0


def _verify(root: Path) -> int:
    result = maintenance.verify(root)
    if not result.broken and not result.records:
        say(f"{root}: {count(result.blobs, 'file')}, all intact")
        return 0
    say(f"{root}: {count(result.blobs, 'file')}, {len(result.broken)} corrupt and removed")
    for digest in result.broken:
        say(f"  {digest}")
    say(
        f"  {count(result.records, 'record')} of missing files removed: "
        "the next build makes these files again"
    )
    if result.paid:
        say(f"  {result.paid} of them were replies: fetching them again costs as many API calls")
    return 1


def _size(number: int) -> str:
    for unit, power in (("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if number >= power:
            return f"{number / power:.2f} {unit}"
    return f"{number} bytes"
