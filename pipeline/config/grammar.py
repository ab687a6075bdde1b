"""Writes names and values in the grammar of Hydra's overrides."""

import re
from typing import Any

import yaml

_NAME_CHARACTERS = re.compile(r"[\w\-/+.$%*@?|()\[\]{}:=, \\]+", re.ASCII)
_SPECIAL_CHARACTERS = re.compile(r"([()\[\]{}:=, \\])")
_NON_TEXT = re.compile(r"[+-]?[\d._]+(e[+-]?\d+)?|[+-]?(inf|nan)|true|false|null", re.IGNORECASE)
"""Words that the grammar reads as numbers, booleans or null."""


class NotWritableError(ValueError):
    """The grammar cannot write a name."""


def is_writable(name: str) -> bool:
    """Tells whether the grammar can write a name as a mapping's key."""
    plain = bool(_NAME_CHARACTERS.fullmatch(name)) and name == name.strip()
    return plain and not _NON_TEXT.fullmatch(name)


def name(text: str) -> str:
    """Writes a name as a mapping's key."""
    return _SPECIAL_CHARACTERS.sub(r"\\\1", text)


def converted(value: str) -> str:
    """Converts a mapping or a list from YAML or JSON, with quoted names, to the grammar; returns other values
    unchanged. Raises NotWritableError for a name that the grammar cannot write."""
    if value.lstrip()[:1] not in ("{", "[") or not re.search(r"[\"']", value):
        return value
    # Imported where it is used: help and completion need no OmegaConf.
    from omegaconf._utils import get_yaml_loader

    try:
        # OmegaConf's loader, as for files: it reads 1e-3 as a number, where YAML 1.1 needs 1.0e-3.
        return _write(yaml.load(value, Loader=get_yaml_loader()))
    except NotWritableError:
        raise
    except (yaml.YAMLError, ValueError, RecursionError):
        return value


def _write(tree: Any) -> str:
    """Writes plain data in the grammar; raises ValueError for data that the grammar cannot write."""
    if isinstance(tree, dict):
        if not all(isinstance(key, str) and is_writable(key) for key in tree):
            raise NotWritableError
        return "{" + ",".join(f"{name(key)}:{_write(value)}" for key, value in tree.items()) + "}"
    if isinstance(tree, list):
        return f"[{','.join(map(_write, tree))}]"
    if tree is None or isinstance(tree, bool):
        return {None: "null", True: "true", False: "false"}[tree]
    if isinstance(tree, int | float):
        return repr(tree)
    if not isinstance(tree, str):
        raise ValueError
    return text(tree)


def text(plain: str) -> str:
    """Writes a text in quotes, with its interpolations. A backslash has a meaning only before a quote."""
    # Backslashes before a quote, or before the closing quote, escape it unless they are doubled.
    doubled = re.sub(r"(\\+)(?='|$)", r"\1\1", plain)
    return "'" + doubled.replace("'", r"\'") + "'"
