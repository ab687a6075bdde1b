"""The key `optional` of a configuration: globs that may match nothing."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from linkwright.pipeline.errors import Diagnostic
from linkwright.stages.robot.optional_section import GLOB_KEYS, all_globs, globs_of
from linkwright.stages.robot.text.globs import did_you_mean, there_are

KEY = "optional"


def add_optional(tree: dict[str, Any], shared: Iterable[Mapping[str, Any]]) -> None:
    """Adds the globs of `shared` files, those of several robots, to the key `optional` of a resolved tree,
    where the tree still has them."""
    there, given = all_globs(tree), tree.get(KEY, {})
    for key, globs in ((key, globs) for file in shared for key, globs in all_globs(file).items()):
        if isinstance(given, dict) and isinstance(given.get(key, []), list):
            added = [glob for glob in globs if glob in there.get(key, ()) and glob != "*"]
            given[key] = list(dict.fromkeys([*given.get(key, ()), *added]))
    if given:
        tree[KEY] = {key: globs for key, globs in given.items() if globs}


def without_effect(tree: Mapping[str, Any]) -> Iterator[Diagnostic]:
    """E-VALUE for what the key names that no glob of the configuration is."""
    given = tree.get(KEY)
    for key, globs in given.items() if isinstance(given, Mapping) else ():
        if key not in GLOB_KEYS:
            hint = f"{did_you_mean(str(key), GLOB_KEYS)} allowed: {', '.join(GLOB_KEYS)}".lstrip()
            yield Diagnostic("E-VALUE", f"{key} holds no globs", KEY, hint)
            continue
        there = list(globs_of(tree, key))
        for glob in globs if isinstance(globs, list | tuple) else ():
            if glob not in there:
                hint = there_are(str(glob), {"its globs": there})
                yield Diagnostic(
                    "E-VALUE", f"{key} has no glob {glob!r} that could be optional", f"{KEY}.{key}", hint
                )
