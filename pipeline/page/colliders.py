"""Renders the colliders: how near each is to its part, totals, and pictures."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup, escape

from linkwright.pipeline.page.html.tables import PageTable, plain_table, table
from linkwright.pipeline.page.html.template import marked, name, rendered, text
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.text.plural import count

Row = Mapping[str, Any]

_HEADER = (
    "",
    "link",
    "part",
    "collider",
    "vertices",
    "tolerance, mm",
    "stands out, mm",
    "bare, mm",
    "extra / missing",
    "volumes by",
    "seconds",
)
_CLASSES = dict.fromkeys(_HEADER[4:9], "number") | {"": "word", "part": "name", "seconds": "number"}

_RUNG_WORDS = {"hull": "convex hull", "raw": "the mesh itself", "none": "no collider"}
_COUNTED_RUNGS = {"pieces": "convex piece", "spheres": "sphere"}

MAX_PARTS = 3
"""Largest number of parts named in the row of a collider that they share."""


def colliders(details: Mapping[str, Any], pictures: str, secrets: Secrets) -> str:
    """Renders the section; "" if no collider was made. `details`: the report's details, with secrets blanked;
    `pictures`: the view of the mesh stage as JSON, or ""."""
    rows: Sequence[Row] = details.get("colliders", [])
    if not rows:
        return ""
    missing = sorted((row for row in rows if not _is_within(row)), key=lambda row: -(row["miss"] or 0.0))
    meeting = [row for row in rows if _is_within(row)]
    judged_count, near_count = (
        sum(row["tolerance"] is not None for row in group) for group in (rows, meeting)
    )
    return rendered(
        "colliders",
        title=f"Colliders: {near_count} of {judged_count} within the tolerance"
        if judged_count
        else "Colliders",
        missing=_table(missing),
        meeting=_table(meeting),
        near=near_count,
        judged=judged_count,
        unjudged=len(meeting) - near_count,
        totals=_totals(details.get("links", []), rows),
        gallery=_gallery(pictures, secrets),
    )


def _is_within(row: Row) -> bool:
    """Tells whether a collider is within its tolerance, or has none on purpose."""
    return bool(row["meets"]) and (row["miss"] is None or row["miss"] <= 1)


def _table(rows: Sequence[Row]) -> PageTable | None:
    return table(_HEADER, [_cells(row) for row in rows], _CLASSES, heads="link")


def _cells(row: Row) -> list[str]:
    parts = Markup(", ").join(map(name, row["parts"][:MAX_PARTS]))
    if len(row["parts"]) > MAX_PARTS:
        parts += f" and {len(row['parts']) - MAX_PARTS} more"
    reasons = "; ".join(words for words in (row.get("reason"), row["note"]) if words)
    figures = [""] * 5
    if row["tolerance"] is not None:
        figures = [
            f"{row['tolerance']:.2f}",
            *(
                f"{row[f'{measure}_p95']:.2f} / {row[f'{measure}_max']:.2f}"
                for measure in ("protrusion", "bareness")
            ),
            f"{_share(row['extra'])} / {_share(row['missing'])}",
            text(row["by"]),
        ]
    return [
        _verdict(row),
        name(row["link"]),
        parts,
        escape(text(_kind_words(row))) + marked("hint", reasons),
        f"{row['vertices']:,}",
        *figures,
        f"{row['seconds']:.2f}{', kept' if row['cached'] else ''}",
    ]


def _verdict(row: Row) -> str:
    """Returns the mark of a collider that is not known to be within its tolerance."""
    if row["tolerance"] is None:
        return "not judged"
    return "" if _is_within(row) else marked("warning", "misses")


def _kind_words(row: Row) -> str:
    """Returns the kind of the collider, in words."""
    rung = str(row["rung"])
    return (
        count(row["pieces"], _COUNTED_RUNGS[rung]) if rung in _COUNTED_RUNGS else _RUNG_WORDS.get(rung, rung)
    )


def _share(value: float | None) -> str:
    return "no volume" if value is None else f"{100 * value:.1f} %"


def _totals(links: Sequence[Row], rows: Sequence[Row]) -> tuple[str, PageTable | None]:
    """Returns the robot's totals in words, shown while the table is folded, and a table with each link's."""
    names = ("colliders", "pieces", "vertices", "geoms", "seconds")
    total = {name: sum(link[name] for link in links) for name in names}
    words = (
        f"{count(len(links), 'link')}: {count(total['pieces'], 'piece')}, {total['vertices']:,} vertices, "
        f"{count(total['geoms'], 'geom')}; {sum(not row['cached'] for row in rows)} of "
        f"{count(len(rows), 'collider')} made in this build"
    )
    lines = [*links, {"link": "all", **total}]
    cells = [
        [line["link"], *(f"{line[name]:,}" for name in names[:-1]), f"{line['seconds']:.2f}"]
        for line in lines
    ]
    return words, plain_table(["link", *names], cells)


def _gallery(pictures: str, secrets: Secrets) -> dict[str, Any] | None:
    """Returns the pictures, and the names of the links without one."""
    if not pictures:
        return None
    view = json.loads(pictures)
    pictures_shown = [{**picture, "link": secrets.blanked(picture["link"])} for picture in view["pictures"]]
    lacking = ", ".join(map(secrets.blanked, view["left_out"]))
    return {
        "side": view["side"],
        "pictures": pictures_shown,
        "links": count(len(pictures_shown), "link"),
        "lacking": lacking,
    }
