"""Converts texts of interpolations, such as `${oc.env:SPEED,4}`, where the schema needs a number or a
boolean."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.config.schema import annotation_at
from linkwright.pipeline.key_path import Place
from linkwright.stages.fetch.section import SOURCES


def convert_texts(tree: dict[str, Any], places: Iterable[Place]) -> None:
    """Converts the texts at these places of `tree` to numbers and booleans where the schema needs them."""
    source = tree.get("source")
    kind = SOURCES.get(str(source.get("kind"))) if isinstance(source, Mapping) else None
    for place in places:
        # The source is a union of kinds: its type follows from the kind, not from the place.
        if place[0] == "source" and kind is not None:
            expected_type = annotation_at(kind, place[1:])
        else:
            expected_type = annotation_at(Plan, place)
        node: Any = tree
        try:
            for name in place[:-1]:
                node = node[name]
            text = node[place[-1]]
        except (KeyError, IndexError, TypeError):
            continue
        if isinstance(text, str):
            node[place[-1]] = _converted(text.strip(), expected_type, text)


def _converted(text: str, expected_type: Any, default: Any) -> Any:
    """Returns the text as a value of the type `expected_type`, or `default` if it cannot be converted."""
    if expected_type is bool:
        return {"true": True, "false": False}.get(text.lower(), default)
    if expected_type in (int, float):
        for convert in (int, expected_type):
            try:
                return convert(text)
            except ValueError:
                continue
    return default
