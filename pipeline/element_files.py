"""The files with XML that `elements` names: read before a build, since what they hold decides its result."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.pipeline import observed
from linkwright.pipeline.errors import ConfigError, Diagnostic, as_problems, refusal
from linkwright.stages.robot.system import regular_files

if TYPE_CHECKING:
    from linkwright.pipeline.config.plan import Plan

LARGEST = 16 << 20
"""Largest size of such a file [bytes]."""


def element_texts(plan: "Plan") -> Mapping[str, str]:
    """By the name of the entry the text of its file; paths start from the working folder. ConfigError where
    one is not a readable file of XML elements."""
    found: dict[str, str] = {}
    problems: list[Diagnostic] = []
    for name, one in plan.elements.items():
        if one.file is not None:
            try:
                found[name] = _text(one.file, f"elements.{name}.file")
            except ConfigError as error:
                problems += as_problems(error)
    if problems:
        raise refusal(problems)
    return found


def require_entries(plan: "Plan") -> None:
    """ConfigError where `elements` has XML of no format, or names a file that cannot be read."""
    if not plan.elements:
        return
    # Late: most robots have no element of their own, and these import lxml.
    from linkwright.stages.export.amend.documents import Refused
    from linkwright.stages.export.amend.entries import entries

    texts = element_texts(plan)
    try:
        entries(plan, texts)
    except Refused as refused:
        raise refusal([refused.diagnostic]) from None


def _text(path: str, key: str) -> str:
    # Late: most robots have no element of their own, and these import lxml.
    from linkwright.stages.formats.xml import Malformed, fragment

    regular_files.require(path, key, "XML is in a file", "mount.xml")
    try:
        content = regular_files.content(Path(path), LARGEST)
        observed.read(Path(path), content)
        text = content.decode("utf-8")
        fragment(text)
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is not UTF-8"
        msg, hint = f"{path} is not readable as text: {why}", "it must be a file in UTF-8"
    except regular_files.FileTooLarge as error:
        msg, hint = f"{path} has {error.size} bytes, more than {LARGEST}", "give the elements alone"
    except Malformed as error:
        msg, hint = f"{path} is not XML: {error.place}", "one element or several, each of them closed"
    else:
        return text
    raise ConfigError(msg, key, hint)
