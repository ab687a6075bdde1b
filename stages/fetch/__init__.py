"""Fetches a robot from its source: a source in, a `Bundle` out.

`sources` is the table of sources, `section` that of their configurations; each source has a folder of its
own. An Onshape document costs one call for its definition and two for each part studio, and a single call
where it did not change; a bundle and the sample replay recorded replies through the same code. A URDF or MJCF
is read with the meshes that it names.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from linkwright.stages.fetch.sources import SOURCES as SOURCES
from linkwright.stages.fetch.sources import source_class as source_class

if TYPE_CHECKING:
    from linkwright.stages.fetch.section import FetchSections
    from linkwright.stages.fetch.source import CallsAhead, FetchContext, Fetched, Source
    from linkwright.stages.robot.bundle import Bundle
    from linkwright.stages.robot.errors import Diagnostic

VERSION = 16
"""The version of the stage. It grows with every change of the stage's output for the same input."""


def source_of(keys: FetchSections) -> Source:
    """Returns the configured source."""
    return source_class(keys.source.kind)(keys.source)


def fetch(keys: FetchSections, context: FetchContext) -> Fetched:
    """Fetches the source that `keys.source` names, as a bundle.

    Raises ConfigError if a call is needed and there is no API key; SourceError or a subclass if the source
    cannot be read; AssemblyError if the assembly has no part.
    """
    return source_of(keys).fetch(context)


def survey(keys: FetchSections, context: FetchContext, *, masses: bool) -> Fetched:
    """Fetches only what describes the mechanism of the source that `keys.source` names.

    This is one call for an Onshape assembly, and with `masses` another for each part studio; the bundle then
    has no triangles, and without `masses` no mass properties. Other sources are fetched whole. Raises the
    errors of `fetch`.
    """
    return source_of(keys).survey(context, masses=masses)


def ahead(keys: FetchSections, context: FetchContext) -> CallsAhead:
    """Returns the calls that a fetch of a remote source will make. Raises the errors of `fetch`."""
    return source_of(keys).ahead(context)


def is_remote(keys: FetchSections) -> bool:
    """Tells whether the source is fetched from a server."""
    return source_class(keys.source.kind).remote


def preflight(keys: FetchSections, environ: Mapping[str, str]) -> None:
    """Raises ConfigError for errors of the source that are known before any work: address, file, missing
    key."""
    source_of(keys).preflight(environ)


def remarks(keys: FetchSections) -> tuple[Diagnostic, ...]:
    """Returns diagnostics about the place where the API key is read from."""
    return source_of(keys).remarks()


def spends(keys: FetchSections) -> bool:
    """Tells whether a fetch may make calls that count against a quota."""
    return source_of(keys).spends


def changes_document(keys: FetchSections) -> bool:
    """Tells whether a build changes the user's document, if only for a moment."""
    return source_of(keys).writes


def force(keys: FetchSections) -> bool:
    """Tells whether the source must be read again although nothing about it may have changed."""
    return source_of(keys).force


def describe(keys: FetchSections) -> dict[str, str]:
    """Returns the report's data about the source."""
    return {"kind": keys.source.kind, **source_of(keys).describe()}


def summary(bundle: Bundle) -> str:
    """Describes the content of a bundle in words: "12 replies about 3 part studios"."""
    return source_class(bundle.kind).summary(bundle)


def read_again(keys: Mapping[str, Any], environ: Mapping[str, str]) -> dict[str, Any] | None:
    """Returns the present result of `pinned` for a source on this computer whose keys are plain data, as
    `keys_to_read_again` returned them. Runs nothing, whatever the keys say: a xacro file is not trusted."""
    source = source_class(keys["kind"])(SimpleNamespace(**{**keys, "trust": False}))
    source.preflight(environ)
    return source.pinned(environ)


def keys_to_read_again(keys: FetchSections) -> dict[str, Any]:
    """Returns the keys of a source on this computer as plain data; {} for an address, which identifies its
    content."""
    is_local = source_class(keys.source.kind).on_this_computer
    return keys.source.model_dump(mode="json") if is_local else {}


def pinned(keys: FetchSections, environ: Mapping[str, str] | None = None) -> dict[str, Any] | None:
    """Returns the permanent identity of the source as plain data; None for a workspace, which changes.

    `environ` names the folders of ROS packages. Raises SourceError if a robot's file is not readable.
    """
    return source_of(keys).pinned(environ or {})
