"""Writes the configuration as YAML."""

from collections.abc import Mapping
from typing import Any

import yaml

from linkwright.stages.robot.text.printable import printable_lines


def as_yaml(plan: Mapping[str, Any]) -> bytes:
    """Returns the content of `config.yaml`, with escaped control characters. Each section is written by
    itself, so that its text is the same in all configurations that have it."""
    return b"".join(_section({key: value}) for key, value in plan.items())


def _section(tree: Mapping[str, Any]) -> bytes:
    text: str = yaml.safe_dump(tree, sort_keys=False, allow_unicode=True)
    if printable_lines(text) != text:
        text = yaml.safe_dump(tree, sort_keys=False)
    return text.encode()
