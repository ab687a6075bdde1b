"""Adds to the key `optional` of a configuration: globs that may match nothing."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from linkwright.pipeline.errors import Diagnostic
from linkwright.stages.robot.optional_section import GLOB_KEYS, all_globs, globs_of
from linkwright.stages.robot.text.globs import did_you_mean, no_match_hint

OPTIONAL_KEY = "optional"


def add_optional(tree: dict[str, Any], shared: Iterable[Mapping[str, Any]]) -> None:
    """Adds the globs of `shared` files to the key `optional` of a resolved tree, if the tree still has them:
    a file that several robots share may have globs that match nothing in one of them."""
    globs_by_key, section = all_globs(tree), tree.get(OPTIONAL_KEY, {})
    for key, globs in (item for file in shared for item in all_globs(file).items()):
        if isinstance(section, dict) and isinstance(section.get(key, []), list):
            added = [glob for glob in globs if glob in globs_by_key.get(key, ()) and glob != "*"]
            section[key] = list(dict.fromkeys([*section.get(key, ()), *added]))
    if section:
        tree[OPTIONAL_KEY] = {key: globs for key, globs in section.items() if globs}


def idle_entries(tree: Mapping[str, Any]) -> Iterator[Diagnostic]:
    """Yields an E-VALUE for each entry of `optional` that is not a glob in the configuration."""
    section = tree.get(OPTIONAL_KEY)
    for key, globs in section.items() if isinstance(section, Mapping) else ():
        if key not in GLOB_KEYS:
            hint = f"{did_you_mean(str(key), GLOB_KEYS)} allowed: {', '.join(GLOB_KEYS)}".lstrip()
            yield Diagnostic("E-VALUE", f"{key} holds no globs", OPTIONAL_KEY, hint)
            continue
        tree_globs = list(globs_of(tree, key))
        for glob in globs if isinstance(globs, list | tuple) else ():
            if glob not in tree_globs:
                hint = no_match_hint(str(glob), {"its globs": tree_globs})
                yield Diagnostic(
                    "E-VALUE",
                    f"{key} has no glob {glob!r} that could be optional",
                    f"{OPTIONAL_KEY}.{key}",
                    hint,
                )
