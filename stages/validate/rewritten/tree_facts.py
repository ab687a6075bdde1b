"""Reads YAML, TOML and JSON files as facts: pairs of a place (the path of keys) and a value."""

import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from linkwright.stages.validate.rewritten.facts import Place, Unparsable, Value

MAX_VALUES = 1_000_000
"""Largest number of values in a file: YAML's aliases can turn a few bytes into very many values."""

IDENTIFYING_KEYS = ("Class", "Name")
"""Keys that identify the members of a list in RViz's files."""


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """A YAML loader that reads 1e-1 as a number, like YAML 1.2 and ROS; PyYAML reads it as text."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def yaml_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields the facts of a YAML file; raises Unparsable."""
    try:
        # A subclass of SafeLoader: it makes only plain data, and runs no code.
        tree = yaml.load(data, _Loader)
    except (yaml.YAMLError, ValueError) as error:
        raise Unparsable(f"is not YAML: {' '.join(str(error).split())}") from None
    yield from _facts(tree)


def toml_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields the facts of a TOML file; raises Unparsable."""
    try:
        tree = tomllib.loads(data.decode())
    except ValueError as error:
        raise Unparsable(f"is not TOML: {error}") from None
    yield from _facts(tree)


def json_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    """Yields the facts of a JSON file; raises Unparsable."""
    try:
        tree = json.loads(data)
    except ValueError as error:
        raise Unparsable(f"is not JSON: {error}") from None
    yield from _facts(_with_floats(tree))


def _with_floats(tree: Any) -> Any:
    """Converts all integers to floats, since JSON does not tell them apart."""
    if isinstance(tree, Mapping):
        return {key: _with_floats(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_with_floats(value) for value in tree]
    return float(tree) if isinstance(tree, int) and not isinstance(tree, bool) else tree


def _facts(tree: Any) -> Iterator[tuple[Place, Value]]:
    for index, (path, value) in enumerate(_values(tree, ())):
        if index == MAX_VALUES:
            raise Unparsable(f"has more than {MAX_VALUES} values")
        # A file that is a single value has no keys.
        first, *inner_keys = path or ("file",)
        yield Place((first, *inner_keys), first, " ".join(inner_keys)), value


def _values(tree: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Value]]:
    if tree is None and not path:
        return  # an empty file
    if isinstance(tree, Mapping):
        if not tree:
            yield path, "{}"
        for key, value in tree.items():
            yield from _values(value, (*path, str(key)))
    elif isinstance(tree, list) and any(isinstance(entry, list | Mapping) for entry in tree):
        key_counts: Counter[str] = Counter()
        for index, value in enumerate(tree):
            key = _member_key(value, index)
            key_counts[key] += 1
            yield from _values(
                value, (*path, f"[{key}]" if key_counts[key] == 1 else f"[{key} {key_counts[key]}]")
            )
    elif isinstance(tree, list):
        yield path, tuple(map(_scalar, tree))
    else:
        yield path, _scalar(tree)


def _member_key(member: Any, index: int) -> str:
    if isinstance(member, Mapping):
        for key in IDENTIFYING_KEYS:
            if isinstance(member.get(key), str):
                return str(member[key])
    return str(index)


def _scalar(value: Any) -> Value:
    # Dates in YAML and TOML are compared as text.
    return value if value is None or isinstance(value, str | bool | int | float) else str(value)
