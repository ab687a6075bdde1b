"""The requests that a build makes, in one canonical form.

A request is the path below `/api/<version>` and its query with the keys in sorted order, percent-
encoded: the same text is sent, cached and written in bundles. Ids hold `/` and `+`.
"""

from collections.abc import Mapping
from typing import Protocol
from urllib.parse import parse_qsl, quote

from stages.robot.bundle import StudioKey

API = "v16"
"""The API version that is asked: the shape of replies depends on it."""

_QUALITY = {
    "angleTolerance",
    "chordTolerance",
    "maxFacetWidth",
    "outputFaceAppearances",
    "outputFacetNormals",
    "outputIndexTable",
}


class Tessellation(Protocol):
    """How fine the triangles are: `angle` [rad], `chord` [m], `max_facet_width` [m] or None."""

    @property
    def angle(self) -> float: ...
    @property
    def chord(self) -> float: ...
    @property
    def max_facet_width(self) -> float | None: ...


def definition(document: str, pin: str, element: str, configuration: str) -> str:
    """The assembly definition, at `pin` ("w/<id>", "v/<id>" or "m/<id>")."""
    query = {
        "configuration": configuration,
        "includeMateConnectors": "true",
        "includeMateFeatures": "true",
        "includeNonSolids": "true",
    }
    return _request(_element("assemblies", document, pin, element), query)


def mass_properties(studio: StudioKey, root: str) -> str:
    """The mass properties of all parts of a studio; `root` is the id of the assembly's document."""
    query = {"massAsGroup": "false", "useMassPropertyOverrides": "true"} | _access(studio, root)
    return _request(_studio(studio) + "/massproperties", query)


def tessellated_faces(studio: StudioKey, root: str, quality: Tessellation) -> str:
    """The triangles of all parts of a studio; `root` is the id of the assembly's document."""
    query = {
        "angleTolerance": repr(float(quality.angle)),
        "chordTolerance": repr(float(quality.chord)),
        "outputFaceAppearances": "true",
        "outputFacetNormals": "false",
        "outputIndexTable": "true",
    } | _access(studio, root)
    if quality.max_facet_width is not None:
        query["maxFacetWidth"] = repr(float(quality.max_facet_width))
    return _request(_studio(studio) + "/tessellatedfaces", query)


def recorded_faces(studio: StudioKey) -> str:
    """The triangles of a studio in a recording, which has one quality: the one it was made with."""
    return _request(_studio(studio) + "/tessellatedfaces", {"configuration": studio.configuration})


def part_mass_properties(studio: StudioKey, part: str) -> str:
    """One part's mass properties, as other clients record them."""
    path = _element("parts", studio.document, studio.pin, studio.element)
    query = {"configuration": studio.configuration}
    return _request(f"{path}/partid/{quote(part, safe='')}/massproperties", query)


def subject(request: str) -> tuple[str, tuple[tuple[str, str], ...]]:
    """What a request is about: path and query without triangle quality and way of access.

    For recordings: what they hold is what there is, whatever quality was asked for.
    """
    path, _, query = request.partition("?")
    if path.startswith("/parts/"):
        # Recorded part by part: clients send many different switches here, or none.
        kept = {"configuration": dict(parse_qsl(query)).get("configuration", "default")}
    else:
        pairs = parse_qsl(query, keep_blank_values=True)
        kept = {key: value for key, value in pairs if key not in _QUALITY and key != "linkDocumentId"}
        kept["configuration"] = kept.get("configuration") or "default"
    return path, tuple(sorted(kept.items()))


def describe(request: str) -> str:
    """A request in words, for messages: "the mass properties of part studio <id>"."""
    path = request.partition("?")[0]
    element = path.partition("/e/")[2].partition("/")[0]
    if path.startswith("/assemblies/"):
        return f"the definition of assembly {element}"
    what = "the mass properties" if path.endswith("/massproperties") else "the triangles"
    return f"{what} of part studio {element}"


def is_definition(request: str) -> bool:
    return request.startswith("/assemblies/")


def _access(studio: StudioKey, root: str) -> dict[str, str]:
    query = {"configuration": studio.configuration}
    if studio.document != root:
        query["linkDocumentId"] = root
    return query


def _studio(studio: StudioKey) -> str:
    return _element("partstudios", studio.document, studio.pin, studio.element)


def _element(kind: str, document: str, pin: str, element: str) -> str:
    letter, _, identity = pin.partition("/")
    pieces = [quote(piece, safe="") for piece in (document, letter, identity, element)]
    return "/{}/d/{}/{}/{}/e/{}".format(kind, *pieces)


def _request(path: str, query: Mapping[str, str]) -> str:
    return path + "?" + "&".join(f"{key}={quote(query[key], safe='')}" for key in sorted(query))
