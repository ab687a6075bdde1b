"""Lists the sources. Each is imported only when it is used: importing all would slow each plan by 20 ms."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.fetch.source import Source


def _onshape() -> type[Source]:
    from linkwright.stages.fetch.onshape.source import OnshapeSource  # as the table says

    return OnshapeSource


def _urdf() -> type[Source]:
    from linkwright.stages.fetch.urdf.source import UrdfSource  # as the table says

    return UrdfSource


def _mjcf() -> type[Source]:
    from linkwright.stages.fetch.mjcf.source import MjcfSource  # as the table says

    return MjcfSource


def _bundle() -> type[Source]:
    from linkwright.stages.fetch.bundle.source import BundleSource  # as the table says

    return BundleSource


def _sample() -> type[Source]:
    from linkwright.stages.fetch.bundle.sample.source import SampleSource  # as the table says

    return SampleSource


SOURCES: dict[str, Callable[[], type[Source]]] = {
    "onshape": _onshape,
    "urdf": _urdf,
    "mjcf": _mjcf,
    "bundle": _bundle,
    "sample": _sample,
}
"""Kind of source → the function that imports its class."""


def source_class(kind: str) -> type[Source]:
    """Returns the class of the sources of a kind."""
    return SOURCES[kind]()
