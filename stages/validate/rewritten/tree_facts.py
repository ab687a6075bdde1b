"""The facts of YAML, TOML and JSON: values by their keys."""

import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from linkwright.stages.validate.rewritten.facts import Place, Unparsable, Value

MOST = 1_000_000
"""Values of a file: aliases of YAML make many of few bytes."""

KINDS = ("Class", "Name")
"""Keys by which RViz tells the members of a list."""


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """Takes 1e-1 for a number, as YAML 1.2 and ROS do."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def yaml_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    try:
        # The loader makes texts, numbers, lists and mappings of what it reads, and runs nothing.
        tree = yaml.load(data, _Loader)
    except (yaml.YAMLError, ValueError) as error:
        raise Unparsable(f"is not YAML: {' '.join(str(error).split())}") from None
    yield from _facts(tree)


def toml_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    try:
        tree = tomllib.loads(data.decode())
    except ValueError as error:
        raise Unparsable(f"is not TOML: {error}") from None
    yield from _facts(tree)


def json_facts(data: bytes) -> Iterator[tuple[Place, Value]]:
    try:
        tree = json.loads(data)
    except ValueError as error:
        raise Unparsable(f"is not JSON: {error}") from None
    yield from _facts(_reals(tree))


def _reals(tree: Any) -> Any:
    """JSON has one kind of number."""
    if isinstance(tree, Mapping):
        return {key: _reals(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [_reals(value) for value in tree]
    return float(tree) if isinstance(tree, int) and not isinstance(tree, bool) else tree


def _facts(tree: Any) -> Iterator[tuple[Place, Value]]:
    for number, (path, value) in enumerate(_values(tree, ())):
        if number == MOST:
            raise Unparsable(f"has more than {MOST} values")
        first, *inner = path or ("",)
        yield Place(path, first, " ".join(inner)), value


def _values(tree: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Value]]:
    if isinstance(tree, Mapping):
        if not tree:
            yield path, "{}"
        for key, value in tree.items():
            yield from _values(value, (*path, str(key)))
    elif isinstance(tree, list) and any(isinstance(entry, list | Mapping) for entry in tree):
        seen: Counter[str] = Counter()
        for number, value in enumerate(tree):
            key = _key(value, number)
            seen[key] += 1
            yield from _values(value, (*path, f"[{key}]" if seen[key] == 1 else f"[{key} {seen[key]}]"))
    elif isinstance(tree, list):
        yield path, tuple(map(_scalar, tree))
    else:
        yield path, _scalar(tree)


def _key(member: Any, number: int) -> str:
    if isinstance(member, Mapping):
        for key in KINDS:
            if isinstance(member.get(key), str):
                return str(member[key])
    return str(number)


def _scalar(value: Any) -> Value:
    # A date of YAML or TOML is a text here.
    return value if value is None or isinstance(value, str | bool | int | float) else str(value)
