"""Describes a bundle: the raw replies or files that a build reads, named by their requests."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from linkwright.stages.robot.errors import ProtocolError


@dataclass(frozen=True, slots=True, order=True)
class ElementKey:
    """A part studio or an assembly, in a configuration and at a fixed state of its document."""

    document: str
    """Id of the document."""
    pin: str
    """State of the document: `v/<version>` if it is linked by version, else `m/<microversion>`."""
    element: str
    """Id of the tab."""
    configuration: str
    """Configuration in Onshape's text, or "default"."""

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "ElementKey":
        """Returns the key of an instance or a part of an assembly definition."""
        version = record.get("documentVersion")
        pin = f"v/{version}" if version else f"m/{record['documentMicroversion']}"
        configuration = record.get("configuration") or "default"
        return cls(record["documentId"], pin, record["elementId"], configuration)


@dataclass(frozen=True, slots=True)
class Studio:
    """The digests of the replies about a part studio."""

    key: ElementKey
    mass: tuple[str, ...]
    """Mass properties: one reply for all parts or, in recorded data, one reply for each part."""
    tessellation: str | None
    """The triangles; None if they were not recorded."""


@dataclass(frozen=True, slots=True)
class Features:
    """The digests of the replies about the limits of an assembly's mates, for a definition that lacks
    limits."""

    key: ElementKey
    """The assembly."""

    features: str
    """The assembly's list of features."""
    variables: str | None = None
    """The assembly's variables; None if they are not needed or not available."""


@dataclass(frozen=True, slots=True)
class Bundle:
    """Raw replies or files, byte for byte: the fields that all kinds of bundles have."""

    kind: str
    """The kind of the source."""
    root: Mapping[str, str]
    """The robot: `document`, `microversion`, `element`, `configuration`."""
    definition: str
    """Digest of the assembly definition, or of a robot's own file or model."""
    requests: Mapping[str, str]
    """Name of each reply or file → SHA-256 of its body."""
    blobs: Mapping[str, bytes]
    """SHA-256 → body."""

    def body(self, digest: str) -> bytes:
        """Returns the body with this digest; raises ProtocolError if the bundle lacks it."""
        body = self.blobs.get(digest)
        if body is None:
            msg = f"the bundle lacks the reply with digest {digest}"
            raise ProtocolError(msg, hint="make the bundle again, or fetch with source.refresh=true")
        return body


@dataclass(frozen=True, slots=True)
class OnshapeBundle(Bundle):
    """The replies about an Onshape assembly. Its `requests` name a version or microversion."""

    api: str
    """Version of the API that was used."""
    studios: tuple[Studio, ...]
    features: tuple[Features, ...] = ()
    """Empty if the definition gives all limits."""
    definition_api: str = ""
    """Version of the API by which the definition was read; "" if it is `api`."""


@dataclass(frozen=True, slots=True)
class FileBundle(Bundle):
    """A robot's own file and its meshes."""

    options: Mapping[str, str] = field(default_factory=dict)
    """Options of the source that its reader needs (`bad_inertia`)."""
