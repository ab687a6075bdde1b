"""The schema of a key: its section, its type, its names."""

import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from linkwright.pipeline.key_path import Place, key_of
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.robot.section import Section


def field_at(owner: Any, name: int | str) -> FieldInfo | None:
    """The field of a section that the tree calls `name`."""
    fields = owner.model_fields.items() if is_section(owner) else ()
    return next((field for key, field in fields if (field.alias or key) == name), None)


def names(owner: Any) -> list[str]:
    """The keys of a section, as the tree calls them."""
    return [field.alias or name for name, field in owner.model_fields.items()] if is_section(owner) else []


def is_section(annotation: Any) -> bool:
    """Whether an annotation is a section: a class of named keys."""
    return isinstance(annotation, type) and issubclass(annotation, Section)


def annotation_at(root: Any, place: Place) -> Any:
    """The annotation at a place: a section, or a type."""
    node = _bare(root)
    for part in place:
        if is_section(node):
            field = field_at(node, part)
            node = _bare(field.annotation) if field else Any
        elif get_origin(node) is dict:
            node = _bare(get_args(node)[1])
        elif get_origin(node) is tuple:
            node = _bare(get_args(node)[0])
        else:
            return Any
    return node


def _bare(annotation: Any) -> Any:
    """The type without `Annotated` and without `| None`."""
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        options = [one for one in get_args(annotation) if one is not type(None)]
        return _bare(options[0]) if len(options) == 1 else annotation
    return annotation


def options(annotation: Any) -> list[str]:
    """The allowed words of a key that is a choice of words."""
    return [str(one) for one in get_args(annotation)] if get_origin(annotation) is Literal else []


def leaves(root: Any, place: Place = ()) -> Iterator[str]:
    """Every full key of the tree below a section; the keys of all kinds of source."""
    for section in SOURCES.values() if place == ("source",) else (root,):
        for name in names(section):
            inner, below = (*place, name), annotation_at(section, (name,))
            yield key_of(inner)
            if inner == ("source",) or is_section(below):
                yield from leaves(below, inner)
