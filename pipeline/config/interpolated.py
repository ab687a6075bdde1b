"""Converts texts of interpolations, such as `${oc.env:SPEED,4}`, where the schema needs a number or a
boolean."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.config.schema import annotation_at
from linkwright.pipeline.key_path import Place
from linkwright.stages.fetch.section import SOURCES


def decode(tree: dict[str, Any], places: Iterable[Place]) -> None:
    """Converts the texts at these places of `tree` to numbers and booleans where the schema needs them."""
    source = tree.get("source")
    kind = SOURCES.get(str(source.get("kind"))) if isinstance(source, Mapping) else None
    for place in places:
        if place[0] == "source" and kind is not None:
            wanted = annotation_at(kind, place[1:])
        else:
            wanted = annotation_at(Plan, place)
        node: Any = tree
        try:
            for name in place[:-1]:
                node = node[name]
            text = node[place[-1]]
        except (KeyError, IndexError, TypeError):
            continue
        if isinstance(text, str):
            node[place[-1]] = _meant(text.strip(), wanted, text)


def _meant(text: str, wanted: Any, otherwise: Any) -> Any:
    """The text as a value of the type `wanted`; `otherwise` where it cannot be converted."""
    if wanted is bool:
        return {"true": True, "false": False}.get(text.lower(), otherwise)
    if wanted in (int, float):
        for read in (int, wanted):
            try:
                return read(text)
            except ValueError:
                continue
    return otherwise
