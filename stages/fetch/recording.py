"""A recording: the content of a bundle's zip, from which the source of its kind makes a bundle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

LARGEST = 1 << 30
"""Larger bundles are not read: neither as a file nor unpacked [bytes]."""


@dataclass(frozen=True, slots=True)
class Recording:
    """The checked content of a zip: every digest of `requests` and `definition` is in `blobs`.

    `api` and `definition_api`: the versions of Onshape's API, "" for none; `options`: the reader's options of
    a robot's own file.
    """

    kind: str
    api: str
    root: Mapping[str, str]
    definition: str
    requests: Mapping[str, str]
    blobs: Mapping[str, bytes]
    options: Mapping[str, str]
    definition_api: str = ""
