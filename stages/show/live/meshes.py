"""Stores the meshes of the header, each once, simplified to the number of triangles that a page can show."""

import json
from collections import Counter
from typing import Any

from linkwright.stages.show.live import triangles
from linkwright.stages.show.live.decimate import simplify_to_budget
from linkwright.stages.show.live.geoms import Source
from linkwright.stages.show.live.pack import Buffers
from linkwright.stages.show.live.triangles import Facets

Shown = tuple[dict[str, Any], Source | None]
"""A geom of the header and the source of its triangles."""


def stored_meshes(
    model: Any, geom_sources: list[Shown], max_triangles: int, buffers: Buffers
) -> dict[str, Any]:
    """Returns `geoms`, `meshes` and `simplified` of the header, with the key `mesh` of each geom.

    The visual meshes have at most `max_triangles` triangles together, and so have the meshes of the colliders
    and the ground. Meshes with equal content are stored once; geoms whose meshes have no triangles are
    dropped.
    """
    facets = {source: _facets(model, source) for _, source in geom_sources if source is not None}
    simplified = _simplified(facets, geom_sources, max_triangles)
    entries: dict[str, dict[str, Any]] = {}
    order: dict[str, int] = {}
    index_of_source: dict[Source, int | None] = {}
    for key, mesh in simplified.items():
        entry = triangles.store(mesh, buffers)
        content = json.dumps(entry)
        if entry["faces"]:
            entries[content] = entry
        index_of_source[key] = order.setdefault(content, len(order)) if entry["faces"] else None
    geoms = []
    for geom, source in geom_sources:
        number = None if source is None else index_of_source[source]
        if source is None or number is not None:
            geoms.append({**geom, "mesh": number})
    return {
        "geoms": geoms,
        "meshes": list(entries.values()),
        "thinned": _summary(simplified, facets, geom_sources),
    }


def _simplified(
    facets: dict[Source, Facets], geom_sources: list[Shown], max_triangles: int
) -> dict[Source, Facets]:
    simplified = dict(facets)
    for is_visual in (True, False):
        uses = Counter(
            source
            for geom, source in geom_sources
            if source is not None and (geom["role"] == "visual") == is_visual
        )
        simplified |= simplify_to_budget({source: simplified[source] for source in uses}, uses, max_triangles)
    return simplified


def _summary(
    simplified: dict[Source, Facets], facets: dict[Source, Facets], geom_sources: list[Shown]
) -> dict[str, int] | None:
    """Returns the numbers of triangles after and before simplification; None if they are equal."""
    uses = Counter(source for _, source in geom_sources if source is not None)
    faces, of_faces = (
        sum(len(meshes[source].corners) * count for source, count in uses.items())
        for meshes in (simplified, facets)
    )
    return {"faces": faces, "of_faces": of_faces} if faces < of_faces else None


def _facets(model: Any, source: Source) -> Facets:
    kind, index = source
    return (
        triangles.facets_of_hfield(model, index)
        if kind == "hfield"
        else triangles.facets_of_mesh(model, index)
    )
