"""Renders the origin of a build, and its cost: source, versions, stages, API calls, figures."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.figures import name_of, value_text
from linkwright.pipeline.page.html.tables import PageTable, plain_pairs, plain_table
from linkwright.pipeline.page.html.template import file_link, link, rendered


def cost(tree: Mapping[str, Any]) -> str:
    """Renders the stages with their times, and the API calls, side by side where there is room."""
    stages, calls = _stages(tree["stages"]), plain_pairs(tree["calls"])
    return rendered("cost", stages=stages, calls=calls) if stages or calls else ""


def provenance(tree: Mapping[str, Any]) -> str:
    """Renders the source, with the digest of the input bundle, versions, figures and the objective."""
    source = {**tree["source"], **tree["bundle"], "config": file_link("config.yaml")}
    address = str(source.get("url", ""))
    if address.startswith(("https://", "http://")):
        source["url"] = link(address, address)
    figures = {name_of(key): value_text(value) for key, value in tree["figures"].items()}
    groups = {"Source": plain_pairs(source), "Versions": plain_pairs(tree["versions"]), "Figures": figures}
    if tree["objective"]:
        groups["Objective"] = {name: value_text(value) for name, value in tree["objective"].items()}
    return rendered("provenance", groups=groups)


def _stages(stages: Sequence[Mapping[str, Any]]) -> PageTable | None:
    rows = [
        [stage["name"], "cached" if stage["cached"] else "built", f"{stage['seconds']:.2f}", stage["outputs"]]
        for stage in stages
    ]
    return plain_table(["stage", "result", "seconds", "outputs"], rows)
