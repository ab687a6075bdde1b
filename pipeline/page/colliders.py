"""The part of report.html about colliders: how near each is to its part, totals, and pictures."""

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

_RUNGS = {"hull": "convex hull", "raw": "the mesh itself", "none": "no collider"}
_SEVERAL = {"pieces": "convex piece", "spheres": "sphere"}

_MOST_PARTS = 3
"""So many parts that share a collider are named."""


def colliders(details: Mapping[str, Any], pictures: str, secrets: Secrets) -> str:
    """The section; nothing where no collider was made. `details`: of the report, blanked; `pictures`: the
    view of the mesh stage, "" without one."""
    rows: Sequence[Row] = details.get("colliders", [])
    if not rows:
        return ""
    missing = sorted((row for row in rows if not _within(row)), key=lambda row: -(row["miss"] or 0.0))
    others = [row for row in rows if _within(row)]
    judged, near = (sum(row["tolerance"] is not None for row in some) for some in (rows, others))
    return rendered(
        "colliders",
        title=f"Colliders: {near} of {judged} within the tolerance" if judged else "Colliders",
        missing=_table(missing),
        others=_table(others),
        near=near,
        judged=judged,
        unjudged=len(others) - near,
        totals=_totals(details.get("links", []), rows),
        gallery=_gallery(pictures, secrets),
    )


def _within(row: Row) -> bool:
    """Whether it is within its tolerance, or meant to be judged by none."""
    return bool(row["meets"]) and (row["miss"] is None or row["miss"] <= 1)


def _table(rows: Sequence[Row]) -> PageTable | None:
    return table(_HEADER, [_cells(row) for row in rows], _CLASSES, heads="link")


def _cells(row: Row) -> list[str]:
    parts = Markup(", ").join(map(name, row["parts"][:_MOST_PARTS]))
    if len(row["parts"]) > _MOST_PARTS:
        parts += f" and {len(row['parts']) - _MOST_PARTS} more"
    why = "; ".join(one for one in (row.get("reason"), row["note"]) if one)
    figures = [""] * 5
    if row["tolerance"] is not None:
        figures = [
            f"{row['tolerance']:.2f}",
            *(f"{row[f'{what}_p95']:.2f} / {row[f'{what}_max']:.2f}" for what in ("protrusion", "bareness")),
            f"{_share(row['extra'])} / {_share(row['missing'])}",
            text(row["by"]),
        ]
    return [
        _verdict(row),
        name(row["link"]),
        parts,
        escape(text(_made(row))) + marked("hint", why),
        f"{row['vertices']:,}",
        *figures,
        f"{row['seconds']:.2f}{', kept' if row['cached'] else ''}",
    ]


def _verdict(row: Row) -> str:
    """A mark for what is not known to be within its tolerance."""
    if row["tolerance"] is None:
        return "not judged"
    return "" if _within(row) else marked("warning", "misses")


def _made(row: Row) -> str:
    """What the collider is, in words."""
    rung = str(row["rung"])
    return count(row["pieces"], _SEVERAL[rung]) if rung in _SEVERAL else _RUNGS.get(rung, rung)


def _share(value: float | None) -> str:
    return "no volume" if value is None else f"{100 * value:.1f} %"


def _totals(links: Sequence[Row], rows: Sequence[Row]) -> tuple[str, PageTable | None]:
    """The totals of each link and of the robot, which are what is seen while they are folded."""
    names = ("colliders", "pieces", "vertices", "geoms", "seconds")
    whole = {one: sum(link[one] for link in links) for one in names}
    words = (
        f"{count(len(links), 'link')}: {count(whole['pieces'], 'piece')}, {whole['vertices']:,} vertices, "
        f"{count(whole['geoms'], 'geom')}; {sum(not row['cached'] for row in rows)} of "
        f"{count(len(rows), 'collider')} made in this build"
    )
    lines = [*links, {"link": "all", **whole}]
    cells = [
        [line["link"], *(f"{line[one]:,}" for one in names[:-1]), f"{line['seconds']:.2f}"] for line in lines
    ]
    return words, plain_table(["link", *names], cells)


def _gallery(pictures: str, secrets: Secrets) -> dict[str, Any] | None:
    """The pictures, and which links have none."""
    if not pictures:
        return None
    shown = json.loads(pictures)
    drawn = [{**one, "link": secrets.blanked(one["link"])} for one in shown["pictures"]]
    lacking = ", ".join(map(secrets.blanked, shown["left_out"]))
    return {"side": shown["side"], "pictures": drawn, "links": count(len(drawn), "link"), "lacking": lacking}
