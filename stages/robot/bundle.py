"""A bundle: the raw replies that a build reads, pinned and named by their requests."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.robot.errors import ProtocolError


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
    """The replies about the limits of one assembly's mates, where the definition lacks them, by digest.

    `features`: its feature list; `variables`: its variables, None where they are not needed or not available.
    """

    key: StudioKey
    features: str
    variables: str | None = None


@dataclass(frozen=True, slots=True)
class Bundle:
    """Raw replies or files, byte for byte: the common part of all kinds of bundle.

    `root` names the robot: `document`, `microversion`, `element`, `configuration`. `definition` is the
    digest of the assembly definition, or of a robot's own text or model; `requests` maps the name of each
    reply or file to the SHA-256 of its body; `blobs` maps that digest to the body.
    """

    kind: str
    root: Mapping[str, str]
    definition: str
    requests: Mapping[str, str]
    blobs: Mapping[str, bytes]

    def body(self, digest: str) -> bytes:
        """The body with this digest; ProtocolError where the bundle lacks it."""
        body = self.blobs.get(digest)
        if body is None:
            msg = f"the bundle lacks the reply with digest {digest}"
            raise ProtocolError(msg, hint="make the bundle again, or fetch with source.refresh=true")
        return body


@dataclass(frozen=True, slots=True)
class OnshapeBundle(Bundle):
    """The replies about an Onshape assembly. `requests` are pinned to a version or microversion.

    `api` is the version of the API that was asked, `definition_api` that of the definition, "" for the
    same; `features` is empty where the definition gives all limits.
    """

    api: str
    studios: tuple[Studio, ...]
    features: tuple[Features, ...] = ()
    definition_api: str = ""


@dataclass(frozen=True, slots=True)
class FileBundle(Bundle):
    """A robot's own file and its meshes.

    `options`: those of the source that concern its reader (`bad_inertia`).
    """

    options: Mapping[str, str] = field(default_factory=dict)
