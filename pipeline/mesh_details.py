"""What the report tells of a robot's geometry, and what the terminal shows meanwhile."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.caching.actions import Remembered
from linkwright.pipeline.stages.context import notes
from linkwright.stages.robot.contact.exclude_names import excluded_colliders
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.pipeline.stages.context import BuildContext
    from linkwright.stages.mesh import Shown
    from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Geometry, Touch

_MM = 1e3


def noted(geometry: "Geometry", remembered: Sequence[Remembered]) -> bytes:
    """The notes of the mesh stage. `remembered`: what it made, or had made before."""
    files = {shape.file for shape in geometry.shapes if shape.file is not None}
    figures = {"meshes": len(files), "triangles": sum(shape.faces for shape in geometry.shapes)}
    summary = f"{count(figures['meshes'], 'mesh', 'meshes')}, {count(figures['triangles'], 'triangle')}"
    tables = details(geometry, remembered)
    return notes(summary, geometry.diagnostics, figures, details=tables, lasts=geometry.lasts)


def details(geometry: "Geometry", remembered: Sequence[Remembered] = ()) -> dict[str, Any]:
    """`colliders`: how the parts of each link collide, lengths in mm, volumes as shares of the part's.
    `seconds`: how long making the collider took, when it was made; equal parts have one, and all but the
    first of them 0. `cached`: whether it was made before this build. `remembered`: what the stage made.

    `links`: the colliders of each link in total; `geoms` are what an engine collides, also what the
    user gave. `excludes`: the pairs of links that do not collide with each other, why, and how deep they are
    in each other at `home` [mm]; nothing where the robot does not collide with itself. Where only some of
    their colliders do not, `colliders` names those of each link, and `geoms` has their pairs, by position.
    `touching`: the pairs that collide and touch at `home`.
    """
    excludes = [_exclude(one, geometry) for one in geometry.excludes]
    touching = [_pair(one) for one in geometry.touching]
    colliders = _colliders(geometry.colliders, remembered)
    tables = {
        "colliders": colliders,
        "links": _links(geometry, colliders),
        "excludes": excludes,
        "touching": touching,
    }
    return {name: rows for name, rows in tables.items() if rows}


def kept(details: Mapping[str, Any]) -> dict[str, Any]:
    """The same for a stage whose result comes from the cache: then so does each collider."""
    rows = [{**row, "cached": True} for row in details.get("colliders", [])]
    return {**details, **({"colliders": rows} if rows else {})}


def _colliders(every: Iterable["ColliderFigures"], remembered: Sequence[Remembered]) -> list[dict[str, Any]]:
    steps: dict[str, list[Remembered]] = {}
    for step in remembered:
        if step.kind == "mesh.collider":
            steps.setdefault(step.key["collider"], []).append(step)
    rows, told = [], set[str]()
    for one in every:
        own = steps.get(one.key, [])
        seconds = 0.0 if one.key in told else sum(step.seconds for step in own)
        told.add(one.key)
        cached = all(step.cached for step in own)
        rows.append({**_collider(one), "seconds": round(seconds, 3), "cached": cached})
    return rows


def _collider(one: "ColliderFigures") -> dict[str, Any]:
    row = asdict(one)
    del row["key"]
    measures = row.pop("measures") or {}
    row["tolerance"] = None if one.tolerance is None else round(_MM * one.tolerance, 4)
    row["miss"] = None if one.miss is None else round(one.miss, 4)
    for name, value in measures.items():
        of_length = name.startswith(("protrusion", "bareness"))
        row[name] = round(_MM * value, 4) if of_length else value
    return row


def _links(geometry: "Geometry", rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The totals of each link that has a collider, in the order of the shapes."""
    geoms: dict[str, int] = {}
    for shape in geometry.shapes:
        if shape.role == "collision":
            geoms[shape.link] = geoms.get(shape.link, 0) + 1
    found = []
    for link in dict.fromkeys([*(str(row["link"]) for row in rows), *geoms]):
        own = [row for row in rows if row["link"] == link]
        totals = {name: sum(row[name] for row in own) for name in ("pieces", "vertices", "seconds")}
        totals["seconds"] = round(totals["seconds"], 3)
        found.append({"link": link, "colliders": len(own), **totals, "geoms": geoms.get(link, 0)})
    return found


def _exclude(one: "Exclude", geometry: "Geometry") -> dict[str, Any]:
    names = excluded_colliders(one, geometry.shapes, geometry.colliders)
    return {**_pair(one), "reason": one.reason, "colliders": names, "geoms": one.geoms}


def _pair(one: "Exclude | Touch") -> dict[str, Any]:
    return {"links": [one.link_a, one.link_b], "depth": round(_MM * one.depth, 3)}


def shown(context: "BuildContext") -> "Shown":
    """Shows which parts get their colliders, and about how long the others will take."""
    start: float | None = None

    def show(running: Sequence[str], done: int, total: int) -> None:
        nonlocal start
        start = time.monotonic() if start is None else start
        left = time_left(time.monotonic() - start, done, total)
        making = f": {', '.join(running)}" if running else ""
        context.transient(f"colliders: {done} of {count(total, 'part')}{left}{making}")

    return show


def time_left(seconds: float, done: int, total: int) -> str:
    """In words, how long the rest takes if it is as slow as what was `done` in so many seconds; "" where
    nothing was."""
    if not 0 < done < total:
        return ""
    left = seconds * (total - done) / done
    amount = f"{round(left / 60)} min" if left >= 90 else f"{max(1, round(left / 5)) * 5} s"
    return f", about {amount} left"
