"""Where a build comes from, and what it took: source, versions, stages, API calls, figures."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.figures import name_of, shown
from linkwright.pipeline.page.html.markup import (
    file_link,
    link,
    pairs,
    part,
    plain_pairs,
    plain_table,
    section,
    text,
)


def cost(tree: Mapping[str, Any]) -> str:
    """The stages with their time, and the API calls, side by side where there is room."""
    found = [part("Stages", _stages(tree["stages"])), part("API calls", plain_pairs(tree["calls"]))]
    return section("Time and API calls", _side_by_side(found), "cost")


def provenance(tree: Mapping[str, Any]) -> str:
    """The source, with the digest of the bundle of its inputs, versions and figures."""
    config = {"config": file_link("config.yaml")}
    found = [
        part("Source", pairs({**_source(tree["source"]), **_plain(tree["bundle"]), **config})),
        part("Versions", plain_pairs(tree["versions"])),
        part("Figures", pairs({name_of(key): shown(value) for key, value in tree["figures"].items()})),
    ]
    return section("Provenance", _side_by_side(found), "provenance")


def _side_by_side(parts: Sequence[str]) -> str:
    columns = "\n".join(f"<div>{one}</div>" for one in parts if one)
    return f'<div class="facts">\n{columns}\n</div>' if columns else ""


def _plain(values: Mapping[str, Any]) -> dict[str, str]:
    return {key.replace("_", " "): text(value) for key, value in values.items()}


def _source(source: Mapping[str, Any]) -> dict[str, str]:
    rows = _plain(source)
    address = str(source.get("url", ""))
    if address.startswith(("https://", "http://")):
        rows["url"] = link(address, address)
    return rows


def _stages(stages: Sequence[Mapping[str, Any]]) -> str:
    rows = [
        [one["name"], "cached" if one["cached"] else "built", f"{one['seconds']:.2f}", one["outputs"]]
        for one in stages
    ]
    return plain_table(["stage", "result", "seconds", "outputs"], rows)
