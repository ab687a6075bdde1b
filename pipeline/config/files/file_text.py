"""The configuration as the text of a file."""

from collections.abc import Mapping
from typing import Any

import yaml

from linkwright.stages.robot.text.printable import printable_lines


def as_yaml(plan: Mapping[str, Any]) -> bytes:
    """The content of `config.yaml`, control characters in it escaped."""
    text: str = yaml.safe_dump(plan, sort_keys=False, allow_unicode=True)
    if printable_lines(text) != text:
        text = yaml.safe_dump(plan, sort_keys=False)
    return text.encode()
