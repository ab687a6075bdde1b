"""Defines the document of `linkwright cache`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from linkwright.pipeline.json_documents.document import CommandDocument


@dataclass(frozen=True)
class CallsDocument:
    """The calls of an API key in a year that count against its quota, as far as builds with this cache made
    them.

    key: the start of the hash of the key.
    year: the calendar year (UTC).
    counted: the number of calls.
    calls: the number of calls by endpoint.
    exhausted: whether the quota is used up (402).
    """

    key: str
    year: int
    counted: int
    calls: Mapping[str, int]
    exhausted: bool


@dataclass(frozen=True)
class CacheInfo:
    """The content of the cache.

    size: its size [bytes].
    files: the number of stored files.
    records: the number of records that name them.
    replies: the number of records of replies, which cost an API call each.
    years: the API calls by key and year.
    """

    size: int
    files: int
    records: int
    replies: int
    years: tuple[CallsDocument, ...]


@dataclass(frozen=True)
class CacheCleared:
    """The result of `linkwright cache gc`.

    freed: the size of the removed files [bytes].
    size: the size of the remaining files [bytes].
    limit: the size that was asked for [bytes]; more remains if the rest was used within the last hour.
    files: the number of removed files.
    records: the number of removed records.
    paid: the number of removed records that cost API calls to make again.
    """

    freed: int
    size: int
    limit: int
    files: int
    records: int
    paid: int


@dataclass(frozen=True)
class CacheVerified:
    """The result of `linkwright cache verify`.

    files: the number of files that were read.
    corrupt: the SHA-256 that each corrupt file should have; they were removed.
    records: the number of removed records, which named corrupt or missing files.
    paid: the number of removed records that cost API calls to make again.
    """

    files: int
    corrupt: tuple[str, ...]
    records: int
    paid: int


@dataclass(frozen=True)
class CacheDocument(CommandDocument):
    """The cache (`linkwright cache info|gc|verify`).

    exit_status: 0: done; 1: `verify` found corrupt files.
    folder: the cache folder.
    info: the content, for `info`; else null.
    cleared: the result of `gc`; else null.
    verified: the result of `verify`; else null.
    """

    FORMAT: ClassVar[str] = "linkwright-cache"

    exit_status: int
    folder: str
    info: CacheInfo | None = None
    cleared: CacheCleared | None = None
    verified: CacheVerified | None = None
