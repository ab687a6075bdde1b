"""Defines the configuration `elements` and `attributes`: the user's own XML in the exported files."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import AfterValidator, BeforeValidator, model_validator

from linkwright.stages.robot.section import Section, Text, example, invalid

AmendableFormat = Literal["urdf", "mjcf"]
"""The formats to which the user's elements and attributes can be added."""

UNAMENDABLE_FORMATS = ("sdf",)
"""Formats whose files are XML, but cannot be amended."""

_AMENDABLE_NAMES = get_args(AmendableFormat)

FORMATS, TAG = "formats", "tag"
"""Keys in an entry of `attributes` that are not attributes themselves: neither MJCF nor URDF has attributes
with these names."""

_ATTRIBUTE = re.compile(r"[A-Za-z_][\w.-]*(:[A-Za-z_][\w.-]*)?\Z", re.ASCII)
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _amendable(formats: Any) -> Any:
    """Returns the formats; raises an error for formats of XML that cannot be amended."""
    for name in formats if isinstance(formats, list | tuple) else ():
        if name in UNAMENDABLE_FORMATS:
            raise invalid(
                f"may have {' and '.join(_AMENDABLE_NAMES)} alone: {name} is written without XML of your own"
            )
    return formats


def _well_formed(text: str) -> str:
    """Returns the text; raises an error if it is not XML."""
    # Imported late: most robots have no own elements, and the module imports lxml.
    from linkwright.stages.formats.xml import Malformed, fragment

    try:
        fragment(text)
    except Malformed as error:
        raise invalid(f"must be XML: {error.quoted_place}") from None
    return text


class IntoSection(Section):
    """Where elements are added: as the last of what is in an element."""

    tag: Annotated[Text | None, example("worldbody")] = None
    """The first element with this tag; `mujoco` or `robot` is the root of a file. A section of an MJCF that
    the file lacks is created. With a name: the tag of the element with this name, or of its section, if
    several elements have the name."""

    name: Annotated[Text | None, example("torso")] = None
    """The element with this name, of any kind: in an MJCF, that of the robot's file, otherwise that of
    scene.xml. If it is a site, as frames are, the elements are added to the site's body, with poses relative
    to the site."""

    file: Literal["robot", "scene"] | None = None
    """The file of an MJCF. null: for a tag the robot's file; for a name the first file that has it."""

    @model_validator(mode="after")
    def _check_target(self) -> Self:
        if self.tag is None and self.name is None:
            raise invalid("must have tag, as {tag: worldbody}, or name, as {name: torso}")
        return self


class ElementSection(Section):
    """XML elements of your own."""

    into: IntoSection
    """Where they are added."""

    formats: Annotated[tuple[AmendableFormat, ...] | None, BeforeValidator(_amendable), example(["mjcf"])] = (
        None
    )
    """The formats that the elements are added to, if they are written; never the SDF. null: the MJCF if
    MuJoCo knows all of the elements, otherwise the URDF."""

    xml: Annotated[
        Annotated[Text, AfterValidator(_well_formed)] | None,
        example("<camera name='front' pos='0.1 0 0' xyaxes='0 -1 0 0 0 1'/>"),
    ] = None
    """One element or several, as text; comments are left out."""

    file: Annotated[Text | None, example("mount.xml")] = None
    """A file with the elements, instead of `xml`; a path from the working folder."""

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        if (self.xml is None) == (self.file is None):
            raise invalid("must have either xml or file")
        if self.formats == ():
            raise invalid("formats must name a format")
        if self.into.file is not None and "mjcf" not in (self.formats or ("mjcf",)):
            raise invalid("into.file applies only to an MJCF")
        return self


def _attribute_value(value: Any) -> Any:
    """Returns an attribute's value if it is null, text, a number, true or false, or a list of texts or
    numbers."""
    several = isinstance(value, list | tuple)
    for item in value if several else [value]:
        if isinstance(item, str) and _UNPRINTABLE.search(item):
            raise invalid("must not have characters that XML does not allow")
        if isinstance(item, float) and not math.isfinite(item):
            raise invalid("must be finite")
        if not isinstance(item, str | int | float) and (several or item is not None):
            raise invalid("must be text, a number, true, false, null, or a list of numbers or texts")
    return list(value) if several else value


def _checked_entry(entry: dict[str, Any]) -> dict[str, Any]:
    """Returns an entry of `attributes`; raises an error for wrong `formats`, a wrong `tag`, or names that no
    attribute can have."""
    formats = entry.get(FORMATS)
    _amendable(entry.get(FORMATS))
    if FORMATS in entry and not (
        isinstance(formats, list) and formats and set(formats) <= set(_AMENDABLE_NAMES)
    ):
        raise invalid(f"formats must be a list of {', '.join(_AMENDABLE_NAMES)}")
    if TAG in entry and not isinstance(entry[TAG], str):
        raise invalid("tag must be text")
    attribute_names = [name for name in entry if name not in (FORMATS, TAG)]
    if not attribute_names:
        raise invalid("must have at least one attribute")
    invalid_names = [name for name in attribute_names if not _ATTRIBUTE.match(name)]
    if invalid_names:
        raise invalid(f"{invalid_names[0]!r} cannot be the name of an attribute")
    return entry


AttributeChoice = Annotated[
    dict[Text, Annotated[Any, AfterValidator(_attribute_value)]], AfterValidator(_checked_entry)
]
"""Name of an attribute → its value."""
