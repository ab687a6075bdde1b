"""Reads and writes job lists: files with the jobs of a sweep, for any scheduler to run.

A job list is a command line, split into numbered jobs. With the same files, a job gives the same result on
another computer. Relative paths start from the command's working folder, which is stored relative to the
list's folder. A list contains no secrets.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError, OutputError, reason
from linkwright.pipeline.output.replacing import replace
from linkwright.stages.robot import codec

VERSION_KEY = "linkwright-jobs"
"""The key that identifies a list, and holds its version."""

VERSION = 1

_WRITE_HINT = "a sweep writes a list: linkwright -m robot=my_arm root=fixed,free --plan FILE"

Share = tuple[int, int]
"""A share of the jobs: (3, 8) is the third of eight shares, whose sizes differ by at most one job."""


@dataclass(frozen=True, slots=True)
class ListedJob:
    """A job in a job list."""

    number: int
    label: str
    overrides: Mapping[str, Any]
    """The overrides of the job: key → value."""

    digest: str
    """The digest of the job's whole configuration."""

    folder: str
    """The output folder, without `suffix`."""

    suffix: str = ""
    """The suffix of the output folder of a build up to a stage before the export."""

    source: int | None = None
    """The number of the first job that builds from the same replies of a server; None without a server."""

    pin: str = ""
    """The version or microversion that the job builds; "" before it is known."""


@dataclass(frozen=True, slots=True)
class JobList:
    """A job list: a sweep's command line and its jobs."""

    cwd: str
    """The working folder of the command, relative to the folder of the list."""

    config_dirs: tuple[str, ...]
    overrides: tuple[str, ...]
    folder: str
    """The folder of the sweep."""

    calls: int
    """The number of API calls that fetching the sources will make; a lower bound if not `exact`."""

    exact: bool
    jobs: tuple[ListedJob, ...] = field(default_factory=tuple)

    def share(self, share: Share | None) -> list[ListedJob]:
        """Returns the jobs of a share; all jobs without a share."""
        part, parts = share or (1, 1)
        return [job for job in self.jobs if job.number % parts == part - 1]

    @property
    def sources(self) -> list[ListedJob]:
        """The first job of each configuration that is fetched from a server."""
        return [job for job in self.jobs if job.source == job.number]


def read(path: Path) -> JobList:
    """Reads a job list; raises ConfigError if the file is not a valid list."""
    try:
        data = json.loads(path.read_bytes())
    except OSError as error:
        raise ConfigError(f"cannot be read: {reason(error)}", str(path), _WRITE_HINT) from None
    except (ValueError, RecursionError):
        raise ConfigError("is not a list of jobs: it is not JSON", str(path), _WRITE_HINT) from None
    version = data.pop(VERSION_KEY, None) if isinstance(data, dict) else None
    if version is None:
        raise ConfigError("is not a list of jobs", str(path), _WRITE_HINT)
    if version != VERSION:
        msg = f"is a list of jobs of version {version}, and this linkwright reads version {VERSION}"
        raise ConfigError(msg, str(path), "write it again with this linkwright: add --plan FILE to the sweep")
    try:
        job_list: JobList = codec.typed(JobList, data)
        if not _is_sound(job_list):
            raise ValueError
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ConfigError("is a damaged list of jobs", str(path), _WRITE_HINT) from None
    return job_list


def _is_sound(job_list: JobList) -> bool:
    """Tells whether the values that are used before a job is composed have the right types, and whether all
    folders are inside the sweep's."""
    texts = [job_list.cwd, job_list.folder, *job_list.config_dirs, *job_list.overrides]
    texts += [
        text for job in job_list.jobs for text in (job.label, job.digest, job.folder, job.suffix, job.pin)
    ]
    are_mappings = all(isinstance(job.overrides, dict) for job in job_list.jobs)
    sources = {None, *range(len(job_list.jobs))}
    are_numbered = all(
        job.number == index and job.source in sources for index, job in enumerate(job_list.jobs)
    )
    have_types = are_mappings and are_numbered and all(isinstance(text, str) for text in texts)
    return (
        bool(job_list.jobs)
        and have_types
        and all(_is_inside(job, Path(job_list.folder)) for job in job_list.jobs)
    )


def _is_inside(job: ListedJob, root: Path) -> bool:
    """Tells whether the folder of a job is below that of the sweep."""
    folder = Path(job.folder)
    if not folder.is_relative_to(root) or "/" in job.suffix:
        return False
    inside = folder.relative_to(root).parts
    return bool(inside) and ".." not in inside


def require_place(path: Path) -> None:
    """Raises ConfigError if a list cannot be written, or if that would replace another file."""
    if not path.absolute().parent.is_dir():
        raise ConfigError(f"there is no folder {path.parent}", "--plan", "make it, or name another place")
    if path.exists():
        try:
            read(path)
        except ConfigError as error:
            msg = "another file is there, which would be lost"
            raise ConfigError(msg, str(path), "name a new file, or remove it") from error


def write(path: Path, job_list: JobList) -> None:
    """Writes the list, at a place that `require_place` accepts. Raises OutputError if that fails."""
    try:
        replace(path, "".join(_lines(job_list)).encode())
    except OSError as error:
        raise OutputError(f"the list of jobs cannot be written: {reason(error)}", str(path)) from error


def _lines(job_list: JobList) -> Iterator[str]:
    """Yields the text of the file, with a line for each job."""
    head = {VERSION_KEY: VERSION, **{key: value for key, value in asdict(job_list).items() if key != "jobs"}}
    yield json.dumps(head, indent=1, ensure_ascii=False)[:-2]
    yield ',\n "jobs": ['
    for index, job in enumerate(job_list.jobs):
        yield f"{',' if index else ''}\n  {json.dumps(asdict(job), ensure_ascii=False)}"
    yield "\n ]\n}\n"


class Digests:
    """The digests of configurations: each the SHA-256 of the `config.yaml` that its build writes.

    The jobs of a sweep share most sections, so the text of each section is made only once.
    """

    def __init__(self) -> None:
        self._texts: dict[tuple[str, str], bytes] = {}

    def of(self, tree: Mapping[str, Any]) -> str:
        return sha256(b"".join(self._text(key, value) for key, value in tree.items()))

    def _text(self, key: str, value: Any) -> bytes:
        entry = (key, repr(value))
        if entry not in self._texts:
            self._texts[entry] = as_yaml({key: value})
        return self._texts[entry]


def split_share(arguments: Sequence[str]) -> tuple[list[str], Share | None]:
    """Returns the arguments without `--shard K/N`, and its share; raises ConfigError if K/N is invalid."""
    rest = list(arguments)
    for index, argument in enumerate(arguments):
        option, equal, text = argument.partition("=")
        if option != "--shard":
            continue
        text = text if equal else "".join(arguments[index + 1 : index + 2])
        part, slash, parts = text.partition("/")
        if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
            msg = f"expected a share such as 3/8, the third of eight (given {text or 'nothing'})"
            raise ConfigError(msg, option, f"{option} 1/8 to {option} 8/8")
        del rest[index : index + (1 if equal else 2)]
        return rest, (int(part), int(parts))
    return rest, None


def job_numbered(job_list: JobList, text: str, path: Path) -> ListedJob:
    """Returns the job with a number, given as text; raises ConfigError if there is no such job."""
    if text.isdecimal() and int(text) < len(job_list.jobs):
        return job_list.jobs[int(text)]
    msg = f"has no job {text}: its jobs have the numbers 0 to {len(job_list.jobs) - 1}"
    raise ConfigError(msg, str(path), f"linkwright jobs {path} lists them")
