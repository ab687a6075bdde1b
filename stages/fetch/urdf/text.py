"""Reads the text of a robot's file, as plain URDF that reveals nothing of this computer."""

from __future__ import annotations

import codecs
import html
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import regular_files

LARGEST = 1 << 24
"""Largest size of a robot's file that is read [bytes]."""

_MESH = re.compile(r"<mesh\b[^<]*")
_TEXTURE = re.compile(r"<texture\b[^<]*")
_NAMING = re.compile(r"<(?:mesh|texture)\b[^<]*")
_COMPILER = re.compile(r"<compiler\b[^<]*")
_VALUE = r"""\b%s\s*=\s*(?:"([^"<]*)"|'([^'<]*)')"""
_FILENAME = re.compile(_VALUE % "filename")
_MESHDIR = re.compile(_VALUE % "meshdir")
_ROBOT = re.compile(r"<robot\b[^<>]*")
_NAME = re.compile(_VALUE % "name")
_DECLARED_ENCODING = re.compile(rb"""\A<\?xml[^>]*?encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_DECLARATION = re.compile(r"\A<\?xml[^>]*\?>")
_BYTE_ORDER_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


@dataclass(frozen=True, slots=True)
class TextKind:
    """The expected kind of a text."""

    name: str
    key: str
    """The key of the configuration that names the file."""

    hint: str
    """The hint if the text is of another kind."""


URDF = TextKind("a URDF", "source.path", "give a URDF, or a xacro file that ends in .xacro")


def read(path: Path, where: str, kind: TextKind = URDF) -> str:
    """Returns the text of a file, without its comments but with all its lines; `where` names it in messages.

    Raises SourceError if it cannot be read, or is not text.
    """
    try:
        data = regular_files.content(path, LARGEST)
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        raise SourceError(msg, where, f"check {kind.key} and its permissions") from error
    except regular_files.FileTooLarge as error:
        msg = f"it is not readable as {kind.name}: it has {error.size} bytes; at most {LARGEST} are read"
        raise SourceError(msg, where, f"check that {kind.key} names the right file") from None
    return without_comments(_decoded(data, where, kind))


def _decoded(data: bytes, where: str, kind: TextKind) -> str:
    mark = next((mark for mark in _BYTE_ORDER_MARKS if data.startswith(mark[0])), None)
    declaration = _DECLARED_ENCODING.match(data)
    encoding = mark[1] if mark else declaration.group(1).decode() if declaration else "utf-8"
    try:
        text = (data[len(mark[0]) :] if mark else data).decode(encoding)
    except (LookupError, UnicodeError):
        text = ""
    if not text or "\0" in text:
        why = "it is not text" if data else "it is empty"
        raise SourceError(f"it is not readable as {kind.name}: {why}", where, kind.hint)
    return _DECLARATION.sub('<?xml version="1.0"?>', text)


def without_comments(text: str) -> str:
    """Returns the text with its comments emptied: every line keeps its number."""
    pieces, end = list[str](), 0
    while (start := text.find("<!--", end)) >= 0:
        comment_end = text.find("-->", start + 4)
        if comment_end < 0:
            break
        pieces += [text[end:start], "\n" * text.count("\n", start, comment_end)]
        end = comment_end + 3
    return "".join([*pieces, text[end:]])


def meshes(text: str) -> list[str]:
    """Returns the names of mesh files, in order and once each, found without an XML library."""
    return _filenames(_MESH, text)


def robot_name(text: str) -> str:
    """Returns the name of the robot, or "" if it is missing."""
    element = _ROBOT.search(text)
    match = _NAME.search(element.group()) if element else None
    return _value(match) if match else ""


def images(text: str) -> list[str]:
    """Returns the names of the images of materials, in order and once each."""
    return [name for name in _filenames(_TEXTURE, text) if name]


def meshdir(text: str) -> str:
    """Returns the folder of meshes that MuJoCo's extension names, or ""."""
    element = _COMPILER.search(text) if "<mujoco" in text else None
    match = _MESHDIR.search(element.group()) if element else None
    return _value(match) if match else ""


def with_renamed_files(text: str, names: Mapping[str, str]) -> str:
    """Returns the text with mesh files and images renamed: `names` from old to new."""

    def renamed_element(element: re.Match[str]) -> str:
        element_text = element.group()
        match = _FILENAME.search(element_text)
        if match is None or _value(match) not in names:
            return element_text
        start, end = match.span(1 if match.group(1) is not None else 2)
        return f"{element_text[:start]}{html.escape(names[_value(match)], quote=True)}{element_text[end:]}"

    return _NAMING.sub(renamed_element, text) if names else text


def without_folders(text: str, folders: Mapping[str, str]) -> str:
    """Returns the text with absolute paths replaced as in `folders`; the longest first."""
    for folder in sorted(folders, key=len, reverse=True):
        text = text.replace(f"{folder}/", f"{folders[folder]}/")
    return text


def _filenames(elements: re.Pattern[str], text: str) -> list[str]:
    values = (_FILENAME.search(element.group()) for element in elements.finditer(text))
    return list(dict.fromkeys(_value(match) for match in values if match))


def _value(match: re.Match[str]) -> str:
    return html.unescape(match.group(1) if match.group(1) is not None else match.group(2)).strip()
