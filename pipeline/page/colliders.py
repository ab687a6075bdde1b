"""The part of report.html about colliders: how near each is to its part, totals, and pictures."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.markup import folded, image, name, plain_table, section, table, text
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.text.plural import count

Row = Mapping[str, Any]

_LEGEND = (
    "Stands out: how far the collider's surface is outside the part. Bare: how far the part's surface is "
    "outside its collider. The first figure is what 95 % of the surface stays within, the second the most. "
    "Within the tolerance: what stands out (95 %) and what is bare (the most) are at most the tolerance, and "
    "nothing stands out by more than three times as much. Extra and missing: the volume of the collider "
    "outside the part, and of the part outside the collider, as shares of the part's. Seconds: how long the "
    "collider took to make, of equal parts only at the first; kept: an earlier build made it."
)

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
    words = [f'<span class="passed">{near} within the tolerance</span>'] if near else []
    words += [f"{len(others) - near} not judged"] if near < len(others) else []
    body = [
        _table(missing),
        folded(", ".join(words), _table(others)),
        folded("what the figures are", f'<p class="soft">{text(_LEGEND)}</p>') if judged else "",
        _totals(details.get("links", []), rows),
        _gallery(pictures, secrets),
    ]
    title = f"Colliders: {near} of {judged} within the tolerance" if judged else "Colliders"
    return section(title, "\n".join(one for one in body if one), "colliders")


def _within(row: Row) -> bool:
    """Whether it is within its tolerance, or meant to be judged by none."""
    return bool(row["meets"]) and (row["miss"] is None or row["miss"] <= 1)


def _table(rows: Sequence[Row]) -> str:
    return table(_HEADER, [_cells(row) for row in rows], _CLASSES, heads="link")


def _cells(row: Row) -> list[str]:
    parts = ", ".join(map(name, row["parts"][:_MOST_PARTS]))
    if len(row["parts"]) > _MOST_PARTS:
        parts += f" and {len(row['parts']) - _MOST_PARTS} more"
    why = "; ".join(one for one in (row.get("reason"), row["note"]) if one)
    note = f'<span class="hint">{text(why)}</span>' if why else ""
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
        text(_made(row)) + note,
        f"{row['vertices']:,}",
        *figures,
        f"{row['seconds']:.2f}{', kept' if row['cached'] else ''}",
    ]


def _verdict(row: Row) -> str:
    """A mark for what is not known to be within its tolerance."""
    if row["tolerance"] is None:
        return "not judged"
    return "" if _within(row) else '<span class="warning">misses</span>'


def _made(row: Row) -> str:
    """What the collider is, in words."""
    rung = str(row["rung"])
    return count(row["pieces"], _SEVERAL[rung]) if rung in _SEVERAL else _RUNGS.get(rung, rung)


def _share(value: float | None) -> str:
    return "no volume" if value is None else f"{100 * value:.1f} %"


def _totals(links: Sequence[Row], rows: Sequence[Row]) -> str:
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
    return folded(text(words), plain_table(["link", *names], cells))


def _gallery(pictures: str, secrets: Secrets) -> str:
    """The pictures, and which links have none."""
    if not pictures:
        return ""
    shown = json.loads(pictures)
    side, figures = shown["side"], []
    for one in shown["pictures"]:
        link = secrets.blanked(one["link"])
        drawn = image(one["png"], f"{link}: what is seen, and its collider", 2 * side, side)
        figures.append(f"<figure>{drawn}<figcaption>{name(link)}</figcaption></figure>")
    words = f"Pictures of {count(len(figures), 'link')}: on the left what is seen, on the right the collider"
    lacking = ", ".join(map(secrets.blanked, shown["left_out"]))
    left_out = f'<p class="soft">Too large to be drawn here: {text(lacking)}</p>\n' if lacking else ""
    joined = "\n".join(figures)
    return folded(words, f'{left_out}<div class="gallery">\n{joined}\n</div>')
