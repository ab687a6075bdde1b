"""Converts composed trees to plain data."""

from collections.abc import Iterable, Iterator
from typing import Any

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from linkwright.pipeline.config.files.yaml_file import MAX_DEPTH, MAX_VALUES
from linkwright.pipeline.config.hydra.words import INTERPOLATION_RULES, Words, translate
from linkwright.pipeline.config.messages import how_to_give
from linkwright.pipeline.errors import Diagnostic
from linkwright.pipeline.key_path import Place, key_of


def as_written(node: DictConfig) -> dict[str, Any]:
    """Converts a node to plain data, with unresolved interpolations."""
    tree: Any = OmegaConf.to_container(node, resolve=False)
    return dict(tree)


def value_at(config: DictConfig, place: Place, problems: list[Diagnostic]) -> Any:
    """Returns the value at a place, as plain data with resolved interpolations. If that fails, adds a problem
    and returns None."""
    node: Any = config
    try:
        for name in place:
            node = node[name]
    except OmegaConfBaseException as error:
        problems.append(_unresolved(error, place))
        return None
    return plain(node, place, problems)


def plain(
    node: Any,
    place: Place,
    problems: list[Diagnostic],
    interpolated_places: set[Place] | None = None,
    value_slots: Iterator[int] | None = None,
) -> Any:
    """Converts a node to plain data, with resolved interpolations.

    A value that is missing or cannot be resolved is left out, and becomes a problem. So do values above the
    limit: interpolations repeat the values that they name. `interpolated_places` receives the places of
    interpolations; `value_slots` has an item for each value that may follow.
    """
    value_slots = iter(range(MAX_VALUES)) if value_slots is None else value_slots
    if isinstance(node, ListConfig):
        pairs: Iterable[tuple[Any, Any]] = enumerate(range(len(node)))
    elif isinstance(node, DictConfig):
        pairs = ((name, name) for name in list(node))
    else:
        return node
    content: dict[Any, Any] = {}
    for name, index in pairs:
        if name == "hydra" and not place:
            continue
        inner = (*place, name)
        if next(value_slots, None) is None or len(inner) > MAX_DEPTH:
            text = f"it holds more than {MAX_VALUES} values, or is nested deeper than {MAX_DEPTH} levels"
            if not any(problem.message == text for problem in problems):
                hint = "check its interpolations: ${...}"
                problems.append(Diagnostic("E-VALUE", text, key_of(place), hint))
            break
        try:
            if OmegaConf.is_missing(node, index):
                text = "must be given"
                problems.append(Diagnostic("E-MISSING", text, key_of(inner), how_to_give(key_of(inner))))
                continue
            value = node[index]
            if interpolated_places is not None and OmegaConf.is_interpolation(node, index):
                interpolated_places.add(inner)
        except OmegaConfBaseException as error:
            problems.append(_unresolved(error, inner))
            continue
        content[name] = plain(value, inner, problems, interpolated_places, value_slots)
    return list(content.values()) if isinstance(node, ListConfig) else content


def _unresolved(error: Exception, place: Place) -> Diagnostic:
    """Returns the problem of an interpolation."""
    unknown = Words(f"cannot be resolved: {str(error).splitlines()[0]}", hint="correct its ${...}")
    words = translate(str(error), INTERPOLATION_RULES) or unknown
    return Diagnostic("E-VALUE", words.text, key_of(place), words.hint)
