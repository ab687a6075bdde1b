"""Looks up keys in the schema: their section, their type, their names."""

import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from linkwright.pipeline.key_path import Place, key_of
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.robot.section import Section


def field_at(owner: Any, name: int | str) -> FieldInfo | None:
    """Returns the field with a name in the tree; None if `owner` is not a section or has no such field."""
    fields = owner.model_fields.items() if is_section(owner) else ()
    return next((field for key, field in fields if (field.alias or key) == name), None)


def names(owner: Any) -> list[str]:
    """Returns the keys of a section by their names in the tree."""
    return [field.alias or name for name, field in owner.model_fields.items()] if is_section(owner) else []


def is_section(annotation: Any) -> bool:
    """Tells whether an annotation is a section: a class of named keys."""
    return isinstance(annotation, type) and issubclass(annotation, Section)


def annotation_at(root: Any, place: Place) -> Any:
    """Returns the annotation at a place: a section, or a type."""
    node = _core_type(root)
    for part in place:
        if is_section(node):
            field = field_at(node, part)
            node = _core_type(field.annotation) if field else Any
        elif get_origin(node) is dict:
            node = _core_type(get_args(node)[1])
        elif get_origin(node) is tuple:
            node = _core_type(get_args(node)[0])
        else:
            return Any
    return node


def _core_type(annotation: Any) -> Any:
    """Removes `Annotated` and `| None` from a type."""
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        options = [argument for argument in get_args(annotation) if argument is not type(None)]
        return _core_type(options[0]) if len(options) == 1 else annotation
    return annotation


def options(annotation: Any) -> list[str]:
    """Returns the allowed words if a type is a choice of words, else []."""
    return [str(argument) for argument in get_args(annotation)] if get_origin(annotation) is Literal else []


def leaves(root: Any, place: Place = ()) -> Iterator[str]:
    """Yields all full keys below a section; for the source, the keys of all its kinds."""
    for section in SOURCES.values() if place == ("source",) else (root,):
        for name in names(section):
            inner_place, annotation = (*place, name), annotation_at(section, (name,))
            yield key_of(inner_place)
            if inner_place == ("source",) or is_section(annotation):
                yield from leaves(annotation, inner_place)
