"""Names and values in the grammar of Hydra's overrides."""

import re
from typing import Any

import yaml

_CARRIED = re.compile(r"[\w\-/+.$%*@?|()\[\]{}:=, \\]+", re.ASCII)
_ESCAPED = re.compile(r"([()\[\]{}:=, \\])")
_NO_TEXT = re.compile(r"[+-]?[\d._]+(e[+-]?\d+)?|[+-]?(inf|nan)|true|false|null", re.IGNORECASE)


class NoFormError(ValueError):
    """The grammar cannot write a name."""


def has_form(name: str) -> bool:
    """Whether a name can be a mapping's key."""
    plain = bool(_CARRIED.fullmatch(name)) and name == name.strip()
    return plain and not _NO_TEXT.fullmatch(name)


def name(text: str) -> str:
    """A name as a mapping's key."""
    return _ESCAPED.sub(r"\\\1", text)


def carried(value: str) -> str:
    """Converts a mapping or a list from YAML or JSON, with quoted names, to the grammar; returns other values
    unchanged. NoFormError for a name that the grammar cannot write."""
    if value.lstrip()[:1] not in ("{", "[") or not re.search(r"[\"']", value):
        return value
    # Imported where it is used: help and completion need no OmegaConf.
    from omegaconf._utils import get_yaml_loader

    try:
        # As in a file, where 1e-3 is a number: YAML 1.1 has it only as 1.0e-3.
        return _written(yaml.load(value, Loader=get_yaml_loader()))
    except NoFormError:
        raise
    except (yaml.YAMLError, ValueError, RecursionError):
        return value


def _written(tree: Any) -> str:
    """Plain data in the grammar; ValueError for data that the grammar cannot write."""
    if isinstance(tree, dict):
        if not all(isinstance(key, str) and has_form(key) for key in tree):
            raise NoFormError
        return "{" + ",".join(f"{name(key)}:{_written(value)}" for key, value in tree.items()) + "}"
    if isinstance(tree, list):
        return f"[{','.join(map(_written, tree))}]"
    if tree is None or isinstance(tree, bool):
        return {None: "null", True: "true", False: "false"}[tree]
    if isinstance(tree, int | float):
        return repr(tree)
    if not isinstance(tree, str):
        raise ValueError
    return text(tree)


def text(plain: str) -> str:
    """A text in quotes, interpolations left in it; a backslash counts only before a quote."""
    doubled = re.sub(r"(\\+)(?='|$)", r"\1\1", plain)
    return "'" + doubled.replace("'", r"\'") + "'"
