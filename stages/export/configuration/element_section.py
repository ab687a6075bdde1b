"""Configuration of `elements` and `attributes`: XML of the user's own in the exported files."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import AfterValidator, BeforeValidator, model_validator

from linkwright.stages.robot.section import Section, Text, example, invalid

AmendableFormat = Literal["urdf", "mjcf"]
"""The formats that elements and attributes of the user's own reach."""

FINISHED = ("sdf",)
"""Formats that they do not reach, though their files are XML too."""

_NAMES = get_args(AmendableFormat)

FORMATS, TAG = "formats", "tag"
"""What stands beside attributes in an entry of `attributes`: neither MJCF nor URDF has attributes of these
names."""

_ATTRIBUTE = re.compile(r"[A-Za-z_][\w.-]*(:[A-Za-z_][\w.-]*)?\Z", re.ASCII)
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _amendable(formats: Any) -> Any:
    """Refuses, by name, formats that are written as they are."""
    for name in formats if isinstance(formats, list | tuple) else ():
        if name in FINISHED:
            raise invalid(f"may have {' and '.join(_NAMES)} alone: {name} is written without XML of your own")
    return formats


def _well_formed(text: str) -> str:
    # Late: most robots have no element of their own, and it imports lxml.
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
    the file does not have is made. With a name: the tag of the element of this name, or of the section it is
    in, where several have the name."""

    name: Annotated[Text | None, example("torso")] = None
    """The element of this name, of any kind: of an MJCF in the robot's file, else in scene.xml. Where it is a
    site, as frames are: on the site's body, with poses relative to the site."""

    file: Literal["robot", "scene"] | None = None
    """The file of an MJCF. null: the robot's for a tag; for a name the first that has it."""

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
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
    """The formats that they are added to, of those that are written; never the SDF. null: the MJCF where
    MuJoCo knows all of the elements, else the URDF."""

    xml: Annotated[
        Annotated[Text, AfterValidator(_well_formed)] | None,
        example("<camera name='front' pos='0.1 0 0' xyaxes='0 -1 0 0 0 1'/>"),
    ] = None
    """One element or several, as text; comments are left out."""

    file: Annotated[Text | None, example("mount.xml")] = None
    """A file with them, instead of `xml`; a path from the working folder."""

    @model_validator(mode="after")
    def _one_text(self) -> Self:
        if (self.xml is None) == (self.file is None):
            raise invalid("must have either xml or file")
        if self.formats == ():
            raise invalid("formats must name a format")
        if self.into.file is not None and "mjcf" not in (self.formats or ("mjcf",)):
            raise invalid("into.file is of an MJCF alone")
        return self


def _value(value: Any) -> Any:
    """An attribute's value: null, text, a number, true or false, or a list of texts or numbers."""
    several = isinstance(value, list | tuple)
    for one in value if several else [value]:
        if isinstance(one, str) and _UNPRINTABLE.search(one):
            raise invalid("must not have characters that XML cannot have")
        if isinstance(one, float) and one - one != 0:
            raise invalid("must be finite")
        if not isinstance(one, str | int | float) and (several or one is not None):
            raise invalid("must be text, a number, true, false, null, or a list of numbers or texts")
    return list(value) if several else value


def _attributes(given: dict[str, Any]) -> dict[str, Any]:
    formats = given.get(FORMATS)
    _amendable(given.get(FORMATS))
    if FORMATS in given and not (isinstance(formats, list) and formats and set(formats) <= set(_NAMES)):
        raise invalid(f"formats must be a list of {', '.join(_NAMES)}")
    if TAG in given and not isinstance(given[TAG], str):
        raise invalid("tag must be text")
    own = [name for name in given if name not in (FORMATS, TAG)]
    if not own:
        raise invalid("must have at least one attribute")
    wrong = [name for name in own if not _ATTRIBUTE.match(name)]
    if wrong:
        raise invalid(f"{wrong[0]!r} cannot be the name of an attribute")
    return given


AttributeChoice = Annotated[dict[Text, Annotated[Any, AfterValidator(_value)]], AfterValidator(_attributes)]
"""Name of an attribute → its value."""
