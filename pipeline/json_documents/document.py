"""Defines the base class of all documents, and writes a document as text."""

import json
import math
import os
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from linkwright.pipeline.secrets import Secrets
from linkwright.stages.formats.robot_json.codec import Form, write

VERSION = 1
"""The version of all documents. Keys may be added in the same version."""

AnyValue = Annotated[Any, Form(lambda value: value, lambda data, names: data, {})]
"""A value that keeps the form that it has elsewhere, as in report.json."""


class CommandDocument:
    """A document for programs. A subclass is a frozen dataclass, whose docstring explains each key."""

    FORMAT: ClassVar[str]
    """The value of the key `format`."""

    exit_status: int


def text_of(document: CommandDocument) -> str:
    """Returns the document as JSON in ASCII, without API keys; numbers that JSON lacks are null."""
    tree = {"format": document.FORMAT, "version": VERSION, **write(document)}
    return json.dumps(_finite(Secrets(os.environ).within(tree)), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    """Returns plain data with None in place of infinite numbers and NaN."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    return [_finite(inner) for inner in value] if isinstance(value, list | tuple) else value
