"""Where a build comes from, and what it took: source, versions, stages, API calls, figures."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.figures import name_of, shown
from linkwright.pipeline.page.html.tables import PageTable, plain_pairs, plain_table
from linkwright.pipeline.page.html.template import file_link, link, rendered


def cost(tree: Mapping[str, Any]) -> str:
    """The stages with their time, and the API calls, side by side where there is room."""
    stages, calls = _stages(tree["stages"]), plain_pairs(tree["calls"])
    return rendered("cost", stages=stages, calls=calls) if stages or calls else ""


def provenance(tree: Mapping[str, Any]) -> str:
    """The source, with the digest of the bundle of its inputs, versions and figures."""
    source = {**tree["source"], **tree["bundle"], "config": file_link("config.yaml")}
    address = str(source.get("url", ""))
    if address.startswith(("https://", "http://")):
        source["url"] = link(address, address)
    figures = {name_of(key): shown(value) for key, value in tree["figures"].items()}
    found = {"Source": plain_pairs(source), "Versions": plain_pairs(tree["versions"]), "Figures": figures}
    return rendered("provenance", found=found)


def _stages(stages: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [one["name"], "cached" if one["cached"] else "built", f"{one['seconds']:.2f}", one["outputs"]]
        for one in stages
    ]
    return plain_table(["stage", "result", "seconds", "outputs"], rows)
