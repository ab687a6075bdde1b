"""Writes the report's tables about a robot's geometry, and shows the progress of the mesh stage."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.caching.actions import MemoResult
from linkwright.pipeline.stages.context import notes
from linkwright.stages.robot.contact.exclude_names import excluded_colliders
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.pipeline.stages.context import BuildContext
    from linkwright.stages.mesh import Shown
    from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Geometry, Touch

_MM_PER_M = 1e3


def mesh_notes(geometry: "Geometry", results: Sequence[MemoResult]) -> bytes:
    """Returns the notes of the mesh stage. `results`: the results inside the stage, new or cached."""
    files = {shape.file for shape in geometry.shapes if shape.file is not None}
    figures = {"meshes": len(files), "triangles": sum(shape.faces for shape in geometry.shapes)}
    summary = f"{count(figures['meshes'], 'mesh', 'meshes')}, {count(figures['triangles'], 'triangle')}"
    tables = details(geometry, results)
    return notes(summary, geometry.diagnostics, figures, details=tables, lasts=geometry.lasts)


def details(geometry: "Geometry", results: Sequence[MemoResult] = ()) -> dict[str, Any]:
    """Returns the report's tables about the geometry: lists of rows by name.

    - `colliders`: how the parts of each link collide; lengths in mm, volumes as shares of the part's volume.
      `seconds`: the time to make the collider, when it was made; 0 for all but the first of several equal
      parts. `cached`: whether it was made before this build, by `results`, those inside the stage.
    - `links`: totals of each link. `geoms` counts the shapes with which an engine collides, also the user's.
    - `excludes`: the pairs of links that do not collide with each other, with the reason, and their depth in
      each other at `home` [mm]; empty if the robot does not collide with itself. If only some colliders of a
      pair are excluded, `colliders` names these for each link, and `geoms` lists their pairs by position.
    - `touching`: the pairs that collide and touch at `home`.
    """
    excludes = [_exclude(exclude, geometry) for exclude in geometry.excludes]
    touching = [_pair(pair) for pair in geometry.touching]
    colliders = _colliders(geometry.colliders, results)
    tables = {
        "colliders": colliders,
        "links": _links(geometry, colliders),
        "excludes": excludes,
        "touching": touching,
    }
    return {name: rows for name, rows in tables.items() if rows}


def as_cached(details: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the tables of a stage whose result comes from the cache: all colliders count as cached."""
    rows = [{**row, "cached": True} for row in details.get("colliders", [])]
    return {**details, **({"colliders": rows} if rows else {})}


def _colliders(colliders: Iterable["ColliderFigures"], results: Sequence[MemoResult]) -> list[dict[str, Any]]:
    steps: dict[str, list[MemoResult]] = {}
    for step in results:
        if step.kind == "mesh.collider":
            steps.setdefault(step.key["collider"], []).append(step)
    rows, counted_keys = [], set[str]()
    for collider in colliders:
        own_steps = steps.get(collider.key, [])
        seconds = 0.0 if collider.key in counted_keys else sum(step.seconds for step in own_steps)
        counted_keys.add(collider.key)
        cached = all(step.cached for step in own_steps)
        rows.append({**_collider(collider), "seconds": round(seconds, 3), "cached": cached})
    return rows


def _collider(figures: "ColliderFigures") -> dict[str, Any]:
    row = asdict(figures)
    del row["key"]
    measures = row.pop("measures") or {}
    row["tolerance"] = None if figures.tolerance is None else round(_MM_PER_M * figures.tolerance, 4)
    row["miss"] = None if figures.miss is None else round(figures.miss, 4)
    for name, value in measures.items():
        is_length = name.startswith(("protrusion", "bareness"))
        row[name] = round(_MM_PER_M * value, 4) if is_length else value
    return row


def _links(geometry: "Geometry", rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Returns the totals of each link that has a collider, in the order of the shapes."""
    geoms: dict[str, int] = {}
    for shape in geometry.shapes:
        if shape.role == "collision":
            geoms[shape.link] = geoms.get(shape.link, 0) + 1
    totals_of_links = []
    for link in dict.fromkeys([*(str(row["link"]) for row in rows), *geoms]):
        own_rows = [row for row in rows if row["link"] == link]
        totals = {name: sum(row[name] for row in own_rows) for name in ("pieces", "vertices", "seconds")}
        totals["seconds"] = round(totals["seconds"], 3)
        totals_of_links.append(
            {"link": link, "colliders": len(own_rows), **totals, "geoms": geoms.get(link, 0)}
        )
    return totals_of_links


def _exclude(exclude: "Exclude", geometry: "Geometry") -> dict[str, Any]:
    names = excluded_colliders(exclude, geometry.shapes, geometry.colliders)
    return {**_pair(exclude), "reason": exclude.reason, "colliders": names, "geoms": exclude.geoms}


def _pair(pair: "Exclude | Touch") -> dict[str, Any]:
    return {"links": [pair.link_a, pair.link_b], "depth": round(_MM_PER_M * pair.depth, 3)}


def progress_of(context: "BuildContext") -> "Shown":
    """Returns a function that shows which parts get their colliders, and about how long the others will
    take."""
    start: float | None = None

    def show(running: Sequence[str], done: int, total: int) -> None:
        nonlocal start
        start = time.monotonic() if start is None else start
        remaining = time_left(time.monotonic() - start, done, total)
        names = f": {', '.join(running)}" if running else ""
        context.transient(f"colliders: {done} of {count(total, 'part')}{remaining}{names}")

    return show


def time_left(seconds: float, done: int, total: int) -> str:
    """Returns in words the time for the remaining parts, at the speed of the `done` parts, which took
    `seconds`; "" before the first part is done."""
    if not 0 < done < total:
        return ""
    remaining = seconds * (total - done) / done
    amount = f"{round(remaining / 60)} min" if remaining >= 90 else f"{max(1, round(remaining / 5)) * 5} s"
    return f", about {amount} left"
