"""Composed trees as plain data."""

from collections.abc import Iterable
from typing import Any

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from pipeline.errors import Diagnostic
from pipeline.problems import how_to_give
from pipeline.schema import Place, key_of


def as_written(node: DictConfig) -> dict[str, Any]:
    """The node as plain data, interpolations as they are."""
    tree: Any = OmegaConf.to_container(node, resolve=False)
    return dict(tree)


def at(config: DictConfig, place: Place, problems: list[Diagnostic]) -> Any:
    """What stands at a place, as plain data, interpolations resolved; None, and a problem, where that
    cannot be."""
    node: Any = config
    try:
        for name in place:
            node = node[name]
    except OmegaConfBaseException as error:
        text = f"cannot be resolved: {str(error).splitlines()[0]}"
        problems.append(Diagnostic("E-VALUE", text, key_of(place)))
        return None
    return plain(node, place, problems)


def plain(node: Any, place: Place, problems: list[Diagnostic], computed: set[Place] | None = None) -> Any:
    """The node as plain data, interpolations resolved; what is missing or cannot be resolved is a
    problem, and left out. The places of the interpolations go into `computed`."""
    if isinstance(node, ListConfig):
        pairs: Iterable[tuple[Any, Any]] = enumerate(range(len(node)))
    elif isinstance(node, DictConfig):
        pairs = ((name, name) for name in list(node))
    else:
        return node
    found: dict[Any, Any] = {}
    for name, index in pairs:
        if name == "hydra" and not place:
            continue
        inner = (*place, name)
        try:
            if OmegaConf.is_missing(node, index):
                text = "must be given"
                problems.append(Diagnostic("E-MISSING", text, key_of(inner), how_to_give(key_of(inner))))
                continue
            value = node[index]
            if computed is not None and OmegaConf.is_interpolation(node, index):
                computed.add(inner)
        except OmegaConfBaseException as error:
            text = f"cannot be resolved: {str(error).splitlines()[0]}"
            problems.append(Diagnostic("E-VALUE", text, key_of(inner)))
            continue
        found[name] = plain(value, inner, problems, computed)
    return list(found.values()) if isinstance(node, ListConfig) else found
