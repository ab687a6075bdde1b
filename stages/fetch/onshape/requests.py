"""Writes the requests that a build makes, in their canonical form.

A request is the path below `/api/<version>` and its query with the keys in sorted order, percent-
encoded: the same text is sent, cached and written in bundles. Ids hold `/` and `+`.
"""

from collections.abc import Iterable, Mapping
from typing import Protocol
from urllib.parse import parse_qsl, quote

from linkwright.stages.robot.bundle import ElementKey

API = "v16"
"""The API version of all requests except definitions: the form of replies depends on it."""

DEFINITION_API = "v17"
"""The API version of requests for assembly definitions: from this version on they have the limits of mates.
Requests do not name their version, so replies that were cached at an earlier version stay valid."""

JSON = "application/json;charset=UTF-8; qs=0.09"
"""The accepted type of replies, except for glTF."""

_GLTF = "model/gltf-binary;qs=0.08"

_SUBJECT_BY_END = {
    "/configuration": "the configuration parameters of element",
    "/features": "the features of assembly",
    "/variables": "the variables of element",
}
_QUALITY_KEYS = {
    "angleTolerance",
    "chordTolerance",
    "maxFacetWidth",
    "outputFaceAppearances",
    "outputFacetNormals",
    "outputIndexTable",
}


class Tessellation(Protocol):
    """The fineness of triangles: `angle` [rad], `chord` [m], `max_facet_width` [m] or None."""

    @property
    def angle(self) -> float: ...
    @property
    def chord(self) -> float: ...
    @property
    def max_facet_width(self) -> float | None: ...


def definition(document: str, pin: str, element: str, configuration: str) -> str:
    """Returns the request for the assembly definition, at `pin` ("w/<id>", "v/<id>" or "m/<id>")."""
    query = {
        "configuration": configuration,
        "includeMateConnectors": "true",
        "includeMateFeatures": "true",
        "includeNonSolids": "true",
    }
    return _request(_element("assemblies", document, pin, element), query)


def current_microversion(document: str, workspace: str) -> str:
    """Returns the request for the present microversion of a workspace; `workspace` is its id."""
    pieces = [quote(piece, safe="") for piece in (document, workspace)]
    return "/documents/d/{}/w/{}/currentmicroversion".format(*pieces)


def configuration_asked(request: str) -> str:
    """Returns the configuration that a request is about, decoded; empty for the default configuration."""
    values = dict(parse_qsl(request.partition("?")[2], keep_blank_values=True))
    values_text = values.get("configuration", "default")
    return "" if values_text == "default" else values_text


def elements(document: str, microversion: str) -> str:
    """Returns the request for the tabs of a document at a microversion, each with a microversion of its
    own."""
    pieces = [quote(piece, safe="") for piece in (document, microversion)]
    return "/documents/d/{}/m/{}/elements".format(*pieces)


def assembly_mass_properties(document: str, pin: str, element: str, configuration: str) -> str:
    """Returns the request for the mass properties of the whole assembly, at `pin`."""
    path = _element("assemblies", document, pin, element)
    return _request(f"{path}/massproperties", {"configuration": configuration})


def configuration(document: str, pin: str, element: str) -> str:
    """Returns the request for the configuration parameters of an element, at `pin`."""
    return _element("elements", document, pin, element) + "/configuration"


def features(owner: ElementKey, root: str) -> str:
    """Returns the request for the features of a single assembly; `root` is the id of the root assembly's
    document."""
    path = _element("assemblies", owner.document, owner.pin, owner.element)
    return _request(path + "/features", _access(owner, root))


def variables(owner: ElementKey, root: str) -> str:
    """Returns the request for the variables that an element may use, values included.

    The server takes only workspaces ("w/<id>") and versions as pins; with a microversion the request is only
    the name under which the reply is cached.
    """
    path = _element("variables", owner.document, owner.pin, owner.element)
    query = {"includeValuesAndReferencedVariables": "true"} | _access(owner, root)
    return _request(path + "/variables", query)


def variable_studio(document: str, workspace: str, element: str) -> str:
    """Returns the request for the variables of a variable studio, to read and to write; `workspace` is its
    id."""
    return _element("variables", document, f"w/{workspace}", element) + "/variables"


def tabs(document: str, workspace: str) -> str:
    """Returns the request for the tabs of a workspace as they are now; `workspace` is its id."""
    pieces = [quote(piece, safe="") for piece in (document, workspace)]
    return "/documents/d/{}/w/{}/elements".format(*pieces)


def mass_properties(studio: ElementKey, root: str) -> str:
    """Returns the request for the mass properties of all parts of a studio; `root` is the id of the
    assembly's document."""
    query = {"massAsGroup": "false", "useMassPropertyOverrides": "true"} | _access(studio, root)
    return _request(_studio(studio) + "/massproperties", query)


def tessellated_faces(studio: ElementKey, root: str, quality: Tessellation, parts: Iterable[str] = ()) -> str:
    """Returns the request for the triangles of a studio's parts: of all, or of `parts` only.

    `root` is the id of the assembly's document.
    """
    query = {
        "angleTolerance": repr(float(quality.angle)),
        "chordTolerance": repr(float(quality.chord)),
        "outputFaceAppearances": "true",
        "outputFacetNormals": "false",
        "outputIndexTable": "true",
    } | _access(studio, root)
    if quality.max_facet_width is not None:
        query["maxFacetWidth"] = repr(float(quality.max_facet_width))
    return _request(_studio(studio) + "/tessellatedfaces", query, parts)


def gltf(studio: ElementKey, root: str, quality: Tessellation, parts: Iterable[str] = ()) -> str:
    """Returns the request for the same triangles as `tessellated_faces`, as glTF."""
    query = {
        "angleTolerance": repr(float(quality.angle)),
        "chordTolerance": repr(float(quality.chord)),
        "outputFaceAppearances": "true",
    } | _access(studio, root)
    if quality.max_facet_width is not None:
        query["maxFacetWidth"] = repr(float(quality.max_facet_width))
    return _request(_studio(studio) + "/gltf", query, parts)


def recorded_faces(studio: ElementKey) -> str:
    """Returns the request for the triangles of a studio in a recording, which has a single quality."""
    return _request(_studio(studio) + "/tessellatedfaces", {"configuration": studio.configuration})


def recorded_gltf(studio: ElementKey) -> str:
    """Returns the request for the glTF of a studio in a recording."""
    return _request(_studio(studio) + "/gltf", {"configuration": studio.configuration})


def part_mass_properties(studio: ElementKey, part: str) -> str:
    """Returns the request for the mass properties of a part, as other clients record it."""
    path = _element("parts", studio.document, studio.pin, studio.element)
    query = {"configuration": studio.configuration}
    return _request(f"{path}/partid/{quote(part, safe='')}/massproperties", query)


def subject(request: str) -> tuple[str, tuple[tuple[str, str], ...]]:
    """Returns the subject of a request: path and query without triangle quality, choice of parts and access.

    For recordings, which have only one quality.
    """
    path, _, query = request.partition("?")
    if path.startswith("/parts/"):
        # Recordings are part by part: clients send many different switches here, or no switch.
        subject_query = {"configuration": dict(parse_qsl(query)).get("configuration", "default")}
    else:
        pairs = parse_qsl(query, keep_blank_values=True)
        ignored_keys = {
            *_QUALITY_KEYS,
            "linkDocumentId",
            *(() if path.endswith("/massproperties") else ("partId",)),
        }
        subject_query = {key: value for key, value in pairs if key not in ignored_keys}
        subject_query["configuration"] = subject_query.get("configuration") or "default"
    return path, tuple(sorted(subject_query.items()))


def describe(request: str) -> str:
    """Describes a request in words, for messages: "the mass properties of part studio <id>"."""
    path = request.partition("?")[0]
    element = path.partition("/e/")[2].partition("/")[0]
    if path.startswith("/documents/"):
        document = path.split("/")[3]
        subject_text = "the tabs" if path.endswith("/elements") else "the current microversion"
        return f"{subject_text} of document {document}"
    if is_assembly_mass(request):
        return f"the mass of assembly {element}"
    for end, subject_text in _SUBJECT_BY_END.items():
        if path.endswith(end):
            return f"{subject_text} {element}"
    if path.startswith("/assemblies/"):
        return f"the definition of assembly {element}"
    subject_text = "the mass properties" if path.endswith("/massproperties") else "the triangles"
    return f"{subject_text} of part studio {element}"


def api(request: str) -> str:
    """Returns the API version that a request is made at."""
    return DEFINITION_API if is_definition(request) else API


def is_definition(request: str) -> bool:
    """Tells whether a request is for an assembly definition."""
    path = request.partition("?")[0]
    return path.startswith("/assemblies/") and "/" not in path.partition("/e/")[2]


def is_triangles(request: str) -> bool:
    """Tells whether a request is for triangles."""
    return request.partition("?")[0].endswith("/tessellatedfaces")


def is_gltf(request: str) -> bool:
    """Tells whether a request is for triangles as glTF."""
    return request.partition("?")[0].endswith("/gltf")


def accept(request: str) -> str:
    """Returns the Accept header of a request; the server refuses another form (406)."""
    return _GLTF if is_gltf(request) else JSON


def is_features(request: str) -> bool:
    """Tells whether a request is for the features of an assembly."""
    path = request.partition("?")[0]
    return path.startswith("/assemblies/") and path.endswith("/features")


def is_assembly_mass(request: str) -> bool:
    """Tells whether a request is for the mass properties of a whole assembly."""
    path = request.partition("?")[0]
    return path.startswith("/assemblies/") and path.endswith("/massproperties")


def _access(studio: ElementKey, root: str) -> dict[str, str]:
    query = {"configuration": studio.configuration}
    if studio.document != root:
        query["linkDocumentId"] = root
    return query


def _studio(studio: ElementKey) -> str:
    return _element("partstudios", studio.document, studio.pin, studio.element)


def _element(kind: str, document: str, pin: str, element: str) -> str:
    letter, _, identity = pin.partition("/")
    pieces = [quote(piece, safe="") for piece in (document, letter, identity, element)]
    return "/{}/d/{}/{}/{}/e/{}".format(kind, *pieces)


def _request(path: str, query: Mapping[str, str], parts: Iterable[str] = ()) -> str:
    pairs = sorted([*query.items(), *(("partId", part) for part in set(parts))])
    return path + "?" + "&".join(f"{key}={quote(value, safe='')}" for key, value in pairs)
