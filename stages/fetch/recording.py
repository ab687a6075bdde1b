"""Holds a recording: the content of a bundle's zip, from which the source of its kind makes a bundle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

LARGEST = 1 << 30
"""Largest size of a bundle that is read, as a file and unpacked [bytes]."""


@dataclass(frozen=True, slots=True)
class Recording:
    """The checked content of a zip: every digest of `requests` and `definition` is in `blobs`."""

    kind: str
    """The kind of source that the recording was made from."""

    api: str
    """The version of Onshape's API, or ""."""

    root: Mapping[str, str]
    definition: str
    """The digest of the definition."""

    requests: Mapping[str, str]
    """Request → digest of its reply."""

    blobs: Mapping[str, bytes]
    """Digest → content."""

    options: Mapping[str, str]
    """The reader's options for a robot's own file."""

    definition_api: str = ""
    """The version of the API for definitions, or ""."""
