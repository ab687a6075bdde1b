"""Reads the XML files that the key `elements` names, before a build, whose input they are."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.pipeline import observed
from linkwright.pipeline.errors import ConfigError, Diagnostic, as_problems, refusal
from linkwright.stages.robot.system import regular_files

if TYPE_CHECKING:
    from linkwright.pipeline.config.plan import Plan

MAX_BYTES = 16 << 20
"""Largest size of an XML file [bytes]."""


def element_texts(plan: "Plan") -> Mapping[str, str]:
    """Returns the text of each entry's file, by the entry's name; entries without a file are left out.

    Paths start from the working folder. Raises ConfigError unless every file can be read and contains XML
    elements.
    """
    texts: dict[str, str] = {}
    problems: list[Diagnostic] = []
    for name, element in plan.elements.items():
        if element.file is not None:
            try:
                texts[name] = _read_elements(element.file, f"elements.{name}.file")
            except ConfigError as error:
                problems += as_problems(error)
    if problems:
        raise refusal(problems)
    return texts


def require_valid_elements(plan: "Plan") -> None:
    """Raises ConfigError if an entry of `elements` fits no format, or if its file cannot be read as XML."""
    if not plan.elements:
        return
    # Imported late, since these modules load lxml, and most robots have no elements of their own.
    from linkwright.stages.export.amend.documents import Refused
    from linkwright.stages.export.amend.entries import entries

    texts = element_texts(plan)
    try:
        entries(plan, texts)
    except Refused as error:
        raise refusal([error.diagnostic]) from None


def _read_elements(path: str, key: str) -> str:
    """Returns the text of the file that the key `key` names. Raises ConfigError unless the file contains XML
    elements."""
    # Imported late: see `require_valid_elements`.
    from linkwright.stages.formats.xml import Malformed, fragment

    regular_files.require(path, key, description="XML is in a file", example="mount.xml")
    try:
        content = regular_files.content(Path(path), MAX_BYTES)
        observed.record_content(Path(path), content)
        text = content.decode("utf-8")
        # Raises Malformed unless the text consists of complete elements.
        fragment(text)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        msg = f"{path} is not readable as text: {reason}"
        raise ConfigError(msg, key, "it must be a file in UTF-8") from None
    except regular_files.FileTooLarge as error:
        msg = f"{path} has {error.size} bytes, more than {MAX_BYTES}"
        raise ConfigError(msg, key, "keep only the elements") from None
    except Malformed as error:
        msg = f"{path} is not XML: {error.place}"
        raise ConfigError(msg, key, "it must contain one or more complete elements") from None
    return text
