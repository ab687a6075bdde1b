"""A bundle: the raw replies that a build reads, pinned and named by their requests."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stages.robot.errors import ProtocolError


@dataclass(frozen=True, slots=True, order=True)
class StudioKey:
    """One part studio in one configuration, pinned.

    `pin` is `v/<version>` where the document is linked by version, else `m/<microversion>`.
    """

    document: str
    pin: str
    element: str
    configuration: str

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "StudioKey":
        """The key of an instance or a part of an assembly definition."""
        version = record.get("documentVersion")
        pin = f"v/{version}" if version else f"m/{record['documentMicroversion']}"
        configuration = record.get("configuration") or "default"
        return cls(record["documentId"], pin, record["elementId"], configuration)


@dataclass(frozen=True, slots=True)
class Studio:
    """The replies about one part studio, by digest.

    `mass`: mass properties (one reply for all parts, or one a part in recorded data);
    `tessellation`: the triangles, or None where none were recorded.
    """

    key: StudioKey
    mass: tuple[str, ...]
    tessellation: str | None


@dataclass(frozen=True, slots=True)
class Features:
    """What one assembly says about its mates' limits where the definition does not, by digest.

    `features`: its list of features; `variables`: its variables, None where they are not needed or
    cannot be had.
    """

    key: StudioKey
    features: str
    variables: str | None = None


@dataclass(frozen=True, slots=True)
class Bundle:
    """Raw replies, kept byte for byte.

    `root` names the assembly: `document`, `microversion`, `element`, `configuration`.
    `definition` is the digest of the assembly definition; `requests` maps each request (the path
    below `/api/<version>` with its query, pinned to a version or microversion) to the SHA-256 of
    its body; `blobs` maps that digest to the body; `features` is empty where the definition gives all
    limits. `api` is the version of the API that was asked, `definition_api` that of the definition, "" for
    the same. `options`: what the source was told that concerns its reader (`bad_inertia`).
    """

    kind: str
    api: str
    root: Mapping[str, str]
    definition: str
    studios: tuple[Studio, ...]
    requests: Mapping[str, str]
    blobs: Mapping[str, bytes]
    features: tuple[Features, ...] = ()
    options: Mapping[str, str] = field(default_factory=dict)
    definition_api: str = ""

    def body(self, digest: str) -> bytes:
        """The body with this digest; ProtocolError where the bundle lacks it."""
        body = self.blobs.get(digest)
        if body is None:
            msg = f"the bundle lacks the reply with digest {digest}"
            raise ProtocolError(msg, hint="make the bundle again, or fetch with source.refresh=true")
        return body
