"""Fetch: a source in, a `Bundle` out.

`sources` is the table of sources, `section` that of their configurations; each source lies in a room of its
own. An Onshape document costs one call for its definition and two for each part studio, and one where it did
not change since; a bundle and the sample replay recorded replies through the same code. A URDF or MJCF is
read with the meshes that it names.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from linkwright.stages.fetch.sources import SOURCES as SOURCES
from linkwright.stages.fetch.sources import source_class as source_class

if TYPE_CHECKING:
    from linkwright.stages.fetch.section import FetchSections
    from linkwright.stages.fetch.source import FetchContext, Fetched, Source
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.errors import Diagnostic

VERSION = 13
"""Grows with every change of what this stage makes of the same input."""


def source_of(keys: FetchSections) -> Source:
    """The source that is configured."""
    return source_class(keys.source.kind)(keys.source)


def fetch(keys: FetchSections, context: FetchContext) -> Fetched:
    """The bundle of what `keys.source` names.

    ConfigError where a call is needed and there is no API key; SourceError and its kinds where the
    source cannot be read; AssemblyError where the assembly has no part.
    """
    return source_of(keys).fetch(context)


def preflight(keys: FetchSections, environ: Mapping[str, str]) -> None:
    """ConfigError for what is wrong with the source before any work: address, file, missing key."""
    source_of(keys).preflight(environ)


def remarks(keys: FetchSections) -> tuple[Diagnostic, ...]:
    """Diagnostics about the place that the API key is read from."""
    return source_of(keys).remarks()


def spends(keys: FetchSections) -> bool:
    """Whether a fetch may make calls that count against a quota."""
    return source_of(keys).spends


def writes(keys: FetchSections) -> bool:
    """Whether a build changes the user's document, if only for a moment."""
    return source_of(keys).writes


def force(keys: FetchSections) -> bool:
    """Whether the source must be read again although nothing about it may have changed."""
    return source_of(keys).force


def describe(keys: FetchSections) -> dict[str, str]:
    """The source as the report names it."""
    return {"kind": keys.source.kind, **source_of(keys).describe()}


def summary(bundle: Bundle) -> str:
    """What a bundle holds, in words: "12 replies about 3 part studios"."""
    return source_class(bundle.kind).summary(bundle)


def read_again(keys: Mapping[str, Any], environ: Mapping[str, str]) -> dict[str, Any] | None:
    """What `pinned` says now of a source whose keys are plain data: those of a source on this computer, as
    `keys_to_read_again` gave them. Runs nothing, whatever they say: a xacro file is not trusted."""
    source = source_class(keys["kind"])(SimpleNamespace(**{**keys, "trust": False}))
    source.preflight(environ)
    return source.pinned(environ)


def keys_to_read_again(keys: FetchSections) -> dict[str, Any]:
    """The keys of a source on this computer as plain data; {} of an address, which stands for its content."""
    here = source_class(keys.source.kind).on_this_computer
    return keys.source.model_dump(mode="json") if here else {}


def pinned(keys: FetchSections, environ: Mapping[str, str] | None = None) -> dict[str, Any] | None:
    """What identifies the source for ever, as plain data; None for a workspace, which changes.

    `environ` names the folders of ROS packages. SourceError where a robot's file is not readable.
    """
    return source_of(keys).pinned(environ or {})
