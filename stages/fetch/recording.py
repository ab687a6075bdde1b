"""Holds a recording: the content of a bundle's zip, from which the source of its kind makes a bundle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

MAX_BYTES = 1 << 30
"""Largest size [bytes] of a bundle that is read, both as a file and unpacked."""


@dataclass(frozen=True, slots=True)
class Recording:
    """The checked content of a zip: every digest of `requests` and `definition` is in `blobs`."""

    kind: str
    """Kind of the source from which the recording was made."""

    api: str
    """The version of Onshape's API, or ""."""

    root: Mapping[str, str]
    """The robot in its source, as in the manifest: the document, microversion, element and configuration of
    an assembly."""

    definition: str
    """The digest of the definition's reply, or of a robot's own file: a key of `blobs`."""

    requests: Mapping[str, str]
    """Request → digest of its reply."""

    blobs: Mapping[str, bytes]
    """Digest → content: the definition, and the replies to requests."""

    options: Mapping[str, str]
    """The reader's options for a robot's own file."""

    definition_api: str = ""
    """The version of the API for definitions, or ""."""
