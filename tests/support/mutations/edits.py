"""Edits of elements and their numbers, which several faults make."""

import random
from collections.abc import Sequence

from tests.support.mutations.kind import Element, NothingToChange


def pick(found: Sequence[Element], rng: random.Random) -> Element:
    if not found:
        raise NothingToChange
    return rng.choice(list(found))


def numbers(node: Element, key: str) -> list[float]:
    return [float(one) for one in node.get(key).split()]


def put(node: Element, key: str, values: Sequence[float]) -> None:
    node.set(key, " ".join(f"{one:.15g}" for one in values))


def moved(node: Element, key: str, rng: random.Random, distance: float) -> None:
    """Moves a vector by `distance` along one axis."""
    values = numbers(node, key) if node.get(key) else [0.0, 0.0, 0.0]
    values[rng.randrange(3)] += rng.choice((-1, 1)) * distance
    put(node, key, values)


def sign_of(values: Sequence[float]) -> list[float]:
    return [-one for one in values]


def named(tag: str, node: Element) -> str:
    return f'{tag} "{node.get("name")}"'
