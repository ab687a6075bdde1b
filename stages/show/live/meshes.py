"""The meshes of the header: each once, thinned to what a page can show."""

import json
from collections import Counter
from typing import Any

from linkwright.stages.show.live import triangles
from linkwright.stages.show.live.decimate import fitted
from linkwright.stages.show.live.geoms import Source
from linkwright.stages.show.live.pack import Buffers
from linkwright.stages.show.live.triangles import Facets

Shown = tuple[dict[str, Any], Source | None]
"""A geom of the header and where its triangles are."""


def stored_meshes(model: Any, shown: list[Shown], most: int, buffers: Buffers) -> dict[str, Any]:
    """`geoms`, `meshes` and `thinned` of the header, the geoms with their `mesh` set.

    The visual meshes have at most `most` triangles, and so have those of the colliders and the ground. Meshes
    of one content are one; geoms whose meshes have no triangle are left out.
    """
    facets = {source: _facets(model, source) for _, source in shown if source is not None}
    kept = _thinned(facets, shown, most)
    entries: dict[str, dict[str, Any]] = {}
    order: dict[str, int] = {}
    numbers: dict[Source, int | None] = {}
    for key, one in kept.items():
        entry = triangles.stored(one, buffers)
        same = json.dumps(entry)
        if entry["faces"]:
            entries[same] = entry
        numbers[key] = order.setdefault(same, len(order)) if entry["faces"] else None
    geoms = []
    for geom, source in shown:
        number = None if source is None else numbers[source]
        if source is None or number is not None:
            geoms.append({**geom, "mesh": number})
    return {"geoms": geoms, "meshes": list(entries.values()), "thinned": _summary(kept, facets, shown)}


def _thinned(facets: dict[Source, Facets], shown: list[Shown], most: int) -> dict[Source, Facets]:
    found = dict(facets)
    for seen in (True, False):
        uses = Counter(
            source for geom, source in shown if source is not None and (geom["role"] == "visual") == seen
        )
        found |= fitted({source: found[source] for source in uses}, uses, most)
    return found


def _summary(
    kept: dict[Source, Facets], facets: dict[Source, Facets], shown: list[Shown]
) -> dict[str, int] | None:
    """How many triangles there are of how many; None where there are all."""
    uses = Counter(source for _, source in shown if source is not None)
    faces, of_faces = (
        sum(len(meshes[source].corners) * count for source, count in uses.items())
        for meshes in (kept, facets)
    )
    return {"faces": faces, "of_faces": of_faces} if faces < of_faces else None


def _facets(model: Any, source: Source) -> Facets:
    kind, index = source
    return triangles.of_hfield(model, index) if kind == "hfield" else triangles.of_mesh(model, index)
