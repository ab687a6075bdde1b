"""Checks the content of a reply before it is cached or used."""

from threading import Lock

import orjson

from linkwright.stages.fetch.onshape import configuration, definition
from linkwright.stages.fetch.onshape.replies import documents, features, mass_check
from linkwright.stages.fetch.onshape.requests import (
    describe,
    is_assembly_mass,
    is_definition,
    is_features,
    is_gltf,
    is_triangles,
)
from linkwright.stages.formats import triangles
from linkwright.stages.robot.errors import ProtocolError

NOT_JSON, NO_BODIES = "not JSON", "no bodies"
_PARSE_LOCK = Lock()
"""Lock for parsing: replies arrive in several threads, and only one at a time is in memory as Python
objects."""


def cached_form(request: str, body: bytes) -> bytes:
    """Returns the form in which a reply is cached: unchanged, except tessellated faces, which are in compact
    form. Raises the errors of `check`."""
    if triangles.is_compact(body):
        triangles.require_compact(body)
        return body
    if is_triangles(request):
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.onshape.triangles import faces

        return faces.compact(body)
    if is_gltf(request):
        # Late: an unchanged source is not read again.
        from linkwright.stages.formats.meshes import gltf

        gltf.read(body)
        return body
    check(request, body)
    return body


def compact_triangles(request: str, body: bytes, mass: bytes) -> bytes:
    """Returns the compact form of an accepted reply with triangles. Raises ProtocolError if its bodies are
    unclear.

    `mass`: the reply with the mass properties of the part studio, which identifies the bodies of a glTF.
    """
    if is_gltf(request) and not triangles.is_compact(body):
        # Late: an unchanged source is not read again.
        from linkwright.stages.fetch.onshape.triangles import gltf_parts

        return gltf_parts.compact(body, mass)
    return cached_form(request, body)


def check(request: str, body: bytes) -> None:
    """Raises ProtocolError if `body` does not parse or lacks the keys that every such reply has."""
    if is_definition(request):
        definition.read(body)
        return
    path = request.partition("?")[0]
    if path.startswith("/documents/"):
        read = documents.tab_microversions if path.endswith("/elements") else documents.microversion
        read(body)
        return
    if is_assembly_mass(request):
        mass_check.read_total(body)
        return
    if is_triangles(request) or is_gltf(request):
        cached_form(request, body)
        return
    if path.startswith("/elements/") and path.endswith("/configuration"):
        configuration.read_parameters(body)
        return
    if is_features(request) or path.startswith("/variables/"):
        features.check(body, describe(request), tables=not is_features(request))
        return
    with _PARSE_LOCK:
        fault = _fault_of_bodies(body)
    if fault == NOT_JSON:
        msg = f"the reply with {describe(request)} is not JSON, or was cut short"
        raise ProtocolError(msg, hint="run the same command again; what was fetched is kept")
    if fault:
        msg = f"the reply with {describe(request)} has no bodies"
        raise ProtocolError(
            msg, hint="run the same command again; if it fails each time, the API has changed"
        )


def _fault_of_bodies(body: bytes) -> str:
    """Returns the error of a reply that should have bodies, or "".

    The parsed reply, many times as large as `body`, ends here: an error raised from here would keep it.
    """
    try:
        data = orjson.loads(body)
    except orjson.JSONDecodeError:
        return NOT_JSON
    return "" if isinstance(data, dict) and isinstance(data.get("bodies"), dict) else NO_BODIES
